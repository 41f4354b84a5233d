//! Talking with a program in virtual time, and what it sees of its inputs and its interfaces.

use crate::common::{bytes, c, python, secs};
use lockstep::{Lockstep, Program, Said};
use wire::device::{Device as _, PortId, Transmit};
use wire::packet::{BYTES_MAX, Packet};
use wire::serial::{Parity, SerialSettings};
use wire::time::{Span, Timestamp};

fn lines(running: &mut Lockstep) -> Vec<String> {
    let said = std::iter::from_fn(|| running.said());
    said.map(|said| match said {
        Said::Line(line) => String::from_utf8(line).unwrap(),
        Said::Lost => "LOST".to_owned(),
    })
    .collect()
}

/// Writes to it at an instant; returns its reply.
fn told(running: &mut Lockstep, ms: i64, text: &str) -> Vec<String> {
    let at = Timestamp::ZERO + Span::from_millis(ms);
    assert!(running.tell(at, text.as_bytes()));
    assert_eq!(running.next_wakeup(), at, "it wants to be run");
    assert_eq!(running.transmit(at), None);
    lines(running)
}

fn talks(program: Program) {
    let mut running = program.talks().start().unwrap();
    assert_eq!(running.transmit(secs(0)), None);
    assert_eq!(lines(&mut running), [""; 0]);
    assert_eq!(told(&mut running, 1_500, "one\n"), ["1500 one"]);
    assert_eq!(told(&mut running, 2_000, "two\nthree\nfo"), ["2000 two", "2000 three"]);
    assert_eq!(told(&mut running, 2_250, "ur\n"), ["2250 four"]);
    // The clock was set back.
    assert_eq!(told(&mut running, 1_750, "five\n"), ["1750 five"]);
    assert_eq!(running.ended(), None, "{}", running.last_words());
}

#[test]
fn a_program_in_c_is_talked_with() {
    talks(Program::new([c("talk.c")]));
}

fn script(text: &str) -> Program {
    let interpreter = python().into_string().unwrap();
    Program::new([interpreter.as_str(), "-c", text]).env("PYTHONHASHSEED", "0")
}

#[test]
fn a_program_in_python_is_talked_with() {
    talks(script(
        "import sys, time\n\
         for line in sys.stdin: print(round((time.monotonic() - 10_000) * 1000), line, end='', flush=True)",
    ));
}

/// Data that arrives at one instant is there at once, and one write is one packet.
#[test]
fn a_moment_is_one_and_a_write_is_one() {
    let text = "import os\n\
                port = os.open('/dev/ttyHIL0', os.O_RDWR)\n\
                while True:\n\
                \x20   heard = os.read(port, 100)\n\
                \x20   os.write(port, heard)\n\
                \x20   os.write(port, b'.')\n\
                \x20   os.write(port, b'x' * 200)\n";
    let mut running = script(text).serial("/dev/ttyHIL0").start().unwrap();
    assert_eq!(running.transmit(secs(0)), None);
    let (at, port) = (secs(1), PortId(0));
    running.receive(at, port, &bytes("ab"));
    running.receive(at, port, &bytes("cd"));
    let sent: Vec<Transmit> =
        std::iter::from_fn(|| running.transmit(at)).map(|(_, what)| what).collect();
    let long = ["x".repeat(BYTES_MAX), "x".repeat(200 - BYTES_MAX)];
    assert_eq!(sent, [bytes("abcd"), bytes("."), bytes(&long[0]), bytes(&long[1])]);
}

/// `PARMRK` as in termios(3): bytes that could be marks are doubled, until marks are switched off.
#[test]
fn what_could_be_a_mark_is_doubled() {
    let text = "import os, termios\n\
                port = os.open('/dev/ttyHIL0', os.O_RDWR)\n\
                settings = termios.tcgetattr(port)\n\
                for marks in (termios.PARMRK, 0):\n\
                \x20   settings[0] = settings[0] & ~termios.PARMRK | marks\n\
                \x20   termios.tcsetattr(port, termios.TCSANOW, settings)\n\
                \x20   os.write(port, os.read(port, 100).hex().encode())\n";
    let mut running = script(text).serial("/dev/ttyHIL0").start().unwrap();
    assert_eq!(running.transmit(secs(0)), None);
    let heard = Transmit::Bytes(Packet::from_slice(&[0x01, 0xFF, 0x02]).unwrap());
    for (at, expected) in [(secs(1), "01ffff02"), (secs(2), "01ff02")] {
        running.receive(at, PortId(0), &heard);
        assert_eq!(running.transmit(at), Some((PortId(0), bytes(expected))));
    }
}

/// A pty keeps neither data bits nor parity; a UART does.
#[test]
fn what_the_program_sets_of_its_port_is_known_and_given_back() {
    let text = "import os, termios\n\
                port = os.open('/dev/ttyHIL0', os.O_RDWR)\n\
                print(termios.tcgetattr(port)[4] == termios.B19200, flush=True)\n\
                os.read(port, 1)\n\
                settings = termios.tcgetattr(port)\n\
                settings[2] |= termios.CSTOPB\n\
                settings[4] = settings[5] = termios.B9600\n\
                termios.tcsetattr(port, termios.TCSANOW, settings)\n\
                settings[2] = settings[2] & ~termios.CSIZE | termios.CS7 | termios.PARENB\n\
                for _ in range(2): termios.tcsetattr(port, termios.TCSANOW, settings)\n\
                has = termios.tcgetattr(port)[2]\n\
                print(has & termios.CSIZE == termios.CS7, has & termios.PARENB != 0, flush=True)\n\
                os.read(port, 1)";
    let line = SerialSettings::new_8n1(19_200);
    let mut running = script(text).serial_at("/dev/ttyHIL0", line).talks().start().unwrap();
    assert_eq!(running.transmit(secs(0)), None);
    assert_eq!(running.framing(PortId(0)), None);
    running.receive(secs(1), PortId(0), &bytes("x"));
    assert_eq!(running.transmit(secs(1)), None);
    assert_eq!(lines(&mut running), ["True", "True True"], "{}", running.last_words());
    let set = SerialSettings { baud: 9_600, data_bits: 7, parity: Parity::Even, stop_bits: 2 };
    assert_eq!(running.framing(PortId(0)), Some(set));
}

#[test]
fn the_system_shows_its_interfaces() {
    let text = "import os, sys\n\
                folder = '/sys/class/net/can0/'\n\
                read = lambda name: open(folder + name).read().strip()\n\
                print(os.path.isdir(folder), read('type'), read('mtu'), read('operstate'), os.path.exists(folder + 'flags'))\n\
                print(os.path.exists('/sys/class/net/can1'), int(read('flags'), 16) & 1, flush=True)\n\
                sys.stdin.read()";
    let mut running = script(text).can_fd("can0").talks().start().unwrap();
    assert_eq!(running.transmit(secs(0)), None);
    assert_eq!(lines(&mut running), ["True 280 72 up True", "False 1"], "{}", running.last_words());
}
