//! Checks the diagnostics of a description.

use super::formula::formula;
use super::parameters::{self, Parameter};
use super::parts::seconds;
use super::scope::Local;
use super::variables::Variables;
use crate::error::{Mistake, Read};
use crate::expression::Expression;
use crate::file::{
    AccessTable, DidTable, DtcTable, Formula, NumberTable, RoutineTable, SecurityTable, UdsTable,
};
use crate::hint;
use crate::isotp::{BYTES_MAX, IsoTp};
use crate::place::Place;
use crate::uds::{
    Access, Content, DEFAULT_SESSION, Diagnosis, Did, Dtc, Field, KEY_BYTES_MAX, KeyFunction,
    Number, Routine, SERVICES, Security, Service, sid,
};
use std::collections::BTreeMap;
use wire::time::Span;

/// What holds without a key of the file: ISO 14229-2 for P2, P2* and S3; the delay is an assumption.
const P2_S: f64 = 0.05;
const P2_STAR_S: f64 = 5.0;
const S3_S: f64 = 5.0;
const RESET_S: f64 = 0.2;
const SECURITY_DELAY_S: f64 = 10.0;
/// P2 in a response has 16 bits of 1 ms.
const P2_S_MAX: f64 = 65.535;

struct Reader<'a> {
    variables: &'a Variables,
    parameters: &'a [Parameter],
    sessions: BTreeMap<String, u8>,
    levels: Vec<u8>,
}

pub(super) fn diagnosis(
    table: &UdsTable,
    isotp: IsoTp,
    variables: &Variables,
    parameters: &[Parameter],
) -> Read<Diagnosis> {
    let place = Place::file().key("uds");
    let time = |key: &str, given: Option<f64>, usual: f64| {
        seconds(given.unwrap_or(usual), 0.0, &place.key(key))
    };
    let (p2, p2_star) = (table.p2_s.unwrap_or(P2_S), table.p2_star_s.unwrap_or(P2_STAR_S));
    for (key, value, most) in [("p2_s", p2, P2_S_MAX), ("p2_star_s", p2_star, 10.0 * P2_S_MAX)] {
        if !(0.001..=most).contains(&value) {
            let text = format!("{value} s, expected 0.001 s to {most} s");
            return Err(Mistake::new(place.key(key), text));
        }
    }
    let mut reader =
        Reader { variables, parameters, sessions: sessions(table, &place)?, levels: Vec::new() };
    for key in table.security.keys() {
        let place = place.key("security").key(key);
        let level = number(key, &place)?;
        let level = u8::try_from(level).ok().filter(|level| level % 2 == 1 && *level < 0x7F);
        reader.levels.push(level.ok_or_else(|| {
            Mistake::new(place.name(), format!("`{key}` is no security level"))
                .help("an odd number from 1 to 0x7D: the sub-function that requests the seed")
        })?);
    }
    Ok(Diagnosis {
        isotp,
        p2: Span::from_secs_f64(p2),
        p2_star: Span::from_secs_f64(p2_star),
        s3: seconds(table.s3_s.unwrap_or(S3_S), 0.01, &place.key("s3_s"))?,
        response_pending: table.response_pending.unwrap_or(true),
        reset: time("reset_s", table.reset_s, RESET_S)?,
        flow_control_delay: reader
            .delay(&table.flow_control_delay_s, &place.key("flow_control_delay_s"))?,
        separation: reader.delay(&table.separation_s, &place.key("separation_s"))?,
        services: reader.services(table, &place.key("service"))?,
        dids: reader.each(&table.did, &place.key("did"), Reader::did)?,
        security: reader.each(&table.security, &place.key("security"), Reader::security)?,
        routines: reader.each(&table.routine, &place.key("routine"), Reader::routine)?,
        dtcs: reader.dtcs(table, &place.key("dtc"))?,
        sessions: reader.sessions.values().copied().collect(),
    })
}

/// The sessions by name, `default` included.
fn sessions(table: &UdsTable, place: &Place) -> Read<BTreeMap<String, u8>> {
    let usual = || [("programming", 2), ("extended", 3)].map(|(name, id)| (name.to_owned(), id));
    let mut sessions = table.sessions.clone().unwrap_or_else(|| usual().into());
    for (name, id) in &sessions {
        let place = place.key("sessions").key(name);
        let is_again = sessions.iter().any(|(other, known)| other != name && known == id);
        if is_again || *id <= DEFAULT_SESSION || *id > 0x7E {
            let text = format!("session `{name}` cannot have the number {id}");
            let help = "each has a number of its own from 2 to 0x7E; `default` is 1";
            return Err(Mistake::new(place, text).help(help));
        }
    }
    sessions.insert("default".to_owned(), DEFAULT_SESSION);
    Ok(sessions)
}

/// The number that a key of a table is.
fn number(key: &str, place: &Place) -> Read<u32> {
    let number = match key.strip_prefix("0x").or_else(|| key.strip_prefix("0X")) {
        Some(digits) => u32::from_str_radix(digits, 16),
        None => key.parse(),
    };
    number.map_err(|_| {
        Mistake::new(place.name(), format!("`{key}` is not a number")).help("such as 0xF190")
    })
}

/// A diagnostic trouble code: a number of 24 bits, or `P0A0F-16` (SAE J2012).
fn code(key: &str, place: &Place) -> Read<u32> {
    let named = || {
        let (code, kind) = key.split_once('-').unwrap_or((key, "00"));
        let system = "PCBU".find(code.chars().next()?)? as u32;
        let digits = code.get(1..).filter(|digits| digits.len() == 4 && kind.len() == 2)?;
        let first = digits.starts_with(['0', '1', '2', '3']);
        let number = u32::from_str_radix(digits, 16).ok().filter(|_| first)?;
        Some((system << 14 | number) << 8 | u32::from_str_radix(kind, 16).ok()?)
    };
    match named() {
        Some(code) => Ok(code),
        None => number(key, place).and_then(|code| match code {
            1..0xFF_FFFF => Ok(code),
            _ => Err(Mistake::new(place.name(), format!("`{key}` is no trouble code"))
                .help("a number of 24 bits, or a name such as P0A0F-16")),
        }),
    }
}

impl Reader<'_> {
    fn formula(&self, said: &Formula, place: &Place) -> Read<Expression> {
        let scope = Local { scope: self.variables, index: None, has_parts: false };
        formula(said, &scope, place)
    }

    fn delay(&self, said: &Option<Formula>, place: &Place) -> Read<Expression> {
        match said {
            Some(said) => self.formula(said, place),
            None => Ok(Expression::constant(0.0)),
        }
    }

    /// The tables of a kind by their numbers.
    fn each<T, K: TryFrom<u32> + Ord, V>(
        &self,
        tables: &BTreeMap<String, T>,
        place: &Place,
        read: impl Fn(&Self, &T, &Place) -> Read<V>,
    ) -> Read<BTreeMap<K, V>> {
        let mut all = BTreeMap::new();
        for (key, table) in tables {
            let place = place.key(key);
            let number = number(key, &place)?;
            let Ok(id) = K::try_from(number) else {
                let most = (1_u32 << (8 * size_of::<K>())) - 1;
                return Err(Mistake::new(place.name(), format!("`{key}` is above {most:#x}")));
            };
            if all.insert(id, read(self, table, &place)?).is_some() {
                let text = format!("{number:#06x} is in the file twice");
                return Err(Mistake::new(place.name(), text));
            }
        }
        Ok(all)
    }

    fn access(&self, table: &AccessTable, place: &Place) -> Read<Access> {
        let session = |(index, name): (usize, &String)| {
            self.sessions.get(name).copied().ok_or_else(|| {
                let known: Vec<&str> = self.sessions.keys().map(String::as_str).collect();
                let place = place.key("sessions").index(index);
                place.mistake(format!("no session `{name}`")).help(hint::proposal(name, &known))
            })
        };
        let sessions = table.sessions.as_ref();
        let sessions =
            sessions.map(|names| names.iter().enumerate().map(session).collect()).transpose()?;
        if let Some(level) = table.security.filter(|level| !self.levels.contains(level)) {
            let text = format!("no security level {level}");
            return Err(Mistake::new(place.key("security"), text)
                .help(format!("add [uds.security.{level}] with a `key`")));
        }
        let when = table.when.as_ref().map(|when| self.formula(when, &place.key("when")));
        Ok(Access { sessions, security: table.security, when: when.transpose()? })
    }

    /// The services that the server has: those that the file says, and of the others those that have something to do.
    fn services(&self, table: &UdsTable, place: &Place) -> Read<BTreeMap<u8, Service>> {
        let names = SERVICES.map(|(name, _)| name);
        if let Some(name) = table.service.keys().find(|name| !names.contains(&name.as_str())) {
            return Err(Mistake::new(place.key(name).name(), format!("no service `{name}`"))
                .help(hint::proposal(name, &names)));
        }
        let writes = table.did.values().any(|did| did.write.is_some());
        let mut services = BTreeMap::new();
        for (name, id) in SERVICES {
            let place = place.key(name);
            let said = table.service.get(name).cloned().unwrap_or_default();
            let has_work = match id {
                sid::READ_DATA => !table.did.is_empty(),
                sid::WRITE_DATA => writes,
                sid::SECURITY_ACCESS => !table.security.is_empty(),
                sid::READ_DTC | sid::CLEAR_DTC | sid::CONTROL_DTC_SETTING => !table.dtc.is_empty(),
                sid::ROUTINE_CONTROL => !table.routine.is_empty(),
                _ => true,
            };
            if said.supported.unwrap_or(has_work) {
                let access = self.access(&said.access, &place.key("access"))?;
                let delay = self.delay(&said.delay_s, &place.key("delay_s"))?;
                services.insert(id, Service { access, delay });
            }
        }
        Ok(services)
    }

    fn field(&self, table: &NumberTable, place: &Place) -> Read<Field> {
        let scale = (table.scale.unwrap_or(1.0), table.offset.unwrap_or(0.0));
        let number = Number::new(table.kind, scale.0, scale.1).ok_or_else(|| {
            Mistake::new(place.key("scale"), "a scale is finite and not zero")
                .help("value = scale * number + offset")
        })?;
        let value = self.formula(&table.value, &place.key("value"))?;
        if let Some(name) = &table.set {
            self.parameter(name, &place.key("set"))?;
        }
        Ok(Field { number, value, set: table.set.clone() })
    }

    fn fields(&self, tables: &[NumberTable], place: &Place) -> Read<Vec<Field>> {
        let field = |(index, table)| self.field(table, &place.index(index));
        tables.iter().enumerate().map(field).collect()
    }

    fn parameter(&self, name: &str, place: &Place) -> Read {
        if !parameters::named(self.parameters, name).is_empty() {
            return Ok(());
        }
        let known: Vec<&str> = self.parameters.iter().map(|known| known.name.as_str()).collect();
        Err(place.mistake(format!("no parameter `{name}`")).help(hint::proposal(name, &known)))
    }

    fn did(&self, table: &DidTable, place: &Place) -> Read<Did> {
        let one = match (table.kind, &table.value) {
            (Some(kind), Some(value)) => Some(NumberTable {
                kind,
                value: value.clone(),
                scale: table.scale,
                offset: table.offset,
                unit: String::new(),
                set: table.set.clone(),
            }),
            (Some(_), None) => {
                return Err(Mistake::new(place.key("type").name(), "a number without its `value`"));
            }
            (None, Some(_)) => {
                return Err(Mistake::new(place.key("value").name(), "a value without its `type`")
                    .help("u8, i16, u24, f32, ...: what its bytes are"));
            }
            (None, None) => None,
        };
        let given = [table.text.is_some(), table.bytes.is_some(), table.fields.is_some()];
        if given.into_iter().chain([one.is_some()]).filter(|given| *given).count() != 1 {
            let text = "a data identifier has exactly one of `text`, `bytes`, `value` and `fields`";
            return Err(Mistake::new(place.name(), text));
        }
        let content = match (&table.text, &table.bytes, &table.fields, one) {
            (Some(text), ..) => Content::Fixed(text.clone().into_bytes()),
            (_, Some(bytes), ..) => Content::Fixed(bytes.clone()),
            (_, _, Some(fields), _) => Content::Fields(self.fields(fields, &place.key("fields"))?),
            (_, _, _, one) => {
                let one = one.iter().map(|one| self.field(one, place));
                Content::Fields(one.collect::<Result<_, _>>()?)
            }
        };
        let length = match &content {
            Content::Fixed(bytes) => bytes.len(),
            Content::Fields(fields) => fields.iter().map(|field| field.number.bytes()).sum(),
        };
        // The response begins with its service and the identifier.
        if length == 0 || length + 3 > BYTES_MAX {
            let text = format!("{length} bytes, expected 1 to {}", BYTES_MAX - 3);
            return Err(Mistake::new(place.name(), text));
        }
        let can_be_set = match &content {
            Content::Fixed(_) => true,
            Content::Fields(fields) => fields.iter().all(|field| field.set.is_some()),
        };
        if table.write.is_some() && !can_be_set {
            let text = "a write has nothing to set";
            return Err(Mistake::new(place.key("write").name(), text)
                .help("add `set` with a parameter to each number"));
        }
        let write = table.write.as_ref().map(|write| self.access(write, &place.key("write")));
        Ok(Did {
            content,
            read: self.access(&table.read, &place.key("read"))?,
            write: write.transpose()?,
            delay: self.delay(&table.delay_s, &place.key("delay_s"))?,
        })
    }

    fn security(&self, table: &SecurityTable, place: &Place) -> Read<Security> {
        let key = table.key.as_ref().ok_or_else(|| {
            Mistake::new(place.name(), "a security level without a `key`")
                .help("an expression of `seed`: key = \"bit_xor(seed, 0x5A5A5A5A)\"")
        })?;
        let key = KeyFunction::parse(key).map_err(|(at, text, help)| Mistake {
            help,
            ..Mistake::new(place.key("key").within(at), text)
        })?;
        let length = |key: &str, bytes: usize| match bytes {
            1..=KEY_BYTES_MAX => Ok(bytes),
            _ => Err(Mistake::new(place.key(key), format!("{bytes} bytes"))
                .help(format!("expected 1 to {KEY_BYTES_MAX}"))),
        };
        let seed_bytes = length("seed_bytes", table.seed_bytes.unwrap_or(4))?;
        let attempts = table.attempts.unwrap_or(3);
        if attempts == 0 {
            return Err(Mistake::new(place.key("attempts"), "no attempt, expected at least 1"));
        }
        Ok(Security {
            key,
            seed_bytes,
            key_bytes: length("key_bytes", table.key_bytes.unwrap_or(seed_bytes))?,
            attempts,
            delay: seconds(table.delay_s.unwrap_or(SECURITY_DELAY_S), 0.0, &place.key("delay_s"))?,
            access: self.access(&table.access, &place.key("access"))?,
        })
    }

    fn settings(
        &self,
        table: &BTreeMap<String, Formula>,
        place: &Place,
    ) -> Read<Vec<(String, Expression)>> {
        let setting = |(name, value): (&String, &Formula)| {
            self.parameter(name, &place.key(name).name())?;
            Ok((name.clone(), self.formula(value, &place.key(name))?))
        };
        table.iter().map(setting).collect()
    }

    fn routine(&self, table: &RoutineTable, place: &Place) -> Read<Routine> {
        let stop = table.stop.as_ref().map(|stop| self.settings(stop, &place.key("stop")));
        let results = table.results.as_ref();
        let results = results.map(|results| self.fields(results, &place.key("results")));
        Ok(Routine {
            start: self.settings(&table.start, &place.key("start"))?,
            stop: stop.transpose()?,
            results: results.transpose()?,
            access: self.access(&table.access, &place.key("access"))?,
            delay: self.delay(&table.delay_s, &place.key("delay_s"))?,
        })
    }

    fn dtcs(&self, table: &UdsTable, place: &Place) -> Read<Vec<Dtc>> {
        let mut dtcs: Vec<Dtc> = Vec::new();
        for (key, table) in &table.dtc {
            let place = place.key(key);
            let code = code(key, &place)?;
            if dtcs.iter().any(|known| known.code == code) {
                return Err(place.name().mistake(format!("{code:#08x} is in the file twice")));
            }
            let DtcTable { failed, debounce_s, warning, .. } = table;
            dtcs.push(Dtc {
                code,
                failed: self.formula(failed, &place.key("failed"))?,
                debounce: seconds(debounce_s.unwrap_or(0.0), 0.0, &place.key("debounce_s"))?,
                warning: *warning,
            });
        }
        dtcs.sort_by_key(|dtc| dtc.code);
        Ok(dtcs)
    }
}
