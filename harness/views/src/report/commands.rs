//! What the bench did by commands of its own.

use super::listed;
use maud::{Markup, html};
use record::outcome::CommandSummary;

/// The table; nothing where the plan asks for none.
pub(super) fn table(commands: &[CommandSummary]) -> Option<Markup> {
    if commands.is_empty() {
        return None;
    }
    let rows = html! {
        @for one in commands {
            tr {
                td { code { (one.name) } }
                td.number { (one.times) }
                td.number { @if let Some(s) = one.longest_s { (format!("{s:.3}")) " s" } }
                td { (one.ended.as_deref().unwrap_or("not run: in virtual time there is no bench")) }
            }
        }
    };
    Some(listed::table(None, &["command", "run", "longest", "ended"], &rows))
}

#[cfg(test)]
mod tests {
    use super::{CommandSummary, table};

    #[test]
    fn what_was_run_and_what_was_not_is_told_apart() {
        assert!(table(&[]).is_none());
        let mut all = Vec::new();
        CommandSummary::passed_over(&mut all, "flash");
        CommandSummary::ran(&mut all, "power-on", 0.25, "exit status: 0");
        let page = table(&all).unwrap().into_string();
        assert!(page.contains("<code>flash</code></td><td class=\"number\">0</td>"), "{page}");
        assert!(page.contains("not run: in virtual time"), "{page}");
        assert!(page.contains("0.250 s</td><td>exit status: 0</td>"), "{page}");
    }
}
