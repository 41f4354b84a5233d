//! A record sink that shows its records to a feed.

use super::{Feed, Traffic};
use record::sink::{Level, RecordSink};
use record::{Device, Record, Violation};
use std::io;
use wire::can::CanFrame;
use wire::time::Timestamp;

/// Passes every record on unchanged, and shows it to a feed, if there is one. Traffic is counted here and shown once
/// per second of bench time: there are millions of frames, and each would need the lock.
pub struct Watched<S> {
    inner: S,
    feed: Option<Feed>,
    traffic: Traffic,
}

impl<S> Watched<S> {
    /// Creates a sink that shows to `feed` what `inner` receives.
    pub fn new(inner: S, feed: Option<&Feed>) -> Self {
        let traffic = feed.map(|feed| feed.model().traffic.clone()).unwrap_or_default();
        Self { inner, feed: feed.cloned(), traffic }
    }

    pub fn into_inner(self) -> S {
        self.inner
    }

    /// Shows the traffic of the begun second as well.
    pub fn show_traffic(&self) {
        if let Some(feed) = &self.feed {
            feed.model().traffic.clone_from(&self.traffic);
        }
    }
}

impl<S: RecordSink> RecordSink for Watched<S> {
    fn record(&mut self, record: Record) {
        if let Some(feed) = &self.feed {
            feed.take(&record);
        }
        self.inner.record(record);
    }

    fn bytes(&mut self, at: Timestamp, device: Device, bytes: &[u8]) {
        if self.feed.is_some() && self.traffic.bytes(at, device, bytes.len()) {
            self.show_traffic();
        }
        self.inner.bytes(at, device, bytes);
    }

    fn frame(&mut self, at: Timestamp, device: Device, frame: CanFrame) {
        if self.feed.is_some() && self.traffic.frame(at, device, &frame) {
            self.show_traffic();
        }
        self.inner.frame(at, device, frame);
    }

    fn broken(&mut self, name: &str, violation: &Violation) {
        if let Some(feed) = &self.feed {
            feed.model().broken(name, violation);
        }
        self.inner.broken(name, violation);
    }

    fn level(&self) -> Level {
        self.inner.level()
    }

    fn failed(&self) -> Option<&io::Error> {
        self.inner.failed()
    }

    fn finish(&mut self) {
        self.show_traffic();
        self.inner.finish();
    }
}
