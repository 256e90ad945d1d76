//! Cylinder surface G07.1 (docs/dialect.md, section 11): the rotary axis as a length on the unrolled surface.

use crate::block::{AXIS_LETTERS, Block, GWord, mask};
use crate::codes::{Group, number};
use crate::diagnostics::{Check, Fault, Id};
use crate::group::Point;
use crate::translate::Translator;

/// Where an arc lies: two slots in their order, what they measure in mm, and the letters of the centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ArcPlane {
    pub slots: [usize; 2],
    /// mm per axis unit.
    pub metric: [f64; 2],
    pub centres: [u8; 2],
    /// The centre letter that does not belong to the plane.
    pub third: u8,
}

impl ArcPlane {
    /// The two coordinates of a point, in mm.
    pub fn in_mm(&self, point: &Point) -> [f64; 2] {
        [0, 1].map(|i| point[self.slots[i]] * self.metric[i])
    }
}

/// The linear axis along a rotary one, and the centre letters of (surface, linear axis) with the third.
fn along(rotary: u8) -> (u8, [u8; 2], u8) {
    match rotary {
        b'A' => (b'X', [b'J', b'I'], b'K'),
        b'B' => (b'Y', [b'I', b'J'], b'K'),
        _ => (b'Z', [b'J', b'K'], b'I'),
    }
}

impl Translator<'_> {
    /// The plane of arcs: G17..G19, or in cylinder mode the unrolled surface.
    pub(crate) fn arc_plane(&self, block: &Block) -> Check<ArcPlane> {
        let g = block.code_of(Group::Motion).map_or(block.span, |g| g.span);
        let slot = |letter: u8| {
            let missing = || Fault::with(Id::GC417, g, &[&char::from(letter)]);
            self.group.slot(letter).ok_or_else(missing)
        };
        let Some((rotary, _)) = self.state.modal.cylinder else {
            let ([a, b], _) = self.state.modal.plane.letters();
            let (centres, third) = self.state.modal.plane.centres();
            return Ok(ArcPlane { slots: [slot(a)?, slot(b)?], metric: [1.0; 2], centres, third });
        };
        let axis = &self.group.axes[rotary];
        let (linear, centres, third) = along(axis.letter);
        Ok(ArcPlane { slots: [rotary, slot(linear)?], metric: [axis.metric, 1.0], centres, third })
    }
    /// The rotary words that an arc block may hold: that of the surface.
    pub(crate) fn surface_letter(&self) -> u32 {
        self.state.modal.cylinder.map_or(0, |(slot, _)| crate::block::bit(self.group.axes[slot].letter))
    }

    /// `G07.1 C20`: on with radius 20; `G07.1 C0`: off.
    pub(crate) fn cylinder(&mut self, block: &Block, g: &GWord) -> Check<()> {
        let rotary = |letter: u8| self.group.slot(letter).filter(|s| self.group.axes[*s].rotary);
        let Some((letter, word)) = block.first_of(AXIS_LETTERS & mask("ABC")) else {
            let name = format!("G{}", number(g.code.tenths));
            return match block.first_of(AXIS_LETTERS) {
                Some((letter, word)) => Err(Fault::with(Id::GC326, word.span, &[&char::from(letter)])),
                None => Err(Fault::with(Id::GC327, g.span, &[&name])),
            };
        };
        self.slot_of(block, letter)?;
        let Some(slot) = rotary(letter) else {
            return Err(Fault::with(Id::GC326, word.span, &[&char::from(letter)]));
        };
        let radius = self.length(block, letter).unwrap_or(0.0);
        if radius < 0.0 {
            return Err(Fault::new(Id::GC414, word.span));
        }
        if let Some((active, _)) = self.state.modal.cylinder.filter(|c| c.0 != slot) {
            return Err(Fault::with(Id::GC322, word.span, &[&char::from(self.group.axes[active].letter)]));
        }
        if self.state.frame.rotation.is_some() {
            return Err(Fault::with(Id::GC321, g.span, &[&"G68"]));
        }
        self.used |= crate::block::bit(letter);
        self.check_unused(block)?;
        self.set_cylinder((radius > 0.0).then_some((slot, radius)));
        Ok(())
    }
    /// Switches the surface; what was spooled is done before, since effradius is not spooled (4.4.143).
    pub(crate) fn set_cylinder(&mut self, surface: Option<(usize, f64)>) {
        let before = self.state.modal.cylinder;
        if surface == before {
            return;
        }
        let slot = surface.or(before).expect("one of them is on").0;
        let radius = surface.map_or(self.machine.axes[self.group.axes[slot].axis].effradius, |s| s.1);
        self.drain();
        self.state.modal.cylinder = surface;
        self.group.set_radius(slot, radius, surface.is_some());
        self.sink.effradius(self.line, slot, radius, surface.is_some());
    }
    /// After a block with an error: the group measures as the state before says.
    pub(crate) fn restore_surface(&mut self) {
        for slot in 0..self.group.len() {
            let own = self.machine.axes[self.group.axes[slot].axis].effradius;
            let on = self.state.modal.cylinder.filter(|c| c.0 == slot);
            if self.group.axes[slot].rotary {
                self.group.set_radius(slot, on.map_or(own, |c| c.1), on.is_some());
            }
        }
    }

    /// What has no meaning on the surface is refused (GC321); cycles say so themselves.
    pub(crate) fn check_cylinder(&self, block: &Block) -> Check<()> {
        if self.state.modal.cylinder.is_none() {
            return Ok(());
        }
        let refused = |g: &&GWord| match g.code.group {
            Group::Plane => g.code.tenths != self.state.modal.plane.g() * 10,
            Group::RadiusCorrection => g.code.tenths != 400,
            Group::ZeroOffset => g.code.tenths == 530,
            Group::OneShot => matches!(g.code.tenths, 280 | 300),
            Group::Rotation => g.code.tenths == 680,
            _ => false,
        };
        match block.g.iter().find(refused) {
            Some(g) => Err(Fault::with(Id::GC321, g.span, &[&format!("G{}", number(g.code.tenths))])),
            None => Ok(()),
        }
    }
}
