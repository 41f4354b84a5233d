//! debug
use lockstep::*;
use wire::device::Device as _;
fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let p = Program::new(words)
        .can("can0")
        .serial("/dev/ttyHIL0")
        .env("PYTHONHASHSEED", "0")
        .wall_limit(std::time::Duration::from_secs(4))
        .output(Output::Sink(Box::new(|b| print!("{}", String::from_utf8_lossy(b)))));
    let mut r = p.start().expect("start");
    for _ in 0..200 {
        let t = r.next_wakeup();
        eprintln!("wake {t:?} {:?} pids {:?}", r.state(), r.pids());
        if t == wire::time::Timestamp::MAX {
            break;
        }
        r.wake(t);
        while let Some(x) = r.transmit(t) {
            eprintln!("sent {x:?}");
        }
    }
    eprintln!("{:?} {}", r.state(), r.last_words());
    if std::env::var_os("HOLD").is_some() {
        loop {
            std::thread::park();
        }
    }
}
