//! M, S, T, H and dwell: the spool functions they become (docs/dialect.md, section 16).

use motion_kernel::autocode::Instr;
use motion_kernel::axes::AxisSet;

use crate::block::{AXIS_LETTERS, Block, GWord, bit, mask};
use crate::codes::{Group, number};
use crate::diagnostics::{Check, Fault, Id, Span};
use crate::dialect::{Dialect, LoneD};
use crate::outputs::Outputs;
use crate::translate::{Call, Flow, Translator};
use crate::variables::Variable;

/// Spool special functions by their number (4.4.123).
pub mod spool {
    pub const HALT: u16 = 1000;
    pub const SET_OUTPUTS: u16 = 1001;
    pub const RESET_OUTPUTS: u16 = 1002;
    /// Wait, unit 64 us.
    pub const WAIT: u16 = 1003;
    pub const WAIT_INPUTS: u16 = 1004;
    /// Wait until the application clears CI99.
    pub const WAIT_HOST: u16 = 1025;
    /// Motor command port of axis 0; the others follow.
    pub const MOTOR_COMMAND: u16 = 1200;
    pub const WRITE_CD: u16 = 20000;
}

/// Letters of a G65 block and the variables they set (Fanuc, first table; M is 13).
const MACRO_ARGUMENTS: [(u8, usize); 20] = [
    (b'A', 1),
    (b'B', 2),
    (b'C', 3),
    (b'I', 4),
    (b'J', 5),
    (b'K', 6),
    (b'D', 7),
    (b'E', 8),
    (b'F', 9),
    (b'H', 11),
    (b'Q', 17),
    (b'R', 18),
    (b'S', 19),
    (b'T', 20),
    (b'U', 21),
    (b'V', 22),
    (b'W', 23),
    (b'X', 24),
    (b'Y', 25),
    (b'Z', 26),
];

impl Translator<'_> {
    pub(crate) fn first(&self) -> AxisSet {
        AxisSet::single(self.sink.first_axis())
    }
    /// A wait function for all group axes.
    pub(crate) fn wait(&mut self, command: u16, value: f64) {
        self.sink.ssf(self.line, self.sink.set(), command, value, true);
        self.sink.instr(self.line, Instr::Ssms(self.sink.set()));
    }
    /// A host event that the path waits for.
    pub(crate) fn host_wait(&mut self, kind: &str, text: &str) {
        self.sink.stop();
        self.sink.event(self.line, kind, text);
        self.wait(spool::WAIT_HOST, 1.0);
    }
    /// G75: everything spooled is done before the task goes on.
    pub(crate) fn drain(&mut self) {
        self.sink.stop();
        self.sink.instr(self.line, Instr::Drain(self.sink.set()));
    }

    /// Step 3: MSG.
    pub(crate) fn message(&mut self, block: &Block) {
        if let Some(text) = &block.message {
            self.sink.event(self.line, "MSG", text);
        }
    }

    /// Steps 6 to 9: T, M06, gear, spindle start, coolant on, clamps.
    pub(crate) fn tool_and_outputs_before(&mut self, block: &Block) -> Check<()> {
        self.used |= bit(b'T');
        if let Some(word) = block.word(b'T') {
            let number = word.value as u32;
            self.select_tool(number);
            self.sink.event(self.line, "T", &number.to_string());
        }
        if block.has(b'H') && block.code_of(Group::LengthCorrection).is_none() {
            self.used |= bit(b'H');
            let value = block.value(b'H').unwrap_or(0.0);
            self.sink.ssf(self.line, self.first(), self.machine.gcode.auxiliary_ci as u16, value, false);
        }
        if let Some(m) = block.m(6) {
            self.tool_change(m.span)?;
        }
        let turns = [3, 4, 13, 14].iter().any(|m| block.m(*m).is_some());
        if turns {
            self.end_thread();
        }
        let mut outputs = Outputs::default();
        for m in &block.m {
            self.function_before(block, m.number, m.span, &mut outputs)?;
        }
        self.put_out(outputs);
        if turns {
            self.direction_changed();
            self.run_up();
        }
        Ok(())
    }
    /// The lathe's T word holds tool and correction.
    pub(crate) fn select_tool(&mut self, number: u32) {
        let split = self.dialect.lathe && number >= 100;
        self.state.modal.tool = if split { number / 100 } else { number };
        self.state.modal.tool_offset = split.then_some(number % 100);
        self.state.modal.tool_named = true;
        if split {
            self.state.modal.d = None;
        }
    }
    fn tool_change(&mut self, span: Span) -> Check<()> {
        if self.dialect.m6_needs_t && !std::mem::take(&mut self.state.modal.tool_named) {
            return Err(Fault::new(Id::GC516, span));
        }
        let tool = self.state.modal.tool;
        self.state.modal.in_spindle = tool;
        if self.dialect.lone_d != LoneD::Modal {
            self.state.modal.d = None;
        }
        self.facts.tool_changed(tool);
        if tool != 0 && self.tool(tool).is_none() {
            self.faults.push(Fault::with(Id::GW935, span, &[&tool]));
        }
        self.host_wait("M06", &tool.to_string());
        Ok(())
    }
    fn function_before(&mut self, block: &Block, m: u16, span: Span, outputs: &mut Outputs) -> Check<()> {
        let modal = &mut self.state.modal;
        let lines = self.machine.gcode.outputs;
        match m {
            3 | 13 => (modal.spindle, _) = (3, outputs.turn(lines.spindle_cw, lines.spindle_ccw)),
            4 | 14 => (modal.spindle, _) = (4, outputs.turn(lines.spindle_ccw, lines.spindle_cw)),
            7 => (modal.coolant[1], _) = (true, outputs.put(lines.coolant2, 0)),
            8 => (modal.coolant[0], _) = (true, outputs.put(lines.coolant1, 0)),
            10 => self.clamp((lines.clamp, 0), lines.clamp_wait, outputs),
            11 => self.clamp((0, lines.clamp), lines.unclamp_wait, outputs),
            19 => {
                self.used |= mask("SR");
                let angle = block.value(b'S').or(block.value(b'R')).unwrap_or(0.0);
                self.host_wait("M19", &angle.to_string());
            }
            36..=39 => self.sink.event(self.line, &format!("M{m}"), ""),
            40..=45 => self.host_wait(&format!("M{m}"), ""),
            48 | 49 => {
                modal.override_on = m == 48;
                self.sink.event(self.line, &format!("M{m}"), "");
            }
            97 if block.has(b'P') && !self.is_user_function(m) => {
                return Err(Fault::with(Id::GC510, span, &[&m])); // Haas: a call within the program
            }
            15 | 16 | 31 if !self.is_user_function(m) => return Err(Fault::with(Id::GC510, span, &[&m])),
            62..=65 => self.output(block, m, span, outputs)?,
            66 => self.wait_input(block, span)?,
            0..=2 | 5 | 6 | 9 | 17 | 30 | 60 | 98 | 99 => {}
            29 if !self.dialect.rigid_m29 => {}
            _ if self.is_user_function(m) => self.user_function(m, outputs),
            _ if self.dialect.strict_m => return Err(Fault::with(Id::GC513, span, &[&m])),
            _ => {
                self.faults.push(Fault::with(Id::GW930, span, &[&format!("M{m}")]));
                self.sink.event(self.line, &format!("M{m}"), "");
            }
        }
        if matches!(m, 13 | 14) {
            self.state.modal.coolant[0] = true;
            outputs.put(lines.coolant1, 0);
        }
        Ok(())
    }
    /// Number of an output or input, P0..P31.
    fn line_number(&mut self, block: &Block, m: u16, span: Span) -> Check<u32> {
        self.used |= bit(b'P');
        let Some(word) = block.word(b'P') else { return Err(Fault::with(Id::GC310, span, &[&format!("M{m}"), &'P'])) };
        if word.value.fract() != 0.0 || !(0.0..=31.0).contains(&word.value) {
            return Err(Fault::with(Id::GC514, word.span, &[&word.value]));
        }
        Ok(word.value as u32)
    }
    /// M62..M65: output P on or off, in step with motion.
    fn output(&mut self, block: &Block, m: u16, span: Span, outputs: &mut Outputs) -> Check<()> {
        let bit = 1 << self.line_number(block, m, span)?;
        if m.is_multiple_of(2) {
            outputs.put(bit, 0)
        } else {
            outputs.put(0, bit)
        }
        if m >= 64 {
            self.faults.push(Fault::new(Id::GW931, span));
        }
        Ok(())
    }
    /// M66 Pn L3: wait for an input; L0 goes on at once.
    fn wait_input(&mut self, block: &Block, span: Span) -> Check<()> {
        let mode = block.integer(b'L').unwrap_or(0);
        self.used |= bit(b'L');
        if block.has(b'Q') || !matches!(mode, 0 | 3) {
            let word = block.word(b'Q').or(block.word(b'L'));
            return Err(Fault::new(Id::GC511, word.map_or(span, |w| w.span)));
        }
        let input = self.line_number(block, 66, span)?;
        if mode == 3 {
            self.wait(spool::WAIT_INPUTS, f64::from(1u32 << input));
        }
        Ok(())
    }

    /// A dwell stands alone with its time.
    pub(crate) fn check_dwell_block(&self, block: &Block) -> Check<()> {
        let time = mask("XU");
        if let Some(g) = block.g.iter().find(|g| {
            let code = g.code;
            code.group == Group::Motion && code.tenths <= 30 || code.group == Group::OneShot && code.tenths != 40
        }) {
            let dwell = block.g(40).map_or(g.span, |d| d.span);
            let later = if dwell.start > g.span.start { dwell } else { g.span };
            return Err(Fault::new(Id::GC304, later));
        }
        match block.first_of(AXIS_LETTERS & !time) {
            Some((_, word)) => Err(Fault::new(Id::GC304, word.span)),
            None => Ok(()),
        }
    }
    /// Step 10: G04.
    pub(crate) fn dwell(&mut self, block: &Block) -> Check<()> {
        let Some(g) = block.g(40).copied() else { return Ok(()) };
        let times = mask("XUFPS");
        self.used |= times;
        let mut found = None;
        for letter in *b"XUFPS" {
            if let Some(word) = block.word(letter) {
                if found.is_some() {
                    let (_, last) = block.first_of(bit(letter)).expect("the word is there");
                    return Err(Fault::new(Id::GC508, last.span));
                }
                let seconds = if letter == b'S' {
                    word.value * 60.0 / self.revolutions(block)?
                } else {
                    dwell_seconds(&self.dialect, letter, word.value, word.integer_form)
                };
                found = Some((seconds, word.span));
            }
        }
        let Some((seconds, span)) = found else { return Err(Fault::new(Id::GC507, g.span)) };
        self.wait_seconds(seconds, span)
    }
    /// 1003 on all group axes; 0 only stops the path.
    pub(crate) fn wait_seconds(&mut self, seconds: f64, span: Span) -> Check<()> {
        if seconds < 0.0 {
            return Err(Fault::new(Id::GC506, span));
        }
        if seconds > 86400.0 {
            return Err(Fault::new(Id::GC512, span));
        }
        if seconds == 0.0 {
            self.sink.stop();
            return Ok(());
        }
        if seconds < self.machine.sample_time_s() {
            self.faults.push(Fault::new(Id::GW932, span));
        }
        self.wait(spool::WAIT, (seconds / 64e-6 + 0.5).floor());
        Ok(())
    }

    /// Step 20: M05, M09.
    pub(crate) fn outputs_after(&mut self, block: &Block) -> Check<()> {
        let (mut outputs, lines) = (Outputs::default(), self.machine.gcode.outputs);
        if block.m(5).is_some() {
            self.state.modal.spindle = 5;
            self.direction_changed();
            outputs.put(0, lines.spindle_cw | lines.spindle_ccw);
        }
        if block.m(9).is_some() {
            self.state.modal.coolant = [false; 2];
            outputs.put(0, lines.coolant1 | lines.coolant2);
        }
        self.put_out(outputs);
        Ok(())
    }

    /// Steps 21 and 22: calls, returns, stops, end.
    pub(crate) fn flow_step(&mut self, block: &Block) -> Check<Flow> {
        if let Some(call) = self.call(block)? {
            return Ok(Flow::Call(call));
        }
        for m in &block.m {
            match m.number {
                0 | 60 => self.operator_stop(m.number),
                1 if self.options.optional_stop => self.operator_stop(1),
                2 | 30 => return Ok(Flow::End),
                29 if self.dialect.rigid_m29 => {}
                17 | 29 | 99 => {
                    self.used |= bit(b'P');
                    let target = block.whole(b'P')?.map(|p| (p as u32, block.span_of(b'P')));
                    return Ok(Flow::Return(target));
                }
                _ => {}
            }
        }
        Ok(Flow::Next)
    }
    pub(crate) fn operator_stop(&mut self, m: u16) {
        self.sink.stop();
        self.sink.event(self.line, &format!("M{m:02}"), "");
        self.wait(spool::HALT, 0.0);
    }
    fn call(&mut self, block: &Block) -> Check<Option<Call>> {
        let m98 = block.m(98);
        let by_l = m98.is_none() && block.g(100).is_none() && block.m(66).is_none() && block.g(650).is_none();
        let by_l = by_l && !matches!(self.state.modal.motion, crate::modal::MotionMode::Cycle(_));
        if let Some(m) = m98 {
            self.used |= mask("PL");
            let Some(p) = block.whole(b'P')? else { return Err(Fault::new(Id::GC612, m.span)) };
            let count = block.integer(b'L').unwrap_or(1);
            let (name, count) =
                if !block.has(b'L') && p >= 10000 { (p % 10000, (p / 10000) as u32) } else { (p, count) };
            return self.counted(block, name.to_string(), count, m.span).map(Some);
        }
        if let Some((name, span)) = &block.call_name {
            return self.executions(block, name.clone(), *span).map(Some);
        }
        match block.word(b'L') {
            Some(word) if by_l => {
                self.used |= bit(b'L');
                self.executions(block, (word.value as u32).to_string(), word.span).map(Some)
            }
            _ => Ok(None),
        }
    }
    fn executions(&mut self, block: &Block, name: String, span: Span) -> Check<Call> {
        self.used |= bit(b'O');
        let count = block.integer(b'O').unwrap_or(1);
        self.counted(block, name, count, span)
    }
    /// `G65 P<n> [L] A.. B..`: a call with a set of #1..#33 of its own.
    pub(crate) fn macro_call(&mut self, block: &Block, g: &GWord) -> Check<Flow> {
        let mapped = self.machine.gcode.g_functions.iter().find(|f| f.0 == g.code.tenths);
        if g.code.group == Group::Call && mapped.is_none() {
            return Err(Fault::with(Id::GC305, g.span, &[&number(g.code.tenths)]));
        }
        if mapped.is_none() && !self.dialect.macros {
            return Err(Fault::with(Id::GC305, g.span, &[&"65"]));
        }
        if let Some(other) = block.g.iter().find(|w| w.code.tenths != g.code.tenths) {
            let (one, two) = (number(other.code.tenths), number(g.code.tenths));
            return Err(Fault::with(Id::GC303, other.span, &[&format!("G{two}"), &format!("G{one}")]));
        }
        self.used = u32::MAX;
        let name = match mapped {
            Some((_, name)) => name.clone(),
            None => block.whole(b'P')?.ok_or_else(|| Fault::new(Id::GC612, g.span))?.to_string(),
        };
        let mut arguments: Vec<(usize, f64)> =
            MACRO_ARGUMENTS.iter().filter_map(|(letter, n)| block.value(*letter).map(|v| (*n, v))).collect();
        if let Some(m) = block.m.first() {
            arguments.push((13, f64::from(m.number)));
        }
        let count = block.integer(b'L').unwrap_or(1);
        if count > 9999 {
            return Err(Fault::with(Id::GC616, block.span_of(b'L'), &[&count]));
        }
        Ok(Flow::Call(Call { name, count, arguments: Some(arguments), span: g.span }))
    }
    fn counted(&mut self, block: &Block, name: String, count: u32, span: Span) -> Check<Call> {
        if count > 9999 {
            return Err(Fault::with(Id::GC616, span, &[&count]));
        }
        if count == 0 {
            self.faults.push(Fault::new(Id::GW910, span));
        }
        if block.has_any(AXIS_LETTERS) {
            self.faults.push(Fault::new(Id::GW911, span));
        }
        Ok(Call { name, count, arguments: None, span })
    }

    /// Program end: outputs off, everything done, modal reset.
    pub fn end(&mut self, kind: &str) {
        if let Err(fault) = self.sink.close_correction(Span::new(0, 1)) {
            self.faults.push(fault);
        }
        self.end_thread();
        self.sink.stop();
        if !self.options.mdi {
            self.state.modal.spindle = 5;
            self.direction_changed();
            let lines = self.machine.gcode.outputs;
            let reset = lines.spindle_cw | lines.spindle_ccw | lines.coolant1 | lines.coolant2;
            self.put_out(Outputs { set: 0, reset });
        }
        self.sink.event(self.line, kind, "");
        self.sink.instr(self.line, Instr::Drain(self.sink.set()));
        self.set_cylinder(None);
        self.sink.instr(self.line, Instr::Halt);
    }

    /// Assignments of a block: `CIn` and `CDn` are spooled, in step with motion.
    pub fn assign(&mut self, block: &Block, variables: &mut crate::variables::Variables) {
        for a in &block.assignments {
            variables.set(&a.variable, a.value);
            match a.variable {
                Variable::Ci(n) => self.sink.ssf(self.line, self.first(), n, a.value.round(), false),
                Variable::Cd(n) => self.sink.ssf(self.line, self.first(), spool::WRITE_CD + n, a.value, false),
                _ => {}
            }
        }
    }
    /// `#3000 = n (text)` is an alarm, `#3006 = n (text)` a stop with a text.
    pub fn alarm(&mut self, block: &Block, text: &str) {
        for a in &block.assignments {
            let kind = match a.variable {
                Variable::Hash(3000) => "ALARM",
                Variable::Hash(3006) => "STOP",
                _ => continue,
            };
            self.sink.stop();
            self.sink.event(self.line, kind, &format!("{} {text}", number_text(a.value)));
            self.wait(spool::HALT, 0.0);
        }
    }
}

/// Integers plain, others with up to 6 significant decimals and no trailing zeros.
pub fn number_text(value: f64) -> String {
    if value.fract() == 0.0 && value.abs() < 1e15 {
        return format!("{value:.0}");
    }
    format!("{value:.6}").trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// X, U and F are seconds; P is in the unit of the dialect.
pub(crate) fn dwell_seconds(dialect: &Dialect, letter: u8, value: f64, integer_form: bool) -> f64 {
    if letter == b'P' {
        return value * dialect.dwell_p;
    }
    if integer_form && dialect.integer_increment > 0.0 { value * dialect.integer_increment } else { value }
}
