//! The plan of a recorded run, and whether its rig is that of the record.

use super::declared;
use super::prepared::{PrepareError, Prepared, load_plan};
use super::rig_of::load_rig;
use crate::library::{Kind, Library, PLAN, names};
use crate::made::Made;
use crate::plan::{Plan, Rig};
use crate::record::header::{Header, Node};
use std::sync::Arc;

/// Loads the plan and the rig of a recorded run: of the plan `named`, else of the plan in the record, else of the
/// shipped plan that was run. `None` if there is no such plan.
///
/// # Errors
///
/// When the plan or its rig is missing or invalid, or has other nodes than the record.
pub fn load_recorded(
    recorded: &Header,
    named: Option<&str>,
) -> Result<Option<(Plan, Rig)>, PrepareError> {
    let Some((library, name)) = place_of(recorded, named) else { return Ok(None) };
    let source = library.open(Kind::Plan, name)?;
    let plan = Plan::parse(&source.origin, &source.text)?;
    let rig = load_rig(&library.of(plan.project.as_deref()), &plan)?;
    expect_nodes(recorded, &plan, &rig)?;
    // That of the record was checked before it was run, by the rules of its day.
    if named.is_some() {
        plan.check_rig(&source.origin, &source.text, &rig)?;
    }
    Ok(Some((plan, rig)))
}

/// The plan of a recorded run, if the record holds it or it ships.
pub(super) fn plan_of(recorded: &Header) -> Option<Plan> {
    let (library, name) = place_of(recorded, None)?;
    load_plan(&library, name).ok()
}

/// Like [`load_recorded`], with everything that the plan names.
///
/// # Errors
///
/// When a file is missing or invalid, or the rig has other nodes than the record.
pub fn prepare_recorded(
    recorded: &Header,
    named: Option<&str>,
) -> Result<Option<Prepared>, PrepareError> {
    let Some((library, name)) = place_of(recorded, named) else { return Ok(None) };
    let prepared = Prepared::load_from(&library, name, &Made::default())?;
    // Another plan may have a program in the place of a device that was real.
    let real = recorded.bench.iter().filter(|_| named.is_none()).flat_map(|bench| &bench.real);
    let prepared = prepared.with_real(&real.cloned().collect::<Vec<_>>())?;
    expect_nodes(recorded, &prepared.plan, &prepared.rig)?;
    Ok(Some(prepared))
}

/// Where the plan is, and its name there.
fn place_of<'a>(recorded: &'a Header, named: Option<&'a str>) -> Option<(Library, &'a str)> {
    match named {
        Some(name) => Some((Library::beside(name), name)),
        None if recorded.files.plan().is_some() => {
            Some((Library::packed(Arc::clone(&recorded.files)), PLAN))
        }
        // The name comes from a file, so it is not taken for a path.
        None if names(Kind::Plan).contains(&recorded.plan) => {
            Some((Library::shipped(), recorded.plan.as_str()))
        }
        None => None,
    }
}

/// Refuses a rig with other nodes than the record.
fn expect_nodes(recorded: &Header, plan: &Plan, rig: &Rig) -> Result<(), PrepareError> {
    let nodes = declared::nodes(rig);
    let is_same =
        |(one, other): (&Node, &Node)| (&one.name, &one.line) == (&other.name, &other.line);
    if nodes.len() == recorded.nodes.len() && nodes.iter().zip(&recorded.nodes).all(is_same) {
        return Ok(());
    }
    let named = |nodes: &[Node]| match nodes {
        [] => "no named nodes".to_owned(),
        nodes => {
            let one = |node: &Node| format!("{} on {}", node.name, node.line);
            format!("the nodes {}", nodes.iter().map(one).collect::<Vec<_>>().join(", "))
        }
    };
    Err(PrepareError::OtherNodes {
        plan: plan.name.as_str().to_owned(),
        theirs: named(&nodes),
        recorded: named(&recorded.nodes),
    })
}
