//! What a device sends, and when.

use super::dynamics::finite;
use super::occasion::Occasion;
use super::{Device, NEVER, QUEUE_MAX};
use crate::description::{Description, Model, Sent, SignalSource, Source, TIME};
use crate::layout::SendKind;
use emulators::gyro::terms::{Seen, Sensor};
use emulators::random::RandomStream;
use wire::time::Timestamp;

/// One of the messages that are sent.
#[derive(Debug)]
pub(super) struct Sending {
    /// When it is sent next, where it is periodic.
    pub(super) due: Timestamp,
    /// When it is sent because of a change.
    pub(super) occasion: Occasion,
    /// Which page a multiplexer that nobody drives has next: of each signal.
    pages: Vec<usize>,
    /// What each signal was last, without noise.
    pub(super) last: Vec<f64>,
    /// One a signal, so that none shifts the numbers of another.
    noise: Vec<RandomStream>,
    /// One a signal that is read from a sensor, since its first reading.
    pub(super) sensors: Vec<Option<Sensor>>,
}

impl Sending {
    pub(super) fn new(description: &Description, sent: &Sent, seed: u64) -> Self {
        let message = &description.layout().messages()[sent.message];
        let stream = |signal: &str| {
            let purpose = format!("signal {}.{signal}", message.name);
            RandomStream::new(seed, &description.name, &purpose)
        };
        Self {
            due: NEVER,
            occasion: Occasion::new(),
            pages: vec![0; message.signals.len()],
            last: message.signals.iter().map(|signal| signal.start).collect(),
            noise: message.signals.iter().map(|signal| stream(&signal.name)).collect(),
            sensors: vec![None; message.signals.len()],
        }
    }

    /// Power on: the first one comes a period later.
    pub(super) fn start(&mut self, description: &Description, sent: &Sent, now: Timestamp) {
        self.due = sent.period.map_or(NEVER, |period| now + period);
        self.pages.fill(0);
        self.sensors.fill(None);
        let signals = &description.layout().messages()[sent.message].signals;
        for (last, signal) in self.last.iter_mut().zip(signals) {
            *last = signal.start;
        }
    }

    /// When something is to be done for it.
    pub(super) fn next(&self) -> Timestamp {
        self.due.min(self.occasion.look).min(self.occasion.due)
    }

    /// Woken late it sends once: a device has no past to catch up with.
    fn next_period(&mut self, sent: &Sent, now: Timestamp) {
        self.due = sent.period.map_or(NEVER, |period| {
            let missed = now.since(self.due).as_nanos() / period.as_nanos().max(1) + 1;
            self.due + period * missed
        });
    }
}

impl Device {
    /// Sends messages that are due by their period or a change, and answers, the earliest first.
    pub(super) fn send_what_is_due(&mut self, model: &Model, now: Timestamp) {
        loop {
            let periodic = self.senders.iter().enumerate().map(|(index, one)| (one.next(), index));
            let periodic = periodic.filter(|(due, _)| *due <= now && *due != NEVER).min();
            let answer = self.answers.iter().enumerate().map(|(place, (at, _))| (*at, place));
            let answer = answer.filter(|(at, _)| *at <= now && *at != NEVER).min();
            let index = match (periodic, answer) {
                (None, None) => return,
                (Some((due, index)), answer) if answer.is_none_or(|(at, _)| due <= at) => {
                    let is_due = |at: Timestamp| at <= now && at != NEVER;
                    if is_due(self.senders[index].occasion.look) {
                        self.dynamics.reach(model, now);
                        self.look(model, index, now);
                        continue;
                    }
                    if is_due(self.senders[index].due) {
                        self.senders[index].next_period(&model.sent[index], now);
                    }
                    index
                }
                (_, Some((_, place))) => match self.answers.remove(place) {
                    Some((_, index)) => index,
                    None => return,
                },
                (Some(_), None) => return,
            };
            self.dynamics.reach(model, now);
            self.senders[index].occasion.sent(&model.sent[index].send, now);
            self.send(model, index);
        }
    }

    /// Looks whether a change has a message sent.
    pub(super) fn look(&mut self, model: &Model, index: usize, now: Timestamp) {
        let sent = &model.sent[index];
        if sent.send.kind == SendKind::Cyclic {
            return;
        }
        let numbers = self.numbers(model, index);
        let signals = &self.description.layout().messages()[sent.message].signals;
        let is_start = |signal: usize, number: Option<u64>| {
            number == signals[signal].number_of(signals[signal].start)
        };
        let occasion = &mut self.senders[index].occasion;
        occasion.look(&sent.send, (now, model.step), numbers, is_start);
    }

    /// What the signals would be sent as now, without noise: nothing for those that no change of counts.
    pub(super) fn numbers(&self, model: &Model, index: usize) -> Vec<Option<u64>> {
        let sent = &model.sent[index];
        let signals = &self.description.layout().messages()[sent.message].signals;
        let number = |(place, from): (usize, &SignalSource)| {
            if !sent.send.looks_at(place) || matches!(from.source, Source::Unsaid) {
                return None;
            }
            // To look is not to read: the sensor stays as it was.
            let mut sensor = self.senders[index].sensors[place].clone();
            let value = from.source.value(self.dynamics.values(), &mut sensor);
            let (least, greatest) = (signals[place].minimum, signals[place].maximum);
            if value.is_nan() {
                None
            } else {
                signals[place].number_of(value.clamp(least, greatest))
            }
        };
        sent.signals.iter().enumerate().map(number).collect()
    }

    fn send(&mut self, model: &Model, index: usize) {
        let sent = &model.sent[index];
        let sending = &mut self.senders[index];
        let message = &self.description.layout().messages()[sent.message];
        let mut values = Vec::with_capacity(message.signals.len());
        for (place, (signal, from)) in message.signals.iter().zip(&sent.signals).enumerate() {
            let value = match &from.source {
                Source::Unsaid => {
                    let pages = &sent.pages[place];
                    let page = pages.get(sending.pages[place] % pages.len().max(1));
                    page.map_or(signal.start, |page| signal.selecting(*page))
                }
                source => source.value(self.dynamics.values(), &mut sending.sensors[place]),
            };
            let value = finite(value, sending.last[place], &mut self.not_finite);
            sending.last[place] = value;
            let mut shown = value;
            if from.noise > 0.0 {
                shown += from.noise * sending.noise[place].standard_normal();
            }
            let inside = shown.clamp(signal.minimum, signal.maximum);
            self.clipped += u64::from(inside != shown);
            values.push(inside);
        }
        // One below another goes on when it has been sent, so that all of its pages are.
        for place in message.multiplexers().filter(|place| message.carries(*place, &values)) {
            sending.pages[place] = sending.pages[place].wrapping_add(1);
        }
        let is_own = |signal: usize| !matches!(sent.signals[signal].source, Source::Unsaid);
        match self.encoder.encode(sent.message, &values, is_own) {
            Ok(wired) if self.queue.len() < QUEUE_MAX.max(2 * self.senders.len()) => {
                self.queue.push_back(wired);
            }
            // A line can be longer than what is sent at once; else the values are in range.
            Ok(_) | Err(_) => self.dropped += 1,
        }
    }
}

impl Source {
    /// The value with these variables; of nothing, not a number. `sensor` is its memory, where it is one.
    pub(super) fn value(&self, variables: &[f64], sensor: &mut Option<Sensor>) -> f64 {
        match self {
            Self::Unsaid => f64::NAN,
            Self::Expression(expression) => expression.value(variables),
            Self::Series(series) => series.value(variables.get(TIME).copied().unwrap_or(f64::NAN)),
            Self::Sensor(rate) => {
                let seen = Seen {
                    rate: rate.truth.value(variables, &mut None) * rate.unit,
                    heading: rate.heading.value(variables).to_radians(),
                    celsius: rate.temperature.value(variables),
                    time_s: variables.get(TIME).copied().unwrap_or(f64::NAN),
                };
                let sensor = sensor.get_or_insert_with(|| Sensor::new(&rate.errors, &seen));
                sensor.read(&rate.errors, &seen) / rate.unit
            }
        }
    }
}
