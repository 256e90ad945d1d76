//! Statements of a block: IF, GOTO, WHILE, DO, END, write, and O-words (docs/dialect.md, sections 3, 15.3, 15.4).

use crate::block::{Item, OWord, Statement};
use crate::diagnostics::{Check, Fault, Id, Span};
use crate::parser::{Parser, set_statement};
use crate::source::decode;

const MAX_TEXT: usize = 512;

pub(crate) const O_WORDS: &[(&str, OWord)] = &[
    ("sub", OWord::Sub),
    ("endsub", OWord::EndSub),
    ("call", OWord::Call),
    ("return", OWord::Return),
    ("if", OWord::If),
    ("elseif", OWord::ElseIf),
    ("else", OWord::Else),
    ("endif", OWord::EndIf),
    ("while", OWord::While),
    ("endwhile", OWord::EndWhile),
    ("do", OWord::Do),
    ("repeat", OWord::Repeat),
    ("endrepeat", OWord::EndRepeat),
    ("break", OWord::Break),
    ("continue", OWord::Continue),
];

/// Reads a statement if `word` is a keyword; false if it is none.
pub(crate) fn keyword(p: &mut Parser, word: &[u8]) -> Check<bool> {
    let at = p.r.pos;
    let upper = String::from_utf8_lossy(word).to_ascii_uppercase();
    let span = Span::new(at, at + word.len());
    let known = matches!(upper.as_str(), "IF" | "GOTO" | "WHILE" | "DO" | "END" | "THEN" | "WRITE" | "WRITELN");
    if !known || !p.dialect.macros && !upper.starts_with("WRITE") {
        return Ok(false);
    }
    p.r.pos += word.len();
    let statement = match upper.as_str() {
        "IF" => if_statement(p, span)?,
        "GOTO" => goto(p, true, span)?,
        "WHILE" => while_loop(p, span)?,
        "DO" => Statement::While { condition: true, level: level(p)?, span },
        "END" => Statement::End { level: level(p)?, span },
        "THEN" => return Err(Fault::with(Id::GC610, span, &[&"IF"])),
        _ => write(p, upper == "WRITELN", span)?,
    };
    alone(p, span)?;
    set_statement(p, statement, at);
    Ok(true)
}

/// A statement stands alone in its block, after N.
fn alone(p: &mut Parser, span: Span) -> Check<()> {
    let before = p.block.mask & !crate::block::bit(b'N') != 0 || !p.block.g.is_empty() || !p.block.m.is_empty();
    p.r.blanks();
    let is_then = matches!(p.block.statement, Some(Statement::Done));
    if before || p.block.statement.is_some() && !is_then {
        return Err(Fault::new(Id::GC609, span));
    }
    if matches!(p.r.peek(), 0 | b'(' | b';') { Ok(()) } else { Err(Fault::new(Id::GC609, p.r.character(p.r.pos))) }
}

fn condition(p: &mut Parser) -> Check<bool> {
    p.r.blanks();
    if p.r.peek() != b'[' {
        return Err(Fault::with(Id::GC610, p.r.character(p.r.pos), &[&"'['"]));
    }
    Ok(p.r.bracket()? != 0.0)
}

fn next_keyword(p: &mut Parser) -> String {
    p.r.blanks();
    let word = p.r.letters(p.r.pos, false);
    String::from_utf8_lossy(word).to_ascii_uppercase()
}

fn if_statement(p: &mut Parser, span: Span) -> Check<Statement> {
    let taken = condition(p)?;
    match next_keyword(p).as_str() {
        "GOTO" => {
            p.r.pos += 4;
            goto(p, taken, span)
        }
        "THEN" => {
            p.r.pos += 4;
            p.r.blanks();
            then(p, taken)?;
            Ok(Statement::Done)
        }
        _ => Err(Fault::with(Id::GC610, p.r.character(p.r.pos), &[&"GOTO or THEN"])),
    }
}

/// The assignment behind THEN is read in any case, but kept only if the condition holds.
fn then(p: &mut Parser, taken: bool) -> Check<()> {
    let at = p.r.pos;
    let count = p.r.assigned.len();
    let result = assignment(p, at);
    if !taken {
        // values that only hold under the condition must not raise errors
        p.r.assigned.truncate(count);
        if let Err(fault) = &result
            && (Id::GC702..=Id::GC706).contains(&fault.id) | (Id::GC710..=Id::GC712).contains(&fault.id)
        {
            p.r.pos = p.r.text.len();
            return Ok(());
        }
    }
    result
}

fn assignment(p: &mut Parser, at: usize) -> Check<()> {
    if p.r.peek() == b'#' {
        let variable = p.r.hash_variable()?;
        return p.assignment(variable, at);
    }
    if let Some(variable) = p.r.common()? {
        return p.assignment(variable, at);
    }
    let word = p.r.letters(at, true);
    if word.len() < 2 {
        return Err(Fault::with(Id::GC610, p.r.character(at), &[&"assignment"]));
    }
    let name = crate::expression::short(&String::from_utf8_lossy(word));
    p.r.pos += word.len();
    p.assignment(crate::variables::Variable::Name(name), at)
}

fn goto(p: &mut Parser, taken: bool, span: Span) -> Check<Statement> {
    p.r.blanks();
    if matches!(p.r.peek(), 0 | b'(' | b';') {
        return Err(Fault::with(Id::GC610, span, &[&"block number"]));
    }
    if matches!(p.r.peek(), b'N' | b'n') {
        p.r.pos += 1;
    }
    let at = p.r.pos;
    let target = p.r.expression()?;
    Ok(Statement::Goto { taken, target, span: Span::new(at, p.r.pos) })
}

fn while_loop(p: &mut Parser, span: Span) -> Check<Statement> {
    let condition = condition(p)?;
    if next_keyword(p) != "DO" {
        return Err(Fault::with(Id::GC610, p.r.character(p.r.pos), &[&"DO"]));
    }
    p.r.pos += 2;
    Ok(Statement::While { condition, level: level(p)?, span })
}

fn level(p: &mut Parser) -> Check<u8> {
    p.r.blanks();
    let digit = p.r.peek();
    if !(b'1'..=b'9').contains(&digit) || p.r.at(p.r.pos + 1).is_ascii_digit() {
        return Err(Fault::with(Id::GC610, p.r.character(p.r.pos), &[&"loop number 1..9"]));
    }
    p.r.pos += 1;
    Ok(digit - b'0')
}

/// `write item {, item}`; parentheses are tolerated where a string follows them.
fn write(p: &mut Parser, line: bool, span: Span) -> Check<Statement> {
    let mut items = Vec::new();
    p.r.blanks();
    let parentheses = p.r.peek() == b'(' && {
        let rest = &p.r.text[p.r.pos + 1..];
        let blanks = rest.iter().take_while(|b| matches!(b, b' ' | b'\t')).count();
        quote(&rest[blanks..]) > 0
    };
    p.r.pos += usize::from(parentheses);
    p.r.blanks();
    if !(line && matches!(p.r.peek(), 0 | b';')) {
        loop {
            p.r.blanks();
            items.push(if quote(&p.r.text[p.r.pos..]) > 0 { string(p)? } else { value(p)? });
            p.r.blanks();
            if p.r.peek() != b',' {
                break;
            }
            p.r.pos += 1;
        }
    }
    if parentheses {
        if p.r.peek() != b')' {
            return Err(Fault::new(Id::GC108, span));
        }
        p.r.pos += 1;
    }
    Ok(Statement::Write { items, line })
}

/// An expression; a common variable alone is read when the block runs.
fn value(p: &mut Parser) -> Check<Item> {
    let at = p.r.pos;
    if let Some(variable) = p.r.common()? {
        p.r.blanks();
        if matches!(p.r.peek(), 0 | b',' | b';' | b')') {
            return Ok(Item::Common(variable));
        }
        p.r.pos = at;
    }
    Ok(Item::Value(p.r.expression()?))
}

/// Length of the quotation mark that stands here: `"`, U+201C..U+201E, or Windows-1252 84h 93h 94h.
fn quote(text: &[u8]) -> usize {
    match text {
        [b'"' | 0x84 | 0x93 | 0x94, ..] => 1,
        [0xE2, 0x80, 0x9C..=0x9E, ..] => 3,
        _ => 0,
    }
}

fn string(p: &mut Parser) -> Check<Item> {
    let open = p.r.pos;
    let mut pos = open + quote(&p.r.text[open..]);
    let mut bytes = Vec::new();
    while pos < p.r.text.len() {
        let length = quote(&p.r.text[pos..]);
        if length == 0 {
            bytes.push(p.r.text[pos]);
            pos += 1;
            continue;
        }
        pos += length;
        if p.r.at(pos) != b'"' {
            p.r.pos = pos;
            let text = decode(&bytes);
            if text.chars().count() > MAX_TEXT {
                return Err(Fault::new(Id::GC717, Span::new(open, pos)));
            }
            return Ok(Item::Text(text));
        }
        bytes.push(b'"');
        pos += 1;
    }
    Err(Fault::new(Id::GC110, p.r.character(open)))
}

/// `O100`, or an O-word such as `o100 sub`.
pub(crate) fn program_or_o_word(p: &mut Parser) -> Check<()> {
    let at = p.r.pos;
    let Some((label, word, end)) = o_word(p.r.text, at) else {
        no_o_word(p, at)?;
        p.r.pos = at + 1;
        p.r.blanks();
        let value = p.value(at, b'O')?;
        p.block.program = Some(value);
        return Ok(());
    };
    p.r.pos = end;
    let span = Span::new(at, end);
    if !p.dialect.oword {
        return Err(Fault::new(Id::GC611, span));
    }
    let mut arguments = Vec::new();
    p.r.blanks();
    while p.r.peek() == b'[' {
        arguments.push(p.r.bracket()?);
        p.r.blanks();
    }
    alone(p, span)?;
    set_statement(p, Statement::OWord { label, word, arguments, span }, at);
    Ok(())
}

/// `o<name>` is always an O-word, `o100` one if a word of letters follows: GC610 if it is not known.
fn no_o_word(p: &Parser, at: usize) -> Check<()> {
    let named = p.r.at(at + 1) == b'<';
    let part: fn(&u8) -> bool = if named { |b| *b != b'>' } else { u8::is_ascii_digit };
    let label = at + 1 + p.r.text[at + 1..].iter().take_while(|b| part(b)).count() + usize::from(named);
    let end = label.min(p.r.text.len());
    let start = end + p.r.text[end..].iter().take_while(|b| matches!(b, b' ' | b'\t')).count();
    let length = p.r.text[start..].iter().take_while(|b| b.is_ascii_alphabetic()).count();
    if !named && (length < 2 || end == at + 1 || !p.dialect.oword) {
        return Ok(());
    }
    if !p.dialect.oword {
        return Err(Fault::new(Id::GC611, Span::new(at, end)));
    }
    let span = if length > 0 { Span::new(start, start + length) } else { Span::new(at, end) };
    Err(Fault::with(Id::GC610, span, &[&"O-word (sub, call, if, while ..)"]))
}

/// Label, meaning and end of an O-word at a position, if one stands there.
pub(crate) fn o_word(text: &[u8], at: usize) -> Option<(String, OWord, usize)> {
    let blanks = |pos: usize| pos + text[pos..].iter().take_while(|b| matches!(b, b' ' | b'\t')).count();
    if !matches!(text.get(at), Some(b'o' | b'O')) {
        return None;
    }
    let (label, end) = if text.get(at + 1) == Some(&b'<') {
        let length = text[at + 2..].iter().position(|&b| b == b'>')?;
        (String::from_utf8_lossy(&text[at + 2..at + 2 + length]).trim().to_ascii_lowercase(), at + length + 3)
    } else {
        let digits = text[at + 1..].iter().take_while(|b| b.is_ascii_digit()).count();
        let number = String::from_utf8_lossy(&text[at + 1..at + 1 + digits]).into_owned();
        (number.trim_start_matches('0').to_owned(), at + 1 + digits)
    };
    let start = blanks(end);
    let length = text[start..].iter().take_while(|b| b.is_ascii_alphabetic()).count();
    let word = String::from_utf8_lossy(&text[start..start + length]).to_ascii_lowercase();
    let kind = O_WORDS.iter().find(|w| w.0 == word).filter(|_| end > at + 1)?.1;
    Some((label, kind, start + length))
}

/// Does a line open (WHILE, DO) or close (END) a loop, and which?
pub(crate) fn loop_word(text: &[u8]) -> Option<(bool, u8)> {
    let upper = text[head_length(text)..].trim_ascii().to_ascii_uppercase();
    let digit = |at: usize| upper.get(at).filter(|b| (b'1'..=b'9').contains(*b)).map(|b| b - b'0');
    if upper.starts_with(b"END") {
        return Some((false, digit(3)?));
    }
    if upper.starts_with(b"DO") {
        return Some((true, digit(2)?));
    }
    if !upper.starts_with(b"WHILE") {
        return None;
    }
    let at = upper.windows(2).rposition(|w| w == b"DO")?;
    Some((true, digit(at + 2)?))
}

/// Length of blanks, block delete and block number at the start of a line.
pub(crate) fn head_length(text: &[u8]) -> usize {
    let mut pos = 0;
    let skip = |pos: usize, f: fn(&u8) -> bool| pos + text[pos..].iter().take_while(|b| f(b)).count();
    let blank = |b: &u8| matches!(b, b' ' | b'\t');
    for _ in 0..2 {
        pos = skip(pos, blank);
        if text.get(pos) == Some(&b'/') {
            pos = skip(skip(pos + 1, u8::is_ascii_digit), blank);
        }
        if matches!(text.get(pos), Some(b'N' | b'n')) {
            pos = skip(skip(skip(pos + 1, blank), u8::is_ascii_digit), blank);
        }
    }
    pos
}

/// The block number of a line.
pub(crate) fn block_number(text: &[u8]) -> Option<u32> {
    let head = &text[..head_length(text)];
    let at = head.iter().position(|b| matches!(b, b'N' | b'n'))?;
    let digits: Vec<u8> = head[at + 1..].iter().filter(|b| !b.is_ascii_whitespace()).copied().collect();
    let digits = &digits[..digits.iter().take_while(|b| b.is_ascii_digit()).count()];
    std::str::from_utf8(digits).ok()?.parse().ok()
}

pub(crate) fn is_active(upper: &[u8], name: &[u8]) -> bool {
    upper.starts_with(name) && (name.ends_with(b",") || upper[name.len()..].contains(&b','))
}

/// Length of a comment whose nested parentheses balance within the line.
pub(crate) fn balanced(text: &[u8]) -> Option<usize> {
    let mut depth = 0i32;
    for (i, b) in text.iter().enumerate() {
        depth += i32::from(*b == b'(') - i32::from(*b == b')');
        if depth == 0 {
            return Some(i + 1);
        }
    }
    None
}
