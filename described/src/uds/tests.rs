//! A client and the server of the documentation page, and the mistakes of a file.

use super::{Reply, Request, UdsClient};
use crate::{Description, Device};
use proptest::prelude::*;
use std::sync::Arc;
use wire::can::{CanFrame, StandardId};
use wire::device::Transmit;
use wire::time::{Span, Timestamp};

const PAGE: &str = include_str!("../../../docs/uds.md");

/// The device of the page.
fn heater() -> &'static str {
    PAGE.split("```toml\n").nth(1).unwrap().split("```").next().unwrap()
}

fn description(text: &str) -> Description {
    let read = Description::parse("heater.toml", text, &mut |name| Err(name.to_owned()));
    read.unwrap_or_else(|error| panic!("{error}"))
}

/// A device and a client on a line without delay.
struct Bench {
    device: Device,
    client: UdsClient,
    now: Timestamp,
    /// Ordinary messages sent.
    messages: usize,
    /// Identifiers of the frames of the client, and its own, that are lost.
    pending: usize,
}

impl Bench {
    fn new(text: &str) -> Self {
        let description = Arc::new(description(text));
        let client = UdsClient::new(description.isotp().unwrap());
        let device = Device::new(description, 1);
        Self { device, client, now: Timestamp::ZERO, messages: 0, pending: 0 }
    }

    /// Lets everything happen up to `until`, or up to a reply.
    fn go_on(&mut self, until: Timestamp) -> Option<Reply> {
        loop {
            loop {
                let mut quiet = true;
                while let Some(frame) = self.client.transmit() {
                    quiet = false;
                    self.device.receive_frame(self.now, &frame);
                }
                while let Some(Transmit::Frame(frame)) = self.device.transmit() {
                    quiet = false;
                    self.messages +=
                        usize::from(frame.id() == StandardId::new(0x100).unwrap().into());
                    self.pending += usize::from(
                        frame.data().starts_with(&[3, 0x7F]) && frame.data()[3] == 0x78,
                    );
                    self.client.receive(self.now, &frame);
                }
                if quiet {
                    break;
                }
            }
            if let Some(reply) = self.client.reply() {
                return Some(reply);
            }
            let next = self.device.next_wakeup().min(self.client.next_wakeup());
            if next > until {
                self.now = until;
                return None;
            }
            self.now = self.now.max(next);
            self.device.wake(self.now);
            self.client.wake(self.now);
        }
    }

    fn wait(&mut self, s: f64) {
        let until = self.now + Span::from_secs_f64(s);
        assert_eq!(self.go_on(until), None);
    }

    fn request(&mut self, data: &[u8], functional: bool) -> Reply {
        let (p2, p2_star) = (Span::from_millis(60), Span::from_secs(5));
        self.client.ask(self.now, Request { data: data.to_vec(), functional, p2, p2_star });
        self.go_on(Timestamp::MAX).unwrap()
    }

    fn ask(&mut self, data: &[u8]) -> Vec<u8> {
        match self.request(data, false) {
            Reply::Response(response) => response,
            other => panic!("{data:x?}: {other:?}"),
        }
    }

    fn unlock(&mut self) {
        assert_eq!(self.ask(&[0x10, 3])[0], 0x50);
        let seed = self.ask(&[0x27, 1]);
        let key: Vec<u8> = seed[2..].iter().map(|byte| byte ^ 0x5A).collect();
        assert_eq!(self.ask(&[&[0x27, 2], &key[..]].concat()), [0x67, 2]);
    }
}

#[test]
fn data_is_read_several_at_once() {
    let mut bench = Bench::new(heater());
    assert_eq!(bench.ask(&[0x22, 0xF1, 0x90]), b"\x62\xF1\x90WHEATER0000000042");
    assert_eq!(
        bench.ask(&[0x22, 1, 1, 9, 9, 1, 0]),
        [0x62, 1, 1, 60, 1, 0, 0, 200],
        "an unknown one among others is left out"
    );
    assert_eq!(bench.ask(&[0x22, 9, 9]), [0x7F, 0x22, 0x31]);
    assert_eq!(bench.ask(&[0x22, 9]), [0x7F, 0x22, 0x13]);
    assert_eq!(bench.ask(&[0x99, 9]), [0x7F, 0x99, 0x11]);
    bench.wait(10.0);
    let response = bench.ask(&[0x22, 1, 0]);
    let value = i16::from_be_bytes([response[3], response[4]]);
    // 120 K and 300 s: 20 + 120 (1 - exp(-10 / 300)) degrees.
    assert_eq!(value, (200.0 + 1200.0 * (1.0 - (-10f64 / 300.0).exp())).round() as i16);
}

#[test]
fn writing_needs_session_and_security() {
    let mut bench = Bench::new(heater());
    assert_eq!(bench.ask(&[0x2E, 1, 1, 70]), [0x7F, 0x2E, 0x7F]);
    assert_eq!(bench.ask(&[0x10, 3]), [0x50, 3, 0, 50, 1, 0xF4]);
    assert_eq!(bench.ask(&[0x2E, 1, 1, 70]), [0x7F, 0x2E, 0x33]);
    bench.unlock();
    assert_eq!(bench.ask(&[0x27, 1]), [0x67, 1, 0, 0, 0, 0], "it is unlocked");
    assert_eq!(bench.ask(&[0x2E, 1, 1, 70]), [0x6E, 1, 1]);
    assert_eq!(bench.ask(&[0x22, 1, 1]), [0x62, 1, 1, 70]);
    assert_eq!(bench.ask(&[0x2E, 1, 1, 95]), [0x7F, 0x2E, 0x31], "beyond the parameter");
    assert_eq!(bench.ask(&[0x2E, 1, 1, 70, 0]), [0x7F, 0x2E, 0x13]);
    assert_eq!(bench.ask(&[0x2E, 1, 0, 70, 0]), [0x7F, 0x2E, 0x31], "nothing to set");
    assert_eq!(bench.ask(&[0x10, 5]), [0x7F, 0x10, 0x12]);
    assert_eq!(bench.ask(&[0x10, 3])[0], 0x50);
    assert_eq!(bench.ask(&[0x2E, 1, 1, 70]), [0x7F, 0x2E, 0x33], "a session locks");
}

#[test]
fn a_text_is_written_for_good_by_one_of_its_length() {
    let text = "text = \"WHEATER0000000042\"\n";
    let mut bench = Bench::new(&heater().replace(text, &format!("{text}write = {{}}\n")));
    let vin = b"WHEATER0000000043";
    let write = |vin: &[u8]| [b"\x2E\xF1\x90", vin].concat();
    assert_eq!(bench.ask(&[0x10, 3])[0], 0x50);
    assert_eq!(bench.ask(&write(&vin[1..])), [0x7F, 0x2E, 0x13]);
    assert_eq!(bench.ask(&[0x22, 0xF1, 0x90]), b"\x62\xF1\x90WHEATER0000000042");
    assert_eq!(bench.ask(&write(vin)), b"\x6E\xF1\x90");
    assert_eq!(bench.ask(&[0x11, 1]), [0x51, 1]);
    bench.wait(1.0);
    assert_eq!(bench.ask(&[0x22, 0xF1, 0x90]), [b"\x62\xF1\x90", &vin[..]].concat());
}

#[test]
fn wrong_keys_are_counted_and_then_delayed() {
    let mut bench = Bench::new(heater());
    assert_eq!(bench.ask(&[0x27, 2, 0, 0, 0, 0]), [0x7F, 0x27, 0x24], "no seed was given");
    let seeds = [1, 2].map(|_| bench.ask(&[0x27, 1]));
    assert_ne!(seeds[0], seeds[1]);
    for code in [0x35, 0x35, 0x36] {
        bench.ask(&[0x27, 1]);
        assert_eq!(bench.ask(&[0x27, 2, 0, 0, 0, 0]), [0x7F, 0x27, code]);
    }
    assert_eq!(bench.ask(&[0x27, 1]), [0x7F, 0x27, 0x37]);
    assert_eq!(bench.ask(&[0x11, 1]), [0x51, 1]);
    bench.wait(5.0);
    assert_eq!(bench.ask(&[0x27, 1]), [0x7F, 0x27, 0x37], "a reset does not shorten it");
    bench.wait(5.0);
    bench.unlock();
    assert_eq!(bench.ask(&[0x27, 3]), [0x7F, 0x27, 0x12]);
}

#[test]
fn a_session_ends_without_tester_present() {
    let mut bench = Bench::new(heater());
    bench.unlock();
    for _ in 0..3 {
        bench.wait(4.0);
        assert_eq!(bench.request(&[0x3E, 0x80], false), Reply::Silence);
    }
    assert_eq!(bench.ask(&[0x2E, 1, 1, 70]), [0x6E, 1, 1]);
    bench.wait(4.9);
    assert_eq!(bench.ask(&[0x3E, 0]), [0x7E, 0]);
    bench.wait(5.1);
    assert_eq!(bench.ask(&[0x2E, 1, 1, 70]), [0x7F, 0x2E, 0x7F]);
}

#[test]
fn a_reset_undoes_what_requests_have_set() {
    let mut bench = Bench::new(heater());
    bench.device.set_parameter(Timestamp::ZERO, "fan", 1.0);
    bench.unlock();
    bench.ask(&[0x2E, 1, 1, 80]);
    bench.wait(4.0);
    assert!(bench.device.value("temperature").unwrap() > 21.0);
    assert_eq!(bench.ask(&[0x11, 1]), [0x51, 1]);
    bench.wait(0.01);
    assert_eq!(bench.request(&[0x3E, 0], false), Reply::Silence, "it restarts");
    bench.wait(0.2);
    assert_eq!(bench.ask(&[0x22, 1, 1]), [0x62, 1, 1, 60]);
    assert!(bench.device.value("temperature").unwrap() < 20.2);
    assert_eq!(bench.device.value("fan"), Some(1.0), "that was not by a request");
}

#[test]
fn trouble_codes_have_the_status_of_the_standard() {
    let mut bench = Bench::new(heater());
    let status = |bench: &mut Bench| bench.ask(&[0x19, 0x0A])[10];
    assert_eq!(bench.ask(&[0x19, 0x0A])[..7], [0x59, 0x0A, 0xFF, 0x0A, 0x0F, 0x16, 0]);
    assert_eq!(status(&mut bench), 0, "tested, and never failed");
    bench.device.set_parameter(bench.now, "setpoint", 75.0);
    assert_eq!(status(&mut bench), 0xAF);
    bench.device.set_parameter(bench.now, "setpoint", 65.0);
    assert_eq!(status(&mut bench), 0xAE, "it has failed in this cycle");
    assert_eq!(bench.ask(&[0x19, 1, 8]), [0x59, 1, 0xFF, 1, 0, 1]);
    assert_eq!(bench.ask(&[0x19, 2, 1]), [0x59, 2, 0xFF]);
    for (cycles, expected) in [(1, 0xAC), (2, 0xA8)] {
        bench.ask(&[0x11, 1]);
        bench.wait(0.5);
        assert_eq!(status(&mut bench), expected, "after {cycles}");
    }
    assert_eq!(bench.ask(&[0x14, 0, 0, 1]), [0x7F, 0x14, 0x31]);
    assert_eq!(bench.ask(&[0x14, 0x12, 0x34, 0x56]), [0x54]);
    assert_eq!(status(&mut bench), 0);
    bench.ask(&[0x10, 3]);
    assert_eq!(bench.ask(&[0x85, 2]), [0xC5, 2]);
    bench.device.set_parameter(bench.now, "setpoint", 75.0);
    assert_eq!(status(&mut bench), 0, "the tests are off");
    bench.ask(&[0x10, 1]);
    assert_eq!(status(&mut bench), 0xAF);
    assert_eq!(bench.ask(&[0x19, 6]), [0x7F, 0x19, 0x12]);
}

#[test]
fn a_failure_between_requests_is_remembered_once_it_has_lasted() {
    let text = heater().replace("temperature > 80", "abs(t - 2.03) < 0.2 or t > 5 and t < 5.7");
    let mut bench = Bench::new(&text);
    let status = |bench: &mut Bench| bench.ask(&[0x19, 0x0A])[6];
    bench.wait(4.0);
    assert_eq!(status(&mut bench), 0, "0.4 s are too short");
    bench.wait(4.0);
    assert_eq!(status(&mut bench), 0x2E, "0.7 s are not");
}

#[test]
fn what_takes_longer_than_p2_is_pending() {
    let mut bench = Bench::new(heater());
    bench.device.set_parameter(bench.now, "slow", 6.0);
    assert_eq!(bench.ask(&[0x22, 1, 1]), [0x62, 1, 1, 60]);
    assert_eq!(bench.now, Timestamp::from_secs_f64(6.0));
    assert_eq!(bench.pending, 2);
    let silent = heater().replace("s3_s = 5", "s3_s = 5\nresponse_pending = false");
    let mut bench = Bench::new(&silent);
    bench.device.set_parameter(bench.now, "slow", 0.1);
    assert_eq!(bench.request(&[0x22, 1, 1], false), Reply::Silence);
    assert_eq!(bench.ask(&[0x3E, 0]), [0x7F, 0x3E, 0x21], "it is still busy");
}

#[test]
fn routines_have_an_order() {
    let mut bench = Bench::new(heater());
    assert_eq!(bench.ask(&[0x31, 1, 2, 3]), [0x7F, 0x31, 0x31], "not in this session");
    bench.ask(&[0x10, 3]);
    assert_eq!(bench.ask(&[0x31, 3, 2, 3]), [0x7F, 0x31, 0x24]);
    assert_eq!(bench.ask(&[0x31, 1, 2, 3]), [0x71, 1, 2, 3]);
    assert_eq!(bench.ask(&[0x31, 3, 2, 3]), [0x71, 3, 2, 3, 1]);
    assert_eq!(bench.ask(&[0x31, 2, 2, 3]), [0x71, 2, 2, 3]);
    assert_eq!(bench.device.value("fan"), Some(0.0));
    assert_eq!(bench.ask(&[0x31, 4, 2, 3]), [0x7F, 0x31, 0x12]);
}

#[test]
fn the_ordinary_messages_can_be_silenced() {
    let mut bench = Bench::new(heater());
    bench.ask(&[0x10, 3]);
    assert_eq!(bench.ask(&[0x28, 1, 1]), [0x68, 1]);
    let before = bench.messages;
    bench.wait(2.0);
    assert_eq!(bench.messages, before);
    bench.wait(4.0);
    assert!(bench.messages > before, "until the session ends");
    assert_eq!(bench.ask(&[0x28, 9, 1]), [0x7F, 0x28, 0x12]);
}

#[test]
fn errors_are_not_answered_to_all() {
    let mut bench = Bench::new(heater());
    assert_eq!(bench.request(&[0x22, 9, 9], true), Reply::Silence);
    assert_eq!(bench.request(&[0x3E, 0], true), Reply::Response(vec![0x7E, 0]));
    assert_eq!(bench.request(&[0x22, 1], true), Reply::Response(vec![0x7F, 0x22, 0x13]));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn no_request_causes_a_panic(
        requests in prop::collection::vec((prop::sample::select(vec![0x10u8, 0x11, 0x14, 0x19, 0x22, 0x27, 0x28, 0x2E, 0x31, 0x3E, 0x85, 0]), prop::collection::vec(any::<u8>(), 0..20)), 0..30),
    ) {
        let mut bench = Bench::new(heater());
        for (service, rest) in requests {
            bench.request(&[&[service], rest.as_slice()].concat(), false);
        }
        prop_assert_eq!(bench.device.not_finite(), 0);
    }

    #[test]
    fn no_frame_causes_a_panic(
        frames in prop::collection::vec((prop::sample::select(vec![0x7E0, 0x7DF]), prop::collection::vec(any::<u8>(), 0..=8)), 0..100),
    ) {
        let mut device = Device::new(Arc::new(description(heater())), 1);
        for (at, (id, data)) in frames.into_iter().enumerate() {
            let now = Timestamp::ZERO + Span::from_millis(at as i64);
            device.receive_frame(now, &CanFrame::new(StandardId::new(id).unwrap(), &data).unwrap());
            device.wake(now);
            while device.transmit().is_some() {}
        }
    }
}

#[test]
fn mistakes_are_found_at_their_place() {
    for (from, to, marked, message) in [
        ("[uds.did.0x0100]", "[uds.did.0xF1_90]", "0xF1_90", "`0xF1_90` is not a number"),
        ("[uds.did.0x0100]", "[uds.did.61840]", "61840", "0xf190 is in the file twice"),
        ("key = \"bit_xor(seed, 0x5A5A5A5A)\"\n", "", "1", "a security level without a `key`"),
        ("(seed, 0x", "(sed, 0x", "sed", "no variable `sed`"),
        ("response_id = 0x7E8", "response_id = 0x100", "0x100", "`Status` has the same identifier"),
        (
            "[\"extended\"] }\n\n[uds.did",
            "[\"extnded\"] }\n\n[uds.did",
            "\"extnded\"",
            "no session `extnded`",
        ),
        ("write = { security = 1 }", "write = { security = 3 }", "3", "no security level 3"),
        ("set = \"setpoint\" ", "set = \"setpint\" ", "\"setpint\"", "no parameter `setpint`"),
        ("[uds.dtc.0x123456]", "[uds.dtc.0x0A0F16]", "P0A0F-16", "0x0a0f16 is in the file twice"),
        ("[uds.service.read_data]", "[uds.service.read]", "read", "no service `read`"),
        (
            "value = \"temperature\"",
            "value = \"temprature\"",
            "temprature",
            "no variable `temprature`",
        ),
        ("p2_s = 0.05", "p2_s = 100", "100", "100 s, expected 0.001 s to 65.535 s"),
    ] {
        assert!(heater().contains(from), "{from}");
        let text = heater().replacen(from, to, 1);
        let error =
            Description::parse("heater.toml", &text, &mut |_| Err(String::new())).unwrap_err();
        assert_eq!(error.message(), message);
        assert_eq!(&text[error.range()], marked, "{message}");
    }
}
