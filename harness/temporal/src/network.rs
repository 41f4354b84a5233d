//! A condition as a network of operators connected by streams.

use crate::formula::{Comparator, Condition, Interval, Width, distance, rounded};
use crate::number::Number;
use crate::operators::{Edge, Join, Reach, Until, Window};
use crate::stream::Stream;
use crate::truth::Truth;

/// Operators, each after its operands, and the output stream of each.
#[derive(Debug, Clone)]
pub(crate) struct Network {
    nodes: Vec<Node>,
    streams: Vec<Stream>,
}

/// An operator. Numbers are indices of its operands; each node is the operand of at most one other.
#[derive(Debug, Clone)]
enum Node {
    Compare(Comparator, Number, Number, Width),
    Near(bool, Number, Number, Number, Width),
    Changes(Number, Change, Width),
    Not(usize),
    Known(usize),
    Edge(usize, Edge),
    Join(usize, usize, Join),
    Window(usize, Window),
    Until(usize, usize, Box<Until>),
}

/// State of `changes`.
#[derive(Debug, Clone)]
struct Change {
    /// The last value; NaN before the first of one that is not known from the start.
    last: f64,
    /// When the nanosecond of the last change ends, and the truth during it.
    over: Option<(i64, Truth)>,
}

impl Network {
    pub(crate) fn new(condition: &Condition) -> Self {
        let mut network = Self { nodes: Vec::new(), streams: Vec::new() };
        network.add(condition);
        network
    }

    /// Starts the run at `at`.
    pub(crate) fn start(&mut self, at: i64) {
        for (node, stream) in self.nodes.iter().zip(&mut self.streams) {
            stream.start(at);
            if let Node::Known(_) = node {
                stream.push(at, Truth::FALSE);
            }
        }
    }

    /// The run ends: it has no moment from `end` on.
    pub(crate) fn end(&mut self, end: i64) {
        for node in &mut self.nodes {
            if let Node::Edge(_, edge) = node {
                edge.end(end);
            }
        }
    }

    pub(crate) fn root(&mut self) -> &mut Stream {
        let root = self.streams.len() - 1;
        &mut self.streams[root]
    }

    fn add(&mut self, condition: &Condition) -> usize {
        let node = match condition {
            Condition::Compare(how, a, b, width) => {
                Node::Compare(*how, a.clone(), b.clone(), *width)
            }
            Condition::Near(is_near, a, b, tolerance, width) => {
                Node::Near(*is_near, a.clone(), b.clone(), tolerance.clone(), *width)
            }
            Condition::Changes(of, width, before) => {
                let change = Change { last: *before, over: None };
                Node::Changes(of.clone(), change, *width)
            }
            Condition::Not(of) => Node::Not(self.add(of)),
            Condition::Known(of) => Node::Known(self.add(of)),
            Condition::Rises(of) => Node::Edge(self.add(of), Edge::new()),
            Condition::And(a, b) => Node::Join(self.add(a), self.add(b), Join::and()),
            Condition::Or(a, b) => Node::Join(self.add(a), self.add(b), Join::or()),
            Condition::Eventually(interval, of) => self.window(interval.after(), of, false, false),
            Condition::Always(interval, of) => self.window(interval.after(), of, true, false),
            Condition::Once(interval, of) => self.window(interval.before(), of, false, true),
            Condition::Historically(interval, of) => self.window(interval.before(), of, true, true),
            Condition::Until(interval, a, b) => {
                let until = Until::ahead(interval.from, interval.ahead());
                Node::Until(self.add(a), self.add(b), Box::new(until))
            }
            Condition::Since(interval, a, b) => {
                let since = Until::back(interval.from, interval.to);
                Node::Until(self.add(a), self.add(b), Box::new(since))
            }
        };
        self.nodes.push(node);
        self.streams.push(Stream::new());
        self.nodes.len() - 1
    }

    /// The distance of the deciding comparison from changing, in its unit.
    pub(crate) fn distance(&self, truth: Truth) -> Option<f64> {
        let range = self.width(truth).map_or(1.0, |width| width.range);
        truth.robustness().map(|share| share * range)
    }

    /// That unit, by its index among those of the formula.
    pub(crate) fn unit(&self, truth: Truth) -> Option<usize> {
        self.width(truth)?.unit
    }

    fn width(&self, truth: Truth) -> Option<Width> {
        match self.nodes.get(truth.comparison())? {
            Node::Compare(.., width) | Node::Near(.., width) | Node::Changes(.., width) => {
                Some(*width)
            }
            _ => None,
        }
    }

    fn window(&mut self, reach: Reach, of: &Condition, is_least: bool, clips: bool) -> Node {
        Node::Window(self.add(of), Window::new(reach, is_least, clips))
    }

    /// The signals have the values `slots` from `from` until just before `to`.
    pub(crate) fn run(&mut self, slots: &[f64], from: i64, to: i64) {
        for (index, node) in self.nodes.iter_mut().enumerate() {
            let (inputs, outputs) = self.streams.split_at_mut(index);
            let out = &mut outputs[0];
            match node {
                Node::Compare(how, a, b, width) => {
                    let truth = how.truth(a.value(slots), b.value(slots), *width);
                    out.push(from, truth.by(index));
                    out.know(to);
                }
                Node::Near(is_near, a, b, tolerance, width) => {
                    let (a, b) = (a.value(slots), b.value(slots));
                    let (apart, tolerance) = (distance(a, b), tolerance.value(slots));
                    let from_edge = rounded(apart, tolerance, a.abs().max(b.abs()));
                    let is_within = apart < tolerance || from_edge == 0.0;
                    let share = from_edge / width.range;
                    let truth = Truth::new(is_within == *is_near, share);
                    out.push(from, truth.by(index));
                    out.know(to);
                }
                Node::Changes(of, change, width) => {
                    change.run(of.value(slots), (from, to), (index, *width), out);
                    out.know(to);
                }
                Node::Not(of) => {
                    let input = &mut inputs[*of];
                    input.pour(|step| out.push(step.at, -step.truth));
                    out.know(input.known());
                }
                Node::Known(of) => {
                    let input = &mut inputs[*of];
                    input.pour(|step| {
                        let truth = if step.truth.is_known() { Truth::TRUE } else { Truth::FALSE };
                        out.push(step.at, truth);
                    });
                    out.know(input.known());
                }
                Node::Edge(of, edge) => edge.run(&mut inputs[*of], out),
                Node::Window(of, window) => window.run(&mut inputs[*of], out),
                Node::Join(a, b, join) => {
                    let (a, b) = pair(inputs, *a, *b);
                    join.run(a, b, out);
                }
                Node::Until(a, b, until) => {
                    let (a, b) = pair(inputs, *a, *b);
                    until.run(a, b, out);
                }
            }
        }
    }
}

impl Change {
    fn run(
        &mut self,
        value: f64,
        (from, to): (i64, i64),
        (comparison, width): (usize, Width),
        out: &mut Stream,
    ) {
        if let Some((over, truth)) = self.over.take_if(|(over, _)| *over < from) {
            out.push(over, truth);
        }
        let apart = distance(value, self.last);
        let is_first = self.last.is_nan() && !value.is_nan();
        let truth =
            if is_first { Truth::TRUE } else { Truth::new(apart > 0.0, apart / width.range) };
        out.push(from, truth.by(comparison));
        if !value.is_nan() {
            self.last = value;
        }
        let steady =
            if value.is_nan() { Truth::UNKNOWN } else { Truth::new(false, 0.0).by(comparison) };
        let over = from.saturating_add(1);
        if over < to {
            out.push(over, steady);
            self.over = None;
        } else {
            self.over = Some((over, steady));
        }
    }
}

impl Interval {
    fn after(self) -> Reach {
        Reach { from: Some(self.from), to: self.ahead() }
    }

    fn before(self) -> Reach {
        Reach { from: self.to.map(|to| -to), to: -self.from }
    }
}

/// Two streams of a slice; `first` is before `second`.
fn pair(streams: &mut [Stream], first: usize, second: usize) -> (&mut Stream, &mut Stream) {
    let (left, right) = streams.split_at_mut(second);
    (&mut left[first], &mut right[0])
}
