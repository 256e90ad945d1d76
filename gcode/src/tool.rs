//! Corrections for the tool: radius G40..G42 and length G43, G44, G49 (docs/dialect.md, sections 6 and 22).

use crate::block::{Block, GWord, bit};
use crate::codes::{Group, number};
use crate::diagnostics::{Check, Fault, Id};
use crate::dialect::LoneD;
use crate::translate::Translator;

impl Translator<'_> {
    /// G40, G41, G42: the tool radius is that of D, or of the tool in the spindle.
    pub(crate) fn radius_correction(&mut self, block: &Block) -> Check<()> {
        let Some(g) = block.code_of(Group::RadiusCorrection) else { return self.lone_d(block) };
        if g.code.tenths != 400 && !self.dialect.radius_correction {
            return Err(Fault::with(Id::GC312, g.span, &[&number(g.code.tenths)]));
        }
        if g.code.tenths == 400 {
            self.state.modal.correction = 40;
            self.note_d(block);
            return self.sink.stop_correction(g.span);
        }
        self.note_d(block);
        let tool = self.correction_number(block, g)?;
        let found = self.tool(tool).map(|t| t.radius);
        let missing = || Fault::with(Id::GC509, block.word(b'D').map_or(g.span, |w| w.span), &[&tool]);
        let radius = match self.length(block, b'D') {
            Some(radius) if self.dialect.d_is_radius => radius,
            _ if tool == 0 => 0.0,
            _ => found.ok_or_else(missing)?,
        };
        self.state.modal.correction = g.code.tenths / 10;
        if radius == 0.0 {
            self.faults.push(Fault::new(Id::GW917, g.span));
            return self.sink.stop_correction(g.span);
        }
        let (letters, _) = self.state.modal.plane.letters();
        let mut slots = [0; 2];
        for (slot, letter) in slots.iter_mut().zip(letters) {
            let found = self.group.slot(letter).filter(|s| !self.group.axes[*s].rotary);
            *slot = found.ok_or_else(|| Fault::with(Id::GC417, g.span, &[&char::from(letter)]))?;
        }
        let reverses = self.state.frame.reverses(slots).ok_or_else(|| Fault::new(Id::GC412, g.span))?;
        let left = (g.code.tenths == 410) != reverses;
        let programmed = slots.map(|s| self.state.machine[s]);
        self.sink.plane = slots;
        self.sink.start_correction(slots, if left { radius } else { -radius }, programmed, g.span)
    }
    /// D without G41 or G42 names the correction of the next one; while one acts it cannot change.
    #[inline]
    fn lone_d(&mut self, block: &Block) -> Check<()> {
        let Some(word) = block.word(b'D') else { return Ok(()) };
        let other = self.sink.is_correcting() && self.state.modal.d != block.integer(b'D');
        if other || self.dialect.lone_d == LoneD::Refused || self.dialect.d_is_radius {
            return Err(Fault::with(Id::GC326, word.span, &[&'D']));
        }
        self.note_d(block);
        Ok(())
    }
    fn note_d(&mut self, block: &Block) {
        self.used |= bit(b'D');
        if self.dialect.lone_d != LoneD::Refused {
            self.state.modal.d = block.integer(b'D').or(self.state.modal.d);
        }
    }
    /// Number of D, of the last D, or of the tool. The last D is no modal word everywhere: two different radii are refused.
    fn correction_number(&self, block: &Block, g: &GWord) -> Check<u32> {
        let tool = self.state.modal.tool_offset.unwrap_or(self.state.modal.in_spindle);
        let last = self.state.modal.d.filter(|_| !self.dialect.d_is_radius).unwrap_or(tool);
        let radius = |number: u32| self.tool(number).filter(|_| number > 0).map_or(0.0, |t| t.radius);
        if let Some(number) = block.integer(b'D') {
            return Ok(number);
        }
        if self.dialect.lone_d == LoneD::Modal || radius(last) == radius(tool) {
            return Ok(last);
        }
        Err(Fault::with(Id::GC310, g.span, &[&format!("G{}", number(g.code.tenths)), &'D']))
    }
    /// What would move the contour away from the tool is refused while a correction acts (GC419).
    pub(crate) fn check_correction(&self, block: &Block) -> Check<()> {
        if !self.sink.is_correcting() {
            return Ok(());
        }
        let refused = |g: &&GWord| match g.code.group {
            Group::Plane => g.code.tenths != self.state.modal.plane.g() * 10,
            Group::ZeroOffset | Group::Scaling | Group::Mirror | Group::Rotation | Group::Cylinder => true,
            Group::OneShot => g.code.tenths != 40,
            Group::Motion => g.code.tenths > 30 && g.code.tenths != 800,
            _ => false,
        };
        match block.g.iter().find(refused) {
            Some(g) => Err(Fault::with(Id::GC419, g.span, &[&format!("G{}", number(g.code.tenths))])),
            None => Ok(()),
        }
    }
    /// G43, G44, G49: along the normal of the plane.
    pub(crate) fn length_correction(&mut self, block: &Block) -> Check<()> {
        let Some(g) = block.code_of(Group::LengthCorrection) else { return Ok(()) };
        self.used |= bit(b'H');
        let spindle = self.state.modal.tool_offset.unwrap_or(self.state.modal.in_spindle);
        let number = if g.code.tenths == 490 { 0 } else { block.integer(b'H').unwrap_or(spindle) };
        if number == 0 {
            // H0 is G49
            (self.state.modal.length_code, self.state.frame.length) = (49, None);
            self.state.reframe();
            return Ok(());
        }
        let missing = || Fault::with(Id::GC509, block.word(b'H').map_or(g.span, |w| w.span), &[&number]);
        let length = self.tool(number).ok_or_else(missing)?.length;
        let signed = if g.code.tenths == 440 { -length } else { length };
        let normal = self.state.modal.plane.letters().1;
        self.state.frame.length = match self.group.slot(normal) {
            Some(slot) => Some((slot, signed)),
            None if signed == 0.0 => None,
            None => return Err(Fault::with(Id::GC801, g.span, &[&char::from(normal)])),
        };
        self.state.modal.length_code = g.code.tenths / 10;
        self.state.reframe();
        Ok(())
    }
}
