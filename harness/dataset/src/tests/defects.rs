//! Each mistake has one message with the file, the row, the field and the expectation.

use super::{FieldText, Package, SERIES, SERIES_CSV, descriptor, gzip};
use miette::{Diagnostic, GraphicalReportHandler, GraphicalTheme};
use std::path::Path;

const TURNS: &[FieldText<'static>] = &[
    ("t", "time", "s", ""),
    ("run", "run", "1", ""),
    ("way", "direction", "1", ""),
    ("gyro", "gyro_angle", "deg", ""),
    ("table", "reference_angle", "deg", ""),
];

/// `SERIES` with one field replaced.
fn with(place: usize, field: FieldText<'static>) -> Vec<FieldText<'static>> {
    let mut fields = SERIES.to_vec();
    fields[place] = field;
    fields
}

fn and(field: FieldText<'static>) -> Vec<FieldText<'static>> {
    [SERIES, &[field]].concat()
}

/// The message without the name of the folder.
fn message(package: &Package) -> String {
    let error = package.read().expect_err("a mistake");
    let folder = format!("{}/", package.path().display());
    assert!(error.to_string().starts_with(&folder), "{error}");
    let mut text = error.to_string().replace(&folder, "");
    if let Some(help) = error.help() {
        text += &format!("\n    help: {help}");
    }
    text
}

fn series(csv: &str) -> Package {
    Package::new("series", SERIES, csv)
}

fn fields(fields: &[FieldText<'_>]) -> Package {
    let names: Vec<_> = fields.iter().map(|field| field.0).collect();
    Package::new("series", fields, &format!("{}\n", names.join(",")))
}

fn written(descriptor: &str) -> Package {
    let package = series(SERIES_CSV);
    package.put("datapackage.json", descriptor.as_bytes());
    package
}

fn located(path: &str) -> Package {
    written(&descriptor("series", SERIES, &[path]))
}

fn packed(bytes: &[u8]) -> Package {
    let package = located("data.csv.gz");
    package.put("data.csv.gz", bytes);
    package
}

fn cases() -> Vec<(&'static str, Package)> {
    let rows = |rows: &str| series(&format!("t,w,ref\n{rows}"));
    let turns = |rows: &str| Package::new("turns", TURNS, &format!("t,run,way,gyro,table\n{rows}"));
    let whole = gzip(SERIES_CSV.as_bytes());
    let mut damaged = whole.clone();
    damaged[14] ^= 0xff;
    let mut no_descriptor = series(SERIES_CSV);
    std::fs::remove_file(no_descriptor.path().join("datapackage.json")).unwrap();
    let mut no_table = series(SERIES_CSV);
    std::fs::remove_file(no_table.path().join("data.csv")).unwrap();
    let two = |second: &str, csv: &str| {
        let mut text = descriptor("series", SERIES, &["data.csv"]);
        text = text.replace("}}]}\n", &format!("}}}}, {second}]}}\n"));
        let package = written(&text);
        package.put("more.csv", csv.as_bytes());
        package
    };
    let other = r#"{"path": "more.csv", "schema": {"fields": [{"name": "t", "role": "time", "unit": "s"}]}}"#;
    let plain = descriptor("series", SERIES, &["data.csv"]);
    let _ = (&mut no_descriptor, &mut no_table);
    vec![
        ("no descriptor", no_descriptor),
        ("no such table", no_table),
        ("bad JSON", written("{\"name\": \"set\",\n \"hil\": }\n")),
        ("no text", {
            let package = series(SERIES_CSV);
            package.put("datapackage.json", b"{\"name\": \"\xff\"}");
            package
        }),
        ("no hil", written(&plain.replace("\"hil\"", "\"hill\""))),
        ("no kind", written(&plain.replace("\"kind\"", "\"sort\""))),
        ("unknown kind", written(&plain.replace("\"series\"", "\"spins\""))),
        ("unknown drive", written(&plain.replace("\"series\"", "\"series\", \"drive\": \"tank\""))),
        ("unknown role", fields(&with(1, ("w", "gyro", "deg/s", "")))),
        ("unknown unit", fields(&with(1, ("w", "gyro_rate", "dps", "")))),
        ("unknown axis", fields(&with(1, ("w", "gyro_rate", "deg/s", r#", "axis": "up""#)))),
        ("unit of another dimension", fields(&and(("T", "temperature", "m", "")))),
        ("a temperature where none is", fields(&with(1, ("w", "gyro_rate", "K", "")))),
        ("no unit", written(&plain.replace(r#", "unit": "s""#, ""))),
        ("no role", written(&plain.replace(r#""role": "time", "#, ""))),
        (
            "text for a number role",
            fields(&and(("T", "temperature", "Cel", r#", "type": "string""#))),
        ),
        (
            "unknown unit of a constant",
            written(&plain.replace(
                "\"series\"",
                r#""series", "constants": {"base": {"value": 1, "unit": "ft"}}"#,
            )),
        ),
        (
            "a size of nothing",
            written(&plain.replace(
                "\"series\"",
                r#""series", "constants": {"wheelbase": {"value": 0, "unit": "m"}}"#,
            )),
        ),
        ("no tables", written(r#"{"hil": {"kind": "series"}, "resources": []}"#)),
        (
            "no schema",
            written(r#"{"hil": {"kind": "series"}, "resources": [{"path": "data.csv"}]}"#),
        ),
        ("no path", written(&plain.replace("\"path\"", "\"file\""))),
        ("role twice without an axis", fields(&and(("w2", "gyro_rate", "deg/s", "")))),
        (
            "role twice on one axis",
            fields(&[
                SERIES[0],
                SERIES[2],
                ("wx", "gyro_rate", "deg/s", r#", "axis": "x""#),
                ("wx2", "gyro_rate", "deg/s", r#", "axis": "x""#),
            ]),
        ),
        ("time twice", fields(&and(("t2", "time", "s", "")))),
        ("name twice", fields(&and(("w", "temperature", "Cel", "")))),
        ("no gyro", fields(&[SERIES[0], SERIES[2]])),
        ("no reference", fields(&[SERIES[0], SERIES[1]])),
        (
            "one wheel",
            written(&descriptor(
                "odometry",
                &[SERIES[0], ("run", "run", "1", ""), ("l", "wheel_left", "count", "")],
                &["data.csv"],
            )),
        ),
        ("no direction", written(&descriptor("laps", &[("run", "run", "1", "")], &["data.csv"]))),
        ("a path that leaves", located("../data.csv")),
        ("a path that leaves by a detour", located("a/../../data.csv")),
        ("an absolute path", located("/etc/passwd")),
        ("a remote path", located("https://example.org/data.csv")),
        ("several paths", written(&plain.replace("\"data.csv\"", r#"["data.csv", "b.csv"]"#))),
        (
            "another encoding",
            written(&plain.replace("\"data.csv\"", r#""data.csv", "encoding": "utf-16""#)),
        ),
        (
            "no header",
            written(&plain.replace("\"data.csv\"", r#""data.csv", "dialect": {"header": false}"#)),
        ),
        ("other fields", two(other, "t\n1\n")),
        ("empty", series("")),
        ("header alone", series("t,w,ref\n")),
        ("field not in the header", series("t,w\n0,1\n")),
        ("field not in the schema", series("t,w,ref,extra\n0,1,2,3\n")),
        ("another delimiter", series("t;w;ref\n0;0,1;0\n")),
        ("tabs", series("t\tw\tref\n0\t1\t0\n")),
        (
            "a point where a comma is said",
            written(
                &plain.replace("\"data.csv\"", r#""data.csv", "dialect": {"decimalChar": ","}"#),
            ),
        ),
        (
            "another decimal sign",
            written(
                &plain.replace("\"data.csv\"", r#""data.csv", "dialect": {"decimalChar": "'"}"#),
            ),
        ),
        ("line ends of Windows", series("t,w,ref\r\n0,1,0\r\n1,\"a\r\nb\",0\r\n")),
        ("name twice in the header", series("t,w,w\n0,1,2\n")),
        ("short row", rows("0,1,0\n1,2\n")),
        ("long row", rows("0,1,0\n1,2,0,9\n")),
        ("text", rows("0,1,0\n\n1,fast,0\n")),
        ("not a number", rows("0,1,0\n1,nan,0\n")),
        ("a time stamp", rows("2024-05-01T12:00:00,1,0\n")),
        ("infinite", rows("0,1,0\n1,-inf,0\n")),
        ("too large", rows("0,1,0\n1,1e999,0\n")),
        ("decimal comma", rows("0,\"1,5\",0\n")),
        ("time backwards", rows("0,1,0\n2,1,0\n1,1,0\n")),
        ("time stands still", rows("0,1,0\n2,1,0\n2,1.5,0\n2,2,0\n")),
        ("time backwards among turns", turns("5,a,1,360,360\n5,a,-1,-360,-360\n4,a,1,360,360\n")),
        ("neither way", turns("5,a,1,360,360\n6,a,0,-360,-360\n")),
        ("no gyro at all", rows("0,,0\n1,,0\n")),
        ("no reference at all", rows("0,1,\n1,1,\n")),
        ("one row", rows("0,1,0\n")),
        ("bytes", {
            let package = series("");
            package.put("data.csv", b"t,w,ref\n0,1,0\n1,\xff,0\n");
            package
        }),
        ("gzip cut short", packed(&whole[..whole.len() - 6])),
        ("gzip cut in its header", packed(&whole[..5])),
        ("gzip damaged", packed(&damaged)),
        ("no gzip", packed(SERIES_CSV.as_bytes())),
    ]
}

#[test]
fn each_mistake_has_its_message() {
    let said: Vec<_> =
        cases().iter().map(|(name, package)| format!("{name}\n    {}", message(package))).collect();
    insta::assert_snapshot!(said.join("\n"));
}

#[test]
fn the_place_in_the_descriptor_is_shown() {
    let package = fields(&with(1, ("w", "gyro_rate", "dps", "")));
    let error = package.read().expect_err("an unknown unit");
    let mut text = String::new();
    let handler = GraphicalReportHandler::new_themed(GraphicalTheme::none()).with_width(100);
    handler.render_report(&mut text, &error).unwrap();
    assert!(text.contains("\"unit\": \"dps\"") && text.contains("^^|^^"), "{text}");
    assert!(text.contains("known: s, deg, rad"), "{text}");
}

#[test]
fn a_folder_that_is_not_there_is_named() {
    let error = crate::read(Path::new("no/such/folder")).expect_err("it is not there");
    assert!(error.to_string().starts_with("no/such/folder: failed to read"), "{error}");
}

#[test]
fn nothing_panics_on_any_bytes() {
    use proptest::prelude::*;
    let package = series(SERIES_CSV);
    proptest!(ProptestConfig::with_cases(256), |(bytes in prop::collection::vec(any::<u8>(), 0..200),
                                                 at in 0_usize..200, cut in 0_usize..200)| {
        package.put("data.csv", &bytes);
        let _ = package.read();
        let mut packed = gzip(SERIES_CSV.as_bytes());
        let place = at % packed.len();
        packed[place] ^= bytes.first().copied().unwrap_or(1);
        packed.truncate(cut.max(1));
        package.put("data.csv", &packed);
        let _ = package.read();
        package.put("data.csv", SERIES_CSV.as_bytes());
        let good = descriptor("series", SERIES, &["data.csv"]);
        let mut text = good.clone().into_bytes();
        text.splice(at..(at + bytes.len() / 20).min(good.len()), bytes.iter().take(8).copied());
        package.put("datapackage.json", &text);
        let _ = package.read();
        package.put("datapackage.json", good.as_bytes());
    });
}

/// Quoted or not, an endless row is rejected long before the memory is full.
#[test]
fn a_row_without_end_is_refused() {
    let names: Vec<_> = SERIES.iter().map(|field| field.0).collect();
    for quote in ["", "\""] {
        let csv = format!("{}\n{quote}{}", names.join(","), "1".repeat(4 << 20));
        let message = message(&series(&csv));
        assert!(message.contains("it holds more than 1048576 bytes in a row"), "{message}");
    }
}

/// As a spreadsheet on Windows saves it.
#[test]
fn a_header_in_latin_1_has_its_line() {
    let package = series("");
    package.put("data.csv", b"t,w,ref,Temperatur \xb0C\n0,0.1,0,20\n");
    let text = message(&package);
    assert!(text.starts_with("data.csv, line 1: found bytes that are no UTF-8"), "{text}");
    assert!(text.contains("save it as UTF-8"), "{text}");
}
