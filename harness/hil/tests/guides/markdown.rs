//! Contents of a guide: commands with their output, files, and commands within sentences.

use pulldown_cmark::{CodeBlockKind, Event, Parser, Tag, TagEnd};

/// What commands need.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Needs {
    Nothing,
    AnotherTerminal,
    Can,
    Python,
    NotRun,
}

/// A command and its output in the guide.
#[derive(Debug, PartialEq, Eq)]
pub struct Command {
    /// Line of the page.
    pub at: usize,
    pub line: String,
    pub status: i32,
    pub shown: Vec<String>,
}

#[derive(Debug, PartialEq, Eq)]
pub enum Block {
    Commands { needs: Needs, commands: Vec<Command> },
    File { path: String, text: String },
}

#[derive(Debug)]
pub struct Guide {
    pub name: String,
    pub blocks: Vec<Block>,
}

impl Guide {
    /// Reads a guide; an error names the line of what a guide must not contain.
    pub fn read(name: &str, text: &str) -> Result<Self, String> {
        let mut guide = Self { name: name.to_owned(), blocks: Vec::new() };
        let mut fence: Option<(String, String)> = None;
        let mut spans = Vec::new();
        for (event, range) in Parser::new(text).into_offset_iter() {
            let at = text[..range.start].lines().count() + 1;
            match event {
                Event::Start(Tag::CodeBlock(CodeBlockKind::Indented)) => {
                    return Err(format!("{name}:{at}: an indented block, expected a fenced one"));
                }
                Event::Start(Tag::CodeBlock(CodeBlockKind::Fenced(info))) => {
                    fence = Some((info.to_string(), String::new()));
                }
                Event::Text(part) => {
                    if let Some((_, held)) = &mut fence {
                        held.push_str(&part);
                    }
                }
                Event::End(TagEnd::CodeBlock) => {
                    let (info, held) = fence.take().unwrap();
                    // The fence itself is the line before the text.
                    let block = block(&info, &held, at + 1);
                    guide.blocks.extend(block.map_err(|wrong| format!("{name}:{at}: {wrong}"))?);
                }
                Event::Code(code) if code.starts_with("hil ") => spans.push((at, code.to_string())),
                _ => {}
            }
        }
        for (at, span) in spans {
            if !guide.lines().any(|line| line.starts_with(&span)) {
                return Err(format!("{name}:{at}: `{span}` begins no command that is run"));
            }
        }
        Ok(guide)
    }

    fn lines(&self) -> impl Iterator<Item = &str> {
        let commands = self.blocks.iter().flat_map(|block| match block {
            Block::Commands { commands, .. } => commands.as_slice(),
            Block::File { .. } => &[],
        });
        commands.map(|command| command.line.as_str())
    }
}

fn block(info: &str, text: &str, at: usize) -> Result<Option<Block>, String> {
    let words: Vec<&str> = info.split_whitespace().collect();
    let needs = match words.as_slice() {
        ["console"] => Needs::Nothing,
        ["console", "another-terminal"] => Needs::AnotherTerminal,
        ["console", "needs-can"] => Needs::Can,
        ["console", "needs-python"] => Needs::Python,
        ["console", "not-run"] => Needs::NotRun,
        ["toml" | "python" | "rust" | "text"] => return Ok(None),
        ["toml" | "python", path] => {
            return Ok(Some(Block::File { path: (*path).to_owned(), text: text.to_owned() }));
        }
        _ => return Err(format!("a block `{info}`, which nobody runs")),
    };
    let mut commands: Vec<Command> = Vec::new();
    for (index, line) in text.lines().enumerate() {
        match (line.strip_prefix("$ "), commands.last_mut()) {
            (Some(line), _) => {
                let status = line.split_once("# exit status ").map(|(_, status)| status.trim());
                let status = status.map_or(Ok(0), str::parse).map_err(|_| "no exit status")?;
                let (line, shown) = (line.to_owned(), Vec::new());
                commands.push(Command { at: at + index, line, status, shown });
            }
            (None, Some(command)) => command.shown.push(line.to_owned()),
            (None, None) => return Err("output without a command".to_owned()),
        }
    }
    Ok(Some(Block::Commands { needs, commands }))
}
