//! Names of ports, parsed and printed.

use super::{
    BAUD, DATA_BITS, Flow, PortSpec, SerialDevice, SerialOptions, SerialSpec, Sharing, UsbId,
};
use miette::{GraphicalReportHandler, GraphicalTheme};
use proptest::prelude::*;
use wire::serial::{Parity, SerialSettings};
use wire::slcan::BitRate;

fn read(text: &str) -> PortSpec {
    text.parse().unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn each_kind_comes_back_as_it_was_written() {
    for text in [
        "pty",
        "pty:./gyro.pty",
        "serial:/dev/ttyUSB0",
        "serial:/dev/serial/by-path/pci-0:1.0-port0",
        "serial:usb:0403:6001",
        "serial:usb:0403:6001:A50285BI",
        "serial:/dev/ttyS0?baud=19200&data=7&parity=even&stop=2&flow=hardware&exclusive=no",
        "can:vcan0",
        "slcan:/dev/ttyACM0?baud=115200&bitrate=500000",
        "slcan:usb:16d0:117e",
        "slcan-pty",
        "slcan-pty:/tmp/can.pty",
    ] {
        assert_eq!(read(text).to_string(), text);
    }
    assert_eq!(read("/dev/ttyUSB0?stop=2"), read("serial:/dev/ttyUSB0?stop=2"));
}

#[test]
fn what_is_not_said_is_as_usual() {
    let PortSpec::Serial(spec) = read("/dev/ttyS0?parity=even&data=7") else { panic!("serial") };
    let settings = spec.options.settings(SerialSettings::new_8n1(38_400));
    let expected =
        SerialSettings { baud: 38_400, data_bits: 7, parity: Parity::Even, stop_bits: 1 };
    assert_eq!(settings, expected);
}

#[test]
fn a_port_stands_in_a_file_as_its_string() {
    #[derive(serde::Deserialize)]
    struct Section {
        port: PortSpec,
    }
    let section: Section = toml::from_str("port = \"can:can0\"").unwrap();
    assert_eq!(section.port, PortSpec::Can { interface: "can0".to_owned() });
    let Err(error) = toml::from_str::<Section>("port = \"can:\"") else { panic!("no interface") };
    assert!(error.to_string().contains("is no name of an interface"), "{error}");
}

#[test]
fn mistakes_are_shown_in_place() {
    let theme = GraphicalTheme::unicode_nocolor();
    let handler = GraphicalReportHandler::new_themed(theme).with_width(100);
    let mut shown = String::new();
    for text in [
        "",
        "ttyUSB0",
        "usb:0403:6001",
        "pty:",
        "serial",
        "serial:ttyUSB0",
        "serial:usb:403:6001",
        "serial:usb:0403",
        "serial:usb:0403:60x1",
        "serial:usb:0403:6001:",
        "/dev/ttyUSB0?",
        "/dev/ttyUSB0?baud",
        "/dev/ttyUSB0?baud=",
        "/dev/ttyUSB0?baud=fast",
        "/dev/ttyUSB0?baud=+9600",
        "/dev/ttyUSB0?baud=9600&data=9",
        "/dev/ttyUSB0?parity=mark",
        "/dev/ttyUSB0?stop=3",
        "/dev/ttyUSB0?flow=rts",
        "/dev/ttyUSB0?exclusive=maybe",
        "/dev/ttyUSB0?speed=9600",
        "/dev/ttyUSB0?baud=9600&baud=9600",
        "serial:/dev/ttyUSB0?bitrate=500000",
        "can",
        "can:a-name-that-is-too-long",
        "can:can/0",
        "slcan:/dev/ttyACM0?bitrate=300000",
        "slcan-pty:",
    ] {
        let error = text.parse::<PortSpec>().expect_err(text);
        handler.render_report(&mut shown, &error).unwrap();
        shown.push('\n');
    }
    insta::assert_snapshot!(shown);
}

fn any_device() -> impl Strategy<Value = SerialDevice> {
    prop_oneof![
        "/[a-zA-Z0-9/:._-]{0,20}".prop_map(SerialDevice::Path),
        (any::<u16>(), any::<u16>(), prop::option::of("[A-Z0-9:]{1,10}")).prop_map(
            |(vendor, product, serial_number)| SerialDevice::Usb(UsbId {
                vendor,
                product,
                serial_number
            })
        ),
    ]
}

fn any_serial() -> impl Strategy<Value = SerialSpec> {
    let parity = prop::sample::select(vec![Parity::None, Parity::Odd, Parity::Even]);
    let flow = prop::sample::select(vec![Flow::None, Flow::Software, Flow::Hardware]);
    let sharing = prop::sample::select(vec![Sharing::Exclusive, Sharing::Shared]);
    let options = (
        prop::option::of(BAUD),
        prop::option::of(DATA_BITS),
        prop::option::of(parity),
        prop::option::of(1..=2u8),
        prop::option::of(flow),
        prop::option::of(sharing),
    );
    (any_device(), options).prop_map(|(device, options)| {
        let (baud, data_bits, parity, stop_bits, flow, sharing) = options;
        let options = SerialOptions { baud, data_bits, parity, stop_bits, flow, sharing };
        SerialSpec { device, options }
    })
}

fn any_spec() -> impl Strategy<Value = PortSpec> {
    let link = || prop::option::of("[a-z./?:&=-]{1,20}".prop_map(Into::into));
    prop_oneof![
        link().prop_map(|link| PortSpec::Pty { link }),
        link().prop_map(|link| PortSpec::SlcanPty { link }),
        any_serial().prop_map(PortSpec::Serial),
        "[a-z0-9?:-]{1,15}".prop_map(|interface| PortSpec::Can { interface }),
        (any_serial(), prop::option::of(prop::sample::select(BitRate::ALL.to_vec())))
            .prop_map(|(serial, bitrate)| PortSpec::Slcan { serial, bitrate }),
    ]
}

proptest! {
    #[test]
    fn what_is_written_is_read_as_the_same(spec in any_spec()) {
        prop_assert_eq!(spec.to_string().parse::<PortSpec>(), Ok(spec));
    }

    #[test]
    fn no_text_makes_it_panic(text in "(pty|serial|can|slcan|slcan-pty|/dev)?[:/?&=a-z0-9é\\PC]{0,40}") {
        match text.parse::<PortSpec>() {
            Ok(spec) => prop_assert_eq!(spec.to_string().parse::<PortSpec>(), Ok(spec)),
            Err(error) => {
                let handler = GraphicalReportHandler::new_themed(GraphicalTheme::ascii());
                handler.render_report(&mut String::new(), &error).unwrap();
            }
        }
    }
}
