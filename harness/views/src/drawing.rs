//! A rig as a picture (SVG): lines as bars, nodes as boxes that stand on them.
//!
//! Texts are monospaced and boxes are as wide as their texts, so that no text leaves its box.

use maud::{Markup, PreEscaped, html};
use plan::Rig;
use plan::bench_file::{BenchFile, ControllerSection, Role};
use plan::faults::{LineKind, Ride};
use plan::rig::{NodePart, RigLine, UnderTest};

/// Advance of a character, and height of a text line, px.
const CHARACTER: usize = 8;
const TEXT_LINE: usize = 18;
/// Space around texts and between boxes.
const PAD: usize = 12;
/// Distance between two lines.
const LINE_STEP: usize = 40;
/// Longer texts in boxes, and longer titles, end in an ellipsis.
const CHARACTERS_MAX: usize = 36;
const TITLE_MAX: usize = 100;

const STYLE: &str = "\
text { font: 13px ui-monospace, 'DejaVu Sans Mono', Menlo, Consolas, monospace; fill: #1a1f2b; }
.name { font-weight: 700; } .soft { fill: #5b606b; }
.page { fill: #ffffff; } .line { stroke: #5b606b; stroke-width: 4; stroke-linecap: round; }
.stub { stroke: #5b606b; stroke-width: 1.5; } .dot { fill: #5b606b; }
.emulated { fill: #dbe6f8; stroke: #1f66d1; } .under_test { fill: #fdf0d5; stroke: #b06a00; stroke-width: 2.5; }
.tester { fill: #f0f1f4; stroke: #5b606b; } .replayed { fill: #efe3fa; stroke: #8a4fc9; }
.real { fill: #dcf3e6; stroke: #15794a; stroke-width: 2.5; }
@media (prefers-color-scheme: dark) {
text { fill: #e8ebf0; } .soft { fill: #a2a9b6; } .page { fill: #12151b; }
.line, .stub { stroke: #a2a9b6; } .dot { fill: #a2a9b6; }
.emulated { fill: #26364f; stroke: #6ea6ff; } .under_test { fill: #47371a; stroke: #e5a93a; }
.tester { fill: #262b35; stroke: #a2a9b6; } .replayed { fill: #372a4a; stroke: #c39bff; }
.real { fill: #1d3b2c; stroke: #43c586; } }
";

/// Role of a node in the harness.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    UnderTest,
    Emulated,
    Tester,
    Replayed,
    Real,
}

impl Kind {
    const fn class(self) -> &'static str {
        match self {
            Self::UnderTest => "under_test",
            Self::Emulated => "emulated",
            Self::Tester => "tester",
            Self::Replayed => "replayed",
            Self::Real => "real",
        }
    }

    const fn words(self) -> &'static str {
        match self {
            Self::UnderTest => "under test",
            Self::Emulated => "emulated",
            Self::Tester => "the plan",
            Self::Replayed => "from a log",
            Self::Real => "real",
        }
    }
}

struct Node {
    name: String,
    kind: Kind,
    /// What implements it, and where.
    detail: String,
    /// Its lines, by index in the picture.
    lines: Vec<usize>,
}

struct Line {
    name: String,
    detail: String,
}

/// Draws the rig; with `bench`, also which parts are real and at which port.
pub fn svg(title: &str, rig: &Rig, bench: Option<&BenchFile>) -> String {
    let (mut nodes, mut lines) = (Vec::new(), Vec::new());
    if let Some(ride) = rig.ride() {
        robot(ride, bench, &mut nodes, &mut lines);
    }
    lines.extend(rig.lines.iter().map(|line| line_of(line, bench)));
    // Nodes count lines from the robot's on, as here.
    for node in &rig.nodes {
        let (kind, detail) = played(&node.part);
        nodes.push(Node { name: node.name.clone(), kind, detail, lines: node.lines.clone() });
    }
    if rig.device().is_some()
        && let Some(Role::Real(port)) = bench.and_then(|bench| bench.device.as_ref())
        && let Some(node) = nodes.iter_mut().find(|node| node.kind == Kind::Emulated)
    {
        (node.kind, node.detail) = (Kind::Real, port.to_string());
    }
    picture(title, &nodes, &lines).into_string()
}

/// Adds the paper's robot or table: gyro, its carrier, and the controller.
fn robot(ride: Ride, bench: Option<&BenchFile>, nodes: &mut Vec<Node>, lines: &mut Vec<Line>) {
    let (carrier, medium) = match ride {
        Ride::Table => ("table", "serial"),
        Ride::Base(LineKind::Can) => ("base", "CAN"),
        Ride::Base(LineKind::Serial) => ("base", "serial"),
    };
    let is_table = carrier == "table";
    for (place, name) in ["gyro", carrier].into_iter().enumerate() {
        let detail = if place == 0 { "serial" } else { medium };
        lines.push(Line { name: name.to_owned(), detail: detail.to_owned() });
        let (kind, detail) = match bench.map(|bench| bench.role(name)) {
            Some(Role::Real(port)) => (Kind::Real, port.to_string()),
            Some(Role::Emulated(Some(port))) => (Kind::Emulated, port.to_string()),
            Some(Role::Emulated(None)) | None => (Kind::Emulated, String::new()),
        };
        nodes.push(Node { name: name.to_owned(), kind, detail, lines: vec![place] });
    }
    let detail = match bench.and_then(|bench| bench.controller.as_ref()) {
        Some(ControllerSection::Command(words)) => words.join(" "),
        Some(ControllerSection::Attach(place)) => place.to_string(),
        Some(ControllerSection::InProcess) | None => "in this process".to_owned(),
    };
    let reaches = if is_table { vec![0] } else { vec![0, 1] };
    nodes.push(Node {
        name: "controller".to_owned(),
        kind: Kind::UnderTest,
        detail,
        lines: reaches,
    });
    if is_table {
        let (name, detail) = ("plan".to_owned(), String::new());
        nodes.push(Node { name, kind: Kind::Tester, detail, lines: vec![1] });
    }
}

fn line_of(line: &RigLine, bench: Option<&BenchFile>) -> Line {
    let section = bench.and_then(|bench| bench.lines.get(&line.name));
    let port = section.map_or_else(String::new, |section| format!(", {}", section.port));
    Line { name: line.name.clone(), detail: format!("{line}{port}") }
}

fn played(part: &NodePart) -> (Kind, String) {
    match part {
        NodePart::Described(description) => (Kind::Emulated, description.title.clone()),
        NodePart::UnderTest(UnderTest::Command(words)) => (Kind::UnderTest, words.join(" ")),
        NodePart::UnderTest(UnderTest::InProcess(_)) => {
            (Kind::UnderTest, "in this process".to_owned())
        }
        NodePart::UnderTest(UnderTest::Attached(_)) => (Kind::UnderTest, "at its port".to_owned()),
        NodePart::Tester(..) => (Kind::Tester, String::new()),
        NodePart::Replayed(_) => (Kind::Replayed, String::new()),
    }
}

fn picture(title: &str, nodes: &[Node], lines: &[Line]) -> Markup {
    let title = cut(title, TITLE_MAX);
    let label =
        |line: &Line| shown(&line.name).chars().count().max(shown(&line.detail).chars().count());
    let margin = PAD + CHARACTER * lines.iter().map(label).max().unwrap_or(0) + PAD;
    let box_height = 3 * TEXT_LINE + PAD;
    let top = PAD + TEXT_LINE + PAD;
    let (mut boxes, mut right) = (Vec::new(), margin);
    for node in nodes {
        let words = [&node.name, node.kind.words(), &node.detail];
        let most = words.iter().map(|text| shown(text).chars().count()).max().unwrap_or(0);
        let width = CHARACTER * most + 2 * PAD;
        boxes.push((right, width));
        right += width + PAD;
    }
    let width = right.max(PAD + CHARACTER * title.chars().count() + PAD);
    let first_line = top + box_height + LINE_STEP;
    let y = |line: usize| first_line + line * LINE_STEP;
    let height = first_line + lines.len().saturating_sub(1) * LINE_STEP + 2 * PAD;
    html! {
        svg xmlns="http://www.w3.org/2000/svg" viewBox=(format!("0 0 {width} {height}")) width=(width) height=(height) {
            title { (&title) }
            style { (PreEscaped(STYLE)) }
            rect.page width=(width) height=(height) {}
            (text(PAD, PAD + TEXT_LINE - 5, "name", &title))
            @for (place, line) in lines.iter().enumerate() {
                (text(PAD, y(place) - 2, "name", &shown(&line.name)))
                (text(PAD, y(place) + TEXT_LINE - 4, "soft", &shown(&line.detail)))
                line.line x1=(margin) x2=(right - PAD) y1=(y(place)) y2=(y(place)) {}
            }
            @for (node, (x, wide)) in nodes.iter().zip(&boxes) {
                @for (port, line) in node.lines.iter().enumerate() {
                    @let at = x + wide * (port + 1) / (node.lines.len() + 1);
                    line.stub x1=(at) x2=(at) y1=(top + box_height) y2=(y(*line)) {}
                    circle.dot cx=(at) cy=(y(*line)) r="5" {}
                }
                rect.(node.kind.class()) x=(x) y=(top) width=(wide) height=(box_height) rx="6" {}
                (text(x + PAD, top + TEXT_LINE, "name", &shown(&node.name)))
                (text(x + PAD, top + 2 * TEXT_LINE, "", node.kind.words()))
                (text(x + PAD, top + 3 * TEXT_LINE, "soft", &shown(&node.detail)))
            }
        }
    }
}

fn text(x: usize, y: usize, class: &str, what: &str) -> Markup {
    html! { text class=(class) x=(x) y=(y) { (what) } }
}

fn shown(text: &str) -> String {
    cut(text, CHARACTERS_MAX)
}

fn cut(text: &str, characters: usize) -> String {
    let mut shown: String = text.chars().take(characters).collect();
    if text.chars().nth(characters).is_some() {
        shown.pop();
        shown.push('…');
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::{CHARACTER, Kind, Line, Node, PAD, picture};
    use scraper::{Html, Selector};

    fn number(element: scraper::ElementRef<'_>, name: &str) -> usize {
        element.attr(name).unwrap().parse().unwrap()
    }

    #[test]
    fn no_text_leaves_its_box_or_the_picture() {
        let node = |name: &str, kind, detail: &str, lines: &[usize]| Node {
            name: name.to_owned(),
            kind,
            detail: detail.to_owned(),
            lines: lines.to_vec(),
        };
        let long = "python3 manager.py {can0} --with more words than anybody would read";
        let nodes = [
            node("manager", Kind::UnderTest, long, &[0, 1]),
            node("<cells>", Kind::Real, "can:can0", &[0]),
            node("tester", Kind::Tester, "", &[1]),
        ];
        let line = |name: &str, detail: &str| Line { name: name.into(), detail: detail.into() };
        let lines =
            [line("can0", "CAN, 250 kbit/s"), line("uart", "serial, 9600 baud, pty:/tmp/x")];
        let svg = picture("A battery pack and its manager", &nodes, &lines).into_string();
        assert!(svg.contains("&lt;cells&gt;") && svg.contains('…'));
        let page = Html::parse_fragment(&svg);
        let all = |selector: &str| {
            let selector = Selector::parse(selector).unwrap();
            page.select(&selector).collect::<Vec<_>>()
        };
        let boxes: Vec<(usize, usize)> = all("rect[rx]")
            .into_iter()
            .map(|of| (number(of, "x"), number(of, "x") + number(of, "width")))
            .collect();
        assert_eq!(boxes.len(), 3);
        assert!(boxes.windows(2).all(|pair| pair[0].1 < pair[1].0), "{boxes:?}");
        let bars = all("line.line").into_iter().map(|of| number(of, "x1")).min().unwrap();
        for text in all("text") {
            let (x, words) = (number(text, "x"), text.text().collect::<String>());
            let end = x + CHARACTER * words.chars().count();
            let right = match boxes.iter().find(|(left, right)| (*left..*right).contains(&x)) {
                Some((_, right)) => *right,
                None if number(text, "y") > 40 => bars,
                None => number(all("svg")[0], "width"),
            };
            assert!(end + PAD <= right + 1, "\"{words}\" ends at {end}, {right} is there");
        }
        assert_eq!(all("circle").len(), 4);
    }
}
