//! Reference model of a controller that receives commands in any order, without a clock.

use controller::calibration::Calibration;
use controller::health::Level;
use controller::mission::{AbortReason, BiasMethod, Command, HeadingSource, Refusal};
use emulators::base::Transport;
use proptest::prelude::*;
use proptest_state_machine::ReferenceStateMachine;
use tests::rig::Rig;
use wire::units::{Angle, Length, Pose};

/// A command, in common units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Order {
    Straight {
        mm: i32,
    },
    Turn {
        deg: i32,
    },
    BiasTest,
    SetPose {
        x_m: i32,
        y_m: i32,
        deg: i32,
    },
    SetSource(HeadingSource),
    SetMethod(BiasMethod),
    SetCalibration,
    RequestState,
    /// Faster than the base can go.
    TooFast,
}

/// A mission that takes longer than any sequence of steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Long {
    Straight,
    Turn,
    BiasTest,
}

/// A line to the controller that can be cut.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Line {
    Gyro,
    Base,
}

/// One step of a sequence.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Step {
    /// Gives an order and waits for its answer.
    Do(Order),
    /// Begins a long mission and lets it run for a while.
    Begin(Long),
    /// Stops the running mission; the next step follows at once.
    Stop,
    /// Waits long enough for a base to come to rest.
    Wait { ms: u16 },
    /// Cuts a line for a while, then restores it.
    Cut { line: Line, ms: u16 },
}

/// Expected result of the last step.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Expected {
    #[default]
    Nothing,
    /// The order is carried out.
    Done,
    /// It is refused for one of these reasons.
    Refused(Vec<Refusal>),
    /// The long mission runs.
    Runs,
    /// The running mission is broken off.
    Aborted(AbortReason),
}

/// The state of the reference.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    /// How the base is connected.
    pub transport: Transport,
    /// The running long mission.
    pub runs: Option<Long>,
    /// A stop in motion was given a moment ago.
    pub brakes: bool,
    pub source: HeadingSource,
    pub method: BiasMethod,
    /// A bias test has passed.
    pub tested: bool,
    /// The last bias test has failed.
    pub test_failed: bool,
    /// Samples of the gyro were lost since the pose was last set.
    pub samples_lost: bool,
    /// Expected pose estimate; `None` if a motion was broken off or the heading has another source.
    pub pose: Option<Pose>,
    /// Expected result of the last step.
    pub expected: Expected,
}

impl Model {
    const fn new(transport: Transport) -> Self {
        Self {
            transport,
            runs: None,
            brakes: false,
            source: HeadingSource::Gyro,
            method: BiasMethod::StaticTest,
            tested: false,
            test_failed: false,
            samples_lost: false,
            pose: Some(Pose { x: Length::ZERO, y: Length::ZERO, heading: Angle::ZERO }),
            expected: Expected::Nothing,
        }
    }

    fn knows_bias(&self) -> bool {
        match self.method {
            BiasMethod::StaticTest => self.tested,
            // No sequence loads a calibration with a table.
            BiasMethod::TemperatureTable => false,
            BiasMethod::None => true,
        }
    }

    /// Health that must be reported once everything is received again.
    pub fn level(&self) -> Level {
        let doubtful = !self.knows_bias() || self.test_failed || self.samples_lost;
        if doubtful { Level::Degraded } else { Level::Ok }
    }

    /// Returns every reason to refuse an order: it is refused for one of them, or carried out if there are none.
    fn against(&self, order: Order) -> Vec<Refusal> {
        let moves = matches!(order, Order::Straight { .. } | Order::Turn { .. } | Order::TooFast);
        if matches!(order, Order::RequestState | Order::SetMethod(_)) {
            return Vec::new();
        }
        let reasons = [
            (self.runs.is_some(), Refusal::Busy),
            (self.brakes, Refusal::Moving),
            (order == Order::TooFast, Refusal::OutOfRange),
            (moves && self.source == HeadingSource::Gyro && !self.knows_bias(), Refusal::NoBias),
        ];
        reasons.into_iter().filter_map(|(applies, reason)| applies.then_some(reason)).collect()
    }

    fn order(&mut self, order: Order) {
        let against = self.against(order);
        if !against.is_empty() {
            self.expected = Expected::Refused(against);
            return;
        }
        self.expected = Expected::Done;
        match order {
            Order::Straight { mm } => {
                if let Some(pose) = &mut self.pose {
                    let way = Length::from_m(f64::from(mm) / 1e3);
                    pose.x += way * pose.heading.cos();
                    pose.y += way * pose.heading.sin();
                }
            }
            Order::Turn { deg } => {
                if let Some(pose) = &mut self.pose {
                    pose.heading += Angle::from_deg(f64::from(deg));
                }
            }
            Order::BiasTest => {
                (self.tested, self.test_failed) = (true, false);
            }
            Order::SetPose { x_m, y_m, deg } => {
                self.pose = Some(pose(x_m, y_m, deg));
                self.samples_lost = false;
            }
            Order::SetSource(source) => {
                self.source = source;
                self.pose = None;
            }
            Order::SetMethod(method) => self.method = method,
            Order::SetCalibration | Order::RequestState | Order::TooFast => {}
        }
    }

    /// Breaks off the running mission.
    fn abort(&mut self, reason: AbortReason) {
        let Some(ran) = self.runs.take() else { return };
        self.expected = Expected::Aborted(reason);
        if ran == Long::BiasTest {
            self.test_failed = true;
        } else {
            self.pose = None;
        }
    }

    fn cut(&mut self, line: Line, ms: u16) {
        self.brakes = false;
        let (is_long, drives) =
            (ms >= CUT_LONG_MS, matches!(self.runs, Some(Long::Straight | Long::Turn)));
        match line {
            Line::Gyro => {
                let needed = self.runs == Some(Long::BiasTest)
                    || drives && self.source == HeadingSource::Gyro;
                if is_long && needed {
                    self.abort(AbortReason::GyroSilent);
                }
                self.samples_lost = true;
            }
            Line::Base if is_long && drives => self.abort(AbortReason::BaseSilent),
            Line::Base => {}
        }
    }
}

/// A cut of at least this length breaks off what needs the line; the base's time-out in motion is 250 ms, the gyro's
/// 100 ms.
const CUT_LONG_MS: u16 = 400;

/// The pose of a `SetPose`.
pub fn pose(x_m: i32, y_m: i32, deg: i32) -> Pose {
    Pose {
        x: Length::from_m(f64::from(x_m)),
        y: Length::from_m(f64::from(y_m)),
        heading: Angle::from_deg(f64::from(deg)),
    }
}

impl Order {
    /// Converts it to a command of the controller.
    pub fn command(self) -> Command {
        match self {
            Self::Straight { mm } => Rig::straight_order(f64::from(mm) / 1e3, 0.4),
            Self::Turn { deg } => Rig::turn_order(f64::from(deg), 30.0),
            Self::BiasTest => Rig::bias_test_order(1.0),
            Self::SetPose { x_m, y_m, deg } => Command::SetPose(pose(x_m, y_m, deg)),
            Self::SetSource(source) => Command::SetHeadingSource(source),
            Self::SetMethod(method) => Command::SetBiasMethod(method),
            Self::SetCalibration => Command::SetCalibration(Calibration::default()),
            Self::RequestState => Command::RequestState,
            Self::TooFast => Rig::straight_order(1.0, 2.0),
        }
    }
}

impl Long {
    /// Converts it to a command of the controller that takes minutes.
    pub const fn command(self) -> Command {
        match self {
            Self::Straight => Rig::straight_order(100.0, 0.4),
            Self::Turn => Rig::turn_order(7_200.0, 30.0),
            Self::BiasTest => Rig::bias_test_order(600.0),
        }
    }

    const fn as_order(self) -> Order {
        match self {
            Self::Straight => Order::Straight { mm: 0 },
            Self::Turn => Order::Turn { deg: 0 },
            Self::BiasTest => Order::BiasTest,
        }
    }
}

fn orders() -> impl Strategy<Value = Order> {
    let source = prop_oneof![Just(HeadingSource::Gyro), Just(HeadingSource::Odometry)];
    let method = prop_oneof![
        Just(BiasMethod::StaticTest),
        Just(BiasMethod::TemperatureTable),
        Just(BiasMethod::None)
    ];
    let place = (-5..=5, -5..=5, -720..=720);
    prop_oneof![
        3 => (-2_000..=2_000).prop_map(|mm| Order::Straight { mm }),
        4 => (-200..=200).prop_map(|deg| Order::Turn { deg }),
        4 => Just(Order::BiasTest),
        2 => place.prop_map(|(x_m, y_m, deg)| Order::SetPose { x_m, y_m, deg }),
        1 => source.prop_map(Order::SetSource),
        1 => method.prop_map(Order::SetMethod),
        1 => Just(Order::SetCalibration),
        1 => Just(Order::RequestState),
        1 => Just(Order::TooFast),
    ]
}

impl ReferenceStateMachine for Model {
    type State = Self;
    type Transition = Step;

    fn init_state() -> BoxedStrategy<Self> {
        prop_oneof![Just(Transport::Can), Just(Transport::Serial)].prop_map(Self::new).boxed()
    }

    fn transitions(_: &Self) -> BoxedStrategy<Step> {
        let long = prop_oneof![Just(Long::Straight), Just(Long::Turn), Just(Long::BiasTest)];
        let cut = prop_oneof![
            (30_u16..=60).prop_map(|ms| Step::Cut { line: Line::Gyro, ms }),
            (CUT_LONG_MS..=900).prop_map(|ms| Step::Cut { line: Line::Gyro, ms }),
            (50_u16..=150).prop_map(|ms| Step::Cut { line: Line::Base, ms }),
            (CUT_LONG_MS..=900).prop_map(|ms| Step::Cut { line: Line::Base, ms }),
        ];
        prop_oneof![
            8 => orders().prop_map(Step::Do),
            3 => long.prop_map(Step::Begin),
            2 => Just(Step::Stop),
            1 => (3_000_u16..=5_000).prop_map(|ms| Step::Wait { ms }),
            2 => cut,
        ]
        .boxed()
    }

    fn apply(mut model: Self, step: &Step) -> Self {
        model.expected = Expected::Nothing;
        match *step {
            Step::Do(order) => model.order(order),
            Step::Begin(long) => {
                let against = model.against(long.as_order());
                if against.is_empty() {
                    model.runs = Some(long);
                    model.expected = Expected::Runs;
                } else {
                    model.expected = Expected::Refused(against);
                }
            }
            Step::Stop => {
                model.brakes |= matches!(model.runs, Some(Long::Straight | Long::Turn));
                model.abort(AbortReason::Stopped);
            }
            Step::Wait { .. } => model.brakes = false,
            Step::Cut { line, ms } => model.cut(line, ms),
        }
        model
    }
}
