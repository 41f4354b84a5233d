//! Files that a rig names and that are not there.

use crate::rigs::{PACK, cells, load, project};
use harness::TrialError;
use harness::run::{PrepareError, RigError};
use plan::library::LibraryError;

#[test]
fn a_missing_file_is_shown_where_the_rig_names_it() {
    let emulate = "emulate = \"cells\"";
    let log = "replay = { log = \"none.log\" }";
    for (rig, at, said) in [
        (PACK.replace(emulate, "emulate = \"cellz\""), "\"cellz\"", "cellz"),
        (PACK.replace(emulate, log), log, "none.log"),
        (
            PACK.replace("pack.dbc", "none.dbc"),
            "can = { bit_rate = 250_000, dbc = \"../devices/none.dbc\" }",
            "none.dbc: No such file",
        ),
    ] {
        let refused = load(&project(&rig, &cells()));
        let Err(TrialError::Prepare(PrepareError::Rig(RigError::Library(error)))) = refused else {
            panic!("taken")
        };
        assert!(error.to_string().contains(said), "{error}");
        let LibraryError::Mistake(mistake) = error else { panic!("without a place: {error}") };
        assert!(mistake.file().ends_with("rigs/pack.toml"), "{}", mistake.file());
        assert_eq!(&rig[mistake.range()], at);
        let help = mistake.advice().unwrap_or_default();
        assert!(said != "cellz" || help.starts_with("did you mean `cells`?"), "{help}");
    }
}

/// Found by a user: the plan sent all messages as the first of them, and the second stayed silent without a word.
#[test]
fn two_testers_of_the_same_messages_are_refused() {
    let testers = "[[node]]\nname = \"one\"\nat = \"can0\"\ntester = true\n\
                   [[node]]\nname = \"two\"\nat = \"can0\"\ntester = true\n";
    let rig = format!("{PACK}\n{testers}");
    let refused = load(&project(&rig, &cells()));
    let Err(TrialError::Prepare(error)) = refused else { panic!("taken") };
    assert!(error.to_string().contains("testers of the same messages"), "{error}");
}
