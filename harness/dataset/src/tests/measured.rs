//! The measured sets in the repository.

use crate::read;
use identification::dataset::{Axis, Dataset, Drive, Kind, Role, Unit};
use std::path::Path;

fn shipped(name: &str) -> Dataset {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../test-data/measured").join(name);
    read(&folder).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn a_robot_on_square_paths() {
    let set = shipped("square-path-odometry");
    assert_eq!((set.kind, set.drive), (Kind::Odometry, Some(Drive::Differential)));
    assert_eq!(set.rows(), 22_224);
    assert_eq!(set.run_labels.first().map(String::as_str), Some("231220200029-01"));
    assert_eq!(set.run_labels.len(), 16);
    let wheelbase = set.constants["wheelbase"];
    assert_eq!((wheelbase.value, wheelbase.unit), (0.2, Unit::Metre));
    let left = set.column(Role::WheelLeft).unwrap();
    assert_eq!((left.name.as_str(), &left.values[..3]), ("ticks_left", &[0.0, 0.0, 5.0][..]));
    let recording = set.named("recording").unwrap();
    assert!(recording.values.is_sorted() && recording.values[0] == 0.0);
    assert!(set.notices.iter().any(|notice| notice.starts_with("recording is text")));
}

#[test]
fn a_gyro_at_rest() {
    let set = shipped("gyro-at-rest-over-temperature");
    assert_eq!((set.kind, set.rows(), set.run_labels.len()), (Kind::Series, 8_399, 1));
    let axes: Vec<_> = set.columns_of(Role::GyroRate).map(|column| column.axis).collect();
    assert_eq!(axes, [Some(Axis::X), Some(Axis::Y), Some(Axis::Z)]);
    assert_eq!(set.column(Role::Time).unwrap().unit, Unit::One);
    assert_eq!(set.column(Role::Temperature).unwrap().values[0], 52.106_128_7);
    assert!(set.notices.is_empty(), "{:?}", set.notices);
}
