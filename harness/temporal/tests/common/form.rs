//! Random formulas as data, printed in this crate's notation and in that of RTAMT.

use super::LETTERS;
use proptest::prelude::*;

#[derive(Debug, Clone)]
pub enum Num {
    Constant(i32),
    Signal(usize),
    Add(Box<Num>, Box<Num>),
    Subtract(Box<Num>, Box<Num>),
    Multiply(Box<Num>, Box<Num>),
    Negate(Box<Num>),
    Abs(Box<Num>),
    Min(Box<Num>, Box<Num>),
    Max(Box<Num>, Box<Num>),
}

#[derive(Debug, Clone)]
pub enum Form {
    Compare(&'static str, Num, Num),
    /// The numbers differ by at most the last.
    Near(Num, Num, u8),
    Between(Num, Num, Num),
    Changes(Num),
    Rises(Box<Form>),
    Falls(Box<Form>),
    Not(Box<Form>),
    And(Box<Form>, Box<Form>),
    Or(Box<Form>, Box<Form>),
    Implies(Box<Form>, Box<Form>),
    Eventually(i64, i64, Box<Form>),
    Always(i64, i64, Box<Form>),
    Once(i64, Option<i64>, Box<Form>),
    Historically(i64, Option<i64>, Box<Form>),
    Until(i64, i64, Box<Form>, Box<Form>),
    Since(i64, Option<i64>, Box<Form>, Box<Form>),
}

use Form::*;

pub fn num() -> impl Strategy<Value = Num> {
    let leaf = prop_oneof![(-3..4i32).prop_map(Num::Constant), (0..3usize).prop_map(Num::Signal)];
    leaf.prop_recursive(2, 6, 2, |of| {
        let of = of.prop_map(Box::new).boxed();
        let two = (of.clone(), of.clone());
        prop_oneof![
            two.clone().prop_map(|(a, b)| Num::Add(a, b)),
            two.clone().prop_map(|(a, b)| Num::Subtract(a, b)),
            two.clone().prop_map(|(a, b)| Num::Multiply(a, b)),
            of.clone().prop_map(Num::Negate),
            of.prop_map(Num::Abs),
            two.clone().prop_map(|(a, b)| Num::Min(a, b)),
            two.prop_map(|(a, b)| Num::Max(a, b)),
        ]
    })
}

fn atom() -> impl Strategy<Value = Form> {
    let operator = prop::sample::select(vec!["<", "<=", ">", ">=", "==", "!="]);
    // One side must contain a signal.
    let some = (0..3usize, num()).prop_map(|(signal, more)| match more {
        Num::Constant(_) => Num::Signal(signal),
        more => Num::Subtract(Box::new(Num::Signal(signal)), Box::new(more)),
    });
    let some = prop_oneof![(0..3usize).prop_map(Num::Signal), some];
    prop_oneof![
        6 => (operator, some.clone(), num()).prop_map(|(how, a, b)| Compare(how, a, b)),
        1 => (some.clone(), num(), 0..3u8).prop_map(|(a, b, c)| Near(a, b, c)),
        1 => (num(), some.clone(), num()).prop_map(|(a, b, c)| Between(a, b, c)),
        1 => some.prop_map(Changes),
    ]
}

fn window() -> impl Strategy<Value = (i64, i64)> {
    (prop_oneof![Just(0), 0..5i64], 0..6i64).prop_map(|(from, length)| (from, from + length))
}

fn past() -> impl Strategy<Value = (i64, Option<i64>)> {
    prop_oneof![
        3 => window().prop_map(|(from, to)| (from, Some(to))),
        1 => Just((0, None)),
    ]
}

pub fn form() -> impl Strategy<Value = Form> {
    atom().prop_recursive(4, 12, 2, |of| {
        let of = of.prop_map(Box::new).boxed();
        let two = (of.clone(), of.clone());
        prop_oneof![
            1 => of.clone().prop_map(Not),
            1 => of.clone().prop_map(Rises),
            1 => of.clone().prop_map(Falls),
            2 => two.clone().prop_map(|(a, b)| And(a, b)),
            2 => two.clone().prop_map(|(a, b)| Or(a, b)),
            2 => two.clone().prop_map(|(a, b)| Implies(a, b)),
            2 => (window(), of.clone()).prop_map(|((a, b), of)| Eventually(a, b, of)),
            2 => (window(), of.clone()).prop_map(|((a, b), of)| Always(a, b, of)),
            2 => (past(), of.clone()).prop_map(|((a, b), of)| Once(a, b, of)),
            2 => (past(), of).prop_map(|((a, b), of)| Historically(a, b, of)),
            6 => (window(), two.clone()).prop_map(|((a, b), (p, q))| Until(a, b, p, q)),
            9 => (past(), two).prop_map(|((a, b), (p, q))| Since(a, b, p, q)),
        ]
    })
}

impl Num {
    pub fn text(&self) -> String {
        match self {
            Self::Constant(value) if *value < 0 => format!("(-{})", value.unsigned_abs()),
            Self::Constant(value) => value.to_string(),
            Self::Signal(signal) => LETTERS[*signal].to_owned(),
            Self::Add(a, b) => format!("({} + {})", a.text(), b.text()),
            Self::Subtract(a, b) => format!("({} - {})", a.text(), b.text()),
            Self::Multiply(a, b) => format!("({} * {})", a.text(), b.text()),
            Self::Negate(of) => format!("(-{})", of.text()),
            Self::Abs(of) => format!("abs({})", of.text()),
            Self::Min(a, b) => format!("min({}, {})", a.text(), b.text()),
            Self::Max(a, b) => format!("max({}, {})", a.text(), b.text()),
        }
    }

    /// RTAMT notation. It has no `min` and `max` of numbers and no parentheses in arithmetic, and its `+` binds tighter
    /// than its `*`: each operator stands alone.
    pub fn rtamt(&self) -> Option<String> {
        Some(match self {
            Self::Add(a, b) => format!("{} + {}", a.rtamt_operand()?, b.rtamt_operand()?),
            Self::Subtract(a, b) => format!("{} - {}", a.rtamt_operand()?, b.rtamt_operand()?),
            Self::Multiply(a, b) => format!("{} * {}", a.rtamt_operand()?, b.rtamt_operand()?),
            Self::Negate(of) => format!("0 - {}", of.rtamt_operand()?),
            of => of.rtamt_operand()?,
        })
    }

    fn rtamt_operand(&self) -> Option<String> {
        Some(match self {
            Self::Constant(value) => value.to_string(),
            Self::Signal(signal) => LETTERS[*signal].to_owned(),
            Self::Abs(of) => format!("abs({})", of.rtamt()?),
            _ => return None,
        })
    }
}

impl Form {
    /// This crate's notation; a step of the trace lasts `step` nanoseconds.
    pub fn text(&self, step: i64) -> String {
        let window = |a: i64, b: i64| format!("[{} ns, {} ns]", a * step, b * step);
        let past = |a: i64, b: Option<i64>| b.map_or(String::new(), |b| window(a, b));
        match self {
            Compare(how, a, b) => format!("({} {how} {})", a.text(), b.text()),
            Near(a, b, tolerance) => format!("({} == {} +- {tolerance})", a.text(), b.text()),
            Between(a, b, c) => format!("({} < {} <= {})", a.text(), b.text(), c.text()),
            Changes(of) => format!("changes({})", of.text()),
            Rises(of) => format!("rises({})", of.text(step)),
            Falls(of) => format!("falls({})", of.text(step)),
            Not(of) => format!("(not {})", of.text(step)),
            And(a, b) => format!("({} and {})", a.text(step), b.text(step)),
            Or(a, b) => format!("({} or {})", a.text(step), b.text(step)),
            Implies(a, b) => format!("({} -> {})", a.text(step), b.text(step)),
            Eventually(0, b, of) if *b > 0 => {
                format!("(within {} ns: {})", b * step, of.text(step))
            }
            Always(0, b, of) if *b > 0 => format!("(for {} ns: {})", b * step, of.text(step)),
            Eventually(a, b, of) => format!("(eventually {}: {})", window(*a, *b), of.text(step)),
            Always(a, b, of) => format!("(always {}: {})", window(*a, *b), of.text(step)),
            Once(a, b, of) => format!("(once {}: {})", past(*a, *b), of.text(step)),
            Historically(a, b, of) => format!("(historically {}: {})", past(*a, *b), of.text(step)),
            Until(a, b, p, q) => {
                format!("({} until {} {})", p.text(step), window(*a, *b), q.text(step))
            }
            Since(a, b, p, q) => {
                format!("({} since {} {})", p.text(step), past(*a, *b), q.text(step))
            }
        }
    }

    /// RTAMT notation, times in steps; `None` if RTAMT has no equivalent.
    pub fn rtamt(&self) -> Option<String> {
        let past = |b: Option<i64>, a: i64| b.map_or(String::new(), |b| format!("[{a}:{b}]"));
        Some(match self {
            Compare(how, a, b) => {
                let how = if *how == "!=" { "!==" } else { how };
                format!("({} {how} {})", a.rtamt()?, b.rtamt()?)
            }
            Near(a, b, tolerance) => {
                let apart = Num::Subtract(Box::new(a.clone()), Box::new(b.clone()));
                format!("(abs({}) <= {tolerance})", apart.rtamt()?)
            }
            Between(a, b, c) => {
                format!("(({0} < {1}) and ({1} <= {2}))", a.rtamt()?, b.rtamt()?, c.rtamt()?)
            }
            Changes(_) => return None,
            Rises(of) => format!("rise({})", of.rtamt()?),
            Falls(of) => format!("fall({})", of.rtamt()?),
            Not(of) => format!("(not({}))", of.rtamt()?),
            And(a, b) => format!("({} and {})", a.rtamt()?, b.rtamt()?),
            Or(a, b) => format!("({} or {})", a.rtamt()?, b.rtamt()?),
            Implies(a, b) => format!("({} -> {})", a.rtamt()?, b.rtamt()?),
            Eventually(a, b, of) => format!("(eventually[{a}:{b}]({}))", of.rtamt()?),
            Always(a, b, of) => format!("(always[{a}:{b}]({}))", of.rtamt()?),
            Once(a, b, of) => format!("(once{}({}))", past(*b, *a), of.rtamt()?),
            Historically(a, b, of) => {
                format!("(historically{}({}))", past(*b, *a), of.rtamt()?)
            }
            Until(a, b, p, q) => {
                format!("(({}) until[{a}:{b}] ({}))", p.rtamt()?, q.rtamt()?)
            }
            Since(a, b, p, q) => {
                format!("(({}) since{} ({}))", p.rtamt()?, past(*b, *a), q.rtamt()?)
            }
        })
    }

    /// Number of steps that it looks ahead.
    pub fn horizon(&self) -> i64 {
        match self {
            Compare(..) | Near(..) | Between(..) | Changes(_) => 0,
            Rises(of) | Falls(of) | Not(of) | Once(_, _, of) | Historically(_, _, of) => {
                of.horizon()
            }
            And(a, b) | Or(a, b) | Implies(a, b) | Since(_, _, a, b) => {
                a.horizon().max(b.horizon())
            }
            Eventually(_, to, of) | Always(_, to, of) => to + of.horizon(),
            Until(_, to, a, b) => to + a.horizon().max(b.horizon()),
        }
    }

    /// Whether a step of many nanoseconds means the same as a step of one. It does not for edges, which last a
    /// nanosecond, nor for `until` with a later window, which also reads its left side between two steps.
    pub fn is_coarse(&self) -> bool {
        match self {
            Compare(..) | Near(..) | Between(..) => true,
            Changes(_) | Rises(_) | Falls(_) => false,
            Not(of) => of.is_coarse(),
            And(a, b) | Or(a, b) | Implies(a, b) => a.is_coarse() && b.is_coarse(),
            Eventually(_, _, of) | Always(_, _, of) => of.is_coarse(),
            Once(_, _, of) | Historically(_, _, of) => of.is_coarse(),
            Until(from, _, a, b) | Since(from, _, a, b) => {
                *from == 0 && a.is_coarse() && b.is_coarse()
            }
        }
    }

    /// Collects the names of all its operators.
    pub fn operators(&self, into: &mut Vec<&'static str>) {
        let (name, of): (_, Vec<&Form>) = match self {
            Compare(how, ..) => (*how, vec![]),
            Near(..) => ("+-", vec![]),
            Between(..) => ("range", vec![]),
            Changes(_) => ("changes", vec![]),
            Rises(of) => ("rises", vec![of]),
            Falls(of) => ("falls", vec![of]),
            Not(of) => ("not", vec![of]),
            And(a, b) => ("and", vec![a, b]),
            Or(a, b) => ("or", vec![a, b]),
            Implies(a, b) => ("->", vec![a, b]),
            Eventually(_, _, of) => ("eventually", vec![of]),
            Always(_, _, of) => ("always", vec![of]),
            Once(_, None, of) => ("once unbounded", vec![of]),
            Once(_, _, of) => ("once", vec![of]),
            Historically(_, None, of) => ("historically unbounded", vec![of]),
            Historically(_, _, of) => ("historically", vec![of]),
            Until(0, _, a, b) => ("until", vec![a, b]),
            Until(_, _, a, b) => ("until later", vec![a, b]),
            Since(_, None, a, b) => ("since unbounded", vec![a, b]),
            Since(0, _, a, b) => ("since", vec![a, b]),
            Since(_, _, a, b) => ("since earlier", vec![a, b]),
        };
        into.push(name);
        of.into_iter().for_each(|of| of.operators(into));
    }
}
