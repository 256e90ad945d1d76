//! Virtual zero points (4.4.3, 4.4.110, 4.4.127, 4.4.128): another coordinate system over the same machine zero.
//!
//! Coordinates of an axis are kept relative to its virtual zero point. A new one shifts everything that is a position:
//! set point, encoder, what is queued, software limits; so a standing axis stays where it is. Set point and encoder
//! shift by the same whole counts, and many shifts add up no rounding.

use crate::mcu::Mcu;
use crate::registers::ModeReg;

/// Sets of zero offsets that `azo` chooses from.
pub const ZERO_OFFSET_SETS: usize = 5;

impl Mcu {
    /// Activates one of the five sets of zero offsets for all axes (azo): those of the machine file, or what resource 16
    /// wrote; any other number: none.
    pub fn azo(&mut self, set: i32) {
        for a in 0..self.axes.len() {
            let sets = &self.resources.axes[a].ref_offset[..ZERO_OFFSET_SETS];
            let offset = usize::try_from(set).ok().and_then(|set| sets.get(set)).copied().unwrap_or(0.0);
            self.szpa(a, offset);
        }
    }
    /// Sets the virtual zero point of an axis at a position of the machine (szpa); 0 takes it back.
    pub fn szpa(&mut self, axis: usize, position: f64) -> bool {
        let ok = position.is_finite();
        if ok {
            self.shift(axis, position);
            if self.registers.modereg.has(ModeReg::ClearZeroPosition) {
                self.axes[axis].zero = 0.0;
            }
        }
        ok
    }
    /// Shifts the virtual zero point of an axis (szpr).
    pub fn szpr(&mut self, axis: usize, distance: f64) -> bool {
        self.szpa(axis, self.axes[axis].zero + distance)
    }
    /// The zero offset in force, as a signed total (rdZeroOffset).
    pub fn zero_offset(&self, axis: usize) -> f64 {
        self.axes[axis].zero
    }
    /// MODEREG ClearZeroPosition: offsets become 0 and positions stay, so the machine zero moves (6.3.1.5).
    pub(crate) fn clear_zero_offsets(&mut self) {
        self.axes.iter_mut().for_each(|axis| axis.zero = 0.0);
    }

    fn shift(&mut self, a: usize, zero: f64) {
        let axis = &mut self.axes[a];
        let whole = |position: f64| crate::plant::whole(position * axis.parameters.counts_per_unit);
        let counts = whole(axis.zero).saturating_sub(whole(zero));
        let by = counts as f64 / axis.parameters.counts_per_unit;
        axis.zero = zero;
        if let Some(limits) = &mut axis.parameters.limits {
            limits.left += by;
            limits.right += by;
        }
        self.shift_coordinates(a, counts);
    }
}
