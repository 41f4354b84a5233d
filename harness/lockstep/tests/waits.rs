//! Every way to wait takes exactly the requested time.

use crate::common::{bytes, c, compiled, drive, secs, text};
use lockstep::{Ended, Program};
use wire::device::{Device as _, PortId};
use wire::time::{Span, Timestamp};

const EXPECTED: &str = "\
nanosleep 0 1000001
clock_nanosleep 0 2000002
select 0 3000000
pselect 0 4000004
ppoll 0 5000005
thrd_sleep 0 5000005
sem_timedwait -1 6000006
cond_timedwait 110 7000007
cond_clockwait 110 8000008
mutex_timedlock 110 2000002
mutex_lock 0 4999998
rwlock_rdlock 0 5000000
sem_wait 0 3000000
join 0 1000000
epoll_wait 1 9000009
timerfd 3 0
timerfd 1 7000027
setitimer -3 12000000
alarms 3 0
vtime 0 500000000
";

#[test]
fn every_wait_takes_what_was_asked_for() {
    all_take_what_was_asked_for(&c("waits.c"));
}

#[test]
fn every_wait_of_a_static_program_takes_what_was_asked_for() {
    all_take_what_was_asked_for(&compiled("gcc", "waits.c", &["-static"]));
}

fn all_take_what_was_asked_for(path: &str) {
    let run = || {
        let program = Program::new([path]).serial("/dev/ttyHIL0");
        let mut running = program.start().unwrap();
        let mut events = drive(&mut running, secs(2), &[]);
        assert_eq!(text(&events, 0), EXPECTED, "{:?}", running.state());
        assert_eq!(running.next_wakeup(), Timestamp::MAX);
        // Byte by byte, a tenth of a second apart; then a line with a terminal's line ending, and another one.
        for (tenth, what) in
            ["a", "b", "c", "li", "ne!", "\r", "by stdio\r"].into_iter().enumerate()
        {
            let at = secs(2) + Span::from_millis(100 * (tenth as i64 + 1));
            running.receive(at, PortId(0), &bytes(what));
            events.extend(drive(&mut running, at, &[]));
            while let Some((port, what)) = running.transmit(at) {
                events.push(lockstep::verify::Event { at, port, what });
            }
        }
        assert!(matches!(running.ended(), Some(Ended::Exited(status)) if status.success()));
        events
    };
    let first = run();
    let all = text(&first, 0);
    let rest = all.strip_prefix(EXPECTED).unwrap();
    assert_eq!(rest.lines().count(), 3, "{rest}");
    let words: Vec<&str> = rest.split_ascii_whitespace().collect();
    assert_eq!(words[..2], ["vmin", "3"]);
    assert_eq!(words[3..5], ["canonical", "1"]);
    assert_eq!((words[5], &words[6..10]), ("300000000", &["at", "the", "end", "9"][..]));
    assert_eq!(lockstep::verify::compare(&first, &run()), None);
}
