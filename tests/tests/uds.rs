//! Diagnostics of an emulated device, with the plan as the client and with stacks of somebody else at either end, in
//! virtual time.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use harness::TrialRun;
use std::process::Command;
use tests::project;

const PAGE: &str = include_str!("../../docs/uds.md");

/// The device and the plan of the page.
fn page(block: usize) -> &'static str {
    PAGE.split("```toml\n").nth(block).unwrap().split("```").next().unwrap()
}

/// Returns a Python with udsoncan and can-isotp, if there is one.
fn python() -> Option<String> {
    let python = std::env::var("HIL_TESTS_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let loaded = Command::new(&python).args(["-c", "import can, isotp, udsoncan"]).output();
    if loaded.is_ok_and(|loaded| loaded.status.success()) {
        return Some(python);
    }
    let why = format!("{python} has no udsoncan and can-isotp");
    let how = "tests/interop/README.md says how to install them";
    skips::skip_unless("HIL_TESTS_NEED_PYTHON", why, how);
    None
}

fn run(files: &[(&str, &str)], plan: &str) -> TrialRun {
    let mut all = vec![("plan.toml", plan)];
    all.extend(files);
    project::load(&project::of(all), "plan.toml").unwrap().run().unwrap()
}

/// The plan of the page with other steps, which alone judge unless `rest` does.
fn plan(steps: &str, rest: &str) -> String {
    format!("name = \"p\"\ntitle = \"p\"\ndevice = \"heater\"\nsteps = [{steps}]\n{rest}")
}

#[test]
fn the_plan_of_the_page_passes() {
    let run = run(&[("devices/heater.toml", page(1))], page(2));
    assert!(run.passed(), "{run}");
    // Found by a user: "sent 13 frames of UdsResponse with more bytes than it has".
    let notes = &run.summary().notes;
    assert!(!notes.iter().any(|note| note.contains("bytes")), "{notes:?}");
}

#[test]
fn another_response_fails_the_run() {
    let read = |expected: &str| {
        let step = format!("{{ uds = {{ request = [0x22, 1, 1], {expected} }} }}");
        run(&[("devices/heater.toml", page(1))], &plan(&step, ""))
    };
    assert!(read("expect = { data = [0x62, 1, 1, 60] }").passed());
    for (step, reason) in [
        (
            "request = [0x22, 9, 9]",
            "expected a positive response, and 7F 22 31 (requestOutOfRange) came",
        ),
        (
            "request = [0x22, 1, 1], expect = { negative = 0x33 }",
            "expected 0x33 (securityAccessDenied), and 62 01 01 3C came",
        ),
        ("request = [0x3E, 0x80]", "expected a positive response, and no response came"),
        (
            "request = [0x22, 1, 1], read = { name = \"x\", type = \"u16\" }",
            "62 01 01 3C is too short for `x`",
        ),
        (
            "request = [0x22, 1, 0], read = { name = \"x\", type = \"u8\" }",
            "is longer than `x`; `at` picks a part",
        ),
        (
            "request = [0x27, 1], key = \"seed\"",
            "expected a positive response, and 7F 27 35 (invalidKey) came",
        ),
    ] {
        let run = run(
            &[("devices/heater.toml", page(1))],
            &plan(&format!("{{ uds = {{ {step} }} }}"), ""),
        );
        assert!(!run.passed());
        assert!(run.to_string().contains(reason), "{run}");
    }
}

/// Each takes 0.3 s: a routine whose response is suppressed, and the second identifier of a read.
#[test]
fn what_takes_its_time_takes_it_in_every_request() {
    let heater = page(1)
        .replace("delay_s = \"slow\"\n", "")
        .replace("access = { sessions = [\"extended\"] }\n", "delay_s = 0.3\n")
        .replace("value = \"setpoint\"\n", "value = \"setpoint\"\ndelay_s = 0.3\n")
        .replace("[uds.service.write_data]\ndelay_s = 0.3\n", "");
    for request in ["0x31, 0x81, 2, 3", "0x22, 1, 0, 1, 1"] {
        let step = format!("{{ uds = {{ request = [{request}] }}, label = \"slow\" }}");
        let measured = "[[measurement]]\nname = \"slow\"\ndoc = \"slow\"\nquantity = \"step.duration\"\n\
                        where = { \"during.slow\" = 1 }\nunit = \"s\"\ncheck = { all_within = [0.3, 0.31] }\n";
        let run = run(&[("devices/heater.toml", &heater)], &plan(&step, measured));
        assert!(run.passed(), "{request}: {run}");
    }
}

#[test]
fn faults_strike_the_frames_of_a_response() {
    let read = "{ uds = { request = [0x22, 0xF1, 0x90] } }";
    for (what, reason) in [
        ("drop = { loss_percent = 100 }", "no response came"),
        ("duplicate = { duplicate_percent = 100 }", "a consecutive frame out of sequence"),
        ("delay = { by_s = 1.5 }", "no response came"),
    ] {
        let fault = format!("[[fault]]\ntarget = \"device.UdsResponse\"\nwhat = {{ {what} }}\n");
        let run = run(&[("devices/heater.toml", page(1))], &plan(read, &fault));
        assert!(!run.passed() && run.to_string().contains(reason), "{what}: {run}");
    }
    // A flow control that comes too late: the tester gives up its long request.
    let slow = page(1).replace("reset_s = 0.2", "flow_control_delay_s = \"slow\"\nreset_s = 0.2");
    let late = "{ set_parameter = { parameter = \"device.slow\", value = 1.5 } }, \
                { uds = { request = [0x22, 1, 1, 1, 1, 1, 1, 1, 1] } }";
    let run_late = run(&[("devices/heater.toml", &slow)], &plan(late, ""));
    assert!(
        !run_late.passed() && run_late.to_string().contains("no flow control within N_Bs"),
        "{run_late}"
    );
    let unharmed = run(&[("devices/heater.toml", page(1))], &plan(read, ""));
    assert!(unharmed.passed(), "{unharmed}");
}

#[test]
fn mistakes_of_a_plan_are_found_before_the_run() {
    for (step, message) in [
        ("node = \"other\", request = [1]", "no node `other` in this rig"),
        ("request = []", "a request of 0 bytes, expected 1 to 4095"),
        ("request = [0x27, 1], key = \"sed\"", "no variable `sed`"),
    ] {
        let plan = plan(&format!("{{ uds = {{ {step} }} }}"), "");
        let folder = project::of([("plan.toml", plan.as_str()), ("devices/heater.toml", page(1))]);
        let error = project::load(&folder, "plan.toml").unwrap_err();
        let error =
            std::error::Error::source(&error).map_or(error.to_string(), ToString::to_string);
        assert!(error.contains(message), "{error}");
    }
}

fn rig(line: &str, nodes: &str) -> String {
    format!("title = \"A rig\"\n[[line]]\nname = \"can0\"\ncan = {{ {line} }}\n{nodes}")
}

#[test]
fn a_client_of_somebody_else_is_content_with_the_server() {
    let Some(python) = python() else { return };
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/interop/uds_client.py");
    // Each read takes longer than P2. The message says which setpoint was written.
    let heater = page(1).replace("delay_s = \"slow\"", "delay_s = 0.3").replace(
        "fields = [{",
        "fields = [{ name = \"Setpoint\", type = \"u8\", unit = \"degC\" }, {",
    ) + "\n[signal.Setpoint]\nexpression = \"setpoint\"\n";
    let fd = heater.replace(
        "request_id = 0x7E0, response_id = 0x7E8, padding = 0xCC",
        "normal_fixed = { server = 0x10, tester = 0xF1 }, fd = 64, block_size = 4, st_min_s = 0.0005",
    );
    for (mode, heater, line) in
        [("classic", heater, ""), ("fd", fd, "bit_rate = 500_000, data_bit_rate = 2_000_000")]
    {
        let nodes = format!(
            "[[node]]\nname = \"ecu\"\nat = \"can0\"\nemulate = \"heater\"\n[[node]]\nname = \"client\"\nat = \"can0\"\n\
             under_test = {{ command = [\"{python}\", \"{script}\", \"{{can0}}\", \"{mode}\"] }}\n"
        );
        let plan = "name = \"p\"\ntitle = \"p\"\nrig = \"bench\"\nsteps = [{ wait_until = { above = { quantity = \
                    \"ecu.Setpoint\", limit = 76.5 } }, time_limit_s = 60 }]\n[[measurement]]\nname = \"m\"\ndoc = \"m\"\n\
                    quantity = \"step.duration\"\nunit = \"s\"\ncheck = { all_within = [0, 60] }\n";
        let files =
            [("devices/heater.toml", heater.as_str()), ("rigs/bench.toml", &rig(line, &nodes))];
        let run = run(&files, plan);
        assert!(run.passed(), "{mode}: {run}");
    }
}

#[test]
fn a_plan_asks_a_server_of_somebody_else() {
    let Some(python) = python() else { return };
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/interop/uds_server.py");
    let nodes = format!(
        "[[node]]\nname = \"ecu\"\nat = \"can0\"\nunder_test = {{ command = [\"{python}\", \"{script}\", \"{{can0}}\"] }}\n\
         isotp = {{ request_id = 0x7E0, response_id = 0x7E8, block_size = 4, st_min_s = 0.001 }}\n\
         [[node]]\nname = \"tester\"\nat = \"can0\"\ntester = true\n"
    );
    let steps = r#"
        { wait = { duration_s = 2 } },
        { uds = { node = "ecu", request = [0x22, 0xF1, 0x90], expect = { text = "WPYTHON0000000042" } } },
        { uds = { node = "ecu", request = [0x27, 1], key = "bit_xor(seed, 0xF0F0F0F0)" } },
        { uds = { node = "ecu", request = [0x31, 1, 2, 3], read = { name = "result", type = "i16", scale = 0.1, unit = "V", at = 4 } }, label = "routine" },
        { uds = { node = "ecu", request = [0x99, 1], expect = { negative = 0x11 } } },
        { uds = { node = "ecu", request = [0x2E, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27, 28, 29, 30, 31, 32, 33, 34, 35], expect = { data = [0x6E, 1, 2, 0, 36] } } },
    "#;
    let plan = format!(
        "name = \"p\"\ntitle = \"p\"\nrig = \"bench\"\nsteps = [{steps}]\n[[measurement]]\nname = \"result\"\ndoc = \"m\"\n\
         quantity = \"uds.result\"\nunit = \"V\"\ncheck = {{ all_within = [30, 30] }}\n[[measurement]]\nname = \"time\"\n\
         doc = \"m\"\nquantity = \"step.duration\"\nwhere = {{ \"during.routine\" = 1 }}\nunit = \"s\"\n\
         check = {{ all_within = [2, 2.1] }}\n"
    );
    let run = run(&[("rigs/bench.toml", &rig("", &nodes))], &plan);
    assert!(run.passed(), "{run}");
}
