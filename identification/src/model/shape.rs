//! A term without its linear coefficients: its shape over the rows.

use super::see::{Field, Fixed, field, fixed, fixed_or, heat, is_noise, see};
use super::spline::{REACH, cardinal, hats};
use super::{Acts, Driver, Form, Wrap, beside};
use crate::dataset::Role;
use crate::problem::{Aggregate, Block, Channels, Exposure, Over};
use crate::robust;
use crate::signal::{interpolate_along, since_before};
use std::f64::consts::TAU;

/// Name of the number of a delay that says how much of what is measured is late: all of it, its scale error included.
pub const LATE_SHARE: &str = "share";

/// Names of the numbers that hold the observed range of each driver.
pub const SEEN: [[&str; 2]; 2] = [["seen_from", "seen_to"], ["seen_from_2", "seen_to_2"]];

/// A term without its coefficients.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    /// Standard name.
    pub name: String,
    /// Whether the library names it.
    pub known: bool,
    /// What it acts on.
    pub acts: Acts,
    /// Its drivers.
    pub drivers: Vec<Driver>,
    /// How it depends on them.
    pub form: Form,
    /// Knots, SI.
    pub knots: Vec<f64>,
    /// Knots over the second driver, SI.
    pub knots_2: Vec<f64>,
    /// Its other numbers, SI.
    pub fixed: Fixed,
}

impl Shape {
    /// A library term over one driver.
    pub fn new(name: &str, acts: Acts, driver: Driver, form: Form) -> Self {
        Self {
            name: name.to_owned(),
            known: true,
            acts,
            drivers: vec![driver],
            form,
            knots: Vec::new(),
            knots_2: Vec::new(),
            fixed: Fixed::new(),
        }
    }

    /// A constant.
    pub fn constant(name: &str, acts: Acts) -> Self {
        Self { drivers: Vec::new(), ..Self::new(name, acts, Driver::plain("time"), Form::Constant) }
    }

    /// Adds a number.
    #[must_use]
    pub fn with(mut self, name: &str, value: f64) -> Self {
        self.set(name, value);
        self
    }

    /// Marks it as unnamed by any library.
    #[must_use]
    pub fn unnamed(mut self) -> Self {
        self.known = false;
        self
    }

    /// Changes a number.
    pub fn set(&mut self, name: &str, value: f64) {
        match self.fixed.iter_mut().find(|(key, _)| key == name) {
            Some((_, old)) => *old = value,
            None => self.fixed.push((name.to_owned(), value)),
        }
    }

    /// A number.
    pub fn number(&self, name: &str) -> Option<f64> {
        fixed(&self.fixed, name)
    }

    /// Numbers that the data can determine but the columns are not linear in.
    pub fn nonlinear(&self) -> Vec<&'static str> {
        let mut found = Vec::new();
        for driver in &self.drivers {
            match driver.wrap {
                Wrap::LagOf => found.push("time_constant"),
                Wrap::BranchOf => found.push("half_width"),
                _ => {}
            }
        }
        match self.form {
            Form::Exponential => found.push("time_constant"),
            Form::Periodic => found.push("period"),
            Form::Step | Form::Hinge => found.push("at"),
            Form::Bump | Form::Tanh => found.extend(["centre", "width"]),
            Form::DeadZone => found.push("width"),
            Form::Saturation => found.push("limit"),
            Form::Product if !self.known => found.extend(["origin", "origin_2"]),
            _ => {}
        }
        found
    }

    /// Whether its contribution depends on the past.
    pub fn remembers(&self) -> bool {
        let wraps = [Wrap::RateOf, Wrap::LagOf, Wrap::BranchOf];
        self.form == Form::Delay || self.drivers.iter().any(|driver| wraps.contains(&driver.wrap))
    }

    /// Whether it equals `other` up to its numbers.
    pub fn says(&self, other: &Self) -> bool {
        self.acts == other.acts && self.form == other.form && self.drivers == other.drivers
    }

    /// Number of coefficients.
    pub fn width(&self) -> usize {
        match self.form {
            Form::Harmonic | Form::Periodic => 2,
            Form::Spline => self.knots.len(),
            Form::Surface => self.knots.len() * self.knots_2.len(),
            _ => 1,
        }
    }

    /// Whether it extrapolates beyond the observed range of its drivers. A law of the sensor itself, and not of its
    /// surroundings, does; a shape with knots, waves or two levels does not.
    fn extrapolates(&self) -> bool {
        matches!(
            self.form,
            Form::Linear
                | Form::Quadratic
                | Form::Cubic
                | Form::Exponential
                | Form::Hinge
                | Form::Bump
                | Form::Tanh
                | Form::Product
        ) && self.acts != Acts::Axis
            && !self.is_heat()
    }

    /// Adds the range in which `channels` show its drivers: a fitted curve is held beyond it.
    #[must_use]
    pub fn within_seen(mut self, channels: &Channels) -> Self {
        let drivers = if self.extrapolates() { self.drivers.clone() } else { Vec::new() };
        for (driver, [from, to]) in drivers.iter().zip(SEEN) {
            let Some(seen) = see(channels, driver, &self.fixed) else { continue };
            // The rate of a turn rises from rest.
            let is_turn = channels.turning.is_some() && goes_with_rate(channels, driver);
            let seen = seen.iter().copied().filter(|value| value.is_finite());
            let (low, high) = robust::ends(seen.chain(is_turn.then_some(0.0)));
            if low <= high {
                self.set(from, low);
                self.set(to, high);
            }
        }
        self
    }

    /// Removes the observed range: other data have their own.
    #[must_use]
    pub fn anywhere(mut self) -> Self {
        self.fixed.retain(|(name, _)| !SEEN.as_flattened().contains(&name.as_str()));
        self
    }

    /// Limits of that driver, if its observed range is set.
    pub fn limits(&self, driver: usize) -> Option<[f64; 2]> {
        let [from, to] = SEEN.get(driver)?;
        Some(self.form.held([self.number(from)?, self.number(to)?]))
    }

    /// Its columns over the rows, one per coefficient: the term with that coefficient at 1. `None` if the data lack a
    /// driver.
    pub fn per_row(&self, channels: &Channels) -> Option<Vec<Vec<f64>>> {
        self.at_share(channels, 1.0)
    }

    /// The same with the rotation scaled to this share.
    fn at_share(&self, channels: &Channels, share: f64) -> Option<Vec<Vec<f64>>> {
        if self.form == Form::Constant {
            return Some(vec![vec![1.0; channels.time.len()]]);
        }
        if self.is_heat() {
            return Some(vec![heat(channels, &self.drivers[0], &self.fixed)?]);
        }
        let seen = |which: usize| {
            let driver = self.drivers.get(which)?;
            let mut seen = see(channels, driver, &self.fixed)?;
            if share != 1.0 && goes_with_rate(channels, driver) {
                seen.to_mut().iter_mut().for_each(|value| *value *= share);
            }
            if let Some([low, high]) = self.limits(which) {
                // Must not panic if a bound is NaN.
                seen.to_mut().iter_mut().for_each(|value| *value = value.max(low).min(high));
            }
            Some(seen)
        };
        let x = seen(0)?;
        let number = |name: &str| self.number(name);
        let origin = fixed_or(&self.fixed, "origin", 0.0);
        let one = |f: &dyn Fn(f64) -> f64| vec![x.iter().map(|&x| f(x)).collect::<Vec<f64>>()];
        Some(match self.form {
            Form::Constant => one(&|_| 1.0),
            Form::Linear => one(&|x| x - origin),
            Form::Quadratic => one(&|x| (x - origin).powi(2)),
            Form::Cubic => one(&|x| (x - origin).powi(3)),
            Form::Exponential => {
                let constant = number("time_constant")?;
                one(&|x| (-x / constant).exp())
            }
            Form::Harmonic => {
                let k = self.order();
                let mut columns = one(&|x| (k * x).cos());
                columns.extend(one(&|x| (k * x).sin()));
                columns
            }
            Form::Periodic => {
                let omega = TAU / number("period")?;
                let mut columns = one(&|x| (omega * x).cos());
                columns.extend(one(&|x| (omega * x).sin()));
                columns
            }
            Form::Step => {
                let at = number("at")?;
                one(&|x| f64::from(u8::from(x >= at)))
            }
            Form::Hinge => {
                let at = number("at")?;
                one(&|x| (x - at).max(0.0))
            }
            Form::Bump => {
                let (centre, width) = (number("centre")?, number("width")?);
                one(&|x| (-0.5 * ((x - centre) / width).powi(2)).exp())
            }
            Form::Tanh => {
                let (centre, width) = (number("centre")?, number("width")?);
                one(&|x| ((x - centre) / width).tanh())
            }
            Form::Spline => cardinal(&self.knots, &x),
            Form::Surface => {
                let y = seen(1)?;
                let (over_x, over_y) = (hats(&self.knots, &x), hats(&self.knots_2, &y));
                let mut columns = Vec::with_capacity(self.width());
                for a in &over_x {
                    for b in &over_y {
                        columns.push(a.iter().zip(b).map(|(a, b)| a * b).collect());
                    }
                }
                columns
            }
            Form::Product => {
                let y = seen(1)?;
                let origin_2 = fixed_or(&self.fixed, "origin_2", 0.0);
                vec![x.iter().zip(y.iter()).map(|(x, y)| (x - origin) * (y - origin_2)).collect()]
            }
            Form::Delay => vec![self.delayed(channels)?],
            Form::DeadZone => {
                let width = number("width")?;
                let is_rotation =
                    self.drivers.first().is_some_and(|one| one.field == channels.rotation_name);
                // Where a reference of zero is noisy, any dead zone would take its noise away.
                let is_told = |x: f64| !(is_rotation && is_noise(x, channels));
                one(&|x| if x.abs() < width && is_told(x) { -x } else { 0.0 })
            }
            Form::Saturation => {
                let limit = number("limit")?;
                let lower = fixed_or(&self.fixed, "lower_limit", -limit);
                one(&|x| x.max(lower).min(limit) - x)
            }
        })
    }

    /// Its columns over the rows, each value the mean over the row's duration.
    fn within_rows(&self, channels: &Channels) -> Option<Vec<Vec<f64>>> {
        let Some(turning) = &channels.turning else { return self.per_row(channels) };
        let over = if self.acts == Acts::Scale { Over::Angle } else { Over::Time };
        let first = self.drivers.first();
        let heading = first.and_then(|driver| field(channels, driver));
        if self.form == Form::Harmonic
            && let Some(Field::Channel(channel)) = heading
            && channel.role == Role::Heading
        {
            return Some(turning.harmonic(over, self.order(), &channel.values));
        }
        if self.drivers.iter().any(|driver| goes_with_rate(channels, driver)) {
            turning.mean(over, |share| self.at_share(channels, share))
        } else {
            self.per_row(channels)
        }
    }

    /// Order of its harmonic.
    fn order(&self) -> f64 {
        match self.drivers.first().map(|driver| driver.wrap) {
            Some(Wrap::Harmonic(order)) => f64::from(order),
            _ => 1.0,
        }
    }

    /// Effect of a delay, a clock or a bandwidth on the rotation, per unit of its number.
    fn delayed(&self, channels: &Channels) -> Option<Vec<f64>> {
        let rate = &channels.rotation;
        let share = fixed_or(&self.fixed, LATE_SHARE, 1.0);
        let Some(Field::Rotation | Field::Time) = field(channels, &self.drivers[0]) else {
            return None;
        };
        if self.drivers[0].wrap == Wrap::LagOf {
            let lagged = see(channels, &self.drivers[0], &self.fixed)?;
            let constant = self.number("time_constant")?;
            let slower = |(lagged, rate): (&f64, &f64)| share * ((lagged - rate) / constant);
            return Some(lagged.iter().zip(rate).map(slower).collect());
        }
        let (number, is_clock) = match self.acts {
            Acts::Clock => (self.number("stretch")?, true),
            _ => (self.number("delay")?, false),
        };
        let mut found = Vec::with_capacity(rate.len());
        for range in &channels.segments {
            let times = &channels.time[range.clone()];
            let values = &rate[range.clone()];
            let at = times.iter().map(|&time| {
                if is_clock { time + number * (time - times[0]) } else { time - number }
            });
            let bends = &channels.bends_of_rotation()[range.clone()];
            let moved = interpolate_along(times, values, bends, at);
            found
                .extend(moved.zip(values).map(|(moved, value)| share * ((moved - value) / number)));
        }
        Some(found)
    }

    /// Its columns over the observations of `block`. `None` if the block has no such term or the data lack a driver.
    pub fn observed(&self, block: &Block, channels: &Channels) -> Option<Vec<Vec<f64>>> {
        let exposure = exposure(block, self.acts)?;
        let columns = self.within_rows(channels)?;
        let adds_up = block.aggregate == Aggregate::Level;
        let beside = beside(&self.name, (self.acts, self.form), block);
        Some(
            columns
                .into_iter()
                .map(|mut column| {
                    adds_up.then(|| since_before(&mut column));
                    let more = beside.iter().map(|(acts, per_row)| {
                        let also = column.iter().zip(per_row).map(|(value, per)| value * per);
                        block.observe(*acts, also.collect(), &channels.run)
                    });
                    let more: Vec<Vec<f64>> = more.collect();
                    let both = column.iter_mut().zip(&exposure.per_row);
                    both.for_each(|(value, per)| *value *= per);
                    let mut seen = block.observe(self.acts, column, &channels.run);
                    for more in more {
                        seen.iter_mut().zip(more).for_each(|(seen, more)| *seen += more);
                    }
                    seen
                })
                .collect(),
        )
    }

    /// A word that distinguishes two shapes.
    pub fn label(&self) -> String {
        let drivers: Vec<String> = self.drivers.iter().map(ToString::to_string).collect();
        format!("{:?}[{}]{:?}", self.acts, drivers.join(","), self.form)
    }
}

impl Form {
    /// Limits of a driver that was `seen` in this range: for what rises evenly, a little beyond. Squares, cubes and
    /// products change most at the ends, where the data say least.
    pub(super) fn held(self, [from, to]: [f64; 2]) -> [f64; 2] {
        let rises_steeply = matches!(self, Self::Quadratic | Self::Cubic | Self::Product);
        let reach = if rises_steeply { 0.0 } else { REACH * (to - from) };
        [from - reach, to + reach]
    }
}

/// Whether the driver is proportional to the rate of rotation, or to its magnitude.
fn goes_with_rate(channels: &Channels, driver: &Driver) -> bool {
    matches!(driver.wrap, Wrap::Plain | Wrap::Abs)
        && matches!(field(channels, driver), Some(Field::Rotation))
}

/// What one unit of a term that `acts` so adds to the observations of `block`. Additions to a rate have the exposure of
/// a bias; slip has that of the distance.
pub fn exposure(block: &Block, acts: Acts) -> Option<&Exposure> {
    let like = match acts {
        Acts::Delay | Acts::Clock | Acts::DeadZone | Acts::Saturation | Acts::Axis => Acts::Bias,
        Acts::Slip => {
            return block.exposure(Acts::Drive).or_else(|| block.exposure(Acts::Curvature));
        }
        other => other,
    };
    block.exposure(like)
}
