//! Message definitions (`.msg`), as bags of ROS 1 and ROS 2 contain them.
//!
//! Source: wiki.ros.org/msg and docs.ros.org, "Interfaces". A definition is followed by those that it uses, each after a
//! line of `=` and a line `MSG: package/Type`.

use std::collections::BTreeMap;

/// Longest text of a definition with those that it uses.
const TEXT_BYTES_MAX: usize = 1024 * 1024;

/// Deepest nesting of messages.
const DEPTH_MAX: usize = 32;

/// The shortest line of `=` between two definitions.
const RULE_LENGTH_MIN: usize = 40;

/// Type of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Number {
    Bool,
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Number {
    pub(super) const fn bytes(self) -> usize {
        match self {
            Self::Bool | Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }
}

/// Type of a field or of its elements.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Number(Number),
    /// Seconds and nanoseconds.
    Stamp(Number, Number),
    Text,
    /// Index of a message.
    Message(usize),
}

/// Whether a field is an array.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Count {
    One,
    Fixed(u32),
    /// The data have the number of elements.
    Any,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Field {
    pub name: String,
    pub kind: Kind,
    pub count: Count,
}

#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Message {
    pub fields: Vec<Field>,
    /// Bytes that it has at least, without padding. Without any, it has no content.
    pub bytes_min: u64,
}

/// A message type, and those that it contains.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Definition {
    /// Each after those that it contains.
    messages: Vec<Message>,
}

impl Definition {
    /// The definition of message `name` (`package/Type` or `package/msg/Type`). `is_ros_2` decides how times and empty
    /// messages are stored.
    pub(super) fn parse(name: &str, text: &str, is_ros_2: bool) -> Result<Self, String> {
        if text.len() > TEXT_BYTES_MAX {
            return Err(format!("its definition is longer than {TEXT_BYTES_MAX} bytes"));
        }
        let mut sections = BTreeMap::<String, Vec<&str>>::new();
        let (name, mut lines) = (plain(name), text.lines());
        let mut section: &mut Vec<&str> = sections.entry(name.clone()).or_default();
        while let Some(line) = lines.next() {
            let line = line.trim();
            if line.len() < RULE_LENGTH_MIN || line.bytes().any(|byte| byte != b'=') {
                section.push(line);
                continue;
            }
            let head = lines.next().unwrap_or_default();
            let Some(name) = head.trim().strip_prefix("MSG:") else {
                return Err(format!("found `{head}` in its definition, expected `MSG: TYPE`"));
            };
            section = sections.entry(plain(name.trim())).or_default();
            section.clear();
        }
        let mut parser =
            Parser { sections, is_ros_2, done: BTreeMap::new(), messages: Vec::new(), open: 0 };
        parser.message(&name)?;
        Ok(Self { messages: parser.messages })
    }

    pub(super) fn root(&self) -> usize {
        self.messages.len().saturating_sub(1)
    }

    pub(super) fn message(&self, index: usize) -> &Message {
        &self.messages[index]
    }

    /// Bytes that a value has at least.
    pub(super) fn bytes_min(&self, kind: Kind) -> u64 {
        bytes_min(&self.messages, kind)
    }

    /// The way to a field with one value, such as `pose.position.x` or `covariance[0]`, and its type: the number of the
    /// field in its message, then of the element if it is in an array, and so on.
    pub(super) fn path(&self, name: &str) -> Option<(Vec<u32>, Kind)> {
        let (mut path, mut kind) = (Vec::new(), Kind::Message(self.root()));
        for part in name.split('.') {
            let Kind::Message(message) = kind else { return None };
            let (name, element) = match part.strip_suffix(']') {
                Some(part) => part.split_once('[').map(|(name, at)| (name, Some(at)))?,
                None => (part, None),
            };
            let fields = &self.message(message).fields;
            let at = fields.iter().position(|field| field.name == name)?;
            path.push(u32::try_from(at).ok()?);
            let element = element.map(str::parse::<u32>).transpose().ok()?;
            match (fields[at].count, element) {
                (Count::One, None) => {}
                (Count::Fixed(count), Some(element)) if element < count => path.push(element),
                (Count::Any, Some(element)) => path.push(element),
                _ => return None,
            }
            kind = fields[at].kind;
        }
        (!matches!(kind, Kind::Message(_))).then_some((path, kind))
    }
}

/// `package/Type` of a type's name.
fn plain(name: &str) -> String {
    name.replacen("/msg/", "/", 1)
}

fn bytes_min(messages: &[Message], kind: Kind) -> u64 {
    match kind {
        Kind::Number(number) => number.bytes() as u64,
        Kind::Stamp(..) => 8,
        Kind::Text => 4,
        Kind::Message(index) => messages[index].bytes_min,
    }
}

struct Parser<'a> {
    sections: BTreeMap<String, Vec<&'a str>>,
    is_ros_2: bool,
    done: BTreeMap<String, usize>,
    messages: Vec<Message>,
    /// Number of messages that are being parsed, each in the one before.
    open: usize,
}

impl Parser<'_> {
    fn message(&mut self, name: &str) -> Result<usize, String> {
        if let Some(index) = self.done.get(name) {
            return Ok(*index);
        }
        let Some(lines) = self.sections.get(name).cloned() else {
            return Err(format!("its definition lacks {name}"));
        };
        if self.open == DEPTH_MAX {
            return Err(format!("its definition has more than {DEPTH_MAX} messages in each other"));
        }
        self.open += 1;
        let package = name.split_once('/').map_or("", |(package, _)| package);
        let mut message = Message::default();
        for line in lines {
            if let Some(field) = self.field(package, line)? {
                let least = bytes_min(&self.messages, field.kind);
                let least = match field.count {
                    Count::One => least,
                    Count::Fixed(count) => least.saturating_mul(count.into()),
                    Count::Any => 4,
                };
                message.bytes_min = message.bytes_min.saturating_add(least);
                message.fields.push(field);
            }
        }
        if self.is_ros_2 && message.fields.is_empty() {
            // A message without fields has one that is not in the definition (rosidl).
            let name = "structure_needs_at_least_one_member".to_owned();
            let kind = Kind::Number(Number::U8);
            message =
                Message { fields: vec![Field { name, kind, count: Count::One }], bytes_min: 1 };
        }
        self.open -= 1;
        self.messages.push(message);
        let index = self.messages.len() - 1;
        self.done.insert(name.to_owned(), index);
        Ok(index)
    }

    /// The field of a line; `None` for a line that declares no field, such as a constant.
    fn field(&mut self, package: &str, line: &str) -> Result<Option<Field>, String> {
        let code = line.split('#').next().unwrap_or_default().trim();
        if code.is_empty() {
            return Ok(None);
        }
        let bad = || format!("found `{line}` in its definition, expected a type and a name");
        let (kind, rest) = code.split_once(char::is_whitespace).ok_or_else(bad)?;
        let rest = rest.trim_start();
        let end = rest.find(|c: char| c == '=' || c.is_whitespace()).unwrap_or(rest.len());
        let (name, rest) = rest.split_at(end);
        if rest.trim_start().starts_with('=') {
            return Ok(None);
        }
        if name.is_empty() {
            return Err(bad());
        }
        let (kind, count) = match kind.strip_suffix(']') {
            None => (kind, Count::One),
            Some(kind) => {
                let (kind, count) = kind.rsplit_once('[').ok_or_else(bad)?;
                match count {
                    count if count.is_empty() || count.starts_with("<=") => (kind, Count::Any),
                    count => (kind, Count::Fixed(count.parse().map_err(|_| bad())?)),
                }
            }
        };
        let kind = self.kind(package, kind)?;
        Ok(Some(Field { name: name.to_owned(), kind, count }))
    }

    fn kind(&mut self, package: &str, name: &str) -> Result<Kind, String> {
        let name = name.split_once("<=").map_or(name, |(name, _)| name);
        let number = match name {
            "bool" => Number::Bool,
            "int8" => Number::I8,
            // A byte has a sign in ROS 1.
            "byte" if !self.is_ros_2 => Number::I8,
            "uint8" | "char" | "byte" => Number::U8,
            "int16" => Number::I16,
            "uint16" => Number::U16,
            "int32" => Number::I32,
            "uint32" => Number::U32,
            "int64" => Number::I64,
            "uint64" => Number::U64,
            "float32" => Number::F32,
            "float64" => Number::F64,
            "string" => return Ok(Kind::Text),
            "time" if !self.is_ros_2 => return Ok(Kind::Stamp(Number::U32, Number::U32)),
            "duration" if !self.is_ros_2 => return Ok(Kind::Stamp(Number::I32, Number::I32)),
            "wstring" => return Err("its definition has a wstring, which is not read".to_owned()),
            _ => {
                let name = match name {
                    "Header" => "std_msgs/Header".to_owned(),
                    _ if name.contains('/') => plain(name),
                    _ => format!("{package}/{name}"),
                };
                return match name.as_str() {
                    "builtin_interfaces/Time" | "builtin_interfaces/Duration" => {
                        Ok(Kind::Stamp(Number::I32, Number::U32))
                    }
                    _ => self.message(&name).map(Kind::Message),
                };
            }
        };
        Ok(Kind::Number(number))
    }
}
