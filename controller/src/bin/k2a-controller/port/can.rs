//! A CAN interface of Linux (SocketCAN).

#[cfg(target_os = "linux")]
pub(crate) use linux::CanPort;
#[cfg(not(target_os = "linux"))]
pub(crate) use missing::CanPort;

#[cfg(target_os = "linux")]
mod linux {
    use crate::port::{Ears, Heard, Medium, PortError};
    use controller::Port;
    use rustix::io::Errno;
    use rustix::net::{AddressFamily, Protocol, SocketType};
    use socketcan::EmbeddedFrame;
    use socketcan::tokio::CanSocket;
    use std::io;
    use std::num::NonZeroU32;
    use tokio::sync::mpsc;
    use wire::can::CanFrame;

    /// `CAN_RAW` of `linux/can.h`.
    const CAN_RAW: NonZeroU32 = NonZeroU32::MIN;
    /// `IFF_UP` of `linux/if.h`.
    const INTERFACE_UP: u32 = 1;

    /// The CAN bus of the base.
    #[derive(Debug)]
    pub(crate) struct CanPort {
        interface: String,
    }

    impl CanPort {
        /// The interface of that name, such as `can0`.
        pub(crate) const fn new(interface: String) -> Self {
            Self { interface }
        }

        fn error(&self, cause: &io::Error, advice: String) -> PortError {
            let (name, cause) = (self.interface.clone(), cause.to_string());
            PortError { port: Port::Base, name, cause, advice }
        }

        /// `None` where the system does not tell.
        fn is_up(&self) -> Option<bool> {
            let path = format!("/sys/class/net/{}/flags", self.interface);
            let text = std::fs::read_to_string(path).ok()?;
            let flags = u32::from_str_radix(text.trim().trim_start_matches("0x"), 16).ok()?;
            Some(flags & INTERFACE_UP != 0)
        }
    }

    impl Medium for CanPort {
        type Link = CanSocket;
        type Unit = CanFrame;

        fn port(&self) -> Port {
            Port::Base
        }

        fn name(&self) -> &str {
            &self.interface
        }

        fn open(&self) -> Result<CanSocket, PortError> {
            let interface = &self.interface;
            // Asked first, since the library reports a kernel without CAN as a missing interface.
            if let Err(cause) = kernel_has_can() {
                return Err(self.error(
                    &cause,
                    "this kernel has no CAN sockets; `sudo modprobe can_raw`, or use another kernel"
                        .to_owned(),
                ));
            }
            if self.is_up() == Some(false) {
                return Err(self.error(
                    &Errno::NETDOWN.into(),
                    format!("start it: `sudo ip link set {interface} up type can bitrate 500000`"),
                ));
            }
            CanSocket::open(interface).map_err(|cause| {
                self.error(
                    &cause,
                    format!(
                        "check the spelling (`ip -brief link` lists interfaces); a virtual one is \
                         made by `sudo ip link add dev {interface} type vcan`"
                    ),
                )
            })
        }

        fn greeting(&self) -> Option<CanFrame> {
            None
        }

        async fn converse(
            &self,
            link: CanSocket,
            ears: &Ears,
            outgoing: &mut mpsc::Receiver<CanFrame>,
        ) -> io::Error {
            let listen = async {
                loop {
                    match link.read_frame().await {
                        Ok(frame) => {
                            if let Some(frame) = from_socket(&frame) {
                                ears.hear(Heard::Frame(frame)).await;
                            }
                        }
                        Err(cause) => return cause,
                    }
                }
            };
            let speak = async {
                while let Some(frame) = outgoing.recv().await {
                    let Some(frame) = to_socket(&frame) else {
                        continue;
                    };
                    match link.write_frame(frame).await {
                        Ok(()) => {}
                        // The bus does not take frames as fast as they come; a later one may pass.
                        Err(cause) if Errno::from_io_error(&cause) == Some(Errno::NOBUFS) => {
                            ears.drop_unit("the transmit queue of the interface is full");
                        }
                        Err(cause) => {
                            ears.drop_unit("the port is gone");
                            return cause;
                        }
                    }
                }
                std::future::pending().await
            };
            tokio::select! {
                cause = listen => cause,
                cause = speak => cause,
            }
        }
    }

    fn kernel_has_can() -> io::Result<()> {
        let protocol = Protocol::from_raw(CAN_RAW);
        rustix::net::socket(AddressFamily::CAN, SocketType::RAW, Some(protocol))?;
        Ok(())
    }

    /// `None` for error frames: they are the interface's word, not the bus's.
    fn from_socket(frame: &socketcan::CanFrame) -> Option<CanFrame> {
        match frame {
            socketcan::CanFrame::Data(frame) => CanFrame::new(frame.id(), frame.data()),
            socketcan::CanFrame::Remote(frame) => {
                <CanFrame as EmbeddedFrame>::new_remote(frame.id(), frame.dlc())
            }
            socketcan::CanFrame::Error(_) => None,
        }
    }

    fn to_socket(frame: &CanFrame) -> Option<socketcan::CanFrame> {
        if frame.is_remote() {
            socketcan::CanFrame::new_remote(frame.id(), frame.dlc())
        } else {
            socketcan::CanFrame::new(frame.id(), frame.data())
        }
    }

    #[cfg(test)]
    mod tests {
        use super::{CanFrame, CanPort, from_socket, kernel_has_can, to_socket};
        use crate::port::Medium as _;
        use wire::can::{ExtendedId, Id, StandardId};

        #[test]
        fn frames_cross_unchanged() {
            let ids: [Id; 2] = [
                StandardId::new(0x101).unwrap().into(),
                ExtendedId::new(0x1234_5678).unwrap().into(),
            ];
            for id in ids {
                for data in [&b""[..], b"abc", b"12345678"] {
                    let frame = CanFrame::new(id, data).unwrap();
                    assert_eq!(from_socket(&to_socket(&frame).unwrap()), Some(frame));
                }
            }
        }

        #[test]
        fn a_missing_interface_is_told_from_a_kernel_without_can() {
            let text = CanPort::new("nocan7".to_owned()).open().unwrap_err().to_string();
            assert!(text.starts_with("cannot open base port nocan7: "), "{text}");
            let expected =
                if kernel_has_can().is_ok() { "check the spelling" } else { "has no CAN sockets" };
            assert!(text.contains(expected), "{text}");
        }
    }
}

#[cfg(not(target_os = "linux"))]
mod missing {
    use crate::port::{Ears, Medium, PortError};
    use controller::Port;
    use std::convert::Infallible;
    use std::io;
    use tokio::sync::mpsc;
    use wire::can::CanFrame;

    /// CAN sockets are Linux's.
    #[derive(Debug)]
    pub(crate) struct CanPort {
        interface: String,
    }

    impl CanPort {
        /// The interface of that name.
        pub(crate) const fn new(interface: String) -> Self {
            Self { interface }
        }
    }

    impl Medium for CanPort {
        type Link = Infallible;
        type Unit = CanFrame;

        fn port(&self) -> Port {
            Port::Base
        }

        fn name(&self) -> &str {
            &self.interface
        }

        fn open(&self) -> Result<Infallible, PortError> {
            Err(PortError {
                port: Port::Base,
                name: self.interface.clone(),
                cause: "this system has no CAN sockets".to_owned(),
                advice: "use Linux, or a base on a serial port".to_owned(),
            })
        }

        fn greeting(&self) -> Option<CanFrame> {
            None
        }

        async fn converse(
            &self,
            link: Infallible,
            _: &Ears,
            _: &mut mpsc::Receiver<CanFrame>,
        ) -> io::Error {
            match link {}
        }
    }
}
