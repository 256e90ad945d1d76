//! The program as it leaves the sink: whole, or in segments while the text is still read; instructions of the task.

use motion_kernel::autocode::{Instr, Program};

use crate::offset_path::Held;
use crate::sink::Sink;

/// Takes the segments of a program in order.
pub struct Deliver {
    /// Instructions after which a segment is cut.
    pub every: u32,
    pub to: Box<dyn FnMut(Program)>,
}

/// An instruction of the task, its operand not yet in a pool.
#[derive(Clone, Debug)]
pub(crate) enum Direct {
    Instr(Instr),
    /// Push a number.
    Number(f64),
    /// Write a text.
    Text(String),
}

impl Sink {
    /// Hands over what is written so far, if it is enough. Its last move must be final.
    #[inline]
    pub(crate) fn cut(&mut self) {
        if self.deliver.as_ref().is_some_and(|deliver| self.builder.here() >= deliver.every) {
            self.cut_here();
        }
    }
    #[cold]
    fn cut_here(&mut self) {
        let segment = self.builder.cut();
        self.list = self.builder.axis_list(self.group.axis_list());
        self.circle_lists.clear();
        match (&mut self.left, &mut self.deliver) {
            (Some(left), _) => left.pass(&segment),
            (None, Some(deliver)) => (deliver.to)(segment),
            (None, None) => {}
        }
    }
    /// A later block may still lower or raise the target velocity of the last move.
    fn is_open(&self) -> bool {
        self.previous.is_some_and(|previous| previous.joins)
    }
    /// An instruction of the task itself, behind everything spooled so far. Its operand is no place in a pool.
    pub fn instr(&mut self, line: u32, instr: Instr) {
        self.direct(line, Direct::Instr(instr));
    }
    /// Appends a text to the output string.
    pub fn write_text(&mut self, line: u32, text: String) {
        self.direct(line, Direct::Text(text));
    }
    pub(crate) fn direct(&mut self, line: u32, what: Direct) {
        if self.is_holding() {
            self.hold(|| Held::Direct(line, what));
            return;
        }
        self.close_run();
        self.commands += 1;
        if self.begins() {
            let instr = match what {
                Direct::Instr(instr) => instr,
                Direct::Number(value) => Instr::Number(self.builder.numbers(&[value])),
                Direct::Text(text) => Instr::WriteText(self.builder.text(&text)),
            };
            self.builder.emit(line, instr);
        }
    }
    /// Before a command that is no motion: true if the program is kept.
    pub(crate) fn begins(&mut self) -> bool {
        if self.keep && !self.is_open() {
            self.cut();
        }
        self.keep
    }
    /// Another effective radius (section 11); the caller has drained the spoolers.
    pub fn effradius(&mut self, line: u32, slot: usize, radius: f64, on_surface: bool) {
        self.group.set_radius(slot, radius, on_surface);
        self.direct(line, Direct::Number(radius));
        self.instr(line, Instr::EffRadius(self.group.axes[slot].axis as u16));
    }
}
