//! Layout of the page.

use super::collect::Collected;
use super::paper::Figures;
use super::{
    decided, failures, heading, listed, measurements, observations, path, plain, properties,
    timeline, trouble,
};
use maud::{DOCTYPE, Markup, PreEscaped, html};
use record::header::Header;
use record::outcome::{CommandSummary, Outcome, Summary};

/// Embedded, so that the page is self-contained.
const STYLE: &str = include_str!("style.css");

/// Renders the whole document of a run.
pub(super) fn page(summary: &Summary, header: &Header, collected: &Collected) -> Markup {
    // The declared measurements of a killed run are not known.
    let is_judged = !summary.measurements.is_empty() || summary.outcome != Outcome::Error;
    let marks = decided::marks(summary, header, collected);
    let paper = Figures::of(header, collected);
    let body = html! {
        (heading::heading(summary, collected))
        (section(measurements::heading(&summary.measurements), is_judged.then(|| measurements::table(&summary.measurements))))
        (section("What failed", failures::figures(summary, header, collected)))
        (section("Properties", properties::table(&summary.properties)))
        (section("Notes and faults", trouble::list(&collected.troubles)))
        (section("The paper's figures", paper.plots()))
        (section("Observations", observations::plots(header, collected, &paper)))
        (section("Where it went", path::figure(&collected.believed, &collected.truth)))
        (section(
            "Steps, faults and verdicts",
            timeline::figure(collected, &marks),
        ))
        (section("Commands of the bench", bench_commands(&summary.commands)))
        (section("Load of the lines", Some(collected.load.plots(header))))
        (section("Files", artifacts(&summary.artifacts)))
    };
    document(&format!("{}: {}", summary.plan, summary.outcome.name()), &body)
}

/// Content policy: a browser may load only what the page contains.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; img-src data:; base-uri 'none'; \
                      form-action 'none'";

/// Renders a self-contained page, light or dark like the reader's system.
pub(super) fn document(title: &str, body: &Markup) -> Markup {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (title) }
                style { (PreEscaped(STYLE)) }
            }
            body { main { (body) } }
        }
    };
    PreEscaped(plain::text(page.into_string()))
}

pub(super) fn section(title: &str, content: Option<Markup>) -> Markup {
    html! {
        @if let Some(content) = content {
            section { h2 { (title) } (content) }
        }
    }
}

fn artifacts(names: &[String]) -> Option<Markup> {
    if names.is_empty() {
        return None;
    }
    Some(html! {
        p { "Beside this page:" }
        ul { @for name in names { li { code { (name) } } } }
    })
}

/// What the bench did by commands of its own; nothing where the plan asks for none.
fn bench_commands(commands: &[CommandSummary]) -> Option<Markup> {
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
    use super::{CommandSummary, bench_commands};

    #[test]
    fn what_was_run_and_what_was_not_is_told_apart() {
        assert!(bench_commands(&[]).is_none());
        let mut all = Vec::new();
        CommandSummary::passed_over(&mut all, "flash");
        CommandSummary::ran(&mut all, "power-on", 0.25, "exit status: 0");
        let page = bench_commands(&all).unwrap().into_string();
        assert!(page.contains("<code>flash</code></td><td class=\"number\">0</td>"), "{page}");
        assert!(page.contains("not run: in virtual time"), "{page}");
        assert!(page.contains("0.250 s</td><td>exit status: 0</td>"), "{page}");
    }
}
