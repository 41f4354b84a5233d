//! Output for build servers and editors: working files in `ci/`, summaries, and schemas.

use super::hil::{Hil, Ran, TURN};
use std::fs;
use std::path::Path;

/// What installs and runs on GitHub, and the job of GitLab.
const ACTION: &str = "action.yml";
const GITLAB: &str = "ci/gitlab.yml";

fn text(file: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(file);
    let text = fs::read_to_string(path).unwrap();
    assert!(!text.contains('\t'), "{file}: YAML has no tabs");
    text
}

/// Shell scripts of a workflow: each command, or several that belong together.
fn scripts(file: &str) -> Vec<String> {
    let text = text(file);
    let depth = |line: &str| line.len() - line.trim_start().len();
    let mut lines = text.lines().filter(|line| !line.trim().starts_with('#')).peekable();
    let (mut scripts, mut in_list) = (Vec::new(), false);
    while let Some(line) = lines.next() {
        let said = line.trim();
        if said == "run: |" || (in_list && said == "- |") {
            let mut script = String::new();
            while let Some(next) = lines.next_if(|next| depth(next) > depth(line)) {
                script += &format!("{next}\n");
            }
            scripts.push(script);
        } else if let Some(script) = said.strip_prefix("run: ") {
            scripts.push(script.to_owned());
        } else if let Some(script) = said.strip_prefix("- ").filter(|_| in_list) {
            scripts.push(script.to_owned());
        } else {
            in_list = said == "script:";
        }
    }
    scripts
}

/// What `text` says of `key`, without quotes.
fn value<'a>(text: &'a str, key: &str) -> &'a str {
    let (_, after) = text.split_once(&format!("{key}: ")).unwrap();
    after.lines().next().unwrap().trim_matches('"')
}

/// The environment of the action's scripts: what the inputs are by default.
fn environment() -> Vec<(String, String)> {
    let text = text(ACTION);
    let (head, steps) = text.split_once("\nruns:\n").unwrap();
    let given = steps.lines().filter_map(|line| line.trim().split_once(": ${{ inputs."));
    let default = |input: &str| {
        let (_, declared) = head.split_once(&format!("\n  {input}:\n")).unwrap();
        value(declared, "default").to_owned()
    };
    given.map(|(name, input)| (name.to_owned(), default(input.trim_end_matches(" }}")))).collect()
}

/// A repository with plans in `plans`.
fn repository() -> Hil {
    let hil = Hil::new();
    hil.run(&["new", "oven"]).exits(0);
    fs::rename(hil.path("oven"), hil.path("plans")).unwrap();
    hil
}

/// Runs a script in the repository, with nothing of ours but the program.
fn execute(hil: &Hil, script: &str) -> Ran {
    let programs = Path::new(env!("CARGO_BIN_EXE_hil")).parent().unwrap();
    let known = std::env::var_os("PATH").unwrap_or_default();
    let path = [programs.to_owned()].into_iter().chain(std::env::split_paths(&known));
    let path = std::env::join_paths(path).unwrap();
    let mut shell = std::process::Command::new("bash");
    shell.args(["-e", "-c", script]).current_dir(hil.path(".")).envs(environment());
    shell.env("PATH", &path);
    Ran::of(shell.output().unwrap())
}

/// What runs after the installation, with the inputs of the action in their places.
fn commands(file: &str) -> Vec<String> {
    let scripts = scripts(file);
    let (install, others): (Vec<_>, Vec<_>) =
        scripts.iter().partition(|script| script.contains("pip install"));
    assert!(install.len() == 1 && others.len() == 3, "{file}: {scripts:?}");
    let command = |script: &String| {
        let mut script = script.replace("(exit $status)", "exit $status");
        for (name, value) in environment() {
            script = script.replace(&format!("\"${name}\""), &value);
            script = script.replace(&format!("${name}"), &value);
        }
        script.lines().map(str::trim).collect::<Vec<_>>().join("\n")
    };
    others.into_iter().map(command).collect()
}

#[test]
fn the_workflows_that_ship_do_what_they_say() {
    let commands = commands(ACTION);
    assert_eq!(commands, self::commands(GITLAB), "the same job");
    let hil = repository();
    for script in commands {
        // The campaigns find that the bus can be too noisy for the plan; the job is green.
        execute(&hil, &script).exits(0);
    }
    let found = fs::read_to_string(hil.path("campaigns/settles/junit.xml")).unwrap();
    assert!(found.contains("<failure"), "{found}");
    let junit = fs::read_dir(hil.path("runs")).unwrap();
    let junit = junit.filter(|run| run.as_ref().unwrap().path().join("junit.xml").is_file());
    assert_eq!(junit.count(), 3, "build servers read runs/*/junit.xml");
}

/// With `hil` on the PATH nothing is installed.
#[test]
fn the_action_is_one_that_github_takes() {
    let action = text(ACTION);
    assert_eq!(value(&action, "  using"), "composite");
    let steps = action.matches("\n    - name: ").count();
    assert_eq!(action.matches("\n      shell: bash\n").count(), steps, "each step names its shell");
    let install = &scripts(ACTION)[0];
    let ran = execute(&repository(), install).exits(0);
    assert!(ran.out.trim_end().ends_with("/hil") && ran.err.is_empty(), "{ran:?}");
    let workflow = text("ci/github.yml");
    assert!(workflow.contains("/hil@v1\n") && workflow.contains("\n          package: "));
}

/// The first plan fails without any fault, and the second has its campaign nevertheless; the job fails.
#[test]
fn a_plan_that_breaks_does_not_keep_the_others_from_their_campaigns() {
    let hil = repository();
    let plan = fs::read_to_string(hil.path("plans/settles.toml")).unwrap();
    for other in ["settles", "noisy-bus", "safe-alone"] {
        fs::remove_file(hil.path(format!("plans/{other}.toml"))).unwrap();
    }
    let short = plan.replace("duration_s = 300", "duration_s = 30").replace("2900", "290");
    for (name, short) in [("broken", short.replace("[58, 61]", "[61, 62]")), ("good", short)] {
        let named = short.replace("name = \"settles\"", &format!("name = \"{name}\""));
        fs::write(hil.path(format!("plans/{name}.toml")), named).unwrap();
    }
    let campaigns = commands(ACTION).pop().unwrap();
    let few = campaigns.replace("--cases 50", "--cases 2");
    assert_ne!(few, campaigns);
    let ran = execute(&hil, &few);
    assert_eq!(ran.status, Some(2), "{ran:?}");
    assert!(ran.err.contains("broken fails without any fault"), "{ran:?}");
    assert!(hil.path("campaigns/good/junit.xml").is_file(), "{ran:?}");
}

/// Runs `hil` as on GitHub.
fn on_github(hil: &Hil, arguments: &[&str]) -> Ran {
    let mut command = hil.command(arguments);
    command.env("GITHUB_ACTIONS", "true").env("GITHUB_STEP_SUMMARY", hil.path("summary.md"));
    Ran::of(command.output().unwrap())
}

#[test]
fn a_job_has_a_summary_and_mistakes_their_place() {
    let hil = Hil::with_plan(TURN);
    on_github(&hil, &["run", "turn.toml"]).exits(0);
    let passed = fs::read_to_string(hil.path("summary.md")).unwrap();
    assert!(passed.contains("### turn: passed") && passed.contains(r"| pass | stop\_error |"));

    fs::write(hil.path("turn.toml"), TURN.replace("[-5, 5]", "[4, 5]")).unwrap();
    let failed = on_github(&hil, &["run", "turn.toml"]).exits(1);
    assert!(
        failed.err.contains("::error file=turn.toml,line=1,title=turn%3A failed::"),
        "{failed:#?}"
    );
    let both = fs::read_to_string(hil.path("summary.md")).unwrap();
    assert!(both.starts_with(&passed) && both.contains(r"| **fail** | stop\_error |"), "{both}");

    fs::write(hil.path("turn.toml"), TURN.replace("bias_test", "bais_test")).unwrap();
    let wrong = on_github(&hil, &["run", "turn.toml"]).exits(2);
    assert!(
        wrong.err.contains("::error file=./turn.toml,line=6,")
            || wrong.err.contains("::error file=turn.toml,line=6,"),
        "{wrong:#?}"
    );
    let elsewhere = hil.run(&["run", "turn.toml"]).exits(2);
    assert!(!elsewhere.err.contains("::error"), "{elsewhere:#?}");
}

/// A build server takes the verdicts that it finds for those of this job.
#[test]
fn a_run_that_does_not_begin_leaves_no_verdicts_of_an_earlier_one() {
    let hil = Hil::with_plan(TURN);
    hil.run(&["run", "turn.toml"]).exits(0);
    hil.run(&["run", "turn.toml", "--out", "here"]).exits(0);
    hil.run(&["new", "oven"]).exits(0);
    let campaign = ["campaign", "oven/safe-alone.toml", "--cases", "1"];
    hil.run(&campaign);
    assert!(hil.path("runs/campaign-safe-alone-seed1/junit.xml").is_file());
    fs::create_dir(hil.path("foreign")).unwrap();
    fs::write(hil.path("foreign/junit.xml"), "<testsuites/>").unwrap();
    fs::write(hil.path("turn.toml"), TURN.replace("bias_test", "bais_test")).unwrap();
    hil.run(&["run", "turn.toml"]).exits(2);
    for folder in ["here", "foreign"] {
        hil.run(&["run", "turn.toml", "--out", folder]).exits(2);
    }
    fs::write(hil.path("oven/safe-alone.toml"), "steps = []").unwrap();
    hil.run(&["campaign", "oven/safe-alone.toml", "--envelopes"]).exits(2);
    let verdicts = hil.path("runs/campaign-safe-alone-seed1/junit.xml");
    assert!(verdicts.is_file(), "envelopes have a folder of their own");
    hil.run(&campaign).exits(2);
    for folder in ["runs/turn-seed1", "here", "runs/campaign-safe-alone-seed1"] {
        assert!(!hil.path(folder).join("junit.xml").exists(), "{folder}");
        assert!(hil.path(folder).join("report.html").is_file(), "{folder}");
    }
    assert!(hil.path("foreign/junit.xml").is_file(), "it is of no run");
}

#[test]
fn a_summary_goes_where_it_is_asked_for() {
    let hil = Hil::with_plan(TURN);
    hil.run(&["run", "turn.toml", "--summary", "here.md"]).exits(0);
    assert!(fs::read_to_string(hil.path("here.md")).unwrap().contains("### turn: passed"));
    let junit = fs::read_to_string(hil.path("runs/turn-seed1/junit.xml")).unwrap();
    assert!(junit.contains("[[ATTACHMENT|runs/turn-seed1/report.html]]"), "{junit}");
}

#[test]
fn schemas_and_pages_are_written_for_every_kind() {
    let hil = Hil::new();
    hil.run(&["schema", "--out", "schemas"]).exits(0);
    let printed = hil.run(&["schema", "plan"]).exits(0).out;
    assert_eq!(printed, fs::read_to_string(hil.path("schemas/plan.schema.json")).unwrap());
    assert!(hil.path("schemas/device.schema.json").is_file());
    hil.run(&["man", "--out", "man"]).exits(0);
    assert!(hil.path("man/hil-run.1").is_file());
    hil.run(&["schema"]).exits(2);
}
