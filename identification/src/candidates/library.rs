//! Named effects (devices of this class, IEEE Std 952 and the odometry of wheeled robots).

use super::names::{acts, constant, over};
use super::{Candidate, Family};
use crate::dataset::{Dimension, Role};
use crate::late::delay_of;
use crate::model::{Acts, Driver, Form, Shape, WHEEL_SIZE, Wrap, exposure};
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

impl Builder<'_> {
    pub(super) fn push(&mut self, family: Family, shape: Shape) {
        self.found.push(Candidate { shape, family });
    }

    /// Whether a wheel on each side drives and steers.
    fn has_two_wheels(&self) -> bool {
        self.block.pose.as_ref().is_some_and(|pose| pose.half_track.is_some())
    }

    fn over_channel(&mut self, on: Acts, channel: &Channel) {
        let origin = origin(channel);
        let name = |wrap, form| over(on, channel, wrap, form);
        let driver = |wrap| Driver::new(wrap, &channel.name);
        if channel.role == Role::Heading {
            self.over_heading(on, channel);
            return;
        }
        if channel.role == Role::SteerAngle {
            self.over_steering(on, channel);
            return;
        }
        if channel.role == Role::ReferenceRate {
            // The axis's own reference is the rotation itself.
            if on == Acts::Bias && channel.name != self.channels.rotation_name {
                let driver = Driver::plain(&channel.name);
                let shape = Shape::new("misaligned_axis", Acts::Axis, driver, Form::Linear);
                self.push(Family::Library, shape);
            }
            return;
        }
        if matches!(channel.role, Role::GyroRate | Role::GyroCounts | Role::GyroAngleIncrement) {
            self.other_axis(on, channel);
            return;
        }
        let plain = |form| Shape::new(&name(Wrap::Plain, form), on, driver(Wrap::Plain), form);
        self.push(Family::Library, plain(Form::Linear).with("origin", origin));
        // A bias test yields one number per run: it has no curve and no rate.
        if channel.is_angle() || matches!(channel.role, Role::Duration | Role::Bias) {
            return;
        }
        if !channel.has_more_than(2) {
            return;
        }
        self.push(Family::Library, plain(Form::Quadratic).with("origin", origin));
        if self.block.aggregate != Aggregate::Row && on != Acts::Bias && on != Acts::Scale {
            // A path of a minute has no measurable thermal memory.
            return;
        }
        let is_temperature = channel.role == Role::Temperature;
        // No known effect depends on jerk.
        if channel.unit.dimension() != Dimension::Acceleration {
            let wrap = Wrap::RateOf;
            let rate = Shape::new(&name(wrap, Form::Linear), on, driver(wrap), Form::Linear);
            self.push(if is_temperature { Family::Library } else { Family::Memory }, rate);
        }
        if is_temperature {
            self.push(Family::Library, plain(Form::Cubic).with("origin", origin));
        }
        if channel.unit.dimension() == Dimension::Temperature {
            for constant in self.time_constants() {
                let shape = Shape::new(
                    &name(Wrap::LagOf, Form::Linear),
                    on,
                    driver(Wrap::LagOf),
                    Form::Linear,
                );
                self.push(
                    Family::Memory,
                    shape.with("origin", origin).with("time_constant", constant),
                );
            }
            for share in PLAYS {
                let shape = Shape::new(
                    &name(Wrap::BranchOf, Form::Linear),
                    on,
                    driver(Wrap::BranchOf),
                    Form::Linear,
                );
                let shape = shape.with("half_width", share * channel.span());
                self.push(
                    Family::Memory,
                    shape.clone().with("through", 1.0).with("origin", origin),
                );
                self.push(Family::Memory, shape);
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
        let harmonic = |name: &str, wrap| {
            Shape::new(name, on, Driver::new(wrap, &channel.name), Form::Harmonic)
        };
        if self.block.pose.is_some() && self.channels.of(Role::Heading).is_some_and(is_ground) {
            if on == Acts::Curvature {
                self.push(Family::Library, harmonic("ground_slope", Wrap::Harmonic(1)));
            }
            return;
        }
        for wrap in [Wrap::Harmonic(1), Wrap::Harmonic(2)] {
            self.push(Family::Library, harmonic(&over(on, channel, wrap, Form::Harmonic), wrap));
        }
    }

    /// A scale error of the steering angle turns the robot in proportion to that angle over the distance.
    fn over_steering(&mut self, on: Acts, channel: &Channel) {
        let driver = Driver::plain(&channel.name);
        let shape = match on {
            Acts::Curvature => Shape::new("steer_scale", on, driver, Form::Linear),
            Acts::Drive => {
                Shape::new("distance_scale_over_steer_angle", on, driver, Form::Quadratic)
            }
            _ => return,
        };
        self.push(Family::Library, shape.with("origin", 0.0));
    }

    /// Cross-axis sensitivity: a rotation about another axis leaks in.
    fn other_axis(&mut self, on: Acts, channel: &Channel) {
        // At rest, all axes share the same heat source.
        let turns = self.block.exposure(Acts::Scale).is_some();
        if on == Acts::Bias && turns && channel.name != self.block.label {
            let shape = Shape::new(
                "misaligned_axis",
                Acts::Axis,
                Driver::plain(&channel.name),
                Form::Linear,
            );
            self.push(Family::Library, shape);
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
        let time = self.channels.time_name.clone();
        let middle = mean(&self.channels.time);
        let is_wear = on == Acts::Drive;
        let trend_name =
            if is_wear { "tyre_wear".to_owned() } else { format!("{}_ageing", acts(on)) };
        let trend = Shape::new(&trend_name, on, Driver::new(Wrap::Trend, &time), Form::Linear);
        self.push(Family::Library, trend.clone().with("origin", middle));
        if matches!(on, Acts::Turn | Acts::Drive | Acts::Curvature) {
            // No constant of a plain model takes up where it begins: also what is right when the record begins.
            let (first, _) = robust::ends(self.channels.time.iter().copied());
            self.push(Family::Library, trend.with("origin", first));
        }
        if matches!(on, Acts::Bias | Acts::Scale) {
            let name = if on == Acts::Bias { "warm_up" } else { "scale_warm_up" };
            for constant in self.time_constants() {
                let shape = Shape::new(name, on, Driver::plain(&time), Form::Exponential);
                self.push(Family::Memory, shape.with("time_constant", constant));
            }
        }
    }

    fn over_rotation(&mut self, on: Acts) {
        if self.channels.rotation.is_empty() {
            return;
        }
        if self.channels.of_sensor {
            self.over_reference(on);
            return;
        }
        let direction = match &self.channels.direction_name {
            Some(name) => Driver::plain(name),
            None => Driver::new(Wrap::Sign, &self.channels.rotation_name),
        };
        let rotation = Driver::rotation(self.channels);
        let size = Driver::new(Wrap::Abs, &self.channels.rotation_name);
        if on == Acts::Curvature {
            // Nothing leaks into a steering that there is not.
            if self.channels.named("speed").is_some() && !self.has_two_wheels() {
                let driver = Driver::new(Wrap::Sign, "speed");
                let shape = Shape::new("drive_to_steer_leakage", on, driver, Form::Linear);
                self.push(Family::Library, shape);
            }
            return;
        }
        let name = match on {
            Acts::Scale => "direction_asymmetry".to_owned(),
            Acts::Turn => "turn_asymmetry".to_owned(),
            other => format!("{}_over_direction", acts(other)),
        };
        self.push(Family::Library, Shape::new(&name, on, direction, Form::Linear));
        if matches!(on, Acts::Scale | Acts::Turn) {
            let over_rate = format!("{}_over_rate", acts(on));
            self.push(Family::Library, Shape::new(&over_rate, on, size, Form::Linear));
            let squared = format!("{over_rate}_quadratic");
            self.push(Family::Library, Shape::new(&squared, on, rotation, Form::Quadratic));
        }
    }

    /// Products of two causes.
    fn products(&mut self, on: Acts) {
        let Some(temperature) = self.channels.of(Role::Temperature) else {
            return;
        };
        let (name, origin) = (temperature.name.clone(), origin(temperature));
        let mut with = |what: &str, other: Driver, origin_2: f64| {
            let mut shape = Shape::new(
                &format!("{}_over_temperature_and_{what}", acts(on)),
                on,
                Driver::plain(&name),
                Form::Product,
            );
            shape.drivers.push(other);
            self.found.push(Candidate {
                shape: shape.with("origin", origin).with("origin_2", origin_2),
                family: Family::Library,
            });
        };
        with("time", Driver::plain(&self.channels.time_name), mean(&self.channels.time));
        if !self.channels.rotation.is_empty() && on == Acts::Scale {
            let rates: Vec<f64> = self.channels.rotation.iter().map(|rate| rate.abs()).collect();
            with("rate", Driver::new(Wrap::Abs, &self.channels.rotation_name), mean(&rates));
            // Where only one direction occurs, its sign is a constant.
            let occurs = |sign: f64| self.channels.rotation.iter().any(|rate| sign * rate > 0.0);
            if occurs(1.0) && occurs(-1.0) {
                with("direction", Driver::new(Wrap::Sign, &self.channels.rotation_name), 0.0);
            }
        }
    }

    /// Rate errors beyond a bias and a scale factor.
    fn rate_errors(&mut self) {
        if self.channels.rotation.is_empty() {
            return;
        }
        let rotation = Driver::rotation(self.channels);
        let largest = self.channels.rotation.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        if !(largest > 0.0) {
            return;
        }
        for width in self.dead_widths() {
            let shape = Shape::new("dead_zone", Acts::DeadZone, rotation.clone(), Form::DeadZone);
            self.push(Family::Library, shape.with("width", width));
        }
        for share in [0.95, 0.9, 0.8, 0.65, 0.5] {
            let shape =
                Shape::new("saturation", Acts::Saturation, rotation.clone(), Form::Saturation);
            self.push(Family::Library, shape.with("limit", share * largest));
        }
        if self.block.exposure(Acts::Scale).is_none() || !self.channels.sampled {
            return;
        }
        let interval = self.channels.interval();
        for multiple in DELAYS {
            let shape = Shape::new("delay", Acts::Delay, rotation.clone(), Form::Delay);
            self.push(Family::Library, shape.with("delay", multiple * interval));
        }
        // One that lies between or beyond them.
        if let Some(late) = delay_of(self.block, self.channels) {
            let shape = Shape::new("delay", Acts::Delay, rotation.clone(), Form::Delay);
            self.push(Family::Library, shape.with("delay", late));
        }
        for multiple in [0.3, 1.0, 3.0, 10.0] {
            let driver = Driver::new(Wrap::LagOf, &self.channels.rotation_name);
            let shape = Shape::new("bandwidth", Acts::Delay, driver, Form::Delay);
            self.push(Family::Memory, shape.with("time_constant", multiple * interval));
        }
        let span = self.channels.span();
        for shift in [-4.0, -0.5, 0.5, 4.0] {
            let driver = Driver::plain(&self.channels.time_name);
            let shape = Shape::new("sample_clock", Acts::Clock, driver, Form::Delay);
            self.push(Family::Library, shape.with("stretch", shift * interval / span));
        }
    }

    /// Widths of a dead zone: between rates that occur, by rank.
    fn dead_widths(&self) -> Vec<f64> {
        let mut sizes: Vec<f64> = self
            .channels
            .rotation
            .iter()
            .map(|rate| rate.abs())
            .filter(|rate| *rate > 0.0)
            .collect();
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
            let driver = Driver::new(Wrap::Abs, "acceleration");
            let shape = Shape::new("slip", Acts::Slip, driver, Form::Hinge);
            self.push(Family::Library, shape.with("at", share * largest));
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

/// Whether the block has terms that act so.
pub(super) fn is_open(block: &Block, on: Acts) -> bool {
    exposure(block, on).is_some()
}
