//! Expressions that are evaluated together. Expressions of the same shape, such as those of the cells of a battery,
//! share one list of instructions and differ only in numbers and slots. The results equal those of separate
//! evaluation.

use super::Expression;
use super::operation::{Binary, Unary};
use super::program::{From, Instruction};

/// Number of expressions evaluated together: what a processor adds and multiplies at once. Larger groups are split; in
/// smaller ones the last expression fills the missing lanes.
const LANES: usize = 4;

/// Expressions, each with the position of its value.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Batch {
    alike: Box<[Alike]>,
    /// Expressions with a unique shape, or with one that needs the stack.
    alone: Box<[(usize, Expression)]>,
}

/// Expressions of one shape.
#[derive(Debug, Clone, PartialEq)]
struct Alike {
    /// Missing lanes repeat the last one.
    places: [usize; LANES],
    /// Each place follows the one before: the lanes are calculated where their values belong.
    is_in_order: bool,
    steps: Box<[Step]>,
}

/// An instruction for all lanes; each variant corresponds to one of [`Instruction`].
#[derive(Debug, Clone, PartialEq)]
enum Step {
    Load(Operands),
    Unary(Unary),
    Right(Binary, Operands),
    Left(Binary, Operands),
    AddProduct(Operands, Operands),
    SubtractProduct(Operands, Operands),
}

/// The operand of an instruction in each lane.
#[derive(Debug, Clone, PartialEq)]
enum Operands {
    SameSlot(u32),
    Numbers([f64; LANES]),
    Slots([u32; LANES]),
}

impl Batch {
    pub(crate) fn new<'a>(expressions: impl Iterator<Item = (usize, &'a Expression)>) -> Self {
        let mut shapes: Vec<Vec<(usize, &Expression)>> = Vec::new();
        for (place, expression) in expressions {
            let is_alike = |shape: &&mut Vec<(usize, &Expression)>| {
                shape.len() < LANES && are_alike(shape[0].1, expression)
            };
            match shapes.iter_mut().find(is_alike) {
                Some(shape) => shape.push((place, expression)),
                None => shapes.push(vec![(place, expression)]),
            }
        }
        let (mut alike, mut alone) = (Vec::new(), Vec::new());
        for shape in shapes {
            match Alike::of(&shape) {
                Some(several) => alike.push(several),
                None => alone.extend(shape.into_iter().map(|(place, one)| (place, one.clone()))),
            }
        }
        Self { alike: alike.into(), alone: alone.into() }
    }

    /// The positions of the expressions that are evaluated together.
    #[cfg(test)]
    pub(super) fn shapes(&self) -> Vec<Vec<usize>> {
        let alike = self.alike.iter().map(|several| {
            let mut places = several.places.to_vec();
            places.dedup();
            places
        });
        alike.chain(self.alone.iter().map(|(place, _)| vec![*place])).collect()
    }

    /// Stores the value of each at its position; NaN if it cannot be evaluated.
    #[inline]
    pub(crate) fn values(&self, variables: &[f64], values: &mut [f64]) {
        for several in &self.alike {
            several.values(variables, values);
        }
        for (place, expression) in &self.alone {
            if let Some(value) = values.get_mut(*place) {
                *value = expression.value(variables);
            }
        }
    }
}

/// True if both have the same instructions, apart from numbers and slots.
fn are_alike(a: &Expression, b: &Expression) -> bool {
    let (a, b) = (a.program.instructions(), b.program.instructions());
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| Step::of(&[*a, *b]).is_some())
}

impl Alike {
    /// `None` for a single expression, and for instructions without a [`Step`].
    fn of(shape: &[(usize, &Expression)]) -> Option<Self> {
        let [(_, first), .., (last, _)] = shape else { return None };
        let step = |index: usize| {
            let each = shape.iter().map(|(_, one)| one.program.instructions().get(index).copied());
            Step::of(&each.collect::<Option<Vec<_>>>()?)
        };
        let steps: Option<Vec<_>> = (0..first.program.instructions().len()).map(step).collect();
        let place = |lane: usize| shape.get(lane).map_or(*last, |(place, _)| *place);
        let places: [usize; LANES] = std::array::from_fn(place);
        let is_in_order = places.windows(2).all(|pair| pair[0] + 1 == pair[1]);
        Some(Self { places, is_in_order, steps: steps?.into() })
    }

    #[inline]
    fn values(&self, variables: &[f64], values: &mut [f64]) {
        let [first, ..] = self.places;
        if let Some(hands) = values.get_mut(first..).and_then(<[f64]>::first_chunk_mut)
            && self.is_in_order
        {
            self.run(variables, hands);
            return;
        }
        let mut hands = [f64::NAN; LANES];
        self.run(variables, &mut hands);
        for (place, hand) in self.places.into_iter().zip(hands) {
            if let Some(value) = values.get_mut(place) {
                *value = hand;
            }
        }
    }

    /// Not inlined: the compiler would keep the lanes apart, and calculate with one at a time.
    #[inline(never)]
    fn run(&self, variables: &[f64], hands: &mut [f64; LANES]) {
        for step in &self.steps {
            *hands = step.run(variables, *hands);
        }
    }
}

/// The common part of instructions that are executed together.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Load,
    Unary(Unary),
    Right(Binary),
    Left(Binary),
    AddProduct,
    SubtractProduct,
}

/// The kind of an instruction and its operands, unused ones as NaN.
fn parts(instruction: &Instruction) -> Option<(Kind, [From; 2])> {
    const NONE: From = From::Number(f64::NAN);
    Some(match *instruction {
        Instruction::Load(a) => (Kind::Load, [a, NONE]),
        Instruction::Unary(unary) => (Kind::Unary(unary), [NONE, NONE]),
        Instruction::Right(binary, a) => (Kind::Right(binary), [a, NONE]),
        Instruction::Left(binary, a) => (Kind::Left(binary), [a, NONE]),
        Instruction::AddProduct(a, b) => (Kind::AddProduct, [a, b]),
        Instruction::SubtractProduct(a, b) => (Kind::SubtractProduct, [a, b]),
        _ => return None,
    })
}

impl Step {
    /// Combines the same instruction of several expressions; `None` if they differ, or if one needs the stack or more
    /// than two operands.
    fn of(each: &[Instruction]) -> Option<Self> {
        let parts: Vec<_> = each.iter().map(parts).collect::<Option<_>>()?;
        let (kind, _) = *parts.first()?;
        if parts.iter().any(|(other, _)| *other != kind) {
            return None;
        }
        let operands =
            |which: usize| Operands::of(parts.iter().map(|(_, operands)| operands[which]));
        Some(match kind {
            Kind::Load => Self::Load(operands(0)?),
            Kind::Unary(unary) => Self::Unary(unary),
            Kind::Right(binary) => Self::Right(binary, operands(0)?),
            Kind::Left(binary) => Self::Left(binary, operands(0)?),
            Kind::AddProduct => Self::AddProduct(operands(0)?, operands(1)?),
            Kind::SubtractProduct => Self::SubtractProduct(operands(0)?, operands(1)?),
        })
    }

    #[inline]
    fn run(&self, variables: &[f64], hands: [f64; LANES]) -> [f64; LANES] {
        match self {
            Self::Load(a) => a.values(variables),
            Self::Unary(unary) => hands.map(|hand| unary.apply(hand)),
            // The most frequent operators, without a branch per value.
            Self::Right(Binary::Add, a) => both(hands, a.values(variables), |hand, a| hand + a),
            Self::Right(Binary::Subtract, a) => {
                both(hands, a.values(variables), |hand, a| hand - a)
            }
            Self::Right(Binary::Multiply, a) => {
                both(hands, a.values(variables), |hand, a| hand * a)
            }
            Self::Right(Binary::Divide, a) => both(hands, a.values(variables), |hand, a| hand / a),
            Self::Right(binary, a) => {
                both(hands, a.values(variables), |hand, a| binary.apply(hand, a))
            }
            Self::Left(binary, a) => {
                both(a.values(variables), hands, |a, hand| binary.apply(a, hand))
            }
            Self::AddProduct(a, b) => {
                let product = both(a.values(variables), b.values(variables), |a, b| a * b);
                both(hands, product, |hand, product| hand + product)
            }
            Self::SubtractProduct(a, b) => {
                let product = both(a.values(variables), b.values(variables), |a, b| a * b);
                both(hands, product, |hand, product| hand - product)
            }
        }
    }
}

impl Operands {
    /// `None` if an operand is on the stack, or if numbers and slots are mixed.
    fn of(each: impl Iterator<Item = From>) -> Option<Self> {
        let each: Vec<From> = each.collect();
        let last = *each.last()?;
        let lanes: [From; LANES] = std::array::from_fn(|lane| *each.get(lane).unwrap_or(&last));
        let is_same = lanes.iter().all(|from| *from == last);
        let number = |from: From| if let From::Number(number) = from { Some(number) } else { None };
        let slot = |from: From| if let From::Slot(slot) = from { Some(slot) } else { None };
        match last {
            From::Slot(slot) if is_same => Some(Self::SameSlot(slot)),
            From::Number(_) => all(lanes.map(number)).map(Self::Numbers),
            From::Slot(_) => all(lanes.map(slot)).map(Self::Slots),
            From::Stack => None,
        }
    }

    #[inline]
    fn values(&self, variables: &[f64]) -> [f64; LANES] {
        let in_slot = |slot: u32| variables.get(slot as usize).copied().unwrap_or(f64::NAN);
        match *self {
            Self::SameSlot(slot) => [in_slot(slot); LANES],
            Self::Numbers(numbers) => numbers,
            Self::Slots(slots) => slots.map(in_slot),
        }
    }
}

#[inline]
fn both(a: [f64; LANES], b: [f64; LANES], becomes: impl Fn(f64, f64) -> f64) -> [f64; LANES] {
    std::array::from_fn(|lane| becomes(a[lane], b[lane]))
}

/// All values, if none is missing.
fn all<T: Copy>(lanes: [Option<T>; LANES]) -> Option<[T; LANES]> {
    let first = lanes[0]?;
    lanes.iter().all(Option::is_some).then(|| lanes.map(|lane| lane.unwrap_or(first)))
}
