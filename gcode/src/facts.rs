//! What a user interface wants to know about a program beside its commands.

use std::collections::HashMap;

use crate::group::Point;
use crate::modal::Codes;
use crate::part::Start;
use crate::sink::Merged;

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
        }
    }
    /// Notes the modal codes of a line.
    pub fn modal_changed(&mut self, line: u32, codes: Codes) {
        let texts = &mut self.modal_texts;
        let number = *self.known.entry(codes).or_insert_with(|| {
            texts.push(codes.to_string());
            texts.len() as u32 - 1
        });
        self.modal.push((line, number));
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
