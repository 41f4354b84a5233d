//! Parts of statements, and the starts of statements.

use super::cursor::{Cursor, Unexpected};

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Value {
    Number(f64),
    Text(String),
}

impl Value {
    /// The number, which some tools put in quotes.
    pub(super) fn number(&self) -> Option<f64> {
        match self {
            Self::Number(number) => Some(*number),
            Self::Text(text) => text.trim().parse().ok(),
        }
    }

    pub(super) fn text(&self) -> Option<&str> {
        match self {
            Self::Text(text) if !text.is_empty() => Some(text),
            _ => None,
        }
    }
}

/// The object of an attribute or a comment.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Of {
    Node(String),
    /// By its identifier as written in the file.
    Message(u64),
    /// By the identifier and the signal's name.
    Signal(u64, String),
}

/// The words that start a statement.
const SECTIONS: &str = "BA_ BA_DEF_ BA_DEF_DEF_ BA_DEF_DEF_REL_ BA_DEF_REL_ BA_DEF_SGTYPE_ BA_REL_ BA_SGTYPE_ \
    BO_ BO_TX_BU_ BS_ BU_ BU_BO_REL_ BU_EV_REL_ BU_SG_REL_ CAT_ CAT_DEF_ CM_ ENVVAR_DATA_ \
    EV_ EV_DATA_ FILTER NS_ NS_DESC_ SGTYPE_ SGTYPE_VAL_ SG_ SG_MUL_VAL_ SIGTYPE_VALTYPE_ \
    SIG_GROUP_ SIG_TYPE_REF_ SIG_VALTYPE_ VAL_ VAL_TABLE_ VERSION";

pub(super) fn is_section(word: &str) -> bool {
    SECTIONS.split(' ').any(|section| section == word)
}

/// Skips the symbols below `NS_ :`, each on its own line, up to the first section.
pub(super) fn symbols(cursor: &mut Cursor<'_>) {
    cursor.takes(':');
    loop {
        let mut ahead = cursor.clone();
        // A section continues after its name, a symbol does not.
        if ahead.word("").is_err() || !(ahead.begins_a_line() || ahead.is_at_end()) {
            return;
        }
        *cursor = ahead;
    }
}

/// Names separated by blanks or commas, up to the start of a statement; `end` is set to the position after the last.
pub(super) fn names(cursor: &mut Cursor<'_>, end: &mut usize) -> Vec<String> {
    let mut names = Vec::new();
    loop {
        cursor.takes(',');
        match cursor.peek() {
            "" => return names,
            word if is_section(word) || word.starts_with(|c: char| c.is_ascii_digit()) => {
                return names;
            }
            word => names.push(word.to_owned()),
        }
        // Cannot fail: the word was peeked.
        let _ = cursor.word("");
        *end = cursor.behind();
    }
}

/// `M`, `m1`, `m1M`, or nothing.
pub(super) fn multiplexing(cursor: &mut Cursor<'_>) -> Result<(Option<u64>, bool), Unexpected> {
    let word = cursor.peek();
    let (page, multiplexes) = match word.strip_suffix('M') {
        Some(page) => (page, true),
        None => (word, false),
    };
    let page = match page {
        "" => None,
        _ => match page.strip_prefix('m').and_then(|number| number.parse().ok()) {
            Some(number) => Some(number),
            None => {
                return Err(
                    cursor.unexpected("`:`, or what multiplexes the signal: `M`, `m1`, `m1M`")
                );
            }
        },
    };
    if !word.is_empty() {
        cursor.word("")?;
    }
    Ok((page, multiplexes))
}

/// `0+`: whether the most significant byte comes first, and whether there is a sign.
pub(super) fn byte_order(cursor: &mut Cursor<'_>) -> Result<(bool, bool), Unexpected> {
    let read = match cursor.peek() {
        "0+" => (true, false),
        "0-" => (true, true),
        "1+" => (false, false),
        "1-" => (false, true),
        _ => {
            let expected = "byte order and sign: `1` (little endian) or `0` (big endian), \
                            then `+` (unsigned) or `-` (signed)";
            return Err(cursor.unexpected(expected));
        }
    };
    cursor.word("")?;
    Ok(read)
}

/// The object of a comment or an attribute; `None` for the whole file or for an unused object.
pub(super) fn of(cursor: &mut Cursor<'_>) -> Result<Option<Of>, Unexpected> {
    let id = "the identifier of a message";
    Ok(match cursor.peek() {
        "BU_" => {
            cursor.word("")?;
            Some(Of::Node(cursor.word("the name of a node")?.to_owned()))
        }
        "BO_" => {
            cursor.word("")?;
            Some(Of::Message(cursor.whole(id)?))
        }
        "SG_" => {
            cursor.word("")?;
            let id = cursor.whole(id)?;
            Some(Of::Signal(id, cursor.word("the name of a signal")?.to_owned()))
        }
        "EV_" => {
            cursor.word("")?;
            cursor.word("the name of an environment variable")?;
            None
        }
        _ => None,
    })
}

pub(super) fn value(cursor: &mut Cursor<'_>) -> Result<Value, Unexpected> {
    if cursor.peek().is_empty() {
        return Ok(Value::Text(cursor.string("a number, or a text in quotation marks")?));
    }
    Ok(Value::Number(cursor.number("a number, or a text in quotation marks")?))
}

/// The semicolon after a statement, which some files omit at the end of a line.
pub(super) fn end(cursor: &mut Cursor<'_>) -> Result<(), Unexpected> {
    if cursor.takes(';') || cursor.begins_a_line() || cursor.is_at_end() {
        return Ok(());
    }
    Err(cursor.unexpected("`;` at the end of the statement"))
}
