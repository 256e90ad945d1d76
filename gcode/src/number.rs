//! Numbers: exact to the last bit (as `str::parse`), at most 15 significant digits, no exponent.

use crate::diagnostics::{Check, Fault, Id, Span};

/// A scanned number; `end` is the offset behind it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Number {
    pub value: f64,
    pub signed: bool,
    pub point: bool,
    /// More than 15 significant digits were given (GW905).
    pub rounded: bool,
    pub end: usize,
}

const POWERS: [f64; 16] = [1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15];
const MAX_CHARACTERS: usize = 40;

#[inline]
fn at(text: &[u8], pos: usize) -> u8 {
    text.get(pos).copied().unwrap_or(0)
}

/// True where a number can begin.
#[inline]
pub fn starts_number(byte: u8) -> bool {
    byte.is_ascii_digit() || matches!(byte, b'+' | b'-' | b'.')
}

/// Reads the number at `start`; `address` is the offset of the word, for messages.
#[inline]
pub fn scan(text: &[u8], start: usize, address: usize) -> Check<Number> {
    scan_before(text, start, address, |b| matches!(b, b'.' | b',' | b'+' | b'-'))
}

/// As [`scan`], inside an expression: signs and commas behind the number belong to the expression.
pub fn scan_operand(text: &[u8], start: usize) -> Check<Number> {
    scan_before(text, start, start, |b| b == b'.')
}

#[inline]
fn scan_before(text: &[u8], start: usize, address: usize, bad: fn(u8) -> bool) -> Check<Number> {
    let mut pos = start;
    let sign = at(text, pos);
    let signed = sign == b'-' || sign == b'+';
    pos += usize::from(signed);
    let (mut mantissa, mut digits, first) = (0u64, 0usize, pos);
    while let digit @ 0..=9 = at(text, pos).wrapping_sub(b'0') {
        mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(digit));
        digits += 1;
        pos += 1;
    }
    let point = at(text, pos) == b'.';
    let mut decimals = 0;
    if point {
        pos += 1;
        let behind = pos;
        while let digit @ 0..=9 = at(text, pos).wrapping_sub(b'0') {
            mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(digit));
            pos += 1;
        }
        decimals = pos - behind;
        digits += decimals;
    }
    if digits == 0 || digits > 15 || bad(at(text, pos)) {
        let next = Some(at(text, pos)).filter(|b| bad(*b)).unwrap_or(0);
        return unusual(text, (start, first, pos, address), digits, (signed, sign == b'-', point), next);
    }
    // both are exact in a double, so the quotient is correctly rounded
    let value = mantissa as f64 / POWERS[decimals];
    let value = if sign == b'-' && mantissa != 0 { -value } else { value };
    Ok(Number { value, signed, point, rounded: false, end: pos })
}

/// Everything that is not a short well-formed number.
#[cold]
fn unusual(
    text: &[u8],
    (start, first, pos, address): (usize, usize, usize, usize),
    digits: usize,
    (signed, negative, point): (bool, bool, bool),
    next: u8,
) -> Check<Number> {
    let run = |from: usize| {
        let is_part = |b: u8| b.is_ascii_digit() || matches!(b, b'.' | b'+' | b'-');
        from + text[from..].iter().take_while(|&&b| is_part(b)).count()
    };
    if next == b',' && digits > 0 {
        if at(text, pos + 1).is_ascii_digit() {
            return Err(Fault::new(Id::GC205, Span::new(pos, pos + 1)));
        }
    } else if matches!(next, b'.' | b'+' | b'-') {
        let end = run(start);
        let shown = String::from_utf8_lossy(&text[start..end.min(start + MAX_CHARACTERS)]).into_owned();
        return Err(Fault::with(Id::GC204, Span::new(start, end), &[&shown]));
    }
    if digits == 0 {
        let letter = char::from(at(text, address)).to_ascii_uppercase();
        return Err(Fault::with(Id::GC202, Span::new(address, pos.max(address + 1)), &[&letter]));
    }
    if pos - start > MAX_CHARACTERS {
        return Err(Fault::new(Id::GC206, Span::new(start, pos)));
    }
    let (value, rounded) = fifteen_digits(&text[first..pos]);
    let value = if negative && value != 0.0 { -value } else { value };
    Ok(Number { value, signed, point, rounded, end: pos })
}

/// The value of an unsigned decimal of any length, rounded half up to 15 significant digits.
fn fifteen_digits(text: &[u8]) -> (f64, bool) {
    let point = text.iter().position(|&b| b == b'.').unwrap_or(text.len());
    let digits: Vec<u8> = text.iter().filter(|b| b.is_ascii_digit()).copied().collect();
    let zeros = digits.iter().take_while(|&&b| b == b'0').count();
    let significant = &digits[zeros..];
    let trimmed = significant.len() - significant.iter().rev().take_while(|&&b| b == b'0').count();
    let kept = trimmed.min(15);
    let mut mantissa = significant[..kept].iter().fold(0u64, |m, &b| m * 10 + u64::from(b - b'0'));
    let rounded = trimmed > 15;
    if rounded && significant[15] >= b'5' {
        mantissa += 1;
    }
    let exponent = point as i64 - (zeros + kept) as i64;
    (format!("{mantissa}e{exponent}").parse().unwrap_or(f64::INFINITY), rounded)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn value(text: &str) -> f64 {
        scan(text.as_bytes(), 0, 0).unwrap().value
    }

    proptest! {
        #[test]
        fn short_numbers_are_as_exact_as_parse(a in 0u64..1_000_000_000, b in 0u32..1_000_000, negative: bool) {
            let text = format!("{}{a}.{b:06}", if negative { "-" } else { "" });
            prop_assert_eq!(value(&text), text.parse::<f64>().unwrap() + 0.0);
        }
        #[test]
        fn long_numbers_keep_fifteen_digits(digits in "[1-9][0-9]{16,30}", shift in 0usize..16) {
            let text = format!("{}.{}", &digits[..shift], &digits[shift..]);
            let n = scan(text.as_bytes(), 0, 0).unwrap();
            let exact: f64 = text.parse().unwrap();
            prop_assert!((n.value - exact).abs() <= exact * 1e-14);
        }
    }

    #[test]
    fn every_form_of_five() {
        for text in ["5", "5.", "5.0", "+5", "05", "5.000000000000000000"] {
            assert_eq!(value(text), 5.0, "{text}");
        }
        assert!(value("-0").is_sign_positive());
        assert_eq!(value(".5"), 0.5);
        assert_eq!(value("123456789012345678"), 123456789012346000.0);
    }
}
