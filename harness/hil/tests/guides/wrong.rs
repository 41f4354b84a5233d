//! Wrong guides are detected.

use crate::followed;
use crate::markdown::Guide;

fn wrong(page: &str) -> String {
    Guide::read("page", page).and_then(|guide| followed(&guide)).unwrap_err()
}

/// A block of commands.
fn console(text: &str) -> String {
    format!("Words.\n\n```console\n{text}\n```\n")
}

#[test]
fn a_page_that_is_right_passes() {
    let page = console(
        "$ printf 'one\\ntwo in 0.4 s\\nthree\\n'\none\ntwo in 7 s\n...\n$ mkdir a && cd a\n$ pwd\n.../a\n\
         $ false   # exit status 1",
    );
    let page = page + "\n```toml b/c.toml\nd = 1\n```\n\n```console\n$ cat b/c.toml\nd = 1\n```\n";
    let guide = Guide::read("page", &page).unwrap();
    followed(&guide).unwrap();
}

#[test]
fn what_is_not_printed_is_wrong() {
    for (command, shown) in
        [("echo one", "two"), ("printf 'one\\ntwo\\n'", "one"), ("echo one", "one\ntwo")]
    {
        let wrong = wrong(&console(&format!("$ {command}\n{shown}")));
        assert!(wrong.contains("page:4: $"), "{wrong}");
        assert!(wrong.contains("printed:"), "{wrong}");
    }
}

#[test]
fn another_exit_status_is_wrong() {
    assert!(wrong(&console("$ exit 3")).contains("Some(3), expected 0"));
    assert!(wrong(&console("$ true   # exit status 1")).contains("Some(0), expected 1"));
    assert!(wrong(&console("$ hil run none.toml")).contains("Some(2), expected 0"));
}

#[test]
fn a_command_that_nobody_runs_is_wrong() {
    assert!(wrong("```sh\nhil list plans\n```\n").contains("page:1: a block `sh`"));
    assert!(wrong("```\nhil list plans\n```\n").contains("which nobody runs"));
    assert!(wrong("Words.\n\n    hil list plans\n").contains("indented"));
    let said = format!("Then `hil list steps`.\n\n{}", console("$ hil list plans"));
    assert!(wrong(&said).contains("`hil list steps` begins no command"));
}

#[test]
fn a_command_in_another_terminal_must_say_what_is_shown_and_end_well() {
    let page = |command, shown| format!("```console another-terminal\n$ {command}\n{shown}\n```\n");
    let never = page("sh -c 'echo no'", "yes");
    assert!(wrong(&never).contains("printed:\nno"));
    // Not sh: dash loses a signal that comes while it starts a command.
    let badly = page("bash -c 'trap \"exit 3\" TERM; echo up; while :; do sleep 0.1; done'", "up");
    assert!(wrong(&badly).contains("ended with"));
}
