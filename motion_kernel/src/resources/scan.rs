//! The scanner: chosen resources, read at the end of every sample into the trace.
//!
//! A row shows what a read behind the sample would answer. Where a resource is BUSY (device 101: no strobe yet) the
//! scanner waits: the row is NaN, and data blocks keep their rows.

use super::rts::Block;
use super::table::{self, Place, Read};
use super::{Code, ObjectDescriptor, READ, Type};
use crate::mcu::Mcu;
use crate::trace::Trace;
use std::sync::Arc;

/// Most resources that are scanned together.
pub const MOST: usize = 64;

/// What a row of the scanner holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layout {
    /// Numbers, one column each.
    pub names: Vec<String>,
    /// Data blocks, one after the other.
    pub blocks: Vec<(String, Block)>,
}

/// Rows of the scanner, one for each sample.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scan {
    pub layout: Arc<Layout>,
    /// Row-major, a value for each name.
    pub values: Vec<f64>,
    /// Row-major, the bytes of each block.
    pub blocks: Vec<u8>,
}

impl Scan {
    pub(crate) fn restart(&mut self, scanner: &Scanner) {
        if !Arc::ptr_eq(&self.layout, &scanner.layout) {
            self.layout = Arc::clone(&scanner.layout);
        }
        self.values.clear();
        self.blocks.clear();
    }
    pub(crate) fn reserve(&mut self, samples: usize) {
        let bytes: usize = self.layout.blocks.iter().map(|(_, block)| block.bytes()).sum();
        self.values.reserve((samples * self.layout.names.len()).saturating_sub(self.values.len()));
        self.blocks.reserve((samples * bytes).saturating_sub(self.blocks.len()));
    }
}

/// What is scanned.
#[derive(Clone, Default)]
pub(crate) struct Scanner {
    pub layout: Arc<Layout>,
    columns: Vec<(Read, Place)>,
}

impl Mcu {
    /// Scans these resources, by names of the caller's choice, from the next sample on; none ends it. A descriptor must
    /// have a handle, so the resource was read before. The first that cannot be scanned is told by its position, and
    /// nothing changes: [`Code::Unknown`] (no handle, or not readable), [`Code::State`] (more than [`MOST`], or memory of
    /// the host, which no sample reads).
    pub fn scan(&mut self, resources: &[(String, ObjectDescriptor)]) -> Result<(), (usize, Code)> {
        let (mut layout, mut columns) = (Layout::default(), Vec::new());
        for (n, (name, d)) in resources.iter().enumerate() {
            let double = d.data_type == Type::Double as i32;
            let (device, place) = self.resolve(d, READ, double).map_err(|code| (n, code))?;
            if d.handle == 0 {
                return Err((n, Code::Unknown));
            }
            if n >= MOST || table::is_host_memory(place.device) {
                return Err((n, Code::State));
            }
            match device.read {
                _ if device.kind == Type::DataBlock => {
                    layout.blocks.push((name.clone(), self.data_block(place).map_err(|code| (n, code))?));
                }
                Some(read) => {
                    layout.names.push(name.clone());
                    columns.push((read, place));
                }
                None => return Err((n, Code::Unknown)),
            }
        }
        self.resources.scanner = Scanner { layout: Arc::new(layout), columns };
        self.attend_to(|attention| attention.scanning = !resources.is_empty());
        Ok(())
    }

    /// At the end of a sample.
    #[cold]
    pub(crate) fn scan_sample(&mut self, trace: &mut Trace) {
        if !Arc::ptr_eq(&trace.scan.layout, &self.resources.scanner.layout) {
            return; // nobody records this sample
        }
        let layout = Arc::clone(&trace.scan.layout);
        let columns = std::mem::take(&mut self.resources.scanner.columns);
        let begin = trace.scan.values.len();
        let mut waits = false;
        for (read, place) in &columns {
            let answer = read(self, *place);
            waits |= answer == Err(Code::Busy);
            trace.scan.values.push(answer.unwrap_or(f64::NAN));
        }
        if waits {
            trace.scan.values[begin..].fill(f64::NAN);
        }
        for (_, block) in &layout.blocks {
            if waits {
                trace.scan.blocks.resize(trace.scan.blocks.len() + block.bytes(), 0);
            } else {
                self.resources.rts.write_block(block, &mut trace.scan.blocks);
            }
        }
        if !waits && !layout.blocks.is_empty() {
            self.resources.rts.taken();
        }
        self.resources.scanner.columns = columns;
    }
}

impl std::fmt::Debug for Scanner {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.layout.fmt(f)
    }
}
