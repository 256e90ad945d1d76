//! Memory of the host, by physical address, as a bus master sees it (chapter 4).

/// First address that is given out, and the granularity.
const FIRST: u32 = 0x1000_0000;
const PAGE: u32 = 4096;
/// Most bytes of all blocks together.
const MOST_BYTES: u32 = 1 << 28;

/// Blocks of host memory that the application has allocated.
#[derive(Clone, Debug, Default)]
pub struct HostMemory {
    /// Physical address and bytes.
    blocks: Vec<(u32, Vec<u8>)>,
}

impl HostMemory {
    /// Physical address of a new block of zeros (allocPhysMem). `None`: no bytes asked for, or too many.
    pub fn alloc(&mut self, size: u32) -> Option<u32> {
        let used: u64 = self.blocks.iter().map(|(_, bytes)| bytes.len() as u64).sum();
        if size == 0 || used + u64::from(size) > u64::from(MOST_BYTES) {
            return None;
        }
        let end = |(base, bytes): &(u32, Vec<u8>)| u64::from(*base) + bytes.len() as u64;
        let base = self.blocks.iter().map(end).max().unwrap_or(u64::from(FIRST)).next_multiple_of(u64::from(PAGE));
        let base = u32::try_from(base).ok().filter(|base| base.checked_add(size).is_some())?;
        self.blocks.push((base, vec![0; size as usize]));
        Some(base)
    }
    /// Releases a block (freePhysMem). False: there is none at this address.
    pub fn free(&mut self, base: u32) -> bool {
        let before = self.blocks.len();
        self.blocks.retain(|block| block.0 != base);
        self.blocks.len() < before
    }
    /// Bytes at an address, if they all lie in one block.
    pub fn at(&mut self, address: u64, size: usize) -> Option<&mut [u8]> {
        self.blocks.iter_mut().find_map(|(base, bytes)| {
            let from = usize::try_from(address.checked_sub(u64::from(*base))?).ok()?;
            bytes.get_mut(from..from.checked_add(size)?)
        })
    }
}
