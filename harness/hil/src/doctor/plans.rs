//! Do plans find their files, and does a bench provide the roles that they need?

use super::finding::Finding;
use described::Medium;
use emulators::base::Transport;
use emulators::device_file::Mount;
use harness::operator::{AnswerFile, Answers, Attendance, RealRoles, asks_a_person};
use harness::run::Prepared;
use miette::Diagnostic;
use plan::bench_file::{self, BenchFile, ROLES, Role};
use plan::made::Made;

/// How a base is connected.
const ON_CAN: &str = "on CAN";
/// See [`ON_CAN`].
const ON_A_SERIAL_LINE: &str = "on a serial line";

/// Reads the plans in order, each with what the earlier ones promise to make.
pub(super) fn prepare(plans: &[String], findings: &mut Vec<Finding>) -> Vec<Prepared> {
    let mut promised = Made::default();
    let mut prepared = Vec::new();
    for name in plans {
        match Prepared::load(name, &promised) {
            Ok(next) => {
                promised.promise(&next.plan);
                prepared.push(next);
            }
            Err(error) => findings.push(unusable(&format!("plan {name}"), &error)),
        }
    }
    for one in &prepared {
        let roles = needed(one).into_iter().map(|(role, on)| match on {
            None => role.to_owned(),
            Some(bus) => format!("{role} {bus}"),
        });
        let what =
            format!("all its files are there; needs {}", roles.collect::<Vec<_>>().join(", "));
        findings.push(Finding::good(format!("plan {}", one.plan.name), what));
    }
    prepared
}

/// A file that cannot be used.
pub(super) fn unusable(subject: &str, error: &dyn Diagnostic) -> Finding {
    let help = error.help().map(|help| comment(&help.to_string()));
    let mend = help.unwrap_or_else(|| "# mend the file; what ships:\nhil list".to_owned());
    Finding::gap(subject, error.to_string(), mend, Some(subject.to_owned()))
}

/// Prose as lines that a shell passes over.
fn comment(text: &str) -> String {
    text.lines().map(|line| format!("# {line}")).collect::<Vec<_>>().join("\n")
}

/// The roles that a plan needs, and what each is connected by where there is a choice.
fn needed(prepared: &Prepared) -> Vec<(&'static str, Option<&'static str>)> {
    match (&prepared.rig.robot, prepared.rig.device()) {
        (Some(devices), _) => {
            let carrier = match (devices.mount, &devices.base) {
                (Mount::Base, Some((Transport::Can, _))) => ("base", Some(ON_CAN)),
                (Mount::Base, Some((Transport::Serial, _))) => ("base", Some(ON_A_SERIAL_LINE)),
                _ => ("table", None),
            };
            vec![("gyro", None), carrier]
        }
        (None, Some(device)) => match device.layout().medium() {
            Medium::Can => vec![("device", Some(ON_CAN))],
            Medium::Serial(_) => vec![("device", Some(ON_A_SERIAL_LINE))],
        },
        // Its lines have ports, and no roles.
        (None, None) => Vec::new(),
    }
}

/// Judges a bench against the plans; gives the roles that they need of it, all where there are no plans.
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
        for (role, on) in needed(one) {
            if !roles.contains(&role) {
                roles.push(role);
            }
            findings.extend(misfit(&subject, plan, (role, on), &bench.role(role)));
        }
    }
    answers(&subject, bench, prepared, findings);
    if findings.len() == before {
        let what = match prepared {
            [] => "can be used",
            _ => "provides every role that the plans need",
        };
        findings.push(Finding::good(subject, what));
    }
    if prepared.is_empty() { ROLES.to_vec() } else { roles }
}

/// A role on a medium that the plan's base is not connected by.
fn misfit(
    subject: &str,
    plan: &str,
    (role, on): (&str, Option<&str>),
    player: &Role,
) -> Option<Finding> {
    let Some(port) = player.port() else {
        // The pty that an emulated device gets where no port is named carries bytes.
        return (on == Some(ON_CAN)).then(|| {
            Finding::gap(
                subject,
                format!("names no port for the {role}, which plan {plan} has on CAN"),
                format!("# in the bench:\n# [{role}]\n# port = \"can:vcan0\"\n# emulated = true"),
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
    Some(Finding::gap(
        subject,
        format!("gives the {role} {carries}, plan {plan} has it {}", on.unwrap_or_default()),
        format!(
            "# name a port such as {}:... for [{role}], or a device file in the plan whose base has the \
             other transport",
            proposed.scheme()
        ),
        Some(format!("plan {plan}")),
    ))
}

/// The answers that the bench names, against what the plans ask.
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
