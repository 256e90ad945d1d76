//! `write` and `writeln` (docs/dialect.md, section 15.4): the task puts the text out when the motion before it is done.

use motion_kernel::autocode::Instr;
use motion_kernel::registers::ModeReg;

use crate::block::{Item, Statement};
use crate::diagnostics::{Fault, Id, Span};
use crate::mfunc::number_text;
use crate::translate::Translator;
use crate::variables::Variable;

/// Longest output string, characters.
const LONGEST: usize = 512;

impl Translator<'_> {
    pub fn write(&mut self, statement: &Statement, span: Span) {
        let Statement::Write { items, line } = statement else { return };
        self.drain();
        for item in items {
            let load = match item {
                Item::Common(Variable::Ci(n)) => Instr::LoadCi(*n),
                Item::Common(Variable::Cd(n)) => Instr::LoadCd(*n),
                Item::Text(text) => {
                    self.put_text(text, span);
                    continue;
                }
                Item::Value(value) => {
                    self.put_text(&number_text(*value), span);
                    continue;
                }
                Item::Common(_) => continue,
            };
            self.written += 1; // its length is known only when it runs
            self.sink.instr(self.line, load);
            self.sink.instr(self.line, Instr::WriteValue);
        }
        if *line {
            self.written = 0;
            if self.machine.gcode.modereg & ModeReg::StopAtWriteln.0 != 0 {
                // the task stops behind writeln: tell the operator before
                self.sink.event(self.line, "M00", "");
                self.drain();
            }
            self.sink.instr(self.line, Instr::Writeln);
        }
    }
    /// Cuts what does not fit into the output string any more (GW929).
    fn put_text(&mut self, text: &str, span: Span) {
        let (left, length) = (LONGEST - self.written.min(LONGEST), text.chars().count());
        let cut: String = text.chars().take(left).collect();
        if length > left && self.written <= LONGEST {
            self.faults.push(Fault::new(Id::GW929, span));
        }
        self.written += length;
        if !cut.is_empty() {
            self.sink.write_text(self.line, cut);
        }
    }
}
