//! Every generated project runs as it is.

use super::{Template, from_dbc, from_eds, restbus, write};
use harness::operator::Answers;
use harness::run::{Prepared, simulate};
use plan::Name;
use plan::made::Made;
use record::outcome::Outcome;
use record::sink::NullSink;
use std::path::Path;

const K2A: &str = include_str!("../../../../wire/dbc/k2a.dbc");

fn plans(folder: &Path) -> Vec<String> {
    let names = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut plans: Vec<String> = names
        .filter(|path| path.extension().is_some_and(|extension| extension == "toml"))
        .map(|path| path.display().to_string())
        .collect();
    plans.sort();
    plans
}

/// Returns the outcome of each plan of the project, by its checks.
fn outcomes(folder: &Path) -> Vec<(String, Outcome)> {
    let outcome = |plan: &String| {
        let prepared = Prepared::load(plan, &Made::default());
        let prepared = prepared.unwrap_or_else(|error| panic!("{plan}: {error:?}"));
        let run = simulate(&prepared, 1, &Answers::default(), &mut NullSink, &mut |_| true);
        let (measurements, judged) =
            judge::checks::judge_all(&prepared.plan.measurements, &run.observations);
        assert_eq!(run.ending.outcome, Outcome::Passed, "{plan}: {:?}", run.ending);
        assert!(judged == Outcome::Passed, "{plan}: {measurements:#?}");
        (prepared.plan.name.to_string(), judged)
    };
    plans(folder).iter().map(outcome).collect()
}

#[test]
fn each_template_runs_under_any_name_and_passes() {
    let folder = tempfile::tempdir().unwrap();
    for (template, plan) in [(Template::Can, "noisy-bus"), (Template::Serial, "noisy-line")] {
        // `Host` is the other node of the DBC.
        for name in ["oven-2", "host"] {
            let at = folder.path().join(plan).join(name);
            write(&at, &template.files(&Name::new(name).unwrap())).unwrap();
            let names: Vec<String> = outcomes(&at).into_iter().map(|(name, _)| name).collect();
            assert_eq!(names, [plan, "safe-alone", "settles"]);
        }
    }
}

#[test]
fn a_project_of_a_dbc_passes_too() {
    let folder = tempfile::tempdir().unwrap();
    let name = Name::new("base").unwrap();
    let node = K2A.lines().find_map(|line| line.strip_prefix("BU_:")).unwrap();
    for node in node.split_whitespace() {
        let at = folder.path().join(node);
        let made = from_dbc(&name, "k2a.dbc", K2A.as_bytes(), Some(node)).unwrap();
        write(&at, &made.files).unwrap();
        assert_eq!(outcomes(&at).len(), 1, "{node}");
    }
}

/// 20,000 signals: with a search through all of them for each, this took minutes.
#[test]
fn a_project_of_a_large_dbc_can_be_read() {
    use std::fmt::Write as _;
    let mut dbc = "BU_: ECU TOOL\n".to_owned();
    for number in 0..5_000u32 {
        let (id, sender) = ((1 << 31) + number, if number % 4 == 0 { "TOOL" } else { "ECU" });
        let _ = writeln!(dbc, "BO_ {id} Message_{number}: 8 {sender}");
        for signal in 0..4 {
            let start = 16 * signal;
            let _ = writeln!(
                dbc,
                " SG_ Signal_{number}_{signal} : {start}|16@1+ (0.1,0) [0|6553.5] \"V\" TOOL"
            );
        }
        let _ = writeln!(dbc, "CM_ SG_ {id} Signal_{number}_0 \"doc\";");
    }
    dbc += "BA_DEF_DEF_ \"GenMsgCycleTime\" 5000;\n";
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path().join("large");
    let made = from_dbc(&Name::new("large").unwrap(), "large.dbc", dbc.as_bytes(), Some("ECU"));
    write(&at, &made.unwrap().files).unwrap();
    let plan = at.join("talks.toml");
    let prepared = Prepared::load(plan.to_str().unwrap(), &Made::default()).unwrap();
    assert_eq!(prepared.plan.measurements.len(), 3_750 * 5);
    // A plan has no room for all that the device receives.
    assert_eq!(prepared.plan.steps.len(), plan::STEPS_MAX);
}

#[test]
fn a_plan_has_as_many_measurements_as_can_be_read() {
    use super::from_dbc::{Measured, PLAN_LEN_MAX};
    use super::traffic::Waits;
    let layout = described::Layout::from_dbc("k2a.dbc", K2A, "BASE").unwrap();
    let message = &layout.messages()[0];
    for (length, is_measured) in [(0, true), (PLAN_LEN_MAX - 10, false)] {
        let mut plan = "#".repeat(length);
        let mut measured = Measured::new(&mut plan, 10.0);
        measured.add((None, &layout, &Waits::of(&layout)), message, wire::time::Span::ZERO);
        measured.finish();
        assert_eq!(plan.contains("[[measurement]]"), is_measured);
        assert_eq!(plan.contains("1 more messages are not measured"), !is_measured);
        assert!(plan.len() < plan::FILE_LEN_MAX);
    }
}

/// Removes the bench, which needs a real device.
fn without_bench(folder: &Path) {
    std::fs::remove_file(folder.join("bench.toml")).unwrap();
}

#[test]
fn the_rest_of_a_bus_runs_and_passes() {
    let folder = tempfile::tempdir().unwrap();
    let dbc = include_bytes!("../../../../wire/dbc/k2a.dbc");
    let name = Name::new("rest").unwrap();
    for (dbc, real) in [(&dbc[..], "BASE"), (&dbc[..], "HOST"), (HARD, "TOOL")] {
        let at = folder.path().join(real);
        let real = [real.to_owned()];
        let made = restbus(&name, "bus.dbc", dbc, &real).unwrap_or_else(|error| panic!("{error}"));
        write(&at, &made.files).unwrap();
        let bench = Prepared::load(at.join("bench.toml").to_str().unwrap(), &Made::default());
        assert_eq!(bench.unwrap().rig.nodes.len(), 2);
        without_bench(&at);
        assert_eq!(outcomes(&at), [("rest".to_owned(), Outcome::Passed)]);
    }
    let alone = restbus(&name, "bus.dbc", b"BO_ 1 M: 8 One", &["One".to_owned()]).unwrap_err();
    assert_eq!(alone.to_string(), "bus.dbc has no other node that sends messages");
    let nobody = restbus(&name, "bus.dbc", HARD, &["Toll".to_owned()]).unwrap_err();
    assert!(nobody.to_string().contains("no node `Toll`"), "{nobody}");
}

/// Found by a user: a message that is sent on an event alone failed a sound device.
#[test]
fn what_may_be_an_event_is_not_asked_of_a_real_device() {
    let dbc = include_bytes!("../../../../examples/battery-pack/devices/pack.dbc");
    let name = Name::new("rest").unwrap();
    let made = restbus(&name, "pack.dbc", dbc, &["Manager".to_owned()]).unwrap();
    let file = |name: &str| {
        let found = made.files.iter().find(|file| file.path == Path::new(name)).unwrap();
        String::from_utf8(found.bytes.clone()).unwrap()
    };
    let bench = file("bench.toml");
    assert!(bench.contains("period.manager.ManagerCommand"), "{bench}");
    assert!(!bench.contains("manager.TripReport"), "{bench}");
    assert!(bench.contains("# TripReport is not measured: the DBC gives it no period"), "{bench}");
}

#[test]
fn the_rest_of_a_bus_has_as_many_nodes_as_a_rig() {
    use std::fmt::Write as _;
    let mut dbc = "BU_:".to_owned();
    (0..100).for_each(|node| _ = write!(dbc, " N{node}"));
    for id in 0..200u32 {
        let _ =
            write!(dbc, "\nBO_ {} M{id}: 8 N{}", id + 1, if id < 40 { id + 60 } else { id % 100 });
    }
    let folder = tempfile::tempdir().unwrap();
    let name = Name::new("many").unwrap();
    let made = restbus(&name, "many.dbc", dbc.as_bytes(), &["N1".to_owned()]).unwrap();
    assert_eq!(made.notes.len(), 40);
    assert!(!made.notes.iter().any(|note| note.message == "N1" || note.message == "N99"));
    write(folder.path(), &made.files).unwrap();
    let plan = folder.path().join("rest.toml");
    let prepared = Prepared::load(plan.to_str().unwrap(), &Made::default()).unwrap();
    assert_eq!(prepared.rig.nodes.len(), 59);
}

/// Most difficult features of a DBC, in the encoding that Vector's tools write.
const HARD: &[u8] = b"BU_: ECU TOOL
BO_ 100 Pages: 8 ECU
 SG_ Top M : 0|4@1+ (1,0) [0|1] \"\" TOOL
 SG_ Low m1M : 4|4@1+ (1,0) [0|0] \"\" TOOL
 SG_ Hot m0 : 8|16@1- (0.1,0) [-40|3.35] \"\xb0C\" TOOL
 SG_ Cold m1 : 8|16@1- (0.1,0) [5|60] \"\xb0C\" TOOL
 SG_ Far m2 : 8|16@1- (0.1,0) [60|5] \"\xb0C\" TOOL
 SG_ Same : 60|4@1+ (1,0) [0|0] \"\" TOOL
BO_ 101 Huge: 8 ECU
 SG_ Float : 0|64@1- (1,0) [0|0] \"\" TOOL
BO_ 102 Whole: 8 ECU
 SG_ 0_Bits : 7|64@0+ (1,0) [0|0] \"\" TOOL
BO_ 103 Fd: 64 ECU
 SG_ Same : 0|8@1+ (1,0) [0|0] \"\" TOOL
BO_ 200 Told: 8 TOOL
 SG_ Group M : 0|8@1+ (1,0) [0|0] \"\" ECU
 SG_ Same m3 : 8|8@1+ (1,0) [3|9] \"\" ECU
 SG_ Other m4 : 8|64@1+ (1,0) [0|0] \"\" ECU
SG_MUL_VAL_ 100 Low Top 1-1;
SG_MUL_VAL_ 100 Hot Top 0-0, 4-9;
SG_MUL_VAL_ 100 Cold Low 1-1;
SG_MUL_VAL_ 100 Far Low 2-15;
SIG_VALTYPE_ 101 Float : 2;
";

#[test]
fn a_project_of_a_hard_dbc_passes_too() {
    let folder = tempfile::tempdir().unwrap();
    let name = Name::new("hard").unwrap();
    for node in ["ECU", "TOOL"] {
        let at = folder.path().join(node);
        let made = from_dbc(&name, "hard.dbc", HARD, Some(node)).unwrap();
        assert_eq!(made.notes.len(), 3, "{:#?}", made.notes);
        write(&at, &made.files).unwrap();
        assert_eq!(outcomes(&at).len(), 1, "{node}");
        assert_eq!(std::fs::read(at.join("devices/hard.dbc")).unwrap(), HARD);
    }
    let several = from_dbc(&name, "hard.dbc", HARD, None).unwrap_err();
    assert_eq!(several.to_string(), "hard.dbc has 2 nodes that send messages");
    let dumb = b"BU_: A B\nBO_ 1 M: 8 A\nBO_ 2 N: 0 B\n";
    let received = from_dbc(&name, "two.dbc", dumb, Some("A")).unwrap();
    assert!(received.files[1].text().contains("# Received: N.\n"), "{:?}", received.files[1]);
    let nobody = from_dbc(&name, "one.dbc", b"BO_ 1 M: 8 Vector__XXX", None).unwrap();
    assert!(nobody.files.iter().any(|file| file.text().contains("node = \"Vector__XXX\"")));
}

#[test]
fn a_project_of_an_eds_passes() {
    let folder = tempfile::tempdir().unwrap();
    let name = Name::new("axis").unwrap();
    let eds = include_bytes!("../../../../examples/rotary-table/devices/drive.eds");
    // A name in Latin-1, and another node.
    let latin = String::from_utf8_lossy(eds).replace("Description=Rotary", "Description=R\u{1}");
    let latin: Vec<u8> = latin.bytes().map(|byte| if byte == 1 { 0xFC } else { byte }).collect();
    for (bytes, node) in [(&eds[..], None), (&latin[..], Some(127))] {
        let at = folder.path().join(format!("{node:?}"));
        let made = from_eds(&name, "drive.eds", bytes, node).unwrap();
        write(&at, &made.files).unwrap();
        assert_eq!(outcomes(&at).len(), 1, "{node:?}");
        // The boot-up and the heartbeats, the PDO of the event timer, and the one of each SYNC.
        let plan = std::fs::read_to_string(at.join("talks.toml")).unwrap();
        let talks = [58, 1, 54, 270].map(|least| format!("observations_min = {least}\n"));
        assert!(talks.iter().all(|least| plan.contains(least)), "{plan}");
        let silent = format!(
            "{plan}[[fault]]\ntarget = \"device\"\nwhat = {{ drop = {{ loss_percent = 100 }} }}\nwhen = {{ at_s = 1 }}\n"
        );
        std::fs::write(at.join("talks.toml"), silent).unwrap();
        let prepared = Prepared::load(&plans(&at)[0], &Made::default()).unwrap();
        let run = simulate(&prepared, 1, &Answers::default(), &mut NullSink, &mut |_| true);
        let (found, _) = judge::checks::judge_all(&prepared.plan.measurements, &run.observations);
        let missed = found.iter().filter(|one| one.statistic.contains("are needed")).count();
        assert_eq!(missed, found.len() - 1, "only the device type was said before: {found:#?}");
    }
    let cut = from_eds(&name, "drive.eds", &eds[..9_000], None).unwrap_err();
    assert!(cut.message().contains("the file has no section"), "{cut}");
}

#[test]
fn nothing_is_written_over() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("mine.txt"), "mine").unwrap();
    let error = write(folder.path(), &Template::Can.files(&Name::new("oven").unwrap()));
    assert_eq!(error.unwrap_err().to_string(), "the folder is not empty");
}
