//! A custom device in real time: emulated, with a port on its line.

use crate::{hil, out, run, shown, summary};
use hil::project::{Template, write};
use plan::Name;
use skips::in_time;
use std::path::Path;

fn project(folder: &Path, template: Template) {
    write(&folder.join("oven"), &template.files(&Name::new("oven").unwrap())).unwrap();
}

#[test]
fn an_emulated_one_is_tested_on_a_line_with_a_port() {
    in_time(|| {
        // On a bus, the port is for other programs; on a serial line, the plan has its other side.
        for (template, bus, ports) in
            [(Template::Can, "slcan-pty", 1), (Template::Serial, "pty", 2)]
        {
            let (folder, out) = out("own-device");
            project(folder.path(), template);
            let plan = folder.path().join("oven/safe-alone.toml");
            let output = run(&["run", plan.to_str().unwrap(), "--clock", "real"], &out);
            assert_eq!(output.status.code(), Some(0), "{}", shown(&output));
            let summary = summary(&out);
            assert_eq!(summary["bus"], bus, "{summary}");
            assert_eq!(summary["device_under_test"], "oven, emulated", "{summary}");
            assert_eq!(summary["ports"].as_array().unwrap().len(), ports, "{summary}");
        }
    });
}

#[test]
fn a_bench_that_does_not_fit_is_bad_input() {
    let (folder, out) = out("own-device");
    project(folder.path(), Template::Can);
    let plan = folder.path().join("oven/noisy-bus.toml");
    let refused = |bench: &str| {
        let file = folder.path().join("bench.toml");
        std::fs::write(&file, bench).unwrap();
        let mut run = hil();
        run.args(["run", plan.to_str().unwrap(), "--clock", "real", "--bench"]).arg(&file);
        let output = run.arg("--out").arg(&out).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{}", shown(&output));
        shown(&output)
    };
    let bytes = refused("[device]\nport = \"/dev/ttyS3\"\n");
    assert!(bytes.contains("needs a port for CAN frames"), "{bytes}");
    let real = refused("[device]\nport = \"slcan:/dev/ttyS3\"\n");
    assert!(real.contains("the device is real"), "{real}");
    // Found by a user: that an adapter carries no CAN FD showed only when it was opened, in the folder of a run.
    let dbc = folder.path().join("oven/devices/oven.dbc");
    let text = std::fs::read_to_string(&dbc).unwrap();
    std::fs::write(&dbc, text.replace("Status: 3 Oven", "Status: 12 Oven")).unwrap();
    let classic = refused("");
    assert!(classic.contains("CAN FD") && classic.contains("can:INTERFACE"), "{classic}");
    assert!(!out.exists(), "nothing is run");
}
