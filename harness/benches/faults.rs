//! Cost of the fault layers: a packet on a line, and a long run, without faults, with a schedule that is not due, and
//! with active faults.
//!
//! `cargo bench -p harness --bench faults`. Each figure is the median of [`RUNS`](processor::RUNS) rounds of processor
//! time.

mod processor;

use harness::run::{Prepared, simulate};
use plan::faults::Chance;
use plan::faults::{Fault, FaultKind, Schedule, Target, When};
use plan::made::Made;
use processor::{median, processor_s};
use record::sink::NullSink;
use rig::link::SerialLine;
use rig::operator::Answers;
use std::hint::black_box;
use std::sync::Arc;
use wire::packet::Packet;
use wire::serial::SerialSettings;
use wire::time::{Span, Timestamp};

const PACKETS: u32 = 2_000_000;
const BITS: SerialSettings = SerialSettings::new_8n1(115_200);
/// After the end of the plan.
const NEVER: Span = Span::from_secs(10_000);

fn main() {
    // `cargo test --benches` only checks that it starts.
    if std::env::args().any(|argument| argument == "--test") {
        return;
    }
    for (name, kind) in [
        ("no fault", None),
        ("a layer that does nothing", Some(FaultKind::Drop { loss_percent: 0.0 })),
        ("burst loss", FaultKind::typical("burst_loss")),
    ] {
        let median_s = seconds(|| packets(kind.as_ref()));
        println!(
            "{:<46} {:>8.1} ns",
            format!("packet, {name}"),
            median_s / f64::from(PACKETS) * 1e9
        );
    }
    let plain = Prepared::load("straight-accuracy", &Made::default()).expect("it ships");
    let kind = FaultKind::Drop { loss_percent: 0.1 };
    let not_due = Fault { when: When::At(NEVER), ..Fault::new(Target::Gyro, kind) };
    for (name, faults) in [
        ("no fault", Vec::new()),
        ("a schedule that is not due", vec![not_due]),
        ("drop 0.1 % of the gyro", vec![Fault::new(Target::Gyro, kind)]),
    ] {
        let mut prepared = plain.clone();
        Arc::make_mut(&mut prepared.plan).faults = Schedule { faults };
        let run = || simulate(&prepared, 1, &Answers::default(), &mut NullSink, &mut |_| true);
        let events = run().events;
        let median_s = seconds(|| {
            black_box(run());
        });
        println!(
            "{:<46} {:>8.1} ns an event",
            format!("run, {name}"),
            median_s / events as f64 * 1e9
        );
    }
}

fn packets(kind: Option<&FaultKind>) {
    let packet = Packet::from_slice(&[0x5a; 8]).expect("eight bytes fit");
    let mut line = SerialLine::new(BITS);
    if let Some(kind) = kind {
        line.begin_fault(Timestamp::ZERO, 0, kind, Chance::new(1, "0"));
    }
    let mut now = Timestamp::ZERO;
    for _ in 0..PACKETS {
        now += Span::from_millis(10);
        line.send(now, black_box(packet));
        black_box(line.arrived(now + Span::from_millis(5)));
    }
}

/// Median processor time of a run, s.
fn seconds(mut run: impl FnMut()) -> f64 {
    median(|| {
        let before = processor_s();
        run();
        processor_s() - before
    })
}
