//! Written data can be read back unchanged.

use crate::{WriteOptions, read, write};
use identification::dataset::{Axis, Column, Constant, Dataset, Drive, Kind, Role, Unit};
use proptest::prelude::*;

/// A number or a missing cell.
fn cell() -> impl Strategy<Value = f64> {
    prop_oneof![4 => -1e6..1e6_f64, 1 => Just(f64::NAN), 1 => prop::num::f64::NORMAL]
}

fn datasets() -> impl Strategy<Value = Dataset> {
    let runs = prop::collection::vec(("[a-zé][a-z0-9, \"\n;-]{0,5}[a-z]", 2_usize..5), 1..5);
    let compass = prop::option::of(prop_oneof![Just(Axis::X), Just(Axis::Z)]);
    (runs, compass, any::<bool>(), any::<u64>())
        .prop_flat_map(|(runs, axis, synchro, _)| {
            let rows: usize = runs.iter().map(|(_, rows)| rows).sum();
            let column = || prop::collection::vec(cell(), rows);
            (Just((runs, axis, synchro)), column(), column(), column())
        })
        .prop_map(|((runs, axis, synchro), mut gyro, temperature, mut reference)| {
            // At least one value of each required role, and a gyro value in each row.
            gyro.iter_mut().filter(|value| value.is_nan()).for_each(|value| *value = 0.0);
            if reference.iter().all(|value| value.is_nan()) {
                reference[0] = 1.0;
            }
            let column = |name: &str, role, axis, unit, values: Vec<f64>| Column {
                name: name.to_owned(),
                role,
                axis,
                unit,
                values,
            };
            let time = runs.iter().flat_map(|(_, rows)| (0..*rows).map(|row| row as f64 / 3.0));
            let time = time.collect();
            let mut labels: Vec<String> = Vec::new();
            for (index, (label, _)) in runs.iter().enumerate() {
                labels.push(if labels.contains(label) {
                    format!("{label}{index}")
                } else {
                    label.clone()
                });
            }
            Dataset {
                name: "a set".to_owned(),
                kind: Kind::Series,
                drive: Some(if synchro { Drive::Synchro } else { Drive::Differential }),
                constants: [("base".to_owned(), Constant { value: 0.1, unit: Unit::Metre })].into(),
                columns: vec![
                    column("run", Role::Time, None, Unit::Second, time),
                    column("w, \"x\"", Role::GyroRate, axis, Unit::DegreePerHour, gyro),
                    column("T", Role::Temperature, None, Unit::Celsius, temperature),
                    column("ref", Role::ReferenceRate, None, Unit::RadianPerSecond, reference),
                ],
                run_of_row: runs
                    .iter()
                    .enumerate()
                    .flat_map(|(run, (_, rows))| std::iter::repeat_n(run, *rows))
                    .collect(),
                run_labels: labels,
                notices: Vec::new(),
            }
        })
}

/// Equality where missing cells equal one another.
fn same(one: &Dataset, other: &Dataset) -> bool {
    let bits = |set: &Dataset| -> Vec<Vec<Option<u64>>> {
        let of = |column: &Column| {
            column.values.iter().map(|value| (!value.is_nan()).then(|| value.to_bits())).collect()
        };
        set.columns.iter().map(of).collect()
    };
    let rest = |set: &Dataset| {
        let mut rest = Dataset { notices: Vec::new(), ..set.clone() };
        rest.columns.iter_mut().for_each(|column| column.values.clear());
        rest
    };
    bits(one) == bits(other) && rest(one) == rest(other)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn what_is_written_is_read(dataset in datasets(), compressed: bool) {
        let dir = tempfile::tempdir().unwrap();
        let folder = dir.path().join("set");
        // The second one replaces the first, its table included.
        for compressed in [!compressed, compressed] {
            let options = WriteOptions { compressed, ..WriteOptions::default() };
            write(&dataset, &folder, &options).unwrap();
        }
        let back = read(&folder).unwrap();
        prop_assert!(same(&dataset, &back), "{dataset:?}\n{back:?}");
        prop_assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 2);
    }
}
