//! Runs plans in the live world, judges them and writes their run folders.

use crate::bench_file::{BenchFile, ControllerSection};
use crate::made::Made;
use crate::outcome::{Outcome, Summary};
use crate::plan::DEVICE;
use crate::plan::Rig;
use crate::plan::rig::{RigLine, RigNode, UnderTest};
use crate::port::PortSpec;
use crate::properties::Property;
use crate::record::header::Header;
use crate::record::{Bench, Device, Record, RecordKind};
use crate::run::{Completed, Ended, Options, Prepared, finish, keep, summarise};
use crate::run_folder::{RunFolder, RunFolderError};
use crate::watch::{Feed, Watched};
use chrono::{DateTime, SecondsFormat};
use described::{Layout, Medium};
use live::unix_time::unix_s;
use live::world::{
    ATTACH_MAX_DEFAULT, BenchWork, DeviceUnderTest, LATE_MAX_DEFAULT, LineSite, LiveEnd, LiveError,
    LiveWorld, Placement, PlacementError, Player, Program, Scheduling, Setting, Site, Unfit,
    line_port, player, usual_port,
};
use rig::bench::base_transport;
use rig::engine::{Action, Ending};
use rig::operator::{Operator, Person};
use rig::{Pulse, Sink};
use std::path::Path;
use wire::time::Timestamp;

pub use crate::program::DEVICE_LOG;

/// Why a live run did not begin.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum LiveRunError {
    /// The run folder cannot be written.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Folder(#[from] RunFolderError),
    /// The bench does not come up. The run folder has this summary.
    #[error("the bench did not come up")]
    #[diagnostic(forward(source))]
    Live {
        /// Why.
        source: Box<LiveError>,
        /// A run that ended with this error before anything was measured.
        summary: Box<Summary>,
    },
    /// The bench does not fit the plan.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Placement(#[from] PlacementError),
    /// What the plan asks for cannot be done there.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Unfit(#[from] Unfit),
}

/// Settings of a live run beyond plan and options.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LiveSetting {
    /// The device under test, unless the bench file names one.
    pub device_under_test: DeviceUnderTest,
    /// The roles of real ports, and the places of emulated devices.
    pub bench: BenchFile,
    /// Port of an emulated base on CAN for which the bench file gives none.
    pub can: PortSpec,
    /// Requested scheduling; the bench file may request more.
    pub scheduling: Scheduling,
    /// The number of the run where it is repeated, from 1.
    pub repetition: Option<u32>,
}

impl LiveSetting {
    /// Combines the settings for a plan on `rig`: the bench file takes precedence.
    ///
    /// # Errors
    ///
    /// When the bench does not fit the plan.
    pub fn resolve(&self, rig: &Rig) -> Result<Setting, PlacementError> {
        self.bench.expect_of(rig)?;
        let timing = &self.bench.timing;
        let (site, device_under_test) = match (&rig.robot, rig.device()) {
            (Some(devices), _) => {
                let placement = Placement::new(&self.bench, base_transport(devices), &self.can)?;
                let device_under_test = match &self.bench.controller {
                    Some(ControllerSection::Command(command)) => {
                        DeviceUnderTest::Command(command.clone())
                    }
                    Some(ControllerSection::InProcess) => DeviceUnderTest::InProcess,
                    Some(ControllerSection::Attach(place)) => {
                        DeviceUnderTest::Attached(place.clone())
                    }
                    None => self.device_under_test.clone(),
                };
                if !rig.is_short {
                    placement.beside_nodes()?;
                }
                (Site::Robot(placement, self.lines(rig)?), device_under_test)
            }
            (None, Some(device)) => {
                let player = self.device(device.layout())?;
                let name = match &player {
                    Player::Real(spec) => format!("{} at {spec}", device.name),
                    Player::Emulated(_) => format!("{}, emulated", device.name),
                };
                (Site::Device(player), DeviceUnderTest::Device(name))
            }
            (None, None) => (Site::Lines(self.lines(rig)?), nodes(rig)),
        };
        Ok(Setting {
            device_under_test,
            programs: programs(rig),
            work: BenchWork::of(&self.bench),
            site,
            attach_max: timing.attach_max.unwrap_or(ATTACH_MAX_DEFAULT),
            late_max: timing.late_max.unwrap_or(LATE_MAX_DEFAULT),
            scheduling: if timing.realtime { Scheduling::RealTime } else { self.scheduling },
        })
    }

    /// Ports of the lines with a node outside this process.
    fn lines(&self, rig: &Rig) -> Result<Vec<LineSite>, PlacementError> {
        let mut sites = Vec::new();
        for (place, line) in rig.lines.iter().enumerate() {
            let named = self.bench.lines.get(line.name.as_str());
            if !rig.is_away(place) && named.is_none() {
                continue;
            }
            let spec = match named {
                Some(section) => line_port(&line.name, &section.port)?,
                None => usual_port(line.medium, &self.can),
            };
            carried(&spec, line)?;
            let mut beyond = Vec::new();
            let away: Vec<&str> = rig.away_at(place).collect();
            if away.len() > 1 && matches!(spec, PortSpec::Can { .. } | PortSpec::Slcan { .. }) {
                beyond.push(line.name.clone());
                beyond.extend(away.into_iter().map(str::to_owned));
            }
            sites.push(LineSite { line: place, spec, beyond });
        }
        Ok(sites)
    }

    /// Place of a device with this layout.
    fn device(&self, layout: &Layout) -> Result<Player, PlacementError> {
        let line = RigLine::of_device(layout);
        let usual = usual_port(line.medium, &self.can);
        let player = player(DEVICE, &self.bench.role(DEVICE), &usual)?;
        carried(player.spec(), &line)?;
        Ok(player)
    }
}

/// Checks that a port carries what is on a line. Whether an interface of the kernel is set up for CAN FD shows only when
/// it is opened.
///
/// # Errors
///
/// When it carries something else, or no CAN FD where the line has it.
pub fn carried(spec: &PortSpec, line: &RigLine) -> Result<(), PlacementError> {
    let (wanted, fits) = match line.medium {
        Medium::Can => ("CAN frames", spec.carries_frames()),
        Medium::Serial(_) => ("serial bytes", !spec.carries_frames()),
    };
    if !fits {
        return Err(PlacementError::DeviceMedium { port: spec.to_string(), wanted });
    }
    let is_fd = line.medium == Medium::Can && line.data_bit_rate.is_some();
    match spec {
        PortSpec::Slcan { .. } | PortSpec::SlcanPty { .. } if is_fd => {
            Err(PlacementError::NoFd { port: spec.to_string() })
        }
        _ => Ok(()),
    }
}

/// Device under test of a rig of nodes alone.
fn nodes(rig: &Rig) -> DeviceUnderTest {
    match rig.under_test().next() {
        Some(_) => DeviceUnderTest::Nodes,
        None => DeviceUnderTest::Device(format!("{}, emulated", rig.described_names().join(", "))),
    }
}

/// The nodes under test, and their command lines.
fn programs(rig: &Rig) -> Vec<Program> {
    let program = |(node, how): (&RigNode, &UnderTest)| Program {
        node: node.name.clone(),
        words: match how {
            UnderTest::Command(words) => words.clone(),
            UnderTest::InProcess(_) | UnderTest::Attached(_) => Vec::new(),
        },
    };
    rig.under_test().map(program).collect()
}

/// Request for one run in real time.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LiveOrder<'a> {
    pub(crate) prepared: &'a Prepared,
    pub(crate) seed: u64,
    pub(crate) setting: &'a Setting,
    /// Properties judged during the run.
    pub(crate) properties: &'a [Property],
    /// File for the stderr of the device under test.
    pub(crate) log: &'a Path,
}

/// Carries out a run; judges only the properties.
///
/// # Errors
///
/// When the bench does not come up.
pub(crate) fn carry_out(
    order: LiveOrder<'_>,
    operator: Operator,
    sink: Sink<'_>,
    pulse: Pulse<'_>,
) -> Result<LiveEnd, LiveError> {
    let LiveOrder { prepared, seed, setting, properties, log } = order;
    let seed = prepared.plan.seed_of_run(seed);
    let (rig, director) = prepared.live(seed, setting, operator);
    let mut world = LiveWorld::new(rig, director, setting.clone(), seed)
        .with_monitor(properties, &prepared.rig.speakers);
    let mut made = Made::default();
    let mut keep_made = |action: &Action| action.keep_in(&mut made);
    let mut end = match world.run(log, sink, &mut keep_made, pulse) {
        Ok(end) => end,
        Err(error) => {
            let why = RecordKind::Note(said(&error));
            sink.record(Record { at: Timestamp::ZERO, device: Device::Plan, kind: why });
            sink.finish();
            return Err(error);
        }
    };
    end.run.made = made;
    finish(sink, &mut end.run.ending);
    Ok(end)
}

/// The error with its causes, in one line.
fn said(error: &LiveError) -> String {
    let first: &dyn std::error::Error = error;
    let all = std::iter::successors(Some(first), |error| error.source());
    all.map(ToString::to_string).collect::<Vec<_>>().join(": ")
}

/// This machine, now, and what the bench file says.
fn here(file: &BenchFile, repetition: Option<u32>) -> Bench {
    let host = std::fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
    let started = DateTime::from_timestamp(unix_s().unwrap_or_default(), 0).unwrap_or_default();
    Bench {
        started: started.to_rfc3339_opts(SecondsFormat::Secs, true),
        host: host.trim().to_owned(),
        file: file.origin.clone(),
        title: file.title.clone(),
        real: file.real_nodes(),
        repetition,
        about: file.about.clone(),
    }
}

/// A run of a bench that did not come up.
fn not_begun(error: &LiveError) -> Ended {
    let outcome = match error {
        LiveError::Stopped => Outcome::Aborted,
        _ => Outcome::Error,
    };
    Ended::at_once(Ending { outcome, reason: Some(said(error)), lost: false })
}

/// Runs a prepared plan in real time, judges it and writes its run folder. `person` answers what `options` does not;
/// `feed` is shown the run.
///
/// # Errors
///
/// When the bench cannot be used or does not come up, or the run folder cannot be made. A run that has begun ends with
/// an outcome, not with an error.
pub fn run_live_to_folder_watched(
    prepared: &Prepared,
    options: &Options<'_>,
    setting: &LiveSetting,
    person: Option<Box<dyn Person>>,
    feed: Option<&Feed>,
    pulse: Pulse<'_>,
) -> Result<Completed, LiveRunError> {
    let (bench, repetition) = (&setting.bench, setting.repetition);
    let setting = setting.resolve(&prepared.rig)?;
    setting.fits(&prepared.plan)?;
    let folder = RunFolder::create(options.out)?;
    let bench = here(bench, repetition);
    let header = Header { bench: Some(bench.clone()), ..prepared.header(options.seed) };
    let mut sink = Watched::new(folder.record_sink(&header, options.level)?, feed);
    let operator = Operator::live(options.answers.clone(), person);
    let log = folder.file(DEVICE_LOG);
    let (seed, properties) = (options.seed, &prepared.plan.properties);
    let order = LiveOrder { prepared, seed, setting: &setting, properties, log: &log };
    let live = carry_out(order, operator, &mut sink, pulse);
    drop(sink);
    let summarised = |run: &Ended| {
        let mut summary = summarise(prepared, options.seed, run);
        "real".clone_into(&mut summary.clock);
        summary.bench = Some(bench.clone());
        summary.bus = setting.site.bus();
        summary.device_under_test = setting.under_test();
        if folder.file(DEVICE_LOG).is_file() {
            summary.artifacts.push(DEVICE_LOG.to_owned());
        }
        summary
    };
    let live = match live {
        Ok(live) => live,
        Err(error) => {
            let summary = summarised(&not_begun(&error));
            let kept = keep(&folder, &header, summary, not_begun(&error));
            let (source, summary) = (Box::new(error), Box::new(kept.summary));
            return Err(LiveRunError::Live { source, summary });
        }
    };
    let mut summary = summarised(&live.run);
    summary.timing = Some(live.timing);
    summary.ports = live.ports;
    summary.wall_s = summary.simulated_s;
    summary.artifacts.extend(live.artifacts);
    Ok(keep(&folder, &header, summary, live.run))
}
