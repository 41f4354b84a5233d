//! Tables in MDF files: the same rows as in CSV, channels of several groups, and defects of files.

use super::{FieldText, Package, SERIES, descriptor};
use bus_log::mdf4::channels::{Form, Kind, Value, Writer};
use identification::dataset::Role;
use miette::Diagnostic;
use std::io::Cursor;
use std::path::Path;

fn form(name: &str, kind: Kind, unit: &str) -> Form {
    let (name, unit) = (name.to_owned(), unit.to_owned());
    Form { name, kind, unit, doc: String::new(), names: Vec::new() }
}

/// Groups by name: channels after the time `t`, and records after their time.
type Groups<'a> = &'a [(&'a str, &'a [(&'a str, Kind, &'a str)], &'a [(f64, &'a [Value<'a>])])];

fn file(groups: Groups<'_>) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    let mut writer = Writer::new(Path::new("data.mf4"), &mut file).unwrap();
    for (name, channels, records) in groups {
        let time = form("t", Kind::Float, "s");
        let others = channels.iter().map(|(name, kind, unit)| form(name, *kind, unit));
        let group = writer.group(name, "", std::iter::once(time).chain(others).collect());
        for (time, values) in *records {
            let record = [&[Value::Float(*time)], *values].concat();
            writer.record(group, &record).unwrap();
        }
    }
    writer.finish(&[]).unwrap();
    file.into_inner()
}

fn package(fields: &[FieldText<'_>], bytes: &[u8]) -> Package {
    let package = Package::new("series", fields, "");
    package.put("datapackage.json", descriptor("series", fields, &["data.mf4"]).as_bytes());
    package.put("data.mf4", bytes);
    package
}

const RATES: &[(&str, Kind, &str)] = &[("w", Kind::Float, "deg/s"), ("ref", Kind::Float, "deg/s")];

fn rates() -> Vec<u8> {
    let records: &[(f64, &[Value<'_>])] = &[
        (0.0, &[Value::Float(0.1), Value::Float(0.0)]),
        (1.0, &[Value::Float(0.2), Value::Missing]),
        (2.0, &[Value::Float(0.3), Value::Float(0.5)]),
    ];
    file(&[("imu", RATES, records)])
}

#[test]
fn channels_are_columns() {
    let csv = Package::new("series", SERIES, "t,w,ref\n0,0.1,0\n1,0.2,\n2,0.3,0.5\n");
    let (mut found, mut expected) =
        (package(SERIES, &rates()).read().unwrap(), csv.read().unwrap());
    for set in [&mut found, &mut expected] {
        // Missing values are NaN, which is not equal to itself.
        let reference = set.columns.iter_mut().find(|one| one.name == "ref").unwrap();
        assert!(reference.values[1].is_nan());
        reference.values[1] = -1.0;
    }
    assert_eq!(found, expected);
}

#[test]
fn an_empty_file_is_called_so() {
    let error = package(SERIES, b"").read().unwrap_err().to_string();
    assert!(error.ends_with("data.mf4: the file is empty"), "{error}");
}

#[test]
fn runs_and_causes_may_be_texts_or_numbers() {
    let fields =
        [SERIES, &[("run", "run", "1", ""), ("how", "auxiliary", "1", r#", "type": "string""#)]];
    let fields = fields.concat();
    let kinds = [RATES, &[("run", Kind::Integer, ""), ("how", Kind::Choice, "")]].concat();
    let row = |rate, run, how| {
        [Value::Float(rate), Value::Float(0.0), Value::Integer(run), Value::Text(how)]
    };
    let rows = [row(0.1, 7, "warm"), row(0.2, 7, "cold"), row(0.3, 8, "warm"), row(0.4, 8, "cold")];
    let records: Vec<(f64, &[Value<'_>])> =
        (0..).map(f64::from).zip(rows.iter().map(|row| &row[..])).collect();
    let set = package(&fields, &file(&[("imu", &kinds, &records)])).read().unwrap();
    assert_eq!(set.run_labels, ["7", "8"]);
    assert_eq!(set.named("how").unwrap().values, [0.0, 1.0, 0.0, 1.0]);
}

/// A gyro at 100 Hz, a reference at 10 Hz, shifted by a third of a step, and another gyro.
fn of_two_rasters() -> Vec<u8> {
    let gyro: Vec<[Value<'_>; 1]> = (0..100).map(|n| [Value::Float(f64::from(n))]).collect();
    let gyro: Vec<(f64, &[Value<'_>])> =
        (0..).map(|n| f64::from(n) / 100.0).zip(gyro.iter().map(|one| &one[..])).collect();
    let reference: Vec<[Value<'_>; 1]> = (0..10).map(|n| [Value::Float(-f64::from(n))]).collect();
    let reference: Vec<(f64, &[Value<'_>])> = (0..)
        .map(|n| f64::from(n) / 10.0 + 0.004)
        .zip(reference.iter().map(|one| &one[..]))
        .collect();
    let one = [("w", Kind::Float, "deg/s")];
    file(&[
        ("table", &[("ref", Kind::Float, "rad/s")], &reference),
        ("imu", &one, &gyro),
        ("spare", &one, &gyro[..50]),
    ])
}

#[test]
fn a_reference_with_times_of_its_own_is_at_the_nearest_rows() {
    let package = package(SERIES, &of_two_rasters());
    let error = package.read().unwrap_err();
    assert!(
        error.to_string().ends_with("field w: 2 channels have this name, expected one"),
        "{error}"
    );
    let help = error.help().unwrap().to_string();
    assert!(help.contains(r#""dialect": { "group": NAME }"#), "{help}");
    let text = descriptor("series", SERIES, &["data.mf4"]);
    let of = |group: &str| {
        let dialect = format!(r#""path": "data.mf4", "dialect": {{"group": "{group}"}}"#);
        package.put("datapackage.json", text.replace(r#""path": "data.mf4""#, &dialect).as_bytes());
        package.read()
    };
    let set = of("imu").unwrap();
    assert_eq!(set.rows(), 100);
    let reference = &set.column(Role::ReferenceRate).unwrap().values;
    for (row, value) in reference.iter().enumerate() {
        let expected = (row % 10 == 0).then_some(-(row as f64) / 10.0);
        assert_eq!((!value.is_nan()).then_some(*value), expected, "row {row}");
    }
    let told = set.notices.join("\n");
    assert!(told.contains("ref has times of its own: 10 of 10 values are at the rows"), "{told}");
    assert!(told.contains("ref is in rad/s by its file, taken as deg/s"), "{told}");
    assert_eq!(of("spare").unwrap().rows(), 50);
    let error = of("gyro").unwrap_err();
    assert!(error.to_string().contains("0 groups have the name \"gyro\""), "{error}");
    assert_eq!(error.help().unwrap().to_string(), "groups: table, imu, spare");
}

#[test]
fn what_is_wrong_with_a_file_has_its_place() {
    let message = |fields: &[FieldText<'_>], bytes: &[u8]| {
        let error = package(fields, bytes).read().expect_err("a mistake");
        error.to_string().rsplit_once("data.mf4").unwrap().1.to_owned()
    };
    let other = [SERIES, &[("volts", "auxiliary", "V", "")]].concat();
    let no_channel = ", field volts: the file has no channel of this name, expected one for every field that is used";
    assert_eq!(message(&other, &rates()), no_channel);
    let error = package(&other, &rates()).read().unwrap_err();
    let help = error.help().unwrap().to_string();
    assert!(help.starts_with("channels: "), "{help}");
    assert!(
        message(SERIES, b"t,w,ref\n").contains("block at byte 0: expected `MDF` and its version")
    );
    let mut cut = rates();
    cut.truncate(600);
    assert!(message(SERIES, &cut).contains(": block at byte "));
    let text = file(&[(
        "imu",
        &[("w", Kind::Text, ""), ("ref", Kind::Float, "")],
        &[(0.0, &[Value::Text("fast"), Value::Float(0.0)])],
    )]);
    let found = message(SERIES, &text);
    assert!(found.contains("expected a channel of numbers, found `texts`"), "{found}");
    let backwards = file(&[(
        "imu",
        RATES,
        &[
            (1.0, &[Value::Float(0.1), Value::Float(0.0)]),
            (0.5, &[Value::Float(0.1), Value::Float(0.0)]),
        ],
    )]);
    let found = message(SERIES, &backwards);
    assert!(found.starts_with(", row 2, field t: time runs backwards in run \"data\""), "{found}");
}
