//! Commands in any order, with lines cut in between: the controller against a reference model.
//!
//! The reference (`model.rs`) states which orders must be refused and why, what breaks off a mission, the health that
//! must be reported and the pose that the robot must estimate; the properties of a run are watched too.

mod machine;
mod model;

use controller::Mutant;
use machine::{Machine, SOUND};
use model::Model;
use proptest::test_runner::{Config, RngSeed, TestRunner};
use proptest_state_machine::{ReferenceStateMachine as _, StateMachineTest, prop_state_machine};

/// Maximum steps of a sequence.
const STEPS_MAX: usize = 16;

prop_state_machine! {
    #![proptest_config(Config { cases: 1_000, ..Config::default() })]

    #[test]
    fn the_controller_does_what_the_reference_says(sequential 1..STEPS_MAX => Machine<SOUND>);
}

/// Whether some sequence distinguishes this controller from the reference.
fn is_told<M: StateMachineTest<Reference = Model>>() -> bool {
    let seed = RngSeed::Fixed(1);
    let config = Config {
        cases: 1_000,
        max_shrink_iters: 0,
        failure_persistence: None,
        rng_seed: seed,
        ..Config::default()
    };
    let sequences = Model::sequential_strategy(1..STEPS_MAX);
    // The counter of steps taken is needed only for shrinking.
    let test = |(model, steps, _)| {
        M::test_sequential(Config::default(), model, steps, None);
        Ok(())
    };
    TestRunner::new(config).run(&sequences, test).is_err()
}

/// The test can fail: it detects mutants of the controller.
#[test]
fn mistakes_are_told() {
    macro_rules! told {
        ($($place:literal = $mutant:ident),* $(,)?) => {
            $(
                assert_eq!(Mutant::ALL[$place], Mutant::$mutant);
                assert!(is_told::<Machine<$place>>(), "{}", Mutant::$mutant.name());
            )*
        };
    }
    told!(
        0 = StaleHeading,
        2 = WatchdogOffByTen,
        3 = BiasTestWhileMoving,
        4 = WrapAt360,
        6 = PoseWrittenInMotion,
    );
}
