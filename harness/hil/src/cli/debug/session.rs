//! A run that stops where the user asks: the sink of the run's record, which does not return before the run may
//! continue.

use super::super::determinism::is_in_each_record;
use super::super::tame::tamed;
use super::asked::{Asked, HELP, Until, asked};
use super::seconds;
use exchange::moment::Moment;
use record::header::Header;
use record::sink::{Level, RecordSink};
use record::text::Line;
use record::{Record, RecordKind};
use std::cell::Cell;
use std::io::{self, BufRead, Write};
use wire::time::Timestamp;

/// A run in virtual time and its user.
pub(super) struct Session<'a, R, W, I> {
    input: R,
    output: W,
    /// A user sits at the terminal.
    is_asked: bool,
    /// The next record of the previous run, and those after it.
    then: Option<Record>,
    recorded: I,
    /// The previous record holds bytes, frames, and every state and truth.
    is_full: bool,
    /// A difference from the recorded run has been reported.
    differs: bool,
    header: &'a Header,
    moment: Moment,
    until: Until,
    has_left: &'a Cell<bool>,
    failed: Option<io::Error>,
}

impl<'a, R: BufRead, W: Write, I: Iterator<Item = Record>> Session<'a, R, W, I> {
    /// Creates a session that reads commands and prints its output, with the records of the previous run, which may be
    /// complete or hold only events.
    pub(super) fn new(
        (input, output): (R, W),
        is_asked: bool,
        (mut recorded, is_full): (I, bool),
        (moment, header): (Moment, &'a Header),
        has_left: &'a Cell<bool>,
    ) -> Self {
        Self {
            input,
            output,
            is_asked,
            then: recorded.next(),
            recorded,
            is_full,
            differs: false,
            header,
            moment,
            until: Until::End,
            has_left,
            failed: None,
        }
    }

    pub(super) fn go_to(&mut self, at: Timestamp) {
        self.until = Until::Moment(at);
    }

    /// Reports the end of the run at `at`.
    pub(super) fn close(mut self, at: Timestamp) -> io::Result<()> {
        if !self.has_left.get() {
            match &self.until {
                Until::Line(text) => {
                    let missed = format!("no record with `{text}` up to the end");
                    self.print(&missed);
                }
                Until::Moment(_) => self.show(),
                _ => {}
            }
            match self.then.take() {
                _ if self.differs => {}
                Some(then) => {
                    let then = self.line(&then);
                    self.print(&format!(
                        "not as recorded: recorded `{}`, now the end",
                        then.trim()
                    ));
                }
                None => self.print("as recorded to the end"),
            }
            self.print(&format!("the run ended at {}", seconds(at)));
        }
        if let Err(error) = self.output.flush() {
            self.broken(error);
        }
        self.failed.map_or(Ok(()), Err)
    }

    fn line(&self, record: &Record) -> String {
        Line(record, self.header).to_string()
    }

    /// Returns the record's line, followed by the messages that it completes.
    fn lines(&self, record: &Record) -> Vec<String> {
        std::iter::once(self.line(record)).chain(self.moment.heard()).collect()
    }

    fn is_looked_for(&self, line: &str) -> bool {
        matches!(&self.until, Until::Line(text) if line.contains(&**text))
    }

    fn print(&mut self, line: &str) {
        if let Err(error) = writeln!(self.output, "{}", tamed(line)) {
            self.broken(error);
        }
    }

    /// A reader that closes early is no error.
    fn broken(&mut self, error: io::Error) {
        self.has_left.set(true);
        if error.kind() != io::ErrorKind::BrokenPipe {
            self.failed.get_or_insert(error);
        }
    }

    fn show(&mut self) {
        for line in self.moment.lines() {
            self.print(&line);
        }
    }

    /// Stops until the run may continue, before the record at `at`.
    fn stop(&mut self, at: Timestamp) {
        while !self.has_left.get() {
            if self.is_asked {
                let prompt = write!(self.output, "hil> ");
                prompt.unwrap_or_else(|error| self.broken(error));
            }
            self.output.flush().unwrap_or_else(|error| self.broken(error));
            let mut line = String::new();
            match self.input.read_line(&mut line) {
                Ok(1..) => {}
                Ok(0) => return self.has_left.set(true),
                Err(error) => return self.broken(error),
            }
            match asked(&line) {
                Ok(Asked::Go(Until::Moment(moment))) if moment < at => {
                    self.print(&format!("already past {}", seconds(at)));
                }
                Ok(Asked::Go(until)) => return self.until = until,
                Ok(Asked::Show) => self.show(),
                Ok(Asked::Help) => self.print(HELP),
                Ok(Asked::Quit) => self.has_left.set(true),
                Err(why) => self.print(&why),
            }
        }
    }

    /// Reports once that the run differs from the recorded one.
    fn compare(&mut self, record: &Record) {
        if self.differs {
            return;
        }
        // NaN compares equal if its text is equal.
        let is_same = |then: &Record| then == record || self.line(then) == self.line(record);
        if self.then.as_ref().is_some_and(is_same) {
            self.then = self.recorded.next();
            return;
        }
        if !is_in_each_record(&record.kind) && !self.is_full {
            return;
        }
        self.differs = true;
        let then = match &self.then {
            Some(then) => format!("`{}`", self.line(then).trim()),
            None => "the end".to_owned(),
        };
        let now = self.line(record);
        self.print(&format!("not as recorded: recorded {then}, now `{}`", now.trim()));
    }
}

impl<R: BufRead, W: Write, I: Iterator<Item = Record>> RecordSink for Session<'_, R, W, I> {
    fn record(&mut self, record: Record) {
        while !self.has_left.get() && matches!(self.until, Until::Moment(at) if at < record.at) {
            self.show();
            self.stop(record.at);
        }
        if self.has_left.get() {
            return;
        }
        self.compare(&record);
        self.moment.take(&record);
        let is_step =
            matches!(record.kind, RecordKind::StepBegan { .. } | RecordKind::StepEnded { .. });
        let (prints, stops) = match &mut self.until {
            Until::Records(left) => {
                *left -= 1;
                (true, *left == 0)
            }
            Until::Step => (is_step, is_step),
            Until::Line(_) => {
                let found = self.lines(&record).iter().any(|line| self.is_looked_for(line));
                (found, found)
            }
            Until::Moment(_) | Until::End => (false, false),
        };
        if prints {
            self.lines(&record).iter().for_each(|line| self.print(line));
        }
        if stops {
            self.stop(record.at);
        }
    }

    fn level(&self) -> Level {
        Level::Full
    }

    fn failed(&self) -> Option<&io::Error> {
        self.failed.as_ref()
    }

    fn finish(&mut self) {}
}

#[cfg(test)]
mod tests {
    use super::Session;
    use exchange::moment::Moment;
    use exchange::tables::Ears;
    use record::header::Header;
    use record::sink::RecordSink;
    use record::{Device, Record, RecordKind};
    use std::cell::Cell;
    use wire::time::Timestamp;

    fn note(at_s: f64, text: &str) -> Record {
        let kind = RecordKind::Note(text.to_owned());
        Record { at: Timestamp::from_secs_f64(at_s), device: Device::Plan, kind }
    }

    fn frame(at_s: f64) -> Record {
        Record { kind: RecordKind::Bytes(vec![1]), ..note(at_s, "") }
    }

    /// Output of a session with these recorded records, new records and commands.
    fn said(recorded: &[Record], now: &[Record], orders: &str) -> String {
        let header = Header::default();
        let has_left = Cell::new(false);
        let is_full = recorded.iter().any(|one| matches!(one.kind, RecordKind::Bytes(_)));
        let moment = Moment::new(header.clone(), Ears::deaf());
        let mut output = Vec::new();
        let lines = (recorded.iter().cloned(), is_full);
        let mut session = Session::new(
            (orders.as_bytes(), &mut output),
            false,
            lines,
            (moment, &header),
            &has_left,
        );
        session.go_to(Timestamp::ZERO);
        now.iter().cloned().for_each(|record| session.record(record));
        session.close(Timestamp::from_secs_f64(9.0)).unwrap();
        let text = String::from_utf8(output).unwrap();
        text.lines()
            .map(|line| line.split_whitespace().collect::<Vec<_>>().join(" ") + "\n")
            .collect()
    }

    #[test]
    fn it_stops_where_one_asks() {
        let records = [note(1.0, "a"), frame(1.5), note(2.0, "b"), note(3.0, "c"), note(4.0, "d")];
        let text = said(&records, &records, "step\nto 0.5\nfind note b\nstep 1\nend\n");
        insta::assert_snapshot!(text, @r"
        1.000000000 plan note a
        already past 1.000000 s
        2.000000000 plan note b
        3.000000000 plan note c
        as recorded to the end
        the run ended at 9.000000 s
        ");
        // Found by a user: what is looked for and never comes was not told.
        let missed = said(&records, &records, "find note b\nfind zzz\nshow\n");
        insta::assert_snapshot!(missed, @r"
        2.000000000 plan note b
        no record with `zzz` up to the end
        as recorded to the end
        the run ended at 9.000000 s
        ");
        // The end of the input leaves the session.
        assert_eq!(said(&records, &records, "step 2\n").lines().count(), 2);
    }

    #[test]
    fn the_first_difference_is_told_once() {
        let (a, b) =
            ([note(1.0, "a"), note(2.0, "b")], [note(1.0, "a"), note(2.0, "x"), note(3.0, "y")]);
        let first = |a: &[Record], b: &[Record]| {
            said(a, b, "end\n").lines().next().unwrap_or("").to_owned()
        };
        assert_eq!(
            said(&a, &b, "end\n"),
            "not as recorded: recorded `2.000000000 plan note b`, now `2.000000000 plan note x`\n\
             the run ended at 9.000000 s\n"
        );
        assert_eq!(
            first(&a, &a[..1]),
            "not as recorded: recorded `2.000000000 plan note b`, now the end"
        );
        assert_eq!(
            first(&a[..1], &a),
            "not as recorded: recorded the end, now `2.000000000 plan note b`"
        );
        // What a record of events leaves out is no difference; in a complete record it is.
        let with_bytes = [a[0].clone(), frame(1.5), a[1].clone()];
        assert!(said(&a, &with_bytes, "end\n").contains("as recorded to the end"));
        assert!(said(&with_bytes, &a, "end\n").contains("not as recorded"));
    }
}
