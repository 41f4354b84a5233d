//! Controllers that say what is not so, in a shell: each is judged by what is true, and by what it says of itself.

use crate::{out, record, run, shown, summary};
use skips::in_time;

/// Answers with results that look right.
const ANSWERS: &str = r#"
say() { echo "{\"at_ns\":1,\"report\":$1}"; }
state() {
    say "{\"state\":{\"activity\":\"idle\",\"pose\":{\"x_m\":0,\"y_m\":0,\"heading_rad\":0},\"gyro_heading_rad\":0,\"odometry_heading_rad\":0,\"displacement_m\":0,\"heading_error_rad\":$1,\"raw_rate_rad_per_s\":0,\"bias_rad_per_s\":0,\"temperature_celsius\":30,\"moving\":${2:-false},\"samples\":0,\"samples_lost\":0,\"clock_ratio\":null,\"health\":{\"level\":\"ok\",\"causes\":{}}}}"
}
done_with() { say "{\"done\":{\"id\":$id,\"result\":$1}}"; }
bias='{"bias_test":{"mean_rad_per_s":0,"spread_rad_per_s":0.0002,"samples":2000,"temperature_celsius":30,"table_rad_per_s":null}}'
pose='{"x_m":4,"y_m":0,"heading_rad":0}'
straight="{\"straight\":{\"stop_error_m\":0,\"heading_error_max_rad\":0,\"heading_error_rad\":0,\"duration_ns\":11000000000,\"pose_writes\":1,\"pose\":$pose}}"
turn='{"turn":{"stop_error_rad":0,"gyro_angle_rad":1.5708,"odometry_angle_rad":1.5708,"duration_ns":5000000000}}'
state null
while read -r line; do
    id=${line#*\"id\":}; id=${id%%,*}
    case "$line" in
"#;

/// Runs a plan with a controller that answers by these cases; returns its status, its summary and all that it says.
fn run_liar(name: &str, plan: &str, cases: &str) -> (Option<i32>, serde_json::Value, String) {
    let (folder, out) = out(name);
    let file = folder.path().join("liar.sh");
    let script = format!(
        "{ANSWERS}{cases}\n*request_state*) state null; done_with '\"applied\"';;\n*) done_with '\"applied\"';;\nesac\ndone\n"
    );
    std::fs::write(&file, script).unwrap();
    let controller = format!("sh {}", file.display());
    let output = run(&["run", plan, "--clock", "real", "--controller", &controller], &out);
    let record = record(&out);
    (output.status.code(), summary(&out), format!("{}{record}", shown(&output)))
}

/// The measurements with this verdict.
fn with_verdict(summary: &serde_json::Value, verdict: &str) -> Vec<String> {
    let all = summary["measurements"].as_array().unwrap().iter();
    let of = all.filter(|one| one["verdict"] == verdict);
    of.map(|one| one["name"].as_str().unwrap().to_owned()).collect()
}

/// Answers *done* at once, invents three states on the way, and never moves.
#[test]
fn one_that_never_moves_fails_by_truth_and_by_time() {
    const NEVER_MOVES: &str = "*bias_test*) done_with \"$bias\";;
*straight*) state 0; state 0.001; state 0; done_with \"$straight\";;
*turn*) done_with \"$turn\";;";
    in_time(|| {
        let (status, summary, said) = run_liar("still", "live-side", NEVER_MOVES);
        assert_eq!((status, &summary["outcome"]), (Some(1), &"failed".into()), "{said}");
        let failed = with_verdict(&summary, "fail");
        assert_eq!(failed, ["end_x", "end_heading", "side_duration"], "{said}");
        assert_eq!(with_verdict(&summary, "unset"), ["heading_held"]);
        let passed = with_verdict(&summary, "pass");
        assert_eq!(passed, ["straight_stop_error", "turn_stop_error", "end_y"]);
    });
}

#[test]
fn a_result_that_is_no_number_fails_at_once_by_name() {
    const NO_NUMBER: &str = "*bias_test*) done_with '{\"bias_test\":{\"mean_rad_per_s\":NaN,\"spread_rad_per_s\":0}}';;";
    in_time(|| {
        let (status, summary, said) = run_liar("nan", "live-table-run", NO_NUMBER);
        assert_eq!((status, &summary["outcome"]), (Some(1), &"failed".into()), "{said}");
        let reason = summary["reason"].as_str().unwrap();
        assert!(reason.contains("`mean_rad_per_s` is NaN, which is no number"), "{reason}");
        assert!(summary["simulated_s"].as_f64().unwrap() < 10.0, "{summary}");
    });
}

#[test]
fn a_second_answer_is_noted() {
    const TWICE: &str = "*bias_test*) done_with \"$bias\"; done_with \"$bias\";;";
    in_time(|| {
        let (_, _, said) = run_liar("twice", "live-table-run", TWICE);
        assert!(said.contains("the controller answered mission 2, once more"), "{said}");
    });
}

#[test]
fn one_that_moves_on_after_the_stop_fails_by_name() {
    const MOVES_ON: &str = "*bias_test*) done_with \"$bias\";;
*straight*) done_with \"$straight\";;
*turn*) done_with \"$turn\"; stopped=yes;;
*request_state*) state null $([ -n \"$stopped\" ] && echo true || echo false); done_with '\"applied\"';;";
    in_time(|| {
        let (status, summary, said) = run_liar("moves-on", "live-side", MOVES_ON);
        assert_eq!((status, &summary["outcome"]), (Some(1), &"failed".into()), "{said}");
        let reason = summary["reason"].as_str().unwrap();
        assert!(
            reason.contains("long after the order to stop, the controller still reports motion"),
            "{reason}"
        );
    });
}
