//! Invariants hold when lines drop, repeat, corrupt or delay traffic.

use emulators::base::Transport;
use judge::properties::{Kind, PropertyVerdict};
use proptest::prelude::*;
use tests::devices::{TRANSPORTS, ideal};
use tests::rig::{Direction, Rig, bytes};
use wire::base::{Motion, Reply, can_link};
use wire::device::Transmit;
use wire::time::Span;
use wire::units::Length;

/// What a line does to its traffic.
#[derive(Debug, Clone, Copy)]
enum Harm {
    Cut,
    Drop,
    Repeat,
    Flip,
    Bunch,
}

/// One fault: its delay after the last, its direction, which pieces it affects (one in so many), and its duration.
#[derive(Debug, Clone)]
struct Fault {
    after: Span,
    direction: Direction,
    harm: Harm,
    every: usize,
    lasts: Span,
}

fn fault() -> impl Strategy<Value = Fault> {
    use Direction::{BaseToController, ControllerToBase, GyroToController};
    let direction =
        prop::sample::select(vec![GyroToController, BaseToController, ControllerToBase]);
    let harm =
        prop::sample::select(vec![Harm::Cut, Harm::Drop, Harm::Repeat, Harm::Flip, Harm::Bunch]);
    (0i64..4_000, direction, harm, 2usize..40, 10i64..3_000).prop_map(
        |(after, direction, harm, every, lasts)| Fault {
            after: Span::from_millis(after),
            direction,
            harm,
            every,
            lasts: Span::from_millis(lasts),
        },
    )
}

/// Half straights, half turns, within the base's limits.
fn order() -> impl Strategy<Value = (f64, f64, bool)> {
    (-1.0f64..1.0, 0.1f64..0.9, any::<bool>())
}

fn apply(rig: &mut Rig, fault: &Fault) {
    rig.run_for(fault.after);
    let (harm, every) = (fault.harm, fault.every);
    let mut count = 0usize;
    let mut held = Vec::new();
    rig.tap(fault.direction, move |_, piece| {
        count += 1;
        let hit = count.is_multiple_of(every);
        match (harm, piece) {
            (Harm::Cut, _) => Vec::new(),
            (Harm::Drop, _) if hit => Vec::new(),
            (Harm::Repeat, piece) if hit => vec![piece, piece],
            (Harm::Flip, Transmit::Bytes(packet)) if hit => {
                let mut flipped = packet.as_slice().to_vec();
                let at = count % flipped.len();
                flipped[at] ^= 1 << (count % 8);
                bytes(&flipped)
            }
            (Harm::Bunch, piece) => {
                held.push(piece);
                if hit { std::mem::take(&mut held) } else { Vec::new() }
            }
            (_, piece) => vec![piece],
        }
    });
    rig.run_for(fault.lasts);
    rig.untap(fault.direction);
}

fn broken(rig: Rig) -> Vec<PropertyVerdict> {
    let mut verdicts = rig.verdicts();
    verdicts.retain(|verdict| verdict.kind == Kind::Always && !verdict.held);
    verdicts
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    #[test]
    fn every_always_property_holds(
        transport in prop::sample::select(TRANSPORTS.to_vec()),
        missions in prop::collection::vec((order(), prop::collection::vec(fault(), 0..3)), 1..4),
    ) {
        let mut rig = Rig::new(&ideal(transport), 1).ready();
        for ((size, rate, straight), faults) in &missions {
            let id = rig.begin(if *straight {
                Rig::straight_order(2.0 * size, 0.8 * rate)
            } else {
                Rig::turn_order(400.0 * size, 120.0 * rate)
            });
            faults.iter().for_each(|fault| apply(&mut rig, fault));
            rig.finish(id);
            rig.run_for(Span::from_secs(2));
        }
        rig.run_for(Span::from_secs(6));
        let broken = broken(rig);
        prop_assert!(broken.is_empty(), "{:#?}", broken);
    }
}

/// An answer that is out of step reads like this if its one checksum byte happens to match.
#[test]
fn a_path_that_no_base_could_have_gone_moves_no_pose() {
    let mut rig = Rig::new(&ideal(Transport::Can), 1).ready();
    let id = rig.under_way(Rig::straight_order(2.0, 0.4), Span::from_secs(3));
    let displacement = Length::from_m(248.8);
    let motion = Motion { displacement, moving: true, ..Motion::default() };
    let frame = can_link::reply_frame(&Reply::Motion(motion));
    rig.inject(Direction::BaseToController, &Transmit::Frame(frame));
    rig.finish(id);
    let state = rig.state();
    assert!((state.pose.x.m() - 2.0).abs() < 0.003, "{:?}", state.pose);
    let broken = broken(rig);
    assert!(broken.is_empty(), "{broken:#?}");
}
