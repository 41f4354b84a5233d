use super::{EmulatedBench, Parts};
use crate::emulation::Role;
use crate::emulation::link::{Output, Pace};
use crate::emulation::request::{RequestError, read};
use emulators::base::{BaseParameters, Transport};
use emulators::device_file::Mount;
use emulators::gyro::GyroParameters;
use emulators::table::TableParameters;
use serde_json::Value;
use std::collections::BTreeMap;
use wire::base::{Request as BaseRequest, can_link};
use wire::gyro::{GyroDecoder, GyroFormat, GyroOutput, GyroSample, GyroStream, OutputMode};
use wire::packet::Packet;
use wire::time::{Span, Timestamp};
use wire::units::{AngularRate, Speed};

const STREAM: GyroStream =
    GyroStream { format: GyroFormat::Navigator, mode: OutputMode::Rate, reversed: false };

fn gyro() -> Option<(GyroStream, GyroParameters)> {
    Some((STREAM, GyroParameters::default()))
}

fn base(transport: Transport) -> Option<(Transport, BaseParameters)> {
    Some((transport, BaseParameters::default()))
}

fn bench(parts: Parts) -> EmulatedBench {
    let paces: BTreeMap<Role, Pace> =
        Role::ALL.into_iter().map(|role| (role, Pace::Medium)).collect();
    EmulatedBench::new(parts, &paces, 1)
}

fn alone() -> EmulatedBench {
    bench(Parts { gyro: gyro(), ..Parts::default() })
}

fn at(seconds: f64) -> Timestamp {
    Timestamp::ZERO + Span::from_secs_f64(seconds)
}

/// Goes on to `now` and gives what has been sent on the way.
fn sent(bench: &mut EmulatedBench, now: Timestamp) -> Vec<(Role, Output)> {
    let mut sent = Vec::new();
    while bench.next_wakeup() <= now {
        bench.wake(bench.next_wakeup());
        sent.extend(std::iter::from_fn(|| bench.transmit()));
    }
    bench.wake(now);
    sent
}

fn samples(outputs: &[(Role, Output)]) -> Vec<GyroSample> {
    let mut decoder = GyroDecoder::new(STREAM);
    let mut samples = Vec::new();
    for (_, output) in outputs.iter().filter(|(role, _)| *role == Role::Gyro) {
        let Output::Bytes(bytes) = output else { panic!("a gyro sends bytes") };
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

fn ask(bench: &mut EmulatedBench, now: Timestamp, line: &str) -> Result<Value, RequestError> {
    let (_, request) = read(line.as_bytes());
    bench.request(now, &request?)
}

fn drive(bench: &mut EmulatedBench, now: Timestamp, speed: f64, steer_deg_per_s: f64) {
    let frame = can_link::request_frame(&BaseRequest::SetVelocity {
        drive: Speed::from_m_per_s(speed),
        steer: AngularRate::from_deg_per_s(steer_deg_per_s),
    });
    bench.receive(now, Role::Base, Output::Frame(frame.expect("a velocity fits a frame")));
}

#[test]
fn a_gyro_alone_is_turned_by_request() {
    let mut bench = alone();
    let before = samples(&sent(&mut bench, at(1.0)));
    assert_eq!(before.len(), 100, "100 Hz, the first output after one period");
    assert!(mean_deg_per_s(&before).abs() < 1e-9);
    ask(&mut bench, at(1.0), r#"{"rate_deg_per_s":10}"#).unwrap();
    let after = samples(&sent(&mut bench, at(3.0)));
    assert!((mean_deg_per_s(&after) - 10.0).abs() < 0.002, "{}", mean_deg_per_s(&after));
    let truth = ask(&mut bench, at(3.0), r#"{"get":"truth"}"#).unwrap();
    assert!((truth["heading_deg"].as_f64().unwrap() - 20.0).abs() < 1e-9, "{truth}");
    assert!((truth["rate_deg_per_s"].as_f64().unwrap() - 10.0).abs() < 1e-6, "{truth}");
}

#[test]
fn a_bias_that_is_set_is_in_the_stream() {
    let mut bench = alone();
    sent(&mut bench, at(0.5));
    ask(&mut bench, at(0.5), r#"{"set":{"bias_deg_per_h":360,"temperature_degC":35}}"#).unwrap();
    let samples = samples(&sent(&mut bench, at(3.5)));
    assert!((mean_deg_per_s(&samples) - 0.1).abs() < 0.002, "{}", mean_deg_per_s(&samples));
    let told = samples.last().unwrap().temperature.unwrap().celsius();
    assert!((told - 35.0).abs() < 0.01, "{told}");
    let list = ask(&mut bench, at(3.5), r#"{"list":true}"#).unwrap();
    assert_eq!(list["gyro"]["parameters"]["ambient_celsius"], 35.0);
}

#[test]
fn a_set_with_one_mistake_sets_nothing() {
    let mut bench = alone();
    let line = r#"{"set":{"bias_deg_per_h":30,"bias_per_h":1}}"#;
    let error = ask(&mut bench, at(1.0), line).unwrap_err();
    assert!(error.to_string().contains("gyro.bias_per_h"), "{error}");
    let list = ask(&mut bench, at(1.0), r#"{"list":true}"#).unwrap();
    assert_eq!(list["gyro"]["parameters"]["bias_deg_per_h"], 0.0);
}

#[test]
fn a_bench_on_can_carries_its_gyro() {
    let parts = Parts {
        gyro: gyro(),
        base: base(Transport::Can),
        mount: Some(Mount::Base),
        ..Parts::default()
    };
    let mut bench = bench(parts);
    sent(&mut bench, at(1.0));
    let mut turned = Vec::new();
    for tick in 0..300 {
        let now = at(1.0 + f64::from(tick) * 0.02);
        turned.extend(sent(&mut bench, now));
        drive(&mut bench, now, 0.0, 20.0);
    }
    let frames = turned.iter().filter(|(role, _)| *role == Role::Base).count();
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
    let parts = || Parts {
        gyro: gyro(),
        base: base(Transport::Can),
        mount: Some(Mount::Base),
        ..Parts::default()
    };
    let (mut late, mut on_time) = (bench(parts()), bench(parts()));
    for bench in [&mut late, &mut on_time] {
        drive(bench, at(0.1), 0.2, 30.0);
    }
    let all = sent(&mut on_time, at(3.0));
    late.wake(at(3.0));
    let late: Vec<_> = std::iter::from_fn(|| late.transmit()).collect();
    let bytes = |outputs: &[(Role, Output)], role: Role| {
        let of_role = outputs.iter().filter(|(from, _)| *from == role);
        of_role.map(|(_, output)| *output).take(200).collect::<Vec<_>>()
    };
    for role in [Role::Gyro, Role::Base] {
        // The queue to the port is bounded: what it kept is the same.
        let (late, all) = (bytes(&late, role), bytes(&all, role));
        assert_eq!(late, all[..late.len()]);
        assert!(late.len() > 30, "{}", late.len());
    }
}

#[test]
fn faults_of_the_base_end_by_themselves() {
    let mut bench = bench(Parts { base: base(Transport::Can), ..Parts::default() });
    drive(&mut bench, at(0.1), 0.2, 0.0);
    ask(&mut bench, at(0.2), r#"{"fault":"emergency_stop","for_s":2}"#).unwrap();
    drive(&mut bench, at(1.5), 0.2, 0.0);
    let truth = ask(&mut bench, at(1.9), r#"{"get":"truth"}"#).unwrap();
    assert_eq!(truth["base"]["speed_m_per_s"], 0.0);
    drive(&mut bench, at(2.3), 0.2, 0.0);
    let truth = ask(&mut bench, at(2.6), r#"{"get":"truth"}"#).unwrap();
    assert!(truth["base"]["speed_m_per_s"].as_f64().unwrap() > 0.01, "{truth}");
}

#[test]
fn what_cannot_fail_says_so() {
    let parts = Parts {
        gyro: gyro(),
        base: base(Transport::Serial),
        table: Some(TableParameters::default()),
        mount: None,
    };
    let mut bench = bench(parts);
    let mut said = String::new();
    for line in [
        r#"{"device":"base","fault":"stuck"}"#,
        r#"{"device":"table","fault":"stuck"}"#,
        r#"{"device":"gyro","fault":"emergency_stop"}"#,
        r#"{"fault":"silent"}"#,
    ] {
        said += &format!("{line}\n    {}\n", ask(&mut bench, at(0.1), line).unwrap_err());
    }
    let mut gyroless = self::bench(Parts { base: base(Transport::Can), ..Parts::default() });
    for line in [r#"{"rate_deg_per_s":1}"#, r#"{"device":"gyro","fault":"silent"}"#] {
        said += &format!("{line}\n    {}\n", ask(&mut gyroless, at(0.1), line).unwrap_err());
    }
    insta::assert_snapshot!(said);
}

#[test]
fn a_table_answers_on_its_line() {
    let parts = Parts { table: Some(TableParameters::default()), ..Parts::default() };
    let mut bench = bench(parts);
    let command = wire::table::Command::State.encode();
    bench.receive(at(0.1), Role::Table, Output::Bytes(command));
    let (role, answer) = bench.transmit().unwrap();
    assert_eq!(role, Role::Table);
    let Output::Bytes(answer) = answer else { panic!("a table sends bytes") };
    assert_ne!(answer, Packet::new());
    let counters = ask(&mut bench, at(0.2), r#"{"get":"counters"}"#).unwrap();
    assert_eq!(counters["table"]["device"]["lines_refused"], 0);
}
