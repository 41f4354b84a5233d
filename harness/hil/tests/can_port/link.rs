//! Interfaces that a test creates.

use ports::can_socket::kernel_has_can;
use std::io;
use std::process::Stdio;
use tokio::process::Command;

/// A virtual CAN interface; deleted when this is dropped.
pub struct Link(pub &'static str);

impl Link {
    /// Creates an interface of this name and sets it up. Returns `None`, and prints the reason, if the machine does not
    /// allow it.
    pub async fn make(name: &'static str) -> Option<Self> {
        if let Err(cause) = kernel_has_can() {
            return skip(&format!("this kernel has no CAN sockets: {cause}"));
        }
        let link = Self(name);
        // An interface left by a killed test.
        ip(&["link", "del", name]).await.ok();
        match link.add().await {
            Ok(()) => Some(link),
            Err(cause) => skip(&format!("no right to make an interface: {cause}")),
        }
    }

    /// Creates the interface and sets it up.
    pub async fn add(&self) -> Result<(), String> {
        ip(&["link", "add", "dev", self.0, "type", "vcan"]).await?;
        self.set("up").await
    }

    /// Sets it `up` or `down`.
    pub async fn set(&self, state: &str) -> Result<(), String> {
        ip(&["link", "set", self.0, state]).await
    }

    pub async fn delete(&self) -> Result<(), String> {
        ip(&["link", "del", self.0]).await
    }
}

impl Drop for Link {
    fn drop(&mut self) {
        for program in [&["ip"][..], &["busybox", "ip"]] {
            let mut command = std::process::Command::new(program[0]);
            command.args(&program[1..]).args(["link", "del", self.0]).stderr(Stdio::null());
            if command.status().is_ok() {
                return;
            }
        }
    }
}

/// Runs `ip` with these arguments; returns its message if it failed.
pub async fn ip(arguments: &[&str]) -> Result<(), String> {
    let output = match Command::new("ip").args(arguments).output().await {
        // For a machine without iproute2; the guest always has busybox.
        Err(cause) if cause.kind() == io::ErrorKind::NotFound => {
            Command::new("busybox").arg("ip").args(arguments).output().await
        }
        result => result,
    };
    let output = output.map_err(|cause| cause.to_string())?;
    if output.status.success() {
        return Ok(());
    }
    Err(String::from_utf8_lossy(&output.stderr).trim().to_owned())
}

fn skip<T>(why: &str) -> Option<T> {
    skips::skip_unless(skips::CAN_REQUIRED, why, skips::in_guest("--test can_port"));
    None
}
