//! Comparison with another implementation of end-to-end protection: random messages protected by the Python package
//! autosar-e2e. `data/protect_with_autosar_e2e.py` wrote the file (autosar-e2e 1.0.0).

use described::{Description, Layout, Outbox, Verdict};
use wire::can::CanFrame;
use wire::device::Transmit;
use wire::time::Timestamp;

const MESSAGES: &str = include_str!("data/autosar_e2e.csv");

/// The start byte of a packet.
const START: u8 = 0xaa;

struct Row<'a> {
    profile: &'a str,
    data_ids: &'a str,
    at: usize,
    bytes: Vec<u8>,
    protected: Vec<u8>,
}

fn row(line: &str) -> Row<'_> {
    let cells: Vec<&str> = line.split(',').collect();
    let [profile, data_ids, at, bytes, protected] = cells[..] else { panic!("{line}") };
    let hex = |text: &str| {
        let byte = |at: usize| u8::from_str_radix(&text[at..at + 2], 16).expect("a byte");
        (0..text.len()).step_by(2).map(byte).collect()
    };
    let at = at.parse().expect("a place");
    Row { profile, data_ids, at, bytes: hex(bytes), protected: hex(protected) }
}

impl Row<'_> {
    /// The fields of a message that protect it: name, first bit as in a DBC, length, byte order.
    fn fields(&self) -> [(&'static str, usize, usize, usize); 2] {
        let at = 8 * self.at;
        match self.profile {
            "4" => [("Crc", at + 71, 32, 0), ("Alive", at + 23, 16, 0)],
            "5" => [("Crc", at, 16, 1), ("Alive", at + 16, 8, 1)],
            _ => [("Crc", at, 8, 1), ("Alive", at + 8, 4, 1)],
        }
    }

    /// The row's counter number.
    fn counter(&self) -> f64 {
        let byte = |at: usize| f64::from(self.bytes[at]);
        match self.profile {
            "4" => 256.0 * byte(self.at + 2) + byte(self.at + 3),
            "5" => byte(self.at + 2),
            _ => f64::from(self.bytes[self.at + 1] & 0xf),
        }
    }

    /// The keys of its protection.
    fn e2e(&self) -> String {
        let ids = match self.profile {
            "2" => format!("data_ids = [{}]", self.data_ids.replace(' ', ", ")),
            _ => format!("data_id = {}", self.data_ids),
        };
        let profile = self.profile;
        format!(
            "e2e = {{ profile = \"{profile}\", {ids}, counter = \"Alive\", checksum = \"Crc\" }}"
        )
    }

    /// A message on CAN with the protection signals; each half of the other bytes is a signal.
    fn on_can(&self) -> Layout {
        let mut dbc = "VERSION \"\"\n\nBU_: A B\n\nBO_ 1 M: 8 A\n".to_owned();
        let taken = |half: usize| {
            self.fields()
                .iter()
                .any(|(_, start, length, _)| (*start..start + length).contains(&(4 * half)))
        };
        for (name, start, length, order) in self.fields() {
            dbc += &format!(" SG_ {name} : {start}|{length}@{order}+ (1,0) [0|0] \"\" B\n");
        }
        for half in (0..16).filter(|half| !taken(*half)) {
            dbc += &format!(" SG_ H{half} : {}|4@1+ (1,0) [0|0] \"\" B\n", 4 * half);
        }
        let text = format!(
            "name = \"a\"\ndbc = \"a.dbc\"\nnode = \"A\"\n[message.M]\nperiod_s = 1\n{}\n",
            self.e2e()
        );
        let read = &mut |_: &str| Ok(dbc.clone());
        let description = Description::parse("a.toml", &text, read);
        description.unwrap_or_else(|error| panic!("{error}\n{text}")).layout().clone()
    }

    /// A packet or a frame of CAN FD, with bytes before and after the header.
    fn of_fields(&self, is_packet: bool) -> Layout {
        let mut fields: Vec<String> =
            (0..self.at).map(|at| format!("{{ name = \"B{at}\", type = \"u8\" }}")).collect();
        for (name, kind) in [("Length", "u16"), ("Alive", "u16"), ("Id", "u32"), ("Crc", "u32")] {
            fields.push(format!("{{ name = \"{name}\", type = \"{kind}\", order = \"big\" }}"));
        }
        fields
            .extend((self.at + 12..16).map(|at| format!("{{ name = \"B{at}\", type = \"u8\" }}")));
        let (line, begin) = match is_packet {
            true => ("[serial]\nbaud = 9600\n", format!("start = [{START}]")),
            false => ("", "can_id = 1\nfd = true".to_owned()),
        };
        let text = format!(
            "name = \"a\"\n{line}[[message]]\nname = \"M\"\nsent_by = \"device\"\n{begin}\n\
             period_s = 1\n{}\nfields = [{}]\n",
            self.e2e(),
            fields.join(", ")
        );
        let description = Description::parse("a.toml", &text, &mut |_| Err(String::new()));
        description.unwrap_or_else(|error| panic!("{error}\n{text}")).layout().clone()
    }

    /// The value of a signal with this name.
    fn value(&self, name: &str) -> f64 {
        let number = |from: usize| name[from..].parse::<usize>().expect("a number");
        match name {
            "Alive" => self.counter(),
            "Crc" | "Length" | "Id" => 0.0,
            _ if name.starts_with('B') => f64::from(self.bytes[number(1)]),
            _ => f64::from(self.bytes[number(1) / 2] >> (4 * (number(1) % 2)) & 0xf),
        }
    }
}

#[test]
fn messages_are_those_of_autosar_e2e() {
    let mut compared = 0;
    for line in MESSAGES.lines().skip(1) {
        let row = row(line);
        let layouts = match row.profile {
            "4" => vec![row.of_fields(true), row.of_fields(false)],
            _ => vec![row.on_can()],
        };
        for layout in layouts {
            compare(line, &row, &layout);
            compared += 1;
        }
    }
    assert_eq!(compared, 280);
}

fn compare(line: &str, row: &Row<'_>, layout: &Layout) {
    let signals = &layout.messages()[0].signals;
    let values: Vec<f64> = signals.iter().map(|signal| row.value(&signal.name)).collect();
    // The counter of the row is used.
    let is_own = |signal: usize| signals[signal].name == "Alive";
    let mut outbox = Outbox::new(layout.clone(), layout.messages()[0].sender, 1);
    outbox.send(Timestamp::ZERO, 0, &values, is_own).expect("all in range");
    let wired = outbox.transmit().expect("one frame or packet");
    let mut verdict = None;
    let bytes = match &wired {
        Transmit::Frame(frame) => {
            verdict = layout.decoder().frame(frame).and_then(|found| found.verdict);
            frame.data().to_vec()
        }
        Transmit::Bytes(packet) => {
            let mut decoder = layout.decoder();
            decoder.bytes(packet.as_slice(), &mut |found| verdict = found.verdict);
            packet.as_slice()[1..].to_vec()
        }
    };
    assert_eq!(bytes, row.protected, "{line}");
    assert_eq!(verdict, Some(Verdict::Ok), "{line}");
}

/// Every changed bit in their frames is detected.
#[test]
fn damage_to_their_frames_is_noticed() {
    for line in MESSAGES.lines().skip(1).map(row).filter(|row| row.profile != "4") {
        let layout = line.on_can();
        let id = layout.messages()[0].can_id().expect("on CAN");
        for bit in 0..64 {
            let mut data = line.protected.clone();
            data[bit / 8] ^= 1 << (bit % 8);
            let frame = CanFrame::new(id, &data).expect("eight bytes");
            let verdict = layout.decoder().frame(&frame).and_then(|found| found.verdict);
            assert_eq!(verdict, Some(Verdict::WrongChecksum), "{} {bit}", line.profile);
        }
    }
}
