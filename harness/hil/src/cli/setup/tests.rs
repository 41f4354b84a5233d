//! Which clock, bus, controller and bench go together.

use super::{
    BenchFile, BusChoice, Clock, Controller, DeviceUnderTest, KernelBus, LiveSetting, PortSpec,
    Scheduling, Setup, SetupArguments,
};

fn setup(clock: Clock, bus: Option<BusChoice>, controller: Option<&str>) -> Result<Setup, String> {
    let controller = controller.map(|text| text.parse().unwrap());
    let arguments =
        SetupArguments { clock, bus, controller, bench: None, wait: 0, realtime: false };
    arguments.setup().map_err(|failure| failure.to_string())
}

#[test]
fn what_goes_together() {
    assert_eq!(setup(Clock::Virtual, None, None), Ok(Setup::Simulated));
    assert_eq!(
        setup(Clock::Virtual, Some(BusChoice::Memory), Some("in-process")),
        Ok(Setup::Simulated)
    );
    for (bus, kernel) in [
        (BusChoice::Pty, KernelBus::Pty),
        (BusChoice::Vcan, KernelBus::Vcan),
        (BusChoice::Slcan, KernelBus::Slcan),
    ] {
        assert_eq!(setup(Clock::Virtual, Some(bus), None), Ok(Setup::Kernel(kernel)));
    }
    let live = |device_under_test, can| {
        let (bench, scheduling) = (BenchFile::default(), Scheduling::Normal);
        let repetition = None;
        let setting = LiveSetting { device_under_test, bench, can, scheduling, repetition };
        Ok(Setup::Live(Box::new(setting)))
    };
    let adapter = PortSpec::SlcanPty { link: None };
    assert_eq!(setup(Clock::Real, None, None), live(DeviceUnderTest::OurProcess, adapter));
    let command = DeviceUnderTest::Command(vec!["./mine".to_owned(), "--fast".to_owned()]);
    assert_eq!(
        setup(Clock::Real, Some(BusChoice::Vcan), Some("./mine --fast")),
        live(command, PortSpec::Can { interface: "vcan0".to_owned() })
    );
}

#[test]
fn what_does_not_go_together_says_why() {
    let why = setup(Clock::Real, Some(BusChoice::Memory), None).unwrap_err();
    assert!(why.contains(" clock needs the "), "{why}");
    let plain = SetupArguments {
        clock: Clock::Virtual,
        bus: None,
        controller: None,
        bench: None,
        wait: 0,
        realtime: false,
    };
    let with_bench = SetupArguments { bench: Some("mine.toml".to_owned()), ..plain.clone() };
    let in_real_time = SetupArguments { realtime: true, ..plain };
    assert!(with_bench.setup().is_err() && in_real_time.setup().is_err());
}

#[cfg(feature = "nats")]
#[test]
fn over_a_server_the_bench_file_says_it_all() {
    let alone = SetupArguments {
        clock: Clock::Real,
        bus: None,
        controller: None,
        bench: Some("window.toml".to_owned()),
        wait: 0,
        realtime: false,
    };
    assert_eq!(alone.bench_elsewhere().ok(), Some("window.toml"));
    let others = [
        SetupArguments { bench: None, ..alone.clone() },
        SetupArguments { controller: Some(Controller::InProcess), ..alone.clone() },
        SetupArguments { bus: Some(BusChoice::Vcan), ..alone.clone() },
        SetupArguments { realtime: true, ..alone },
    ];
    let refused = others.map(|other| other.bench_elsewhere().unwrap_err().rendered(false));
    insta::assert_snapshot!(refused.concat());
}

#[test]
fn no_command_is_no_controller_and_quotes_are_refused() {
    assert!([" ", "sh -c 'exit 1'"].iter().all(|text| text.parse::<Controller>().is_err()));
}
