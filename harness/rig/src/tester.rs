//! A tester: a node that sends the messages that the plan orders, periodically if ordered.

use described::{IsoTp, Layout, Message, Outbox, Reply, Request, Sender, UdsClient};
use plan::Send;
use wire::device::Transmit;
use wire::time::{Span, Timestamp};

/// A node that sends what the plan orders.
#[derive(Debug, Clone)]
pub struct Tester {
    outbox: Outbox,
    /// Sender in the layout whose messages it sends.
    sender: Sender,
    /// Last signal values of each message.
    values: Vec<Vec<f64>>,
    /// Signals of each message that the last order set: counters and checksums among them are not computed.
    own: Vec<Vec<usize>>,
    repeats: Vec<Repeat>,
    /// Clients of the nodes that it can ask.
    clients: Vec<(String, UdsClient)>,
}

#[derive(Debug, Clone)]
struct Repeat {
    message: usize,
    period: Span,
    due: Timestamp,
    /// Remaining repetitions after a change; `None` to repeat until stopped.
    left: Option<u32>,
}

impl Tester {
    pub fn new(layout: Layout, sender: Sender) -> Self {
        let start = |message: &Message| message.signals.iter().map(|signal| signal.start).collect();
        Self {
            values: layout.messages().iter().map(start).collect(),
            own: vec![Vec::new(); layout.messages().len()],
            repeats: Vec::new(),
            clients: Vec::new(),
            outbox: Outbox::new(layout, sender, usize::MAX),
            sender,
        }
    }

    /// Adds the channels on which it can ask nodes.
    #[must_use]
    pub fn asking<'a>(mut self, channels: impl Iterator<Item = (&'a str, &'a IsoTp)>) -> Self {
        self.clients.extend(channels.map(|(node, isotp)| (node.to_owned(), UdsClient::new(isotp))));
        self
    }

    /// Asks a node; returns `false` if it cannot.
    pub(super) fn ask(&mut self, now: Timestamp, node: &str, request: &Request) -> bool {
        let client = self.clients.iter_mut().find(|(name, _)| name == node);
        client.map(|(_, client)| client.ask(now, request.clone())).is_some()
    }

    /// What became of a request, once.
    pub(super) fn reply(&mut self) -> Option<Reply> {
        self.clients.iter_mut().find_map(|(_, client)| client.reply())
    }

    pub(super) fn knows(&self, message: &str) -> bool {
        let layout = self.outbox.layout();
        let place = layout.find(message);
        place.is_some_and(|place| layout.messages()[place].sender == self.sender)
    }

    /// Sends a message now, and repeats it as ordered or as the layout says: after a change faster for a while, if the
    /// layout has that. Its counter and checksum are computed, unless the order sets them.
    ///
    /// # Errors
    /// When the layout has no such message or signal, or when a value does not fit.
    pub(super) fn send(&mut self, now: Timestamp, send: &Send) -> Result<(), String> {
        let layout = self.outbox.layout();
        let Some(message) = layout.find(&send.message) else {
            return Err(format!("no message `{}` in the layout of the device", send.message));
        };
        let form = &layout.messages()[message];
        self.own[message].clear();
        let mut is_change = false;
        for (name, value) in &send.set {
            let Some(signal) = form.signals.iter().position(|signal| signal.name == *name) else {
                return Err(format!("`{}` has no signal `{name}`", send.message));
            };
            let value = form.signals[signal].value_of(value).map_err(|(why, _)| why)?;
            is_change |= self.values[message][signal] != value;
            self.values[message][signal] = value;
            self.own[message].push(signal);
        }
        let signals = form.signals.iter().enumerate();
        let mut set = signals.filter(|(_, signal)| send.set.contains_key(&signal.name));
        let values = &self.values[message];
        if let Some((_, signal)) = set.find(|(place, _)| !form.carries(*place, values)) {
            return Err(format!(
                "`{}` has no `{}` with its multiplexers as they are: set them in the same step",
                send.message, signal.name
            ));
        }
        let every = send.every.or(form.period).filter(|every| *every > Span::ZERO);
        let repeat = |period, left| Repeat { message, period, due: now + period, left };
        let fast = form.send.fast.filter(|_| is_change && send.every != Some(Span::ZERO));
        self.repeats.retain(|repeat| repeat.message != message);
        self.repeats.extend(every.map(|period| repeat(period, None)));
        let least = form.send.min_delay;
        self.repeats.extend(fast.map(|(period, times)| repeat(period.max(least), Some(times))));
        self.encode(now, message)
    }

    pub(super) fn stop(&mut self, message: &str) {
        let message = self.outbox.layout().find(message);
        self.repeats.retain(|repeat| Some(repeat.message) != message);
    }

    pub(super) fn next_wakeup(&self) -> Timestamp {
        let repeats = self.repeats.iter().map(|repeat| repeat.due);
        let clients = self.clients.iter().map(|(_, client)| client.next_wakeup());
        repeats.chain(clients).min().unwrap_or(Timestamp::MAX).min(self.outbox.next_wakeup())
    }

    /// Takes a frame of its line: needed for segmented messages, where the receiver answers.
    pub(super) fn receive(&mut self, now: Timestamp, what: &Transmit) {
        if let Transmit::Frame(frame) = what {
            self.outbox.receive(now, frame);
            self.clients.iter_mut().for_each(|(_, client)| client.receive(now, frame));
        }
    }

    /// Sends the messages that are due.
    ///
    /// # Errors
    /// When a value does not fit.
    pub(super) fn wake(&mut self, now: Timestamp) -> Result<(), String> {
        let mut due: Vec<usize> = Vec::new();
        for Repeat { message, period, due: at, left } in &mut self.repeats {
            if *at > now {
                continue;
            }
            if !due.contains(message) {
                due.push(*message);
            }
            // Repetitions missed in real time are skipped, not sent in a burst.
            let missed = (now - *at).as_nanos() / period.as_nanos();
            *at += *period * (missed + 1);
            *left = left.map(|left| left - 1);
        }
        self.repeats.retain(|repeat| repeat.left != Some(0));
        for message in due {
            self.encode(now, message)?;
        }
        self.outbox.wake(now);
        self.clients.iter_mut().for_each(|(_, client)| client.wake(now));
        Ok(())
    }

    pub(super) fn transmit(&mut self) -> Option<Transmit> {
        let mut clients = self.clients.iter_mut();
        self.outbox
            .transmit()
            .or_else(|| clients.find_map(|(_, client)| client.transmit()).map(Transmit::Frame))
    }

    fn encode(&mut self, now: Timestamp, message: usize) -> Result<(), String> {
        let (values, own) = (&self.values[message], &self.own[message]);
        let sent = self.outbox.send(now, message, values, |signal| own.contains(&signal));
        sent.map_err(|error| error.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::Tester;
    use described::{Layout, Sender};
    use plan::Send;
    use std::collections::BTreeMap;
    use wire::time::{Span, Timestamp};

    const DBC: &str = r#"
BU_: Host Motor
BO_ 256 Command: 8 Host
 SG_ Speed : 0|16@1+ (1,0) [0|65535] "rpm" Motor
BA_DEF_ BO_ "GenMsgCycleTime" INT 0 65535;
BA_DEF_ BO_ "GenMsgCycleTimeFast" INT 0 65535;
BA_DEF_ BO_ "GenMsgNrOfRepetition" INT 0 100;
BA_DEF_ BO_ "GenMsgSendType" ENUM "cyclic","cyclicAndOnChange";
BA_DEF_DEF_ "GenMsgCycleTime" 0;
BA_DEF_DEF_ "GenMsgCycleTimeFast" 0;
BA_DEF_DEF_ "GenMsgNrOfRepetition" 0;
BA_DEF_DEF_ "GenMsgSendType" "cyclic";
BA_ "GenMsgCycleTime" BO_ 256 100;
BA_ "GenMsgCycleTimeFast" BO_ 256 10;
BA_ "GenMsgNrOfRepetition" BO_ 256 3;
BA_ "GenMsgSendType" BO_ 256 1;
"#;

    fn at_ms(ms: i64) -> Timestamp {
        Timestamp::ZERO + Span::from_millis(ms)
    }

    /// Times of frames until 250 ms, in ms.
    fn sent(tester: &mut Tester) -> Vec<i64> {
        let mut times = Vec::new();
        let mut now = Timestamp::ZERO;
        while now <= at_ms(250) {
            tester.wake(now).unwrap();
            while tester.transmit().is_some() {
                times.push((now - Timestamp::ZERO).as_nanos() / 1_000_000);
            }
            now = tester.next_wakeup();
        }
        times
    }

    #[test]
    fn after_a_change_it_is_sent_faster_for_a_while() {
        let layout = Layout::from_dbc("x.dbc", DBC, "Host").unwrap();
        let mut tester = Tester::new(layout, Sender::Device);
        let send = |speed: f64, every: Option<Span>| Send {
            message: "Command".to_owned(),
            set: BTreeMap::from([("Speed".to_owned(), speed.into())]),
            every,
        };
        tester.send(Timestamp::ZERO, &send(7.0, None)).unwrap();
        assert_eq!(sent(&mut tester), [0, 10, 20, 30, 100, 200]);
        tester.send(Timestamp::ZERO, &send(7.0, None)).unwrap();
        assert_eq!(sent(&mut tester), [0, 100, 200], "nothing changed");
        tester.send(Timestamp::ZERO, &send(8.0, Some(Span::ZERO))).unwrap();
        assert_eq!(sent(&mut tester), [0], "once is once");
    }
}
