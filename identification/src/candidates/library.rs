//! Named effects (devices of this class, IEEE Std 952 and the odometry of wheeled robots).

use super::cycles::tells_cycles;
use super::names::{acts, constant, over};
use super::{Candidate, Family};
use crate::dataset::{Dimension, Role};
use crate::late::delay_of;
use crate::model::{Acts, Driver, Form, LATE_SHARE, Shape, WHEEL_SIZE, Wrap};
use crate::problem::{Aggregate, Block, Channel, Channels};
use crate::robust;

/// Terms that any driver may change.
pub(super) const OPEN: [Acts; 5] =
    [Acts::Bias, Acts::Scale, Acts::Turn, Acts::Curvature, Acts::Drive];

/// Number of time constants tried for a lag.
const LAGS: usize = 10;
/// Half widths of a hysteresis, as shares of a channel's span.
pub(super) const PLAYS: [f64; 5] = [0.02, 0.05, 0.1, 0.2, 0.35];
/// Delays tried, as multiples of the sample interval.
const DELAYS: [f64; 10] = [-4.0, -2.0, -1.0, -0.4, -0.1, 0.1, 0.4, 1.0, 2.0, 4.0];

pub(super) struct Builder<'a> {
    pub(super) block: &'a Block,
    pub(super) channels: &'a Channels,
    found: Vec<Candidate>,
}

/// Named effects that these data could show.
pub fn library(block: &Block, channels: &Channels) -> Vec<Candidate> {
    // Of a tricycle: one wheel is steered and drives.
    let is_steered = channels.of(Role::SteerAngle).is_some();
    let mut builder = Builder { block, channels, found: Vec::new() };
    for on in OPEN.into_iter().filter(|on| block.exposure(*on).is_some()) {
        if !block.constants.iter().any(|known| known.acts == on) {
            builder.push(Family::Library, Shape::constant(constant(on, is_steered), on));
        }
        if on == Acts::Drive && builder.has_two_wheels() {
            builder.push(Family::Library, Shape::constant(WHEEL_SIZE, on));
        }
        for channel in &channels.channels {
            builder.over_channel(on, channel);
        }
        builder.over_time(on);
        builder.over_rotation(on);
        builder.products(on);
    }
    if block.exposure(Acts::Bias).is_some() {
        builder.rate_errors();
    }
    if block.exposure(Acts::Reference).is_some() {
        let shape = Shape::constant(constant(Acts::Reference, is_steered), Acts::Reference);
        builder.push(Family::Library, shape);
    }
    if block.exposure(Acts::Drive).is_some() {
        builder.slip();
    }
    builder.found
}

impl<'a> Builder<'a> {
    fn push(&mut self, family: Family, shape: Shape) {
        self.found.push(Candidate { shape, family });
    }

    /// Adds a term over a function of a field, with these numbers.
    pub(super) fn add(
        &mut self,
        name: &str,
        on: Acts,
        (wrap, field): (Wrap, &str),
        form: Form,
        numbers: &[(&str, f64)],
    ) {
        let mut shape = Shape::new(name, on, Driver::new(wrap, field), form);
        numbers.iter().for_each(|(name, value)| shape.set(name, *value));
        let remembers = matches!(wrap, Wrap::LagOf | Wrap::BranchOf) || form == Form::Exponential;
        self.push(if remembers { Family::Memory } else { Family::Library }, shape);
    }

    /// Whether a wheel on each side drives and steers.
    fn has_two_wheels(&self) -> bool {
        self.block.pose.as_ref().is_some_and(|pose| pose.half_track.is_some())
    }

    fn over_channel(&mut self, on: Acts, channel: &Channel) {
        match channel.role {
            Role::Heading => return self.over_heading(on, channel),
            Role::SteerAngle => return self.over_steering(on, channel),
            // The axis's own reference is the rotation itself.
            Role::ReferenceRate if channel.name == self.channels.rotation_name => return,
            Role::ReferenceRate | Role::Reference => return self.over_other_axis(on, channel),
            Role::GyroRate | Role::GyroCounts | Role::GyroAngleIncrement => {
                // At rest, all axes share the same heat source.
                let turns = self.block.exposure(Acts::Scale).is_some();
                if turns && channel.name != self.block.label {
                    self.over_other_axis(on, channel);
                }
                return;
            }
            _ => {}
        }
        let (origin, field) = (("origin", origin(channel)), channel.name.as_str());
        let mut add = |wrap, form, numbers: &[(&str, f64)]| {
            self.add(&over(on, channel, wrap, form), on, (wrap, field), form, numbers);
        };
        add(Wrap::Plain, Form::Linear, &[origin]);
        // A bias test yields one number per run: it has no curve and no rate.
        let is_plain = channel.is_angle() || matches!(channel.role, Role::Duration | Role::Bias);
        if is_plain || !channel.has_more_than(2) {
            return;
        }
        add(Wrap::Plain, Form::Quadratic, &[origin]);
        if self.block.aggregate != Aggregate::Row && on != Acts::Bias && on != Acts::Scale {
            // A path of a minute has no measurable thermal memory.
            return;
        }
        let is_temperature = channel.role == Role::Temperature;
        // No known effect depends on jerk.
        if channel.unit.dimension() != Dimension::Acceleration {
            let name = over(on, channel, Wrap::RateOf, Form::Linear);
            let rate = Shape::new(&name, on, Driver::new(Wrap::RateOf, field), Form::Linear);
            self.push(if is_temperature { Family::Library } else { Family::Memory }, rate);
        }
        // What is fed to a sensor warms it, by its power or by the square of a current, and the heat goes as it came: slowly.
        let warms = self.channels.of_sensor && channel.role == Role::Auxiliary && on == Acts::Bias;
        let time_constants = self.time_constants();
        let mut add = |wrap, form, numbers: &[(&str, f64)]| {
            self.add(&over(on, channel, wrap, form), on, (wrap, field), form, numbers);
        };
        if is_temperature {
            add(Wrap::Plain, Form::Cubic, &[origin]);
        }
        let dimension = channel.unit.dimension();
        if dimension == Dimension::Temperature || warms {
            for &constant in &time_constants {
                add(Wrap::LagOf, Form::Linear, &[origin, ("time_constant", constant)]);
            }
        }
        if warms && matches!(dimension, Dimension::Current | Dimension::Voltage) {
            for &constant in &time_constants {
                add(Wrap::LagOf, Form::Quadratic, &[("time_constant", constant)]);
            }
        }
        if dimension == Dimension::Temperature {
            for share in PLAYS {
                let half_width = ("half_width", share * channel.span());
                let through = [half_width, ("through", 1.0), origin];
                add(Wrap::BranchOf, Form::Linear, &through);
                add(Wrap::BranchOf, Form::Linear, &[half_width]);
            }
        }
    }

    /// Cycles of a heading: of the earth's field, or of a wheel that is steered. Toward the ground a robot that steers no
    /// wheel has its slope alone, down which it drifts.
    fn over_heading(&mut self, on: Acts, channel: &Channel) {
        if on == Acts::Drive || self.channels.of_sensor {
            return;
        }
        let is_ground = |one: &Channel| one.name == channel.name;
        // A turn goes through its headings; elsewhere they are those of the rows.
        let goes_round = self.channels.turning.is_some();
        let tells = |order: &u8| goes_round || tells_cycles(*order, &channel.values);
        if self.block.pose.is_some() && self.channels.of(Role::Heading).is_some_and(is_ground) {
            if on == Acts::Curvature && tells(&1) {
                let once = (Wrap::Harmonic(1), channel.name.as_str());
                self.add("ground_slope", on, once, Form::Harmonic, &[]);
            }
            return;
        }
        for wrap in [1, 2].into_iter().filter(tells).map(Wrap::Harmonic) {
            let name = over(on, channel, wrap, Form::Harmonic);
            self.add(&name, on, (wrap, &channel.name), Form::Harmonic, &[]);
        }
    }

    /// A scale error of the steering angle turns the robot in proportion to that angle over the distance.
    fn over_steering(&mut self, on: Acts, channel: &Channel) {
        let (name, form) = match on {
            Acts::Curvature => ("steer_scale", Form::Linear),
            Acts::Drive => ("distance_scale_over_steer_angle", Form::Quadratic),
            _ => return,
        };
        self.add(name, on, (Wrap::Plain, &channel.name), form, &[("origin", 0.0)]);
    }

    /// Cross-axis sensitivity: a rotation about another axis leaks in.
    fn over_other_axis(&mut self, on: Acts, channel: &Channel) {
        if on == Acts::Bias {
            let driver = (Wrap::Plain, channel.name.as_str());
            self.add("misaligned_axis", Acts::Axis, driver, Form::Linear, &[]);
        }
    }

    pub(super) fn time_constants(&self) -> Vec<f64> {
        let (interval, span) = (self.channels.interval(), self.channels.span());
        let (from, to) = ((2.0 * interval).max(span / 500.0), span / 2.0);
        (0..LAGS)
            .map(|i| from * (to / from).powf(i as f64 / (LAGS - 1) as f64))
            .filter(|constant| constant.is_finite() && *constant > 0.0)
            .collect()
    }

    fn over_time(&mut self, on: Acts) {
        let Channels { time, time_name, .. } = self.channels;
        let name = match on {
            Acts::Drive => "tyre_wear".to_owned(),
            _ => format!("{}_ageing", acts(on)),
        };
        let driver = (Wrap::Trend, time_name.as_str());
        self.add(&name, on, driver, Form::Linear, &[("origin", mean(time))]);
        if matches!(on, Acts::Turn | Acts::Drive | Acts::Curvature) {
            // No constant of a plain model takes up where it begins: also what is right when the record begins.
            let (first, _) = robust::ends(time.iter().copied());
            self.add(&name, on, driver, Form::Linear, &[("origin", first)]);
        }
        if matches!(on, Acts::Bias | Acts::Scale) {
            let name = if on == Acts::Bias { "warm_up" } else { "scale_warm_up" };
            for constant in self.time_constants() {
                let numbers = [("time_constant", constant)];
                self.add(name, on, (Wrap::Plain, time_name), Form::Exponential, &numbers);
            }
        }
    }

    fn over_rotation(&mut self, on: Acts) {
        let Channels { rotation, rotation_name, direction_name, of_sensor, .. } = self.channels;
        if rotation.is_empty() {
            return;
        }
        if *of_sensor {
            self.over_reference(on);
            return;
        }
        if on == Acts::Curvature {
            // Nothing leaks into a steering that there is not.
            if self.channels.named("speed").is_some() && !self.has_two_wheels() {
                let driver = (Wrap::Sign, "speed");
                self.add("drive_to_steer_leakage", on, driver, Form::Linear, &[]);
            }
            return;
        }
        let direction = match direction_name {
            Some(name) => (Wrap::Plain, name),
            None => (Wrap::Sign, rotation_name),
        };
        let name = match on {
            Acts::Scale => "direction_asymmetry".to_owned(),
            Acts::Turn => "turn_asymmetry".to_owned(),
            other => format!("{}_over_direction", acts(other)),
        };
        self.add(&name, on, (direction.0, direction.1), Form::Linear, &[]);
        if matches!(on, Acts::Scale | Acts::Turn) {
            let over_rate = format!("{}_over_rate", acts(on));
            self.add(&over_rate, on, (Wrap::Abs, rotation_name), Form::Linear, &[]);
            let squared = format!("{over_rate}_quadratic");
            self.add(&squared, on, (Wrap::Plain, rotation_name), Form::Quadratic, &[]);
        }
    }

    /// Products of two causes.
    fn products(&mut self, on: Acts) {
        let Channels { time, time_name, rotation, rotation_name, .. } = self.channels;
        let Some(temperature) = self.channels.of(Role::Temperature) else {
            return;
        };
        let mut with = |what: &str, other: Driver, origin_2: f64| {
            let name = format!("{}_over_temperature_and_{what}", acts(on));
            let mut shape = Shape::new(&name, on, Driver::plain(&temperature.name), Form::Product);
            shape.drivers.push(other);
            let shape = shape.with("origin", origin(temperature)).with("origin_2", origin_2);
            self.push(Family::Library, shape);
        };
        with("time", Driver::plain(time_name), mean(time));
        if !rotation.is_empty() && on == Acts::Scale {
            let rates: Vec<f64> = rotation.iter().map(|rate| rate.abs()).collect();
            with("rate", Driver::new(Wrap::Abs, rotation_name), mean(&rates));
            // Where only one direction occurs, its sign is a constant.
            let occurs = |sign: f64| rotation.iter().any(|rate| sign * rate > 0.0);
            if occurs(1.0) && occurs(-1.0) {
                with("direction", Driver::new(Wrap::Sign, rotation_name), 0.0);
            }
        }
    }

    /// Rate errors beyond a bias and a scale factor.
    fn rate_errors(&mut self) {
        let Channels { rotation, rotation_name, time_name, .. } = self.channels;
        // What goes with a rotation that says nothing of the readings would only stand for their scale.
        if self.block.exposure(Acts::Scale).is_none() || !rotation.iter().any(|rate| *rate != 0.0) {
            return;
        }
        let driver = (Wrap::Plain, rotation_name.as_str());
        // Nothing happens at a zero that somebody chose, nor as far from it one way as the other.
        if self.channels.rotation_has_zero() {
            for width in self.dead_widths() {
                self.add("dead_zone", Acts::DeadZone, driver, Form::DeadZone, &[("width", width)]);
            }
            let largest = self.largest();
            for share in [0.95, 0.9, 0.8, 0.65, 0.5] {
                let limit = [("limit", share * largest)];
                self.add("saturation", Acts::Saturation, driver, Form::Saturation, &limit);
            }
        }
        if !self.channels.sampled {
            return;
        }
        let interval = self.channels.interval();
        // All that a sensor measures is late, in the unit of its readings.
        let all = self.channels.of_sensor.then_some((LATE_SHARE, self.channels.gain));
        let with_all = |name, value| -> Vec<(&str, f64)> {
            std::iter::once((name, value)).chain(all).collect()
        };
        // One may lie between or beyond them.
        let at_sight = delay_of(self.block, self.channels);
        for delay in DELAYS.map(|multiple| multiple * interval).into_iter().chain(at_sight) {
            self.add("delay", Acts::Delay, driver, Form::Delay, &with_all("delay", delay));
        }
        for multiple in [0.3, 1.0, 3.0, 10.0] {
            let numbers = with_all("time_constant", multiple * interval);
            let lag = (Wrap::LagOf, rotation_name.as_str());
            self.add("bandwidth", Acts::Delay, lag, Form::Delay, &numbers);
        }
        let span = self.channels.span();
        for shift in [-4.0, -0.5, 0.5, 4.0] {
            let numbers = with_all("stretch", shift * interval / span);
            let time = (Wrap::Plain, time_name.as_str());
            self.add("sample_clock", Acts::Clock, time, Form::Delay, &numbers);
        }
    }

    /// Largest rotation, or the largest reading where that is smaller: no reading reaches a limit beyond it.
    fn largest(&self) -> f64 {
        let Channels { rotation, gain, sampled, .. } = self.channels;
        let most = |of: &mut dyn Iterator<Item = f64>| of.fold(0.0, |a: f64, b| a.max(b.abs()));
        let largest = most(&mut rotation.iter().copied());
        if self.block.aggregate != Aggregate::Row || !sampled {
            return largest;
        }
        let count = self.block.raw.len();
        largest.min(most(&mut (0..count).map(|i| self.block.measured(i) / gain)))
    }

    /// Widths of a dead zone: between rates that occur, by rank.
    fn dead_widths(&self) -> Vec<f64> {
        let sizes = self.channels.rotation.iter().map(|rate| rate.abs());
        let mut sizes: Vec<f64> = sizes.filter(|rate| *rate > 0.0).collect();
        sizes.sort_by(f64::total_cmp);
        let mut widths: Vec<f64> = Vec::new();
        for share in [0.005, 0.02, 0.05, 0.1, 0.2, 0.35, 0.5] {
            let at = (sizes.len() as f64 * share) as usize;
            let Some(&size) = sizes.get(at) else { continue };
            // Just beyond that rate.
            let width = size * 1.001;
            if widths.last().is_none_or(|last| width > 1.01 * last) {
                widths.push(width);
            }
        }
        widths
    }

    fn slip(&mut self) {
        let Some(acceleration) = self.channels.named("acceleration") else {
            return;
        };
        let largest = acceleration.range.0.abs().max(acceleration.range.1.abs());
        for share in [0.0, 0.1, 0.25, 0.5] {
            let driver = (Wrap::Abs, "acceleration");
            self.add("slip", Acts::Slip, driver, Form::Hinge, &[("at", share * largest)]);
        }
    }
}

/// Zero of a channel: its middle, rounded to three digits of its span.
fn origin(channel: &Channel) -> f64 {
    let middle = mean(&channel.values);
    let digit = 10_f64.powf((channel.span() / 100.0).log10().floor());
    (middle / digit).round() * digit
}

pub(super) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}
