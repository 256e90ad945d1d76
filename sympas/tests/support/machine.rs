//! A plain interpreter of the register code's core: checks the compiler where no controller is needed.

use std::collections::BTreeMap;

use motion_kernel::sap::code::{Instr, Slot};
use motion_kernel::sap::program::{Program, boolean, integer, real, timer};
use motion_kernel::sap::tables::Type;

use super::evaluator::{End, Outcome, shown};
use super::values::{Value, function};

struct Machine<'p> {
    program: &'p Program,
    globals: Vec<u64>,
    stack: Vec<u64>,
    /// Frame base, slots of the frame, return address.
    frames: Vec<(usize, usize, usize)>,
    at: usize,
    output: String,
    ci: BTreeMap<u32, i32>,
    cd: BTreeMap<u32, f64>,
    buffer: Vec<u8>,
}

pub fn run(program: &Program, mut most: u64) -> Outcome {
    let main = &program.routines[0];
    let mut machine = Machine {
        program,
        globals: program.globals.clone(),
        stack: vec![0; usize::from(main.frame)],
        frames: vec![(0, usize::from(main.frame), usize::MAX)],
        at: main.entry as usize,
        output: String::new(),
        ci: BTreeMap::new(),
        cd: BTreeMap::new(),
        buffer: vec![0; 1000],
    };
    let end = loop {
        most -= 1;
        if most == 0 {
            break End::Endless;
        }
        let line = program.lines[machine.at].1;
        match machine.step() {
            Ok(true) => {}
            Ok(false) => break End::Finished,
            Err(End::Error(number, _)) => break End::Error(number, line),
            Err(other) => break other,
        }
    };
    Outcome { end, output: machine.output, ci: machine.ci, cd: machine.cd }
}

impl Machine<'_> {
    fn slot(&mut self, slot: Slot) -> &mut u64 {
        if slot.is_global() {
            return &mut self.globals[slot.index()];
        }
        let base = self.frames.last().expect("a frame").0;
        &mut self.stack[base + slot.index()]
    }
    fn set(&mut self, slot: Slot, bits: u64) {
        *self.slot(slot) = bits;
    }
    fn i(&mut self, slot: Slot) -> i32 {
        let bits = *self.slot(slot);
        assert_eq!(bits, integer(bits as i32), "an Integer is sign-extended");
        bits as i32
    }
    fn t(&mut self, slot: Slot) -> u32 {
        *self.slot(slot) as u32
    }
    fn d(&mut self, slot: Slot) -> f64 {
        f64::from_bits(*self.slot(slot))
    }
    /// The jump behind a conditional instruction is executed if `jump`, else skipped.
    fn test(&mut self, jump: bool) {
        assert!(matches!(self.program.code[self.at], Instr::Jump(_)));
        if !jump {
            self.at += 1;
        }
    }
    fn next(&mut self, variable: Slot, more: bool, step: i32) {
        let value = self.i(variable);
        if more {
            self.set(variable, integer(value + step));
        }
        self.test(more);
    }
    fn span(&mut self, slot: Slot, size: i32) -> Result<std::ops::Range<usize>, End> {
        let at = self.i(slot);
        if !(0..=1000 - size).contains(&at) {
            return Err(End::Error(0x0100, 0));
        }
        if at % size != 0 {
            return Err(End::Error(if size == 8 { 0x0800 } else { 0x0100 }, 0));
        }
        Ok(at as usize..(at + size) as usize)
    }
    fn step(&mut self) -> Result<bool, End> {
        use Instr::*;
        let instr = self.program.code[self.at];
        self.at += 1;
        let zero = |b: i32| if b == 0 { Err(End::Error(0x8000, 0)) } else { Ok(b) };
        macro_rules! set {
            ($to:expr, $value:expr) => {{
                let value = $value;
                self.set($to, value)
            }};
        }
        match instr {
            Statement(line) => assert_eq!(line, self.program.lines[self.at - 1].1),
            Copy(to, a) => set!(to, *self.slot(a)),
            Clear(to) => self.set(to, 0),
            AddI(to, a, b) => set!(to, integer(self.i(a).wrapping_add(self.i(b)))),
            SubI(to, a, b) => set!(to, integer(self.i(a).wrapping_sub(self.i(b)))),
            MulI(to, a, b) => set!(to, integer(self.i(a).wrapping_mul(self.i(b)))),
            DivI(to, a, b) => set!(to, integer(self.i(a).wrapping_div(zero(self.i(b))?))),
            ModI(to, a, b) => set!(to, integer(self.i(a).wrapping_rem(zero(self.i(b))?))),
            NegI(to, a) => set!(to, integer(self.i(a).wrapping_neg())),
            ShlI(to, a, b) => set!(to, integer(self.i(a) << (self.i(b) & 31))),
            ShrI(to, a, b) => set!(to, integer(self.i(a) >> (self.i(b) & 31))),
            And(to, a, b) => set!(to, *self.slot(a) & *self.slot(b)),
            Or(to, a, b) => set!(to, *self.slot(a) | *self.slot(b)),
            Xor(to, a, b) => set!(to, *self.slot(a) ^ *self.slot(b)),
            NotI(to, a) => set!(to, integer(!self.i(a))),
            NotB(to, a) => set!(to, boolean(*self.slot(a) == 0)),
            AddD(to, a, b) => set!(to, real(self.d(a) + self.d(b))),
            SubD(to, a, b) => set!(to, real(self.d(a) - self.d(b))),
            MulD(to, a, b) => set!(to, real(self.d(a) * self.d(b))),
            DivD(_, _, b) if self.d(b) == 0.0 => return Err(End::Error(0x8000, 0)),
            DivD(to, a, b) => set!(to, real(self.d(a) / self.d(b))),
            NegD(to, a) => set!(to, real(-self.d(a))),
            AddT(to, a, b) => set!(to, timer(self.t(a).wrapping_add(self.t(b)))),
            SubT(to, a, b) => set!(to, timer(self.t(a).wrapping_sub(self.t(b)))),
            EqI(to, a, b) => set!(to, boolean(self.i(a) == self.i(b))),
            NeI(to, a, b) => set!(to, boolean(self.i(a) != self.i(b))),
            LtI(to, a, b) => set!(to, boolean(self.i(a) < self.i(b))),
            LeI(to, a, b) => set!(to, boolean(self.i(a) <= self.i(b))),
            EqD(to, a, b) => set!(to, boolean(self.d(a) == self.d(b))),
            NeD(to, a, b) => set!(to, boolean(self.d(a) != self.d(b))),
            LtD(to, a, b) => set!(to, boolean(self.d(a) < self.d(b))),
            LeD(to, a, b) => set!(to, boolean(self.d(a) <= self.d(b))),
            EqT(to, a, b) => set!(to, boolean(self.t(a) == self.t(b))),
            NeT(to, a, b) => set!(to, boolean(self.t(a) != self.t(b))),
            LtT(to, a, b) => set!(to, boolean((1..=0x7FFF_FFFF).contains(&self.t(b).wrapping_sub(self.t(a))))),
            LeT(to, a, b) => set!(to, boolean(!(1..=0x7FFF_FFFF).contains(&self.t(a).wrapping_sub(self.t(b))))),
            ItoD(to, a) => set!(to, real(f64::from(self.i(a)))),
            TtoD(to, a) => set!(to, real(f64::from(self.t(a)))),
            DtoI(to, a) => set!(to, integer(self.d(a) as i32)),
            TtoI(to, a) => set!(to, integer(self.t(a) as i32)),
            ItoT(to, a) => set!(to, timer(self.i(a) as u32)),
            ItoB(to, a) => set!(to, boolean(*self.slot(a) != 0)),
            DtoB(to, a) => set!(to, boolean(self.d(a) != 0.0)),
            RoundS(to, a) => set!(to, real(f64::from(self.d(a) as f32))),
            Jump(to) => self.at = to as usize,
            JumpIfNot(a, to) => {
                if *self.slot(a) == 0 {
                    self.at = to as usize;
                }
            }
            IfEqI(a, b) => {
                let ok = self.i(a) == self.i(b);
                self.test(!ok)
            }
            IfNeI(a, b) => {
                let ok = self.i(a) != self.i(b);
                self.test(!ok)
            }
            IfLtI(a, b) => {
                let ok = self.i(a) < self.i(b);
                self.test(!ok)
            }
            IfLeI(a, b) => {
                let ok = self.i(a) <= self.i(b);
                self.test(!ok)
            }
            IfEqD(a, b) => {
                let ok = self.d(a) == self.d(b);
                self.test(!ok)
            }
            IfNeD(a, b) => {
                let ok = self.d(a) != self.d(b);
                self.test(!ok)
            }
            IfLtD(a, b) => {
                let ok = self.d(a) < self.d(b);
                self.test(!ok)
            }
            IfLeD(a, b) => {
                let ok = self.d(a) <= self.d(b);
                self.test(!ok)
            }
            NextUp(a, b) => {
                let more = self.i(a) < self.i(b);
                self.next(a, more, 1)
            }
            NextDown(a, b) => {
                let more = self.i(a) > self.i(b);
                self.next(a, more, -1)
            }
            Call(number, base) => {
                let routine = &self.program.routines[usize::from(number)];
                let base = self.frames.last().expect("a frame").0 + usize::from(base);
                let (frame, given) = (usize::from(routine.frame), usize::from(routine.parameters));
                self.stack.resize(self.stack.len().max(base + frame + 1), 0);
                let first = base + usize::from(routine.function);
                if routine.function {
                    self.stack[base] = 0;
                }
                self.stack[first + given..base + frame.max(first + given - base)].fill(0);
                self.frames.push((base, frame, self.at));
                self.at = routine.entry as usize;
            }
            Return => {
                let (.., back) = self.frames.pop().expect("a frame");
                if self.frames.is_empty() {
                    return Ok(false);
                }
                self.at = back;
            }
            Math(f, to, a) => set!(to, real(function(f.name(), self.d(a)))),
            Power(to, a, b) => set!(to, real(self.d(a).powf(self.d(b)))),
            ReadCi(_, n) | WriteCi(_, n) | ReadCd(_, n) | WriteCd(_, n) if n > 999 => {
                return Err(End::Error(0x0400, 0));
            }
            ReadCi(to, n) => set!(to, integer(self.ci.get(&n).copied().unwrap_or(0))),
            WriteCi(a, n) => {
                let value = self.i(a);
                self.ci.insert(n, value);
            }
            ReadCd(to, n) => set!(to, real(self.cd.get(&n).copied().unwrap_or(0.0))),
            WriteCd(a, n) => {
                let value = self.d(a);
                self.cd.insert(n, value);
            }
            ReadBuffer(of, to, offset) => {
                let range = self.span(offset, if of == Type::Double { 8 } else { 4 })?;
                let bytes = self.buffer[range].to_vec();
                set!(
                    to,
                    match of {
                        Type::Integer => integer(i32::from_le_bytes(bytes.try_into().expect("4"))),
                        Type::Single => real(f64::from(f32::from_le_bytes(bytes.try_into().expect("4")))),
                        _ => real(f64::from_le_bytes(bytes.try_into().expect("8"))),
                    }
                );
            }
            WriteBuffer(of, offset, from) => {
                let range = self.span(offset, if of == Type::Double { 8 } else { 4 })?;
                let bytes = match of {
                    Type::Integer => self.i(from).to_le_bytes().to_vec(),
                    Type::Single => (self.d(from) as f32).to_le_bytes().to_vec(),
                    _ => self.d(from).to_le_bytes().to_vec(),
                };
                self.buffer[range].copy_from_slice(&bytes);
            }
            WriteText(n) => self.output += &self.program.texts[n as usize],
            WriteValue(of, a) => {
                let value = match of {
                    Type::Boolean => Value::Boolean(*self.slot(a) != 0),
                    Type::Integer => Value::Integer(self.i(a)),
                    Type::Timer => Value::Timer(self.t(a)),
                    Type::Single => Value::Single(self.d(a)),
                    Type::Double => Value::Double(self.d(a)),
                };
                self.output += &shown(value);
            }
            Writeln => self.output.push('\n'),
            Abort => return Err(End::Aborted),
            other => return Err(End::Beyond(format!("{other:?}"))),
        }
        Ok(true)
    }
}
