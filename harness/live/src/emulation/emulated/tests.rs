use super::super::request::{RequestError, read};
use super::super::{Parts, Setup, What};
use super::Emulated;
use emulators::base::{BaseParameters, Transport};
use emulators::device_file::Mount;
use emulators::gyro::GyroParameters;
use emulators::table::TableParameters;
use ports::PortSpec;
use rig::line::EndId;
use serde_json::Value;
use std::sync::Arc;
use wire::base::{Request as BaseRequest, can_link};
use wire::device::Transmit;
use wire::gyro::{GyroDecoder, GyroFormat, GyroOutput, GyroSample, GyroStream, OutputMode};
use wire::time::{Span, Timestamp};
use wire::units::{AngularRate, Speed};

const STREAM: GyroStream =
    GyroStream { format: GyroFormat::Navigator, mode: OutputMode::Rate, reversed: false };
const HOST: EndId = EndId(0);

fn gyro() -> Option<(GyroStream, GyroParameters)> {
    Some((STREAM, GyroParameters::default()))
}

fn base(transport: Transport) -> Option<(Transport, BaseParameters)> {
    Some((transport, BaseParameters::default()))
}

fn carried() -> Parts {
    let (base, mount) = (base(Transport::Can), Some(Mount::Base));
    Parts { gyro: gyro(), base, mount, ..Parts::default() }
}

/// Each device with a port: lines in the order gyro, base, table.
fn emulated(parts: Parts) -> Emulated {
    let there = [
        ("gyro", parts.gyro.is_some()),
        ("base", parts.base.is_some()),
        ("table", parts.table.is_some()),
    ];
    let ports = there.into_iter().filter(|(_, there)| *there);
    let ports = ports.map(|(name, _)| (name.to_owned(), PortSpec::Pty { link: None })).collect();
    Emulated::new(&Setup { what: What::Parts(Box::new(parts)), ports, control: None, seed: 1 }).0
}

fn alone() -> Emulated {
    emulated(Parts { gyro: gyro(), ..Parts::default() })
}

fn at(seconds: f64) -> Timestamp {
    Timestamp::ZERO + Span::from_secs_f64(seconds)
}

/// Advances to `now` and returns what devices have sent meanwhile, by line.
fn sent(emulated: &mut Emulated, now: Timestamp) -> Vec<(String, Transmit)> {
    let mut sent = Vec::new();
    while emulated.next_wakeup() <= now {
        emulated.wake(emulated.next_wakeup());
        sent.extend(outputs(emulated));
    }
    emulated.wake(now);
    sent
}

fn outputs(emulated: &mut Emulated) -> Vec<(String, Transmit)> {
    let mut outputs = Vec::new();
    while let Some((line, from, what)) = emulated.transmit() {
        if from != HOST {
            outputs.push((emulated.rig.line_names[line].to_string(), what));
        }
    }
    outputs
}

fn samples(outputs: &[(String, Transmit)]) -> Vec<GyroSample> {
    let mut decoder = GyroDecoder::new(STREAM);
    let mut samples = Vec::new();
    for (_, output) in outputs.iter().filter(|(line, _)| line == "gyro") {
        let Transmit::Bytes(bytes) = output else { panic!("a gyro sends bytes") };
        decoder.feed(bytes.as_slice(), |sample| samples.push(sample));
    }
    samples
}

fn mean_deg_per_s(samples: &[GyroSample]) -> f64 {
    let rates = samples.iter().map(|sample| match sample.output {
        GyroOutput::Rate(rate) => rate.deg_per_s(),
        _ => panic!("a rate"),
    });
    rates.sum::<f64>() / samples.len() as f64
}

fn ask(emulated: &mut Emulated, now: Timestamp, line: &str) -> Result<Value, RequestError> {
    let (_, request) = read(line.as_bytes());
    emulated.request(now, &request?)
}

fn drive(emulated: &mut Emulated, now: Timestamp, speed: f64, steer_deg_per_s: f64) {
    let line = emulated.rig.line_names.iter().position(|name| &**name == "base").unwrap();
    let frame = can_link::request_frame(&BaseRequest::SetVelocity {
        drive: Speed::from_m_per_s(speed),
        steer: AngularRate::from_deg_per_s(steer_deg_per_s),
    });
    let frame = Transmit::Frame(frame.expect("a velocity fits a frame"));
    emulated.receive(now, (line, HOST), frame);
}

#[test]
fn a_gyro_alone_is_turned_by_request() {
    let mut gyro = alone();
    let before = samples(&sent(&mut gyro, at(1.0)));
    // 100 Hz, with the first output after one period; the last one is still on its line.
    assert_eq!(before.len(), 99);
    assert!(mean_deg_per_s(&before).abs() < 1e-9);
    ask(&mut gyro, at(1.0), r#"{"rate_deg_per_s":10}"#).unwrap();
    sent(&mut gyro, at(1.1));
    let after = samples(&sent(&mut gyro, at(3.0)));
    assert!((mean_deg_per_s(&after) - 10.0).abs() < 0.002, "{}", mean_deg_per_s(&after));
    let truth = ask(&mut gyro, at(3.0), r#"{"get":"truth"}"#).unwrap();
    assert!((truth["heading_deg"].as_f64().unwrap() - 20.0).abs() < 1e-9, "{truth}");
    assert!((truth["rate_deg_per_s"].as_f64().unwrap() - 10.0).abs() < 1e-6, "{truth}");
}

#[test]
fn a_bias_that_is_set_is_in_the_stream() {
    let mut gyro = alone();
    sent(&mut gyro, at(0.5));
    ask(&mut gyro, at(0.5), r#"{"set":{"bias_deg_per_h":360,"temperature_degC":35}}"#).unwrap();
    sent(&mut gyro, at(0.6));
    let samples = samples(&sent(&mut gyro, at(3.5)));
    assert!((mean_deg_per_s(&samples) - 0.1).abs() < 0.002, "{}", mean_deg_per_s(&samples));
    let told = samples.last().unwrap().temperature.unwrap().celsius();
    assert!((told - 35.0).abs() < 0.01, "{told}");
    let list = ask(&mut gyro, at(3.5), r#"{"list":true}"#).unwrap();
    assert_eq!(list["gyro"]["parameters"]["ambient_celsius"], 35.0);
}

#[test]
fn a_set_with_one_mistake_sets_nothing() {
    let mut gyro = alone();
    let line = r#"{"set":{"bias_deg_per_h":30,"bias_per_h":1}}"#;
    let error = ask(&mut gyro, at(1.0), line).unwrap_err();
    assert!(error.to_string().contains("gyro.bias_per_h"), "{error}");
    let list = ask(&mut gyro, at(1.0), r#"{"list":true}"#).unwrap();
    assert_eq!(list["gyro"]["parameters"]["bias_deg_per_h"], 0.0);
}

#[test]
fn a_base_on_can_carries_its_gyro() {
    let mut bench = emulated(carried());
    sent(&mut bench, at(1.0));
    let mut turned = Vec::new();
    for tick in 0..300 {
        let now = at(1.0 + f64::from(tick) * 0.02);
        turned.extend(sent(&mut bench, now));
        drive(&mut bench, now, 0.0, 20.0);
    }
    let frames = turned.iter().filter(|(line, _)| line == "base").count();
    assert!(frames > 250, "a motion report every 20 ms: {frames}");
    let angle: f64 = mean_deg_per_s(&samples(&turned)) * samples(&turned).len() as f64 * 0.01;
    let truth = ask(&mut bench, at(7.0), r#"{"get":"truth"}"#).unwrap();
    let heading = truth["base"]["heading_deg"].as_f64().unwrap();
    assert!(heading > 90.0 && (angle - heading).abs() < 1.5, "{angle} {heading}");
    let error = ask(&mut bench, at(7.0), r#"{"rate_deg_per_s":10}"#).unwrap_err();
    assert!(error.to_string().contains("the base carries it"), "{error}");
    let error = ask(&mut bench, at(7.0), r#"{"set":{"bias_deg_per_h":1}}"#).unwrap_err();
    assert!(error.to_string().contains("gyro, base"), "{error}");
}

#[test]
fn being_late_changes_nothing() {
    let (mut late, mut on_time) = (emulated(carried()), emulated(carried()));
    for bench in [&mut late, &mut on_time] {
        drive(bench, at(0.1), 0.2, 30.0);
    }
    let all = sent(&mut on_time, at(3.0));
    late.wake(at(3.0));
    let late = outputs(&mut late);
    assert!(late.len() > 300, "{}", late.len());
    assert_eq!(late, all);
}

#[test]
fn faults_of_the_base_end_by_themselves() {
    let mut base = emulated(Parts { base: base(Transport::Can), ..Parts::default() });
    drive(&mut base, at(0.1), 0.2, 0.0);
    ask(&mut base, at(0.2), r#"{"fault":{"emergency_stop":{"for_s":2}}}"#).unwrap();
    drive(&mut base, at(1.5), 0.2, 0.0);
    let truth = ask(&mut base, at(1.9), r#"{"get":"truth"}"#).unwrap();
    assert_eq!(truth["base"]["speed_m_per_s"], 0.0);
    drive(&mut base, at(2.3), 0.2, 0.0);
    let truth = ask(&mut base, at(2.6), r#"{"get":"truth"}"#).unwrap();
    assert!(truth["base"]["speed_m_per_s"].as_f64().unwrap() > 0.01, "{truth}");
}

#[test]
fn a_fault_of_a_line_goes_on_until_it_is_taken_back() {
    let mut gyro = alone();
    sent(&mut gyro, at(1.0));
    let drop = r#"{"fault":{"drop":{"loss_percent":100}},"toward":"host"}"#;
    ask(&mut gyro, at(1.0), drop).unwrap();
    sent(&mut gyro, at(1.1));
    assert!(sent(&mut gyro, at(2.0)).is_empty());
    ask(&mut gyro, at(2.0), r#"{"no_fault":{}}"#).unwrap();
    assert!(sent(&mut gyro, at(3.0)).len() > 90);
    let counters = ask(&mut gyro, at(3.0), r#"{"get":"counters"}"#).unwrap();
    // A hundred outputs of eight bytes.
    assert_eq!(counters["faults_acted"], 800, "{counters}");
}

/// Found by a user: its restart was refused, and its switch told of that restart.
#[test]
fn a_gyro_is_restarted_by_a_fault() {
    let mut gyro = alone();
    sent(&mut gyro, at(1.0));
    ask(&mut gyro, at(1.0), r#"{"fault":{"restart":{"for_s":0.5}}}"#).unwrap();
    sent(&mut gyro, at(1.1));
    assert!(sent(&mut gyro, at(1.45)).is_empty());
    assert!(sent(&mut gyro, at(2.5)).len() > 90);
}

#[test]
fn what_cannot_fail_says_so() {
    let (base, table) = (base(Transport::Serial), Some(TableParameters::default()));
    let mut bench = emulated(Parts { gyro: gyro(), base, table, mount: None });
    let mut said = String::new();
    for line in [
        r#"{"device":"base","fault":"stuck"}"#,
        r#"{"device":"base","fault":"babble"}"#,
        r#"{"device":"gyro","fault":"emergency_stop"}"#,
        r#"{"device":"gyro","fault":"stuck","duration_s":3}"#,
        r#"{"device":"laser","fault":"drop"}"#,
        r#"{"fault":"disconnect"}"#,
        r#"{"fault":"silent"}"#,
        r#"{"power":false,"device":"gyro"}"#,
        r#"{"get":["x"],"device":"gyro"}"#,
    ] {
        said += &format!("{line}\n    {}\n", ask(&mut bench, at(0.1), line).unwrap_err());
    }
    let mut gyroless = emulated(Parts { base: self::base(Transport::Can), ..Parts::default() });
    for line in [r#"{"rate_deg_per_s":1}"#, r#"{"device":"gyro","fault":"disconnect"}"#] {
        said += &format!("{line}\n    {}\n", ask(&mut gyroless, at(0.1), line).unwrap_err());
    }
    insta::assert_snapshot!(said);
}

#[test]
fn a_table_answers_on_its_line() {
    let mut table = emulated(Parts { table: Some(TableParameters::default()), ..Parts::default() });
    let command = wire::table::Command::State.encode();
    table.receive(at(0.1), (0, HOST), Transmit::Bytes(command));
    let answers = sent(&mut table, at(1.0));
    assert!(matches!(answers.as_slice(), [(line, Transmit::Bytes(_))] if line == "table"));
    let counters = ask(&mut table, at(1.0), r#"{"get":"counters"}"#).unwrap();
    assert_eq!(counters["table"]["device"]["lines_refused"], 0);
}

#[test]
fn messages_that_a_device_refuses_are_counted() {
    const METER: &str = "name = \"meter\"\n[serial]\nbaud = 9600\n[[message]]\nname = \"Set\"\nsent_by = \"host\"\n\
        start = [0xAA]\nchecksum = \"sum8\"\nfields = [{ name = \"Gain\", type = \"u8\" }]\n";
    let read = &mut |_: &str| Err("none".to_owned());
    let described = described::Description::parse("meter.toml", METER, read).unwrap();
    let what = What::Rig(Box::new(plan::Rig::of_device(Arc::new(described))));
    let ports = vec![("device".to_owned(), PortSpec::Pty { link: None })];
    let mut meter = Emulated::new(&Setup { what, ports, control: None, seed: 1 }).0;
    for (seconds, checksum) in [(0.1, 7), (0.2, 8)] {
        let packet = wire::packet::Packet::from_slice(&[0xaa, 7, checksum]).unwrap();
        meter.receive(at(seconds), (0, HOST), Transmit::Bytes(packet));
        sent(&mut meter, at(seconds + 0.05));
    }
    let counters = ask(&mut meter, at(0.3), r#"{"get":"counters"}"#).unwrap();
    assert_eq!(counters["device"]["device"]["messages_refused"], 1, "{counters}");
}
