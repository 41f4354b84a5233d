//! Commands in any order, with lines cut in between: the controller beside a reference that says what must be true.
//!
//! The reference (`model.rs`) knows which orders must be refused and why, what breaks off a mission, what health must
//! say and where the robot must believe to be; the properties of a run are watched besides.

mod machine;
mod model;

use controller::Mutant;
use machine::{Machine, SOUND};
use model::Model;
use proptest::test_runner::{Config, RngSeed, TestRunner};
use proptest_state_machine::{ReferenceStateMachine as _, StateMachineTest, prop_state_machine};

/// Most steps of a sequence.
const STEPS_MAX: usize = 16;

prop_state_machine! {
    #![proptest_config(Config { cases: 1_000, ..Config::default() })]

    #[test]
    fn the_controller_does_what_the_reference_says(sequential 1..STEPS_MAX => Machine<SOUND>);
}

/// Does some sequence tell this controller from the reference?
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
    // Without shrinking nobody asks which steps were seen.
    let test = |(model, steps, _)| {
        M::test_sequential(Config::default(), model, steps, None);
        Ok(())
    };
    TestRunner::new(config).run(&sequences, test).is_err()
}

/// The test can fail: it tells controllers with a mistake.
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
