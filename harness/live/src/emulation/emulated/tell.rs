//! Answers to queries: the truth, the counters, the list of settings.

use super::Emulated;
use emulators::parameters::Parameters;
use plan::faults::{Fault, FaultKind, Target};
use rig::bench::Carrier;
use rig::robot::Robot;
use serde_json::{Map, Value, json};
use wire::time::{Span, Timestamp};

/// The true rate is the mean over this time from now on, if the current motion continues.
const RATE_SPAN: Span = Span::from_millis(1);
/// A short name of a gyro's [`AMBIENT`].
const TEMPERATURE: &str = "temperature_degC";
/// Room temperature; the coil follows by its time constant and self-heating.
const AMBIENT: &str = "ambient_celsius";

/// The parameter to which `name` refers.
pub(super) fn parameter_name(name: &str) -> &str {
    if name == TEMPERATURE { AMBIENT } else { name }
}

/// Truth at `now`: that of the carrier, and that of each device.
pub(super) fn truth(emulated: &mut Emulated, now: Timestamp) -> Value {
    let mut told = Map::new();
    let mut tell = |name: &str, value: Value| _ = told.insert(name.to_owned(), value);
    tell("at_s", json!((now - Timestamp::ZERO).as_secs_f64()));
    if let Some(first) = emulated.rig.robot() {
        let heading = |at| first.bench.carrier.heading_at(at);
        let turned = heading(now + RATE_SPAN) - heading(now);
        tell("heading_deg", json!(heading(now).deg()));
        tell("rate_deg_per_s", json!(turned.deg() / RATE_SPAN.as_secs_f64()));
    }
    for robot in emulated.rig.robots() {
        if robot.has(Target::Gyro) {
            let truth = robot.bench.gyro.truth();
            let gyro = json!({
                "bias_deg_per_h": truth.bias.deg_per_h(),
                "scale": truth.scale,
                "coil_celsius": truth.coil_temperature.celsius(),
            });
            tell("gyro", gyro);
        }
        match &robot.bench.carrier {
            Carrier::Base(base) => {
                let truth = base.truth_at(now);
                let base = json!({
                    "x_m": truth.pose.x.m(),
                    "y_m": truth.pose.y.m(),
                    "heading_deg": truth.pose.heading.deg(),
                    "body_heading_deg": truth.body_heading.deg(),
                    "speed_m_per_s": truth.speed.m_per_s(),
                    "steer_rate_deg_per_s": truth.steer_rate.deg_per_s(),
                });
                tell("base", base);
            }
            Carrier::Table(table) => {
                let table = json!({
                    "angle_deg": table.angle_at(now).deg(),
                    "steps_lost": table.steps_lost_at(now),
                });
                tell("table", table);
            }
            Carrier::Turning(_) => {}
        }
    }
    for name in described(emulated) {
        let Some(device) = emulated.described(&name) else { continue };
        let states: Vec<String> = device.description().states().map(str::to_owned).collect();
        let values =
            states.iter().filter_map(|state| Some((state.clone(), json!(device.value(state)?))));
        tell(&name, Value::Object(values.collect()));
    }
    Value::Object(told)
}

/// States, signals and parameters of a described device.
pub(super) fn values(
    emulated: &mut Emulated,
    name: &str,
    names: &[String],
) -> Result<Value, String> {
    let Some(device) = emulated.described(name) else {
        return Err(format!("failed to tell values of the {name}: ask for its \"truth\""));
    };
    let parameters = device.description().parameters().map(|(name, ..)| name.to_owned());
    let names: Vec<String> = if names.is_empty() { parameters.collect() } else { names.to_vec() };
    let value = |name: &String| match device.value(name) {
        Some(value) => Ok((name.clone(), json!(value))),
        None => Err(format!("nothing is called {name}")),
    };
    Ok(Value::Object(names.iter().map(value).collect::<Result<_, _>>()?))
}

pub(super) fn counters(emulated: &Emulated) -> Value {
    let mut told = Map::new();
    for name in emulated.names() {
        let device = match (emulated.robot(name), emulated.shown(name)) {
            (Some(robot), _) => of_robot(robot, name),
            (None, Some(device)) => json!({
                "messages_refused": device.refused_messages(),
                "questions_refused": device.refused_busy(),
                "values_out_of_range": device.clipped().map(|one| one.count).sum::<u64>(),
                "values_not_finite": device.not_finite(),
            }),
            (None, None) => Value::Null,
        };
        told.insert(name.to_owned(), json!({ "device": device }));
    }
    told.insert("dropped".to_owned(), json!(emulated.dropped()));
    told.insert("faults_acted".to_owned(), json!(emulated.acted));
    Value::Object(told)
}

fn of_robot(robot: &Robot, name: &str) -> Value {
    match &robot.bench.carrier {
        _ if name == Target::Gyro.name() => {
            json!({ "outputs_dropped": robot.bench.gyro.outputs_dropped() })
        }
        Carrier::Base(base) => {
            let serial = base.serial_counters();
            json!({
                "frames_ignored": base.frames_ignored(),
                "writes": serial.writes,
                "reads": serial.reads,
                "malformed": serial.malformed,
                "bad_checksum": serial.bad_checksum,
                "other_computer": serial.other_computer,
                "unknown_register": serial.unknown_register,
                "wrong_count": serial.wrong_count,
                "wrong_value": serial.wrong_value,
                "skipped": serial.skipped,
                "outputs_dropped": base.outputs_dropped(),
            })
        }
        Carrier::Table(table) => json!({
            "lines_refused": table.lines_refused(),
            "answers_dropped": table.answers_dropped(),
        }),
        Carrier::Turning(_) => Value::Null,
    }
}

/// Devices, their parameters with current values, and the faults that can strike them.
pub(super) fn list(emulated: &mut Emulated) -> Value {
    let mut told = Map::new();
    let names: Vec<String> = emulated.names().into_iter().map(str::to_owned).collect();
    for name in names {
        let parameters = match emulated.robot(&name).map(|robot| &robot.bench) {
            Some(bench) if name == Target::Gyro.name() => parameters(bench.gyro.parameters()),
            Some(bench) => match &bench.carrier {
                Carrier::Base(base) => parameters(base.parameters()),
                Carrier::Table(table) => parameters(table.parameters()),
                Carrier::Turning(_) => Value::Null,
            },
            None => values(emulated, &name, &[]).unwrap_or_default(),
        };
        let can_strike = |kind: &FaultKind| {
            let target = Target::named(&name);
            target.is_some_and(|target| Fault::new(target, *kind).check(&emulated.lines).is_ok())
        };
        let faults = FaultKind::all().iter().filter(|info| can_strike(&info.typical));
        let faults: Vec<&str> = faults.map(|info| info.name).collect();
        told.insert(name, json!({ "parameters": parameters, "faults": faults }));
    }
    Value::Object(told)
}

fn described(emulated: &Emulated) -> Vec<String> {
    let names = emulated.names().into_iter();
    names.filter(|name| emulated.robot(name).is_none()).map(str::to_owned).collect()
}

/// Values by name. JSON has no infinity: an infinite limit is `null`.
fn parameters<P: Parameters + Clone>(parameters: &P) -> Value {
    let mut copy = parameters.clone();
    let values = P::TABLE.iter().filter_map(|info| {
        let (value, _) = copy.slot(info.name)?;
        Some((info.name.to_owned(), json!(*value)))
    });
    Value::Object(values.collect())
}
