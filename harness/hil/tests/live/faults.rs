//! Faults and properties in real time: the same schedule, and what this bench can judge.

use crate::can::plan;
use crate::{hil, out, record, run, shown, summary};
use serde_json::Value;
use skips::in_time;

/// Short, with every property that can be declared without a limit.
const PLAN: &str = r#"
name = "struck"
title = "A metre and a quarter turn, and what goes wrong on the way"
devices = "paper-serial"
steps = [
    { bias_test = { duration_s = 2 } },
    # What was lost until now is said until a pose is set.
    { place = { x_m = 0, y_m = 0, heading_deg = 0 } },
    { straight = { distance_m = 1, speed_m_per_s = 0.4 } },
    { turn = { angle_deg = 45, rate_deg_per_s = 30 } },
]

[[measurement]]
name = "samples_lost"
doc = "Gyro samples lost on the way"
quantity = "samples.lost"
unit = "1"
check = { all_within = [0, 1e6] }
"#;

const PROPERTIES: &str = r#"
[[property]]
always = { fresh_heading = {} }
[[property]]
always = { stops_on_loss = {} }
[[property]]
always = { within_limits = {} }
[[property]]
always = { finite_outputs = {} }
[[property]]
always = { recovers = {} }
[[property]]
always = { done_is_done = {} }
[[property]]
sometimes = "gyro_silent"
[[property]]
sometimes = "samples_lost"
"#;

fn property<'a>(summary: &'a Value, name: &str) -> &'a Value {
    let all = summary["properties"].as_array().unwrap();
    all.iter().find(|one| one["name"] == name).unwrap_or_else(|| panic!("no {name}: {summary}"))
}

fn struck(summary: &Value, index: usize) -> (bool, u64) {
    let fault = &summary["faults"][index];
    (fault["begun"].as_bool().unwrap(), fault["acted"].as_u64().unwrap())
}

#[test]
fn lines_devices_and_the_host_are_struck_in_real_time() {
    in_time(|| {
        let faults = r#"
[[fault]]
target = "gyro"
toward = "host"
what = { drop = { loss_percent = 1 } }
when = { during = "bias_test" }
[[fault]]
target = "base"
what = { wheel_slip = { slip_percent = 1 } }
when = { step = "straight", after_s = 0.5 }
[[fault]]
target = "host"
what = { scheduler_stall = { for_s = 0.03 } }
when = { at_s = 1 }
[[fault]]
target = "gyro"
what = { bias_step = { deg_per_h = 1 } }
when = { at_s = 1 }
duration_s = 1
[[fault]]
target = "gyro"
what = { disconnect = { for_s = 1 } }
when = { step = "turn", number = 1, after_s = 100 }
"#;
        let (folder, out) = out("struck");
        let plan = plan(folder.path(), &format!("{PLAN}{PROPERTIES}{faults}"));
        let plan = plan.to_str().unwrap();
        let output = run(
            &["run", plan, "--clock", "real", "--controller", "in-process", "--record", "full"],
            &out,
        );
        // No gyro was silent, which the plan asks for; all else holds.
        assert_eq!(output.status.code(), Some(1), "{}", shown(&output));
        let summary = summary(&out);
        for index in 0..4 {
            let (begun, acted) = struck(&summary, index);
            assert!(begun && acted > 0, "fault {index}: {}", summary["faults"]);
        }
        assert_eq!(struck(&summary, 4), (false, 0), "it waits for longer than the run");
        let record = record(&out);
        for told in [
            "fault 0 begins: drop of gyro",
            "fault 1 ends: wheel_slip of base",
            "fault 2 begins: scheduler_stall of host",
            "fault 4 never happened: disconnect of gyro",
        ] {
            assert!(record.contains(told), "{told}");
        }
        let judged = |name| {
            let one = property(&summary, name);
            assert_eq!(one["held"], true, "{one}");
            one["margin"].as_f64()
        };
        for always in ["fresh_heading", "stops_on_loss", "within_limits", "done_is_done"] {
            let margin = judged(always).unwrap_or_else(|| panic!("{always} had nothing to judge"));
            assert!((0.0..1.0).contains(&margin), "{always}: {margin}");
        }
        assert_eq!(judged("finite_outputs"), Some(1.0));
        assert_eq!(judged("samples_lost"), None);
        assert_eq!(property(&summary, "gyro_silent")["held"], false);
    });
}

/// The gyro is unplugged while the robot drives. A controller in a separate process reports it, and stops in time.
#[test]
fn a_plug_that_is_out_is_noticed_by_a_process_and_the_properties_say_so() {
    in_time(|| {
        let fault = "\n[[fault]]\ntarget = \"gyro\"\nwhat = { disconnect = { for_s = 60 } }\n\
                 when = { step = \"straight\", after_s = 1 }\n";
        let (folder, out) = out("unplugged");
        let plan = plan(folder.path(), &format!("{PLAN}{PROPERTIES}{fault}"));
        let output = run(&["run", plan.to_str().unwrap(), "--clock", "real"], &out);
        assert_eq!(output.status.code(), Some(1), "{}", shown(&output));
        let summary = summary(&out);
        assert!(struck(&summary, 0).0, "{summary}");
        assert_eq!(property(&summary, "gyro_silent")["held"], true, "{summary}");
        let stops = property(&summary, "stops_on_loss");
        assert_eq!(stops["held"], true, "{stops}");
        assert!(stops["margin"].as_f64().unwrap() < 0.9, "{stops}");
        // JSON lines of a process cannot be judged; every place that shows verdicts states that.
        let finite = property(&summary, "finite_outputs");
        assert!(finite.get("held").is_none(), "{finite}");
        assert!(shown(&output).contains("finite_outputs not judged: "), "{}", shown(&output));
        for file in ["report.html", "junit.xml"] {
            let text = std::fs::read_to_string(out.join(file)).unwrap();
            assert!(text.contains("line of JSON"), "{file}");
        }
    });
}

const BUS: &str = r#"
name = "bus"
title = "A straight on a bus that is at fault"
devices = "paper"
steps = [
    { place = { x_m = 0, y_m = 0, heading_deg = 0 } },
    { bias_test = { duration_s = 4 } },
    { straight = { distance_m = 0.5, speed_m_per_s = 0.4 } },
]

[[measurement]]
name = "samples_lost"
doc = "Gyro samples lost on the way"
quantity = "samples.lost"
unit = "1"
check = { all_within = [0, 1e6] }

[[fault]]
target = "base"
what = { bit_errors = { bit_error_rate = 0.05 } }
when = { during = "bias_test" }
duration_s = 1
[[fault]]
target = "base"
what = { bus_load = { load_percent = 30 } }
when = { during = "straight" }

[[property]]
sometimes = "bus_off"
[[property]]
always = { stops_on_loss = {} }
[[property]]
always = { within_limits = {} }
"#;

#[test]
fn a_bus_behind_an_adapter_is_struck() {
    in_time(|| {
        bus_is_struck("slcan");
    });
}

/// A base on CAN: bit errors until a node leaves the bus, and other nodes that send.
pub fn bus_is_struck(bus: &str) {
    let (folder, out) = out("bus");
    let plan = plan(folder.path(), BUS);
    let plan = plan.to_str().unwrap();
    let arguments = ["run", plan, "--clock", "real", "--bus", bus, "--record", "full"];
    let output = run(&arguments, &out);
    assert_eq!(output.status.code(), Some(0), "{}", shown(&output));
    let summary = summary(&out);
    for index in 0..2 {
        let (begun, acted) = struck(&summary, index);
        assert!(begun && acted > 0, "fault {index}: {}", summary["faults"]);
    }
    assert_eq!(property(&summary, "bus_off")["held"], true, "{summary}");
    assert_eq!(property(&summary, "stops_on_loss")["held"], true, "{summary}");
    let record = record(&out);
    assert!(record.contains("base is bus-off"), "no node left the bus");
    // Frames of a sender outside the bench.
    assert!(record.lines().any(|line| line.contains(" plan       frame ")), "no stranger's frame");
}

#[test]
fn a_property_that_breaks_in_real_time_fails_the_run() {
    in_time(|| {
        let fault = "\n[[property]]\nalways = { done_is_done = { distance_m_max = 0.05 } }\n\
                 [[fault]]\ntarget = \"base\"\nwhat = { wheel_slip = { slip_percent = 30 } }\n";
        let (folder, out) = out("slips");
        let plan = plan(folder.path(), &format!("{PLAN}{fault}"));
        let output = run(&["run", plan.to_str().unwrap(), "--clock", "real"], &out);
        assert_eq!(output.status.code(), Some(1), "{}", shown(&output));
        let summary = summary(&out);
        assert_eq!(property(&summary, "done_is_done")["held"], false, "{summary}");
        assert!(summary["reason"].as_str().unwrap().contains("broke done_is_done at"), "{summary}");
    });
}

#[test]
fn what_cannot_be_struck_is_refused_before_the_run() {
    let clock = "\n[[fault]]\ntarget = \"host\"\nwhat = { clock_step = { step_s = 1 } }\n";
    let drop = "\n[[fault]]\ntarget = \"gyro\"\nwhat = { drop = { loss_percent = 1 } }\n";
    let (folder, out) = out("refused");
    let bench = folder.path().join("bench.toml");
    std::fs::write(&bench, "[gyro]\nport = \"/dev/there-is-no-such-port\"\n").unwrap();
    for (fault, rest, said) in [
        (clock, vec!["--controller", "process"], "failed to inject fault 0, clock_step of host"),
        (drop, vec!["--bench", bench.to_str().unwrap()], "the gyro is real"),
    ] {
        let plan = plan(folder.path(), &format!("{PLAN}{fault}"));
        let mut run = hil();
        run.args(["run", plan.to_str().unwrap(), "--clock", "real"]).args(rest);
        let output = run.arg("--out").arg(&out).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{}", shown(&output));
        assert!(shown(&output).contains(said), "{}", shown(&output));
        assert!(!out.exists(), "nothing ran");
    }
}
