//! What a user interface wants to know about a program beside its commands.

use std::collections::HashMap;

use crate::group::Point;
use crate::merging::Merged;
use crate::modal::Codes;
use crate::part::Start;

/// Tool changes that are remembered.
const MAX_TOOLS: usize = 10_000;

/// Facts per source line, kept as changes: cheap for programs of a million blocks.
#[derive(Clone, Debug, PartialEq)]
pub struct Facts {
    /// Smallest and largest machine position per slot of the group.
    pub low: Point,
    pub high: Point,
    /// Tools in the order in which M06 changed to them.
    pub tools: Vec<u32>,
    /// (line, index into `modal_texts`) wherever the modal codes changed.
    pub modal: Vec<(u32, u32)>,
    /// "G1 G17 G90 G21 G94 G40 G49 G64 G54" and so on, each once.
    pub modal_texts: Vec<String>,
    known: HashMap<Codes, u32>,
    /// (line, F in mm/min or degree/min) wherever the programmed feed changed.
    pub feeds: Vec<(u32, f64)>,
    /// Motion blocks as programmed, before merging.
    pub motion_blocks: u64,
    pub merged: Merged,
    /// Blocks executed, and lines read.
    pub blocks: u64,
    pub lines: u32,
    /// State at the first block of a part.
    pub start: Option<Start>,
    /// It jumps, loops or calls: commands do not come in the order of the lines.
    pub looks_back: bool,
    /// Changes that `modal` and `feeds` are to hold; a longer list is empty.
    pub most_changes: usize,
}

impl Facts {
    pub fn new(start: &Point) -> Self {
        Facts {
            low: *start,
            high: *start,
            tools: Vec::new(),
            modal: Vec::new(),
            modal_texts: Vec::new(),
            known: HashMap::new(),
            feeds: Vec::new(),
            motion_blocks: 0,
            merged: Merged::default(),
            blocks: 0,
            lines: 0,
            start: None,
            looks_back: false,
            most_changes: usize::MAX,
        }
    }
    /// Notes the modal codes of a line.
    pub fn modal_changed(&mut self, line: u32, codes: Codes) {
        if self.modal.len() > self.most_changes {
            return;
        }
        let texts = &mut self.modal_texts;
        let number = *self.known.entry(codes).or_insert_with(|| {
            texts.push(codes.to_string());
            texts.len() as u32 - 1
        });
        note(&mut self.modal, line, number);
    }
    /// Notes the feed of a line, mm/min or degree/min.
    pub fn feed_changed(&mut self, line: u32, feed: f64) {
        if self.feeds.len() <= self.most_changes {
            note(&mut self.feeds, line, feed);
        }
    }
    /// Nothing more comes.
    pub fn settle(&mut self) {
        if self.modal.len() > self.most_changes {
            self.modal = Vec::new();
        }
        if self.feeds.len() > self.most_changes {
            self.feeds = Vec::new();
        }
    }
    /// Notes a tool change; a loop of them is not remembered for ever.
    pub fn tool_changed(&mut self, tool: u32) {
        if self.tools.len() < MAX_TOOLS {
            self.tools.push(tool);
        }
    }
    /// Modal codes as an operator reads them, at a line.
    pub fn modal_at(&self, line: u32) -> &str {
        Self::at(&self.modal, line).map_or("", |number| self.modal_texts[*number as usize].as_str())
    }
    /// The value that holds at a line of a list of changes.
    pub fn at<T>(changes: &[(u32, T)], line: u32) -> Option<&T> {
        let after = changes.partition_point(|change| change.0 <= line);
        changes[..after].last().map(|change| &change.1)
    }
}

/// Keeps a list of changes sorted, one entry a line: the newest. Loops and subprograms come back to lines.
fn note<T>(changes: &mut Vec<(u32, T)>, line: u32, value: T) {
    if changes.last().is_none_or(|last| last.0 < line) {
        return changes.push((line, value));
    }
    match changes.binary_search_by_key(&line, |change| change.0) {
        Ok(at) => changes[at].1 = value,
        Err(at) => changes.insert(at, (line, value)),
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn changes_are_sorted_by_line_and_the_newest_counts() {
        let mut changes = Vec::new();
        for (line, value) in [(3, 'a'), (7, 'b'), (5, 'c'), (3, 'd'), (9, 'e')] {
            super::note(&mut changes, line, value);
        }
        assert_eq!(changes, [(3, 'd'), (5, 'c'), (7, 'b'), (9, 'e')]);
        assert_eq!(super::Facts::at(&changes, 6), Some(&'c'));
    }
}
