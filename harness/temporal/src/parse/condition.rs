//! Connectives: `->`, `or`, `and`, `until`, `since`, `not`, and the prefixes before a colon.

use super::lexer::Token;
use super::{Parser, Part, What};
use crate::formula::{Condition, Interval, Premise};
use crate::mistake::Mistake;
use std::ops::Range;

impl Parser<'_> {
    pub(super) fn implication(&mut self) -> Result<Part, Mistake> {
        self.deeper(|parser| {
            let left = parser.disjunction()?;
            if !parser.is_symbol("->") {
                return Ok(left);
            }
            if left.is_open {
                let mistake = Mistake::new(parser.at.clone(), "this `->` can be read in two ways");
                let help = "put parentheses around what the colon is to reach";
                return Err(mistake.help(help));
            }
            parser.advance()?;
            let right = parser.implication()?;
            let (of_left, at) = (left.at.clone(), left.at.start..right.at.end);
            let is_open = right.is_open;
            let (left, right) = (parser.condition(left)?, parser.condition(right)?);
            if parser.nesting == 1 {
                parser.premise = Some(Premise::new(parser.said(&of_left), left.clone(), &right));
            }
            let condition = Condition::Or(negated(left), Box::new(right));
            Ok(Part { is_open, ..Part::condition(condition, at) })
        })
    }

    fn disjunction(&mut self) -> Result<Part, Mistake> {
        let mut left = self.conjunction()?;
        while self.next == Token::Name("or") || self.is_symbol("||") {
            self.advance()?;
            let right = self.conjunction()?;
            left = self.joined(left, right, Condition::Or)?;
        }
        Ok(left)
    }

    fn conjunction(&mut self) -> Result<Part, Mistake> {
        let mut left = self.timed()?;
        while self.next == Token::Name("and") || self.is_symbol("&&") {
            self.advance()?;
            let right = self.timed()?;
            left = self.joined(left, right, Condition::And)?;
        }
        Ok(left)
    }

    fn joined(
        &mut self,
        left: Part,
        right: Part,
        join: fn(Box<Condition>, Box<Condition>) -> Condition,
    ) -> Result<Part, Mistake> {
        for part in [&left, &right] {
            if let Some(at) = &part.bare {
                let mistake = Mistake::new(
                    at.clone(),
                    format!("this `{}` can be read in two ways", self.said(at)),
                );
                return Err(
                    mistake.help("put parentheses around its two sides or around the whole")
                );
            }
        }
        let (at, is_open) = (left.at.start..right.at.end, right.is_open);
        let (left, right) = (self.condition(left)?, self.condition(right)?);
        Ok(Part { is_open, ..Part::condition(join(Box::new(left), Box::new(right)), at) })
    }

    /// `until` and `since`.
    fn timed(&mut self) -> Result<Part, Mistake> {
        let left = self.negation()?;
        let Token::Name(word @ ("until" | "since")) = self.next else { return Ok(left) };
        let word_at = self.at.clone();
        self.advance()?;
        let window = if self.is_symbol("[") { Some(self.window()?) } else { None };
        let interval = match window {
            None if word == "until" => return Err(without_end(word, word_at, " ")),
            window => window.unwrap_or(Interval { from: 0, to: None }),
        };
        let right = self.negation()?;
        if matches!(self.next, Token::Name("until" | "since")) {
            let mistake = Mistake::new(self.at.clone(), "`until` and `since` do not chain");
            return Err(mistake.help("put parentheses around the first"));
        }
        let (at, is_open) = (left.at.start..right.at.end, right.is_open);
        let (left, right) = (self.condition(left)?, self.condition(right)?);
        let make = if word == "until" { Condition::Until } else { Condition::Since };
        let condition = make(interval, Box::new(left), Box::new(right));
        Ok(Part { bare: Some(word_at), is_open, ..Part::condition(condition, at) })
    }

    fn negation(&mut self) -> Result<Part, Mistake> {
        if self.next != Token::Name("not") && !self.is_symbol("!") {
            return self.prefixed();
        }
        let start = self.at.start;
        self.advance()?;
        let of = self.deeper(Self::negation)?;
        let (at, is_open) = (start..of.at.end, of.is_open);
        let of = self.condition(of)?;
        Ok(Part { is_open, ..Part::condition(*negated(of), at) })
    }

    /// `within 100 ms: ...` and similar prefixes.
    fn prefixed(&mut self) -> Result<Part, Mistake> {
        let Token::Name(word) = self.next else { return self.comparison() };
        let at = self.at.clone();
        let make = match word {
            "within" | "eventually" => Condition::Eventually,
            "for" | "always" => Condition::Always,
            "once" => Condition::Once,
            "historically" => Condition::Historically,
            _ => return self.comparison(),
        };
        self.advance()?;
        let interval = match word {
            "within" | "for" => self.length(word)?,
            _ if self.is_symbol("[") => self.window()?,
            "once" | "historically" => Interval { from: 0, to: None },
            _ => return Err(without_end(word, at, ": ")),
        };
        if !self.is_symbol(":") {
            let said = self.said(&(at.start..self.end));
            return Err(self.unexpected("`:`").help(format!("write `{said}: ...`")));
        }
        self.advance()?;
        let of = self.deeper(Self::disjunction)?;
        let at = at.start..of.at.end;
        let of = self.condition(of)?;
        Ok(Part { is_open: true, ..Part::condition(make(interval, Box::new(of)), at) })
    }

    /// Requires a part that is true or false.
    pub(super) fn condition(&self, part: Part) -> Result<Condition, Mistake> {
        match part.what {
            What::Condition(condition) => Ok(condition),
            What::Quantity(_) => {
                let said = self.said(&part.at);
                let mistake =
                    Mistake::new(part.at, format!("`{said}` is a number, not a condition"));
                Err(mistake.help(format!("compare it: `{said} != 0`")))
            }
            What::Named(name) => {
                let mistake = Mistake::new(part.at, format!("`\"{name}\"` alone is no condition"));
                Err(mistake.help(format!("write `signal == \"{name}\"`")))
            }
        }
    }
}

/// The mistake of a forward-looking operator without an end: its memory would have no bound.
fn without_end(word: &str, at: Range<usize>, behind: &str) -> Mistake {
    let mistake = Mistake::new(at, format!("`{word}` must say how far it looks ahead"));
    let help = format!("write `{word} [0 s, 10 s]{behind}...`");
    mistake.help(match word {
        "always" => format!("{help}; the whole formula holds at every moment anyhow"),
        _ => help,
    })
}

fn negated(of: Condition) -> Box<Condition> {
    Box::new(match of {
        Condition::Not(of) => *of,
        of => Condition::Not(Box::new(of)),
    })
}
