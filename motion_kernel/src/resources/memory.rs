//! Memory of the host, by physical address, as a bus master sees it (chapter 4).

/// First address that is given out, and the granularity.
const FIRST: u32 = 0x1000_0000;
const PAGE: u32 = 4096;
/// Most bytes of all blocks together.
const MOST_BYTES: u64 = 1 << 28;

/// Memory that belongs to the caller: it lives as long as this does.
pub trait CallerMemory: Send + Sync + std::fmt::Debug {
    fn size(&self) -> usize;
    /// Bytes from `from` on, which lie inside. False: the caller does not let us.
    fn read(&self, from: usize, bytes: &mut [u8]) -> bool;
    fn write(&mut self, from: usize, bytes: &[u8]) -> bool;
}

#[derive(Debug)]
enum Block {
    Own(Vec<u8>),
    Caller(Box<dyn CallerMemory>),
}

impl Block {
    fn size(&self) -> usize {
        match self {
            Block::Own(bytes) => bytes.len(),
            Block::Caller(memory) => memory.size(),
        }
    }
}

/// Blocks of host memory that the application has allocated or lent.
#[derive(Debug, Default)]
pub struct HostMemory {
    /// Physical address and bytes.
    blocks: Vec<(u32, Block)>,
}

impl HostMemory {
    /// Physical address of a new block of zeros (allocPhysMem). `None`: no bytes asked for, or too many.
    pub fn alloc(&mut self, size: u32) -> Option<u32> {
        let base = self.place(size as usize)?;
        self.blocks.push((base, Block::Own(vec![0; size as usize])));
        Some(base)
    }
    /// Physical address of memory of the caller, used as it is. `None` as for [`HostMemory::alloc`].
    pub fn lend(&mut self, memory: Box<dyn CallerMemory>) -> Option<u32> {
        let base = self.place(memory.size())?;
        self.blocks.push((base, Block::Caller(memory)));
        Some(base)
    }
    /// Where a block of that size goes.
    fn place(&self, size: usize) -> Option<u32> {
        let used: u64 = self.blocks.iter().map(|(_, block)| block.size() as u64).sum();
        if size == 0 || used + size as u64 > MOST_BYTES {
            return None;
        }
        let end = |(base, block): &(u32, Block)| u64::from(*base) + block.size() as u64;
        let base = self.blocks.iter().map(end).max().unwrap_or(u64::from(FIRST)).next_multiple_of(u64::from(PAGE));
        u32::try_from(base).ok().filter(|base| base.checked_add(size as u32).is_some())
    }
    /// Releases a block (freePhysMem). False: there is none at this address.
    pub fn free(&mut self, base: u32) -> bool {
        let before = self.blocks.len();
        self.blocks.retain(|block| block.0 != base);
        self.blocks.len() < before
    }
    /// Reads at an address. False: the bytes do not all lie in one block.
    pub fn read(&self, address: u64, bytes: &mut [u8]) -> bool {
        self.blocks.iter().any(|(base, block)| {
            inside(*base, block, address, bytes.len()).is_some_and(|from| match block {
                Block::Own(own) => {
                    bytes.copy_from_slice(&own[from..from + bytes.len()]);
                    true
                }
                Block::Caller(memory) => memory.read(from, bytes),
            })
        })
    }
    /// Writes at an address. False, and nothing is written: as for [`HostMemory::read`].
    pub fn write(&mut self, address: u64, bytes: &[u8]) -> bool {
        self.blocks.iter_mut().any(|(base, block)| {
            inside(*base, block, address, bytes.len()).is_some_and(|from| match block {
                Block::Own(own) => {
                    own[from..from + bytes.len()].copy_from_slice(bytes);
                    true
                }
                Block::Caller(memory) => memory.write(from, bytes),
            })
        })
    }
}

/// Where in the block an access begins, if it lies inside.
fn inside(base: u32, block: &Block, address: u64, size: usize) -> Option<usize> {
    let from = usize::try_from(address.checked_sub(u64::from(base))?).ok()?;
    (from.checked_add(size)? <= block.size()).then_some(from)
}
