//! What is no word: comments, and characters that begin nothing (docs/dialect.md, section 2).

use crate::diagnostics::{Check, Fault, Id, Span};
use crate::parser::Parser;
use crate::source::decode;
use crate::statements::{balanced, is_active};

impl Parser<'_, '_, '_> {
    /// `( .. )`: nested ones are counted; if they do not balance, the first `)` ends it.
    pub fn comment(&mut self) -> Check<()> {
        let open = self.r.pos;
        let rest = &self.r.text[open..];
        let Some(first) = rest.iter().position(|&b| b == b')') else {
            return Err(Fault::new(Id::GC108, Span::new(open, open + 1)));
        };
        let mut length = first + 1;
        if self.dialect.nested_comments && rest[1..first].contains(&b'(') {
            match balanced(rest) {
                Some(end) => length = end,
                None => self.faults.push(Fault::new(Id::GW906, Span::new(open, open + length))),
            }
        }
        self.r.pos = open + length;
        self.note(Span::new(open + 1, self.r.pos - 1));
        Ok(())
    }

    /// `(MSG, text)` is for the operator; other active comments are not.
    fn note(&mut self, inner: Span) {
        self.block.comment = Some(inner);
        let text = &self.r.text[inner.start as usize..inner.end as usize];
        let letters: Vec<u8> = text.iter().filter(|b| !b.is_ascii_whitespace()).take(8).copied().collect();
        let upper = letters.to_ascii_uppercase();
        if upper.starts_with(b"MSG,") {
            let comma = text.iter().position(|&b| b == b',').unwrap_or(0);
            self.block.message = Some(decode(&text[comma + 1..]).trim().to_owned());
        } else if [&b"DEBUG,"[..], b"PRINT,", b"LOG", b"PROBE"].iter().any(|name| is_active(&upper, name)) {
            self.faults.push(Fault::new(Id::GW907, Span::new(inner.start as usize - 1, self.r.pos)));
        }
    }

    /// What a character means that begins no word.
    #[cold]
    pub fn stray(&self, at: usize) -> Fault {
        let byte = self.r.at(at);
        let span = self.r.character(at);
        let foreign = |dialect: &str| Fault::with(Id::GC107, span, &[&char::from(byte), &dialect]);
        match byte {
            b'0'..=b'9' | b'.' | b'+' | b'-' => {
                let is_part = |b: &&u8| b.is_ascii_digit() || matches!(b, b'.' | b'+' | b'-');
                let length = self.r.text[at..].iter().take_while(is_part).count();
                Fault::new(Id::GC203, Span::new(at, at + length))
            }
            b')' => Fault::new(Id::GC109, span),
            b'/' => Fault::new(Id::GC211, span),
            b',' if self.r.at(at + 1).is_ascii_alphabetic() => {
                let letter = char::from(self.r.at(at + 1)).to_ascii_uppercase();
                Fault::with(Id::GC213, Span::new(at, at + 2), &[&letter])
            }
            b']' => Fault::new(Id::GC713, span),
            b'"' => Fault::new(Id::GC719, span),
            b'$' => foreign("Okuma or Sinumerik variable, grbl command, LinuxCNC spindle"),
            b'@' => foreign("Sinumerik command"),
            b'{' | b'}' => foreign("TwinCAT or Heidenhain"),
            b'!' | b'?' | b'&' | b'~' | b'\\' | b'`' | b'\'' => foreign("reserved"),
            b'*' if self.r.text[at + 1..].trim_ascii().is_empty() => foreign("Heidenhain end of block"),
            b'%' | b'*' | b',' | b'=' | b':' | b'[' | b'<' | b'>' => self.unexpected(at, span),
            0..=0x1F => Fault::with(Id::GC103, span, &[&format!("{byte:02X}")]),
            _ => {
                let c = decode(&self.r.text[span.start as usize..(span.end as usize).min(self.r.text.len())]);
                let c = c.chars().next().unwrap_or('?');
                Fault::with(Id::GC104, span, &[&c, &format!("{:04X}", c as u32)])
            }
        }
    }
    fn unexpected(&self, at: usize, span: Span) -> Fault {
        let context = if self.block.is_empty() { "the start of the block" } else { "the last word" };
        Fault::with(Id::GC220, span, &[&char::from(self.r.at(at)), &context])
    }
}
