//! `hil export`: a recorded run as a data package, a bus log, tables, an MCAP file or an MDF file.

use super::completions;
use super::export_device::{self, Fmi};
use super::export_whole::{Whole, table_format};
use super::failure::Failure;
use super::measured::{plain_name, tell};
use super::own::ours_or_empty;
use super::progress::Screen;
use super::say;
use crate::choices::one_of;
use bus_log::convert::convert;
use bus_log::recorded::Recorded;
use bus_log::{Entry, Format as LogFormat, LogWriter, Payload};
use clap::Args;
use clap::builder::TypedValueParser;
use dataset::export::export;
use dataset::export::sensor::{Signals, of_run};
use dataset::{DESCRIPTOR, WriteOptions, write};
use exchange::tables::Format;
use harness::run::load_recorded;
use identification::dataset::{Dataset, Kind};
use plan::QuantityName;
use record::figures;
use record::outcome::Outcome;
use record::run_folder::RunFolder;
use std::path::{Path, PathBuf};

/// What one row is.
fn rows() -> impl TypedValueParser<Value = Kind> {
    one_of([
        ("turns", "One turn of the rotary table", Kind::Turns),
        (
            "series",
            "One mean of the gyro's rate, between two states of the controller",
            Kind::Series,
        ),
        ("laps", "One lap of a closed path", Kind::Laps),
        (
            "odometry",
            "One state of the base on the path of a lap, with the measured pose at its ends",
            Kind::Odometry,
        ),
        (
            "sensor",
            "One value of a sensor of your own, a signal of a node, beside its reference",
            Kind::Sensor,
        ),
    ])
}

/// Options of exports of a run, which an export of a device does not take.
const OF_A_RUN: [&str; 8] = ["out", "kind", "gzip", "bus", "tables", "mcap", "mf4", "plan"];

/// Writes a recorded run for other tools: as a data package (datapackage.json and a CSV table), or with --tables, --mcap,
/// --mf4 or --bus as tables for notebooks, as a file for Foxglove, as measured channels, or as a bus log.
///
/// A data package holds what an experimenter at the same bench would have noted, and nothing that only an emulator knows.
/// `hil identify` reads it like any other data. Tables and MCAP hold the whole record; with --record full, that includes
/// every byte and frame. MDF holds each quantity and signal as a channel. With --fmu it writes a device instead of a run, as a
/// functional mock-up unit for other simulators.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct ExportArguments {
    /// A run folder; with --fmu, the description of a device.
    #[arg(value_name = "RUN")]
    run: PathBuf,
    /// The folder of the package. [default: data/PLAN-seedN-KIND]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// What one row is. [default: turns where there are any, then laps, then series]
    #[arg(long, value_parser = rows())]
    kind: Option<Kind>,
    /// With --kind sensor: what the sensor says, as NODE.SIGNAL. The run must have been recorded with --record full.
    #[arg(long, value_name = "SIGNAL", value_parser = quantity, requires_all = ["reference", "kind"])]
    measured: Option<QuantityName>,
    /// With --kind sensor: what is true, in the same unit.
    #[arg(long, value_name = "SIGNAL", value_parser = quantity, requires = "measured")]
    reference: Option<QuantityName>,
    /// With --kind sensor: what may be a cause beside, such as its temperature. May be given several times.
    #[arg(long, value_name = "SIGNAL", value_parser = quantity, requires = "measured")]
    beside: Vec<QuantityName>,
    /// Compress the table.
    #[arg(long)]
    gzip: bool,
    /// A bus log to write instead: FILE.log (candump), FILE.asc or FILE.blf (Vector), FILE.trc (PEAK), FILE.mf4
    /// (MDF 4) or FILE.pcapng (Wireshark, with the serial lines). The run must have been recorded with --record full.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["out", "kind", "gzip"])]
    bus: Option<PathBuf>,
    /// A folder for the run's tables instead: states, observations, events, measurements and more.
    #[arg(long, value_name = "DIR", conflicts_with_all = ["out", "kind", "gzip", "bus"])]
    tables: Option<PathBuf>,
    /// File format of the tables.
    #[arg(long, value_parser = table_format(), default_value = "parquet", requires = "tables",
          conflicts_with_all = ["bus", "mcap", "mf4", "fmu"])]
    format: Format,
    /// An MCAP file to write instead, for Foxglove: FILE.mcap.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["out", "kind", "gzip", "bus", "tables"])]
    mcap: Option<PathBuf>,
    /// An MDF 4 file with the run's quantities and signals as measured channels instead, for asammdf and other
    /// measurement tools: FILE.mf4. Raw frames are in --bus FILE.mf4.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["out", "kind", "gzip", "bus", "tables", "mcap"])]
    mf4: Option<PathBuf>,
    /// With --tables, --mcap or --mf4: the plan whose rig is used to decode messages. [default: the one that the record holds]
    #[arg(long, value_name = "PLAN", conflicts_with_all = ["out", "kind", "gzip", "bus"], add = completions::plan())]
    plan: Option<String>,
    /// A functional mock-up unit to write instead, of the device in the file RUN: FILE.fmu.
    #[arg(long, value_name = "FILE", conflicts_with_all = OF_A_RUN)]
    fmu: Option<PathBuf>,
    /// Version of FMI.
    #[arg(long, value_enum, default_value_t, requires = "fmu", conflicts_with_all = OF_A_RUN)]
    fmi: Fmi,
    /// The library in the FMU. [default: libfmu_device.so where hil is installed]
    #[arg(long, value_name = "FILE", requires = "fmu", conflicts_with_all = OF_A_RUN)]
    library: Option<PathBuf>,
}

const EXAMPLES: &str = "\
Examples:
  hil export runs/laps-corrected-seed1 --tables tables
  hil export runs/laps-corrected-seed1 --tables tables --format csv
  hil export runs/laps-corrected-seed1 --mcap laps.mcap
  hil export runs/settles-seed1 --mcap settles.mcap
  hil export runs/laps-corrected-seed1 --mf4 laps.mf4
  hil export runs/laps-corrected-seed1 --bus laps.pcapng
  hil export runs/laps-corrected-seed1 --kind odometry
  hil export runs/turns-seed1 --kind sensor --measured resolver.Angle --reference encoder.Angle
  hil export devices/oven.toml --fmu oven.fmu
";

/// Part of the title of every package made from a run.
const OF_THE_RUN: &str = " of the run ";

/// Whether the data package in this folder was made from a run.
fn is_export(folder: &Path) -> bool {
    let text = std::fs::read(folder.join(DESCRIPTOR)).ok();
    let package = text.and_then(|text| serde_json::from_slice::<serde_json::Value>(&text).ok());
    let title = package.as_ref().and_then(|package| package["title"].as_str());
    title.is_some_and(|title| title.contains(OF_THE_RUN))
}

fn bus(folder: &RunFolder, path: &Path, screen: &Screen) -> Result<Outcome, Failure> {
    let format = super::log_format::format_of(path, None, "--bus")?;
    let records = folder.records()?;
    let entries = Recorded::new(records.header().clone(), records);
    let mut entries =
        entries.map(|entry| entry.map_err(|source| Failure::from(folder.unreadable(source))));
    // No log is written where it would hold nothing.
    let is_left_out =
        |entry: &Entry| format != LogFormat::Pcapng && matches!(entry.payload, Payload::Serial(_));
    let mut packets = 0;
    let first = loop {
        match entries.next() {
            Some(Ok(entry)) if is_left_out(&entry) => packets += 1,
            Some(first) => break first,
            None => return Err(nothing_for(format, folder.path(), packets)),
        }
    };
    let writer = LogWriter::create(path, format)?;
    let converted = convert(std::iter::once(first).chain(entries), writer);
    let mut converted = converted.inspect_err(|_| {
        screen.note(&format!("{} holds what could be read", path.display()));
    })?;
    converted.packets_left_out += packets;
    super::log::tell(path, converted, screen)
}

/// A log of this format would hold nothing of the run, which has that many packets on serial lines.
fn nothing_for(format: LogFormat, run: &Path, packets: u64) -> Failure {
    let run = run.display();
    if packets == 0 {
        return Failure::arguments(
            format!("{run} holds neither frames nor bytes"),
            "record a run with them: hil run PLAN --record full",
        );
    }
    Failure::arguments(
        format!(
            "{run} holds bytes of serial lines and no frames, and .{} holds frames alone",
            format.extension()
        ),
        "write them to a file of Wireshark: --bus FILE.pcapng",
    )
}

impl ExportArguments {
    pub(super) fn execute(&self, screen: &Screen) -> Result<Outcome, Failure> {
        if let Some(out) = &self.fmu {
            return export_device::fmu(&self.run, out, self.fmi, self.library.as_deref());
        }
        let (_, folder) = screen.opened(&self.run)?;
        if let Some(path) = &self.bus {
            return bus(&folder, path, screen);
        }
        let plan = self.plan.as_deref();
        let whole = (self.tables.as_deref().map(|out| Whole::Tables(out, self.format)))
            .or(self.mcap.as_deref().map(Whole::Mcap))
            .or(self.mf4.as_deref().map(Whole::Mf4));
        if let Some(whole) = whole {
            return whole.write(&folder, plan, screen);
        }
        if plan.is_some() {
            return Err(Failure::arguments(
                "--plan is for the messages of a device, which a data package does not hold",
                "say what to write: --tables DIR, --mcap FILE.mcap or --mf4 FILE.mf4",
            ));
        }
        let dataset = match self.kind {
            Some(Kind::Sensor) => self.sensor(&folder)?,
            kind => export(&folder, kind)?,
        };
        tell(&dataset, screen);
        let name = || format!("{}-{}", plain_name(&dataset.name), dataset.kind.name());
        let out = self.out.clone().unwrap_or_else(|| PathBuf::from("data").join(name()));
        let title = format!("{}{OF_THE_RUN}{}", dataset.kind.name(), dataset.name);
        ours_or_empty(&out, is_export(&out))?;
        let options = WriteOptions {
            compressed: self.gzip,
            title: Some(title),
            notes: (!dataset.notices.is_empty()).then(|| dataset.notices.join("; ")),
        };
        write(&dataset, &out, &options).map_err(|error| Failure::file(&out, error))?;
        say(&format!(
            "{}: {}, {}\n",
            out.display(),
            figures::counted(dataset.rows() as u64, "row", "rows"),
            figures::counted(dataset.run_labels.len() as u64, "run", "runs")
        ))?;
        Ok(Outcome::Passed)
    }

    fn sensor(&self, folder: &RunFolder) -> Result<Dataset, Failure> {
        let (Some(measured), Some(reference)) = (&self.measured, &self.reference) else {
            return Err(Failure::arguments(
                "which signal is measured, and which is its reference?",
                "--measured resolver.Angle --reference encoder.Angle",
            ));
        };
        let records = folder.records()?;
        let Some((_, rig)) = load_recorded(records.header(), None)? else {
            let message = format!("the record of {} holds no plan", self.run.display());
            return Err(Failure::arguments(message, "run the plan again with this version"));
        };
        let (measured, reference) = (measured.clone(), reference.clone());
        let signals = Signals { measured, reference, beside: self.beside.clone() };
        Ok(of_run(folder, &rig, &signals)?)
    }
}

fn quantity(name: &str) -> Result<QuantityName, String> {
    QuantityName::new(name).ok_or_else(|| "expected NODE.SIGNAL".to_owned())
}
