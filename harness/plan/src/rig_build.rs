//! Builds a rig from its file. Errors carry their place.

mod check;
mod replayed;
mod words;

use crate::device_files::{DevicesError, load_devices};
use crate::faults::Target;
use crate::library::{Kind, Library, LibraryError, Source};
use crate::replayed::Logged;
use crate::rig::{
    LINES_MAX, NODES_MAX, NodePart, NodeTable, Rig, RigFile, RigLine, RigNode, UnderTest,
    VirtualTime,
};
use crate::speakers::Speaker;
use described::hint;
use described::{Dbc, Dbcs, Description, FileError, IsoTp, Layout, Medium, Place, Sender};
use miette::Diagnostic as _;
use std::collections::BTreeMap;
use std::sync::Arc;
use wire::serial::SerialSettings;

/// Why a rig cannot be built.
pub trait Cause: From<LibraryError> + From<DevicesError> + From<Box<FileError>> {}

impl<E: From<LibraryError> + From<DevicesError> + From<Box<FileError>>> Cause for E {}

/// The entries of a bus log, and what is doubtful in it.
pub type LogRead = (Vec<Logged>, Vec<String>);

/// Loads the files that a rig file names, where that needs more than a library.
#[derive(Debug)]
pub struct Parts<E> {
    /// The description of a device by its name, with the DBCs that are known already.
    pub description: fn(&Library, &str, &mut Dbcs) -> Result<Description, E>,
    /// A bus log.
    pub log: fn(&Source) -> Result<LogRead, E>,
}

/// Reads the rig with this name or path.
///
/// # Errors
/// The first mistake, with its place.
pub fn load<E: Cause>(library: &Library, name: &str, parts: &Parts<E>) -> Result<Rig, E> {
    let source = library.open(Kind::Rig, name)?;
    let file: RigFile = source.parse()?;
    let mut builder = Builder {
        library,
        source: &source,
        parts,
        known: Dbcs::default(),
        rig: Rig::default(),
        dbcs: BTreeMap::new(),
        protected: BTreeMap::new(),
    };
    builder.lines(&file)?;
    builder.nodes(&file)?;
    builder.note_shared_identifiers();
    // `devices` in a plan stands for the paper's robot alone.
    builder.rig.is_short = file.lines.is_empty() && file.nodes.is_empty();
    Ok(builder.rig)
}

struct Builder<'a, E> {
    library: &'a Library,
    source: &'a Source,
    parts: &'a Parts<E>,
    /// Those of lines and of devices.
    known: Dbcs,
    rig: Rig,
    /// The DBCs of each line that has some.
    dbcs: BTreeMap<usize, Vec<Arc<Dbc>>>,
    /// Their messages, with the counters and checksums that the line states.
    protected: BTreeMap<usize, Layout>,
}

impl<E: Cause> Builder<'_, E> {
    /// A mistake at the `number`-th table with this name, at its `key` if it has that.
    fn mistake(
        &self,
        at: (&str, usize, &str),
        message: String,
        help: Option<String>,
    ) -> LibraryError {
        let (table, number, key) = at;
        let place = Place::file().key(table).index(number).entry(key);
        self.source.mistake(place.locate(&self.source.text), message, help)
    }

    /// The file of that name beside the rig file, named at the `number`-th table.
    fn beside(&self, name: &str, at: (&str, usize, &str)) -> Result<Source, LibraryError> {
        self.library.open_beside(self.source, name).map_err(|error| {
            self.mistake(at, error.to_string(), error.help().map(|help| help.to_string()))
        })
    }

    fn lines(&mut self, file: &RigFile) -> Result<(), E> {
        if file.lines.len() > LINES_MAX {
            let message = format!("{} lines, expected at most {LINES_MAX}", file.lines.len());
            return Err(self.mistake(("line", LINES_MAX, "name"), message, None).into());
        }
        if let Some(devices) = &file.devices {
            self.rig.robot = Some(Box::new(load_devices(self.library, devices.as_str())?));
        }
        for (number, line) in file.lines.iter().enumerate() {
            let name = line.name.as_str();
            let again = self.rig.lines.iter().any(|known| known.name == name);
            if again || (self.rig.robot.is_some() && ["gyro", "base", "table"].contains(&name)) {
                let message = format!("two lines are called `{name}`");
                return Err(self.mistake(("line", number, "name"), message, None).into());
            }
            if [Target::Host, Target::Operator].iter().any(|target| target.name() == name) {
                let message = format!("`{name}` has a meaning of its own in plans");
                let help = "call the line otherwise: faults could not strike it".to_owned();
                return Err(self.mistake(("line", number, "name"), message, Some(help)).into());
            }
            let mut declared = RigLine {
                name: name.to_owned(),
                medium: Medium::Can,
                bit_rate: line.can.as_ref().and_then(|can| can.bit_rate),
                data_bit_rate: line.can.as_ref().and_then(|can| can.data_bit_rate),
            };
            match (&line.can, &line.serial) {
                (Some(can), None) => {
                    self.check_rates(&declared, number)?;
                    let mut dbcs = Vec::new();
                    for dbc in can.dbc.iter().flat_map(|dbc| dbc.as_slice()) {
                        let Source { origin, text } = self.beside(dbc, ("line", number, "can"))?;
                        dbcs.push(self.known.get(&origin, &text).map_err(Box::new)?);
                    }
                    if !dbcs.is_empty() {
                        // Reports what they contradict each other in, whichever nodes are on the line.
                        let layout = Layout::from_dbcs(&dbcs, &|_| false).map_err(Box::new)?;
                        self.check_carries(&declared, &layout, ("line", number, "can"))?;
                        let layout = self.protected(layout, number, line)?;
                        self.protected.insert(number, layout);
                        self.dbcs.insert(number, dbcs);
                    }
                }
                // The device on the line determines its settings.
                (None, Some(_)) => {
                    declared.medium = Medium::Serial(SerialSettings::new_8n1(9_600));
                }
                _ => {
                    let message = format!("line `{name}` is neither CAN nor serial");
                    let help = "write `can = { dbc = \"...\" }` or `serial = {}`".to_owned();
                    let at = ("line", number, "name");
                    return Err(self.mistake(at, message, Some(help)).into());
                }
            };
            if !line.messages.is_empty() && !self.dbcs.contains_key(&number) {
                let message = format!("line `{name}` has no DBC with messages");
                let help = "what a described device sends, its own file protects".to_owned();
                return Err(self.mistake(("line", number, "message"), message, Some(help)).into());
            }
            self.rig.lines.push(declared);
        }
        Ok(())
    }

    fn check_rates(&self, line: &RigLine, number: usize) -> Result<(), LibraryError> {
        let refuse =
            |message: &str| Err(self.mistake(("line", number, "can"), message.to_owned(), None));
        if !(10_000..=1_000_000).contains(&line.rates().nominal) {
            return refuse("expected 10,000 to 1,000,000 bits per second");
        }
        match line.data_bit_rate {
            Some(rate) if !(line.rates().nominal..=8_000_000).contains(&rate) => {
                refuse("expected a `data_bit_rate` from `bit_rate` to 8,000,000 bits per second")
            }
            _ => Ok(()),
        }
    }

    fn nodes(&mut self, file: &RigFile) -> Result<(), E> {
        if file.nodes.is_empty() && file.devices.is_none() {
            let message = "a rig without a node, expected at least one [[node]]".to_owned();
            return Err(self.mistake(("node", 0, "name"), message, None).into());
        }
        if file.nodes.len() + 2 > NODES_MAX {
            let message = format!("{} nodes, expected at most {}", file.nodes.len(), NODES_MAX - 2);
            return Err(self.mistake(("node", NODES_MAX - 2, "name"), message, None).into());
        }
        let of_robot = self.rig.robot_lines();
        // Devices with a description first: they determine the settings of a serial line and its messages.
        let order = |node: &NodeTable| {
            usize::from(node.description().is_none()) + usize::from(node.tester == Some(true))
        };
        let mut numbers: Vec<usize> = (0..file.nodes.len()).collect();
        numbers.sort_by_key(|number| order(&file.nodes[*number]));
        let mut built: Vec<(usize, RigNode)> = Vec::new();
        for number in numbers {
            let node = &file.nodes[number];
            let name = node.name.as_str();
            self.check_name(file, number)?;
            let mut lines = Vec::new();
            for line in node.at.as_slice() {
                let known: Vec<&str> =
                    self.rig.lines.iter().map(|line| line.name.as_str()).collect();
                let robot = match (line.as_str(), self.rig.robot.is_some()) {
                    ("base", true) => Some(1),
                    _ => None,
                };
                let place = known.iter().position(|known| *known == line.as_str());
                let Some(place) = place.map(|place| place + of_robot).or(robot) else {
                    let message = format!("no line `{line}` for `{name}`");
                    let help = Some(hint::proposal(line.as_str(), &known));
                    return Err(self.mistake(("node", number, "at"), message, help).into());
                };
                lines.push(place);
            }
            if lines.is_empty() {
                let message = format!("`{name}` is on no line");
                return Err(self.mistake(("node", number, "at"), message, None).into());
            }
            let (part, channel) = self.part(file, number, &lines)?;
            self.check_ends((file, number), &lines, &built)?;
            let virtual_time = self.virtual_time(file, number)?;
            let isotp = self.isotp(node, number)?.or(channel);
            let name = name.to_owned();
            built.push((number, RigNode { name, part, lines, virtual_time, isotp }));
        }
        built.sort_by_key(|(number, _)| *number);
        self.rig.nodes = built.into_iter().map(|(_, node)| node).collect();
        Ok(())
    }

    fn virtual_time(&self, file: &RigFile, number: usize) -> Result<VirtualTime, LibraryError> {
        let node = &file.nodes[number];
        let Some(said) = node.virtual_time else { return Ok(VirtualTime::default()) };
        let refuse =
            |message: String| Err(self.mistake(("node", number, "virtual_time"), message, None));
        if !matches!(node.under_test, Some(UnderTest::Command(_))) {
            return refuse(format!("`{}` is no program that is started", node.name));
        }
        said.mistake().map_or(Ok(said), |mistake| refuse(mistake.to_owned()))
    }

    fn line(&self, line: usize) -> Option<&RigLine> {
        self.rig.lines.get(line.checked_sub(self.rig.robot_lines())?)
    }

    /// A node's kind, and the channel for diagnostic requests that its description states.
    fn part(
        &mut self,
        file: &RigFile,
        number: usize,
        lines: &[usize],
    ) -> Result<(NodePart, Option<IsoTp>), E> {
        let node = &file.nodes[number];
        let said = [
            node.emulate.is_some(),
            node.under_test.is_some(),
            node.tester == Some(true),
            node.replay.is_some(),
        ];
        if said.iter().filter(|said| **said).count() != 1 {
            let message = format!(
                "`{}` needs exactly one of `emulate`, `under_test`, `tester = true` and `replay`",
                node.name
            );
            let help = "it says what plays this node".to_owned();
            return Err(self.mistake(("node", number, "name"), message, Some(help)).into());
        }
        if node.under_test.as_ref().is_some_and(|how| *how == UnderTest::Command(Vec::new())) {
            let message = format!("no program in the command of `{}`", node.name);
            let help = "write the program and its arguments, or `under_test = { attached = true }`";
            let at = ("node", number, "under_test");
            return Err(self.mistake(at, message, Some(help.to_owned())).into());
        }
        self.check_ports(node, number)?;
        if node.emulate.is_none() && !node.set.is_empty() {
            let message = format!("`{}` is not emulated from a file", node.name);
            let help = "`set` is of parameters of an `emulate`d device".to_owned();
            return Err(self.mistake(("node", number, "set"), message, Some(help)).into());
        }
        if let (Some(_), None) = (&node.described_by, &node.under_test) {
            let message = format!("`{}` is not under test", node.name);
            let help = "`described_by` names the messages of a device under test".to_owned();
            return Err(self.mistake(("node", number, "described_by"), message, Some(help)).into());
        }
        if let Some((key, name)) = node.description() {
            let description = self.described(node, (number, key, name), lines)?;
            let channel = description.isotp().cloned();
            let part = match &node.under_test {
                Some(how) => NodePart::UnderTest(how.clone()),
                None => NodePart::Described(Arc::new(description)),
            };
            return Ok((part, channel));
        }
        if node.tester == Some(true) && lines.len() > 1 {
            let message = format!("the tester `{}` is on several lines", node.name);
            let help = "give each line a tester of its own".to_owned();
            return Err(self.mistake(("node", number, "at"), message, Some(help)).into());
        }
        let mut tester = None;
        for line in lines {
            let words = self.words(file, number, *line)?;
            let Some((mut layout, sender)) = self.with_channel(node, number, words)? else {
                continue;
            };
            if node.tester == Some(true) {
                if sender == Sender::Device {
                    layout = self.asking(layout, number, *line)?;
                }
                self.check_alone(file, number, *line, &layout)?;
            }
            tester.get_or_insert((layout.clone(), sender));
            self.speak(node, *line, layout, sender);
        }
        if let Some(replay) = &node.replay {
            return Ok((self.replayed(number, replay, (node, lines))?, None));
        }
        match (&node.under_test, tester) {
            (Some(how), _) => Ok((NodePart::UnderTest(how.clone()), None)),
            (None, Some((layout, sender))) => Ok((NodePart::Tester(layout, sender), None)),
            (None, None) => {
                let message = format!("nothing is known of what `{}` could send", node.name);
                let help =
                    "give its line a DBC, or a device whose messages are described".to_owned();
                Err(self.mistake(("node", number, "at"), message, Some(help)).into())
            }
        }
    }

    /// The description of a node, which determines the messages of its line.
    fn described(
        &mut self,
        node: &NodeTable,
        (number, key, description): (usize, &'static str, &str),
        lines: &[usize],
    ) -> Result<Description, E> {
        let load = self.parts.description;
        let mut description = load(self.library, description, &mut self.known)?;
        for (name, value) in &node.set {
            let set = description.set_parameter(name, *value);
            set.map_err(|message| self.mistake(("node", number, "set"), message, None))?;
        }
        let layout = description.layout().clone();
        let of_robot = self.rig.robot_lines();
        let [line] = lines else {
            let message = format!("`{}` is described by a file, on one line alone", node.name);
            return Err(self.mistake(("node", number, "at"), message, None).into());
        };
        if let Some(line) = self.line(*line) {
            self.check_carries(line, &layout, ("node", number, "at"))?;
        }
        self.check_agrees(&layout, (node, number, key), *line)?;
        let other = self.rig.speakers.iter().find(|known| known.line == *line);
        let other = other.map(|other| (other.node.clone(), other.layout.medium()));
        let known = line.checked_sub(of_robot).and_then(|place| self.rig.lines.get_mut(place));
        match (known, layout.medium()) {
            (
                Some(RigLine { medium: medium @ Medium::Serial(_), .. }),
                Medium::Serial(settings),
            ) => {
                *medium = Medium::Serial(settings);
                if let Some((other, _)) = other.filter(|(_, medium)| *medium != layout.medium()) {
                    let message =
                        format!("`{}` and `{other}` have other settings of one line", node.name);
                    let help = "`[serial]` is the same in the files of both".to_owned();
                    return Err(self.mistake(("node", number, key), message, Some(help)).into());
                }
            }
            (Some(RigLine { medium: Medium::Can, .. }) | None, Medium::Can) => {}
            _ => {
                let message =
                    format!("`{}` is on the other kind of line by its description", node.name);
                return Err(self.mistake(("node", number, "at"), message, None).into());
            }
        }
        self.speak(node, *line, layout, Sender::Device);
        Ok(description)
    }

    fn speak(&mut self, node: &NodeTable, line: usize, layout: Layout, sender: Sender) {
        self.rig.speakers.push(Speaker {
            node: node.name.as_str().to_owned(),
            line,
            line_name: self.rig.line_name(line).to_owned(),
            layout,
            sender,
        });
    }
}
