//! Records for tests.

use super::{Device, Number, Observation, Record, RecordKind, Reply, Through};
use crate::{FaultEvent, FaultRecord};
use controller::health::{Causes, Health};
use controller::mission::{
    AbortReason, Activity, BiasTest, BiasTestResult, Command, MissionResult, Refusal, Report,
    State, Turn,
};
use proptest::prelude::*;
use std::collections::BTreeMap;
use wire::can::{CanFrame, FD_LENGTHS, FdFlags, StandardId};
use wire::time::Timestamp;
use wire::units::{Angle, AngularRate, Length, Pose, Temperature};

fn pose(x: f64, y: f64, heading_deg: f64) -> Pose {
    Pose { x: Length::from_m(x), y: Length::from_m(y), heading: Angle::from_deg(heading_deg) }
}

/// A state at this position.
pub fn state(x: f64, y: f64) -> State {
    State {
        activity: Activity::TurnOrientation,
        pose: pose(x, y, 45.0),
        gyro_heading: Angle::from_deg(45.01),
        odometry_heading: Angle::from_deg(44.7),
        displacement: Length::from_m(4.0),
        heading_error: None,
        raw_rate: AngularRate::from_deg_per_s(29.987),
        bias: AngularRate::from_deg_per_h(-12.5),
        temperature: Some(Temperature::from_celsius(36.98)),
        moving: true,
        samples: 12_345,
        samples_lost: 2,
        clock_ratio: Some(0.998),
        health: Health::new(false, Causes { samples_lost: true, ..Causes::default() }),
        uncertainty: None,
    }
}

/// An observation of this quantity.
pub fn observation(quantity: &str, value: f64, tags: &[(&str, f64)]) -> RecordKind {
    let tags = tags.iter().map(|(tag, value)| ((*tag).to_owned(), *value)).collect();
    RecordKind::Observation(Observation {
        quantity: quantity.to_owned(),
        value,
        uncertainty: 0.2,
        tags,
    })
}

/// One record.
pub fn record(at_s: f64, device: Device, kind: RecordKind) -> Record {
    Record { at: Timestamp::from_secs_f64(at_s), device, kind }
}

/// Each record kind and each report once.
pub fn one_of_each() -> Vec<Record> {
    let frame =
        CanFrame::new(StandardId::new(0x123).expect("11 bits"), &[0xde, 0xad]).expect("two bytes");
    let turn = Turn { angle: Angle::from_rad(1.5), rate: AngularRate::from_rad_per_s(0.5) };
    let bias = BiasTestResult {
        mean: AngularRate::from_rad_per_s(-0.000_012_1),
        spread: AngularRate::from_rad_per_s(0.001),
        samples: 2_000,
        temperature: None,
        table: None,
    };
    let truth = RecordKind::Truth {
        pose: pose(1.0, -2.0, 90.0),
        bias_rad_per_s: 1e-5,
        coil_celsius: 31.25,
    };
    let health = Health::new(false, Causes { gyro_silent: true, ..Causes::default() });
    let number = Number { name: "gap".into(), value: 1.5, unit: "mm".into() };
    let reply = Reply {
        question: "How wide is the gap?".into(),
        number: Some(number),
        by: "Jane Doe".into(),
        through: Through::Terminal,
        unix_s: Some(1_770_000_000),
    };
    let confined =
        FaultEvent::Confinement { node: "base".into(), state: "bus-off".into(), tec: 256, rec: 3 };
    let fault = FaultRecord { index: 2, name: "bit_errors of base".into(), event: confined };
    vec![
        record(
            0.0,
            Device::Plan,
            RecordKind::StepBegan {
                path: "steps[0].repeat[1]".into(),
                title: "turn by 90 deg".into(),
            },
        ),
        record(0.01, Device::Gyro, RecordKind::Bytes(vec![0x80, 1, 2, 3, 0x7f])),
        record(0.02, Device::Base, RecordKind::Frame(frame)),
        record(0.03, Device::Plan, RecordKind::Command(Box::new(Command::Turn(turn)))),
        record(
            0.04,
            Device::Plan,
            RecordKind::Command(Box::new(Command::BiasTest(BiasTest { duration_s: 20.0 }))),
        ),
        record(0.05, Device::Plan, RecordKind::Command(Box::new(Command::RequestState))),
        record(
            20.1,
            Device::Controller,
            RecordKind::Report(Report::Done { id: 1, result: MissionResult::BiasTest(bias) }),
        ),
        record(20.2, Device::Controller, RecordKind::Report(Report::State(state(1.0, 2.0)))),
        record(
            20.3,
            Device::Controller,
            RecordKind::Report(Report::Refused { id: 2, reason: Refusal::Moving }),
        ),
        record(
            20.4,
            Device::Controller,
            RecordKind::Report(Report::Aborted { id: 3, reason: AbortReason::GyroSilent }),
        ),
        record(20.5, Device::Controller, RecordKind::Report(Report::Health(health))),
        record(
            20.6,
            Device::Absolute,
            observation("lap.gyro_error", -0.31, &[("direction", -1.0), ("run", 3.0)]),
        ),
        record(57_600.0, Device::Base, truth),
        record(57_600.0, Device::Base, RecordKind::Note("1 frame lost".into())),
        record(57_601.0, Device::Plan, RecordKind::StepEnded { path: "steps[0].repeat[1]".into() }),
        record(57_602.0, Device::Plan, RecordKind::Reply(Box::new(reply))),
        record(57_603.0, Device::Base, RecordKind::Fault(Box::new(fault))),
    ]
}

/// Any instant, device and kind; numbers are finite so that equality means the same bytes.
pub fn any_record() -> impl Strategy<Value = Record> {
    let number = || -1e9..1e9f64;
    let kind = prop_oneof![
        prop::collection::vec(any::<u8>(), 0..80).prop_map(RecordKind::Bytes),
        prop::collection::vec(any::<u8>(), 0..=8).prop_map(|data| {
            let id =
                StandardId::new(u16::from(data.first().copied().unwrap_or(0))).expect("11 bits");
            RecordKind::Frame(CanFrame::new(id, &data).expect("eight bytes"))
        }),
        (prop::sample::select(FD_LENGTHS.to_vec()), any::<u8>()).prop_map(|(length, flags)| {
            let (flags, data) = (FdFlags::from_bits(flags), vec![flags; usize::from(length)]);
            RecordKind::Frame(CanFrame::fd(StandardId::MAX, flags, &data).expect("a length of FD"))
        }),
        any::<String>().prop_map(RecordKind::Note),
        (any::<String>(), any::<String>())
            .prop_map(|(path, title)| RecordKind::StepBegan { path, title }),
        any::<String>().prop_map(|path| RecordKind::StepEnded { path }),
        (number(), number()).prop_map(|(x, y)| RecordKind::Report(Report::State(state(x, y)))),
        (number(), number(), number()).prop_map(|(x, y, bias_rad_per_s)| RecordKind::Truth {
            pose: pose(x, y, 12.0),
            bias_rad_per_s,
            coil_celsius: x,
        }),
        (any::<String>(), number(), prop::collection::btree_map(any::<String>(), number(), 0..4))
            .prop_map(|(quantity, value, tags): (_, _, BTreeMap<_, _>)| {
                let uncertainty = 0.1;
                RecordKind::Observation(Observation { quantity, value, uncertainty, tags })
            }),
    ];
    (any::<i64>(), prop::sample::select(Device::ALL.to_vec()), kind)
        .prop_map(|(at, device, kind)| Record { at: Timestamp::from_nanos(at), device, kind })
}
