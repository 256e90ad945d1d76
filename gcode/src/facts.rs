//! What a user interface wants to know about a program beside its commands.

use crate::group::{Point, SLOTS};
use crate::sink::Merged;

/// Facts per source line, kept as changes: cheap for programs of a million blocks.
#[derive(Clone, Debug, PartialEq)]
pub struct Facts {
    /// Smallest and largest machine position per slot of the group.
    pub low: Point,
    pub high: Point,
    /// Tools in the order in which M06 changed to them.
    pub tools: Vec<u32>,
    /// (line, modal text) wherever the modal codes changed.
    pub modal: Vec<(u32, String)>,
    /// (line, F in mm/min or degree/min) wherever the programmed feed changed.
    pub feeds: Vec<(u32, f64)>,
    /// Motion blocks as programmed, before merging.
    pub motion_blocks: u64,
    pub merged: Merged,
    /// Blocks executed, and lines read.
    pub blocks: u64,
    pub lines: u32,
}

impl Facts {
    pub fn new(start: &Point) -> Self {
        Facts {
            low: *start,
            high: *start,
            tools: Vec::new(),
            modal: Vec::new(),
            feeds: Vec::new(),
            motion_blocks: 0,
            merged: Merged::default(),
            blocks: 0,
            lines: 0,
        }
    }
    #[inline]
    pub fn reach(&mut self, point: &Point) {
        for slot in 0..SLOTS {
            self.low[slot] = self.low[slot].min(point[slot]);
            self.high[slot] = self.high[slot].max(point[slot]);
        }
    }
    /// The value that holds at a line of a list of changes.
    pub fn at<T>(changes: &[(u32, T)], line: u32) -> Option<&T> {
        let after = changes.partition_point(|change| change.0 <= line);
        changes[..after].last().map(|change| &change.1)
    }
}
