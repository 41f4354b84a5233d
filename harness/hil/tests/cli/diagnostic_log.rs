//! Diagnostic requests of a plan, and what a log holds of their responses.

use super::hil::Hil;
use super::own_log::within;
use std::fs;

const ECU: &str = "name = \"ecu\"\ntitle = \"An ECU\"\n[signal.On]\nexpression = \"1\"\n\
    [[message]]\nname = \"Status\"\nsent_by = \"device\"\ncan_id = 0x100\nperiod_s = 0.1\n\
    fields = [{ name = \"On\", type = \"u8\" }]\n\
    [uds]\nisotp = { request_id = 0x7E0, response_id = 0x7E8 }\n\
    [uds.did.0xF190]\ntext = \"WECU0000000000042\"\n";

const ASKS: &str = "name = \"asks\"\ntitle = \"\"\nrig = \"ecu\"\nsteps = [{ wait = { duration_s = 1 } },\n\
    { uds = { node = \"ecu\", request = [0x22, 0xF1, 0x90], expect = { text = \"WECU0000000000042\" } } },\n\
    { wait = { duration_s = 1 } }]\n\
    [[measurement]]\nname = \"on\"\ndoc = \"\"\nquantity = \"ecu.On\"\nunit = \"1\"\ncheck = { all_within = [1, 1] }\n";

/// Found by a user: a log without any response passed.
#[test]
fn a_diagnostic_response_in_a_log_is_judged() {
    let hil = Hil::new();
    let nodes = "[[node]]\nname = \"ecu\"\nat = \"can0\"\nemulate = \"ecu\"\n\
        [[node]]\nname = \"desk\"\nat = \"can0\"\ntester = true\n";
    let rig = format!("[[line]]\nname = \"can0\"\ncan = {{}}\n{nodes}");
    for (path, text) in [("devices/ecu.toml", ECU), ("rigs/ecu.toml", &rig), ("asks.toml", ASKS)] {
        let path = hil.path(format!("oven/{path}"));
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
    within(&hil, &["run", "asks.toml", "--record", "full", "--out", "run"]).exits(0);
    within(&hil, &["export", "run", "--bus", "asks.log"]).exits(0);
    let import = |log: &str| within(&hil, &["import", log, "--plan", "asks.toml", "--out", "log"]);
    import("asks.log").exits(0);
    let log = fs::read_to_string(hil.path("oven/asks.log")).unwrap();
    let silent: String = log
        .lines()
        .filter(|line| !line.contains(" 7E8#"))
        .map(|line| line.to_owned() + "\n")
        .collect();
    fs::write(hil.path("oven/silent.log"), &silent).unwrap();
    let told = import("silent.log").exits(1).out;
    assert!(silent != log && told.contains("no response came"), "{told}");
    // The last characters of the number.
    let wrong = log.replace("303432", "303433");
    fs::write(hil.path("oven/wrong.log"), &wrong).unwrap();
    let told = import("wrong.log").exits(1).out;
    assert!(wrong != log && told.contains("expected \"WECU0000000000042\""), "{told}");
}

/// Found by a user: a node of a serial line before the tester was taken for the one that asks, and heard no response; and silence
/// took P2* in an import, where the run had waited for P2.
#[test]
fn a_log_tells_responses_and_silence_wherever_the_tester_stands_in_the_rig() {
    let hil = Hil::new();
    let meter = "name = \"meter\"\ntitle = \"\"\n[serial]\nbaud = 9600\n[[message]]\nname = \"Reading\"\n\
        sent_by = \"device\"\nstart = [0x56]\nfields = [{ name = \"Volume\", type = \"u8\" }]\nperiod_s = 0.5\n\
        [signal.Volume]\nexpression = \"7\"\n";
    let lines = "[[line]]\nname = \"can0\"\ncan = {}\n[[line]]\nname = \"uart\"\nserial = {}\n";
    let ecu = "[[node]]\nname = \"ecu\"\nat = \"can0\"\nemulate = \"ecu\"\n";
    let meter_node = "[[node]]\nname = \"meter\"\nat = \"uart\"\nemulate = \"meter\"\n";
    let desk = "[[node]]\nname = \"desk\"\nat = \"can0\"\ntester = true\n";
    let rig = format!("{lines}{meter_node}{ecu}{desk}");
    let silent = ASKS.replace("name = \"asks\"", "name = \"silent\"").replace(
        "request = [0x22, 0xF1, 0x90], expect = { text = \"WECU0000000000042\" }",
        "request = [0x3E, 0x80], expect = \"silence\", p2_s = 0.1",
    );
    assert!(silent.contains("0x3E"));
    for (path, text) in [
        ("devices/ecu.toml", ECU),
        ("devices/meter.toml", meter),
        ("rigs/ecu.toml", &rig),
        ("asks.toml", ASKS),
        ("silent.toml", &silent),
    ] {
        let path = hil.path(format!("oven/{path}"));
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
    // Found by a user: no rig was called as `hil list rigs` had it.
    let listed = within(&hil, &["list", "rigs"]).exits(0).out;
    let emulated = within(&hil, &["emulate", "rig", "ecu", "--line", "bus=slcan-pty"]).exits(2).err;
    assert!(
        listed.contains("ecu") && emulated.contains("lines of the rig: can0, uart"),
        "{emulated}"
    );
    for plan in ["asks", "silent"] {
        let (plan_file, log, run, out) = (
            format!("{plan}.toml"),
            format!("{plan}.pcapng"),
            format!("{plan}-run"),
            format!("{plan}-log"),
        );
        within(&hil, &["run", &plan_file, "--record", "full", "--out", &run]).exits(0);
        within(&hil, &["export", &run, "--bus", &log]).exits(0);
        within(&hil, &["import", &log, "--plan", &plan_file, "--out", &out]).exits(0);
    }
}
