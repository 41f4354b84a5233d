//! Tables of a page, and how much of what is counted is drawn.

use maud::{Markup, html};
use record::figures;

/// A table that scrolls where it is too wide. A head of a column of numbers begins with `#`.
pub(super) fn table(class: Option<&str>, heads: &[&str], rows: &Markup) -> Markup {
    html! {
        div.scroll {
            table class=[class] {
                thead {
                    tr {
                        @for head in heads {
                            @match head.strip_prefix('#') {
                                Some(head) => th.number { (head) },
                                None => th { (head) },
                            }
                        }
                    }
                }
                tbody { (rows) }
            }
        }
    }
}

/// For [`counted`].
pub(super) const LOWEST_AND_HIGHEST: &str = "the lowest and the highest of each column";

/// `5000 observations; 560 drawn, the lowest and the highest of each column`.
pub(super) fn counted(all: usize, what: &str, drawn: usize, kept: &str) -> Markup {
    html! {
        (figures::counted(all as u64, what, &format!("{what}s")))
        @if drawn < all { "; " (drawn) " drawn, " (kept) }
    }
}
