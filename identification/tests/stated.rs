//! What a package states wrongly and only one thing can be: thousandths for ones, edges of an encoder, exchanged axes,
//! what adds up, a reference that has ended, a field that stands still.

use crate::set_right::{change, effect, found, robot, shaken};
use identification::dataset::{Column, Constant, Dataset, Drive, Kind, Role, Unit};
use identification::finding::{Finding, Verdict};
use identification::identify::{Options, identify, predict};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

/// The robot of other tests with encoders.
fn counting() -> Dataset {
    let mut robot = robot(0.0, 0.0);
    let metres = std::f64::consts::PI * 0.15 / 2048.0;
    for column in &mut robot.columns {
        if matches!(column.role, Role::WheelLeft | Role::WheelRight) {
            column.unit = Unit::Count;
            column.values.iter_mut().for_each(|value| *value = (*value / metres).round());
        }
    }
    let diameter = Constant { value: 0.15, unit: Unit::Metre };
    robot.constants.insert("wheel_diameter".to_owned(), diameter);
    let ticks = Constant { value: 2048.0, unit: Unit::One };
    robot.constants.insert("encoder_ticks_per_revolution".to_owned(), ticks);
    robot
}

/// Asserts that the track is found as if nothing else were wrong, as many effects are named so, and the model applies.
fn assert_set_right(wrong: &Dataset, name: &str, count: usize) -> Finding {
    let identified = found(wrong);
    let finding = &identified.finding;
    let named = finding.effects.iter().filter(|effect| effect.name == name).count();
    assert_eq!((named, finding.effects.len()), (count, count + 1), "{name}: {:?}", finding.effects);
    let track = effect(finding, "effective_track").parameters[0].value;
    assert!((track + 0.05 / 1.05).abs() < 0.005, "{name}: {track}");
    let told = predict(wrong, &identified.model).unwrap().rmse.after;
    assert!(told < 0.05, "{name}: {told}");
    identified.finding
}

#[test]
fn millimetres_and_edges_of_encoders_are_told_by_name() {
    let thousand = |value: f64| 1e3 * value;
    let mut wrong = robot(0.0, 0.0);
    change(&mut wrong, "x", thousand);
    change(&mut wrong, "y", thousand);
    let finding = assert_set_right(&wrong, "wrong_unit", 2);
    assert!(
        finding.in_words().contains(&"x is 1000 times what it must be in its unit.".to_owned())
    );
    let mut wrong = counting();
    wrong.constants.get_mut("wheelbase").unwrap().value *= 1e3;
    wrong.constants.get_mut("wheel_diameter").unwrap().value *= 1e3;
    assert_set_right(&wrong, "wrong_unit", 2);
    for (times, stated) in [(4.0, 0.25), (0.25, 4.0)] {
        let mut wrong = counting();
        change(&mut wrong, "left", |count| count * times);
        change(&mut wrong, "right", |count| count * times);
        let finding = assert_set_right(&wrong, "encoder_decoding", 1);
        let told = effect(&finding, "encoder_decoding");
        assert_eq!(told.drivers, ["encoder_ticks_per_revolution"]);
        assert_eq!(told.parameters[0].value, stated);
    }
}

/// A car on a nearly straight road, whose turns are less than the noise of the reference's heading.
fn straight() -> Dataset {
    const ROWS: usize = 400;
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(11);
    let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
    let mut columns: [Vec<f64>; 6] = Default::default();
    for _ in 0..8 {
        let (mut x, mut y, mut heading) = (0.0, 0.0, 0.1 * draw());
        for row in 0..ROWS {
            let (speed, rate) =
                (20.0 + 3.0 * (row as f64 / 60.0).sin(), 0.01 * (row as f64 / 40.0).cos());
            if row > 0 {
                heading += 0.05 * rate;
                x += 0.05 * speed * f64::cos(heading);
                y += 0.05 * speed * f64::sin(heading);
            }
            let sides = [speed - 0.75 * rate, speed + 0.75 * rate];
            let pose = [x + 0.02 * draw(), y + 0.02 * draw(), heading + 0.003 * draw()];
            let values = [row as f64 * 0.05, sides[0], sides[1], pose[0], pose[1], pose[2]];
            columns.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
        }
    }
    let named = [
        ("time", Role::Time, Unit::Second),
        ("left", Role::WheelLeft, Unit::MetrePerSecond),
        ("right", Role::WheelRight, Unit::MetrePerSecond),
        ("x", Role::ReferenceX, Unit::Metre),
        ("y", Role::ReferenceY, Unit::Metre),
        ("heading", Role::ReferenceHeading, Unit::Radian),
    ];
    let columns = named.into_iter().zip(columns);
    let columns = columns.map(|((name, role, unit), v)| Column::new(name, role, unit, v)).collect();
    let runs = (0..8 * ROWS).map(|row| row / ROWS).collect();
    let mut car = Dataset::new("car", Kind::Odometry, columns, runs);
    car.drive = Some(Drive::Differential);
    let constants = [("wheelbase", 1.5, Unit::Metre), ("mean_speed", 1.0, Unit::One)];
    let constants =
        constants.map(|(name, value, unit)| (name.to_owned(), Constant { value, unit }));
    car.constants.extend(constants);
    car
}

/// On a straight road the turn tells nothing of a unit, and the distance all.
#[test]
fn units_are_told_on_a_straight_road() {
    let named = |dataset: &Dataset| -> Vec<(Vec<String>, f64)> {
        let finding = found(dataset).finding;
        // A heading that is 0.003 rad off where a run begins is a metre off after 400.
        assert!(finding.held_out.after < 2.0, "{:?}", finding.held_out);
        let wrong = finding.effects.into_iter().filter(|effect| effect.name == "wrong_unit");
        wrong.map(|effect| (effect.drivers, effect.parameters[0].value)).collect()
    };
    assert_eq!(named(&straight()), []);
    for (fields, times) in [(["left", "right"], 1e3), (["left", "right"], 3.6), (["x", "y"], 1e3)] {
        let mut wrong = straight();
        fields.iter().for_each(|name| change(&mut wrong, name, |value| times * value));
        let all = fields.map(|name| (vec![name.to_owned()], times));
        assert_eq!(named(&wrong), all);
    }
}

#[test]
fn a_wheel_that_counts_other_edges_than_the_other_one_is_told_by_name() {
    for (wheel, times) in [("left", 4.0), ("right", 2.0), ("right", 0.25)] {
        let mut wrong = counting();
        change(&mut wrong, wheel, |count| count * times);
        let finding = assert_set_right(&wrong, "encoder_decoding", 1);
        let told = effect(&finding, "encoder_decoding");
        assert_eq!((&*told.drivers[0], told.parameters[0].value), (wheel, times));
        let said = format!(
            "The edges of the encoder count otherwise: {wheel} is {times:.3} times what it must be."
        );
        let said = said.replace("4.000", "4.00").replace("2.000", "2.00");
        assert!(finding.in_words().contains(&said), "{:?}", finding.in_words());
    }
}

#[test]
fn counts_that_add_up_and_exchanged_axes_are_told_by_name() {
    let mut wrong = counting();
    for column in wrong.columns.iter_mut().filter(|column| column.unit == Unit::Count) {
        let mut sum = 0.0;
        for (row, value) in column.values.iter_mut().enumerate() {
            sum = if row > 0 && wrong.run_of_row[row] != wrong.run_of_row[row - 1] {
                0.0
            } else {
                sum
            };
            sum += *value;
            *value = sum;
        }
    }
    assert_set_right(&wrong, "added_up", 2);
    let mut wrong = counting();
    for column in &mut wrong.columns {
        column.role = match column.role {
            Role::ReferenceX => Role::ReferenceY,
            Role::ReferenceY => Role::ReferenceX,
            other => other,
        };
    }
    assert_set_right(&wrong, "exchanged_axes", 1);
    let mut wrong = counting();
    change(&mut wrong, "y", |value| -value);
    assert_set_right(&wrong, "reversed_sign", 1);
}

/// Half a row late and of rows that were evened out, they had a reference ahead of the axle and scales over acceleration.
#[test]
fn speeds_that_are_means_are_told_and_those_of_the_moment_are_left() {
    let mut means = robot(0.0, 0.0);
    for column in means.columns.iter_mut().filter(|column| column.name.ends_with("t")) {
        column.unit = Unit::MetrePerSecond;
        column.values.iter_mut().for_each(|way| *way /= 0.05);
    }
    let mut moments = means.clone();
    let run = moments.run_of_row.clone();
    for column in moments.columns.iter_mut().filter(|column| column.unit == Unit::MetrePerSecond) {
        for at in 1..run.len() - 1 {
            if run[at] == run[at + 1] {
                column.values[at] = (column.values[at] + column.values[at + 1]) / 2.0;
            }
        }
    }
    // Under a reference of a centimetre and half a degree half a row is little from row to row, and much over all.
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(4);
    for robot in [&means, &moments] {
        let mut rough = robot.clone();
        for (name, noise) in [("x", 0.01), ("y", 0.01), ("heading", 0.009)] {
            let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
            let column = rough.columns.iter_mut().find(|column| column.name == name).unwrap();
            column.values.iter_mut().for_each(|value| *value += noise * draw());
        }
        let finding = found(&rough).finding;
        let names: Vec<&str> = finding.effects.iter().map(|one| one.name.as_str()).collect();
        let expected = ["mean_speed", "effective_track"];
        let expected = if robot == &means { &expected[..] } else { &expected[1..] };
        assert_eq!(names, expected, "{:?}", finding.effects);
    }
    let finding = assert_set_right(&means, "mean_speed", 1);
    let said = "The speeds of its wheels are means since the row before, not those of the moment.";
    assert!(finding.in_words().iter().any(|one| one == said), "{:?}", finding.in_words());
    let effects = found(&moments).finding.effects;
    assert!(effects.iter().all(|effect| effect.name != "mean_speed"), "{effects:?}");
    let stated = Constant { value: 1.0, unit: Unit::One };
    means.constants.insert("mean_speed".to_owned(), stated);
    assert_eq!(found(&means).finding.effects.len(), 1);
}

#[test]
fn a_rate_that_is_an_angle_is_read_as_one() {
    let mut wrong = shaken(0.0, |rates| rates);
    for column in wrong.columns.iter_mut().filter(|column| column.role == Role::GyroRate) {
        let mut sum = 0.0;
        column.values.iter_mut().for_each(|value| {
            sum += 0.01 * *value;
            *value = sum;
        });
    }
    let finding = found(&wrong).finding;
    assert!(
        finding.effects.iter().all(|effect| effect.name == "added_up"),
        "{:?}",
        finding.effects
    );
    assert_eq!(finding.effects.len(), 3);
    assert!(finding.held_out.after < 0.012, "{:?}", finding.held_out);
}

#[test]
fn what_never_changes_though_the_device_moves_is_refused_by_name() {
    let refused = |dataset: &Dataset| {
        identify(dataset, None, &Options::default(), &mut |_, _| ()).unwrap_err().to_string()
    };
    for name in ["y", "heading", "left"] {
        let mut still = counting();
        change(&mut still, name, |_| 0.0);
        assert!(refused(&still).starts_with(&format!("`{name}` never changes")), "{name}");
    }
    let mut dead = shaken(0.0, |rates| rates);
    change(&mut dead, "gz", |_| 0.013);
    let finding = found(&dead).finding;
    assert_eq!((finding.verdict, finding.held_out_also.len()), (Verdict::NothingMissing, 1));
    let told = "`gz` never changes, though its reference `rz` does: it is left out";
    assert!(finding.notices.contains(&told.to_owned()), "{:?}", finding.notices);
    dead.columns.retain(|column| !["gx", "gy"].contains(&column.name.as_str()));
    assert_eq!(refused(&dead), "`gz` never changes, though its reference `rz` does");
}

#[test]
fn a_reference_that_ends_early_is_told_and_what_follows_it_takes_no_part() {
    let whole = found(&counting()).finding.held_out.after;
    for held in [true, false] {
        let mut ended = counting();
        for column in ended.columns.iter_mut().filter(|column| column.role.is_reference()) {
            let last = if held { column.values[900 + 180] } else { 0.0 };
            column.values[900 + 180..1200].fill(last);
        }
        let finding = found(&ended).finding;
        assert_eq!(finding.effects.len(), 1, "{:?}", finding.effects);
        effect(&finding, "effective_track");
        assert!(finding.held_out.after < 1.2 * whole, "{:?}", finding.held_out);
        let told = |notice: &String| notice.contains("of run 3 repeats one value from 9.000 on");
        assert!(finding.notices.iter().any(told), "{:?}", finding.notices);
    }
}

/// A sensor that reads `factor` times its reference, beside a temperature with codes for no value.
fn sensor(unit: Unit, read: f64, truth: f64) -> Dataset {
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(5);
    let noise: Vec<f64> = (0..2000).map(|_| StandardNormal.sample(&mut random)).collect();
    let truths = |row: usize| 0.3 + 0.25 * (row as f64 / 62.0).sin();
    let values = |of: &dyn Fn(usize) -> f64| (0..2000).map(of).collect::<Vec<f64>>();
    let warm = |row: usize| 20.0 + 5.0 * (row as f64 / 300.0).sin();
    let reads = |row: usize| 1.02 * truths(row) + 5e-4 * (warm(row) - 20.0) + 1e-3 * noise[row];
    let columns = vec![
        Column::new("time", Role::Time, Unit::Second, values(&|row| row as f64 * 0.05)),
        Column::new("reads", Role::Measured, unit, values(&|row| read * reads(row))),
        Column::new("truth", Role::Reference, unit, values(&|row| truth * truths(row))),
        Column::new(
            "warmth",
            Role::Temperature,
            Unit::Celsius,
            values(&|row| if row % 97 == 5 { 9999.0 } else { warm(row) }),
        ),
    ];
    Dataset::new("sensor", Kind::Sensor, columns, vec![0; 2000])
}

#[test]
fn a_sensor_in_another_unit_and_codes_for_no_value_are_told() {
    let plain = found(&sensor(Unit::Metre, 1.0, 1.0)).finding;
    let names = |finding: &Finding| -> Vec<String> {
        finding.effects.iter().map(|effect| effect.name.clone()).collect()
    };
    assert_eq!(names(&plain), ["bias_over_temperature"]);
    assert_eq!((plain.set_aside.len(), plain.set_aside[0].rows), (1, 21));
    assert_eq!(plain.set_aside[0].quantity, "warmth");
    for (unit, read, truth, name) in [
        (Unit::Metre, 1e3, 1.0, "wrong_unit"),
        (Unit::Volt, 1.0, 1e3, "wrong_unit"),
        (Unit::Count, 4e6, 1e6, "encoder_decoding"),
    ] {
        let identified = found(&sensor(unit, read, truth));
        let mut told = names(&identified.finding);
        told.sort();
        let mut expected = vec!["bias_over_temperature".to_owned(), name.to_owned()];
        expected.sort();
        assert_eq!(told, expected, "{unit}");
        let (size, after) = (read.min(truth), identified.finding.held_out.after);
        assert!((after / size / plain.held_out.after - 1.0).abs() < 0.05, "{unit}: {after}");
    }
}
