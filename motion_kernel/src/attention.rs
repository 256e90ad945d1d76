//! What a sample looks after besides motion: searches, latches, offsets, recordings, the world outside. In the plain
//! case there is nothing, and a sample asks one question.

use crate::axes::AxisSet;
use crate::mcu::Mcu;
use crate::trace::Trace;

/// Axes and features that want to be looked after in every sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Attention {
    /// Home searches (jhi, jhl, jhr).
    pub homing: AxisSet,
    /// lps.
    pub latching: AxisSet,
    /// Encoders with an index pulse.
    pub index: AxisSet,
    /// dpoffset on its way.
    pub offsets: AxisSet,
    pub backlash: AxisSet,
    /// Masters of an electronic gear.
    pub masters: AxisSet,
    /// Slaves of SyncMode.
    pub slaves: AxisSet,
    /// lpr and lprs.
    pub recording: bool,
    /// The scanner.
    pub scanning: bool,
    /// Pulses on strobe inputs, or DMA-RTS.
    pub strobes: bool,
    pub stimulus: bool,
}

impl Mcu {
    /// Changes what is looked after.
    pub(crate) fn attend_to(&mut self, change: impl FnOnce(&mut Attention)) {
        change(&mut self.attention);
        self.attending = self.attention != Attention::default();
    }

    /// After the drives have moved: the world outside, signals, latches, searches, offsets.
    #[cold]
    pub(crate) fn attend(&mut self) {
        if self.attention.stimulus {
            self.play_stimulus();
        }
        if self.attention.strobes {
            self.play_strobes();
        }
        for a in self.attention.index.iter() {
            self.watch_index(a);
        }
        for a in self.attention.latching.iter() {
            self.latch_in_step(a);
        }
        for a in self.attention.homing.iter() {
            self.watch_search(a);
        }
        for a in self.attention.offsets.iter() {
            self.ramp_offset(a);
        }
        for a in self.attention.backlash.iter() {
            self.compensate_backlash(a);
        }
    }

    /// Behind a sample: who records it besides the trace.
    #[cold]
    pub(crate) fn look_back(&mut self, trace: &mut Trace) {
        if self.attention.recording {
            self.record_analysis();
        }
        if self.attention.scanning {
            self.scan_sample(trace);
        }
    }
}
