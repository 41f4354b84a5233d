//! Parses the name of a port; a mistake is reported with its position and with the permitted values.

use super::{
    BAUD, DATA_BITS, Flow, INTERFACE_LEN_MAX, PortSpec, SerialDevice, SerialOptions, SerialSpec,
    Sharing, UsbId,
};
use miette::SourceSpan;
use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::str::FromStr;
use wire::serial::Parity;
use wire::slcan::BitRate;

#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error("failed to read the port {spec:?}: {wrong}")]
pub struct SpecError {
    #[source_code]
    spec: String,
    wrong: String,
    #[label("here")]
    at: SourceSpan,
    /// What is permitted in its place.
    #[help]
    allowed: String,
}

const KINDS: &str = "pty, pty:LINK, serial:/dev/..., serial:usb:VENDOR:PRODUCT[:SERIAL], \
                     can:INTERFACE, slcan:/dev/..., slcan-pty, slcan-pty:LINK";
const OPTIONS: &[&str] = &["baud", "data", "parity", "stop", "flow", "exclusive"];
const SLCAN_OPTIONS: &[&str] = &["baud", "data", "parity", "stop", "flow", "exclusive", "bitrate"];

#[derive(Debug, Clone, Copy)]
struct Part<'a> {
    text: &'a str,
    at: usize,
}

/// A mistake in a part, before the whole string is known.
struct Mistake {
    wrong: String,
    at: SourceSpan,
    allowed: String,
}

impl<'a> Part<'a> {
    /// The parts before and after the first `separator`.
    fn split(self, separator: char) -> (Self, Option<Self>) {
        match self.text.split_once(separator) {
            Some((before, behind)) => {
                let at = self.at + before.len() + separator.len_utf8();
                (Self { text: before, at: self.at }, Some(Self { text: behind, at }))
            }
            None => (self, None),
        }
    }

    fn mistake(self, wrong: impl Into<String>, allowed: impl Into<String>) -> Mistake {
        // An empty part is shown by the character before it.
        let nothing = self.text.is_empty() && self.at > 0;
        let at = if nothing { (self.at - 1, 1) } else { (self.at, self.text.len()) }.into();
        Mistake { wrong: wrong.into(), at, allowed: allowed.into() }
    }

    /// The value of a numeric option within this range.
    fn number<T>(self, what: &str, range: &RangeInclusive<T>) -> Result<T, Mistake>
    where
        T: FromStr + PartialOrd + std::fmt::Display,
    {
        // A sign or blanks are not permitted here.
        let digits = self.text.bytes().all(|byte| byte.is_ascii_digit());
        let number = self.text.parse().ok().filter(|number| digits && range.contains(number));
        number.ok_or_else(|| {
            let (from, to) = (range.start(), range.end());
            self.mistake(format!("{:?} is no {what}", self.text), format!("{from} to {to}"))
        })
    }

    /// The value of an option with a few permitted words.
    fn word<T: Copy>(self, what: &str, words: &[(&str, T)]) -> Result<T, Mistake> {
        let known = words.iter().find(|(word, _)| *word == self.text);
        known.map(|(_, value)| *value).ok_or_else(|| {
            let known: Vec<&str> = words.iter().map(|(word, _)| *word).collect();
            self.mistake(format!("{:?} is no {what}", self.text), known.join(", "))
        })
    }
}

impl FromStr for PortSpec {
    type Err = SpecError;

    fn from_str(text: &str) -> Result<Self, SpecError> {
        parse(Part { text, at: 0 }).map_err(|Mistake { wrong, at, allowed }| SpecError {
            spec: text.to_owned(),
            wrong,
            at,
            allowed: format!("allowed here: {allowed}"),
        })
    }
}

impl TryFrom<String> for PortSpec {
    type Error = SpecError;

    fn try_from(text: String) -> Result<Self, SpecError> {
        text.parse()
    }
}

fn parse(whole: Part<'_>) -> Result<PortSpec, Mistake> {
    if whole.text.starts_with('/') {
        return Ok(PortSpec::Serial(serial(whole, OPTIONS)?.0));
    }
    let (kind, rest) = whole.split(':');
    // The place of the part after the colon.
    let missing = Part { text: "", at: whole.text.len() };
    let device = || rest.filter(|rest| !rest.text.is_empty());
    match kind.text {
        "pty" => Ok(PortSpec::Pty { link: link(rest)? }),
        "slcan-pty" => Ok(PortSpec::SlcanPty { link: link(rest)? }),
        "serial" => Ok(PortSpec::Serial(serial(device().unwrap_or(missing), OPTIONS)?.0)),
        "slcan" => {
            let (serial, bitrate) = serial(device().unwrap_or(missing), SLCAN_OPTIONS)?;
            Ok(PortSpec::Slcan { serial, bitrate })
        }
        "can" => Ok(PortSpec::Can { interface: interface(device().unwrap_or(missing))? }),
        "" => Err(kind.mistake("there is no port in it", KINDS)),
        other => Err(kind.mistake(format!("{other:?} is no kind of port"), KINDS)),
    }
}

fn link(part: Option<Part<'_>>) -> Result<Option<PathBuf>, Mistake> {
    match part {
        Some(part) if part.text.is_empty() || part.text.contains('\0') => {
            Err(part.mistake("the link has no usable path", "a path, or no colon at all"))
        }
        part => Ok(part.map(|part| PathBuf::from(part.text))),
    }
}

fn interface(part: Part<'_>) -> Result<String, Mistake> {
    let odd = |c: char| c == '/' || c.is_whitespace() || c.is_control();
    let named = (1..=INTERFACE_LEN_MAX).contains(&part.text.len())
        && !part.text.contains(odd)
        && !matches!(part.text, "." | "..");
    if named {
        return Ok(part.text.to_owned());
    }
    Err(part.mistake(
        format!("{:?} is no name of an interface", part.text),
        format!("up to {INTERFACE_LEN_MAX} bytes without blanks and slashes, such as can0"),
    ))
}

/// A serial port, and its bitrate if given; `known` options are permitted.
fn serial(part: Part<'_>, known: &[&str]) -> Result<(SerialSpec, Option<BitRate>), Mistake> {
    let (device, options) = part.split('?');
    let device = serial_device(device)?;
    let (options, bitrate) = match options {
        Some(options) => serial_options(options, known)?,
        None => (SerialOptions::default(), None),
    };
    Ok((SerialSpec { device, options }, bitrate))
}

fn serial_device(part: Part<'_>) -> Result<SerialDevice, Mistake> {
    let (kind, id) = part.split(':');
    if let ("usb", Some(id)) = (kind.text, id) {
        return usb_id(id).map(SerialDevice::Usb);
    }
    if part.text.starts_with('/') && !part.text.contains('\0') {
        return Ok(SerialDevice::Path(part.text.to_owned()));
    }
    Err(part.mistake(
        format!("{:?} is no serial device", part.text),
        "an absolute path such as /dev/ttyUSB0, or usb:VENDOR:PRODUCT[:SERIAL]",
    ))
}

fn usb_id(part: Part<'_>) -> Result<UsbId, Mistake> {
    const FORM: &str = "four hexadecimal digits each, as `lsusb` shows them: usb:0403:6001";
    let hexadecimal = |part: Part<'_>, what: &str| {
        let digits = part.text.len() == 4 && part.text.bytes().all(|b| b.is_ascii_hexdigit());
        let number = u16::from_str_radix(part.text, 16).ok().filter(|_| digits);
        number.ok_or_else(|| part.mistake(format!("{:?} is no USB {what} id", part.text), FORM))
    };
    let end = Part { text: "", at: part.at + part.text.len() };
    let (vendor, rest) = part.split(':');
    let (product, serial_number) = rest.unwrap_or(end).split(':');
    let (vendor, product) = (hexadecimal(vendor, "vendor")?, hexadecimal(product, "product")?);
    let serial_number = match serial_number {
        Some(part) if part.text.is_empty() => {
            return Err(part.mistake("the serial number is empty", "a number, or no colon"));
        }
        part => part.map(|part| part.text.to_owned()),
    };
    Ok(UsbId { vendor, product, serial_number })
}

fn serial_options(
    part: Part<'_>,
    known: &[&str],
) -> Result<(SerialOptions, Option<BitRate>), Mistake> {
    let (mut options, mut bitrate) = (SerialOptions::default(), None);
    let mut rest = Some(part);
    while let Some(part) = rest {
        let (pair, behind) = part.split('&');
        rest = behind;
        let (key, value) = pair.split('=');
        if !known.contains(&key.text) {
            return Err(key.mistake(format!("{:?} is no option here", key.text), known.join(", ")));
        }
        let Some(value) = value else {
            return Err(pair.mistake(format!("{:?} has no value", pair.text), "key=value"));
        };
        let twice = match key.text {
            "baud" => options.baud.replace(value.number("baud rate", &BAUD)?).is_some(),
            "data" => options
                .data_bits
                .replace(value.number("number of data bits", &DATA_BITS)?)
                .is_some(),
            "parity" => {
                let words = [Parity::None, Parity::Odd, Parity::Even].map(|one| (one.name(), one));
                options.parity.replace(value.word("parity", &words)?).is_some()
            }
            "stop" => {
                options.stop_bits.replace(value.number("number of stop bits", &(1..=2))?).is_some()
            }
            "flow" => {
                let words = Flow::ALL.map(|flow| (flow.name(), flow));
                options.flow.replace(value.word("flow control", &words)?).is_some()
            }
            "exclusive" => {
                let words = Sharing::ALL.map(|sharing| (sharing.name(), sharing));
                options.sharing.replace(value.word("answer", &words)?).is_some()
            }
            // The last of the known options.
            _ => {
                let words = BitRate::ALL.map(|rate| (rate.bits_per_second().to_string(), rate));
                let words = words.each_ref().map(|(word, rate)| (word.as_str(), *rate));
                bitrate.replace(value.word("bitrate of an adapter", &words)?).is_some()
            }
        };
        if twice {
            return Err(key.mistake(format!("{:?} is said twice", key.text), "each option once"));
        }
    }
    Ok((options, bitrate))
}
