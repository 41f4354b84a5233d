//! The device files that ship with the project, and the behaviour of their devices.

use emulators::base::Transport;
use emulators::device_file::{
    BaseModel, DeviceFile, DeviceFileError, Devices, GyroModel, Learned, ModelSource, Mount,
    TableModel,
};
use emulators::gyro::{GyroEmulator, INSTABILITY_LONGEST_S, INSTABILITY_SHORTEST_S};
use emulators::parameters::Parameters as _;
use emulators::table::TableEmulator;
use serde::de::DeserializeOwned;
use std::path::{Path, PathBuf};
use wire::gyro::{GyroDecoder, GyroOutput, OutputMode};
use wire::packet::Packet;
use wire::table::Command;
use wire::time::Timestamp;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../test-plans/devices")
}

fn read<T: DeserializeOwned>(path: &str) -> Result<T, toml::de::Error> {
    let text = std::fs::read_to_string(folder().join(path)).expect("the file is there");
    toml::from_str(&text)
}

struct Folder;

impl ModelSource for Folder {
    type Error = toml::de::Error;

    fn gyro(&mut self, name: &str) -> Result<GyroModel, Self::Error> {
        read(&format!("gyros/{name}.toml"))
    }

    fn base(&mut self, name: &str) -> Result<BaseModel, Self::Error> {
        read(&format!("bases/{name}.toml"))
    }

    fn table(&mut self, name: &str) -> Result<TableModel, Self::Error> {
        read(&format!("tables/{name}.toml"))
    }

    fn learned(&mut self, _: &str) -> Result<Learned, Self::Error> {
        toml::from_str("").map(|()| Learned::default())
    }
}

fn devices(file: &str) -> Devices {
    read::<DeviceFile>(file)
        .expect("the file is a device file")
        .resolve(&mut Folder)
        .expect("its models are there")
}

#[test]
fn every_file_describes_devices() {
    let mut files: Vec<String> = std::fs::read_dir(folder())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| name.ends_with(".toml"))
        .collect();
    files.sort();
    assert_eq!(
        files,
        [
            "asymmetric-table.toml",
            "biased-table.toml",
            "dsp3000-table.toml",
            "paper-anew.toml",
            "paper-correlated.toml",
            "paper-mounted.toml",
            "paper-noisier.toml",
            "paper-serial.toml",
            "paper-table.toml",
            "paper.toml",
            "undeclared-table.toml"
        ]
    );
    for file in &files {
        let devices = devices(file);
        assert_eq!(devices.base.is_some(), devices.mount == Mount::Base, "{file}");
        assert_eq!(devices.table.is_some(), devices.mount == Mount::Table, "{file}");
    }
}

#[test]
fn the_papers_files_differ_in_what_they_say_and_share_the_rest() {
    let (can, serial) = (devices("paper.toml"), devices("paper-serial.toml"));
    let (can_base, serial_base) = (can.base.unwrap(), serial.base.unwrap());
    assert_eq!((can_base.0, serial_base.0), (Transport::Can, Transport::Serial));
    assert_eq!(can_base.1, serial_base.1);
    assert_eq!((&can.gyro, &can.absolute), (&serial.gyro, &serial.absolute));
    assert_eq!(can.gyro, devices("paper-table.toml").gyro);
    let gyro = &can.gyro.1;
    assert_eq!((gyro.bias_instability_rms_deg_per_s, gyro.bias_drift_deg_per_s), (0.005, 0.0));
    let band = [gyro.bias_instability_shortest_s, gyro.bias_instability_longest_s];
    assert_eq!(band, [INSTABILITY_SHORTEST_S, INSTABILITY_LONGEST_S]);
    assert_eq!(devices("dsp3000-table.toml").gyro.0.mode, OutputMode::Increment);
}

/// The plan with one effect after another uses the values of the file with all of them.
#[test]
fn the_plan_of_single_effects_has_the_sizes_of_the_mounted_robot() {
    let plan: toml::Table = read("../table-to-robot.toml").unwrap();
    let step = |step: &toml::Value| {
        let set = step.get("set_parameter")?;
        Some((set["parameter"].as_str()?.to_owned(), set["value"].clone()))
    };
    let number = |value: &toml::Value| {
        value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64)).unwrap()
    };
    let mut set: Vec<(String, f64)> = plan["steps"]
        .as_array()
        .unwrap()
        .iter()
        .filter_map(step)
        .map(|(name, value)| (name, number(&value)))
        .filter(|(_, value)| *value != 0.0)
        .collect();
    set.sort_by(|a, b| a.partial_cmp(b).unwrap());
    set.dedup();
    let file: DeviceFile = read("paper-mounted.toml").unwrap();
    let of = |device: &'static str, parameters: std::collections::BTreeMap<String, f64>| {
        parameters.into_iter().map(move |(name, value)| (format!("{device}.{name}"), value))
    };
    let mut added: Vec<_> = of("gyro", file.gyro.parameters).collect();
    added.extend(of("base", file.base.unwrap().parameters));
    added.sort_by(|a, b| a.partial_cmp(b).unwrap());
    assert_eq!(set, added);
}

/// Angle from the gyro's bytes over one turn of the table, in degrees.
fn turn_by_bytes(devices: &Devices, steps: i32) -> f64 {
    let (stream, parameters) = devices.gyro.clone();
    let nominal_s = stream.format.period().as_secs_f64();
    let mut gyro = GyroEmulator::new(parameters, stream, 1, "gyro");
    let mut decoder = GyroDecoder::new(stream);
    let mut table = TableEmulator::new(devices.table.clone().expect("the gyro is on a table"));
    table.command(Timestamp::ZERO, Command::Distance(steps));
    table.command(Timestamp::ZERO, Command::Go);
    let mut deg = 0.0;
    while gyro.next_wakeup() < Timestamp::from_secs_f64(16.0) {
        let now = gyro.next_wakeup();
        let mut packet = Packet::new();
        if gyro.wake(now, table.angle_at(now), &mut packet) {
            decoder.feed(packet.as_slice(), |sample| match sample.output {
                GyroOutput::Rate(rate) => deg += rate.deg_per_s() * nominal_s,
                GyroOutput::Increment(angle) => deg += angle.deg(),
                GyroOutput::Integrated(_) => panic!("not asked for"),
            });
        }
    }
    deg
}

/// Eq. 5 from the data file, through table, gyro, bytes and decoder, without noise and bias.
#[test]
fn the_papers_table_run_gives_equation_5_through_the_bytes() {
    for celsius in [22.0, 30.0, 36.98, 42.0] {
        let mut file: DeviceFile = read("paper-table.toml").unwrap();
        for (name, value) in [
            ("angle_random_walk_deg_per_sqrt_h", 0.0),
            ("bias_instability_rms_deg_per_s", 0.0),
            ("bias_deg_per_h_per_kelvin", 0.0),
            ("self_heating_kelvin", 0.0),
            ("ambient_celsius", celsius),
        ] {
            file.gyro.parameters.insert(name.to_owned(), value);
        }
        let devices = file.resolve(&mut Folder).unwrap();
        for steps in [-28_800, 28_800] {
            let error = turn_by_bytes(&devices, steps).abs() - 360.0;
            let equation_5 = -0.52 * celsius + 19.23;
            // Half a step of the rate, 0.0015 deg/s, for the 14 s of the turn, plus 0.01 deg of play.
            assert!((error - equation_5).abs() < 0.021 + 0.01, "{celsius}: {error} {equation_5}");
        }
    }
}

#[test]
fn increments_of_a_fast_clock_add_up() {
    let mut file: DeviceFile = read("dsp3000-table.toml").unwrap();
    for name in ["turn_on_bias_deg_per_h", "bias_deg_per_h_per_kelvin", "scale_ppm"] {
        file.gyro.parameters.insert(name.to_owned(), 0.0);
    }
    let increments = turn_by_bytes(&file.resolve(&mut Folder).unwrap(), 28_800);
    assert!((increments - 360.0).abs() < 0.05, "{increments}");
    file.gyro.mode = Some(OutputMode::Rate);
    let rates = turn_by_bytes(&file.resolve(&mut Folder).unwrap(), 28_800);
    assert!((rates - 360.0 * 1.02).abs() < 0.05, "{rates}");
}

#[test]
fn a_device_file_spells_out_terms_and_plans_may_change_them() {
    let head =
        "title = 'x'\nmount = 'table'\n[gyro]\nmodel = 'navigator'\n[table]\nmodel = 'stepper'\n";
    let with = |term: &str| {
        let file: DeviceFile = toml::from_str(&format!("{head}[[gyro.terms]]\n{term}\n"))?;
        Ok::<_, toml::de::Error>(file.resolve(&mut Folder).map(|devices| devices.gyro.1))
    };
    let good = "acts = 'bias'\ndriver = { temperature_lag = { time_constant_s = 60 } }\n\
                form = { linear = { slope = 1e-6, origin = 25 } }";
    let mut parameters = with(good).unwrap().unwrap();
    parameters.set("terms.0.slope", 2e-6).unwrap();
    parameters.set("terms.0.time_constant_s", 120.0).unwrap();
    assert!(parameters.set("terms.0.period", 1.0).is_err());
    assert!(parameters.set("terms.0.time_constant_s", 0.0).is_err());
    let bad = "acts = 'bias'\ndriver = 'time'\n\
               form = { table = { points = [{ x = 1, value = 0 }, { x = 1, value = 2 }] } }";
    assert!(with(bad).unwrap().is_err(), "a table that does not rise");
    assert!(with("acts = 'bias'\nform = { cosine = { value = 1 } }").is_err());
}

#[test]
fn what_is_wrong_is_named() {
    let file = |text: &str| toml::from_str::<DeviceFile>(text);
    let head = "title = 'x'\nmount = 'table'\n[gyro]\nmodel = 'navigator'\n";
    let no_table = file(head).unwrap().resolve(&mut Folder).unwrap_err();
    assert_eq!(no_table, DeviceFileError::NoCarrier(Mount::Table));
    let text = format!("{head}parameters = {{ ambient = 3 }}\n[table]\nmodel = 'stepper'\n");
    let wrong = file(&text).unwrap().resolve(&mut Folder).unwrap_err();
    assert_eq!(
        wrong.to_string(),
        "[gyro]: no parameter `ambient`, did you mean `ambient_celsius`?"
    );
    let text = format!("{head}parameters = {{ bandwidth_hz = 0 }}\n[table]\nmodel = 'stepper'\n");
    assert!(file(&text).unwrap().resolve(&mut Folder).is_err());
    assert!(file(&format!("{head}noise = 3\n")).is_err());
}
