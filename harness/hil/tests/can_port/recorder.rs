//! Recording of bursts on an interface of the kernel.

use crate::link::Link;
use crate::{NOW, frame, heard, opened, run};
use record::header::Header;
use record::run_folder::RunFolder;
use record::sink::{Level, RecordSink};
use record::{Device, Record, RecordKind};
use wire::time::Timestamp;

/// Total number of frames.
const FRAMES: u32 = 100_000;
/// Frames that arrive while the port does not receive: half of what the kernel's queue before the sockets holds
/// (`net.core.netdev_max_backlog`). On a busy machine the kernel drops what is beyond that.
const BURST: u32 = 500;

#[test]
fn bursts_and_then_the_end_are_recorded_whole() {
    run(async {
        let Some(link) = Link::make("hilrecord").await else { return };
        let (mut sender, mut recorder) = (opened(link.0).await, opened(link.0).await);
        let temporary = tempfile::tempdir().unwrap();
        let folder = RunFolder::create(temporary.path().join("run")).unwrap();
        let mut sink = folder.record_sink(&Header::default(), Level::Full).unwrap();

        let at = |number: u32| Timestamp::from_nanos(i64::from(number));
        for first in (0..FRAMES).step_by(BURST as usize) {
            let burst = first..first + BURST;
            burst.clone().for_each(|number| sender.send(NOW, &frame(number)));
            for number in burst {
                let kind = RecordKind::Frame(heard(&mut recorder).await);
                sink.record(Record { at: at(number), device: Device::Base, kind });
            }
        }
        sink.finish();
        assert!(sink.failed().is_none(), "{:?}", sink.failed());
        for counters in [sender.counters(), recorder.counters()] {
            assert!(counters.all_crossed(), "{counters:?}");
        }

        let mut records = folder.records().unwrap();
        for number in 0..FRAMES {
            let kind = RecordKind::Frame(frame(number));
            let expected = Record { at: at(number), device: Device::Base, kind };
            assert_eq!(records.next().expect("no frame is missing").unwrap(), expected);
        }
        assert!(records.next().is_none());
    });
}
