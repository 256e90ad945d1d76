//! Zero offsets and shifts: G10, G28, G30, G52, G53..G59, G92 and their kin (docs/dialect.md, sections 6 and 10).

use motion_kernel::machine::Tool;

use crate::block::{AXIS_LETTERS, Block, GWord, bit, mask};
use crate::codes::{Group, number};
use crate::diagnostics::{Check, Fault, Id};
use crate::frame::{Rotation, Scale, Zero};
use crate::group::{Point, SLOTS};
use crate::target::Target;
use crate::translate::Translator;

impl Translator<'_> {
    /// G53 (modal), G54..G59, G54.1.
    pub(crate) fn zero_offset(&mut self, block: &Block, owner: Option<&GWord>) -> Check<()> {
        let Some(g) = block.code_of(Group::ZeroOffset) else { return Ok(()) };
        let zero = match g.code.tenths {
            530 if owner.is_some_and(|o| o.code.tenths == 530) => return Ok(()),
            530 => Zero::Machine,
            541 => {
                self.used |= bit(b'P');
                let p = block.whole(b'P')?.ok_or_else(|| Fault::with(Id::GC310, g.span, &[&"G54.1", &'P']))?;
                if !(1..=48).contains(&p) {
                    return Err(Fault::with(Id::GC216, block.span_of(b'P'), &[&p, &'P', &1, &48]));
                }
                Zero::Extra(p as u32)
            }
            580 | 590
                if block.has_any(AXIS_LETTERS) && block.code_of(Group::Motion).is_none() && block.g.len() == 1 =>
            {
                return Err(Fault::with(Id::GC316, g.span, &[&number(g.code.tenths)]));
            }
            tenths => Zero::Work(usize::from(tenths / 10 - 54)),
        };
        self.state.frame.zero = zero;
        self.state.reframe();
        Ok(())
    }

    /// Step 18: everything that sets or uses shifts.
    pub(crate) fn offsets_step(&mut self, block: &Block, owner: Option<&GWord>) -> Check<()> {
        if let Some(g) = block.g.iter().find(|g| matches!(g.code.tenths, 921..=923)) {
            self.g92_variant(g.code.tenths);
        }
        if block.g(690).is_some() {
            self.state.frame.rotation = None;
            self.state.reframe();
        }
        if block.g(500).is_some() && !block.has_any(AXIS_LETTERS) && !block.has(b'S') {
            self.state.frame.scale = None;
            self.state.reframe();
        }
        if block.g(750).is_some() {
            self.drain();
        }
        if block.g(510).is_some() {
            self.scale(block)?;
        }
        if block.g(501).is_some() {
            self.mirror_off(block)?;
        }
        let Some(owner) = owner else { return Ok(()) };
        match owner.code.tenths {
            100 => self.set_data(block, owner),
            280 | 300 => self.reference(block, owner),
            520 => self.local_shift(block, owner),
            920 => self.preset(block, owner),
            500 if self.dialect.lathe => self.preset(block, owner),
            500 => Err(Fault::new(Id::GC313, owner.span)),
            511 => self.mirror(block, owner),
            680 => self.rotate(block),
            740 => self.home(block, owner),
            71 | 1070 => self.cylinder(block, owner),
            _ => Ok(()),
        }
    }

    /// Values of the axis words by slot.
    fn words(&mut self, block: &Block) -> Check<Vec<(usize, u8, f64)>> {
        self.used |= AXIS_LETTERS;
        let letters = (0..26u8).map(|i| b'A' + i).filter(|l| block.has(*l) && AXIS_LETTERS & bit(*l) != 0);
        letters.map(|l| self.slot_of(block, l).map(|(slot, _)| (slot, l, self.coordinate(block, l, slot)))).collect()
    }
    fn named(&mut self, block: &Block, g: &GWord) -> Check<Vec<(usize, u8, f64)>> {
        let words = self.words(block)?;
        if let Some(word) = block.word(b'E').filter(|_| words.is_empty()) {
            return Err(Fault::with(Id::GC214, word.span, &[&'E'])); // the extruder of a printer
        }
        if words.is_empty() {
            return Err(Fault::with(Id::GC327, g.span, &[&format!("G{}", number(g.code.tenths))]));
        }
        Ok(words)
    }

    fn local_shift(&mut self, block: &Block, g: &GWord) -> Check<()> {
        for (slot, _, value) in self.named(block, g)? {
            self.state.frame.g52[slot] = value;
        }
        self.state.reframe();
        Ok(())
    }
    /// G92: the present point gets the given coordinates.
    fn preset(&mut self, block: &Block, g: &GWord) -> Check<()> {
        if !block.has_any(AXIS_LETTERS) && block.has(b'S') {
            return Ok(());
        }
        for (slot, _, value) in self.named(block, g)? {
            // the shift acts behind rotation and scaling, so the wanted point goes through them first
            let mut wanted = self.state.program;
            wanted[slot] = value;
            let factor = self.state.frame.factor[slot];
            let without = self.state.frame.to_machine(&wanted)[slot] - factor * self.state.frame.g92[slot];
            self.state.frame.g92[slot] = (self.state.machine[slot] - without) / factor;
            self.state.reframe();
        }
        Ok(())
    }
    fn g92_variant(&mut self, tenths: u16) {
        let frame = &mut self.state.frame;
        match tenths {
            921 => (frame.g92, frame.g92_kept) = ([0.0; SLOTS], [0.0; SLOTS]),
            922 if frame.g92 != [0.0; SLOTS] => (frame.g92_kept, frame.g92) = (frame.g92, [0.0; SLOTS]),
            923 if frame.g92_kept != [0.0; SLOTS] => frame.g92 = frame.g92_kept,
            _ => {}
        }
        self.state.reframe();
    }

    /// G10 L2, L20 (zero offsets) and L1, L10, L11 (tools).
    fn set_data(&mut self, block: &Block, g: &GWord) -> Check<()> {
        self.used |= mask("LP");
        let missing = |what: &str| Fault::with(Id::GC310, g.span, &[&"G10", &what]);
        let kind = block.integer(b'L').ok_or_else(|| missing("L"))?;
        let span = block.span_of(b'L');
        if !matches!(kind, 1 | 2 | 10 | 11 | 20) {
            return Err(Fault::with(Id::GC309, span, &[&kind]));
        }
        let p = block.whole(b'P')?.ok_or_else(|| missing("P"))?;
        if kind != 2 && kind != 20 {
            return self.set_tool(block, p);
        }
        let zero = match (p, self.state.frame.zero) {
            (0, Zero::Machine) => Zero::Work(0),
            (0, active) => active,
            (1..=6, _) => Zero::Work(p as usize - 1),
            _ => return Err(Fault::with(Id::GC216, block.span_of(b'P'), &[&p, &'P', &0, &6])),
        };
        for (slot, _, value) in self.words(block)? {
            let frame = &mut self.state.frame;
            let present = frame.offset(zero)[slot];
            let offset = if kind == 20 {
                let others = frame.shift()[slot] - frame.offset(frame.zero)[slot];
                self.state.machine[slot] - others - frame.factor[slot] * value
            } else if self.state.modal.incremental {
                present + value
            } else {
                value
            };
            frame.set_offset(zero, slot, offset);
        }
        self.state.reframe();
        Ok(())
    }
    fn set_tool(&mut self, block: &Block, p: i64) -> Check<()> {
        self.used |= mask("ZR");
        let (length, radius) = (self.length(block, b'Z'), self.length(block, b'R'));
        let found = self.tool(p as u32);
        let Some(mut tool) = found.or((length.is_some() || radius.is_some()).then_some(Tool::default())) else {
            return Err(Fault::with(Id::GC509, block.span_of(b'P'), &[&p]));
        };
        if radius.is_some_and(|r| r < 0.0) {
            let range: [&dyn std::fmt::Display; 4] = [&block.value(b'R').unwrap_or(0.0), &'R', &0, &1e7];
            return Err(Fault::with(Id::GC216, block.span_of(b'R'), &range));
        }
        tool.length = length.unwrap_or(tool.length);
        tool.radius = radius.unwrap_or(tool.radius);
        self.tools.insert(p as u32, Tool { number: p as u32, ..tool });
        Ok(())
    }
    /// A tool as G10 has set it, else that of the machine file.
    pub(crate) fn tool(&self, number: u32) -> Option<Tool> {
        let own = || self.machine.gcode.tools.iter().find(|t| t.number == number).copied();
        self.tools.get(&number).copied().or_else(own)
    }

    /// G28 and G30: over the given point to the reference position, at rapid speed.
    fn reference(&mut self, block: &Block, g: &GWord) -> Check<()> {
        let references = if g.code.tenths == 300 {
            self.used |= bit(b'P');
            let p = block.whole(b'P')?.unwrap_or(2);
            let span = block.word(b'P').map_or(g.span, |w| w.span);
            self.further_reference(p).ok_or_else(|| Fault::with(Id::GC311, span, &[&p]))?
        } else {
            std::array::from_fn(|s| self.group.axes.get(s).map_or(0.0, |a| a.reference))
        };
        let mut named = self.group.lettered();
        if block.has_any(AXIS_LETTERS) {
            let target = self.target(block)?;
            named = target.named;
            self.check_limits(block, &target.machine);
            self.line_to(block, &target, true)?;
        }
        let mut machine = self.state.machine;
        for slot in (0..self.group.len()).filter(|s| named & 1 << s != 0) {
            machine[slot] = references[slot];
            self.state.unknown &= !(1 << slot);
        }
        let program = self.state.frame.to_program(&machine);
        self.line_to(block, &Target { program, machine, named }, true)
    }
    /// Reference position 2, 3 or 4 of the machine file.
    fn further_reference(&self, p: i64) -> Option<Point> {
        let index = usize::try_from(p.checked_sub(2)?).ok()?;
        let positions = self.machine.gcode.references.get(index)?.as_ref()?;
        Some(std::array::from_fn(|s| self.group.axes.get(s).map_or(0.0, |a| positions[a.axis])))
    }
    /// G74: the application's homing routine, in step.
    fn home(&mut self, block: &Block, g: &GWord) -> Check<()> {
        if block.has(b'R') {
            return Err(Fault::with(Id::GC308, g.span, &[&"74"]));
        }
        let mut letters = String::new();
        for (_, letter, value) in self.words(block)? {
            if value != 0.0 {
                return Err(Fault::new(Id::GC318, block.span_of(letter)));
            }
            letters.push(char::from(letter));
        }
        self.host_wait("G74", &letters);
        Ok(())
    }

    /// G51: centre by axis words, factor P or I J K.
    fn scale(&mut self, block: &Block) -> Check<()> {
        self.used |= mask("PIJK");
        let mut scale = Scale { centre: self.state.program, factor: [1.0; SLOTS] };
        for (slot, _, value) in self.words(block)? {
            scale.centre[slot] = value;
        }
        for letter in *b"PIJK" {
            let Some(word) = block.word(letter) else { continue };
            if word.value == 0.0 {
                return Err(Fault::new(Id::GC403, word.span));
            }
            let axes =
                if letter == b'P' { &b"XYZUVW"[..] } else { std::slice::from_ref(&b"XYZ"[usize::from(letter - b'I')]) };
            for slot in axes.iter().filter_map(|l| self.group.slot(*l)) {
                let thousandths =
                    letter == b'P' && word.integer_form && word.value >= 10.0 && self.dialect.integer_increment > 0.0;
                scale.factor[slot] = if thousandths { word.value * 1e-3 } else { word.value };
            }
        }
        self.state.frame.scale = Some(scale);
        self.state.reframe();
        Ok(())
    }
    /// G51.1: the axis words give the mirror lines.
    fn mirror(&mut self, block: &Block, g: &GWord) -> Check<()> {
        for (slot, _, value) in self.named(block, g)? {
            self.state.frame.mirror[slot] = Some(value);
        }
        self.state.reframe();
        Ok(())
    }
    /// G50.1: off, for all axes or the named ones.
    fn mirror_off(&mut self, block: &Block) -> Check<()> {
        let words = self.words(block)?;
        for slot in 0..SLOTS {
            if words.is_empty() || words.iter().any(|w| w.0 == slot) {
                self.state.frame.mirror[slot] = None;
            }
        }
        self.state.reframe();
        Ok(())
    }
    /// G68: rotation in the plane about a point.
    fn rotate(&mut self, block: &Block) -> Check<()> {
        self.used |= bit(b'R');
        let (letters, _) = self.state.modal.plane.letters();
        let g = block.g(680).map_or(block.span, |g| g.span);
        let mut slots = [0; 2];
        for (slot, letter) in slots.iter_mut().zip(letters) {
            *slot = self.group.slot(letter).ok_or_else(|| Fault::with(Id::GC417, g, &[&char::from(letter)]))?;
        }
        let mut centre = slots.map(|s| self.state.program[s]);
        for (i, letter) in letters.into_iter().enumerate() {
            if block.has(letter) {
                centre[i] = self.coordinate(block, letter, slots[i]);
                self.used |= bit(letter);
            }
        }
        let Some(angle) = block.value(b'R') else {
            return Err(Fault::with(Id::GC310, g, &[&"G68", &'R']));
        };
        self.state.frame.rotation = Some(Rotation::new(slots, centre, angle));
        self.state.reframe();
        Ok(())
    }
}
