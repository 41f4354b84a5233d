//! The services of a server: from a request to its response or its negative response code.

use super::{Answer, Case, Server};
use crate::device::Device;
use crate::expression::Expression;
use crate::isotp::BYTES_MAX;
use crate::uds::{Access, Content, DEFAULT_SESSION, Field, WARNING, nrc, sid};
use wire::time::{Span, Timestamp};

/// Format of trouble codes in a count of them: ISO 14229-1.
const DTC_FORMAT: u8 = 1;
/// All groups of trouble codes.
const ALL_DTCS: u32 = 0xFF_FFFF;

/// Units of P2 and P2* in a response.
const P2_UNIT: Span = Span::from_millis(1);
const P2_STAR_UNIT: Span = Span::from_millis(10);

impl Server {
    pub(super) fn answer(&mut self, data: &[u8], case: &mut Case<'_>) -> Answer {
        let (service, rest) = data.split_first().ok_or(nrc::INCORRECT_LENGTH)?;
        let known = case.diagnosis.services.get(service).ok_or(nrc::SERVICE_NOT_SUPPORTED)?;
        let in_session = nrc::SERVICE_NOT_SUPPORTED_IN_SESSION;
        self.admit(&known.access, in_session, case.device)?;
        let rest = match *service {
            sid::READ_DATA => self.read(rest, case),
            sid::WRITE_DATA => self.write(rest, case),
            sid::CLEAR_DTC => clear(rest, case),
            _ => {
                let (sub, rest) = rest.split_first().ok_or(nrc::INCORRECT_LENGTH)?;
                let sub = sub & 0x7F;
                let answer = match *service {
                    sid::SESSION_CONTROL => self.change_session(sub, rest, case),
                    sid::ECU_RESET => self.reset(case.now, sub, rest),
                    sid::READ_DTC => report(sub, rest, case),
                    sid::SECURITY_ACCESS => self.unlock(sub, rest, case),
                    sid::COMMUNICATION_CONTROL => self.communicate(sub, rest),
                    sid::ROUTINE_CONTROL => self.routine(sub, rest, case),
                    sid::TESTER_PRESENT => nothing_in(sub, 0, rest),
                    sid::CONTROL_DTC_SETTING => set_testing(sub, case.device),
                    _ => return Err(nrc::SERVICE_NOT_SUPPORTED),
                };
                answer.map(|rest| [&[sub], rest.as_slice()].concat())
            }
        }?;
        let response = [&[service | sid::POSITIVE], rest.as_slice()].concat();
        if response.len() > BYTES_MAX { Err(nrc::RESPONSE_TOO_LONG) } else { Ok(response) }
    }

    /// Checks what a request needs; `other_session` is the response in another session.
    fn admit(&self, access: &Access, other_session: u8, device: &mut Device) -> Result<(), u8> {
        if access.sessions.as_ref().is_some_and(|sessions| !sessions.contains(&self.session)) {
            return Err(other_session);
        }
        if access.security.is_some() && access.security != self.unlocked {
            return Err(nrc::SECURITY_ACCESS_DENIED);
        }
        match &access.when {
            Some(when) if device.evaluate(when) == 0.0 => Err(nrc::CONDITIONS_NOT_CORRECT),
            _ => Ok(()),
        }
    }

    fn change_session(&mut self, session: u8, rest: &[u8], case: &mut Case<'_>) -> Answer {
        if !case.diagnosis.sessions.contains(&session) {
            return Err(nrc::SUB_FUNCTION_NOT_SUPPORTED);
        }
        empty(rest)?;
        self.enter(session);
        if session == DEFAULT_SESSION {
            case.device.test_codes(true);
        }
        let units = |span: Span, unit: Span| {
            let count = span.as_nanos() / unit.as_nanos();
            u16::try_from(count).unwrap_or(u16::MAX).to_be_bytes()
        };
        let p2 = units(case.diagnosis.p2, P2_UNIT);
        Ok([p2, units(case.diagnosis.p2_star, P2_STAR_UNIT)].concat())
    }

    /// Hard reset, key off and on, soft reset: all have the same effect here.
    fn reset(&mut self, now: Timestamp, sub: u8, rest: &[u8]) -> Answer {
        if !(1..=3).contains(&sub) {
            return Err(nrc::SUB_FUNCTION_NOT_SUPPORTED);
        }
        empty(rest)?;
        self.reset_soon(now);
        Ok(Vec::new())
    }

    fn read(&self, rest: &[u8], case: &mut Case<'_>) -> Answer {
        let (pairs, odd) = rest.as_chunks::<2>();
        if pairs.is_empty() || !odd.is_empty() {
            return Err(nrc::INCORRECT_LENGTH);
        }
        let mut response = Vec::new();
        for pair in pairs {
            let id = u16::from_be_bytes(*pair);
            let Some(did) = case.diagnosis.dids.get(&id) else { continue };
            match self.admit(&did.read, nrc::REQUEST_OUT_OF_RANGE, case.device) {
                Ok(()) => {}
                // Identifiers that are not supported now are left out.
                Err(nrc::REQUEST_OUT_OF_RANGE) => continue,
                Err(code) => return Err(code),
            }
            response.extend_from_slice(pair);
            match &did.content {
                Content::Fixed(bytes) => {
                    response.extend_from_slice(self.stored.get(&id).unwrap_or(bytes));
                }
                Content::Fields(fields) => put(fields, &mut response, case.device),
            }
            if response.len() > BYTES_MAX {
                return Err(nrc::RESPONSE_TOO_LONG);
            }
        }
        if response.is_empty() { Err(nrc::REQUEST_OUT_OF_RANGE) } else { Ok(response) }
    }

    fn write(&mut self, rest: &[u8], case: &mut Case<'_>) -> Answer {
        let (id, data) = rest.split_first_chunk::<2>().ok_or(nrc::INCORRECT_LENGTH)?;
        let number = u16::from_be_bytes(*id);
        let did = case.diagnosis.dids.get(&number).ok_or(nrc::REQUEST_OUT_OF_RANGE)?;
        let access = did.write.as_ref().ok_or(nrc::REQUEST_OUT_OF_RANGE)?;
        self.admit(access, nrc::REQUEST_OUT_OF_RANGE, case.device)?;
        let fields = match &did.content {
            Content::Fixed(bytes) if bytes.len() == data.len() => {
                self.stored.insert(number, data.to_vec());
                return Ok(id.to_vec());
            }
            Content::Fixed(_) => return Err(nrc::INCORRECT_LENGTH),
            Content::Fields(fields) => fields,
        };
        let mut at = 0;
        let mut settings = Vec::new();
        for field in fields {
            let value = data.get(at..).and_then(|data| field.number.value(data));
            let value = value.ok_or(nrc::INCORRECT_LENGTH)?;
            at += field.number.bytes();
            settings.extend(field.set.as_ref().map(|parameter| (parameter.as_str(), value)));
        }
        if at != data.len() {
            return Err(nrc::INCORRECT_LENGTH);
        }
        self.set(&settings, case)?;
        Ok(id.to_vec())
    }

    /// Sets parameters: all of them, or none if one is out of its range.
    fn set(&mut self, settings: &[(&str, f64)], case: &mut Case<'_>) -> Result<(), u8> {
        let is_allowed = |(name, value): &(&str, f64)| {
            case.device.description().check_parameter(name, *value).is_ok()
        };
        if !settings.iter().all(is_allowed) {
            return Err(nrc::REQUEST_OUT_OF_RANGE);
        }
        for (name, value) in settings {
            case.device.set_parameter(case.now, name, *value);
            self.written.insert((*name).to_owned());
        }
        Ok(())
    }

    fn unlock(&mut self, sub: u8, rest: &[u8], case: &mut Case<'_>) -> Answer {
        let is_request = sub % 2 == 1;
        let level = if is_request { sub } else { sub.wrapping_sub(1) };
        let security =
            case.diagnosis.security.get(&level).ok_or(nrc::SUB_FUNCTION_NOT_SUPPORTED)?;
        let other = nrc::SUB_FUNCTION_NOT_SUPPORTED_IN_SESSION;
        self.admit(&security.access, other, case.device)?;
        let (wrong, delayed_until) = self.attempts.get(&level).copied().unwrap_or_default();
        if is_request {
            empty(rest)?;
            if case.now < delayed_until {
                return Err(nrc::TIME_DELAY_NOT_EXPIRED);
            }
            if self.unlocked == Some(level) {
                return Ok(vec![0; security.seed_bytes]);
            }
            let mut seed: Vec<u8> = (0..security.seed_bytes).map(|_| self.random_byte()).collect();
            // Zeros would say that the level is unlocked.
            if let (true, Some(last)) = (seed.iter().all(|byte| *byte == 0), seed.last_mut()) {
                *last = 1;
            }
            self.seed = Some((level, seed.clone()));
            return Ok(seed);
        }
        if rest.len() != security.key_bytes {
            return Err(nrc::INCORRECT_LENGTH);
        }
        let given = self.seed.take_if(|(of, _)| *of == level);
        let (_, seed) = given.ok_or(nrc::REQUEST_SEQUENCE_ERROR)?;
        if security.key.key(&seed, security.key_bytes).as_deref() == Some(rest) {
            self.attempts.remove(&level);
            self.unlocked = Some(level);
            return Ok(Vec::new());
        }
        if wrong + 1 < security.attempts {
            self.attempts.insert(level, (wrong + 1, delayed_until));
            return Err(nrc::INVALID_KEY);
        }
        self.attempts.insert(level, (0, case.now + security.delay));
        Err(nrc::EXCEEDED_ATTEMPTS)
    }

    fn random_byte(&mut self) -> u8 {
        // A float to an integer saturates at both ends.
        ((self.random.symmetric_uniform() + 1.0) * 128.0) as u8
    }

    /// Silences the ordinary messages in one direction or both.
    fn communicate(&mut self, sub: u8, rest: &[u8]) -> Answer {
        let (deaf, silent) = match sub {
            0 => (false, false),
            1 => (false, true),
            2 => (true, false),
            3 => (true, true),
            _ => return Err(nrc::SUB_FUNCTION_NOT_SUPPORTED),
        };
        let [kind] = rest else { return Err(nrc::INCORRECT_LENGTH) };
        match kind & 0x3 {
            0 => return Err(nrc::REQUEST_OUT_OF_RANGE),
            // Concerns network management alone, which the device does not have.
            2 => {}
            _ => (self.deaf, self.silent) = (deaf, silent),
        }
        Ok(Vec::new())
    }

    fn routine(&mut self, sub: u8, rest: &[u8], case: &mut Case<'_>) -> Answer {
        if !(1..=3).contains(&sub) {
            return Err(nrc::SUB_FUNCTION_NOT_SUPPORTED);
        }
        let (id, options) = rest.split_first_chunk::<2>().ok_or(nrc::INCORRECT_LENGTH)?;
        let number = u16::from_be_bytes(*id);
        let routine = case.diagnosis.routines.get(&number).ok_or(nrc::REQUEST_OUT_OF_RANGE)?;
        self.admit(&routine.access, nrc::REQUEST_OUT_OF_RANGE, case.device)?;
        empty(options)?;
        let mut response = id.to_vec();
        let sequence = |known: bool| if known { Ok(()) } else { Err(nrc::REQUEST_SEQUENCE_ERROR) };
        match sub {
            1 => {
                self.set_all(&routine.start, case)?;
                self.started.insert(number);
            }
            2 => {
                let stop = routine.stop.as_ref().ok_or(nrc::SUB_FUNCTION_NOT_SUPPORTED)?;
                sequence(self.started.contains(&number))?;
                self.set_all(stop, case)?;
            }
            _ => {
                let results = routine.results.as_ref().ok_or(nrc::SUB_FUNCTION_NOT_SUPPORTED)?;
                sequence(self.started.contains(&number))?;
                put(results, &mut response, case.device);
            }
        }
        Ok(response)
    }

    fn set_all(
        &mut self,
        settings: &[(String, Expression)],
        case: &mut Case<'_>,
    ) -> Result<(), u8> {
        let settings: Vec<(&str, f64)> = settings
            .iter()
            .map(|(name, value)| (name.as_str(), case.device.evaluate(value)))
            .collect();
        self.set(&settings, case)
    }
}

fn put(fields: &[Field], response: &mut Vec<u8>, device: &mut Device) {
    for field in fields {
        field.number.put(device.evaluate(&field.value), response);
    }
}

fn empty(rest: &[u8]) -> Result<(), u8> {
    if rest.is_empty() { Ok(()) } else { Err(nrc::INCORRECT_LENGTH) }
}

/// The response of a service with only the sub-function `only`.
fn nothing_in(sub: u8, only: u8, rest: &[u8]) -> Answer {
    if sub != only {
        return Err(nrc::SUB_FUNCTION_NOT_SUPPORTED);
    }
    empty(rest).map(|()| Vec::new())
}

/// Switches the tests of all trouble codes. The rest of the request, which selects codes in some vehicles, is not used.
fn set_testing(sub: u8, device: &mut Device) -> Answer {
    if !(1..=2).contains(&sub) {
        return Err(nrc::SUB_FUNCTION_NOT_SUPPORTED);
    }
    device.test_codes(sub == 1);
    Ok(Vec::new())
}

/// Clears one trouble code or all.
fn clear(rest: &[u8], case: &mut Case<'_>) -> Answer {
    let [high, middle, low] = rest else { return Err(nrc::INCORRECT_LENGTH) };
    let group = u32::from_be_bytes([0, *high, *middle, *low]);
    let mut is_known = group == ALL_DTCS;
    for (dtc, monitor) in case.diagnosis.dtcs.iter().zip(case.device.monitors()) {
        if group == ALL_DTCS || group == dtc.code {
            monitor.clear();
            is_known = true;
        }
    }
    if is_known { Ok(Vec::new()) } else { Err(nrc::REQUEST_OUT_OF_RANGE) }
}

/// Number of codes by a mask of their status, these codes, or all.
fn report(sub: u8, rest: &[u8], case: &mut Case<'_>) -> Answer {
    let has_warning = case.diagnosis.dtcs.iter().any(|dtc| dtc.warning);
    let available = if has_warning { u8::MAX } else { !WARNING };
    let mask = match (sub, rest) {
        (1 | 2, [mask]) => Some(mask & available),
        (0x0A, []) => None,
        (1 | 2 | 0x0A, _) => return Err(nrc::INCORRECT_LENGTH),
        _ => return Err(nrc::SUB_FUNCTION_NOT_SUPPORTED),
    };
    let all = case.diagnosis.dtcs.iter().zip(case.device.monitors());
    let found = all.map(|(dtc, monitor)| (dtc.code, monitor.status()));
    let found = found.filter(|(_, status)| mask.is_none_or(|mask| status & mask != 0));
    if sub == 1 {
        let [high, low] = u16::try_from(found.count()).unwrap_or(u16::MAX).to_be_bytes();
        return Ok(vec![available, DTC_FORMAT, high, low]);
    }
    let mut response = vec![available];
    for (code, status) in found {
        response.extend_from_slice(&code.to_be_bytes()[1..]);
        response.push(status);
    }
    Ok(response)
}
