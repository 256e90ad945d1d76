//! Instructions of a rw_SymPas program on the controller: common variables, registers, buffers, output, tasks.

use super::code::{Instr, Slot};
use super::processor::{Pause, Processor};
use super::program::{Program, boolean, integer, real};
use super::tables::{Indexed, TaskCommand, Type};
use crate::axes::AxisSet;
use crate::axis::Doing;
use crate::mcu::{COMMONS, Mcu};
use crate::registers::{Axst, ModeReg};
use crate::spooler::SpoolState;
use crate::tasks::{Output, runtime_error as error};

impl Processor {
    /// Everything beyond values and control flow.
    pub(super) fn act(
        &mut self,
        instr: Instr,
        program: &Program,
        mcu: &mut Mcu,
        output: &mut Output,
    ) -> Result<(), Pause> {
        use Instr::*;
        match instr {
            ReadCi(..) | WriteCi(..) | ReadCd(..) | WriteCd(..) => return self.common_variable(instr, mcu),
            ReadSystem(parameter, to) => self.put(to, mcu.read_system(parameter)),
            WriteSystem(parameter, from) => mcu.write_system(parameter, self.get(from)),
            ReadAxis(qualifier, to, axis) => {
                let axis = self.axis(axis, mcu)?;
                self.put(to, mcu.read_qualifier(axis, qualifier));
            }
            WriteAxis(qualifier, axis, from) => {
                let axis = self.axis(axis, mcu)?;
                mcu.write_qualifier(axis, qualifier, self.get(from));
            }
            ReadAxisBit(qualifier, bit, to, axis) => {
                let axis = self.axis(axis, mcu)?;
                self.put(to, boolean(mcu.read_qualifier_bit(axis, qualifier, bit)));
            }
            WriteAxisBit(_, bit, axis, from) => {
                let axis = self.axis(axis, mcu)?;
                mcu.wrdigob(axis, u32::from(bit), self.get(from) != 0);
            }
            ReadSysVar(..) | WriteSysVar(..) | ReadAxisVar(..) | WriteAxisVar(..) => {
                return self.application_variable(instr, mcu);
            }
            ReadBuffer(..) | WriteBuffer(..) => return self.common_buffer(instr, mcu),
            Do(..) | AwaitEnd(..) => return self.commanded(instr, program, mcu),
            Task(command, number) => return self.task(command, usize::from(number), mcu),
            Azo(set) => mcu.azo(i32::from(set)),
            Stop => return Err(Pause::Stop),
            Abort => return Err(Pause::Abort),
            WriteText(text) => output.append(&program.texts[text as usize]),
            WriteValue(kind, from) => self.write_value(kind, from, output),
            Writeln => {
                output.close();
                if mcu.registers.modereg.has(ModeReg::StopAtWriteln) {
                    return Err(Pause::Writeln);
                }
            }
            _ => return Err(Pause::Error(error::BAD_CODE)),
        }
        Ok(())
    }

    /// The axis that a slot names; outside the machine it is an address violation (errata Q31).
    pub(super) fn axis(&self, slot: Slot, mcu: &Mcu) -> Result<usize, Pause> {
        let axis = self.int(slot);
        let known = (0..mcu.axes.len() as i32).contains(&axis);
        if known { Ok(axis as usize) } else { Err(Pause::Error(error::BAD_ARGUMENT)) }
    }

    fn common_variable(&mut self, instr: Instr, mcu: &mut Mcu) -> Result<(), Pause> {
        use Instr::*;
        let (ReadCi(_, number) | WriteCi(_, number) | ReadCd(_, number) | WriteCd(_, number)) = instr else {
            return Err(Pause::Error(error::BAD_CODE));
        };
        let n = number as usize;
        if n >= COMMONS {
            return Err(Pause::Error(error::COMMON_RANGE));
        }
        match instr {
            ReadCi(to, _) => self.put(to, integer(mcu.ci[n])),
            WriteCi(from, _) => mcu.ci[n] = self.int(from),
            ReadCd(to, _) => self.put(to, real(mcu.cd[n])),
            WriteCd(from, _) => mcu.cd[n] = self.real(from),
            _ => {}
        }
        Ok(())
    }

    fn application_variable(&mut self, instr: Instr, mcu: &mut Mcu) -> Result<(), Pause> {
        use Instr::*;
        let outside = Pause::Error(error::BAD_ARGUMENT);
        let (which, variables, index) = match instr {
            ReadSysVar(which, _, index) | WriteSysVar(which, index, _) => (which, &mut mcu.card.variables, index),
            ReadAxisVar(which, _, axis, index) | WriteAxisVar(which, axis, index, _) => {
                let axis = self.axis(axis, mcu)?;
                (which, &mut mcu.card.axes[axis].variables, index)
            }
            _ => return Err(Pause::Error(error::BAD_CODE)),
        };
        let n = usize::try_from(self.int(index)).map_err(|_| outside)?;
        let value = match which {
            Indexed::Integer => variables.int.get(n).map(|v| integer(*v)),
            Indexed::Double => variables.dbl.get(n).map(|v| real(*v)),
        };
        let value = value.ok_or(outside)?;
        match (instr, which) {
            (ReadSysVar(_, to, _) | ReadAxisVar(_, to, ..), _) => self.put(to, value),
            (WriteSysVar(.., from) | WriteAxisVar(.., from), Indexed::Integer) => variables.int[n] = self.int(from),
            (WriteSysVar(.., from) | WriteAxisVar(.., from), Indexed::Double) => variables.dbl[n] = self.real(from),
            _ => {}
        }
        Ok(())
    }

    /// rdcb..., wrcb...: offsets are bytes, divisible by the size of the value (errata Q22).
    fn common_buffer(&mut self, instr: Instr, mcu: &mut Mcu) -> Result<(), Pause> {
        let (Instr::ReadBuffer(kind, to, offset) | Instr::WriteBuffer(kind, offset, to)) = instr else {
            return Err(Pause::Error(error::BAD_CODE));
        };
        let size: usize = if kind == Type::Double { 8 } else { 4 };
        let buffer = mcu.card.buffer_mut(self.number);
        let Ok(at) = usize::try_from(self.int(offset)) else { return Err(Pause::Error(error::BAD_ARGUMENT)) };
        if at % size != 0 {
            return Err(Pause::Error(if size == 8 { error::BUFFER_ALIGNMENT } else { error::BAD_ARGUMENT }));
        }
        let Some(bytes) = buffer.get_mut(at..at + size) else { return Err(Pause::Error(error::BAD_ARGUMENT)) };
        if let Instr::WriteBuffer(..) = instr {
            match kind {
                Type::Integer => bytes.copy_from_slice(&self.int(to).to_le_bytes()),
                Type::Single => bytes.copy_from_slice(&(self.real(to) as f32).to_le_bytes()),
                _ => bytes.copy_from_slice(&self.real(to).to_le_bytes()),
            }
            return Ok(());
        }
        let mut raw = [0; 8];
        raw[..size].copy_from_slice(bytes);
        let word = u32::from_le_bytes([raw[0], raw[1], raw[2], raw[3]]);
        self.put(
            to,
            match kind {
                Type::Integer => integer(word as i32),
                Type::Single => real(f64::from(f32::from_bits(word))),
                _ => real(f64::from_le_bytes(raw)),
            },
        );
        Ok(())
    }

    /// Waits until the profiles of the axes have ended (6.5), behind ssms also their spoolers.
    pub(super) fn await_end(&mut self, spooler: bool, axes: AxisSet, mcu: &Mcu) -> Result<(), Pause> {
        let ended = |a: usize| {
            let axis = &mcu.axes[a];
            let drained = !spooler || (axis.is_drained() && axis.spooler.state == SpoolState::Direct);
            drained && axis.pending == 0 && axis.doing == Doing::Nothing && mcu.axst(a).has(Axst::pe)
        };
        if axes.iter().all(ended) { Ok(()) } else { self.wait_here() }
    }

    fn task(&mut self, command: TaskCommand, number: usize, mcu: &mut Mcu) -> Result<(), Pause> {
        let own = number == self.number;
        match command {
            TaskCommand::Startcnct if own => return Err(Pause::Restart),
            TaskCommand::Stopcnct if own => return Err(Pause::Stop),
            _ if own => {} // a running task is neither stopped nor stepping
            TaskCommand::Startcnct => mcu.tasks[number].start(),
            TaskCommand::Stopcnct => mcu.stopcnct(number),
            TaskCommand::Contcnct => mcu.contcnct(number),
            TaskCommand::Stepcnct => mcu.stepcnct(number),
            TaskCommand::Stoptoss => mcu.stoptoss(number),
        }
        Ok(())
    }

    /// The text of a value (errata Q8): the shortest that reads back to the same value.
    fn write_value(&self, kind: Type, from: Slot, output: &mut Output) {
        use std::fmt::Write;
        // writing to an output cannot fail
        let _ = match kind {
            Type::Boolean => output.write_str(if self.get(from) != 0 { "TRUE" } else { "FALSE" }),
            Type::Integer => write!(output, "{}", self.int(from)),
            Type::Timer => write!(output, "{}", self.get(from) as u32),
            Type::Single => write!(output, "{:?}", self.real(from) as f32),
            Type::Double => write!(output, "{:?}", self.real(from)),
        };
    }
}
