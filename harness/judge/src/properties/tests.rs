//! Each judge with hand-made events: what it accepts, what it rejects, and the margin.

mod hidden;
mod scene;
mod silent;

use super::{Always, Kind, Limits, Monitor, Property, PropertyVerdict, Seen, Sometimes};
use controller::config::{Config, GyroConfig, MotionConfig};
use controller::health::{Causes, Health};
use controller::mission::{
    AbortReason, Command, HeadingSource, MissionResult, Refusal, Report, State, Straight, Turn,
    TurnResult, Uncertainty,
};
use scene::Scene;
use wire::base::Request;
use wire::time::Span;
use wire::units::{Acceleration, Angle, AngularAcceleration, AngularRate, Length, Pose, Speed};

/// The result of `name` in the scene that `play` makes.
fn verdict(name: &str, play: impl FnOnce(&mut Scene)) -> PropertyVerdict {
    let mut scene = Scene::new();
    play(&mut scene);
    scene.verdict(name)
}

fn margin(name: &str, play: impl FnOnce(&mut Scene)) -> f64 {
    let verdict = verdict(name, play);
    assert_eq!(verdict.kind, Kind::Always);
    let margin = verdict.margin.expect("there was something to judge");
    assert_eq!(verdict.held, margin >= 0.0, "{verdict:?}");
    assert_eq!(verdict.held, verdict.first_violation.is_none(), "{verdict:?}");
    margin
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-6
}

#[test]
fn the_age_of_the_heading_is_that_of_the_last_good_sample() {
    let at = |millis| {
        margin("fresh_heading", |scene| {
            scene.gyro().after(millis).velocity(0.1);
        })
    };
    assert!(near(at(40), 0.75) && near(at(160), 0.0) && near(at(240), -0.5));
    let never = margin("fresh_heading", |scene| {
        scene.velocity(0.1);
    });
    assert!(near(never, -1.0));
    let standing = verdict("fresh_heading", |scene| {
        scene.velocity(0.0);
    });
    assert_eq!(standing.margin, None, "to stand needs no heading");
    let by_odometry = verdict("fresh_heading", |scene| {
        scene.tell(1, Command::SetHeadingSource(HeadingSource::Odometry));
        scene.report(Report::Done { id: 1, result: MissionResult::Applied }).velocity(0.1);
    });
    assert_eq!(by_odometry.margin, None);
}

#[test]
fn a_gyro_may_be_bridged_for_so_long_where_that_is_said() {
    let bridged = |name: &str, millis: i64, said: bool| {
        verdict(name, |scene| {
            scene.gyro().motion().truth(0.0, 0.4);
            for passed in (10..=millis).step_by(10) {
                scene.after(10).motion();
                if passed == 100 && said {
                    scene.health(Causes { bridging: true, ..Causes::default() });
                }
                scene.velocity(0.4).truth(0.0, 0.4);
            }
        })
    };
    for name in ["fresh_heading", "stops_on_loss"] {
        assert!(bridged(name, 5_000, true).held, "{name}");
        assert!(!bridged(name, 5_000, false).held, "{name}");
        // 5 s of bridge, plus the full reaction time and braking afterwards.
        assert!(!bridged(name, 6_700, true).held, "{name}");
    }
    assert!(!bridged("fresh_heading", 5_010, true).held);
    assert!(bridged("stops_on_loss", 6_100, true).held);
}

#[test]
fn who_loses_an_input_has_time_and_distance_to_stop() {
    // 0.62 s of reaction and 0.4 m/s at 0.4 m/s^2: 1.62 s.
    let moving_for = |millis: i64, gyro: bool, base: bool| {
        margin("stops_on_loss", |scene| {
            scene.truth(0.0, 0.0);
            for _ in 0..millis / 10 {
                scene.after(10);
                if gyro {
                    scene.gyro();
                }
                if base {
                    scene.motion();
                }
                scene.truth(0.0, 0.4);
            }
            scene.after(10).truth(0.0, 0.0);
        })
    };
    assert!(moving_for(3_000, true, true) > 0.95);
    for (gyro, base) in [(false, true), (true, false)] {
        assert!(moving_for(600, gyro, base) > 0.3);
        // Constant full speed exceeds the braking distance before the time is up.
        assert!(moving_for(1_300, gyro, base) < 0.0);
        assert!(near(moving_for(4_000, gyro, base), -1.0));
    }
}

#[test]
fn speeds_commanded_and_true_and_speeding_up_are_limited() {
    assert!(near(
        margin("within_limits", |scene| {
            scene.velocity(0.39);
        }),
        0.5
    ));
    assert!(
        margin("within_limits", |scene| {
            scene.velocity(0.8);
        }) < 0.0
    );
    assert!(
        margin("within_limits", |scene| {
            scene.truth(0.0, 0.79);
        }) > 0.0,
        "scale error"
    );
    assert!(
        margin("within_limits", |scene| {
            scene.truth(0.0, -0.83);
        }) < 0.0
    );
    let speeding_up = |from: f64, to: f64| {
        margin("within_limits", |scene| {
            scene.truth(0.0, from).after(100).truth(0.0, to);
        })
    };
    assert!(near(speeding_up(0.0, 0.04), 0.5) && speeding_up(0.0, 0.1) < 0.0);
    assert!(speeding_up(0.1, 0.0) > 0.8, "braking may be hard");
}

#[test]
fn a_pose_is_written_at_rest() {
    let write = Request::WritePose { pose: Pose::default(), counter: 1 };
    let stood = |millis| {
        margin("pose_written_at_rest", |scene| {
            scene.truth(0.0, 0.1).after(millis).truth(0.0, 0.0).request(&write);
        })
    };
    assert!(near(stood(150), 0.5) && near(stood(1_000), 1.0));
    let moving = margin("pose_written_at_rest", |scene| {
        scene.truth(0.0, 0.001).request(&write);
    });
    assert!(near(moving, -1.0));
}

#[test]
fn numbers_are_numbers() {
    assert!(near(
        margin("finite_outputs", |scene| {
            scene.state(0.0, 0);
        }),
        1.0
    ));
    assert!(near(
        margin("finite_outputs", |scene| {
            scene.state(f64::NAN, 0);
        }),
        -1.0
    ));
    let unsure = |heading| {
        let (x, y) = (Length::ZERO, Length::ZERO);
        let uncertainty = Some(Uncertainty { heading, x, y });
        margin("finite_outputs", |scene| {
            scene.report(Report::State(State { uncertainty, ..scene::state() }));
        })
    };
    assert!(near(unsure(Angle::ZERO), 1.0) && near(unsure(Angle::from_deg(f64::NAN)), -1.0));
}

#[test]
fn after_a_fault_it_works_or_says_that_it_does_not() {
    let faults = Seen::Faults;
    let (active, over) = (faults(1), faults(0));
    let well = Causes::default();
    let counting = margin("recovers", |scene| {
        scene.health(well).see(&active).after(100).see(&over);
        scene.state(0.0, 10).after(1_000).gyro().state(0.0, 110);
    });
    assert!(near(counting, 0.8));
    let stuck = |causes| {
        margin("recovers", |scene| {
            scene.health(causes).see(&active).after(100).see(&over);
            for _ in 0..7 {
                scene.gyro().state(0.0, 10).after(1_000);
            }
        })
    };
    assert!(stuck(well) < 0.0);
    assert!(near(stuck(Causes { gyro_fault: true, ..well }), 1.0));
    let silent = margin("recovers", |scene| {
        scene.health(well).gyro().after(500).truth(0.0, 0.0).gyro();
        for _ in 0..600 {
            scene.after(10).gyro();
        }
    });
    assert!(silent < 0.0, "silence is a fault without anybody saying so");
}

#[test]
fn done_is_done_where_the_controller_calls_itself_well() {
    let turn = Turn { angle: Angle::from_deg(90.0), rate: AngularRate::from_deg_per_s(30.0) };
    let result = MissionResult::Turn(TurnResult {
        stop_error: Angle::ZERO,
        gyro_angle: turn.angle,
        odometry_angle: turn.angle,
        duration: Span::from_secs(5),
    });
    let turned = |deg: f64, causes: Causes| {
        verdict("done_is_done", |scene| {
            scene.health(causes).truth(0.0, 0.0).tell(3, Command::Turn(turn));
            scene.after(5_000).truth(deg, 0.0).report(Report::Done { id: 3, result });
        })
    };
    assert!(near(turned(90.6, Causes::default()).margin.unwrap(), 0.5));
    let wrong = turned(-270.0, Causes::default());
    insta::assert_snapshot!(wrong.first_violation.unwrap().what, @"a turn of 90.0 deg is called done and was one of -270.0 deg, expected within 1.2 deg");
    assert_eq!(turned(0.0, Causes { samples_lost: true, ..Causes::default() }).margin, None);
    let by_states = verdict("done_is_done", |scene| {
        scene.health_by_states(Causes::default()).truth(0.0, 0.0).state(0.0, 1);
        scene.tell(3, Command::Turn(turn));
        scene.after(5_000).truth(0.0, 0.0).report(Report::Done { id: 3, result });
    });
    assert!(!by_states.held, "a health that only states tell is a word, too");
}

/// Found by a campaign: a straight that ended 1.7 deg off its heading, which the next turn made good.
#[test]
fn a_turn_is_done_where_it_was_to_lead_to() {
    let turn = Turn { angle: Angle::from_deg(-90.0), rate: AngularRate::from_deg_per_s(30.0) };
    let result = MissionResult::Turn(TurnResult {
        stop_error: Angle::ZERO,
        gyro_angle: turn.angle,
        odometry_angle: turn.angle,
        duration: Span::from_secs(5),
    });
    let straight = Straight { distance: Length::from_m(4.0), speed: Speed::from_m_per_s(0.4) };
    let turned = |to_deg: f64, broken_off: bool| {
        verdict("done_is_done", |scene| {
            scene.health(Causes::default()).truth(0.0, 0.0).tell(2, Command::Straight(straight));
            if broken_off {
                scene.report(Report::Aborted { id: 2, reason: AbortReason::Stopped });
            }
            scene.after(5_000).truth(1.7, 0.0).tell(3, Command::Turn(turn));
            scene.after(5_000).truth(to_deg, 0.0).report(Report::Done { id: 3, result });
        })
    };
    assert!(turned(-90.0, false).held && turned(-88.3, false).held);
    assert!(!turned(-91.3, false).held && !turned(-86.9, false).held);
    assert!(!turned(-90.0, true).held, "it begins where the last one was broken off");
}

/// The pose is believed from its command on, but the answer waits until the base has it too.
#[test]
fn a_pose_that_is_being_set_is_no_error() {
    let answered = |id| {
        let verdict = verdict("no_silent_wrong", |scene| {
            scene.health(Causes::default()).truth(0.0, 0.0).state(0.0, 1);
            scene.tell(7, Command::SetPose(Pose::default())).after(100).state(50.0, 2);
            let done = Report::Done { id, result: MissionResult::Applied };
            scene.after(100).report(done).state(50.0, 3);
            scene.after(100).truth(0.6, 0.0).state(50.0, 4);
        });
        verdict.margin
    };
    assert!(answered(7).is_some_and(|margin| near(margin, 0.5)));
    // Until it is answered nothing is judged.
    assert_eq!(answered(8), None);
}

#[test]
fn what_a_lap_did_not_add_is_not_its_error() {
    let offset = margin("no_silent_wrong", |scene| {
        scene.health(Causes::default()).truth(0.0, 0.0).state(50.0, 1);
        scene.after(1_000).truth(0.6, 0.0).state(50.0, 2);
    });
    assert!(near(offset, 0.5));
    let carried = verdict("no_silent_wrong", |scene| {
        scene.health(Causes::default()).truth(0.0, 0.0).state(0.0, 1);
        scene.see(&Seen::Placed).truth(90.0, 0.0).state(0.0, 2).see(&Seen::Placed);
    });
    assert!(carried.held, "{carried:?}");
}

#[test]
fn each_state_that_matters_is_reached_by_its_word() {
    let said = |causes: Causes| Report::Health(Health::new(false, causes));
    let none = Causes::default();
    let aborted = |reason| Report::Aborted { id: 1, reason };
    let cases: [(Sometimes, &[Report]); 14] = [
        (Sometimes::BiasTestRefused, &[aborted(AbortReason::NotAtRest)]),
        (Sometimes::GyroSilent, &[said(Causes { gyro_silent: true, ..none })]),
        (Sometimes::GyroFault, &[said(Causes { gyro_fault: true, ..none })]),
        (Sometimes::SamplesLost, &[said(Causes { samples_lost: true, ..none })]),
        (Sometimes::OverRange, &[said(Causes { gyro_over_range: true, ..none })]),
        (Sometimes::ClockMismatch, &[said(Causes { clock_mismatch: true, ..none })]),
        (Sometimes::BaseSilent, &[said(Causes { base_silent: true, ..none })]),
        (Sometimes::BaseNotReady, &[said(Causes { base_not_ready: true, ..none })]),
        (Sometimes::BaseStoppedItself, &[aborted(AbortReason::BaseCommandTimeout)]),
        (Sometimes::MissionRefused, &[Report::Refused { id: 1, reason: Refusal::Busy }]),
        (Sometimes::MissionAborted, &[aborted(AbortReason::TimedOut)]),
        (Sometimes::PoseNotWritten, &[said(Causes { pose_not_written: true, ..none })]),
        (Sometimes::Overflow, &[said(Causes { overflow: true, ..none })]),
        (Sometimes::Recovered, &[said(Causes { gyro_silent: true, ..none }), said(none)]),
    ];
    for (state, reports) in cases {
        let reached = |reports: &[Report]| {
            verdict(state.name(), |scene| {
                for report in reports {
                    scene.report(*report);
                }
            })
        };
        assert!(reached(reports).held, "{}", state.name());
        assert!(!reached(&[said(none)]).held, "{}", state.name());
        assert_eq!(reached(reports).kind, Kind::Sometimes);
    }
    assert!(
        verdict("bus_off", |scene| {
            scene.see(&Seen::BusOff);
        })
        .held
    );
    let noise = |scene: &mut Scene| {
        scene.gyro().see(&Seen::GyroBytes(&[0xff; 30]));
        for _ in 0..5 {
            scene.gyro();
        }
    };
    assert!(verdict("resynchronised", noise).held);
}

#[test]
fn limits_of_a_property_go_before_those_of_the_bench() {
    let strict = Property::Always(Always::FreshHeading { age_max: Some(Span::from_millis(20)) });
    let mut scene = Scene::new();
    let limits = Limits::of(&Config::new(GyroConfig::default(), None, MotionConfig::default()));
    let asked = [strict.clone(), Property::Sometimes(Sometimes::BusOff), strict];
    scene.monitor = Monitor::new(&asked, Some(&limits), &[]);
    scene.gyro().after(40).velocity(0.1);
    let verdicts = scene.monitor.verdicts(scene.now);
    assert_eq!(verdicts.len(), 2, "asked for twice, judged once");
    assert!(near(verdicts[0].margin.unwrap(), -1.0) && verdicts[1].name == "bus_off");
    assert_eq!(limits.acceleration_max, Acceleration::from_m_per_s2(0.8));
    assert_eq!(limits.steer_braking_min, AngularAcceleration::from_deg_per_s2(15.0));
}
