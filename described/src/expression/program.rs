//! An expression as a flat program with one accumulator and a stack.
//!
//! Each operator becomes one instruction that fetches its own operands; adding or subtracting a product is one
//! instruction. The results equal those of evaluating the operators one by one.

use super::array::Array;
use super::operation::{Aggregate, Binary, Unary};
use super::{Operation, STACK_MAX};
use crate::lookup::Lookup;
use std::sync::Arc;

/// Stack size that is enough for most expressions.
const STACK_SMALL: usize = 2;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum From {
    Number(f64),
    Slot(u32),
    Stack,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Instruction {
    Load(From),
    /// Pushes the accumulator on the stack.
    Push,
    Unary(Unary),
    /// Operator with the accumulator on the left.
    Right(Binary, From),
    /// Operator with the accumulator on the right.
    Left(Binary, From),
    AddProduct(From, From),
    SubtractProduct(From, From),
    /// Condition, then and else.
    Choose(From, From, From),
    /// Value, smallest and largest.
    Clamp(From, From, From),
    /// The element of the array at the index in the accumulator.
    Element(Array),
    Aggregate(Aggregate, Array),
    /// Looks the accumulator up in the table with this index.
    LookUp(u32),
    /// Looks up in a two-dimensional table.
    LookUpPlane(u32, From, From),
}

/// Instructions and their look-up tables.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Program {
    instructions: Box<[Instruction]>,
    tables: Box<[Arc<Lookup>]>,
    height: usize,
}

/// An operand that is not used yet.
#[derive(Debug, Clone, Copy)]
enum Pending {
    /// Available at any time.
    Simple(From),
    /// In the accumulator, or on the stack if `waits`.
    Computed { waits: bool },
}

#[derive(Default)]
struct Compiler {
    instructions: Vec<Instruction>,
    tables: Vec<Arc<Lookup>>,
    pending: Vec<Pending>,
}

impl Program {
    /// Compiles operations in which operands precede operators.
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

    /// The value, if it is constant.
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

/// One of two values, by a numeric condition.
pub(super) fn choose(condition: f64, then: f64, otherwise: f64) -> f64 {
    match condition {
        unknown if unknown.is_nan() => f64::NAN,
        0.0 => otherwise,
        _ => then,
    }
}

/// The compiler guarantees that it never overflows.
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
            // The left operand came first: it is on the stack.
            (Computed { .. }, b) => self.of_one(b, Instruction::Left(binary, From::Stack)),
        }
    }

    fn take(&mut self) -> Pending {
        self.pending.pop().unwrap_or(Pending::Simple(From::Number(f64::NAN)))
    }

    /// Emits an instruction with one operand.
    fn of_one(&mut self, operand: Pending, instruction: Instruction) {
        self.bring(operand);
        self.computed(instruction);
    }

    fn computed(&mut self, instruction: Instruction) {
        self.instructions.push(instruction);
        self.pending.push(Pending::Computed { waits: false });
    }

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

    /// Pushes the accumulator on the stack if its value is still needed.
    fn free_hand(&mut self) {
        for pending in &mut self.pending {
            if let Pending::Computed { waits: waits @ false } = pending {
                *waits = true;
                self.instructions.push(Instruction::Push);
            }
        }
    }

    /// The last operands; computed ones are on the stack.
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

/// Fuses products that are added or subtracted into one instruction.
fn fused(instructions: &[Instruction]) -> Vec<Instruction> {
    use Instruction::{AddProduct, Left, Load, Push, Right, SubtractProduct};
    let mut fused: Vec<Instruction> = Vec::with_capacity(instructions.len());
    for instruction in instructions {
        // The accumulator is then on the left; a simple operand must be loaded first.
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
