//! Saves the smallest failing case as a plan that anyone can run.

use super::case::{Case, PANIC, PASSES};
use super::shrink::Small;
use plan::Seed;
use std::io;
use std::path::{Component, Path, PathBuf};

/// A case to save.
#[derive(Debug, Clone, Copy)]
pub struct Regression<'a> {
    /// Name of the plan under test.
    pub plan: &'a str,
    /// Text of that plan.
    pub text: &'a str,
    /// Folder of the files that it names, if it is not among the shipped ones.
    pub project: Option<&'a Path>,
    /// The property that breaks.
    pub property: &'a str,
    /// The observed violation.
    pub what: &'a str,
    /// The case.
    pub case: &'a Case,
    /// How far it was shrunk.
    pub small: Small,
    /// Options with which `hil run` runs it where it broke; `None` if only Rust code can, which has its devices.
    pub again: Option<&'a str>,
}

/// Why a case cannot be saved.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum RegressionError {
    /// The file cannot be written.
    #[error("failed to write or remove {}", path.display())]
    Io {
        /// The path.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The plan's text is not TOML any more.
    #[error("the plan {plan} cannot be written again: {message}")]
    Plan {
        /// Its name.
        plan: String,
        /// Why.
        message: String,
    },
}

/// The first words of each saved plan.
const FOUND_BY: &str = "# Found by `hil campaign";

/// Removes a plan that an earlier part of the campaign saved; nothing else of that name.
///
/// # Errors
///
/// When it cannot be removed.
pub fn remove_saved(path: &Path) -> Result<(), RegressionError> {
    let is_ours = std::fs::read_to_string(path).is_ok_and(|text| text.starts_with(FOUND_BY));
    if !is_ours {
        return Ok(());
    }
    std::fs::remove_file(path)
        .map_err(|source| RegressionError::Io { path: path.to_owned(), source })
}

/// The name of a property in the names of plans and files: words joined by hyphens, truncated.
pub fn slug(property: &str) -> String {
    const LENGTH_MAX: usize = 40;
    let words =
        property.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
    let mut slug = words.collect::<Vec<_>>().join("-").to_ascii_lowercase();
    slug.truncate(LENGTH_MAX);
    slug.trim_end_matches('-').to_owned()
}

impl Regression<'_> {
    /// Name of the plan, from the plan under test, the property and the case.
    pub fn name(&self) -> String {
        let id = self.case.id(self.text).to_string();
        format!("{}-{}-{}", self.plan, slug(self.property), &id[..8])
    }

    /// The plan under test under its new name, with the seed of the case and its faults after the plan's own. In these
    /// positions, and with the random numbers of the original plan, the faults behave as they did when the case was
    /// carried out.
    ///
    /// From `folder`, which exists, it finds the files that it names.
    ///
    /// # Errors
    ///
    /// When the plan's text is not TOML.
    pub fn to_toml(&self, folder: &Path) -> Result<String, RegressionError> {
        let failed =
            |message: String| RegressionError::Plan { plan: self.plan.to_owned(), message };
        let mut table: toml::Table =
            self.text.parse().map_err(|error: toml::de::Error| failed(error.to_string()))?;
        let title = format!("{} breaks under faults: {}", self.plan, self.property);
        table.entry("random_numbers_of").or_insert_with(|| self.plan.into());
        table.insert("name".to_owned(), self.name().into());
        let seed = toml::Value::try_from(Seed(self.case.seed));
        table.insert("seed".to_owned(), seed.map_err(|error| failed(error.to_string()))?);
        // A plan that another campaign saved has that of its own place.
        table.remove("project");
        let project = self.project.and_then(|project| way(folder, project));
        table.extend(project.map(|project| ("project".to_owned(), project.into())));
        table.insert("title".to_owned(), title.into());
        let faults = toml::Value::try_from(&self.case.schedule)
            .map_err(|error| failed(error.to_string()))?;
        let mut all = Vec::new();
        for faults in table.remove("fault").into_iter().chain([faults]) {
            match faults {
                toml::Value::Array(faults) => all.extend(faults),
                other => {
                    return Err(failed(format!("[[fault]] is of type {}", other.type_str())));
                }
            }
        }
        if !all.is_empty() {
            table.insert("fault".to_owned(), all.into());
        }
        // What must occur in some run of the campaign need not in this one.
        if let Some(toml::Value::Array(all)) = table.get_mut("property") {
            all.retain(|property| property.get("sometimes").is_none());
            if all.is_empty() {
                table.remove("property");
            }
        }
        // The broken property is judged again; a panic, and a plan that does not pass, need no property.
        let by_itself = [PANIC, PASSES].contains(&self.property);
        if !by_itself && !table.contains_key("property") {
            let always: toml::Table =
                [(self.property.to_owned(), toml::Table::new().into())].into_iter().collect();
            let property: toml::Table =
                [("always".to_owned(), always.into())].into_iter().collect();
            table.insert("property".to_owned(), vec![toml::Value::from(property)].into());
        }
        let text = toml::to_string_pretty(&table).map_err(|error| failed(error.to_string()))?;
        let mut comment = String::new();
        for line in self.what.lines() {
            comment += &format!("# {line}\n");
        }
        let (plan, property) = (self.plan, self.property);
        let case = match self.small {
            Small::Smallest => format!("the smallest case that breaks `{property}`."),
            Small::InPart => format!(
                "a case that breaks `{property}`, not shrunk to the end: the campaign was stopped."
            ),
            Small::Not => format!("a case that breaks `{property}`, not shrunk."),
        };
        let path = format!("PATH/{}.toml", self.name());
        let again = match self.again {
            Some(options) => format!("hil run {path} {options}"),
            None => format!("Trial::load(\"{path}\"), with the devices of the trial that found it"),
        };
        let again = again.trim_end();
        Ok(format!(
            "{FOUND_BY} {plan}`: {case}\n{comment}# Run it, where {plan} is run: {again}\n\n{text}"
        ))
    }

    /// Writes it into `folder` and returns the path.
    ///
    /// # Errors
    ///
    /// When the file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<PathBuf, RegressionError> {
        let path = folder.join(format!("{}.toml", self.name()));
        let failed = |source| RegressionError::Io { path: path.clone(), source };
        std::fs::create_dir_all(folder).map_err(failed)?;
        let text = self.to_toml(folder)?;
        std::fs::write(&path, text).map_err(failed)?;
        Ok(path)
    }
}

/// The way from `folder` to that of the `project`; `None` if they are the same.
fn way(folder: &Path, project: &Path) -> Option<String> {
    // Of a plan that is named without a folder, the project is an empty path.
    let (from, to) =
        (folder.canonicalize().ok()?, Path::new(".").join(project).canonicalize().ok()?);
    let shared = from.components().zip(to.components()).take_while(|(a, b)| a == b).count();
    let up = from.components().skip(shared).map(|_| Component::ParentDir);
    let way: PathBuf = up.chain(to.components().skip(shared)).collect();
    way.to_str().filter(|way| !way.is_empty()).map(str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::{Regression, Small, remove_saved};
    use crate::Case;
    use plan::Plan;
    use plan::faults::{Fault, FaultKind, Schedule, Target};
    use plan::library::{Kind, Library};
    use std::path::Path;

    const PLAN: &str = r#"
name = "struck"
title = "A plan with a fault of its own"
devices = "paper-serial"
steps = [{ bias_test = {} }]

[[measurement]]
name = "samples_lost"
doc = "Gyro samples lost on the way"
quantity = "samples.lost"
unit = "1"
check = { all_within = [0, 10] }
"#;
    const OWN: &str = "\n[[fault]]\ntarget = \"gyro\"\nwhat = { drop = { loss_percent = 1 } }\n";

    /// The plan made from a case of `text`.
    fn regression(text: &str, case: &Case) -> Plan {
        let (plan, property, what) = ("struck", "fresh_heading", "an old one\nor two");
        let (small, again) = (Small::Smallest, Some(""));
        let regression =
            Regression { plan, text, project: None, property, what, case, small, again };
        let written = regression.to_toml(Path::new(".")).unwrap();
        Plan::parse("written.toml", &written).unwrap_or_else(|e| panic!("{e}\n{written}"))
    }

    fn written(text: &str, case: &Case) -> Schedule {
        regression(text, case).faults
    }

    #[test]
    fn what_the_whole_campaign_has_to_reach_is_not_asked_of_the_smallest_case() {
        let names = |properties: &str| -> Vec<String> {
            let text = format!("{PLAN}{properties}");
            let plan = regression(&text, &Case::default());
            plan.properties.iter().map(|one| one.name().to_owned()).collect()
        };
        let reached = "\n[[property]]\nsometimes = \"gyro_silent\"\n";
        assert_eq!(names(reached), ["fresh_heading"]);
        let both = format!("{reached}[[property]]\nalways = {{ recovers = {{}} }}\n");
        assert_eq!(names(&both), ["recovers"]);
    }

    #[test]
    fn the_saved_plan_finds_the_files_beside_the_plan_that_was_struck() {
        let folder = tempfile::tempdir().unwrap();
        let (plans, out) = (folder.path().join("plans"), folder.path().join("runs/campaign"));
        std::fs::create_dir_all(plans.join("devices")).unwrap();
        std::fs::write(plans.join("devices/mine.toml"), "gyro = \"dsp3000\"\n").unwrap();
        let text = PLAN.replace("paper-serial", "mine");
        let case = Case::default();
        let regression = Regression {
            plan: "struck",
            text: &text,
            project: Some(&plans),
            property: "fresh_heading",
            what: "an old one",
            case: &case,
            small: Small::Smallest,
            again: Some(""),
        };
        let found = |regression: &Regression<'_>, folder| {
            let saved = regression.write(folder).unwrap();
            let saved = saved.to_str().unwrap();
            let text = std::fs::read_to_string(saved).unwrap();
            let plan = Plan::parse(saved, &text).unwrap();
            let library = Library::beside(saved).of(plan.project.as_deref());
            let found = library.open(Kind::Devices, "mine").unwrap();
            assert!(found.origin.ends_with("plans/devices/mine.toml"), "{}", found.origin);
            (plan.project, text)
        };
        let (project, text) = found(&regression, &out);
        assert_eq!(project.as_deref(), Some("../../plans"));
        // The saved plan is struck in its turn.
        let again = Regression { text: &text, ..regression };
        let (project, _) = found(&again, &folder.path().join("again"));
        assert_eq!(project.as_deref(), Some("../plans"));
        let beside = regression.write(&plans).unwrap();
        assert!(!std::fs::read_to_string(beside).unwrap().contains("project"));
    }

    /// Found by a user: after Ctrl-C, plans called themselves the smallest, and stayed when the campaign went on.
    #[test]
    fn a_saved_plan_says_how_small_it_is_and_how_to_run_it() {
        let case = Case::default();
        let head = |small, again| {
            let (plan, property, what) = ("struck", "fresh_heading", "");
            let one = Regression {
                plan,
                text: PLAN,
                project: None,
                property,
                what,
                case: &case,
                small,
                again,
            };
            let text = one.to_toml(Path::new(".")).unwrap();
            text.lines().take(2).map(str::to_owned).collect::<Vec<_>>()
        };
        let smallest = head(Small::Smallest, Some(""));
        assert!(smallest[0].ends_with(": the smallest case that breaks `fresh_heading`."));
        assert!(smallest[1].ends_with(".toml"), "{smallest:?}");
        let not = head(Small::Not, Some("--clock real --bench window.toml"));
        assert!(not[0].ends_with(": a case that breaks `fresh_heading`, not shrunk."), "{not:?}");
        assert!(not[1].ends_with(".toml --clock real --bench window.toml"), "{not:?}");
        assert!(
            head(Small::InPart, Some(""))[0]
                .ends_with("not shrunk to the end: the campaign was stopped.")
        );
        // Found by a user: a program cannot be started in the place of Rust code.
        let in_code = head(Small::Smallest, None);
        assert!(in_code[1].contains("Trial::load(\"PATH/") && !in_code[1].contains("hil run"));
    }

    #[test]
    fn only_what_a_campaign_saved_is_removed() {
        let folder = tempfile::tempdir().unwrap();
        let (ours, other) = (folder.path().join("ours.toml"), folder.path().join("other.toml"));
        std::fs::write(&ours, "# Found by `hil campaign struck`: a case\n").unwrap();
        std::fs::write(&other, "# Mine\n").unwrap();
        for path in [&ours, &other, &folder.path().join("none.toml")] {
            remove_saved(path).unwrap();
        }
        assert!(!ours.exists() && other.exists());
    }

    #[test]
    fn the_faults_of_the_case_stand_behind_those_of_the_plan() {
        let stuck = Fault::new(Target::Gyro, FaultKind::typical("stuck").unwrap());
        let case = Case { seed: 3, schedule: Schedule { faults: vec![stuck.clone()] } };
        let with_own = format!("{PLAN}{OWN}");
        let own = Plan::parse("own.toml", &with_own).unwrap().faults;
        assert_eq!(written(PLAN, &case).faults, [stuck]);
        assert_eq!(written(&with_own, &case), case.schedule.beside(&own));
        // A violation without any fault of the case comes from the plan's own faults.
        assert_eq!(written(&with_own, &Case::default()), own);
        assert!(written(PLAN, &Case::default()).is_empty());
    }
}
