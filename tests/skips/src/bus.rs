//! The kernel's CAN bus, which tests share.

use crate::skip_unless;
use std::fs::File;
use std::path::Path;

/// If set, a test that cannot run fails, as when a kernel with CAN was started for it.
pub const CAN_REQUIRED: &str = "HIL_TESTS_NEED_CAN";

/// Exclusive use of `vcan0` by one test: frames of others would reach it too.
#[derive(Debug)]
pub struct Vcan0 {
    /// A file lock, so that a test in another process waits too.
    _lock: File,
}

impl Vcan0 {
    /// The name of the interface.
    pub const NAME: &'static str = "vcan0";

    /// Waits until no other test uses it. Returns `None`, and prints the reason, if it does not exist or is not up;
    /// `tests` are the arguments of `cargo test` that select the tests which need it.
    ///
    /// # Panics
    ///
    /// When it does not exist and [`CAN_REQUIRED`] is set, or when no temporary file can be created.
    #[track_caller]
    pub fn take(tests: &str) -> Option<Self> {
        if !is_up() {
            skip_unless(CAN_REQUIRED, "there is no vcan0 that is up", how(tests));
            return None;
        }
        let file = File::create(std::env::temp_dir().join("hil-tests-vcan0.lock"));
        let lock = file.expect("temporary files can be made");
        lock.lock().expect("a file of one's own can be locked");
        Some(Self { _lock: lock })
    }
}

/// Explains how to run tests under a kernel with CAN; `tests` as for `cargo test`.
pub fn how(tests: &str) -> String {
    format!(
        "with the Debian packages user-mode-linux, busybox-static and can-utils: \
         CARGO_TARGET_X86_64_UNKNOWN_LINUX_GNU_RUNNER=\"$PWD/tests/vcan-guest/run --\" cargo test {tests}"
    )
}

/// Reads the flags of the kernel's interface, whose last bit is `IFF_UP`.
fn is_up() -> bool {
    let flags = Path::new("/sys/class/net").join(Vcan0::NAME).join("flags");
    let flags = std::fs::read_to_string(flags).unwrap_or_default();
    let flags = flags.trim().strip_prefix("0x").map(|hex| u32::from_str_radix(hex, 16));
    matches!(flags, Some(Ok(flags)) if flags & 1 == 1)
}
