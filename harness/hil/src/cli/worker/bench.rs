//! `hil worker --bench`: cases in real time, on the bench of this machine.

use crate::cli::failure::Failure;
use crate::cli::worker::bench_place;
use campaign::Repeatedly;
use campaign_nats::{Maker, Package, Place, Stopping};
use harness::executors::{Bench, OnBench, Site};
use harness::run_live::{DEVICE_LOG, LiveSetting};
use live::world::{DeviceUnderTest, Scheduling};
use plan::bench_file::BenchFile;
use ports::PortSpec;
use std::path::{Path, PathBuf};
use std::sync::Arc;

#[derive(Debug, Clone)]
pub(super) struct BenchHand {
    place: Place,
    setup: LiveSetting,
    text: String,
    bench: Bench,
    log: PathBuf,
}

impl BenchHand {
    /// Opens the bench of this file; the stderr of the device under test goes to the folder `out`.
    pub(super) fn new(name: &str, out: Option<&Path>) -> Result<Self, Failure> {
        let setup = LiveSetting {
            device_under_test: DeviceUnderTest::OurProcess,
            bench: BenchFile::load(name)?,
            can: PortSpec::SlcanPty { link: None },
            scheduling: Scheduling::Normal,
            repetition: None,
        };
        let text = BenchFile::text(name)?;
        let place = bench_place(name)?;
        let usual = || PathBuf::from("runs").join(format!("worker-{}", bench_name(&place)));
        let folder = out.map_or_else(usual, Path::to_owned);
        std::fs::create_dir_all(&folder).map_err(|source| Failure::file(&folder, source))?;
        Ok(Self { place, setup, text, bench: Bench::default(), log: folder.join(DEVICE_LOG) })
    }

    pub(super) const fn place(&self) -> &Place {
        &self.place
    }

    pub(super) fn maker(&self) -> Maker {
        let hand = self.clone();
        Arc::new(move |package: &Package, stopping: Stopping| {
            let (plan, executor) = hand.made(package, stopping)?;
            Ok((plan, Arc::new(executor)))
        })
    }

    /// Returns the error if the bench ever failed to come up.
    pub(super) fn came_up(&self) -> Result<(), Failure> {
        self.bench.take_broken().map_or(Ok(()), |error| Err(error.into()))
    }

    fn made(
        &self,
        package: &Package,
        stopping: Stopping,
    ) -> Result<(String, Repeatedly<OnBench>), String> {
        let repetition = package.repetition_on(bench_name(&self.place), &self.text);
        let repetition = repetition.map_err(|error| error.to_string())?;
        let (prepared, answers) = package.prepare().map_err(|error| error.to_string())?;
        let prepared = prepared.with_real(&self.setup.bench.real_nodes());
        let prepared = prepared.map_err(|error| error.to_string())?;
        let setting = self.setup.resolve(&prepared.rig).map_err(|error| error.to_string())?;
        setting.fits(&prepared.plan).map_err(|error| error.to_string())?;
        let site = Site {
            bench: self.bench.clone(),
            answers,
            // A person to be asked would sit at the coordinator.
            person: None,
            stop: Box::new(move || stopping.is_so()),
            log: self.log.clone(),
        };
        let plan = prepared.plan.name.to_string();
        Ok((plan, Repeatedly::new(OnBench::new(prepared, setting, site), repetition)))
    }
}

fn bench_name(place: &Place) -> &str {
    match place {
        Place::Virtual => "",
        Place::Bench(name) => name,
    }
}
