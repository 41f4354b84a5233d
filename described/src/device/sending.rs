//! Sending of messages and its times.

use super::correction::Correction;
use super::dynamics::finite;
use super::occasion::Occasion;
use super::{Device, NEVER};
use crate::clipped::{Clipped, Counts};
use crate::description::{Description, Model, PART, Sent, SignalSource, Source};
use crate::expression::TIME;
use crate::layout::{SendKind, Signal};
use crate::steps::Memory;
use emulators::random::RandomStream;
use wire::time::Timestamp;

#[derive(Debug, Clone)]
pub(super) struct Sending {
    /// Next due time of a periodic message.
    pub(super) due: Timestamp,
    /// Sending because of a change.
    pub(super) occasion: Occasion,
    /// Next page of an undriven multiplexer, per signal.
    pages: Vec<usize>,
    /// Last value of each signal, without noise.
    pub(super) last: Vec<f64>,
    /// Smallest and largest value of each signal.
    limits: Box<[(f64, f64)]>,
    /// Values beyond these limits.
    pub(super) clipped: Counts,
    /// Positions of the multiplexers among the signals.
    multiplexers: Box<[usize]>,
    /// One stream per noisy signal, so that none shifts the numbers of another: its position and its stream.
    noise: Box<[(usize, RandomStream)]>,
    /// State of the sensor of each signal.
    pub(super) sensors: Vec<Memory>,
    /// Corrections of sent signals, by position.
    pub(super) corrections: Vec<(usize, Correction)>,
}

impl Sending {
    pub(super) fn new(description: &Description, sent: &Sent, seed: u64) -> Self {
        let message = &description.layout().messages()[sent.message];
        let stream = |signal: &str| {
            let purpose = format!("signal {}.{signal}", message.name);
            RandomStream::new(seed, &description.name, &purpose)
        };
        let noisy = sent.signals.iter().enumerate().filter(|(_, from)| from.noise > 0.0);
        Self {
            due: NEVER,
            occasion: Occasion::new(),
            pages: vec![0; message.signals.len()],
            last: message.signals.iter().map(|signal| signal.start).collect(),
            limits: message.signals.iter().map(|one| (one.minimum, one.maximum)).collect(),
            clipped: Counts::default(),
            multiplexers: message.multiplexers().collect(),
            noise: noisy.map(|(place, _)| (place, stream(&message.signals[place].name))).collect(),
            sensors: vec![Memory::default(); message.signals.len()],
            corrections: Vec::new(),
        }
    }

    /// Power-on: the first message is sent one period later.
    pub(super) fn start(&mut self, description: &Description, sent: &Sent, now: Timestamp) {
        self.due = sent.period.map_or(NEVER, |period| now + period);
        self.pages.fill(0);
        self.sensors.fill(Memory::default());
        for (_, correction) in &mut self.corrections {
            correction.memory = Memory::default();
        }
        let signals = &description.layout().messages()[sent.message].signals;
        for (last, signal) in self.last.iter_mut().zip(signals) {
            *last = signal.start;
        }
    }

    /// True if the true values are sent, always of the same signals.
    #[inline]
    fn is_exact(&self) -> bool {
        self.noise.is_empty() && self.corrections.is_empty() && self.multiplexers.is_empty()
    }

    /// The values of the signals that are not expressions.
    fn others(&mut self, sent: &Sent, signals: &[Signal], variables: &[f64], values: &mut [f64]) {
        for place in &sent.others {
            values[*place] = match &sent.signals[*place].source {
                Source::Unsaid => {
                    let (pages, signal) = (&sent.pages[*place], &signals[*place]);
                    let page = pages.get(self.pages[*place] % pages.len().max(1));
                    page.map_or(signal.start, |page| signal.selecting(*page))
                }
                source => source.value(variables, &mut self.sensors[*place]),
            };
        }
    }

    /// Next time at which it needs attention.
    pub(super) fn next(&self) -> Timestamp {
        self.due.min(self.occasion.look).min(self.occasion.due)
    }

    /// If woken late, the device sends once: it does not catch up with missed periods.
    fn next_period(&mut self, sent: &Sent, now: Timestamp) {
        self.due = sent.period.map_or(NEVER, |period| {
            // The usual case, on time, needs no division.
            let missed = match now.since(self.due) {
                late if late < period => 1,
                late => late.as_nanos() / period.as_nanos().max(1) + 1,
            };
            self.due + period * missed
        });
    }
}

/// Due times of the sent messages.
#[derive(Debug, Clone, Default)]
pub(super) struct Agenda {
    next: Vec<Timestamp>,
    /// The earliest of them; outdated while messages are sent.
    first: Timestamp,
    /// Those due now, the earliest first.
    due: Vec<(Timestamp, usize)>,
    /// Number of them already handled.
    done: usize,
    /// Checked values: a number on the wire for each relevant signal.
    numbers: Vec<Option<u64>>,
    /// Sent values: one per signal.
    values: Vec<f64>,
}

impl Agenda {
    pub(super) fn new(messages: usize) -> Self {
        Self { next: vec![NEVER; messages], first: NEVER, ..Self::default() }
    }

    pub(super) fn plan(&mut self, index: usize, next: Timestamp) {
        let before = std::mem::replace(&mut self.next[index], next);
        if next < self.first {
            self.first = next;
        } else if before == self.first && next != before {
            self.end();
        }
    }

    pub(super) const fn first(&self) -> Timestamp {
        self.first
    }

    fn end(&mut self) {
        self.first = self.next.iter().copied().min().unwrap_or(NEVER);
    }

    fn begin(&mut self, now: Timestamp) {
        self.due.clear();
        self.done = 0;
        let all = self.next.iter().enumerate().map(|(index, next)| (*next, index));
        self.due.extend(all.filter(|(next, _)| *next <= now && *next != NEVER));
        if !self.due.is_sorted() {
            self.due.sort_unstable();
        }
    }

    fn earliest(&self) -> Option<(Timestamp, usize)> {
        self.due.get(self.done).copied()
    }

    /// Marks the earliest as handled, and due again at `next`.
    fn go_on(&mut self, index: usize, next: Timestamp, now: Timestamp) {
        self.next[index] = next;
        self.done += 1;
        if next <= now && next != NEVER {
            let behind = self.due[self.done..].partition_point(|one| *one < (next, index));
            self.due.insert(self.done + behind, (next, index));
        }
    }
}

impl Device {
    /// The signals and objects of which values were clipped to the range. Values that round to one in range are not.
    pub fn clipped(&self) -> impl Iterator<Item = Clipped<'_>> {
        let senders = self.senders.iter().zip(&self.description.model.sent);
        let signals = senders.flat_map(|(sending, sent)| {
            let message = &self.description.layout().messages()[sent.message];
            sending.clipped.all().into_iter().map(|(place, count, farthest)| {
                let signal = &message.signals[place];
                let name = format!("{}.{}", message.name, signal.name);
                let range = (signal.minimum, signal.maximum);
                Clipped { name, range, unit: &signal.unit, count, farthest }
            })
        });
        signals.chain(self.canopen.iter().flat_map(|node| node.clipped()))
    }

    /// Sends messages due by their period, by a change, or as answers, the earliest first.
    pub(super) fn send_what_is_due(&mut self, model: &Model, now: Timestamp) {
        if self.agenda.first() > now && self.answers.due(now).is_none() {
            return;
        }
        self.send_all_due(model, now);
        self.agenda.end();
    }

    fn send_all_due(&mut self, model: &Model, now: Timestamp) {
        self.agenda.begin(now);
        loop {
            let index = match (self.agenda.earliest(), self.answers.due(now)) {
                (None, None) => return,
                (Some((due, index)), answer) if answer.is_none_or(|(at, _)| due <= at) => {
                    let is_due = |at: Timestamp| at <= now && at != NEVER;
                    if is_due(self.senders[index].occasion.look) {
                        self.dynamics.reach(model, now);
                        self.look(model, index, now);
                        self.agenda.go_on(index, self.senders[index].next(), now);
                        continue;
                    }
                    if is_due(self.senders[index].due) {
                        self.senders[index].next_period(&model.sent[index], now);
                    }
                    self.sent(model, index, now);
                    self.agenda.go_on(index, self.senders[index].next(), now);
                    continue;
                }
                (_, Some((_, place))) => match self.answers.next(model, place) {
                    Some(waiting) => {
                        self.dynamics.set(PART, f64::from(waiting.part));
                        waiting.sent
                    }
                    None => return,
                },
                (Some(_), None) => return,
            };
            self.sent(model, index, now);
            // An answer may also be due by its period, or because of a change that it shows.
            self.agenda.plan(index, self.senders[index].next());
            self.agenda.begin(now);
        }
    }

    fn sent(&mut self, model: &Model, index: usize, now: Timestamp) {
        self.dynamics.reach(model, now);
        self.senders[index].occasion.sent(&model.sent[index].send, now);
        self.send(model, index, now);
    }

    /// Checks all messages that are sent on changes.
    pub(super) fn look_at_all(&mut self, model: &Model, now: Timestamp) {
        for index in 0..model.sent.len() {
            self.look(model, index, now);
            self.agenda.plan(index, self.senders[index].next());
        }
    }

    /// Checks whether a change triggers a message.
    fn look(&mut self, model: &Model, index: usize, now: Timestamp) {
        let sent = &model.sent[index];
        if sent.send.kind == SendKind::Cyclic {
            return;
        }
        let mut numbers = std::mem::take(&mut self.agenda.numbers);
        self.numbers(model, index, &mut numbers);
        let signals = &self.description.layout().messages()[sent.message].signals;
        let is_start = |signal: usize, number: Option<u64>| {
            number == signals[signal].on_the_line(signals[signal].start)
        };
        let occasion = &mut self.senders[index].occasion;
        occasion.look(&sent.send, (now, model.step), &mut numbers, is_start);
        self.agenda.numbers = numbers;
    }

    /// The numbers that the signals would be sent as now, without noise; `None` for signals whose changes do not
    /// count.
    pub(super) fn numbers(&self, model: &Model, index: usize, numbers: &mut Vec<Option<u64>>) {
        let sent = &model.sent[index];
        let signals = &self.description.layout().messages()[sent.message].signals;
        let number = |(place, from): (usize, &SignalSource)| {
            if !sent.send.looks_at(place) || matches!(from.source, Source::Unsaid) {
                return None;
            }
            // Looking is not reading: the sensor stays unchanged.
            let mut memory = self.senders[index].sensors[place].clone();
            let value = from.source.value(self.dynamics.values(), &mut memory);
            let (least, greatest) = (signals[place].minimum, signals[place].maximum);
            if value.is_nan() {
                None
            } else {
                signals[place].on_the_line(value.clamp(least, greatest))
            }
        };
        numbers.clear();
        numbers.extend(sent.signals.iter().enumerate().map(number));
    }

    fn send(&mut self, model: &Model, index: usize, now: Timestamp) {
        if self.uds.as_ref().is_some_and(|uds| uds.is_silent()) {
            return;
        }
        let sent = &model.sent[index];
        let sending = &mut self.senders[index];
        let values = self.readings.of(model, sent, &self.dynamics);
        if !sent.others.is_empty() {
            let signals = &self.description.layout().messages()[sent.message].signals;
            sending.others(sent, signals, self.dynamics.values(), values);
        }
        // Usually the values are in range and the message is nothing but its signals.
        if sending.is_exact() && self.outbox.send_plain(sent.message, values) {
            sending.last.copy_from_slice(values);
        } else {
            self.send_fit(model, index, now);
        }
    }

    /// Sends a message whose values may not be those of its signals, or that is more than its signals.
    #[inline(never)]
    fn send_fit(&mut self, model: &Model, index: usize, now: Timestamp) {
        let sent = &model.sent[index];
        let mut fit = std::mem::take(&mut self.agenda.values);
        fit.clear();
        fit.extend_from_slice(self.readings.of(model, sent, &self.dynamics));
        self.make_fit(sent, index, &mut fit);
        let sending = &mut self.senders[index];
        // A nested multiplexer advances only after it was sent, so that all of its pages are sent.
        for place in &sending.multiplexers {
            let message = &self.description.layout().messages()[sent.message];
            if message.carries(*place, &fit) {
                sending.pages[*place] = sending.pages[*place].wrapping_add(1);
            }
        }
        let is_own = |signal: usize| !matches!(sent.signals[signal].source, Source::Unsaid);
        // Values are in range here; messages without room are counted.
        let _ = self.outbox.send(now, sent.message, &fit, is_own);
        self.agenda.values = fit;
    }

    /// Replaces non-finite values, adds noise, applies corrections, and clips to the range.
    fn make_fit(&mut self, sent: &Sent, index: usize, values: &mut [f64]) {
        let sending = &mut self.senders[index];
        for (value, last) in values.iter_mut().zip(&mut sending.last) {
            *last = finite(*value, *last, &mut self.not_finite);
            *value = *last;
        }
        for (place, noise) in &mut sending.noise {
            values[*place] += sent.signals[*place].noise * noise.standard_normal();
        }
        if !sending.corrections.is_empty() {
            self.take_errors_off(index, values);
        }
        let Sending { limits, clipped, .. } = &mut self.senders[index];
        for (place, (value, (least, greatest))) in values.iter_mut().zip(&*limits).enumerate() {
            let inside = value.clamp(*least, *greatest);
            if inside != *value {
                clipped.add(place, *value, inside);
            }
            *value = inside;
        }
    }
}

impl Source {
    /// The value with these variables; NaN without a source. `memory` is the state of the sensor, if it is one.
    pub(super) fn value(&self, variables: &[f64], memory: &mut Memory) -> f64 {
        match self {
            Self::Unsaid => f64::NAN,
            Self::Expression(expression) => expression.value(variables),
            Self::States(machine, each) => {
                let state = variables.get(*machine).map_or(0, |state| *state as usize);
                each.get(state).map_or(f64::NAN, |expression| expression.value(variables))
            }
            Self::Series(series) => series.value(variables.get(TIME).copied().unwrap_or(f64::NAN)),
            Self::Sensor(sensor) => {
                let truth = sensor.truth.value(variables, &mut Memory::default());
                let time = variables.get(TIME).copied().unwrap_or(f64::NAN);
                sensor.errs.next(memory, time, truth, |seen| seen.value(variables))
            }
        }
    }
}
