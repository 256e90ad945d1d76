//! Packing of one column of samples, without loss: what a straight line through the two samples before does not foretell,
//! byte by byte.
//!
//! A machine moves steadily for most of the time, so the difference from the foretold value is small. Differences are
//! folded (0, -1, 1, -2 ... become 0, 1, 2, 3 ...) and written as planes: the lowest bytes of all samples, then the next
//! ones. One byte in front says which planes there are; the others are all zero. Bits of a float count as an integer, so
//! arithmetic on them wraps and nothing is rounded.

/// What is being packed, as integers of 64 bits.
pub(crate) trait Number: Copy {
    /// The value that the two before it let expect, the latest first, as integer bits.
    fn foretold(before: [Self; 2]) -> u64;
    fn bits(self) -> u64;
    fn of_bits(bits: u64) -> Self;
    fn zero() -> Self;
}

impl Number for f64 {
    #[inline]
    fn foretold(before: [f64; 2]) -> u64 {
        let value = before[0] + (before[0] - before[1]);
        // a sum that is no number, or infinite, may have other bits elsewhere
        if value.is_finite() { value.to_bits() } else { 0 }
    }
    #[inline]
    fn bits(self) -> u64 {
        self.to_bits()
    }
    #[inline]
    fn of_bits(bits: u64) -> f64 {
        f64::from_bits(bits)
    }
    fn zero() -> f64 {
        0.0
    }
}

impl Number for i64 {
    #[inline]
    fn foretold(before: [i64; 2]) -> u64 {
        before[0].wrapping_add(before[0].wrapping_sub(before[1])) as u64
    }
    #[inline]
    fn bits(self) -> u64 {
        self as u64
    }
    #[inline]
    fn of_bits(bits: u64) -> i64 {
        bits as i64
    }
    fn zero() -> i64 {
        0
    }
}

/// Lines, numbers of commands and flags stay the same most of the time.
impl Number for u32 {
    #[inline]
    fn foretold(before: [u32; 2]) -> u64 {
        u64::from(before[0])
    }
    #[inline]
    fn bits(self) -> u64 {
        u64::from(self)
    }
    #[inline]
    fn of_bits(bits: u64) -> u32 {
        bits as u32
    }
    fn zero() -> u32 {
        0
    }
}

#[inline]
fn fold(difference: u64) -> u64 {
    (difference << 1) ^ ((difference as i64 >> 63) as u64)
}
#[inline]
fn unfold(folded: u64) -> u64 {
    (folded >> 1) ^ (folded & 1).wrapping_neg()
}

/// Appends a column. `words` is working memory.
pub(crate) fn pack<T: Number>(values: &[T], words: &mut Vec<u64>, out: &mut Vec<u8>) {
    let word = |value: T, before: [T; 2]| fold(value.bits().wrapping_sub(T::foretold(before)));
    words.clear();
    // loops without state, of which the compiler makes several values at once
    words.extend(values.first().map(|&value| word(value, [T::zero(); 2])));
    words.extend(values.get(1).map(|&value| word(value, [values[0], T::zero()])));
    words.extend(values.windows(3).map(|three| word(three[2], [three[1], three[0]])));
    let used = words.iter().fold(0, |bits, word| bits | word);
    let planes = (0..8).filter(|plane| used >> (8 * plane) & 0xff != 0);
    out.push(planes.clone().fold(0, |mask, plane| mask | 1 << plane));
    for plane in planes {
        out.extend(words.iter().map(|word| (word >> (8 * plane)) as u8));
    }
}

/// Takes a column of `n` values off the front of `data`; None if there is less.
pub(crate) fn unpack<T: Number>(data: &mut &[u8], n: usize, words: &mut Vec<u64>) -> Option<Vec<T>> {
    let (&mask, mut rest) = data.split_first()?;
    words.clear();
    words.resize(n, 0);
    for plane in (0..8).filter(|plane| mask >> plane & 1 == 1) {
        let (bytes, behind) = rest.split_at_checked(n)?;
        words.iter_mut().zip(bytes).for_each(|(word, &byte)| *word |= u64::from(byte) << (8 * plane));
        rest = behind;
    }
    *data = rest;
    let mut before = [T::zero(); 2];
    let value = |&word: &u64| {
        let value = T::of_bits(T::foretold(before).wrapping_add(unfold(word)));
        before = [value, before[0]];
        value
    };
    Some(words.iter().map(value).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn same<T: Number>(values: &[T]) -> bool {
        let (mut words, mut out) = (Vec::new(), Vec::new());
        pack(values, &mut words, &mut out);
        assert!(out.len() <= 1 + values.len() * 8);
        let mut data = &out[..];
        let back: Vec<T> = unpack(&mut data, values.len(), &mut words).expect("whole");
        data.is_empty() && back.iter().zip(values).all(|(a, b)| a.bits() == b.bits())
    }

    proptest! {
        #[test]
        fn every_bit_comes_back(
            floats in prop::collection::vec(prop_oneof![any::<f64>(), any::<u64>().prop_map(f64::from_bits)], 0..50),
            wholes in prop::collection::vec(any::<i64>(), 0..50),
            small in prop::collection::vec(any::<u32>(), 0..50),
        ) {
            prop_assert!(same(&floats) && same(&wholes) && same(&small));
        }
    }

    #[test]
    fn a_steady_motion_takes_little() {
        let values: Vec<f64> = (0..1000).map(|k| 100.0 + f64::from(k) * 0.0123).collect();
        let mut out = Vec::new();
        pack(&values, &mut Vec::new(), &mut out);
        assert!(out.len() < 9000 && same(&values));
        let mut data = &out[..out.len() - 1];
        assert!(unpack::<f64>(&mut data, 1000, &mut Vec::new()).is_none(), "cut off");
    }
}
