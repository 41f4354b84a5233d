//! Values of signals.

use super::{OVEN, at, listed, oven, parse, run, showing, values};
use crate::Description;
use crate::device::Device;
use std::sync::Arc;
use wire::device::Transmit;
use wire::time::Timestamp;

#[test]
fn noise_belongs_to_seed_and_signal() {
    let noisy = |toml: &str, seed| {
        let description = parse(toml);
        let mut device = Device::new(Arc::clone(&description), seed);
        let sent = run(&mut device, 20.0);
        let first = |(_, wired): &(Timestamp, Transmit)| values(description.layout(), wired).1[0];
        sent.iter().map(first).collect::<Vec<f64>>()
    };
    let (one, again, other) = (noisy(OVEN, 1), noisy(OVEN, 1), noisy(OVEN, 2));
    assert_eq!(one, again);
    assert_ne!(one, other);
    // Noise on another signal does not change these values.
    let more = OVEN.replace("expression = \"heater\"", "expression = \"heater\"\nnoise = 0.1");
    assert_ne!(more, OVEN);
    assert_eq!(noisy(&more, 1), one);
    let mean = one.iter().sum::<f64>() / one.len() as f64;
    let square = |value: &f64| (value - mean) * (value - mean);
    let rms = (one.iter().map(square).sum::<f64>() / (one.len() - 1) as f64).sqrt();
    // The standard deviation of 200 values is accurate to 5 %.
    assert!((mean - 20.0).abs() < 0.02 && (0.04..0.06).contains(&rms), "{mean} {rms}");
    assert!(Device::new(oven(), 1).value("Temperature") == Some(20.0));
}

#[test]
fn what_is_not_finite_leaves_what_was_before() {
    let description = showing(
        "[state.a]\nstart = 2\nrate = \"if(t > 0.2, 0 / 0, 1)\"\n[state.b]\nvalue = \"1 / (t < 0.25)\"\n\
         [signal.x]\nexpression = \"a / (t < 0.35)\"\n",
    );
    let mut device = Device::new(Arc::clone(&description), 1);
    let sent = run(&mut device, 0.5);
    let shown: Vec<f64> =
        sent.iter().map(|(_, wired)| values(description.layout(), wired).1[0]).collect();
    for (value, expected) in shown.iter().zip([2.1, 2.2, 2.2, 2.2, 2.2]) {
        assert!((value - expected).abs() < 0.02, "{shown:?}");
    }
    assert_eq!(device.value("b"), Some(1.0));
    assert!(device.not_finite() > 20, "{}", device.not_finite());
}

#[test]
fn an_initial_value_may_be_the_name_of_one() {
    let description = parse(&OVEN.replace("Enable = 0 }", "Enable = \"on\" }"));
    assert_eq!(Device::new(description, 1).value("Enable"), Some(1.0));
}

#[test]
fn what_is_beyond_its_range_is_sent_as_its_end() {
    let text = OVEN.replace("expression = \"temperature\"", "expression = \"1e6 * (t - 0.15)\"");
    let description = parse(&text);
    let mut device = Device::new(Arc::clone(&description), 1);
    let sent = run(&mut device, 0.2);
    let first = |(_, wired): &(Timestamp, Transmit)| values(description.layout(), wired).1[0];
    assert_eq!(sent.iter().map(first).collect::<Vec<_>>(), [-40.0, 320.0]);
    let clipped = device.clipped().map(|one| (one.name, one.count));
    assert_eq!(clipped.collect::<Vec<_>>(), [("Status.Temperature".to_owned(), 2)]);
    let farthest = device.clipped().next().unwrap().farthest;
    assert!((farthest + 50_000.0).abs() < 1.0, "{farthest}");
}

#[test]
fn series_go_on_from_power_on() {
    for (source, expected) in [
        ("steps = [[0, 1], [0.2, 2], [0.35, 3]]", [1.0, 2.0, 2.0, 3.0]),
        ("steps = [[0, 0], [0.4, 4]]\ninterpolate = true", [1.0, 2.0, 3.0, 4.0]),
        ("steps = [[0, 0], [0.15, 1], [0.25, 2]]\nrepeat = true", [0.0, 1.0, 0.0, 1.0]),
        ("csv = \"trace.csv\"\ninterpolate = true", [11.0, 12.0, 13.0, 14.0]),
        ("csv = \"trace.csv\"\ntime = \"temp\"\nvalue = \"t_s\"", [0.0; 4]),
    ] {
        let description = showing(&format!("[signal.x]\n{source}"));
        let mut device = Device::new(Arc::clone(&description), 1);
        for begin in [0.0, 7.0] {
            device.power(at(begin), false);
            device.power(at(begin), true);
            let sent = run(&mut device, begin + 0.42);
            let first =
                |(_, wired): &(Timestamp, Transmit)| values(description.layout(), wired).1[0];
            let shown: Vec<f64> = sent.iter().map(first).collect();
            let near = shown.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9);
            assert!(near && shown.len() == 4, "{source}: {shown:?}");
        }
    }
}

#[test]
fn a_meter_answers_over_a_serial_line() {
    let description = parse(
        "name = \"meter\"\n[serial]\nbaud = 9600\n[parameter.level]\nvalue = 1.5\n\
         [signal.Level]\nexpression = \"level\"\n\
         [[message]]\nname = \"Ask\"\nsent_by = \"host\"\ntext = \"LEVEL?\\r\\n\"\n\
         [[message]]\nname = \"Set\"\nsent_by = \"host\"\ntext = \"SET {Gain}\\r\\n\"\n\
         [[message]]\nname = \"Tell\"\nsent_by = \"device\"\ntext = \"L={Level:.3}\\r\\n\"\nanswers = \"Ask\"\n",
    );
    let mut device = Device::new(description, 1);
    device.receive_bytes(at(1.0), b"?\r\nLEV");
    assert_eq!(device.transmit(), None);
    device.receive_bytes(at(1.1), b"EL?\r\nSET 2.5\r\nLEVEL?\r\n");
    let mut sent = Vec::new();
    while let Some(Transmit::Bytes(line)) = device.transmit() {
        sent.extend_from_slice(line.as_slice());
    }
    assert_eq!(sent.escape_ascii().to_string(), "L=1.500\\r\\nL=1.500\\r\\n");
    assert_eq!((device.value("Gain"), device.damaged()), (Some(2.5), 3));
}

#[test]
fn a_multiplexer_that_nobody_drives_takes_its_pages_in_turn() {
    let dbc = "VERSION \"\"\n\nNS_ :\n\nBS_:\n\nBU_: D H\n\nBO_ 1 M: 3 D\n \
               SG_ Page M : 0|8@1+ (1,0) [0|255] \"\" H\n SG_ A m2 : 8|8@1+ (1,0) [0|0] \"\" H\n \
               SG_ B m7 : 8|8@1+ (1,0) [0|0] \"\" H\n\n";
    let text = "name = \"d\"\ndbc = \"d.dbc\"\nnode = \"D\"\nmessage.M.period_s = 1\n\
                signal.A.expression = 3\nsignal.B.expression = \"4 + t\"\n";
    let description = Description::parse("d.toml", text, &mut |_| Ok(dbc.to_owned())).unwrap();
    let mut device = Device::new(Arc::new(description.clone()), 1);
    let sent = listed(description.layout(), &run(&mut device, 3.0));
    assert_eq!(sent, ["1 M [2.0, 3.0, NaN]", "2 M [7.0, NaN, 6.0]", "3 M [2.0, 3.0, NaN]"]);
}

const NESTED: &str = "BU_: D H\nBO_ 1 M: 3 D\n SG_ Top M : 0|4@1+ (1,0) [0|0] \"\" H\n \
    SG_ Low m1M : 4|4@1+ (1,0) [0|0] \"\" H\n SG_ A m0 : 8|8@1+ (1,0) [0|0] \"\" H\n \
    SG_ B m2 : 8|8@1+ (1,0) [0|0] \"\" H\n SG_ C m5 : 8|8@1+ (1,0) [0|0] \"\" H\n\
    SG_MUL_VAL_ 1 Low Top 1-1;\nSG_MUL_VAL_ 1 A Top 0-0;\nSG_MUL_VAL_ 1 B Low 2-2;\nSG_MUL_VAL_ 1 C Low 5-5;\n";

#[test]
fn a_multiplexer_below_another_goes_on_when_it_was_sent() {
    let text = "name = \"d\"\ndbc = \"d.dbc\"\nnode = \"D\"\nmessage.M.period_s = 1\n\
                signal.A.expression = 3\nsignal.B.expression = 4\nsignal.C.expression = 5\n";
    let description = |more: &str| {
        Description::parse("d.toml", &format!("{text}{more}"), &mut |_| Ok(NESTED.to_owned()))
    };
    let free = description("").unwrap();
    let mut device = Device::new(Arc::new(free.clone()), 1);
    let sent = listed(free.layout(), &run(&mut device, 5.0));
    assert_eq!(
        sent,
        [
            "1 M [0.0, NaN, 3.0, NaN, NaN]",
            "2 M [1.0, 2.0, NaN, 4.0, NaN]",
            "3 M [0.0, NaN, 3.0, NaN, NaN]",
            "4 M [1.0, 5.0, NaN, NaN, 5.0]",
            "5 M [0.0, NaN, 3.0, NaN, NaN]",
        ]
    );
    // A multiplexer driven to a constant never selects the other pages.
    let error = description("signal.Top.expression = 0\n").unwrap_err();
    assert_eq!(
        error.message(),
        "`B` is never sent: it is in frames whose `Top` is 1, and that is always 0"
    );
    assert!(description("signal.Top.expression = \"t % 2\"\n").is_ok());
}
