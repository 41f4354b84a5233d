//! Checks that plans find their files, and that a bench provides the roles and lines that they need.

use super::finding::Finding;
use described::Medium;
use emulators::base::Transport;
use emulators::device_file::Mount;
use harness::operator::{AnswerFile, Answers, Attendance, RealRoles, asks_a_person};
use harness::run::Prepared;
use harness::run_live::carried;
use live::world::{BenchWork, PlacementError};
use miette::Diagnostic;
use plan::bench_file::{self, BenchFile, PortText, ROLES};
use plan::made::Made;

const ON_CAN: &str = "on CAN";
const ON_A_SERIAL_LINE: &str = "on a serial line";

/// Reads the plans in order, each with the calibrations that the earlier ones promise.
pub(super) fn prepare(
    plans: &[String],
    real: &[String],
    findings: &mut Vec<Finding>,
) -> Vec<Prepared> {
    let mut promised = Made::default();
    let mut prepared = Vec::new();
    for name in plans {
        match Prepared::load(name, &promised).and_then(|next| next.with_real(real)) {
            Ok(next) => {
                promised.promise(&next.plan);
                prepared.push(next);
            }
            Err(error) => findings.push(unusable(&format!("plan {name}"), &error)),
        }
    }
    for one in &prepared {
        let needs = needed(one).into_iter().map(|needed| match needed.on() {
            None => needed.what(),
            Some(bus) => format!("{} {bus}", needed.what()),
        });
        let needs = match needs.collect::<Vec<_>>() {
            needs if needs.is_empty() => "no port".to_owned(),
            needs => needs.join(", "),
        };
        let what = format!("all files found; needs {needs}");
        findings.push(Finding::good(format!("plan {}", one.plan.name), what));
    }
    prepared
}

pub(super) fn unusable(subject: &str, error: &dyn Diagnostic) -> Finding {
    let help = error.help().map(|help| comment(&help.to_string()));
    let mend = help.unwrap_or_else(|| "# mend the file, or name another".to_owned());
    let what = match place(error) {
        Some(place) => format!("{place}: {error}"),
        None => error.to_string(),
    };
    Finding::gap(subject, what, mend, Some(subject.to_owned()))
}

/// The file and the line of an error that shows them.
fn place(error: &dyn Diagnostic) -> Option<String> {
    let label = error.labels()?.next()?;
    let text = error.source_code()?.read_span(label.inner(), 0, 0).ok()?;
    Some(format!("{}:{}", text.name()?, text.line() + 1))
}

fn comment(text: &str) -> String {
    text.lines().map(|line| format!("# {line}")).collect::<Vec<_>>().join("\n")
}

/// What a plan needs a port for, and its connection if there is a choice.
#[derive(Clone, Copy)]
enum Needed<'a> {
    Role(&'static str, Option<&'static str>),
    Line(&'a str, &'static str),
}

impl Needed<'_> {
    const fn on(self) -> Option<&'static str> {
        match self {
            Self::Role(_, on) => on,
            Self::Line(_, on) => Some(on),
        }
    }

    fn what(self) -> String {
        match self {
            Self::Role(role, _) => role.to_owned(),
            Self::Line(line, _) => format!("line {line}"),
        }
    }

    fn table(self) -> String {
        match self {
            Self::Role(role, _) => role.to_owned(),
            Self::Line(line, _) => format!("line.{line}"),
        }
    }

    fn port(self, bench: &BenchFile) -> Option<PortText> {
        match self {
            Self::Role(role, _) => bench.role(role).port().cloned(),
            Self::Line(line, _) => bench.lines.get(line).map(|section| section.port.clone()),
        }
    }
}

const fn on(medium: Medium) -> &'static str {
    match medium {
        Medium::Can => ON_CAN,
        Medium::Serial(_) => ON_A_SERIAL_LINE,
    }
}

/// Returns the lines of a rig with a node outside this process, and their connection.
pub(super) fn lines(prepared: &Prepared) -> impl Iterator<Item = (&str, &'static str)> {
    let rig = &prepared.rig;
    let lines = rig.lines.iter().enumerate();
    let away = lines.filter(|(place, _)| rig.is_away(*place));
    away.map(|(_, line)| (line.name.as_str(), on(line.medium)))
}

fn needed(prepared: &Prepared) -> Vec<Needed<'_>> {
    let role = Needed::Role;
    match (&prepared.rig.robot, prepared.rig.device()) {
        (Some(devices), _) => {
            let carrier = match (devices.mount, &devices.base) {
                (Mount::Base, Some((Transport::Can, _))) => role("base", Some(ON_CAN)),
                (Mount::Base, Some((Transport::Serial, _))) => role("base", Some(ON_A_SERIAL_LINE)),
                _ => role("table", None),
            };
            let lines = lines(prepared).map(|(line, on)| Needed::Line(line, on));
            [role("gyro", None), carrier].into_iter().chain(lines).collect()
        }
        (None, Some(device)) => vec![role("device", Some(on(device.layout().medium())))],
        (None, None) => lines(prepared).map(|(line, on)| Needed::Line(line, on)).collect(),
    }
}

/// Judges a bench against the plans; returns the roles that they need, or all roles if there are no plans.
pub(super) fn judge(
    name: &str,
    bench: &BenchFile,
    prepared: &[Prepared],
    findings: &mut Vec<Finding>,
) -> Vec<&'static str> {
    let subject = format!("bench {name}");
    let before = findings.len();
    let mut roles = Vec::new();
    for one in prepared {
        let plan = one.plan.name.as_str();
        if let Err(foreign) = bench.expect_of(&one.rig) {
            findings.push(unusable(&subject, &foreign));
        }
        findings.extend(classic(bench, one).map(|error| unusable(&subject, &error)));
        for needed in needed(one) {
            if let Needed::Role(role, _) = needed
                && !roles.contains(&role)
            {
                roles.push(role);
            }
            // A device that the bench does not name is emulated within the harness, as with a bench of commands alone.
            let is_inside = matches!(needed, Needed::Role("device", _)) && bench.device.is_none();
            if !is_inside {
                findings.extend(misfit(&subject, plan, needed, needed.port(bench)));
            }
        }
    }
    for lacking in BenchWork::of(bench).lacks(prepared.iter().map(|one| &*one.plan)) {
        findings.push(unusable(&subject, &lacking));
    }
    answers(&subject, bench, prepared, findings);
    if findings.len() == before {
        let what = match prepared {
            [] => "can be used",
            _ => "provides all that the plans need",
        };
        findings.push(Finding::good(subject, what));
    }
    let has_robot = [&bench.gyro, &bench.base, &bench.table].iter().any(|role| role.is_some())
        || bench.controller.is_some();
    let names_none = bench.device.is_none() && bench.lines.is_empty() && bench.commands.is_empty();
    match prepared {
        [] if has_robot || names_none => ROLES.to_vec(),
        [] => bench.device.iter().map(|_| "device").collect(),
        _ => roles,
    }
}

/// CAN FD lines at ports that carry classic frames. What else a port may not carry, [`misfit`] finds.
fn classic(bench: &BenchFile, one: &Prepared) -> impl Iterator<Item = PlacementError> {
    one.rig.lines.iter().filter_map(|line| {
        let port = &bench.lines.get(&line.name)?.port;
        let error = carried(&port.as_str().parse().ok()?, line).err()?;
        matches!(error, PlacementError::NoFd { .. }).then_some(error)
    })
}

/// Finding for a role or line on another medium than in the plan.
fn misfit(
    subject: &str,
    plan: &str,
    needed: Needed<'_>,
    port: Option<PortText>,
) -> Option<Finding> {
    let (what, table, on) = (needed.what(), needed.table(), needed.on());
    let Some(port) = port else {
        // The pty of an emulated device without a named port carries bytes.
        return (on == Some(ON_CAN)).then(|| {
            let emulated = match needed {
                Needed::Role(..) => "\n# emulated = true",
                Needed::Line(..) => "",
            };
            Finding::gap(
                subject,
                format!("names no port for the {what}, which plan {plan} has on CAN"),
                format!("# in the bench:\n# [{table}]\n# port = \"can:vcan0\"{emulated}"),
                Some(format!("plan {plan}")),
            )
        });
    };
    let medium = port.medium();
    let carries = if medium.is_serial_line() { ON_A_SERIAL_LINE } else { ON_CAN };
    if on.is_none_or(|on| on == carries) {
        return None;
    }
    let proposed =
        if medium.is_serial_line() { bench_file::Medium::Can } else { bench_file::Medium::Serial };
    let or = match needed {
        Needed::Role(..) => ", or a device file in the plan whose base has the other transport",
        Needed::Line(..) => "",
    };
    Some(Finding::gap(
        subject,
        format!("gives the {what} {carries}, plan {plan} has it {}", on.unwrap_or_default()),
        format!("# name a port such as {}:... for [{table}]{or}", proposed.name()),
        Some(format!("plan {plan}")),
    ))
}

/// Checks the bench's answers against the plans' questions.
fn answers(subject: &str, bench: &BenchFile, prepared: &[Prepared], findings: &mut Vec<Finding>) {
    let plans = || prepared.iter().map(|one| &*one.plan);
    let Some(section) = &bench.answers else {
        let asking: Vec<&str> = plans()
            .filter(|plan| asks_a_person(plan, RealRoles::of(bench)))
            .map(|plan| plan.name.as_str())
            .collect();
        if let Some(asking) = super::finding::joined(asking) {
            findings.push(Finding::gap(
                subject,
                format!("no answers for what {asking} asks a person"),
                "# run it in a terminal, or name a file of answers in the bench:\n# [answers]\n# file = \"answers.toml\"",
                None,
            ));
        }
        return;
    };
    let collected =
        AnswerFile::load(&section.file).map_err(Into::into).and_then(|file| match prepared {
            [] => Ok(Answers::default()),
            _ => Answers::collect(
                &[],
                Some(&file),
                plans(),
                RealRoles::of(bench),
                Attendance::Nobody,
            ),
        });
    if let Err(error) = collected {
        findings.push(unusable(subject, &error));
    }
}

#[cfg(test)]
mod tests {
    use super::prepare;

    /// Found by a user: the mistake was told without its place.
    #[test]
    fn a_mistake_in_a_plan_is_told_with_its_line() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("wrong.toml");
        let plan = "name = \"wrong\"\ntitle = \"\"\nsteps = [{ wiat = { duration_s = 1 } }]\n";
        std::fs::write(&path, plan).unwrap();
        let mut findings = Vec::new();
        assert!(prepare(&[path.to_str().unwrap().to_owned()], &[], &mut findings).is_empty());
        let [found] = &findings[..] else { panic!("{findings:?}") };
        assert!(found.what.contains("wrong.toml:3: "), "{found:?}");
        assert!(!found.mend.as_deref().unwrap_or_default().contains("hil list"), "{found:?}");
    }
}
