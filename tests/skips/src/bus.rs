//! The CAN bus of the kernel that tests share.

use crate::skip_unless;
use std::fs::File;
use std::path::Path;

/// Set where a test that cannot run is to fail, as where a kernel with CAN was started for it.
pub const CAN_REQUIRED: &str = "HIL_TESTS_NEED_CAN";

/// `vcan0`, which is one test's alone as long as it has this: what others send would reach it too.
#[derive(Debug)]
pub struct Vcan0 {
    /// Locked: a test in another process waits for it too.
    _lock: File,
}

impl Vcan0 {
    /// The name of the interface.
    pub const NAME: &'static str = "vcan0";

    /// Waits until no other test has it. `None`, and said aloud, where it is not there or not up; `tests` says to
    /// `cargo test` which ones need it.
    ///
    /// # Panics
    ///
    /// Where it is not there and [`CAN_REQUIRED`] is set, or no file can be made where temporary ones are.
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

/// How to run tests under a kernel with CAN; `tests` as for `cargo test`.
pub fn how(tests: &str) -> String {
    format!(
        "with the Debian packages user-mode-linux, busybox-static and can-utils: \
         CARGO_TARGET_X86_64_UNKNOWN_LINUX_GNU_RUNNER=\"$PWD/tests/vcan-guest/run --\" cargo test {tests}"
    )
}

/// The flags of the kernel's interface, of which the last bit is `IFF_UP`.
fn is_up() -> bool {
    let flags = Path::new("/sys/class/net").join(Vcan0::NAME).join("flags");
    let flags = std::fs::read_to_string(flags).unwrap_or_default();
    let flags = flags.trim().strip_prefix("0x").map(|hex| u32::from_str_radix(hex, 16));
    matches!(flags, Some(Ok(flags)) if flags & 1 == 1)
}
