//! Names that exist and names that do not.

use super::{Kind, Library, LibraryError, PAPER_PLANS, Source, names};
use std::path::Path;

#[test]
fn every_procedure_of_the_paper_ships() {
    let shipped = names(Kind::Plan);
    for plan in PAPER_PLANS {
        assert!(shipped.iter().any(|name| name == plan), "{plan}");
    }
}

#[test]
fn an_unknown_name_lists_what_there_is() {
    let error = Library::shipped().open(Kind::Plan, "varification").unwrap_err();
    assert_eq!(error.to_string(), "no plan is called \"varification\"");
    let help = |name: &str, project: &Path, kind| {
        let error = Library::of_project(project).open(kind, name).unwrap_err();
        let help = miette::Diagnostic::help(&error).map(|help| help.to_string());
        help.unwrap().lines().next().unwrap().to_owned()
    };
    let nowhere = Path::new("no/such/folder");
    assert_eq!(help("varification", nowhere, Kind::Plan), "did you mean `verification`?");
    assert!(help("x", nowhere, Kind::Plan).starts_with("shipped: close-the-loop, "));
    assert_eq!(help("x", nowhere, Kind::Description), "there is none");
    let project = tempfile::tempdir().unwrap();
    std::fs::create_dir(project.path().join("devices")).unwrap();
    for file in ["settles.toml", "devices/oven.toml"] {
        std::fs::write(project.path().join(file), "").unwrap();
    }
    let plan = |name| help(name, project.path(), Kind::Plan);
    assert_eq!(plan("setles"), "did you mean `settles.toml`?");
    assert!(plan("x").starts_with("in this project: settles.toml; shipped: close-the-loop, "));
    let device = |name| help(name, project.path(), Kind::Description);
    assert_eq!(device("oevn"), "did you mean `oven`?");
    assert_eq!(device("x"), "in this project: oven");
}

#[test]
fn an_unknown_name_is_marked_where_it_names_a_file() {
    let text = "# not \"nosuch\"\nname = \"nosuch\"\ntitle = \"nosuch\"\nrig = \"nosuch\"\n";
    let source = Source { origin: "p.toml".to_owned(), text: text.to_owned() };
    let error = Library::shipped().open(Kind::Rig, "nosuch").unwrap_err();
    let placed = source.placed(&error).unwrap();
    let LibraryError::Mistake(mistake) = placed else { panic!("{placed}") };
    assert_eq!(mistake.range(), text.rfind("\"nosuch\"").map(|at| at..at + 8).unwrap());
    let elsewhere = Source { text: "name = \"nosuch\"\n".to_owned(), ..source };
    assert!(elsewhere.placed(&error).is_none());
}

#[test]
fn a_missing_path_names_the_path_and_the_cause() {
    let error = Library::shipped().open(Kind::Bench, "no/such.toml").unwrap_err();
    assert!(error.to_string().starts_with("failed to read no/such.toml: "), "{error}");
    assert!(miette::Diagnostic::help(&error).is_none());
}

#[test]
fn a_folder_is_no_file() {
    let project = tempfile::tempdir().unwrap();
    let folder = format!("{}/", project.path().display());
    let error = Library::of_project(project.path()).open(Kind::Plan, &folder).unwrap_err();
    let help = miette::Diagnostic::help(&error).map(|help| help.to_string());
    assert_eq!(help.as_deref(), Some("name a file in that folder"), "{error}");
}

#[test]
fn a_misspelt_path_is_answered_with_the_file_beside_it() {
    let project = tempfile::tempdir().unwrap();
    for file in ["settles.toml", "setles.md", "other.toml"] {
        std::fs::write(project.path().join(file), "").unwrap();
    }
    let path = project.path().join("setles.toml");
    let error = Library::shipped().open(Kind::Plan, path.to_str().unwrap()).unwrap_err();
    let help = miette::Diagnostic::help(&error).map(|help| help.to_string()).unwrap();
    let meant = project.path().join("settles.toml");
    assert_eq!(help, format!("did you mean `{}`?", meant.display()));
}
