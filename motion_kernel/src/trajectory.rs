//! Motion commands as the application gives them: the structures LMP, CMP, HMP and HMP3D of 4.3.2.4 to 4.3.2.7, and a
//! command for each name of chapter 4.4.

use crate::autocode::MoveKind;
use crate::axes::{AxisList, MAX_AXES};
use crate::circle_3d::Circle3d;
use crate::functions::Entered;
use crate::mcu::Mcu;
use crate::motion::MotionCommand;

/// Targets or distances by the number of the axis, whatever the order of AS; those of other axes are not read.
pub type PerAxis = [f64; MAX_AXES];

/// Parameters of linear interpolations, in PU and TU.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lmp {
    /// Path acceleration, velocity, target velocity.
    pub ac: f64,
    pub vl: f64,
    pub tvl: f64,
    pub dtm: PerAxis,
}

/// Parameters of circular interpolations.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cmp {
    pub ac: f64,
    pub vl: f64,
    pub tvl: f64,
    /// Degrees, its sign is the direction.
    pub phi: f64,
    /// Centre in the first and the second axis of AS.
    pub dtca1: f64,
    pub dtca2: f64,
}

/// Parameters of helical interpolations.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Hmp {
    pub ac: f64,
    pub vl: f64,
    pub tvl: f64,
    /// |phi| <= 1e-100: to the target point in `dtm`.
    pub phi: f64,
    pub dtca1: f64,
    pub dtca2: f64,
    pub dtm: PerAxis,
}

/// Parameters of 3-D circles.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Hmp3d {
    pub ac: f64,
    pub vl: f64,
    pub tvl: f64,
    pub phi: f64,
    pub dtca1: f64,
    pub dtca2: f64,
    pub dtca3: f64,
    /// Normal of the plane.
    pub pn1: f64,
    pub pn2: f64,
    pub pn3: f64,
    /// Without effect.
    pub dtm: PerAxis,
}

/// What the structures have in common.
trait Parameters {
    fn command<'a>(&self, kind: MoveKind, axes: &'a AxisList, targets: &'a PerAxis) -> MotionCommand<'a>;
    fn dtm(&self) -> PerAxis;
}

impl Parameters for Lmp {
    fn command<'a>(&self, kind: MoveKind, axes: &'a AxisList, targets: &'a PerAxis) -> MotionCommand<'a> {
        let &Lmp { ac, vl, tvl, .. } = self;
        MotionCommand { kind, axes, targets, center: [0.0; 2], phi: 0.0, vl, ac, tvl, rapid: false, line: 0 }
    }
    fn dtm(&self) -> PerAxis {
        self.dtm
    }
}

impl Parameters for Cmp {
    fn command<'a>(&self, kind: MoveKind, axes: &'a AxisList, targets: &'a PerAxis) -> MotionCommand<'a> {
        let &Cmp { ac, vl, tvl, phi, dtca1, dtca2 } = self;
        MotionCommand { kind, axes, targets, center: [dtca1, dtca2], phi, vl, ac, tvl, rapid: false, line: 0 }
    }
    fn dtm(&self) -> PerAxis {
        [0.0; MAX_AXES]
    }
}

impl Parameters for Hmp {
    fn command<'a>(&self, kind: MoveKind, axes: &'a AxisList, targets: &'a PerAxis) -> MotionCommand<'a> {
        let &Hmp { ac, vl, tvl, phi, dtca1, dtca2, .. } = self;
        MotionCommand { kind, axes, targets, center: [dtca1, dtca2], phi, vl, ac, tvl, rapid: false, line: 0 }
    }
    fn dtm(&self) -> PerAxis {
        self.dtm
    }
}

/// The targets of the axes of a command, in its order.
fn in_order(axes: &AxisList, dtm: &PerAxis) -> PerAxis {
    let mut targets = [0.0; MAX_AXES];
    for (target, a) in targets.iter_mut().zip(axes.iter()) {
        *target = dtm.get(a).copied().unwrap_or(0.0);
    }
    targets
}

/// Declares commands of one structure: direct name, spooled name, kind.
macro_rules! commands {
    ($structure:ident: $($direct:ident, $spooled:ident, $kind:ident;)*) => {
        impl Mcu {
            $(
                /// Direct command (chapter 4.4).
                pub fn $direct(&mut self, axes: &AxisList, parameters: &$structure) -> Entered {
                    let targets = in_order(axes, &parameters.dtm());
                    self.direct(&parameters.command(MoveKind::$kind, axes, &targets))
                }
                /// The same profile into the spooler.
                pub fn $spooled(&mut self, axes: &AxisList, parameters: &$structure) -> Entered {
                    let targets = in_order(axes, &parameters.dtm());
                    self.spool(&parameters.command(MoveKind::$kind, axes, &targets))
                }
            )*
        }
    };
}

commands! { Lmp: mla, smla, Smla; mlr, smlr, Smlr; }
commands! { Cmp: mca, smca, Smca; mcr, smcr, Smcr; }
commands! { Hmp: mha, smha, Smha; mhr, smhr, Smhr; }

impl Mcu {
    /// As [`Mcu::smla`] with a PcapIndex (4.4.94).
    pub fn smlai(&mut self, axes: &AxisList, parameters: &Lmp, pcap_index: i32) -> Entered {
        let targets = in_order(axes, &parameters.dtm);
        self.spool_indexed(&parameters.command(MoveKind::Smla, axes, &targets), pcap_index)
    }
    /// As [`Mcu::smlr`] with a PcapIndex.
    pub fn smlri(&mut self, axes: &AxisList, parameters: &Lmp, pcap_index: i32) -> Entered {
        let targets = in_order(axes, &parameters.dtm);
        self.spool_indexed(&parameters.command(MoveKind::Smlr, axes, &targets), pcap_index)
    }
    /// Circle of three axes in space, direct, absolute centre (4.4.30).
    pub fn mca3d(&mut self, axes: &AxisList, parameters: &Hmp3d) -> Entered {
        self.direct_3d(&parameters.circle(axes, false))
    }
    pub fn smca3d(&mut self, axes: &AxisList, parameters: &Hmp3d) -> Entered {
        self.spool_3d(&parameters.circle(axes, false))
    }
    /// The centre from the set points where the circle begins (4.4.31).
    pub fn mcr3d(&mut self, axes: &AxisList, parameters: &Hmp3d) -> Entered {
        self.direct_3d(&parameters.circle(axes, true))
    }
    pub fn smcr3d(&mut self, axes: &AxisList, parameters: &Hmp3d) -> Entered {
        self.spool_3d(&parameters.circle(axes, true))
    }
}

impl Hmp3d {
    fn circle<'a>(&self, axes: &'a AxisList, relative: bool) -> Circle3d<'a> {
        let &Hmp3d { ac, vl, tvl, phi, dtca1, dtca2, dtca3, pn1, pn2, pn3, .. } = self;
        let (center, normal) = ([dtca1, dtca2, dtca3], [pn1, pn2, pn3]);
        Circle3d { axes, relative, center, normal, phi, vl, ac, tvl, line: 0 }
    }
}
