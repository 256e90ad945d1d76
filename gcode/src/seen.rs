//! Block numbers seen so far: one bit each, in pages, since N goes to 99,999,999.

const PAGE_BITS: usize = 4096;

#[derive(Debug, Default)]
pub struct Numbers {
    pages: Vec<Option<Box<[u64; PAGE_BITS / 64]>>>,
}

impl Numbers {
    /// Notes a number; true if it was there already.
    pub fn seen_before(&mut self, n: u32) -> bool {
        let (page, bit) = (n as usize / PAGE_BITS, n as usize % PAGE_BITS);
        if self.pages.len() <= page {
            self.pages.resize_with(page + 1, || None);
        }
        let words = self.pages[page].get_or_insert_with(|| Box::new([0; PAGE_BITS / 64]));
        let mask = 1u64 << (bit % 64);
        let seen = words[bit / 64] & mask != 0;
        words[bit / 64] |= mask;
        seen
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn each_number_is_new_once() {
        let mut numbers = super::Numbers::default();
        for n in [0, 10, 99_999_999, 63, 64] {
            assert!(!numbers.seen_before(n));
            assert!(numbers.seen_before(n));
        }
    }
}
