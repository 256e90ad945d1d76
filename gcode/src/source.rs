//! File level (docs/dialect.md, section 1): is it text, where do lines end, how long may they be.

use crate::diagnostics::{Check, Fault, Id, Span, characters};

const MAX_LINE_CHARACTERS: usize = 1024;

/// Refuses what is no text at all: nothing else is worth reporting then.
pub fn check_text(source: &[u8], max_bytes: usize) -> Check<()> {
    let file = Span::new(0, 1);
    if source.len() > max_bytes {
        return Err(Fault::with(Id::GC106, file, &[&(max_bytes >> 20)]));
    }
    if is_wide(source) {
        return Err(Fault::new(Id::GC102, file));
    }
    let head = &source[leader(source)..];
    let head = &head[..head.len().min(4096)];
    let control = head.iter().filter(|&&b| b < 0x20 && !is_harmless(b)).count();
    if head.contains(&0) || control * 10 > head.len() {
        return Err(Fault::with(Id::GC101, file, &[&control.max(1)]));
    }
    Ok(())
}

/// UTF-16 or UTF-32 by byte order mark, or by every other byte of the beginning being NUL.
fn is_wide(source: &[u8]) -> bool {
    if source.starts_with(&[0xFF, 0xFE]) || source.starts_with(&[0xFE, 0xFF]) {
        return true;
    }
    let head = &source[..source.len().min(64) & !1];
    let (mut even, mut odd) = (0, 0);
    for pair in head.chunks_exact(2) {
        even += usize::from(pair[0] == 0 && pair[1] != 0);
        odd += usize::from(pair[1] == 0 && pair[0] != 0);
    }
    head.len() >= 4 && (even == head.len() / 2 || odd == head.len() / 2)
}

fn is_harmless(byte: u8) -> bool {
    matches!(byte, b'\t' | b'\n' | b'\r' | 0x0C | 0x03 | 0x11..=0x14 | 0x1A)
}

/// Length of what may stand before the first character: byte order mark, NUL and rub-out of a paper tape.
pub(crate) fn leader(source: &[u8]) -> usize {
    let mark = if source.starts_with(&[0xEF, 0xBB, 0xBF]) { 3 } else { 0 };
    mark + source[mark..].iter().take_while(|&&b| matches!(b, 0 | 0x7F)).count()
}

/// Length without the tape marks (DC1..DC4, SUB) and blanks at the very end.
pub(crate) fn trailer(source: &[u8]) -> usize {
    let is_end = |b: &&u8| matches!(**b, 0x11..=0x14 | 0x1A | b'\n' | b'\r' | b' ' | b'\t' | 0 | 3);
    source.len() - source.iter().rev().take_while(is_end).count()
}

/// A place between two lines of a source: jumps go back to one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Mark {
    pub offset: usize,
    /// Number of the line that starts here, from 1.
    pub line: u32,
}

/// Lines of a source, without their ends. LF, CR LF, CR and LF CR each end one line.
#[derive(Clone, Debug)]
pub struct Lines<'a> {
    source: &'a [u8],
    at: Mark,
}

impl<'a> Lines<'a> {
    pub fn new(source: &'a [u8]) -> Self {
        let (start, end) = (leader(source), trailer(source));
        Lines { source: &source[..end.max(start)], at: Mark { offset: start, line: 1 } }
    }
    /// Lines of a piece of a text, which begins with that line and ends with a line end.
    pub(crate) fn piece(source: &'a [u8], line: u32) -> Self {
        Lines { source, at: Mark { offset: 0, line } }
    }
    pub fn mark(&self) -> Mark {
        self.at
    }
    pub fn go(&mut self, mark: Mark) {
        self.at = mark;
    }
    /// The next line and its number.
    #[inline]
    pub fn next_line(&mut self) -> Option<(u32, &'a [u8])> {
        let rest = &self.source[self.at.offset..];
        if rest.is_empty() {
            return None;
        }
        let length = rest.iter().position(|&b| b == b'\n' || b == b'\r').unwrap_or(rest.len());
        let ends = match rest.get(length..length + 2) {
            Some(b"\r\n" | b"\n\r") => 2,
            _ => 1,
        };
        let line = self.at.line;
        self.at = Mark { offset: (self.at.offset + length + ends).min(self.source.len()), line: line + 1 };
        Some((line, &rest[..length]))
    }
}

/// One GC105 for a line that is too long, at column 1025.
#[inline]
pub fn check_length(line: &[u8]) -> Check<()> {
    if line.len() <= MAX_LINE_CHARACTERS { Ok(()) } else { check_long(line) }
}

#[cold]
fn check_long(line: &[u8]) -> Check<()> {
    let count = characters(line, line.len()) as usize;
    if count <= MAX_LINE_CHARACTERS {
        return Ok(());
    }
    // the span is in bytes: find the byte where character 1025 begins
    let wide = !line.is_ascii() && std::str::from_utf8(line).is_ok();
    let starts = line.iter().enumerate().filter(|(_, b)| !wide || **b & 0xC0 != 0x80);
    let at = starts.map(|(i, _)| i).nth(MAX_LINE_CHARACTERS).unwrap_or(MAX_LINE_CHARACTERS);
    Err(Fault::with(Id::GC105, Span::new(at, line.len()), &[&count]))
}

/// Text of comments and strings: UTF-8, else Windows-1252.
pub fn decode(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes.iter().map(|&b| windows_1252(b)).collect(),
    }
}

fn windows_1252(byte: u8) -> char {
    const HIGH: [char; 32] = [
        '€', '\u{81}', '‚', 'ƒ', '„', '…', '†', '‡', 'ˆ', '‰', 'Š', '‹', 'Œ', '\u{8d}', 'Ž', '\u{8f}', '\u{90}', '‘',
        '’', '“', '”', '•', '–', '—', '˜', '™', 'š', '›', 'œ', '\u{9d}', 'ž', 'Ÿ',
    ];
    match byte {
        0x80..=0x9F => HIGH[usize::from(byte - 0x80)],
        _ => char::from(byte),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(source: &[u8]) -> Vec<(u32, String)> {
        let mut lines = Lines::new(source);
        std::iter::from_fn(|| lines.next_line()).map(|(n, l)| (n, decode(l))).collect()
    }

    #[test]
    fn every_line_end_counts_once() {
        let want = [(1, "a"), (2, "b"), (3, ""), (4, "c"), (5, "d"), (6, "e")].map(|(n, t)| (n, t.to_owned()));
        assert_eq!(lines(b"a\nb\r\n\r\nc\rd\n\re\n\n\x1a"), want);
        assert_eq!(lines(b"\xEF\xBB\xBFG1")[0].1, "G1");
        assert!(lines(b"").is_empty());
    }

    #[test]
    fn what_is_no_text_is_refused() {
        let id = |source: &[u8]| check_text(source, 100).err().map(|f| f.id);
        assert_eq!(id(b"\xFF\xFEG\0"), Some(Id::GC102));
        assert_eq!(id(b"G\x001\0 \0X\0"), Some(Id::GC102));
        assert_eq!(id(b"G1 X\0"), Some(Id::GC101));
        assert_eq!(id(b"\x01\x02abc"), Some(Id::GC101));
        assert_eq!(id(&[b'a'; 101]), Some(Id::GC106));
        assert_eq!(id(b"\0\0\0%\nG1\n"), None);
    }

    #[test]
    fn a_long_line_is_measured_in_characters() {
        assert!(check_length("ä".repeat(1024).as_bytes()).is_ok());
        let fault = check_length("ä".repeat(1025).as_bytes()).unwrap_err();
        assert_eq!((fault.id, fault.span.start), (Id::GC105, 2048));
    }
}
