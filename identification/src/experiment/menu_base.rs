//! Plans for the robot's base.

use super::menu::AMBIENT_SWING;
use super::step::{BASE, Programme, RATE, SIDE, SPEED, Step, laps};
use super::surroundings::ROOM;

/// Time from lap to lap in the paper's 40 runs in 16 hours, s.
const LAP_PERIOD_S: f64 = 1440.0;

/// Plans that a base can run, in order of increasing duration.
pub(super) fn base() -> Vec<Programme> {
    vec![
        plan(
            "speed-ladder",
            "Straight lines forward and back at five speeds",
            "slip and lags grow with speed and acceleration, wheels do not",
            vec![Step::BiasTest, Step::again(
                3,
                [0.1, 0.2, 0.3, 0.5, 0.7]
                    .into_iter()
                    .flat_map(|v| [Step::Place(0.0), Step::Straight(SIDE, v), Step::Straight(-SIDE, v)])
                    .collect(),
            )],
        ),
        plan(
            "straights-at-headings",
            "Straight lines forward and back at eight headings",
            "what the floor or the direction of the wheels bends changes with the heading",
            vec![Step::BiasTest, Step::again(
                2,
                (0..8)
                    .map(|k| Step::Place(f64::from(k) * 45.0 - 180.0))
                    .flat_map(|place| [place, Step::Straight(SIDE, SPEED), Step::Straight(-SIDE, SPEED)])
                    .collect(),
            )],
        ),
        plan(
            "turns-on-the-spot",
            "Turns of the robot both ways, without a distance",
            "the turn alone, by size and rate, with nothing that a distance could bend",
            vec![Step::BiasTest, Step::again(
                4,
                [(90.0, 10.0), (360.0, 10.0), (90.0, RATE), (360.0, RATE)]
                    .into_iter()
                    .flat_map(|(angle, rate)| {
                        [Step::Place(0.0), Step::Turn(angle, rate), Step::Place(0.0), Step::Turn(-angle, rate)]
                    })
                    .collect(),
            )],
        ),
        plan(
            "laps-of-two-sizes",
            "Laps both ways of 4 m and of 2 m",
            "the turns stay, the distance halves",
            vec![Step::again(5, [laps(SIDE, SPEED, RATE), laps(2.0, SPEED, RATE)].concat())],
        ),
        plan(
            "laps-of-four-speeds",
            "Laps both ways, slow and fast on the sides and in the corners",
            "the path stays, its duration and its rates change",
            vec![Step::again(
                3,
                [
                    laps(SIDE, 0.15, RATE),
                    laps(SIDE, 0.6, RATE),
                    laps(SIDE, SPEED, 8.0),
                    laps(SIDE, SPEED, RATE),
                ]
                .concat(),
            )],
        ),
        Programme {
            warm: true,
            ..plan(
                "laps-after-hot-restart",
                "Laps both ways from a power-up while the gyro is warm",
                "time since power-up begins anew while the temperature is steady already",
                vec![
                    Step::Ask(
                        "Let the gyro run for two hours. Then switch it off for 10 s and on again, and go on at once."
                            .to_owned(),
                    ),
                    Step::again(20, laps(SIDE, SPEED, RATE)),
                ],
            )
        },
        plan(
            "laps-in-three-rooms",
            "Laps both ways in a warm, a cold and again a warm room",
            "at equal temperatures the gyro is warming or cooling, or has been on for a different time",
            vec![Step::Sweep {
                ambient: vec![ROOM + AMBIENT_SWING, ROOM - AMBIENT_SWING, ROOM + AMBIENT_SWING],
                steps: vec![Step::again(20, laps(SIDE, SPEED, RATE))],
            }],
        ),
        plan(
            "laps-hours-apart",
            "The same laps every 24 minutes for sixteen hours",
            "what wears or wanders differs from hour to hour",
            vec![Step::Repeat {
                times: 40,
                period_s: Some(LAP_PERIOD_S),
                steps: laps(SIDE, SPEED, RATE),
            }],
        ),
    ]
}

fn plan(
    name: &'static str,
    title: &'static str,
    reason: &'static str,
    steps: Vec<Step>,
) -> Programme {
    Programme { name, title, reason, devices: BASE, warm: false, steps }
}
