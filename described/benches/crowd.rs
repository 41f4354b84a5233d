//! Speed relative to real time of a device with 100 signals at 100 Hz: ten seconds, 1,000 times 25 frames of four
//! signals each, all of them expressions. 10,000 times real time is 1 ms; docs/benchmarks.md has the measured values.
//! The benchmark measures processor time, which other processes disturb less than wall-clock time.

#[path = "../../harness/benches/processor/mod.rs"]
mod processor;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use described::{Description, Device};
use std::fmt::Write;
use std::hint::black_box;
use std::sync::Arc;
use std::time::Duration;
use wire::time::{Span, Timestamp};

const MESSAGES: usize = 25;
const SIGNALS_A_MESSAGE: usize = 4;
const SECONDS: i64 = 10;

/// Cells in series: the state of charge of each, and its voltage under load.
fn pack() -> String {
    let mut text =
        "name = \"pack\"\n[parameter.current]\nvalue = 20\n[parameter.resistance]\nvalue = 0.001\n\
                    [state.soc]\nstart = 0.5\nrate = \"(0.6 - soc) * current / 36000\"\n"
            .to_owned();
    let cells =
        |message: usize| (1..=SIGNALS_A_MESSAGE).map(move |k| SIGNALS_A_MESSAGE * message + k);
    for cell in (0..MESSAGES).flat_map(cells) {
        let _ = write!(
            text,
            "[signal.V{cell}]\nexpression = \"3.3 + {} * soc - resistance * current\"\n",
            0.8 + 0.001 * cell as f64
        );
    }
    for message in 0..MESSAGES {
        let fields = cells(message)
            .map(|cell| format!("{{ name = \"V{cell}\", type = \"u16\", scale = 0.0001 }}"));
        let _ = write!(
            text,
            "[[message]]\nname = \"M{message}\"\nsent_by = \"device\"\ncan_id = {}\nperiod_s = 0.01\nfields = [{}]\n",
            0x100 + message,
            fields.collect::<Vec<_>>().join(", ")
        );
    }
    text
}

fn crowd(criterion: &mut Criterion) {
    let pack = Description::parse("pack.toml", &pack(), &mut |_| Err(String::new()))
        .expect("the file is a description");
    let mut device = Device::new(Arc::new(pack), 1);
    let mut now = Timestamp::ZERO;
    let mut group = criterion.benchmark_group("described device");
    let values = SECONDS * 100 * (MESSAGES * SIGNALS_A_MESSAGE) as i64;
    group.throughput(Throughput::Elements(values as u64));
    group.bench_function("ten seconds of 100 signals at 100 Hz", |bencher| {
        bencher.iter_custom(|runs| {
            let began = processor::processor_s();
            for _ in 0..runs {
                now += Span::from_secs(SECONDS);
                while device.next_wakeup() <= now {
                    device.wake(device.next_wakeup());
                    while let Some(wired) = device.transmit() {
                        black_box(&wired);
                    }
                }
            }
            Duration::from_secs_f64(processor::processor_s() - began)
        });
    });
    group.finish();
    assert_eq!((device.dropped(), device.clipped().count(), device.not_finite()), (0, 0, 0));
}

criterion_group!(benches, crowd);
criterion_main!(benches);
