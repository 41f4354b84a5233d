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

/// Found by a user: the run ended with a limit, and nothing said that nobody had been there.
#[test]
fn a_pty_that_nobody_opens_is_named_with_its_node() {
    let (folder, out) = out("nobody");
    let file = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, text).unwrap();
        path
    };
    file(
        "beat.dbc",
        "VERSION \"\"\nBU_: Beat\nBO_ 291 Beat: 1 Beat\n SG_ Count : 0|8@1+ (1,0) [0|0] \"\" Vector__XXX\n",
    );
    file(
        "rigs/beat.toml",
        "title = \"A program that somebody starts\"\n[[line]]\nname = \"can0\"\n\
         can = { bit_rate = 500_000, dbc = \"../beat.dbc\" }\n[[node]]\nname = \"beat\"\nat = \"can0\"\n\
         under_test = { attached = true }\n",
    );
    let plan = file(
        "beats.toml",
        "name = \"beats\"\ntitle = \"\"\nrig = \"beat\"\nsteps = [{ wait = { duration_s = 0.2 } }]\n\
         [[measurement]]\nname = \"count\"\ndoc = \"\"\nquantity = \"beat.Count\"\nunit = \"1\"\n\
         check = { all_within = { at_least = 0 } }\n",
    );
    let pty = folder.path().join("can.pty");
    let bench = format!("[line.can0]\nport = \"slcan-pty:{}\"\n", pty.display());
    let bench = file("bench.toml", &bench);
    let arguments =
        ["run", plan.to_str().unwrap(), "--clock", "real", "--bench", bench.to_str().unwrap()];
    let output = run(&arguments, &out);
    assert_ne!(output.status.code(), Some(0), "{}", shown(&output));
    let note =
        format!("nobody opened {}, the pty of can0: `beat` was expected there", pty.display());
    let summary = summary(&out);
    assert!(summary["notes"].as_array().unwrap().iter().any(|told| *told == *note), "{summary}");
}
