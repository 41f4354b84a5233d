//! An expression as a flat program: one value at hand, and a stack for those that wait.
//!
//! What is written operand by operand becomes an instruction for each operator, which fetches its own operands; a product
//! that is added or taken away is one instruction. The numbers are those of the operators one by one.

use super::array::{Aggregate, Array};
use super::operation::{Binary, Unary};
use super::{Operation, STACK_MAX};
use crate::lookup::Lookup;
use std::sync::Arc;

/// What most expressions need of the stack.
const STACK_SMALL: usize = 2;

/// Where an operand is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum From {
    Number(f64),
    Slot(u32),
    /// On top of the stack.
    Stack,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Instruction {
    /// It is at hand from now on.
    Load(From),
    /// What is at hand waits.
    Push,
    Unary(Unary),
    /// With what is at hand on the left.
    Right(Binary, From),
    /// With what is at hand on the right.
    Left(Binary, From),
    /// A product is added to what is at hand.
    AddProduct(From, From),
    /// A product is taken from what is at hand.
    SubtractProduct(From, From),
    /// Condition, then and else.
    Choose(From, From, From),
    /// Value, least and greatest.
    Clamp(From, From, From),
    /// Of the array, that of the number at hand.
    Element(Array),
    Aggregate(Aggregate, Array),
    /// The look-up table of this place, with what is at hand.
    LookUp(u32),
    /// And in two dimensions.
    LookUpPlane(u32, From, From),
}

/// Instructions, and the tables that they look into.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Program {
    instructions: Box<[Instruction]>,
    tables: Box<[Arc<Lookup>]>,
    /// How many values wait at the most.
    height: usize,
}

/// An operand that is not yet used.
#[derive(Debug, Clone, Copy)]
enum Pending {
    /// It can be had at any time.
    Simple(From),
    /// At hand, or on the stack where another is at hand.
    Computed { waits: bool },
}

#[derive(Default)]
struct Compiler {
    instructions: Vec<Instruction>,
    tables: Vec<Arc<Lookup>>,
    pending: Vec<Pending>,
}

impl Program {
    /// Of operations, operands before operators.
    pub(super) fn of(operations: &[Operation]) -> Self {
        let mut compiler = Compiler::default();
        for operation in operations {
            compiler.operation(operation);
        }
        let last = compiler.take();
        compiler.bring(last);
        let instructions = fused(&compiler.instructions);
        let height = highest(&instructions);
        Self { instructions: instructions.into(), tables: compiler.tables.into(), height }
    }

    pub(super) fn instructions(&self) -> &[Instruction] {
        &self.instructions
    }

    /// The value where it is the same whatever the variables are.
    pub(super) fn constant(&self) -> Option<f64> {
        match *self.instructions {
            [Instruction::Load(From::Number(number))] => Some(number),
            _ => None,
        }
    }

    /// The value with these variables.
    #[inline]
    pub(super) fn run(&self, variables: &[f64]) -> f64 {
        match self.height {
            0 => self.run_with::<0>(variables),
            1..=STACK_SMALL => self.run_with::<STACK_SMALL>(variables),
            _ => self.run_with::<STACK_MAX>(variables),
        }
    }

    #[inline]
    fn run_with<const DEPTH: usize>(&self, variables: &[f64]) -> f64 {
        let mut stack = Stack { values: [f64::NAN; DEPTH], height: 0, variables };
        let mut hand = f64::NAN;
        for instruction in &self.instructions {
            match *instruction {
                Instruction::Load(from) => hand = stack.get(from),
                Instruction::Push => stack.push(hand),
                Instruction::Unary(unary) => hand = unary.apply(hand),
                Instruction::Right(binary, from) => hand = binary.apply(hand, stack.get(from)),
                Instruction::Left(binary, from) => hand = binary.apply(stack.get(from), hand),
                Instruction::AddProduct(a, b) => hand += stack.get(a) * stack.get(b),
                Instruction::SubtractProduct(a, b) => hand -= stack.get(a) * stack.get(b),
                Instruction::Choose(condition, then, otherwise) => {
                    let (otherwise, then) = (stack.get(otherwise), stack.get(then));
                    hand = choose(stack.get(condition), then, otherwise);
                }
                Instruction::Clamp(x, low, high) => {
                    let (high, low, x) = (stack.get(high), stack.get(low), stack.get(x));
                    hand = Binary::Max.apply(low, Binary::Min.apply(high, x));
                }
                Instruction::Element(array) => hand = array.element(hand, variables),
                Instruction::Aggregate(aggregate, array) => hand = aggregate.of(array, variables),
                Instruction::LookUp(table) => {
                    hand = self.tables[table as usize].value(hand, f64::NAN);
                }
                Instruction::LookUpPlane(table, x, y) => {
                    let (y, x) = (stack.get(y), stack.get(x));
                    hand = self.tables[table as usize].value(x, y);
                }
            }
        }
        hand
    }
}

/// One of two, by a condition that is a number.
pub(super) fn choose(condition: f64, then: f64, otherwise: f64) -> f64 {
    match condition {
        unknown if unknown.is_nan() => f64::NAN,
        0.0 => otherwise,
        _ => then,
    }
}

/// The compiler has seen to it that it never overflows.
struct Stack<'a, const DEPTH: usize> {
    values: [f64; DEPTH],
    height: usize,
    variables: &'a [f64],
}

impl<const DEPTH: usize> Stack<'_, DEPTH> {
    #[inline]
    fn get(&mut self, from: From) -> f64 {
        match from {
            From::Number(number) => number,
            From::Slot(slot) => self.variables.get(slot as usize).copied().unwrap_or(f64::NAN),
            From::Stack => {
                self.height = self.height.saturating_sub(1);
                self.values.get(self.height).copied().unwrap_or(f64::NAN)
            }
        }
    }

    #[inline]
    fn push(&mut self, value: f64) {
        if let Some(place) = self.values.get_mut(self.height) {
            *place = value;
            self.height += 1;
        }
    }
}

impl Compiler {
    fn operation(&mut self, operation: &Operation) {
        match operation {
            Operation::Constant(number) => {
                self.pending.push(Pending::Simple(From::Number(*number)));
            }
            Operation::Variable(slot) => {
                let slot = u32::try_from(*slot).unwrap_or(u32::MAX);
                self.pending.push(Pending::Simple(From::Slot(slot)));
            }
            Operation::Unary(unary) => match self.take() {
                Pending::Simple(From::Number(x)) => {
                    self.pending.push(Pending::Simple(From::Number(unary.apply(x))));
                }
                x => self.of_one(x, Instruction::Unary(*unary)),
            },
            Operation::Element(array) => {
                let index = self.take();
                self.of_one(index, Instruction::Element(*array));
            }
            Operation::LookUp(table) => {
                let place = self.table(table);
                if table.dimensions() == 1 {
                    let x = self.take();
                    self.of_one(x, Instruction::LookUp(place));
                } else {
                    let [x, y] = self.waiting();
                    self.computed(Instruction::LookUpPlane(place, x, y));
                }
            }
            Operation::Aggregate(aggregate, array) => {
                self.free_hand();
                self.computed(Instruction::Aggregate(*aggregate, *array));
            }
            Operation::Binary(binary) => {
                let (b, a) = (self.take(), self.take());
                self.binary(*binary, a, b);
            }
            Operation::Choose => {
                let [condition, then, otherwise] = self.waiting();
                self.computed(Instruction::Choose(condition, then, otherwise));
            }
            Operation::Clamp => {
                let [x, low, high] = self.waiting();
                self.computed(Instruction::Clamp(x, low, high));
            }
        }
    }

    fn binary(&mut self, binary: Binary, a: Pending, b: Pending) {
        use Pending::{Computed, Simple};
        match (a, b) {
            (Simple(From::Number(a)), Simple(From::Number(b))) => {
                self.pending.push(Simple(From::Number(binary.apply(a, b))));
            }
            (a, Simple(b)) => self.of_one(a, Instruction::Right(binary, b)),
            (Simple(a), b) => self.of_one(b, Instruction::Left(binary, a)),
            // The left one came first: it waits.
            (Computed { .. }, b) => self.of_one(b, Instruction::Left(binary, From::Stack)),
        }
    }

    /// The last operand that is not yet used.
    fn take(&mut self) -> Pending {
        self.pending.pop().unwrap_or(Pending::Simple(From::Number(f64::NAN)))
    }

    /// What an instruction makes of one operand.
    fn of_one(&mut self, operand: Pending, instruction: Instruction) {
        self.bring(operand);
        self.computed(instruction);
    }

    fn computed(&mut self, instruction: Instruction) {
        self.instructions.push(instruction);
        self.pending.push(Pending::Computed { waits: false });
    }

    /// Has the operand at hand.
    fn bring(&mut self, operand: Pending) {
        match operand {
            Pending::Simple(from) => {
                self.free_hand();
                self.instructions.push(Instruction::Load(from));
            }
            Pending::Computed { waits: false } => {}
            Pending::Computed { waits: true } => {
                self.instructions.push(Instruction::Load(From::Stack));
            }
        }
    }

    /// Has what is at hand wait on the stack, where it is still to be used.
    fn free_hand(&mut self) {
        for pending in &mut self.pending {
            if let Pending::Computed { waits: waits @ false } = pending {
                *waits = true;
                self.instructions.push(Instruction::Push);
            }
        }
    }

    /// The last operands, those that are computed on the stack.
    fn waiting<const COUNT: usize>(&mut self) -> [From; COUNT] {
        self.free_hand();
        let mut operands = [From::Stack; COUNT];
        for operand in operands.iter_mut().rev() {
            if let Pending::Simple(from) = self.take() {
                *operand = from;
            }
        }
        operands
    }

    fn table(&mut self, table: &Arc<Lookup>) -> u32 {
        self.tables.push(Arc::clone(table));
        u32::try_from(self.tables.len() - 1).unwrap_or(u32::MAX)
    }
}

/// The same with products that are added or taken away in one instruction.
fn fused(instructions: &[Instruction]) -> Vec<Instruction> {
    use Instruction::{AddProduct, Left, Load, Push, Right, SubtractProduct};
    let mut fused: Vec<Instruction> = Vec::with_capacity(instructions.len());
    for instruction in instructions {
        // With what is at hand on its left, which is not yet there where a simple operand is.
        let (sum, first) = match instruction {
            Left(sum @ (Binary::Add | Binary::Subtract), first) => (*sum, *first),
            other => {
                fused.push(*other);
                continue;
            }
        };
        let (a, b) = match fused.as_slice() {
            [.., Load(a), Right(Binary::Multiply, b)] if ![*a, *b].contains(&From::Stack) => {
                (*a, *b)
            }
            _ => {
                fused.push(*instruction);
                continue;
            }
        };
        let waits = first == From::Stack;
        if waits && !matches!(fused.as_slice(), [.., Push, _, _]) {
            fused.push(*instruction);
            continue;
        }
        fused.truncate(fused.len() - 2 - usize::from(waits));
        if !waits {
            fused.push(Load(first));
        }
        fused.push(if sum == Binary::Add { AddProduct(a, b) } else { SubtractProduct(a, b) });
    }
    fused
}

/// How many values wait at the most.
fn highest(instructions: &[Instruction]) -> usize {
    let of_stack = |from: &From| usize::from(*from == From::Stack);
    let (mut height, mut highest) = (0_usize, 0);
    for instruction in instructions {
        let taken = match instruction {
            Instruction::Push => {
                height += 1;
                highest = highest.max(height);
                0
            }
            Instruction::Load(a) | Instruction::Right(_, a) | Instruction::Left(_, a) => {
                of_stack(a)
            }
            Instruction::AddProduct(a, b)
            | Instruction::SubtractProduct(a, b)
            | Instruction::LookUpPlane(_, a, b) => of_stack(a) + of_stack(b),
            Instruction::Choose(a, b, c) | Instruction::Clamp(a, b, c) => {
                of_stack(a) + of_stack(b) + of_stack(c)
            }
            Instruction::Unary(_)
            | Instruction::Element(_)
            | Instruction::Aggregate(..)
            | Instruction::LookUp(_) => 0,
        };
        height = height.saturating_sub(taken);
    }
    highest
}
