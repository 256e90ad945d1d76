//! What can be jumped to or called in one file: subprograms, block numbers, the loops around them.

use std::collections::HashMap;
use std::rc::Rc;

use crate::block::OWord;
use crate::source::{Lines, Mark};
use crate::statements::{block_number, head_length, loop_word, o_word};

/// A block number that jumps may name.
#[derive(Clone, Debug)]
pub(crate) struct Label {
    pub mark: Mark,
    pub ambiguous: bool,
    /// The innermost loop around it.
    loops: Option<Rc<Around>>,
}

/// A loop and the one around it, shared by all labels inside.
#[derive(Debug)]
struct Around {
    offset: usize,
    outer: Option<Rc<Around>>,
}

/// Deeper loops cannot be opened: each needs a number of its own.
const MAX_OPEN: usize = 256;

impl Label {
    /// Offsets of the loops around it, outermost first.
    pub fn loops(&self) -> Vec<usize> {
        let chain = std::iter::successors(self.loops.as_deref(), |around| around.outer.as_deref());
        let mut offsets: Vec<usize> = chain.map(|around| around.offset).collect();
        offsets.reverse();
        offsets
    }
}

/// What can be jumped to or called in one file; built when first needed.
#[derive(Debug, Default)]
pub(crate) struct Index {
    pub subprograms: HashMap<String, (Mark, u32, Option<u32>)>,
    /// Offsets where a program or subprogram begins.
    pub regions: Vec<usize>,
    pub labels: HashMap<(usize, u32), Label>,
}

/// Name of a subprogram in `%L 100` or `%L NAME`, given the text behind `%`.
pub(crate) fn subprogram_name(text: &[u8]) -> Option<String> {
    let rest = text.strip_prefix(b"L").or(text.strip_prefix(b"l"))?;
    if rest.first().is_some_and(|b| b.is_ascii_alphabetic()) {
        return None;
    }
    let rest = rest.trim_ascii();
    let length = rest.iter().take_while(|b| b.is_ascii_alphanumeric() || **b == b'_').count();
    Some(plain(&rest[..length])).filter(|name| !name.is_empty())
}

/// A number without leading zeros, or a name.
fn plain(text: &[u8]) -> String {
    let text = String::from_utf8_lossy(text);
    text.parse::<u64>().map_or_else(|_| text.clone().into_owned(), |n| n.to_string())
}

/// Name of what a line begins: `%L 100`, `O100`, `:100`, `o100 sub`.
pub(crate) fn definition(text: &[u8]) -> Option<String> {
    let trimmed = text.trim_ascii();
    if let Some(rest) = trimmed.strip_prefix(b"%") {
        return subprogram_name(rest.trim_ascii());
    }
    let head = head_length(text);
    match text.get(head)? {
        b':' | b'O' | b'o' => {}
        _ => return None,
    }
    if let Some((label, word, _)) = o_word(text, head) {
        return (word == OWord::Sub).then_some(label);
    }
    let rest = text[head + 1..].trim_ascii_start();
    let digits = rest.iter().take_while(|b| b.is_ascii_digit()).count();
    (digits > 0).then(|| plain(&rest[..digits]))
}

pub(crate) fn build_index(source: &[u8]) -> Index {
    let mut index = Index::default();
    let mut lines = Lines::new(source);
    let mut open: Vec<(Rc<Around>, u8)> = Vec::new();
    loop {
        let at = lines.mark();
        let Some((line, text)) = lines.next_line() else { break };
        if let Some(name) = definition(text) {
            index.regions.push(at.offset);
            open.clear();
            let entry = (lines.mark(), line, None);
            index.subprograms.entry(name).and_modify(|e| e.2 = Some(e.1)).or_insert(entry);
        }
        if let Some(n) = block_number(text) {
            let region = index.regions.len();
            let loops = open.last().map(|l| l.0.clone());
            let label = Label { mark: at, ambiguous: false, loops };
            index.labels.entry((region, n)).and_modify(|l| l.ambiguous = true).or_insert(label);
        }
        match loop_word(text) {
            Some((true, level)) if open.len() < MAX_OPEN => {
                let outer = open.last().map(|l| l.0.clone());
                open.push((Rc::new(Around { offset: at.offset, outer }), level));
            }
            Some((false, level)) if open.last().is_some_and(|l| l.1 == level) => {
                open.pop();
            }
            _ => {}
        }
    }
    index
}
