//! Load of the bus and the serial lines in each second.

use super::download::Table;
use super::frame::{Axis, Frame, SCALE};
use super::listed::counted;
use super::palette::CCW;
use super::thin::{Point, extremes};
use maud::{Markup, html};
use plotters::element::PathElement;
use plotters::style::Color;
use record::header::{Bus, Header, Line};
use record::{Device, Record, RecordKind};
use std::collections::BTreeMap;
use wire::can::BitRates;

/// Maximum number of seconds: two days.
const SECONDS_MAX: usize = 172_800;

/// Columns of a plot; two points per column are drawn.
const COLUMNS: usize = 600;

/// Longer runs are plotted in hours.
const SHORT_MAX: usize = 7_200;

/// Amount on a line in each second, from the first.
type Seconds = Vec<u32>;

#[derive(Debug, Default)]
pub(super) struct BusLoad {
    /// Nanoseconds with frames on the bus, by index of the bus.
    busy_ns: BTreeMap<usize, Seconds>,
    bytes: BTreeMap<Device, Seconds>,
    /// Number of frames and packets later than [`SECONDS_MAX`].
    overflowed: u64,
    /// Bench time of the last record, s.
    end_s: f64,
}

impl BusLoad {
    pub(super) fn add(&mut self, header: &Header, record: &Record) {
        self.end_s = self.end_s.max(record.at.as_secs_f64());
        let (seconds, amount) = match &record.kind {
            RecordKind::Frame(frame) => {
                let bus = header.bus_of(record.device);
                let busy = frame.duration(rates(header, bus)).as_nanos();
                (self.busy_ns.entry(bus).or_default(), u32::try_from(busy).unwrap_or(u32::MAX))
            }
            RecordKind::Bytes(bytes) => {
                let count = u32::try_from(bytes.len()).unwrap_or(u32::MAX);
                (self.bytes.entry(record.device).or_default(), count)
            }
            _ => return,
        };
        // Whole seconds; no time is negative.
        let second = record.at.as_secs_f64() as usize;
        if second >= SECONDS_MAX {
            self.overflowed += 1;
            return;
        }
        if seconds.len() <= second {
            seconds.resize(second + 1, 0);
        }
        seconds[second] = seconds[second].saturating_add(amount);
    }

    /// Amount per second, in whole seconds. Part of one at the end would look like a quiet line; a run shorter than a second
    /// has its mean.
    fn points(&self, seconds: &[u32]) -> Vec<Point> {
        let whole = self.end_s as usize;
        if whole == 0 {
            let amount = seconds.first().map_or(0.0, |amount| f64::from(*amount));
            let mean = if self.end_s > 0.0 { amount / self.end_s } else { amount };
            return vec![(0.0, mean)];
        }
        let whole = seconds.iter().take(whole).enumerate();
        whole.map(|(at, amount)| (at as f64, f64::from(*amount))).collect()
    }

    /// Plots each line; a sentence if the record contains neither frames nor bytes.
    pub(super) fn plots(&self, header: &Header) -> Markup {
        if self.busy_ns.is_empty() && self.bytes.is_empty() {
            return html! {
                p.missing {
                    "The record holds no frames and no bytes; " code { "--record full" } " keeps them."
                }
            };
        }
        html! {
            div.plots {
                @for (place, seconds) in &self.busy_ns {
                    (bus(header, *place, &self.points(seconds)))
                }
                @for (device, seconds) in &self.bytes {
                    @let line = header.lines.iter().find(|line| line.device == *device);
                    (serial(*device, &self.points(seconds), line))
                }
            }
            @if self.overflowed > 0 {
                p.missing { (self.overflowed) " frames and packets came later than is drawn." }
            }
        }
    }
}

fn scaled(points: &[Point], unit: f64) -> Vec<Point> {
    points.iter().map(|(at, amount)| (*at, amount * unit)).collect()
}

fn rates(header: &Header, bus: usize) -> BitRates {
    header.buses.get(bus).map_or(BitRates::USUAL, Bus::rates)
}

fn bus(header: &Header, place: usize, busy_ns: &[Point]) -> Markup {
    let rates = rates(header, place);
    let title = match header.buses.get(place) {
        Some(bus) => format!("CAN bus {}", bus.line),
        None => "CAN bus".to_owned(),
    };
    let fast =
        rates.data.map(|rate| format!(" and {} kbit/s for the data of CAN FD", rate / 1_000));
    let note = format!(
        "Of {} kbit/s{}, the rate of the emulated bus.",
        rates.nominal / 1_000,
        fast.unwrap_or_default()
    );
    plot(&title, "share of bit time in %", &scaled(busy_ns, 1e-7), &note)
}

/// Plots the share of the line's capacity, if that is known.
fn serial(device: Device, seconds: &[Point], line: Option<&Line>) -> Markup {
    let title = format!("Serial line, sent by the {}", device.name());
    let most = seconds.iter().map(|(_, bytes)| *bytes).fold(0.0, f64::max);
    let Some(line) = line.filter(|line| line.baud > 0) else {
        let note = "Of which line, or at how many baud, the record does not say.";
        return plot(&title, "bytes/s", seconds, note);
    };
    let Line { baud, bits_per_byte, .. } = line;
    let share = 100.0 * f64::from(*bits_per_byte) / f64::from(*baud);
    let can = baud / (*bits_per_byte).max(1);
    let note = format!("At most {most:.0} bytes/s, of {can} at {baud} baud.");
    plot(&title, "share of bit time in %", &scaled(seconds, share), &note)
}

fn plot(title: &str, unit: &str, points: &[Point], note: &str) -> Markup {
    let (unit_of_time, unit_s) = match points.len() {
        0..=SHORT_MAX => ("s", 1.0),
        _ => ("h", 3_600.0),
    };
    let line: Vec<Point> =
        extremes(points, COLUMNS).into_iter().map(|(at, load)| (at / unit_s, load)).collect();
    let frame = Frame::wide(
        Axis::around(
            format!("bench time in {unit_of_time}"),
            points.iter().map(|point| point.0 / unit_s),
        ),
        Axis::around(unit, points.iter().map(|point| point.1).chain([0.0])),
    );
    let drawn = line.len();
    let plot = frame.plot(&format!("load of {title}"), |chart| {
        chart.draw_series([PathElement::new(line, CCW.stroke_width(SCALE))])?;
        Ok(())
    });
    html! {
        figure {
            h3 { (title) }
            (plot)
            figcaption {
                p {
                    (note) " "
                    (counted(points.len(), "second", drawn, "the quietest and the busiest of each column"))
                    ". " (Table::thinned("time_s", unit, points).link(&format!("load-{title}")))
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::BusLoad;
    use record::header::{Bus, Header, Line};
    use record::samples::record;
    use record::{Device, RecordKind};
    use wire::can::{CanFrame, StandardId};

    #[test]
    fn what_crosses_is_counted_in_its_second() {
        let frame = CanFrame::new(StandardId::new(0x2aa).unwrap(), &[0x55; 8]).unwrap();
        let mut load = BusLoad::default();
        let mut header = Header::default();
        assert!(load.plots(&header).into_string().contains("--record full"));
        for at_s in [0.5, 2.1, 2.9] {
            load.add(&header, &record(at_s, Device::Base, RecordKind::Frame(frame)));
            load.add(&header, &record(at_s, Device::Gyro, RecordKind::Bytes(vec![0; 8])));
        }
        load.add(&header, &record(1e9, Device::Gyro, RecordKind::Bytes(vec![0; 8])));
        assert_eq!(load.busy_ns[&0], [222_000, 0, 444_000]);
        assert_eq!(load.bytes[&Device::Gyro], [8, 0, 16]);
        assert_eq!(load.overflowed, 1);
        let text = load.plots(&header).into_string();
        assert_eq!(text.matches("<svg").count(), 2);
        assert!(text.contains("bytes/s") && text.contains("500 kbit/s"), "{text}");
        header.lines = vec![Line { device: Device::Gyro, baud: 9_600, bits_per_byte: 10 }];
        let (line, bit_rate) = ("can0".to_owned(), 250_000);
        header.buses = vec![Bus { line, bit_rate, data_bit_rate: Some(2_000_000) }];
        let text = load.plots(&header).into_string();
        assert!(text.contains("CAN bus can0") && text.contains("Of 250 kbit/s and 2000"), "{text}");
        assert!(text.contains("At most 16 bytes/s, of 960 at 9600 baud."), "{text}");
    }

    #[test]
    fn part_of_a_second_at_the_end_is_no_quiet_second() {
        let mut load = BusLoad::default();
        let header = Header::default();
        let mut say = |at_s| {
            load.add(&header, &record(at_s, Device::Gyro, RecordKind::Bytes(vec![0; 8])));
            load.points(&load.bytes[&Device::Gyro])
        };
        assert_eq!(say(0.5), [(0.0, 16.0)], "the mean of a run that is shorter");
        assert_eq!(say(1.1), [(0.0, 8.0)]);
        assert_eq!(say(2.1), [(0.0, 8.0), (1.0, 8.0)]);
    }
}
