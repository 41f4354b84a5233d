//! Runs a plan of a device of the user's own in real time.

use super::{LiveRun, LiveRunError, LiveSetting};
use crate::made::Made;
use crate::operator::{Operator, Person};
use crate::record::Progress;
use crate::record::sink::RecordSink;
use crate::run::{Completed, Options, Prepared, finish, keep, summarise};
use crate::run_folder::RunFolder;
use crate::watch::{Feed, Watched};
use crate::world::live::{
    DescribedLive, DeviceSetting, LATE_MAX_DEFAULT, LiveError, PlacementError, Player, Scheduling,
    player, usual_port,
};
use described::{Description, Medium};
use std::sync::Arc;

impl LiveSetting<'_> {
    /// Where a device of this medium is.
    ///
    /// # Errors
    ///
    /// When the bench file gives it a port of another medium.
    pub fn device(&self, medium: Medium) -> Result<DeviceSetting, PlacementError> {
        let timing = &self.bench.timing;
        let player = player("device", &self.bench.role("device"), &usual_port(medium, &self.can))?;
        let (wanted, fits) = match medium {
            Medium::Can => ("CAN frames", player.spec().carries_frames()),
            Medium::Serial(_) => ("serial bytes", !player.spec().carries_frames()),
        };
        if !fits {
            let port = player.spec().to_string();
            return Err(PlacementError::DeviceMedium { port, wanted });
        }
        Ok(DeviceSetting {
            player,
            late_max: timing.late_max.unwrap_or(LATE_MAX_DEFAULT),
            scheduling: if timing.realtime { Scheduling::RealTime } else { self.scheduling },
        })
    }
}

/// Runs the plan, judges it and writes its run folder.
///
/// # Errors
///
/// As [`run_live_to_folder`](super::run_live_to_folder).
pub(super) fn run_to_folder(
    prepared: &Prepared,
    device: &Arc<Description>,
    options: &Options<'_>,
    setting: &LiveSetting<'_>,
    person: Option<Box<dyn Person>>,
    feed: Option<&Feed>,
    pulse: &mut impl FnMut(Progress) -> bool,
) -> Result<Completed, LiveRunError> {
    let setting = setting.device(device.layout().medium())?;
    setting.reaches(&prepared.plan)?;
    let folder = RunFolder::create(options.out)?;
    let header = prepared.header(options.seed);
    let mut sink = Watched::new(folder.record_sink(&header, options.level)?, feed);
    let operator = Operator::live(options.answers.clone(), person);
    let LiveRun { run, timing, ports } =
        carry_out(prepared, device, &setting, options.seed, operator, &mut sink, pulse)?;
    drop(sink);
    let mut summary = summarise(prepared, options.seed, &run);
    "real".clone_into(&mut summary.clock);
    summary.bus = setting.player.spec().kind().to_owned();
    summary.timing = Some(timing);
    summary.ports = ports;
    if let Player::Real(spec) = &setting.player {
        summary.device_under_test = format!("{} at {spec}", device.name);
    }
    summary.wall_s = summary.simulated_s;
    Ok(keep(&folder, &header, summary, run))
}

fn carry_out(
    prepared: &Prepared,
    device: &Arc<Description>,
    setting: &DeviceSetting,
    seed: u64,
    operator: Operator,
    sink: &mut impl RecordSink,
    pulse: &mut impl FnMut(Progress) -> bool,
) -> Result<LiveRun, LiveError> {
    let plan = Arc::clone(&prepared.plan);
    let mut world = DescribedLive::new(plan, device, operator, setting.clone(), seed);
    let mut end = world.run(sink, pulse)?;
    finish(sink, &mut end.ending);
    Ok(LiveRun::of(end, world.engine(), Made::default()))
}
