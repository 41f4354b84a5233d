//! Packets of one write arrive at one instant: each of them counts.

use tests::project;

const DRIVE: &str = r#"
name = "drive"
title = "It takes a duty cycle"
[serial]
baud = 19200
[[message]]
name = "Drive"
sent_by = "host"
start = [0x55]
fields = [{ name = "Duty", type = "u8", unit = "%" }]
initial = { Duty = 0 }
[[message]]
name = "Reading"
sent_by = "device"
start = [0x56]
fields = [{ name = "At", type = "u8", unit = "%" }]
period_s = 0.1
[signal.At]
expression = "Drive.Duty"
"#;

const RIG: &str = r#"
title = "A drive and its program"
[[line]]
name = "uart"
serial = {}
[[node]]
name = "drive"
at = "uart"
emulate = "drive"
[[node]]
name = "program"
at = "uart"
under_test = { command = ["python3", "-c", '''
import os, sys, time, tty
port = os.open(sys.argv[1], os.O_RDWR | os.O_NOCTTY)
tty.setraw(port)
while True:
    os.write(port, bytes([0x55, 100, 0x55, 0]))
    time.sleep(0.2)
''', "{uart}"] }
"#;

const PLAN: &str = r#"
name = "twice"
title = "The program drives, and stops in the same write"
rig = "drives"
steps = [{ wait = { duration_s = 1 } }]
[[property]]
name = "rests"
always = "program.Duty <= 50 %"
[[property]]
name = "drives"
sometimes = "program.Duty > 50 %"
[[reaction]]
name = "stop"
from = "program.Duty > 50 %"
to = "program.Duty == 0 %"
[[measurement]]
name = "stop"
doc = "From driving to rest"
quantity = "reaction.stop"
unit = "s"
check = { all_within = [0, 0.001] }
observations_min = 4
"#;

/// Found by a user: only the last value of an instant counted, and "rests" held while the same run measured 100 %.
#[test]
fn each_of_two_packets_in_one_write_is_judged() {
    let folder = project::of([
        ("devices/drive.toml", DRIVE),
        ("rigs/drives.toml", RIG),
        ("plan.toml", PLAN),
    ]);
    let run = project::load(&folder, "plan.toml").unwrap().run().unwrap();
    assert_eq!(run.property("rests").unwrap().held, Some(false), "{run}");
    assert_eq!(run.property("drives").unwrap().held, Some(true), "{run}");
    assert!(run.value("stop").unwrap() < 1e-6, "{run}");
}
