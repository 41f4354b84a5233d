//! What the faults of a campaign strike, if not everything.

use plan::Rig;
use plan::faults::{Fault, FaultKind, KindInfo, Lines, Reach, Target};

/// The targets of a campaign on one bench.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Targets {
    /// Those that were asked for; empty for all.
    asked: Vec<Target>,
    /// Nodes whose supply, and whose own messages and signals, are struck only if they are asked for: the properties are
    /// stated over what they say, and the node itself reads none of it.
    under_test: Vec<String>,
}

/// A target that does not exist on the bench.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnknownTarget {
    /// What is wrong with it.
    pub message: String,
    /// Names that exist, if known.
    pub help: String,
}

impl Targets {
    /// All targets on this rig but what its nodes under test say, and their supply.
    pub fn of(rig: &Rig) -> Self {
        let under_test = rig.under_test_names().into_iter().map(str::to_owned).collect();
        Self { asked: Vec::new(), under_test }
    }

    /// The targets with these names on a bench with these lines; without names, all but what the nodes `under_test` say.
    ///
    /// # Errors
    ///
    /// The first name that no fault can strike.
    pub fn named(
        names: &[String],
        lines: &Lines,
        under_test: Vec<String>,
    ) -> Result<Self, UnknownTarget> {
        let asked = names.iter().map(|name| known(name, lines)).collect::<Result<_, _>>()?;
        Ok(Self { asked, under_test })
    }

    /// Those that a kind of fault strikes on a bench with these lines.
    pub(super) fn struck(&self, kind: &KindInfo, lines: &Lines) -> Vec<Target> {
        let of_message = matches!(kind.reach, Reach::Message(_));
        let is_quiet = of_message || kind.reach == Reach::Powered;
        let mut struck = lines.targets(kind.reach);
        struck.retain(|target| {
            let is_under_test = self.under_test.iter().any(|node| node == target.node());
            let all = self.asked.is_empty() && !(is_under_test && is_quiet);
            // Of the device under test, the name of the node stands for no message of its own.
            let by_part = is_under_test && of_message;
            let mut asked = self.asked.iter().filter(|one| !by_part || one.part().is_some());
            all || asked.any(|one| holds(one, target))
        });
        if kind.reach.is_line() {
            struck.extend(self.asked.iter().filter(|one| one.part().is_some()));
        }
        struck
    }
}

/// Whether `asked` is `target`, or the node or the message that it belongs to.
fn holds(asked: &Target, target: &Target) -> bool {
    let is_its_part = match (asked.part(), target.part()) {
        (None, _) => true,
        (Some(_), None) => false,
        // A whole message, a signal of it, or a signal without the name of its message.
        (Some(asked), Some(part)) => {
            part == asked
                || part.strip_prefix(asked).is_some_and(|rest| rest.starts_with('.'))
                || part.strip_suffix(asked).is_some_and(|rest| rest.ends_with('.'))
        }
    };
    asked.node() == target.node() && is_its_part
}

fn known(name: &str, lines: &Lines) -> Result<Target, UnknownTarget> {
    let unknown = |message: String, help: String| Err(UnknownTarget { message, help });
    let Some(target) = Target::named(name) else {
        let help = "the name of a node or a line, or of a message or signal of a node";
        return unknown(format!("`{name}` is no target"), help.to_owned());
    };
    let mut why = None;
    for info in FaultKind::all() {
        match Fault::new(target, info.typical).check(lines) {
            Ok(()) => return Ok(target),
            // The first kind strikes lines: it says which names there are.
            Err(unfit) => why = why.or(Some(unfit)),
        }
    }
    let (message, help) = why.map_or_else(<_>::default, |why| (why.message, why.help));
    unknown(message, help.unwrap_or_default())
}
