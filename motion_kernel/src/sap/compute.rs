//! Instructions of a rw_SymPas program on values: the frequent ones in a loop of their own, then the others.

use super::code::{Instr, Slot};
use super::processor::{Pause, Processor, SLOTS};
use super::program::{Program, boolean, integer, real, timer};
use super::tables::Function;
use crate::mcu::Mcu;
use crate::tasks::{Output, runtime_error as error};

impl Processor {
    /// The frequent instructions, with the registers of the processor in those of the host. Comes back with the first
    /// instruction that is not one of them; Err: the share is used up.
    pub(super) fn compute(&mut self, code: &[Instr], left: &mut u32) -> Result<Instr, Pause> {
        use Instr::*;
        let (mut pc, base, memory) = (self.pc, self.base, &mut *self.memory);
        let mut overflow = false;
        // verified code stays inside the memory; the mask spares the check
        macro_rules! at {
            ($slot:expr) => {
                ($slot.index() + if $slot.is_global() { 0 } else { base }) & (SLOTS - 1)
            };
        }
        macro_rules! int {
            ($slot:expr) => {
                memory[at!($slot)] as i32
            };
        }
        macro_rules! real {
            ($slot:expr) => {
                f64::from_bits(memory[at!($slot)])
            };
        }
        macro_rules! integers {
            ($to:expr, $result:expr) => {{
                let (value, wrapped) = $result;
                overflow |= wrapped;
                memory[at!($to)] = integer(value);
            }};
        }
        // skips the jump behind a condition, or executes it
        macro_rules! branch {
            ($condition:expr) => {
                pc = match (code[pc], $condition) {
                    (Jump(to), false) => to as usize,
                    _ => pc + 1,
                }
            };
        }
        let stop = loop {
            let instr = code[pc];
            pc += 1;
            match instr {
                Statement(_) => {
                    if *left == 0 {
                        pc -= 1;
                        break Err(Pause::Share);
                    }
                    *left -= 1;
                    if self.attention {
                        break Ok(instr);
                    }
                }
                Copy(to, a) => memory[at!(to)] = memory[at!(a)],
                AddI(to, a, b) => integers!(to, int!(a).overflowing_add(int!(b))),
                SubI(to, a, b) => integers!(to, int!(a).overflowing_sub(int!(b))),
                MulI(to, a, b) => integers!(to, int!(a).overflowing_mul(int!(b))),
                And(to, a, b) => memory[at!(to)] = memory[at!(a)] & memory[at!(b)],
                Or(to, a, b) => memory[at!(to)] = memory[at!(a)] | memory[at!(b)],
                AddD(to, a, b) => memory[at!(to)] = real(real!(a) + real!(b)),
                SubD(to, a, b) => memory[at!(to)] = real(real!(a) - real!(b)),
                MulD(to, a, b) => memory[at!(to)] = real(real!(a) * real!(b)),
                ItoD(to, a) => memory[at!(to)] = real(f64::from(int!(a))),
                Jump(to) => pc = to as usize,
                JumpIfNot(a, to) => {
                    if memory[at!(a)] == 0 {
                        pc = to as usize;
                    }
                }
                IfEqI(a, b) => branch!(int!(a) == int!(b)),
                IfNeI(a, b) => branch!(int!(a) != int!(b)),
                IfLtI(a, b) => branch!(int!(a) < int!(b)),
                IfLeI(a, b) => branch!(int!(a) <= int!(b)),
                IfEqD(a, b) => branch!(real!(a) == real!(b)),
                IfNeD(a, b) => branch!(real!(a) != real!(b)),
                IfLtD(a, b) => branch!(real!(a) < real!(b)),
                IfLeD(a, b) => branch!(real!(a) <= real!(b)),
                NextUp(var, last) => {
                    let value = int!(var);
                    let more = value < int!(last);
                    if more {
                        memory[at!(var)] = integer(value.wrapping_add(1));
                    }
                    branch!(!more);
                }
                NextDown(var, last) => {
                    let value = int!(var);
                    let more = value > int!(last);
                    if more {
                        memory[at!(var)] = integer(value.wrapping_sub(1));
                    }
                    branch!(!more);
                }
                _ => break Ok(instr),
            }
        };
        self.pc = pc;
        self.overflow |= overflow;
        stop
    }

    /// The less frequent instructions. On Err the task pauses.
    pub(super) fn execute(
        &mut self,
        instr: Instr,
        program: &Program,
        mcu: &mut Mcu,
        output: &mut Output,
    ) -> Result<(), Pause> {
        use Instr::*;
        match instr {
            Statement(_) => return self.before_statement(),
            Call(number, base) => return self.call(program, number, self.base + usize::from(base), false),
            Return => return self.leave(),
            Constant(to, number) => self.put(to, program.constants[number as usize]),
            DivI(to, a, b) => {
                let divisor = self.divisor(b)?;
                self.put_int(to, self.int(a).overflowing_div(divisor));
            }
            ModI(to, a, b) => {
                let divisor = self.divisor(b)?;
                self.put(to, integer(self.int(a).wrapping_rem(divisor)));
            }
            NegI(to, a) => self.put_int(to, self.int(a).overflowing_neg()),
            ShlI(to, a, b) => self.put(to, integer(self.int(a).wrapping_shl(self.int(b) as u32))),
            ShrI(to, a, b) => self.put(to, integer(self.int(a).wrapping_shr(self.int(b) as u32))),
            Xor(to, a, b) => self.put(to, self.get(a) ^ self.get(b)),
            NotI(to, a) => self.put(to, integer(!self.int(a))),
            NotB(to, a) => self.put(to, self.get(a) ^ 1),
            DivD(to, a, b) => {
                let divisor = self.real(b);
                if divisor == 0.0 {
                    return Err(Pause::Error(error::BAD_PARAMETER));
                }
                self.put(to, real(self.real(a) / divisor));
            }
            NegD(to, a) => self.put(to, real(-self.real(a))),
            AddT(to, a, b) => self.put(to, timer(self.ticks(a).wrapping_add(self.ticks(b)))),
            SubT(to, a, b) => self.put(to, timer(self.ticks(a).wrapping_sub(self.ticks(b)))),
            EqI(to, a, b) => self.put(to, boolean(self.int(a) == self.int(b))),
            NeI(to, a, b) => self.put(to, boolean(self.int(a) != self.int(b))),
            LtI(to, a, b) => self.put(to, boolean(self.int(a) < self.int(b))),
            LeI(to, a, b) => self.put(to, boolean(self.int(a) <= self.int(b))),
            EqD(to, a, b) => self.put(to, boolean(self.real(a) == self.real(b))),
            NeD(to, a, b) => self.put(to, boolean(self.real(a) != self.real(b))),
            LtD(to, a, b) => self.put(to, boolean(self.real(a) < self.real(b))),
            LeD(to, a, b) => self.put(to, boolean(self.real(a) <= self.real(b))),
            EqT(to, a, b) => self.put(to, boolean(self.ticks(a) == self.ticks(b))),
            NeT(to, a, b) => self.put(to, boolean(self.ticks(a) != self.ticks(b))),
            LtT(to, a, b) => self.put(to, boolean(later(self.ticks(b), self.ticks(a)))),
            LeT(to, a, b) => self.put(to, boolean(!later(self.ticks(a), self.ticks(b)))),
            Math(function, to, a) => self.put(to, real(value_of(function, self.real(a)))),
            Power(to, a, b) => self.put(to, real(self.real(a).powf(self.real(b)))),
            Enable(event) => self.enable(event, true),
            Disable(event) => self.enable(event, false),
            Wait(a) => return Err(self.wait_for(self.int(a), mcu)),
            TtoD(..) | DtoI(..) | TtoI(..) | ItoT(..) | ItoB(..) | DtoB(..) | RoundS(..) => self.convert(instr),
            _ => return self.act(instr, program, mcu, output),
        }
        Ok(())
    }

    #[inline(always)]
    fn ticks(&self, slot: Slot) -> u32 {
        self.get(slot) as u32
    }
    fn divisor(&self, slot: Slot) -> Result<i32, Pause> {
        let value = self.int(slot);
        if value == 0 { Err(Pause::Error(error::BAD_PARAMETER)) } else { Ok(value) }
    }

    fn convert(&mut self, instr: Instr) {
        use Instr::*;
        match instr {
            TtoD(to, a) => self.put(to, real(f64::from(self.ticks(a)))),
            DtoI(to, a) => self.put(to, integer(self.real(a) as i32)),
            TtoI(to, a) => self.put(to, integer(self.ticks(a) as i32)),
            ItoT(to, a) => self.put(to, timer(self.ticks(a))),
            ItoB(to, a) => self.put(to, boolean(self.int(a) != 0)),
            DtoB(to, a) => self.put(to, boolean(self.real(a) != 0.0)),
            RoundS(to, a) => self.put(to, real(f64::from(self.real(a) as f32))),
            _ => {}
        }
    }
}

/// `a` is later than `b` on the cyclic clock.
fn later(a: u32, b: u32) -> bool {
    let ahead = a.wrapping_sub(b);
    ahead != 0 && ahead < 1 << 31
}

/// Functions of one Double; outside their domain the result is no number (errata Q4).
fn value_of(function: Function, x: f64) -> f64 {
    match function {
        Function::Abs => x.abs(),
        Function::Acos => x.acos(),
        Function::Asin => x.asin(),
        Function::Atan => x.atan(),
        Function::Cos => x.cos(),
        Function::Cosh => x.cosh(),
        Function::Exp => x.exp(),
        Function::Ln if x <= 0.0 => f64::NAN, // no valid result (6.6.28), nor for 0
        Function::Ln => x.ln(),
        Function::Sin => x.sin(),
        Function::Sinh => x.sinh(),
        Function::Sqr => x * x,
        Function::Sqrt => x.sqrt(),
        Function::Tan => x.tan(),
        Function::Tanh => x.tanh(),
    }
}
