//! The statements of a DBC file, as far as they are used here: others are skipped.
//!
//! Sections may come in any order, as in existing files.

use super::cursor::{Cursor, Unexpected};
use super::parts::{
    Of, Value, byte_order, end, is_section, multiplexing, names, of, symbols, value,
};
use std::collections::BTreeMap;
use std::ops::Range;

/// Attributes that are used; the first two are widespread (Vector's "interaction layer").
pub(super) const CYCLE_TIME_MS: &str = "GenMsgCycleTime";
pub(super) const START_VALUE: &str = "GenSigStartValue";
/// Names of more than 32 letters.
pub(super) const LONG_NODE: &str = "SystemNodeLongSymbol";
pub(super) const LONG_MESSAGE: &str = "SystemMessageLongSymbol";
pub(super) const LONG_SIGNAL: &str = "SystemSignalLongSymbol";

/// Other conditions for sending a message.
pub(super) const SEND_TYPE: &str = "GenMsgSendType";
pub(super) const SIGNAL_SEND_TYPE: &str = "GenSigSendType";
pub(super) const CYCLE_TIME_FAST_MS: &str = "GenMsgCycleTimeFast";
pub(super) const REPETITIONS: &str = "GenMsgNrOfRepetition";
pub(super) const DELAY_TIME_MS: &str = "GenMsgDelayTime";
/// The role of a signal beside its value, as in Vector's files for J1939.
pub(super) const SIGNAL_TYPE: &str = "SigType";
/// Classic or FD, and whether the data phase of FD uses the faster rate.
pub(super) const FRAME_FORMAT: &str = "VFrameFormat";
pub(super) const BIT_RATE_SWITCH: &str = "CANFD_BRS";
/// Address of a node, in files for J1939.
pub(super) const ADDRESS: &str = "NmStationAddress";

const USED: [&str; 14] = [
    CYCLE_TIME_MS,
    START_VALUE,
    LONG_NODE,
    LONG_MESSAGE,
    LONG_SIGNAL,
    SEND_TYPE,
    SIGNAL_SEND_TYPE,
    CYCLE_TIME_FAST_MS,
    REPETITIONS,
    DELAY_TIME_MS,
    SIGNAL_TYPE,
    FRAME_FORMAT,
    BIT_RATE_SWITCH,
    ADDRESS,
];

/// `BO_ 100 Name: 8 Node`
#[derive(Debug, Clone, PartialEq)]
pub(super) struct MessageLine {
    /// With bit 31 set for 29-bit identifiers.
    pub(super) id: u64,
    pub(super) name: String,
    pub(super) bytes: u64,
    pub(super) sender: String,
    pub(super) at: Range<usize>,
    pub(super) signals: Vec<SignalLine>,
}

/// `SG_ Name m1 : 8|16@1- (0.1,-40) [0|100] "unit" Node`
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SignalLine {
    pub(super) name: String,
    /// `m1`: the number of the multiplexer that selects it.
    pub(super) page: Option<u64>,
    /// `M`, or `m1M`.
    pub(super) multiplexes: bool,
    pub(super) start: u64,
    pub(super) length: u64,
    pub(super) is_big_endian: bool,
    pub(super) is_signed: bool,
    pub(super) factor: f64,
    pub(super) offset: f64,
    pub(super) minimum: f64,
    pub(super) maximum: f64,
    pub(super) unit: String,
    pub(super) at: Range<usize>,
}

/// `SG_MUL_VAL_ 100 Signal Multiplexer 1-1, 5-7;`: the name of the multiplexer and its numbers.
pub(super) type Extended = (String, Vec<(u64, u64)>);

#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Syntax {
    pub(super) nodes: Vec<String>,
    pub(super) nodes_at: Range<usize>,
    pub(super) messages: Vec<MessageLine>,
    pub(super) senders: BTreeMap<u64, Vec<String>>,
    pub(super) comments: BTreeMap<Of, String>,
    pub(super) defaults: BTreeMap<String, Value>,
    /// The values of `ENUM` attributes, by number.
    choices: BTreeMap<String, Vec<String>>,
    pub(super) attributes: BTreeMap<(Of, String), Value>,
    /// Names of values of signals.
    pub(super) values: BTreeMap<(u64, String), Vec<(i64, String)>>,
    /// Kinds of floating-point signals.
    pub(super) kinds: BTreeMap<(u64, String), u64>,
    pub(super) extended: BTreeMap<(u64, String), Vec<Extended>>,
}

impl Syntax {
    /// # Errors
    /// With the first position that does not match the syntax.
    pub(super) fn parse(text: &str) -> Result<Self, Unexpected> {
        let mut cursor = Cursor::new(text);
        let mut file = Self::default();
        while !cursor.is_at_end() {
            file.statement(&mut cursor)?;
        }
        Ok(file)
    }

    /// The attribute of that object, otherwise the default.
    pub(super) fn attribute(&self, of: Of, name: &str) -> Option<&Value> {
        self.attributes.get(&(of, name.to_owned())).or_else(|| self.defaults.get(name))
    }

    /// The text of an `ENUM` attribute, given directly or by its number.
    pub(super) fn choice(&self, of: Of, name: &str) -> Option<&str> {
        match self.attribute(of, name)? {
            Value::Number(number) => {
                self.choices.get(name)?.get(*number as usize).map(String::as_str)
            }
            value @ Value::Text(_) => value.text(),
        }
    }

    fn statement(&mut self, cursor: &mut Cursor<'_>) -> Result<(), Unexpected> {
        let word = cursor.peek();
        let begin = cursor.place();
        if !is_section(word) {
            let expected =
                "a section here: `BU_:`, `BO_`, ` SG_` below its `BO_`, `CM_`, `BA_`, `VAL_`";
            return Err(cursor.unexpected(expected));
        }
        cursor.word("")?;
        match word {
            "NS_" => symbols(cursor),
            "BU_" => self.nodes(cursor, begin)?,
            "BO_" => self.message(cursor, begin)?,
            "SG_" => self.signal(cursor, begin)?,
            "BO_TX_BU_" => self.senders(cursor)?,
            "CM_" => self.comment(cursor)?,
            "BA_DEF_" => self.definition(cursor),
            "BA_DEF_DEF_" => self.default_of(cursor)?,
            "BA_" => self.attribute_of(cursor)?,
            "VAL_" => self.values(cursor)?,
            "SIG_VALTYPE_" => self.kind(cursor)?,
            "SG_MUL_VAL_" => self.extended(cursor)?,
            _ => cursor.skip_statement(is_section),
        }
        Ok(())
    }

    /// `: A B`
    fn nodes(&mut self, cursor: &mut Cursor<'_>, begin: usize) -> Result<(), Unexpected> {
        cursor.mark(':', "`:` after `BU_`, then the names of the nodes")?;
        let mut end = cursor.behind();
        let names = names(cursor, &mut end);
        self.nodes.extend(names);
        self.nodes_at = begin..end;
        Ok(())
    }

    /// `100 Name: 8 Node`
    fn message(&mut self, cursor: &mut Cursor<'_>, begin: usize) -> Result<(), Unexpected> {
        let id = cursor.whole("the identifier of a message: `BO_ 100 Name: 8 Node`")?;
        let name = cursor.word("the name of a message: `BO_ 100 Name: 8 Node`")?.to_owned();
        cursor.mark(':', "`:` after the name of a message: `BO_ 100 Name: 8 Node`")?;
        let bytes = cursor.whole("how many bytes the message has: `BO_ 100 Name: 8 Node`")?;
        let at = begin..cursor.behind();
        // Some files omit it.
        let sender = match cursor.begins_a_line() || is_section(cursor.peek()) {
            true => String::new(),
            false => cursor.word("the node that sends the message")?.to_owned(),
        };
        self.messages.push(MessageLine { id, name, bytes, sender, at, signals: Vec::new() });
        Ok(())
    }

    /// `Name m1 : 8|16@1- (0.1,-40) [0|100] "unit" Node`
    fn signal(&mut self, cursor: &mut Cursor<'_>, begin: usize) -> Result<(), Unexpected> {
        let name = cursor.word("the name of a signal: `SG_ Name : 0|8@1+ ...`")?.to_owned();
        let (page, multiplexes) = multiplexing(cursor)?;
        cursor.mark(':', "`:` after the name of a signal: `SG_ Name : 0|8@1+ ...`")?;
        let start = cursor.whole("the start bit of the signal: `0|8@1+`")?;
        cursor.mark('|', "`|` between start bit and length: `0|8@1+`")?;
        let length = cursor.whole("the length of the signal in bits: `0|8@1+`")?;
        cursor.mark('@', "`@` and the byte order after the length: `0|8@1+`")?;
        let (is_big_endian, is_signed) = byte_order(cursor)?;
        cursor.mark('(', "`(factor,offset)` after the bits: `(0.1,-40)`")?;
        let factor = cursor.number("the factor, a number with a decimal point: `(0.1,-40)`")?;
        cursor.mark(',', "`,` between factor and offset: `(0.1,-40)`")?;
        let offset = cursor.number("the offset, a number with a decimal point: `(0.1,-40)`")?;
        cursor.mark(')', "`)` after the offset: `(0.1,-40)`")?;
        cursor.mark('[', "`[minimum|maximum]` after factor and offset: `[0|100]`")?;
        let minimum = cursor.number("the minimum, a number: `[0|100]`")?;
        cursor.mark('|', "`|` between minimum and maximum: `[0|100]`")?;
        let maximum = cursor.number("the maximum, a number: `[0|100]`")?;
        cursor.mark(']', "`]` after the maximum: `[0|100]`")?;
        let unit = cursor.string("the unit in quotation marks: `\"km/h\"`, or `\"\"`")?;
        let at = begin..cursor.behind();
        // The receivers are not used.
        names(cursor, &mut 0);
        let Some(message) = self.messages.last_mut() else {
            let expected =
                "`BO_ 100 Name: 8 Node` first: the message that the signal is in".to_owned();
            return Err(Unexpected { at, expected });
        };
        message.signals.push(SignalLine {
            name,
            page,
            multiplexes,
            start,
            length,
            is_big_endian,
            is_signed,
            factor,
            offset,
            minimum,
            maximum,
            unit,
            at,
        });
        Ok(())
    }

    /// `100 : A, B;`
    fn senders(&mut self, cursor: &mut Cursor<'_>) -> Result<(), Unexpected> {
        let id = cursor.whole("the identifier of a message")?;
        cursor.mark(':', "`:` after the identifier")?;
        self.senders.entry(id).or_default().extend(names(cursor, &mut 0));
        end(cursor)
    }

    /// `SG_ 100 Signal "what it is";` Real files have comments on things that they do not name; these are left out.
    fn comment(&mut self, cursor: &mut Cursor<'_>) -> Result<(), Unexpected> {
        let of = of(cursor).unwrap_or_default();
        while !cursor.begins_a_line() && cursor.word("").is_ok() {}
        let comment = cursor.string("the comment in quotation marks")?;
        if let Some(of) = of {
            self.comments.insert(of, comment);
        }
        end(cursor)
    }

    /// `BO_ "Attribute" ENUM "one","another";` Other kinds are skipped.
    fn definition(&mut self, cursor: &mut Cursor<'_>) {
        if matches!(cursor.peek(), "BU_" | "BO_" | "SG_" | "EV_") {
            _ = cursor.word("");
        }
        if let Ok(name) = cursor.string("")
            && USED.contains(&name.as_str())
            && cursor.peek() == "ENUM"
        {
            _ = cursor.word("");
            let mut choices = Vec::new();
            while let Ok(choice) = cursor.string("") {
                choices.push(choice);
                cursor.takes(',');
            }
            self.choices.insert(name, choices);
        }
        cursor.skip_statement(is_section);
    }

    /// `"Attribute" 0;`
    fn default_of(&mut self, cursor: &mut Cursor<'_>) -> Result<(), Unexpected> {
        let name = cursor.string("the name of an attribute in quotation marks")?;
        let value = value(cursor)?;
        if USED.contains(&name.as_str()) {
            self.defaults.insert(name, value);
        }
        end(cursor)
    }

    /// `"Attribute" BO_ 100 50;`
    fn attribute_of(&mut self, cursor: &mut Cursor<'_>) -> Result<(), Unexpected> {
        let name = cursor.string("the name of an attribute in quotation marks")?;
        let of = of(cursor)?;
        let value = value(cursor)?;
        if let (Some(of), true) = (of, USED.contains(&name.as_str())) {
            self.attributes.insert((of, name), value);
        }
        end(cursor)
    }

    /// `100 Signal 0 "off" 1 "on" ;`, or without the identifier those of an environment variable
    fn values(&mut self, cursor: &mut Cursor<'_>) -> Result<(), Unexpected> {
        let Ok(id) = cursor.whole("") else {
            cursor.skip_statement(is_section);
            return Ok(());
        };
        let signal = cursor.word("the name of a signal")?.to_owned();
        let mut values = Vec::new();
        while !cursor.peek().is_empty() && !is_section(cursor.peek()) {
            let number = cursor.number("a value of the signal, a number: `0 \"off\"`")?;
            let name = cursor.string("the name of the value in quotation marks: `0 \"off\"`")?;
            values.push((number as i64, name));
        }
        self.values.insert((id, signal), values);
        end(cursor)
    }

    /// `100 Signal : 1;`
    fn kind(&mut self, cursor: &mut Cursor<'_>) -> Result<(), Unexpected> {
        let id = cursor.whole("the identifier of a message")?;
        let signal = cursor.word("the name of a signal")?.to_owned();
        cursor.takes(':');
        let kind = cursor.whole("1 for a float of 32 bits, 2 for one of 64")?;
        self.kinds.insert((id, signal), kind);
        end(cursor)
    }

    /// `100 Signal Multiplexer 1-1, 5-7;`
    fn extended(&mut self, cursor: &mut Cursor<'_>) -> Result<(), Unexpected> {
        let id = cursor.whole("the identifier of a message")?;
        let signal = cursor.word("the name of a signal")?.to_owned();
        let multiplexer = cursor.word("the name of its multiplexer")?.to_owned();
        let mut numbers = Vec::new();
        while cursor.peek().starts_with(|c: char| c.is_ascii_digit()) {
            let range = cursor.peek().split_once('-');
            let ends = range.and_then(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)));
            let expected = "numbers of the multiplexer: `1-1, 5-7`";
            numbers.push(ends.ok_or_else(|| cursor.unexpected(expected))?);
            cursor.word("")?;
            cursor.takes(',');
        }
        self.extended.entry((id, signal)).or_default().push((multiplexer, numbers));
        end(cursor)
    }
}
