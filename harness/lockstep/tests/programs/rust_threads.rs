//! A controller in Rust with threads of the standard library: one reads, the main thread waits for its messages or for
//! 15 ms; a mutex and a condition variable connect it to a third.

use std::fs::OpenOptions;
use std::io::{BufRead as _, BufReader, Write as _};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Condvar, Mutex};
use std::time::{Duration, Instant};

#[expect(clippy::disallowed_methods, reason = "it knows nothing of virtual time")]
fn main() {
    let words: Vec<String> = std::env::args().collect();
    let gyro = OpenOptions::new().read(true).write(true).open(&words[1]).expect("the gyro");
    let mut base = OpenOptions::new().read(true).write(true).open(&words[2]).expect("the base");
    let start = Instant::now();
    let (sender, samples) = channel();
    std::thread::spawn(move || {
        for line in BufReader::new(gyro).lines() {
            let value: f64 = line.expect("a line").parse().expect("a number");
            sender.send(value).expect("somebody listens");
        }
    });
    let beat = Arc::new((Mutex::new(0u64), Condvar::new()));
    let counted = Arc::clone(&beat);
    std::thread::spawn(move || {
        loop {
            std::thread::sleep(Duration::from_millis(7));
            *counted.0.lock().expect("a lock") += 1;
            counted.1.notify_one();
        }
    });
    let (mut heading, mut late) = (0.0, 0u64);
    loop {
        match samples.recv_timeout(Duration::from_micros(9_500)) {
            Ok(value) => heading += value / 100.0,
            Err(RecvTimeoutError::Timeout) => late += 1,
            Err(RecvTimeoutError::Disconnected) => return,
        }
        let lock = beat.0.lock().expect("a lock");
        let (beats, _) = beat.1.wait_timeout(lock, Duration::from_millis(2)).expect("a lock");
        let at = start.elapsed().as_nanos();
        writeln!(base, "{heading:.4} {late} {} {at}", *beats).expect("the base");
    }
}
