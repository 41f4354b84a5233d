//! Exports runs of the simulated bench as data sets.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use dataset::export::{ExportError, Recorded, export};
use dataset::{WriteOptions, read, write};
use harness::operator::Answers;
use harness::run::{self, Prepared, run_to_folder};
use identification::dataset::{Dataset, Drive, Kind, Role};
use identification::identify::{Options, identify};
use plan::made::Made;
use record::RecordKind;
use record::run_folder::RunFolder;
use record::sink::Level;
use std::collections::BTreeMap;
use std::path::Path;

fn run(plan: &str, out: &Path) -> RunFolder {
    let prepared = Prepared::load(plan, &Made::default()).unwrap();
    let options = run::Options { seed: 1, out, level: Level::Events, answers: Answers::default() };
    run_to_folder(&prepared, &options, &mut |_| true, &|| 0.0).unwrap();
    RunFolder::open(out).unwrap()
}

fn values(set: &Dataset, role: Role) -> &[f64] {
    &set.column(role).unwrap_or_else(|| panic!("no {role:?}")).values
}

#[test]
fn turns_of_a_temperature_calibration() {
    let dir = tempfile::tempdir().unwrap();
    let folder = run("temperature-calibration", &dir.path().join("run"));
    let set = export(&folder, None).unwrap();
    assert_eq!((set.kind, set.rows(), set.run_labels.len()), (Kind::Turns, 300, 150));
    assert_eq!(set.name, "temperature-calibration-seed1");
    assert_eq!(set.run_labels[..2], ["1", "2"]);
    assert!(values(&set, Role::Time).is_sorted());
    let turns = values(&set, Role::Direction).iter().zip(values(&set, Role::ReferenceAngle));
    for ((direction, reference), row) in turns.zip(0..) {
        assert_eq!(*direction, if row % 2 == 0 { -1.0 } else { 1.0 });
        assert_eq!(*reference, 360.0 * direction);
    }
    // E_T = -0.52 T + 19.23 (Eq. 5), with a scatter of some tenths of a degree.
    let columns =
        [Role::Direction, Role::GyroAngle, Role::Temperature].map(|role| values(&set, role));
    for row in 0..set.rows() {
        let [direction, gyro, temperature] = columns.map(|column| column[row]);
        let error = direction * gyro - 360.0;
        assert!(
            (error - (19.23 - 0.52 * temperature)).abs() < 1.0,
            "{row}: {error} at {temperature}"
        );
    }
    // 14 s by rate and ramps, plus telegrams and settling.
    assert!(values(&set, Role::Duration).iter().all(|duration| (14.0..15.0).contains(duration)));
    assert!(values(&set, Role::TableRate).iter().all(|rate| (rate.abs() - 30.0).abs() < 1e-9));
    assert!(values(&set, Role::Bias).iter().all(|bias| bias.abs() < 0.1));
    assert!(
        values(&set, Role::Heading).iter().all(|heading| *heading == 0.0 || *heading == -360.0)
    );

    let package = dir.path().join("package");
    write(&set, &package, &WriteOptions::default()).unwrap();
    let back = read(&package).unwrap();
    assert_eq!(Dataset { notices: Vec::new(), ..back }, Dataset { notices: Vec::new(), ..set });

    series_has_its_reference(&export(&folder, Some(Kind::Series)).unwrap());
    nothing_of_the_truth_is_in_it(&folder);
    let error = export(&folder, Some(Kind::Laps)).unwrap_err();
    assert!(matches!(error, ExportError::Nothing { what: "laps", .. }), "{error}");
    let error = export(&folder, Some(Kind::Odometry)).unwrap_err();
    assert!(error.to_string().contains("odometry: no lap was driven"), "{error}");
}

fn series_has_its_reference(set: &Dataset) {
    let rates = values(set, Role::GyroRate).iter().zip(values(set, Role::ReferenceRate));
    let mut known = BTreeMap::<i64, usize>::new();
    for (rate, reference) in rates.filter(|(_, reference)| !reference.is_nan()) {
        *known.entry(reference.round() as i64).or_default() += 1;
        // The scale error is at most 2 %: 1 deg in 360 is 0.3 %, 12 deg 3.3 %.
        let allowed = 0.1 + 0.05 * reference.abs();
        assert!((rate - reference).abs() < allowed, "{rate} deg/s where it is {reference}");
    }
    let rows = |rate| known.get(&rate).copied().unwrap_or_default();
    assert_eq!(known.len(), 3, "{known:?}");
    // One state per second: of 20 s at rest and 10 s of steady turning the ends are lost.
    assert!(rows(0) > 150 * 15 && rows(30) > 150 * 6 && rows(-30) > 150 * 6, "{known:?}");
}

/// A record without the truth gives the same data.
fn nothing_of_the_truth_is_in_it(folder: &RunFolder) {
    let records = || folder.records().unwrap().map(|record| record.unwrap());
    let told = records().filter(|record| !matches!(record.kind, RecordKind::Truth { .. }));
    let (all, told) = (Recorded::of(records().map(Ok)), Recorded::of(told.map(Ok)));
    let (all, told) = (all.unwrap(), told.unwrap());
    assert!(
        records().count()
            > records().filter(|r| !matches!(r.kind, RecordKind::Truth { .. })).count()
    );
    for kind in [Kind::Turns, Kind::Series] {
        let set = |recorded: &Recorded| {
            let set = recorded.dataset(kind, "run", Path::new("run")).unwrap().unwrap();
            // Missing cells are NaN, which is not equal to itself.
            format!("{set:?}")
        };
        assert_eq!(set(&all), set(&told));
    }
}

const LAPS: &str = r#"
name = "two-laps"
title = "Two laps each way round"
devices = "paper"
steps = [
    { heading_source = "odometry" },
    { repeat = { times = 2, steps = [
        { place = { x_m = 0, y_m = 0, heading_deg = 0 } },
        { bias_test = { duration_s = 20 } },
        { lap = { direction = "cw", side_m = 2, speed_m_per_s = 0.4, turn_rate_deg_per_s = 30 } },
        { place = { x_m = 0, y_m = 0, heading_deg = 0 } },
        { lap = { direction = "ccw", side_m = 2, speed_m_per_s = 0.4, turn_rate_deg_per_s = 30 } },
    ] } },
]

[[measurement]]
name = "faults"
doc = "Any"
quantity = "health.fault"
unit = "1"
check = { all_within = [0, 0] }
paper = "none"
"#;

#[test]
fn laps_that_the_plan_does_not_judge() {
    let dir = tempfile::tempdir().unwrap();
    let plan = dir.path().join("two-laps.toml");
    std::fs::write(&plan, LAPS).unwrap();
    let folder = run(plan.to_str().unwrap(), &dir.path().join("run"));
    let set = export(&folder, None).unwrap();
    assert_eq!((set.kind, set.rows(), set.run_labels.len()), (Kind::Laps, 4, 2));
    assert_eq!(values(&set, Role::Direction), [-1.0, 1.0, -1.0, 1.0]);
    let column = |role| values(&set, role).to_vec();
    for (gyro, reference) in column(Role::GyroAngle).iter().zip(column(Role::ReferenceAngle)) {
        assert!((gyro - reference).abs() < 20.0 && (reference.abs() - 360.0).abs() < 30.0);
    }
    // A robot that steers by its odometry believes it is back at the start, but it is not.
    for (odometry, reference) in
        column(Role::OdometryHeading).iter().zip(column(Role::ReferenceHeading))
    {
        assert!(
            odometry.abs() < 2.0 && (odometry - reference).abs() > 0.5,
            "{odometry} {reference}"
        );
    }
    for role in [Role::OdometryX, Role::OdometryY, Role::ReferenceX, Role::ReferenceY] {
        assert!(values(&set, role).iter().all(|position| position.abs() < 0.5), "{role:?}");
    }
    assert!(values(&set, Role::Duration).iter().all(|duration| (20.0..60.0).contains(duration)));

    let path = export(&folder, Some(Kind::Odometry)).unwrap();
    is_driven_as_the_laps_say(&path, &set);
    let package = dir.path().join("package");
    write(&path, &package, &WriteOptions::default()).unwrap();
    let back = read(&package).unwrap();
    assert_eq!((back.rows(), back.drive), (path.rows(), path.drive));
    let identified = identify(&back, None, &Options::default(), &mut |_, _| {}).unwrap();
    assert_eq!(identified.finding.held_out.quantity.as_deref(), Some("final_position"));
}

/// Dead reckoning over the rows of each lap ends where the base's own odometry ended, seen from its start.
fn is_driven_as_the_laps_say(path: &Dataset, laps: &Dataset) {
    assert_eq!(
        (path.kind, path.drive, path.run_labels.len()),
        (Kind::Odometry, Some(Drive::Synchro), 4)
    );
    for lap in 0..laps.rows() {
        let rows: Vec<usize> =
            (0..path.rows()).filter(|&row| path.run_of_row[row] == lap).collect();
        let value = |role, row: usize| values(path, role)[row];
        let (first, last) = (rows[0], rows[rows.len() - 1]);
        let (mut x, mut y) = (0.0, 0.0);
        for pair in rows.windows(2) {
            let step = value(Role::DriveDistance, pair[1]) - value(Role::DriveDistance, pair[0]);
            let heading = |row| value(Role::SteerAngle, row) - value(Role::SteerAngle, first);
            let middle = heading(pair[0]).midpoint(heading(pair[1])).to_radians();
            x += step * middle.cos();
            y += step * middle.sin();
            let reference = value(Role::ReferenceX, pair[1]);
            assert_eq!(reference.is_finite(), pair[1] == last, "only the ends are measured");
        }
        let said = |role| values(laps, role)[lap];
        // One state per second: driving and turning within a second are taken as an arc.
        assert!((x - said(Role::OdometryX)).abs() < 0.05, "{lap}: {x}");
        assert!((y - said(Role::OdometryY)).abs() < 0.05, "{lap}: {y}");
        for role in [Role::ReferenceX, Role::ReferenceY, Role::ReferenceHeading] {
            assert_eq!((value(role, first), value(role, last)), (0.0, said(role)));
        }
        let way = value(Role::DriveDistance, last) - value(Role::DriveDistance, first);
        assert!((way - 8.0).abs() < 0.1, "four sides of 2 m: {way}");
    }
}
