//! What is answered to those who ask: the truth, the counters, the list of what can be set.

use super::Role;
use super::bench::EmulatedBench;
use super::link::Link;
use emulators::parameters::Parameters;
use serde_json::{Map, Value, json};
use wire::time::Timestamp;

/// A short name of a gyro's [`AMBIENT`].
const TEMPERATURE: &str = "temperature_degC";
/// Temperature of the room; the coil follows by its time constant and self-heating.
const AMBIENT: &str = "ambient_celsius";

/// The parameter that a request means by `name`.
pub(super) fn parameter_name(name: &str) -> &str {
    if name == TEMPERATURE { AMBIENT } else { name }
}

/// What is true at `now`: what turns the gyro, and each device.
pub(super) fn truth(bench: &EmulatedBench, now: Timestamp) -> Value {
    let mut told = Map::new();
    told.insert("at_s".to_owned(), json!((now - Timestamp::ZERO).as_secs_f64()));
    told.insert("heading_deg".to_owned(), json!(bench.heading_at(now).deg()));
    told.insert("rate_deg_per_s".to_owned(), json!(bench.rate_at(now).deg_per_s()));
    if let Some(gyro) = &bench.gyro {
        let truth = gyro.truth();
        let gyro = json!({
            "bias_deg_per_h": truth.bias.deg_per_h(),
            "scale": truth.scale,
            "coil_celsius": truth.coil_temperature.celsius(),
        });
        told.insert("gyro".to_owned(), gyro);
    }
    if let Some(base) = &bench.base {
        let truth = base.truth_at(now);
        let base = json!({
            "x_m": truth.pose.x.m(),
            "y_m": truth.pose.y.m(),
            "heading_deg": truth.pose.heading.deg(),
            "body_heading_deg": truth.body_heading.deg(),
            "speed_m_per_s": truth.speed.m_per_s(),
            "steer_rate_deg_per_s": truth.steer_rate.deg_per_s(),
        });
        told.insert("base".to_owned(), base);
    }
    if let Some(table) = &bench.table {
        let table = json!({
            "angle_deg": table.angle_at(now).deg(),
            "steps_lost": table.steps_lost_at(now),
        });
        told.insert("table".to_owned(), table);
    }
    Value::Object(told)
}

/// What devices and links have counted.
pub(super) fn counters(bench: &EmulatedBench) -> Value {
    let mut told = Map::new();
    for role in bench.roles() {
        let device = match role {
            Role::Gyro => {
                bench.gyro.as_ref().map(|gyro| json!({ "outputs_dropped": gyro.outputs_dropped() }))
            }
            Role::Base => bench.base.as_ref().map(|base| {
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
            }),
            Role::Table => bench.table.as_ref().map(|table| {
                json!({
                    "lines_refused": table.lines_refused(),
                    "answers_dropped": table.answers_dropped(),
                })
            }),
        };
        let link = bench.links.get(&role).map(Link::counters).map(|link| {
            json!({
                "silenced": link.silenced,
                "delayed": link.delayed,
                "stuck": link.stuck,
                "lost": link.lost,
                "overflowed": link.overflowed,
            })
        });
        told.insert(role.name().to_owned(), json!({ "device": device, "link": link }));
    }
    Value::Object(told)
}

/// Devices, their parameters with the values in force, and the faults that they can have.
pub(super) fn list(bench: &EmulatedBench) -> Value {
    let mut told = Map::new();
    for role in bench.roles() {
        let parameters = match role {
            Role::Gyro => bench.gyro.as_ref().map(|gyro| parameters(gyro.parameters())),
            Role::Base => bench.base.as_ref().map(|base| parameters(base.parameters())),
            Role::Table => bench.table.as_ref().map(|table| parameters(table.parameters())),
        };
        let faults = bench.faults_of(role);
        let device = json!({ "parameters": parameters, "faults": faults });
        told.insert(role.name().to_owned(), device);
    }
    Value::Object(told)
}

/// Values by name. JSON has no infinity: a limit that is none is `null`.
fn parameters<P: Parameters + Clone>(parameters: &P) -> Value {
    let mut copy = parameters.clone();
    let values = P::TABLE.iter().filter_map(|info| {
        let (value, _) = copy.slot(info.name)?;
        Some((info.name.to_owned(), json!(*value)))
    });
    Value::Object(values.collect())
}
