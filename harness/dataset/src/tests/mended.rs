//! Corrected data, and the notices about them.

use super::{FieldText, Package, SERIES, SERIES_CSV, descriptor, gzip};
use identification::dataset::{Dataset, Role};

fn with(more: &[FieldText<'static>], csv: &str) -> Dataset {
    let fields = [SERIES, more].concat();
    Package::new("series", &fields, csv).read().unwrap_or_else(|error| panic!("{error}"))
}

fn values(set: &Dataset, role: Role) -> &[f64] {
    &set.column(role).expect("the role").values
}

#[track_caller]
fn says(set: &Dataset, notice: &str) {
    assert!(set.notices.iter().any(|said| said == notice), "{:?}", set.notices);
}

const RUN: FieldText<'static> = ("run", "run", "1", "");

#[test]
fn a_plain_table_is_read_as_it_stands() {
    let set = with(&[], SERIES_CSV);
    assert_eq!(values(&set, Role::GyroRate), [0.1, 0.2, 0.3]);
    assert_eq!((set.run_of_row.as_slice(), set.run_labels.len()), (&[0, 0, 0][..], 1));
    assert!(set.notices.is_empty(), "{:?}", set.notices);
}

#[test]
fn marks_line_ends_quotes_and_blanks_do_not_matter() {
    let csv = "\u{feff}\"t\", w ,ref\r\n0,\"0.1\",0\r\n1, 0.2 ,0\r\n\r\n2,+3e-1,0";
    assert_eq!(with(&[], csv).columns, with(&[], SERIES_CSV).columns);
}

/// Found by a user: the last reference of a file that was cut short was read as 67 instead of 670.
#[test]
fn a_last_line_without_its_end_may_be_cut_short() {
    let set = with(&[], SERIES_CSV.trim_end());
    let why = "has no line break: if the file was cut short, that row may be wrong";
    says(&set, &format!("the last line of data.csv {why}"));
}

#[test]
fn columns_are_found_by_name() {
    let set = with(&[], "ref,t,w\n0,0,0.1\n0,1,0.2\n0,2,0.3\n");
    assert_eq!(set.columns, with(&[], SERIES_CSV).columns);
}

#[test]
fn gzip_of_several_members_is_read_whole() {
    let package = Package::new("series", SERIES, "");
    let (one, two) = SERIES_CSV.split_at(SERIES_CSV.len() / 2);
    package.put("data.csv", &[gzip(one.as_bytes()), gzip(two.as_bytes())].concat());
    assert_eq!(package.read().unwrap().columns, with(&[], SERIES_CSV).columns);
}

#[test]
fn a_dialect_and_words_for_nothing_are_kept_to() {
    let package = Package::new("series", SERIES, "t;w;ref\n0;0.1;0\n1;0.2;NA\n");
    let text = descriptor("series", SERIES, &["data.csv"])
        .replace("\"data.csv\"", r#""data.csv", "dialect": {"delimiter": ";"}"#)
        .replace("{\"fields\"", r#"{"missingValues": ["", "NA"], "fields""#);
    package.put("datapackage.json", text.as_bytes());
    let set = package.read().unwrap();
    assert!(values(&set, Role::ReferenceRate)[1].is_nan());
    says(&set, "ref: 1 of 2 cells are missing");
}

/// As laboratories in half of Europe save it.
#[test]
fn decimal_commas_are_read_where_the_package_says_so() {
    let package = Package::new("series", SERIES, "t;w;ref\r\n0;0,1;0\r\n1;+3e-1;-1,25\r\n");
    let text = descriptor("series", SERIES, &["data.csv"]);
    let of_table = text.replace(
        "\"data.csv\"",
        r#""data.csv", "dialect": {"delimiter": ";", "decimalChar": ","}"#,
    );
    let of_fields = text
        .replace("\"data.csv\"", r#""data.csv", "dialect": {"delimiter": ";"}"#)
        .replace(r#""unit": "deg/s""#, r#""unit": "deg/s", "decimalChar": ",""#);
    for text in [of_table, of_fields] {
        package.put("datapackage.json", text.as_bytes());
        let set = package.read().unwrap();
        assert_eq!(values(&set, Role::GyroRate), [0.1, 0.3]);
        assert_eq!(values(&set, Role::ReferenceRate), [0.0, -1.25]);
    }
}

#[test]
fn missing_cells_of_a_cause_stay_missing() {
    let set = with(&[("T", "temperature", "Cel", "")], "t,w,ref,T\n0,1,0,20\n1,1.5,0,\n2,1,0,21\n");
    let temperature = values(&set, Role::Temperature);
    assert!(temperature[1].is_nan() && temperature[2] == 21.0);
    says(&set, "T: 1 of 3 cells are missing");
}

#[test]
fn a_temperature_on_another_scale_is_converted_and_told() {
    let read = |unit, cells: [f64; 3]| {
        let [a, b, c] = cells;
        let csv = format!("t,w,ref,T\n0,1,0,{a}\n1,1.5,0,{b}\n2,1,0,{c}\n");
        let set = with(&[("T", "temperature", unit, "")], &csv);
        let values = values(&set, Role::Temperature).to_vec();
        (values, set.notices)
    };
    let here = [20.0, 21.0, 25.0];
    let kelvin = here.map(|celsius| celsius + 273.15);
    for (unit, cells, said) in [
        ("K", kelvin, Some("T is converted from K to Cel")),
        ("degF", [68.0, 69.8, 77.0], Some("T is converted from degF to Cel")),
        (
            "Cel",
            kelvin,
            Some("T is stated in Cel, but its values can only be in K: converted to Cel"),
        ),
        ("K", here, Some("T is stated in K, but its values can only be in Cel")),
        ("Cel", here, None),
    ] {
        let (values, notices) = read(unit, cells);
        assert!(values.iter().zip(here).all(|(a, b)| (a - b).abs() < 1e-9), "{unit} {values:?}");
        assert_eq!(notices, said.into_iter().collect::<Vec<_>>(), "{unit}");
    }
    // An oven is no surroundings.
    let oven =
        with(&[("T", "auxiliary", "Cel", "")], "t,w,ref,T\n0,1,0,250\n1,1.5,0,251\n2,1,0,260\n");
    assert_eq!(values(&oven, Role::Auxiliary), [250.0, 251.0, 260.0]);
}

#[test]
fn rows_without_what_the_kind_needs_are_left_out() {
    let set = with(&[], "t,w,ref\n0,1,0\n1,,0\n,1,0\n3,2,\n");
    assert_eq!(values(&set, Role::Time), [0.0, 3.0]);
    assert!(values(&set, Role::ReferenceRate)[1].is_nan(), "a reference may be missing");
    says(&set, "1 row is left out: gyro_rate is missing");
    says(&set, "1 row is left out: time is missing");
}

#[test]
fn one_axis_is_enough() {
    let fields = [
        SERIES[0],
        SERIES[2],
        ("wx", "gyro_rate", "deg/s", r#", "axis": "x""#),
        ("wy", "gyro_rate", "deg/s", r#", "axis": "y""#),
    ];
    let csv = "t,ref,wx,wy\n0,0,1,2\n1,0,,2.5\n2,0,,\n3,0,1.5,2\n";
    let set = Package::new("series", &fields, csv).read().unwrap();
    assert_eq!(values(&set, Role::Time), [0.0, 1.0, 3.0]);
}

#[test]
fn what_a_row_left_out_has_counted_is_not_lost() {
    let fields = [
        ("t", "time", "s", ""),
        RUN,
        ("l", "wheel_left", "count", ""),
        ("r", "wheel_right", "count", ""),
        ("x", "reference_x", "m", ""),
        ("y", "reference_y", "m", ""),
        ("h", "reference_heading", "deg", ""),
    ];
    let csv = "t,run,l,r,x,y,h\n0,a,1,1,0,0,0\n,a,2,3,,,\n,a,4,5,,,\n3,a,6,7,0,0,0\n4,a,,9,,,\n5,a,1,1,,,\n\
               ,a,7,7,,,\n0,b,1,2,0,0,0\n1,b,1,1,,,\n";
    let set = Package::new("odometry", &fields, csv).read().unwrap();
    assert_eq!(values(&set, Role::WheelLeft), [1.0, 12.0, 1.0, 1.0, 1.0]);
    assert_eq!(values(&set, Role::WheelRight), [1.0, 15.0, 1.0, 2.0, 1.0]);
    says(&set, "increments of rows left out were added to 1 rows after them");
    says(&set, "1 row is left out: wheel_left is missing");
}

#[test]
fn rows_of_a_run_are_brought_together() {
    let set = with(&[RUN], "t,w,ref,run\n0,1,0,b\n0,2,0,a\n1,3,0,b\n1,4,0,a\n7,5,0,\n");
    assert_eq!(set.run_labels, ["b", "a"]);
    assert_eq!(set.run_of_row, [0, 0, 1, 1]);
    assert_eq!(values(&set, Role::GyroRate), [1.0, 3.0, 2.0, 4.0]);
    says(&set, "rows of one run did not lie together and were brought together");
    says(&set, "1 row is left out: of no run");
}

#[test]
fn a_mistake_in_rows_that_were_moved_is_shown_where_it_stands() {
    let fields = [SERIES, &[RUN]].concat();
    let csv = "t,w,ref,run\n5,1,0,b\n0,2,0,a\n4,3,0,b\n1,4,0,a\n";
    let error = Package::new("series", &fields, csv).read().unwrap_err();
    assert!(error.to_string().contains(", row 3 (line 4), field t: "), "{error}");
}

#[test]
fn a_run_of_one_sample_is_left_out_and_one_of_one_turn_is_not() {
    let set = with(&[RUN], "t,w,ref,run\n0,1,0,a\n1,2,0,a\n2,3,0,b\n0,4,0,c\n1,5,0,c\n");
    assert_eq!(set.run_labels, ["a", "c"]);
    assert_eq!(set.run_of_row, [0, 0, 1, 1]);
    says(&set, "run b is left out: it has one row");
    let fields = [RUN, ("way", "direction", "1", ""), ("gyro", "gyro_angle", "deg", "")];
    let laps = Package::new("laps", &fields, "run,way,gyro\n1,1,360\n2,-1,-361\n").read().unwrap();
    assert_eq!(laps.run_labels, ["1", "2"]);
}

#[test]
fn channels_that_say_nothing_are_kept_and_told() {
    let more = [("V", "auxiliary", "V", ""), ("A", "auxiliary", "A", "")];
    let set = with(&more, "t,w,ref,V,A\n0,1,0,5,\n1,2,0,5,\n");
    assert_eq!(set.columns_of(Role::Auxiliary).count(), 2);
    says(&set, "V is constant: no candidate cause");
    says(&set, "A is empty: no candidate cause");
    assert_eq!(set.notices.len(), 2, "a constant reference is a gyro at rest");
}

#[test]
fn a_gyro_that_never_changes_is_told() {
    says(&with(&[], "t,w,ref\n0,1,0\n1,1,0\n"), "w is constant");
}

#[test]
fn words_are_numbered_and_what_is_ignored_is_dropped() {
    let more = [
        ("floor", "auxiliary", "1", r#", "type": "string""#),
        ("note", "ignore", "1", r#", "type": "string""#),
    ];
    let csv = "t,w,ref,floor,note\n0,1,0,tiles,x\n1,2,0,\"a \"\"rug\"\"\",\n2,3,0,tiles,nan\n";
    let set = with(&more, csv);
    assert_eq!(set.named("floor").unwrap().values, [0.0, 1.0, 0.0]);
    assert!(set.named("note").is_none());
    says(&set, "floor is text: its 2 words are numbered from 0");
    says(&set, "not used, as their role is ignore: note");
}

#[test]
fn tables_with_the_same_fields_are_one_set() {
    let package = Package::new("series", SERIES, SERIES_CSV);
    package.put("more.csv", b"w,t,ref\n5,0,0\n6,1,0\n");
    let text = descriptor("series", SERIES, &["data.csv", "more.csv"]);
    package.put("datapackage.json", text.as_bytes());
    package.put("readme.md", b"# The data");
    let set = package.read().unwrap();
    assert_eq!(set.run_labels, ["data", "more"], "each is a run of its own");
    assert_eq!(values(&set, Role::GyroRate), [0.1, 0.2, 0.3, 5.0, 6.0]);
    let with_text = text.replace(
        "\"resources\": [",
        "\"resources\": [{\"name\": \"readme\", \"path\": \"readme.md\"},",
    );
    package.put("datapackage.json", with_text.as_bytes());
    let set = package.read().unwrap();
    assert_eq!(set.rows(), 5);
    says(&set, "readme is no table and was passed over");
}

/// Thirty rows; `change` changes them.
fn long(change: impl Fn(&mut Vec<String>)) -> Package {
    of_rows(30, change)
}

fn of_rows(count: usize, change: impl Fn(&mut Vec<String>)) -> Package {
    let mut lines: Vec<String> = (0..count).map(|row| format!("{row},{}.5,0", row % 7)).collect();
    change(&mut lines);
    Package::new("series", SERIES, &format!("t,w,ref\n{}\n", lines.join("\n")))
}

#[test]
fn a_row_that_is_repeated_counts_once() {
    let right = long(|_| ()).read().unwrap();
    let twice =
        long(|lines| *lines = lines.iter().flat_map(|line| [line.clone(), line.clone()]).collect());
    let set = twice.read().unwrap();
    assert_eq!(set.columns, right.columns);
    says(&set, "30 rows are left out: as the row before");
}

#[test]
fn a_row_at_the_time_of_the_one_before_is_left_out_and_a_coarse_clock_is_a_mistake() {
    let right = long(|_| ()).read().unwrap();
    let other = |places: &[usize]| {
        long(|lines| places.iter().for_each(|&at| lines.insert(at + 1, format!("{at},4.5,0"))))
    };
    let set = other(&[8]).read().unwrap();
    assert_eq!(set.columns, right.columns);
    says(&set, "1 rows say the time of the row before: their own is unknown");
    says(&set, "1 row is left out: time is missing");
    assert!(other(&[20, 8]).read().unwrap_err().to_string().contains("time stands still"));
}

/// One row in twenty of a short run is none.
#[test]
fn one_repeated_time_does_not_refuse_a_short_run() {
    let right = of_rows(12, |_| ()).read().unwrap();
    let other = |places: &[usize]| {
        of_rows(12, |lines| {
            places.iter().for_each(|&at| lines.insert(at + 1, format!("{at},4.5,0")))
        })
    };
    let set = other(&[8]).read().unwrap();
    assert_eq!(set.columns, right.columns);
    says(&set, "1 rows say the time of the row before: their own is unknown");
    assert!(other(&[8, 5]).read().unwrap_err().to_string().contains("time stands still"));
}

#[test]
fn what_wheels_count_in_a_row_without_a_time_of_its_own_is_not_lost() {
    let fields = [
        ("t", "time", "s", ""),
        ("run", "run", "1", ""),
        ("l", "wheel_left", "count", ""),
        ("r", "wheel_right", "count", ""),
        ("x", "reference_x", "m", ""),
        ("y", "reference_y", "m", ""),
        ("th", "reference_heading", "rad", ""),
    ];
    let mut lines: Vec<String> = (0..40).map(|row| format!("{row},1,3,4,0,0,0")).collect();
    lines.insert(12, "11,1,5,6,0,0,0".to_owned());
    let csv = format!("t,run,l,r,x,y,th\n{}\n", lines.join("\n"));
    let set = Package::new("odometry", &fields, &csv).read().unwrap();
    let sum = |role| values(&set, role).iter().sum::<f64>();
    assert_eq!((set.rows(), sum(Role::WheelLeft), sum(Role::WheelRight)), (40, 125.0, 166.0));
}

#[test]
fn a_late_row_is_put_in_its_place_and_a_clock_that_was_set_is_a_mistake() {
    let right = long(|_| ()).read().unwrap();
    let set = long(|lines| lines.swap(11, 12)).read().unwrap();
    assert_eq!(set.columns, right.columns);
    says(&set, "1 rows stood after later ones and were put in their place");
    let set_back = long(|lines| lines.push("3.5,1,0".to_owned()));
    assert!(set_back.read().unwrap_err().to_string().contains("time runs backwards"));
    let many = long(|lines| [2, 9, 17].iter().for_each(|&row| lines.swap(row, row + 1)));
    assert!(many.read().unwrap_err().to_string().contains("time runs backwards"));
}
