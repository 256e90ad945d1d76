//! Circles of three axes in space (4.4.30, 4.4.31; HMP3D of 4.3.2.7): mca3d, mcr3d, smca3d, smcr3d.
//!
//! They follow what they are programmed with: the look-ahead knows six commands, and these are not among them
//! (6.3.1.5, bit 0). In a chain under look-ahead the moves before them stop, unless `sstvl` says otherwise.

use crate::autocode::MoveKind;
use crate::axes::AxisList;
use crate::functions::Entered;
use crate::mcu::Mcu;
use crate::motion::MotionCommand;
use crate::registers::ErrorReg;

/// Where the circle lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Space {
    /// In PU, absolute or from the start; a centre beside the plane is projected onto it (errata-sympas Q15).
    pub center: [f64; 3],
    /// Of any length; the start lies in the plane.
    pub normal: [f64; 3],
}

/// A 3-D circle, in PU and TU.
#[derive(Clone, Copy, Debug)]
pub struct Circle3d<'a> {
    /// Just three, in the order of centre and normal.
    pub axes: &'a AxisList,
    /// The centre counts from the set point where the circle begins (mcr3d), else it is absolute (mca3d).
    pub relative: bool,
    pub center: [f64; 3],
    pub normal: [f64; 3],
    /// Degrees of any size, counter-clockwise positive seen from the tip of the normal. There is no target form.
    pub phi: f64,
    pub vl: f64,
    pub ac: f64,
    pub tvl: f64,
    pub line: u32,
}

const NO_TARGETS: &[f64] = &[0.0; 3];

impl<'a> Circle3d<'a> {
    fn parts(&self) -> (MotionCommand<'a>, Space) {
        let &Circle3d { axes, relative, center, normal, phi, vl, ac, tvl, line } = self;
        let kind = if relative { MoveKind::Smcr } else { MoveKind::Smca };
        let command =
            MotionCommand { kind, axes, targets: NO_TARGETS, center: [0.0; 2], phi, vl, ac, tvl, rapid: false, line };
        (command, Space { center, normal })
    }
}

impl Mcu {
    /// Spools a 3-D circle (smca3d, smcr3d).
    pub fn spool_3d(&mut self, circle: &Circle3d) -> Entered {
        if circle.axes.len() != 3 {
            self.commands += 1;
            self.raise(ErrorReg::errAxDef);
            return Entered::Discarded;
        }
        let (command, space) = circle.parts();
        self.spool_as(&command, Some(&space), None)
    }
    /// The same in direct mode (mca3d, mcr3d).
    pub fn direct_3d(&mut self, circle: &Circle3d) -> Entered {
        if circle.axes.len() != 3 {
            self.raise(ErrorReg::errAxDef);
            return Entered::Discarded;
        }
        let (command, space) = circle.parts();
        self.direct_as(&command, Some(space))
    }
}
