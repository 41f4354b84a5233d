//! What health says of errors of the believed pose, and when.

use super::{margin, near};
use crate::properties::{HEADING_BAND, Seen};
use controller::health::Causes;
use controller::mission::{BiasTest, BiasTestResult, Command, MissionResult, Report};
use wire::units::AngularRate;

#[test]
fn an_error_is_silent_until_there_is_a_word_of_it_within_the_step() {
    let well = Causes::default();
    let lost = Causes { samples_lost: true, ..well };
    let step = |said_before: bool, said_after: bool, taken_back: bool| {
        margin("no_silent_wrong", |scene| {
            scene.health(well).see(&Seen::StepBegan).truth(0.0, 0.0).state(0.0, 1);
            if said_before {
                scene.health(lost);
            }
            if taken_back {
                scene.health(well);
            }
            scene.after(1_000).truth(HEADING_BAND.deg() * 1.5, 0.0).state(0.0, 2);
            if said_after {
                scene.after(1_000).health(lost);
            }
            scene.see(&Seen::StepEnded);
        })
    };
    assert!(near(step(false, false, false), -0.5));
    assert!(near(step(true, false, false), 1.0));
    assert!(near(step(false, true, false), 1.0), "a warning may come late, within the step");
    assert!(near(step(true, false, true), -0.5), "a warning that was withdrawn does not count");
}

/// Eight steps of a quarter of the band each were eight right ones, and a bias test made good what it had found.
#[test]
fn errors_add_up_over_steps_and_bias_tests() {
    let added = |placed: bool, said: bool| {
        let test = Command::BiasTest(BiasTest { duration_s: 20.0 });
        let (mean, spread) = (AngularRate::ZERO, AngularRate::ZERO);
        let result =
            BiasTestResult { mean, spread, samples: 2_000, temperature: None, table: None };
        let result = MissionResult::BiasTest(result);
        margin("no_silent_wrong", |scene| {
            scene.health(Causes::default()).see(&Seen::StepBegan).truth(0.0, 0.0).state(0.0, 1);
            scene.after(1_000).truth(HEADING_BAND.deg() * 0.8, 0.0).state(0.0, 2);
            scene.see(&Seen::StepEnded).see(&Seen::StepBegan).tell(3, test);
            scene.report(Report::Done { id: 3, result }).see(&Seen::StepEnded);
            if placed {
                scene.see(&Seen::Placed).truth(0.0, 0.0).state(0.0, 3);
            }
            if said {
                scene.health(Causes { bias_moved: true, ..Causes::default() });
            }
            let to = HEADING_BAND.deg() * if placed { 0.8 } else { 1.6 };
            scene.see(&Seen::StepBegan).after(1_000).truth(to, 0.0).state(0.0, 4);
            scene.see(&Seen::StepEnded);
        })
    };
    assert!(near(added(false, false), -0.6));
    assert!(near(added(true, false), 0.2) && near(added(false, true), 0.2));
}
