//! A program that takes what one read returns for a whole packet passes as long as packets arrive whole.

use crate::uart_settings::run_on;
use harness::TrialRun;

const SENSOR: &str = r#"
name = "sensor"
title = "It sends ten readings a second, and hears an answer to each"
[serial]
baud = 19200
[[message]]
name = "Told"
sent_by = "host"
start = [0x55]
fields = [{ name = "Level", type = "u8" }]
initial = { Level = 0 }
checksum = "sum8"
[[message]]
name = "Reading"
sent_by = "device"
start = [0x56]
fields = [{ name = "Heard", type = "u8" }, { name = "Number", type = "u8" }]
period_s = 0.1
counter = { signal = "Number" }
checksum = "sum8"
[signal.Heard]
expression = "Told.Level"
"#;

const PLAN: &str = r#"
name = "split"
title = "Each reading is answered"
rig = "sets"
steps = [{ wait = { duration_s = 8.55 } }, { wait = { duration_s = 1.5 }, label = "late" }]
[[measurement]]
name = "answers"
doc = "What the program answers"
quantity = "program.Level"
unit = "1"
check = { all_within = [0, 100] }
observations_min = 98
[[measurement]]
name = "heard"
doc = "What the sensor heard"
quantity = "sensor.Heard"
unit = "1"
where = { "during.late" = 1 }
check = { all_within = [80, 100] }
observations_min = 10
"#;

const FRAMED: &str = "
    kept += os.read(port, 64)
    while len(kept) >= 4:
        answer(kept[:4])
        kept = kept[4:]
";

const ONE_READ: &str = "
    packet = os.read(port, 64)
    if len(packet) == 4:
        answer(packet)
";

fn run(reads: &str, fault: &str) -> TrialRun {
    let host = format!(
        "import os, sys, tty\n\
         port = os.open(sys.argv[1], os.O_RDWR | os.O_NOCTTY)\n\
         tty.setraw(port)\n\
         kept = b''\n\
         def answer(packet):\n    told = bytes([0x55, packet[2]])\n    os.write(port, told + told[1:])\n\
         while True:{reads}"
    );
    run_on(SENSOR, &host, &format!("{PLAN}{fault}"))
}

fn split(target: &str, toward: &str) -> String {
    format!(
        "\n[[fault]]\ntarget = \"{target}\"\ntoward = \"{toward}\"\nwhen = {{ at_s = 0 }}\n\
         what = {{ split = {{ split_percent = 50, late_s = 0.016 }} }}\n"
    )
}

#[test]
fn a_program_that_takes_a_read_for_a_packet_fails_where_packets_arrive_in_parts() {
    let late = split("sensor", "host");
    for (reads, fault, passes) in
        [(ONE_READ, "", true), (ONE_READ, &late, false), (FRAMED, "", true), (FRAMED, &late, true)]
    {
        let run = run(reads, fault);
        assert_eq!(run.passed(), passes, "{reads}{fault}: {run}");
    }
}

/// What an emulated device receives, and what a plan judges, is put together from its parts.
#[test]
fn parts_of_a_packet_to_a_device_are_put_together() {
    let run = run(FRAMED, &split("sensor", "device"));
    assert!(run.passed() && run.summary().faults[0].acted > 20, "{run}");
}
