//! The compensation that a firmware applies to readings to reduce their errors, ready to copy.

use identification::finding::{Compensation, Finding};
use maud::{Markup, html};
use record::figures;

pub(super) fn steps(finding: &Finding) -> Option<Markup> {
    finding.compensations().next()?;
    Some(html! { @for one in finding.compensations() { (steps_of(one)) } })
}

fn steps_of(compensation: &Compensation) -> Markup {
    let Compensation { of, unit, inputs, steps, held_out, left_out } = compensation;
    let error = |value| figures::with_unit(figures::exact(value, 3), unit);
    let (before, after) = (error(held_out.before), error(held_out.after));
    html! {
        p {
            "Done with every reading of " code { (of) } ", in this order, the last step is the reading without the errors \
             that were found. On runs that took no part in the fit of its numbers its error is "
            (after) " root mean square, that of the readings as they are " (before) ". "
            code { "NAME_before" } " is what NAME was at the reading before; what stands behind \u{201c}at first\u{201d} holds \
             at the first reading."
        }
        pre {
            @for input in inputs {
                (input.name) ": " (input.of) @if !input.unit.is_empty() { ", " (input.unit) } "\n"
            }
            "\n"
            @for step in steps {
                (step.name) " = " (step.expression)
                @if let Some(first) = &step.first { "    (at first " (first) ")" }
                "\n"
            }
        }
        @for one in left_out {
            p { code { (one.term) } " is left out: " (one.why) "." }
        }
    }
}
