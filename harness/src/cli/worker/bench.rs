//! `hil worker --bench`: cases in real time, on the bench of this machine.

#[cfg(feature = "live")]
pub(super) use on_bench::BenchHand;
#[cfg(not(feature = "live"))]
pub(super) use without::BenchHand;

#[cfg(feature = "live")]
mod on_bench {
    use crate::bench_file::BenchFile;
    use crate::campaign::Repeatedly;
    use crate::cli::failure::Failure;
    use crate::cli::live;
    use crate::cli::setup::LiveSetup;
    use crate::cli::worker::bench_place;
    use crate::executors::{Bench, OnBench, Site};
    use crate::nats::{Maker, Package, Place, Stopping};
    use crate::run_live::DEVICE_LOG;
    use std::path::{Path, PathBuf};
    use std::sync::Arc;

    /// The bench of a worker.
    #[derive(Debug, Clone)]
    pub(in crate::cli::worker) struct BenchHand {
        place: Place,
        setup: LiveSetup,
        /// The text of its file.
        text: String,
        bench: Bench,
        log: PathBuf,
    }

    impl BenchHand {
        /// That of this bench file; what the device under test writes to stderr goes to the folder `out`.
        pub(in crate::cli::worker) fn new(name: &str, out: Option<&Path>) -> Result<Self, Failure> {
            let (setup, text) = (LiveSetup::of(BenchFile::load(name)?), BenchFile::text(name)?);
            let place = bench_place(name)?;
            let usual = || PathBuf::from("runs").join(format!("worker-{}", bench_name(&place)));
            let folder = out.map_or_else(usual, Path::to_owned);
            std::fs::create_dir_all(&folder).map_err(|source| Failure::file(&folder, source))?;
            Ok(Self { place, setup, text, bench: Bench::default(), log: folder.join(DEVICE_LOG) })
        }

        pub(in crate::cli::worker) const fn place(&self) -> &Place {
            &self.place
        }

        /// Who carries out the cases of a package on it.
        pub(in crate::cli::worker) fn maker(&self) -> Maker {
            let hand = self.clone();
            Arc::new(move |package: &Package, _: &Place, stopping: Stopping| {
                let (plan, executor) = hand.made(package, stopping)?;
                Ok((plan, Arc::new(executor)))
            })
        }

        /// Did it come up each time?
        pub(in crate::cli::worker) fn came_up(&self) -> Result<(), Failure> {
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
            let setting =
                live::setting(&prepared, &self.setup).map_err(|error| error.to_string())?;
            setting.reaches(&prepared.plan.faults).map_err(|error| error.to_string())?;
            let site = Site {
                bench: self.bench.clone(),
                answers,
                // Who is asked is beside the coordinator, if anybody is.
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
}

#[cfg(not(feature = "live"))]
mod without {
    use crate::cli::failure::Failure;
    use crate::nats::{Maker, Place};
    use std::convert::Infallible;
    use std::path::Path;

    /// This build has no live world, and so no bench.
    #[derive(Debug)]
    pub(in crate::cli::worker) struct BenchHand(Infallible);

    impl BenchHand {
        pub(in crate::cli::worker) fn new(_: &str, _: Option<&Path>) -> Result<Self, Failure> {
            Err(Failure::arguments(
                "this build has no live world, and carries no cases out on a bench",
                "build with the feature `live`, or leave out --bench",
            ))
        }

        pub(in crate::cli::worker) const fn place(&self) -> &Place {
            match self.0 {}
        }

        pub(in crate::cli::worker) fn maker(&self) -> Maker {
            match self.0 {}
        }

        pub(in crate::cli::worker) fn came_up(&self) -> Result<(), Failure> {
            match self.0 {}
        }
    }
}
