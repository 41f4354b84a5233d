//! Comparison with another codec: frames encoded by cantools over random layouts in both byte orders, signed and
//! unsigned, floats, and nested multiplexers with ranges. `data/encode_with_cantools.py` wrote both files (cantools
//! 41.4.3).

use described::{Layout, Signal};
use std::collections::BTreeMap;
use wire::device::Transmit;

const DBC: &str = include_str!("data/cantools.dbc");
const FRAMES: &str = include_str!("data/cantools.csv");

/// Rounding of a double for a 40-bit count with a factor.
const ROUNDING: f64 = 1e-3;

#[test]
fn frames_are_those_of_cantools() {
    let layout = Layout::from_dbc("cantools.dbc", DBC, "A").expect("the file is a layout");
    let mut compared = 0;
    for row in FRAMES.lines().skip(1) {
        let mut cells = row.split(',');
        let mut cell = || cells.next().expect("three cells a row");
        let (name, data, values) = (cell(), cell(), cell());
        let message = layout.find(name).expect("the message is in the DBC");
        let form = &layout.messages()[message];
        let said: BTreeMap<&str, f64> = values
            .split(' ')
            .map(|value| value.split_once('=').expect("name=value"))
            .map(|(signal, value)| (signal, value.parse().expect("a number")))
            .collect();
        // Values that the frame does not carry are ignored.
        let value = |signal: &Signal| said.get(signal.name.as_str()).copied().unwrap_or(f64::NAN);
        let values: Vec<f64> = form.signals.iter().map(value).collect();
        let Ok(Transmit::Frame(frame)) = layout.encode(message, &values) else {
            panic!("{row} is not encoded");
        };
        assert_eq!(frame.fd_flags().is_some(), name.starts_with('F'), "{row}");
        let hex: String = frame.data().iter().map(|byte| format!("{byte:02x}")).collect();
        assert_eq!(hex, data, "{row}");
        let mut decoder = layout.decoder();
        let decoded = decoder.frame(&frame).expect("the frame is known");
        for ((found, value), signal) in decoded.values.iter().zip(&values).zip(&form.signals) {
            assert_eq!(found.is_some(), !value.is_nan(), "{name}.{}: {row}", signal.name);
            let Some(found) = found else { continue };
            assert!((found - value).abs() < ROUNDING, "{name}.{}: {found} {value}", signal.name);
            compared += 1;
        }
    }
    assert!(compared > 500, "{compared}");
}
