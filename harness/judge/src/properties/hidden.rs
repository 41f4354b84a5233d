//! What faults hide from every input of the controller, and for how long: the world as its inputs show it.
//!
//! Each property is judged twice, by the real world and by this one. What is broken in the real one alone, no input shows.
//! A kind of fault is no excuse, and a controller that is wrong by more than was hidden breaks both.
//!
//! | hidden | only |
//! |---|---|
//! | the path by which wheels turn further than the base moves | this path |
//! | the angle of a bias that leaps during a drive | until it is there at a standstill, where the gyro reads its bias, and while gyro and odometry differ by no more than the odometry may err |
//! | an order changed past checksum or CRC, or carried out after it was withdrawn | while the base obeys it |
//! | the time that the order in force was on its way | this time |
//! | a message of the base that was changed like that | until the next two: one alone may be doubted, by what the changed one said |

use super::seen::Truth;
use std::collections::VecDeque;
use wire::base::Request;
use wire::time::{Span, Timestamp};
use wire::units::{Angle, AngularRate, Length, Pose, Speed};

/// Difference of gyro and odometry over a drive of any base: three steps of the K2A's heading of 0.3 deg.
const APART_MAX: Angle = Angle::from_deg(1.0);
/// The same per turn and metre of a base that is not known yet: somewhat more than twice the errors of the paper's own,
/// 1.1 % and 0.125 deg/m. One that has turned by [`TURN_KNOWN`], or gone [`PATH_KNOWN`], in earlier drives is known.
const APART_PER_TURN: f64 = 0.025;
const APART_DEG_PER_M: f64 = 0.25;
const TURN_KNOWN: Angle = Angle::from_deg(45.0);
const PATH_KNOWN: Length = Length::from_m(2.0);
/// In motion the two are compared up to this much late: an exchange on the serial line, and the silence that a gyro may keep.
const LATE: Span = Span::from_millis(160);
/// A standstill of this length shows a bias that has leapt: a base settles for as long.
const SHOWS_AFTER: Span = Span::from_millis(300);
/// A bias that moves by less is the drift of the data sheet.
const DRIFT: AngularRate = AngularRate::from_deg_per_s(0.005);
/// An order that another has followed is withdrawn after this time. Assumption: longer than any exchange.
const WITHDRAWN_AFTER: Span = Span::from_millis(100);
/// Time that an order may be on its way without a fault: an exchange on the serial line.
const USUAL: Span = Span::from_millis(60);
/// Messages that correct a changed one: a path that no base could have gone takes a second one to be believed.
const CONFIRMED_BY: u8 = 2;
/// Most remembered orders; an older one counts as changed.
const SENT_MAX: usize = 512;

/// What is hidden now.
#[derive(Debug, Clone, Default)]
pub(super) struct Hidden {
    last: Option<(Timestamp, Truth)>,
    /// Where the base would be had its wheels not slipped, minus where it is.
    slid: (f64, f64),
    leap: Leap,
    orders: Orders,
    /// How many more messages of the base it takes until none that was changed on its way counts.
    misheard: u8,
    /// Such a message came at some time.
    was_misheard: bool,
}

/// The angle by which the bias has leapt, and whether the inputs show it.
#[derive(Debug, Clone, Default)]
struct Leap {
    angle: Angle,
    /// Where the base would be had it turned as the gyro did, minus where it is.
    led: (f64, f64),
    shown: bool,
    at_rest: Span,
    drive: Option<Drive>,
    /// What the base did in earlier drives.
    turned: Angle,
    path: Length,
}

/// The drive under way.
#[derive(Debug, Clone, Copy)]
struct Drive {
    heading: Angle,
    leapt: Angle,
    odometry: Angle,
    turned: Angle,
    path: Length,
    lasted: Span,
}

/// Orders of the controller, and which of them the base obeys.
#[derive(Debug, Clone, Default)]
struct Orders {
    sent: VecDeque<(Timestamp, Request)>,
    velocity_astray: bool,
    ramps_astray: bool,
    /// One of them was at some time, or late.
    were_astray: bool,
    /// How long the velocity that the base obeys was on its way, if that is unusual.
    late: Span,
    /// The order that replaced a stray one, until the base goes as it says.
    settles: Option<(Speed, AngularRate)>,
}

impl Hidden {
    /// The truth at `now`; `said` is the base's heading if it was heard just now, and whether it is known to stand.
    pub(super) fn truth(&mut self, now: Timestamp, truth: &Truth, said: (Option<Angle>, bool)) {
        self.orders.settle(truth);
        let Some((then, last)) = self.last.replace((now, *truth)) else { return };
        let passed = now - then;
        let heading = last.pose.heading.rad().midpoint(truth.pose.heading.rad());
        let slid = ((last.wheels - last.speed) + (truth.wheels - truth.speed)) * 0.5 * passed;
        let (x, y) = (slid.m() * heading.cos(), slid.m() * heading.sin());
        self.slid = (self.slid.0 + x, self.slid.1 + y);
        let went = ((truth.pose.x - last.pose.x).m() + x, (truth.pose.y - last.pose.y).m() + y);
        self.leap.go_on(passed, went, (&last, truth), said);
    }

    /// The base is placed by hand: nothing of what was hidden before counts.
    pub(super) fn placed(&mut self) {
        self.last = None;
        self.slid = (0.0, 0.0);
        self.leap.forget();
    }

    /// A pose was set.
    pub(super) fn pose_is_set(&mut self) {
        self.leap.forget();
    }

    /// A message of the base has come, changed on its way or as it was sent.
    pub(super) const fn hears(&mut self, misheard: bool) {
        self.misheard = if misheard { CONFIRMED_BY } else { self.misheard.saturating_sub(1) };
        self.was_misheard |= misheard;
    }

    /// A changed message of the base is believed.
    pub(super) const fn is_misheard(&self) -> bool {
        self.misheard > 0
    }

    /// The controller sent this.
    pub(super) fn sent(&mut self, now: Timestamp, request: Request) {
        if self.orders.sent.len() == SENT_MAX {
            self.orders.sent.pop_front();
        }
        self.orders.sent.push_back((now, request));
    }

    /// The base received this.
    pub(super) fn carried(&mut self, now: Timestamp, request: Request) {
        self.orders.carried(now, request);
    }

    /// The base obeys an order that the controller did not give, or has withdrawn.
    pub(super) fn is_astray(&self) -> bool {
        self.orders.velocity_astray || self.orders.settles.is_some()
    }

    /// Or speeds up and brakes by ramps that it did not give.
    pub(super) fn has_stray_ramps(&self) -> bool {
        self.orders.ramps_astray || self.is_astray()
    }

    /// How long the velocity that the base obeys was on its way, if that is unusual.
    pub(super) const fn order_late(&self) -> Span {
        self.orders.late
    }

    /// The truth as the inputs show it, if that is another.
    pub(super) fn apparent(&self) -> Option<Truth> {
        let (_, truth) = self.last?;
        let slips = self.slid != (0.0, 0.0) || truth.wheels != truth.speed;
        let (led, angle) = match self.leap.is_hidden() {
            true => (self.leap.led, self.leap.angle),
            false if slips => ((0.0, 0.0), Angle::ZERO),
            false => return None,
        };
        let pose = Pose {
            x: truth.pose.x + Length::from_m(self.slid.0 + led.0),
            y: truth.pose.y + Length::from_m(self.slid.1 + led.1),
            heading: truth.pose.heading + angle,
        };
        Some(Truth { pose, speed: truth.wheels, ..truth })
    }

    /// Whether anything is hidden.
    pub(super) fn is_any(&self) -> bool {
        self.is_misheard()
            || self.has_stray_ramps()
            || self.orders.late > Span::ZERO
            || self.apparent().is_some()
    }

    /// What is or was hidden, as it is shown to people.
    pub(super) fn names(&self) -> String {
        let (x, y) = self.slid;
        let slips = self.last.is_some_and(|(_, truth)| truth.wheels != truth.speed);
        let slid = (slips || self.slid != (0.0, 0.0))
            .then(|| format!("wheel_slip of {:.3} m", x.hypot(y)));
        let leapt = (self.leap.is_hidden()).then(|| {
            let deg = self.leap.angle.deg();
            format!("a bias that leapt by {deg:.2} deg, no more than the odometry may err")
        });
        let astray =
            (self.orders.were_astray).then(|| "an order changed on its way or late".into());
        let misheard = self.was_misheard.then(|| "a message changed on its way".into());
        let names: Vec<String> = [slid, leapt, astray, misheard].into_iter().flatten().collect();
        names.join(" and ")
    }
}

impl Leap {
    fn is_hidden(&self) -> bool {
        !self.shown && self.angle != Angle::ZERO
    }

    fn forget(&mut self) {
        let Self { turned, path, .. } = *self;
        *self = Self { turned, path, ..Self::default() };
    }

    fn go_on(
        &mut self,
        passed: Span,
        (x, y): (f64, f64),
        (last, truth): (&Truth, &Truth),
        (odometry, rests): (Option<Angle>, bool),
    ) {
        let by = truth.leapt - last.leapt;
        let (sin, cos) = ((self.angle + by * 0.5).sin(), (self.angle + by * 0.5).cos());
        self.led.0 += x * cos - y * sin - x;
        self.led.1 += x * sin + y * cos - y;
        self.angle += by;
        if !truth.is_moving() && !last.is_moving() {
            if rests && by.abs() > DRIFT * passed {
                self.at_rest += passed;
                self.shown |= self.at_rest >= SHOWS_AFTER;
            }
            if let (Some(drive), Some(_)) = (&self.drive, odometry) {
                self.turned += drive.turned;
                self.path += drive.path;
                self.drive = None;
            }
        }
        if self.drive.is_none()
            && truth.is_moving()
            && let Some(odometry) = odometry
        {
            let (turned, path, lasted) = (Angle::ZERO, Length::ZERO, Span::ZERO);
            let heading = last.pose.heading;
            let leapt = last.leapt;
            self.drive = Some(Drive { heading, leapt, odometry, turned, path, lasted });
        }
        let Some(drive) = &mut self.drive else { return };
        // The inputs show the turn of the gyro, and that of the base by its odometry.
        let turned = truth.pose.heading - drive.heading;
        let gyro = turned + (truth.leapt - drive.leapt);
        drive.turned = drive.turned.max(turned.abs()).max(gyro.abs());
        drive.path += Length::from_m(x.hypot(y));
        drive.lasted += passed;
        let Some(odometry) = odometry else { return };
        let apart = (gyro - (odometry - drive.odometry)).wrapped().abs();
        // The bias in force may be off by the drift of the data sheet.
        let mut most = APART_MAX + truth.steer_rate.abs() * LATE + DRIFT * drive.lasted;
        if self.turned < TURN_KNOWN {
            most += drive.turned * APART_PER_TURN;
        }
        if self.path < PATH_KNOWN {
            most += Angle::from_deg(APART_DEG_PER_M * drive.path.m());
        }
        self.shown |= apart > most && drive.leapt != truth.leapt;
    }
}

impl Orders {
    fn carried(&mut self, now: Timestamp, request: Request) {
        let sent = self.sent.iter().rev().find(|(_, sent)| *sent == request);
        match request {
            Request::SetVelocity { .. } | Request::Stop => {
                let moves = |request: &Request| {
                    matches!(request, Request::SetVelocity { .. } | Request::Stop)
                };
                let newest = self.sent.iter().rev().find(|(_, sent)| moves(sent));
                let withdrawn = |(at, order): &(Timestamp, Request)| {
                    newest.is_some_and(|(_, newest)| newest != order) && now - *at > WITHDRAWN_AFTER
                };
                let astray = sent.is_none_or(withdrawn);
                if self.velocity_astray && !astray {
                    self.settles = Some(match request {
                        Request::SetVelocity { drive, steer } => (drive, steer),
                        _ => (Speed::ZERO, AngularRate::ZERO),
                    });
                } else if astray {
                    self.settles = None;
                }
                self.velocity_astray = astray;
                let late = sent.map_or(Span::ZERO, |(at, _)| now - *at);
                self.late = if late > USUAL { late } else { Span::ZERO };
            }
            Request::SetAcceleration { .. } => self.ramps_astray = sent.is_none(),
            Request::WritePose { .. } | Request::ReadMotion | Request::ReadPose => {}
        }
        self.were_astray |= self.velocity_astray || self.ramps_astray || self.late > Span::ZERO;
    }

    /// A base that a stray order moved is given the time to follow the next one.
    fn settle(&mut self, truth: &Truth) {
        let follows = |(drive, steer): (Speed, AngularRate)| {
            truth.wheels.abs() <= drive.abs() * super::TRUE_OVER_COMMANDED_MAX
                && truth.steer_rate.abs() <= steer.abs() * super::TRUE_OVER_COMMANDED_MAX
        };
        self.settles = self.settles.filter(|order| !follows(*order));
    }
}
