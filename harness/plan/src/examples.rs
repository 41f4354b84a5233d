//! A step of each kind, as a plan may write it.

/// Key of the action, and a step with it.
pub const STEP_EXAMPLES: &[(&str, &str)] = &[
    ("bias_test", "{ bias_test = { duration_s = 20 } }"),
    ("bias_residual", "{ bias_residual = { duration_s = 64 } }"),
    ("log", "{ log = { duration_s = 7200, interval_s = 10 } }"),
    ("wait", "{ wait = { duration_s = 60 } }"),
    (
        "wait_until",
        "{ wait_until = { steady = { quantity = \"gyro.temperature\", change_at_most = 0.5, over_s = 600 } } }",
    ),
    ("reaction", "{ reaction = \"opening\", time_limit_s = 2 }"),
    ("turn", "{ turn = { angle_deg = 90, rate_deg_per_s = 30 } }"),
    ("straight", "{ straight = { distance_m = 4, speed_m_per_s = 0.4 } }"),
    ("lap", "{ lap = { direction = \"cw\", side_m = 4 } }"),
    ("table_turn", "{ table_turn = { angle_deg = -360, rate_deg_per_s = 30 } }"),
    ("place", "{ place = { x_m = 0, y_m = 0, heading_deg = 90 } }"),
    ("measure_pose", "{ measure_pose = \"start\" }"),
    ("heading_source", "{ heading_source = \"odometry\" }"),
    ("bias_method", "{ bias_method = \"temperature_table\" }"),
    ("estimator", "{ estimator = \"kalman\" }"),
    (
        "fit",
        "{ fit = { name = \"line\", quantity = \"table.error\", model = { line = { against = \"temperature\" } } } }",
    ),
    ("save_calibration", "{ save_calibration = { name = \"mine\", from = [\"line\"] } }"),
    ("use_calibration", "{ use_calibration = \"temperature\" }"),
    ("identify", "{ identify = { from = \"turns\", name = \"loop\", over = \"before\" } }"),
    ("use_model", "{ use_model = \"loop\" }"),
    ("set_parameter", "{ set_parameter = { parameter = \"gyro.ambient_celsius\", value = 35 } }"),
    ("power_cycle", "{ power_cycle = { device = \"gyro\", off_s = 30 } }"),
    ("send", "{ send = { message = \"Command\", set = { Setpoint = 60 }, every_s = 0.1 } }"),
    ("stop_sending", "{ stop_sending = \"Command\" }"),
    (
        "operator_prompt",
        "{ operator_prompt = { text = \"Weigh it\", answer = { name = \"mass\", unit = \"kg\", range = [10, 90] } } }",
    ),
    (
        "repeat",
        "{ repeat = { times = 20, steps = [{ wait = { duration_s = 60 } }] }, label = \"before\" }",
    ),
    (
        "sweep",
        "{ sweep = { parameter = \"gyro.scale_ppm\", values = [0, 100], steps = [{ bias_test = {} }] } }",
    ),
];

#[cfg(test)]
mod tests {
    use super::STEP_EXAMPLES;
    use crate::{Action, Step};
    use serde::Deserialize;

    #[derive(Deserialize)]
    struct Holder {
        step: Step,
    }

    #[test]
    fn every_action_has_an_example_that_is_one() {
        let names: Vec<&str> = STEP_EXAMPLES.iter().map(|(name, _)| *name).collect();
        assert_eq!(names, Action::NAMES);
        for (name, text) in STEP_EXAMPLES {
            let read = toml::from_str::<Holder>(&format!("step = {text}"));
            let step = read.unwrap_or_else(|error| panic!("{text}: {error}")).step;
            assert_eq!(step.action.name(), *name);
        }
    }
}
