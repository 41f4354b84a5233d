//! Messages with counters and checksums: a plan sends them as its rig states, and the emulated node checks them as its
//! file states.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use crate::message_faults::{RIG, load_pack};
use harness::{Trial, TrialError};
use tempfile::TempDir;

fn load(
    rig: &str,
    steps: &str,
    quantity: &str,
    check: &str,
) -> (TempDir, Result<Trial, TrialError>) {
    let plan = format!(
        "name = \"plan\"\ntitle = \"\"\nrig = \"pack\"\nsteps = [{steps}]\n[[measurement]]\nname = \"it\"\ndoc = \"\"\n\
         quantity = \"{quantity}\"\nwhere = {{ \"during.after\" = 1 }}\nunit = \"A\"\ncheck = {{ {check} }}\n"
    );
    load_pack(rig, &plan)
}

fn passes(rig: &str, steps: &str, check: &str) -> bool {
    let (_folder, trial) = load(rig, steps, "cells.CellStatus.Limit", check);
    trial.unwrap_or_else(|error| panic!("{error:?}")).run().unwrap().passed()
}

const SEND: &str = "{ send = { message = \"Request\", set = { Limit = 9 }, every_s = 0.05 } }, \
    { wait = { duration_s = 0.5 } }, ";
const AFTER: &str = "{ wait = { duration_s = 2 }, label = \"after\" }";

#[test]
fn the_line_of_the_page_on_rigs_is_that_of_this_rig() {
    let page = include_str!("../../docs/rigs.md");
    let (line, nodes) = RIG.split_once("[[node]]").unwrap();
    let line = line.split_once('\n').unwrap().1;
    assert!(page.contains(&format!("```toml\n{line}```")), "{line}{nodes}");
}

#[test]
fn what_a_plan_sends_is_counted_and_sealed() {
    assert!(passes(RIG, &format!("{SEND}{AFTER}"), "all_within = [9, 9]"));
}

/// Without the line's table all counters and checksums would be zero; another data id than the device's is a mistake.
#[test]
fn what_is_not_sealed_is_not_used_and_another_data_id_is_refused() {
    let plain = RIG.replace("message.Request", "# message.Request");
    assert!(passes(&plain, &format!("{SEND}{AFTER}"), "all_within = [0, 0]"));
    let other = RIG.replace("0x0a5b", "0x0a5c");
    let (_folder, refused) = load(&other, AFTER, "cells.CellStatus.Limit", "all_within = [0, 0]");
    let told = format!("{:?}", refused.expect_err("two data ids"));
    assert!(told.contains("different checksums of `Request`"), "{told}");
}

/// A plan sends a wrong checksum on purpose, and right ones from its next order on.
#[test]
fn a_checksum_that_an_order_sets_stands_until_the_next_order() {
    let wrong =
        "{ send = { message = \"Request\", set = { Limit = 20, Crc = 1 }, every_s = 0.05 } }, ";
    assert!(passes(RIG, &format!("{SEND}{wrong}{AFTER}"), "all_within = [9, 9]"));
    let right = "{ send = { message = \"Request\", set = { Limit = 30 }, every_s = 0.05 } }, \
        { wait = { duration_s = 0.5 } }, ";
    assert!(passes(RIG, &format!("{SEND}{wrong}{right}{AFTER}"), "all_within = [30, 30]"));
}

#[test]
fn what_is_wrong_with_the_table_of_a_line_is_shown_in_its_place() {
    let changes = [
        ("data_id = 0x0a5b, ", "", "profile 1A needs a `data_id`"),
        ("message.Request", "message.Reqest", "no message `Reqest`"),
        ("\"Alive\"", "\"Alvie\"", "`Request` has no signal `Alvie`"),
        (", dbc = \"pack.dbc\"", "", "line `can0` has no DBC with messages"),
    ];
    for (from, to, expected) in changes {
        let rig = RIG.replace(from, to);
        let (_folder, trial) = load(&rig, AFTER, "cells.CellStatus.Limit", "all_within = [0, 0]");
        let Err(error) = trial else { panic!("taken: {expected}") };
        let mut said = error.to_string();
        let mut cause = std::error::Error::source(&error);
        while let Some(one) = cause {
            said = format!("{said}: {one}");
            cause = one.source();
        }
        assert!(said.contains(expected), "{expected}\n{said}");
    }
}
