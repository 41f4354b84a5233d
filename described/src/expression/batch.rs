//! Expressions that are evaluated together. Expressions of the same shape, such as those of the cells of a battery,
//! share one list of instructions and differ only in numbers and slots. The results equal those of separate
//! evaluation.

use super::Expression;
use super::operation::{Binary, Unary};
use super::program::{From, Instruction};
use std::ops::Range;

/// Number of expressions evaluated together where many have one shape: the time to decode an instruction is spent once
/// for all of them.
const WIDE: usize = 16;

/// The same where few have one shape: what a processor adds and multiplies at once.
const NARROW: usize = 4;

/// Expressions, each with the position of its value, in blocks that are evaluated one at a time.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Batch {
    blocks: Box<[Block]>,
}

#[derive(Debug, Clone, PartialEq)]
enum Block {
    Wide(Alike<WIDE>),
    Narrow(Alike<NARROW>),
    /// An expression with a unique shape, or with one that needs the stack.
    Alone(usize, Expression),
}

#[derive(Debug, Clone, PartialEq)]
struct Alike<const LANES: usize> {
    /// Missing lanes repeat the last one.
    places: [usize; LANES],
    /// Each place follows the one before: the lanes are calculated where their values belong.
    is_in_order: bool,
    steps: Box<[Step<LANES>]>,
}

/// An instruction for all lanes; each variant corresponds to one of [`Instruction`].
#[derive(Debug, Clone, PartialEq)]
enum Step<const LANES: usize> {
    Load(Operands<LANES>),
    Unary(Unary),
    Right(Binary, Operands<LANES>),
    Left(Binary, Operands<LANES>),
    AddProduct(Operands<LANES>, Operands<LANES>),
    SubtractProduct(Operands<LANES>, Operands<LANES>),
}

/// The operand of an instruction in each lane.
#[derive(Debug, Clone, PartialEq)]
enum Operands<const LANES: usize> {
    SameSlot(u32),
    Numbers([f64; LANES]),
    Slots([u32; LANES]),
}

impl Batch {
    /// Expressions with their positions. A block contains expressions of one occasion only, which are needed at the
    /// same times.
    pub(crate) fn new<'a, Occasion: PartialEq>(
        expressions: impl Iterator<Item = (Occasion, usize, &'a Expression)>,
    ) -> Self {
        let mut shapes: Vec<(Occasion, Vec<(usize, &Expression)>)> = Vec::new();
        for (occasion, place, expression) in expressions {
            let is_alike = |(of, shape): &&mut (Occasion, Vec<(usize, &Expression)>)| {
                *of == occasion && shape.len() < WIDE && are_alike(shape[0].1, expression)
            };
            match shapes.iter_mut().find(is_alike) {
                Some((_, shape)) => shape.push((place, expression)),
                None => shapes.push((occasion, vec![(place, expression)])),
            }
        }
        let blocks = shapes.iter().flat_map(|(_, shape)| Block::of(shape));
        Self { blocks: blocks.collect() }
    }

    pub(crate) const fn count(&self) -> usize {
        self.blocks.len()
    }

    /// The blocks with a value at one of these positions.
    pub(crate) fn blocks_of(&self, places: &Range<usize>) -> Box<[usize]> {
        let has_one = |(_, block): &(usize, &Block)| {
            block.places().iter().any(|place| places.contains(place))
        };
        self.blocks.iter().enumerate().filter(has_one).map(|(index, _)| index).collect()
    }

    /// The positions of each block.
    #[cfg(test)]
    pub(super) fn shapes(&self) -> Vec<Vec<usize>> {
        let each = self.blocks.iter().map(|block| {
            let mut places = block.places().to_vec();
            places.dedup();
            places
        });
        each.collect()
    }

    /// Stores the values of a block at their positions; NaN if one cannot be evaluated.
    #[inline]
    pub(crate) fn evaluate(&self, block: usize, variables: &[f64], values: &mut [f64]) {
        match self.blocks.get(block) {
            Some(Block::Wide(several)) => several.evaluate(variables, values),
            Some(Block::Narrow(several)) => several.evaluate(variables, values),
            Some(Block::Alone(place, expression)) => {
                if let Some(value) = values.get_mut(*place) {
                    *value = expression.value(variables);
                }
            }
            None => {}
        }
    }
}

impl Block {
    /// The blocks of expressions of one shape.
    fn of(shape: &[(usize, &Expression)]) -> Vec<Self> {
        if shape.len() > 2 * NARROW
            && let Some(wide) = Alike::of(shape)
        {
            return vec![Self::Wide(wide)];
        }
        let few = |few: &[(usize, &Expression)]| match Alike::of(few) {
            Some(narrow) => vec![Self::Narrow(narrow)],
            None => few.iter().map(|(place, one)| Self::Alone(*place, (*one).clone())).collect(),
        };
        shape.chunks(NARROW).flat_map(few).collect()
    }

    fn places(&self) -> &[usize] {
        match self {
            Self::Wide(several) => &several.places,
            Self::Narrow(several) => &several.places,
            Self::Alone(place, _) => std::slice::from_ref(place),
        }
    }
}

/// True if both have the same instructions, apart from numbers and slots.
fn are_alike(a: &Expression, b: &Expression) -> bool {
    let (a, b) = (a.program.instructions(), b.program.instructions());
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| Step::<2>::of(&[*a, *b]).is_some())
}

impl<const LANES: usize> Alike<LANES> {
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
    fn evaluate(&self, variables: &[f64], values: &mut [f64]) {
        let [first, ..] = self.places[..] else { return };
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
            step.run(variables, hands);
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

impl<const LANES: usize> Step<LANES> {
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
    fn run(&self, variables: &[f64], hands: &mut [f64; LANES]) {
        match self {
            Self::Load(a) => a.each(variables, |lane, a| hands[lane] = a),
            Self::Unary(unary) => *hands = hands.map(|hand| unary.apply(hand)),
            // The most frequent operators, without a branch per value.
            Self::Right(Binary::Add, a) => a.each(variables, |lane, a| hands[lane] += a),
            Self::Right(Binary::Subtract, a) => a.each(variables, |lane, a| hands[lane] -= a),
            Self::Right(Binary::Multiply, a) => a.each(variables, |lane, a| hands[lane] *= a),
            Self::Right(Binary::Divide, a) => a.each(variables, |lane, a| hands[lane] /= a),
            Self::Right(binary, a) => {
                a.each(variables, |lane, a| hands[lane] = binary.apply(hands[lane], a));
            }
            Self::Left(binary, a) => {
                a.each(variables, |lane, a| hands[lane] = binary.apply(a, hands[lane]));
            }
            Self::AddProduct(a, b) => {
                let product = a.times(b, variables);
                (0..LANES).for_each(|lane| hands[lane] += product[lane]);
            }
            Self::SubtractProduct(a, b) => {
                let product = a.times(b, variables);
                (0..LANES).for_each(|lane| hands[lane] -= product[lane]);
            }
        }
    }
}

impl<const LANES: usize> Operands<LANES> {
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

    /// Takes the value in each lane.
    #[inline(always)]
    fn each(&self, variables: &[f64], mut take: impl FnMut(usize, f64)) {
        let in_slot = |slot: u32| variables.get(slot as usize).copied().unwrap_or(f64::NAN);
        match self {
            Self::SameSlot(slot) => {
                let value = in_slot(*slot);
                (0..LANES).for_each(|lane| take(lane, value));
            }
            Self::Numbers(numbers) => (0..LANES).for_each(|lane| take(lane, numbers[lane])),
            Self::Slots(slots) => (0..LANES).for_each(|lane| take(lane, in_slot(slots[lane]))),
        }
    }

    #[inline(always)]
    fn times(&self, other: &Self, variables: &[f64]) -> [f64; LANES] {
        let mut product = [0.0; LANES];
        self.each(variables, |lane, a| product[lane] = a);
        other.each(variables, |lane, b| product[lane] *= b);
        product
    }
}

/// All values, if none is missing.
fn all<T: Copy, const LANES: usize>(lanes: [Option<T>; LANES]) -> Option<[T; LANES]> {
    let first = (*lanes.first()?)?;
    lanes.iter().all(Option::is_some).then(|| lanes.map(|lane| lane.unwrap_or(first)))
}
