//! One CNC task: executes autocode, at most 20 statements per sample (design D4).

use crate::autocode::{BinaryOp, Instr, Program};
use crate::axes::AxisSet;
use crate::functions::Entered;
use crate::mcu::Mcu;
use crate::motion::MotionCommand;
use crate::registers::{Axst, ModeReg};
use crate::sap::processor::Processor;
use crate::spooler::{BYTES_FUNCTION, SpoolState};
use crate::tasks::{Output, Segments};
use std::sync::Arc;

/// Runtime errors (6.8, table 40; ours from 1000 on).
pub mod runtime_error {
    pub const BAD_CODE: u32 = 4;
    pub const STACK_OVERFLOW: u32 = 8;
    pub const STACK_UNDERFLOW: u32 = 16;
    pub const BAD_COMMAND: u32 = 64;
    pub const BAD_ADDRESS: u32 = 128;
    pub const BAD_ARGUMENT: u32 = 256;
    pub const COMMON_RANGE: u32 = 1024;
    pub const BUFFER_ALIGNMENT: u32 = 2048;
    pub const BAD_PARAMETER: u32 = 32768;
    /// A motion command for an axis in open loop (design D11).
    pub const OPEN_LOOP: u32 = 1000;

    pub const fn text(number: u32) -> &'static str {
        match number {
            BAD_CODE => "invalid operation code",
            STACK_OVERFLOW => "stack overflow",
            STACK_UNDERFLOW => "stack underflow",
            BAD_COMMAND => "invalid NC command",
            BAD_ARGUMENT => "address violation by a wrong parameter",
            BUFFER_ALIGNMENT => "Double access to the common buffer with an offset not divisible by 8",
            BAD_ADDRESS => "address outside the program",
            COMMON_RANGE => "common variable outside its range",
            BAD_PARAMETER => "invalid parameter of an arithmetic operation",
            OPEN_LOOP => "motion command for an axis in open loop",
            _ => "unknown error",
        }
    }
}

/// Values and return addresses that a task can hold, and the local slots it has.
const STACK: usize = 256;
const LOCALS: usize = 256;

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TaskState {
    /// Nothing loaded, or loaded and not started, or at the end of the program.
    #[default]
    Idle,
    Running,
    /// By stopcnct; can be continued.
    Stopped,
    /// One line is done in single-step mode.
    Stepped,
    /// By a runtime error or an abort; only startcnct helps.
    Failed,
}

/// A runtime error and the source line that caused it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RuntimeError {
    pub number: u32,
    pub line: u32,
}

/// CNCTS of chapter 4.3.2.10.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TaskStatus {
    /// Error number, 0 = none, and its source line.
    pub errnum: u32,
    pub errline: u32,
    /// Bit 0 executing, bit 1 waits for step or continue, bit 2 halted at writeln, bit 3 waits (wt, end of profile).
    pub running: u32,
    /// Free bytes of the stack.
    pub stackfree: u32,
    /// Source line being executed.
    pub csrcline: u32,
    pub state: TaskState,
}

/// Whether the task goes on in this sample.
enum Flow {
    Next,
    /// The instruction is tried again in the next sample.
    Again,
    /// Go on at this address.
    Jump(usize),
}

/// Registers of one task.
#[derive(Debug, Default)]
pub struct Task {
    program: Option<Arc<Program>>,
    /// Where the segments behind `program` come from.
    pub(super) segments: Option<Segments>,
    /// Registers of a rw_SymPas program; where it is there, `program` is not.
    pub(super) sap: Option<Box<Processor>>,
    pub(super) state: TaskState,
    pub(super) pc: usize,
    stack: Vec<f64>,
    calls: Vec<u32>,
    locals: Vec<f64>,
    /// Samples left of a `Wait`; None = not begun.
    wait: Option<u32>,
    /// Stopped by its own writeln (StopAtWriteln) until the application continues it.
    pub(super) rests: bool,
    /// Waits for time or the end of motion.
    pub(super) waiting: bool,
    stepping: bool,
    /// In single-step mode: the line being executed.
    step_line: Option<u32>,
    pub(super) error: Option<RuntimeError>,
    told: bool,
    pub(crate) output: Output,
}

impl Task {
    pub fn load(&mut self, program: Arc<Program>) {
        *self = Task {
            program: Some(program),
            stack: Vec::with_capacity(STACK),
            calls: Vec::with_capacity(STACK),
            locals: vec![0.0; LOCALS],
            output: Output::reserved(),
            ..Task::default()
        };
    }
    pub fn start(&mut self) {
        if let Some(program) = self.program.take() {
            let segments = self.segments.take();
            let gone = segments.as_ref().is_some_and(Segments::has_begun);
            self.load(program);
            (self.state, self.segments) = (TaskState::Running, segments);
            if gone {
                let error = RuntimeError { number: runtime_error::BAD_ADDRESS, line: self.line() };
                (self.state, self.error) = (TaskState::Failed, Some(error));
            }
        } else if let Some(sap) = &mut self.sap {
            sap.restart();
            (self.state, self.error, self.told) = (TaskState::Running, None, false);
        }
    }
    pub fn stop(&mut self) {
        if self.state == TaskState::Running {
            self.state = TaskState::Stopped;
            self.disable_events();
        }
    }
    pub fn abort(&mut self) {
        if self.is_alive() {
            self.state = TaskState::Failed;
        }
    }
    pub fn resume(&mut self) {
        self.rests = false;
        self.stepping = false;
        if let Some(sap) = &mut self.sap {
            sap.run_on();
        }
        if self.is_alive() {
            self.state = TaskState::Running;
        }
    }
    pub fn step(&mut self) {
        match self.state {
            TaskState::Idle | TaskState::Failed => self.start(),
            _ => {}
        }
        if let Some(sap) = &mut self.sap {
            sap.step(false);
            self.state = TaskState::Running;
        } else if self.program.is_some() {
            (self.state, self.stepping, self.step_line) = (TaskState::Running, true, None);
        }
    }
    /// Executes in each sample.
    pub fn is_active(&self) -> bool {
        self.state == TaskState::Running
    }
    /// Started and not at its end: running, stopped or stepping.
    pub fn is_alive(&self) -> bool {
        matches!(self.state, TaskState::Running | TaskState::Stopped | TaskState::Stepped)
    }
    /// Stopped by its own writeln.
    pub fn rests(&self) -> bool {
        self.rests && self.state == TaskState::Stopped
    }
    pub fn has_failed(&self) -> bool {
        self.error.is_some()
    }
    pub fn program(&self) -> Option<&Arc<Program>> {
        self.program.as_ref()
    }
    /// An error that nobody was told of, with its place (of a part program: its line).
    pub(crate) fn new_error(&mut self) -> Option<RuntimeError> {
        let error = self.error.filter(|_| !self.told)?;
        self.told = true;
        Some(RuntimeError { line: self.place(), ..error })
    }
    pub fn status(&self) -> TaskStatus {
        let running = u32::from(self.state == TaskState::Running)
            | u32::from(self.state == TaskState::Stepped) << 1
            | u32::from(self.rests()) << 2
            | u32::from(self.waiting && self.state == TaskState::Running) << 3;
        TaskStatus {
            errnum: self.error.map_or(0, |e| e.number),
            errline: self.error.map_or(0, |e| e.line),
            running,
            stackfree: self.sap.as_ref().map_or(((STACK - self.stack.len()) * 8) as u32, |sap| sap.stack_free()),
            csrcline: self.line(),
            state: self.state,
        }
    }
    pub(super) fn line(&self) -> u32 {
        if let Some(sap) = &self.sap {
            return sap.line();
        }
        self.program.as_ref().and_then(|p| p.lines.get(self.pc).copied()).unwrap_or(0)
    }

    /// The task's share of one sample.
    pub(crate) fn run(&mut self, mcu: &mut Mcu) {
        if self.sap.is_some() {
            return self.run_sap(mcu);
        }
        let Some(mut program) = self.program.take() else { return };
        let share = mcu.machine.controller.statements_per_sample.max(1);
        let mut statements = 0;
        self.waiting = false;
        while statements < share && self.state == TaskState::Running {
            let Some(&instr) = program.code.get(self.pc) else {
                self.fail(runtime_error::BAD_ADDRESS, &program);
                break;
            };
            if self.line_is_done(&program, mcu) {
                break;
            }
            match self.execute(instr, &program, mcu) {
                Ok(Flow::Next) => {
                    self.pc += 1;
                    if self.pc == program.code.len() {
                        self.next_segment(&mut program);
                    }
                }
                Ok(Flow::Jump(to)) => self.pc = to,
                Ok(Flow::Again) => break,
                Err(number) => self.fail(number, &program),
            }
            statements += u32::from(instr.is_statement());
        }
        self.program = Some(program);
    }

    /// Single step: waits for the motion of the line before, stops before the first instruction of another line,
    /// and starts what was spooled. True when nothing is to be executed now.
    fn line_is_done(&mut self, program: &Program, mcu: &mut Mcu) -> bool {
        if !self.stepping {
            return false;
        }
        let line = program.lines[self.pc];
        if self.step_line.is_none() && !mcu.known(program.group).iter().all(|a| mcu.axes[a].is_drained()) {
            self.waiting = true;
            return true;
        }
        if *self.step_line.get_or_insert(line) == line {
            return false;
        }
        mcu.start_direct(program.group);
        self.state = TaskState::Stepped;
        true
    }

    fn fail(&mut self, number: u32, program: &Program) {
        let line = program.lines.get(self.pc).or(program.lines.last()).copied().unwrap_or(0);
        (self.state, self.error) = (TaskState::Failed, Some(RuntimeError { number, line }));
    }

    fn execute(&mut self, instr: Instr, program: &Program, mcu: &mut Mcu) -> Result<Flow, u32> {
        match instr {
            Instr::Spool(n) => return self.spool(n, program, mcu),
            Instr::Ssf(n) => return self.ssf(n, program, mcu),
            Instr::Ssms(axes) => mcu.start_direct(axes),
            Instr::Drain(axes) => return Ok(self.drain(axes, mcu)),
            Instr::InPosition(axes) => {
                let there = |a: usize| a >= mcu.axes.len() || mcu.axst(a).has(Axst::ip);
                if !axes.iter().all(there) {
                    self.waiting = true;
                    return Ok(Flow::Again);
                }
            }
            Instr::Wait(samples) => return Ok(self.wait(samples)),
            Instr::Number(n) => self.push(*program.numbers.get(n as usize).ok_or(runtime_error::BAD_ADDRESS)?)?,
            Instr::LoadCi(n) => {
                self.push(f64::from(*mcu.ci.get(usize::from(n)).ok_or(runtime_error::COMMON_RANGE)?))?
            }
            Instr::LoadCd(n) => self.push(*mcu.cd.get(usize::from(n)).ok_or(runtime_error::COMMON_RANGE)?)?,
            Instr::StoreCi(n) => {
                let value = crate::functions::to_int(self.pop()?);
                *mcu.ci.get_mut(usize::from(n)).ok_or(runtime_error::COMMON_RANGE)? = value;
            }
            Instr::StoreCd(n) => {
                *mcu.cd.get_mut(usize::from(n)).ok_or(runtime_error::COMMON_RANGE)? = self.pop()?;
            }
            Instr::EffRadius(axis) => {
                if !mcu.change_radius(usize::from(axis), self.pop()?) {
                    return Err(runtime_error::BAD_PARAMETER);
                }
            }
            Instr::LoadLocal(n) => self.push(*self.locals.get(usize::from(n)).ok_or(runtime_error::BAD_ADDRESS)?)?,
            Instr::StoreLocal(n) => {
                let value = self.pop()?;
                *self.locals.get_mut(usize::from(n)).ok_or(runtime_error::BAD_ADDRESS)? = value;
            }
            Instr::Halt => {
                mcu.start_direct(program.group);
                self.state = TaskState::Idle;
                return Ok(Flow::Again);
            }
            Instr::Jump(_) | Instr::JumpIfZero(_) | Instr::Call(_) | Instr::Return => return self.jump(instr, program),
            Instr::WriteText(n) => {
                let text = program.texts.get(n as usize).ok_or(runtime_error::BAD_ADDRESS)?;
                self.output.append(text);
            }
            Instr::WriteValue => self.write_value()?,
            Instr::Writeln => {
                self.output.close();
                if mcu.modereg().has(ModeReg::StopAtWriteln) {
                    (self.state, self.rests, mcu.waiting) = (TaskState::Stopped, true, true);
                }
            }
            Instr::Binary(_) | Instr::Negate | Instr::Not => self.calculate(instr)?,
        }
        Ok(Flow::Next)
    }

    /// Spools a motion command; a full spooler starts by itself, and the task waits for room.
    fn spool(&mut self, n: u32, program: &Program, mcu: &mut Mcu) -> Result<Flow, u32> {
        let mv = program.moves.get(n as usize).ok_or(runtime_error::BAD_ADDRESS)?;
        let axes = program.axes_of(mv);
        if !mcu.has_room(mv.kind, axes) {
            mcu.start_direct(axes.set());
            self.waiting = true;
            return Ok(Flow::Again);
        }
        let command = MotionCommand {
            kind: mv.kind,
            axes,
            targets: program.targets_of(mv),
            center: mv.center,
            phi: mv.phi,
            vl: mv.vl,
            ac: mv.ac,
            // a single step ends with standstill
            tvl: if self.stepping { 0.0 } else { mv.tvl },
            rapid: mv.rapid,
            line: program.lines[self.pc],
        };
        if mcu.spool(&command) == Entered::Refused {
            return Err(runtime_error::OPEN_LOOP);
        }
        self.start_when_filled(program, mcu);
        Ok(Flow::Next)
    }

    /// Enough commands wait: the group starts (din66025.md 17).
    fn start_when_filled(&self, program: &Program, mcu: &mut Mcu) {
        let filled = |a: usize| {
            let spooler = &mcu.axes[a].spooler;
            spooler.state == SpoolState::Direct && spooler.moves() >= program.start_fill
        };
        if program.start_fill > 0 && program.group.iter().any(filled) {
            mcu.start_direct(program.group);
        }
    }

    fn ssf(&mut self, n: u32, program: &Program, mcu: &mut Mcu) -> Result<Flow, u32> {
        let ssf = program.ssfs.get(n as usize).ok_or(runtime_error::BAD_ADDRESS)?;
        if ssf.axes.iter().any(|a| a < mcu.axes.len() && mcu.axes[a].spooler.left() < BYTES_FUNCTION) {
            mcu.start_direct(program.group.union(ssf.axes));
            self.waiting = true;
            return Ok(Flow::Again);
        }
        for axis in ssf.axes.iter() {
            if mcu.ssf(axis, ssf.command, ssf.value, program.lines[self.pc]) == Entered::Refused {
                return Err(runtime_error::OPEN_LOOP);
            }
        }
        Ok(Flow::Next)
    }

    fn drain(&mut self, axes: AxisSet, mcu: &mut Mcu) -> Flow {
        mcu.start_direct(axes);
        let at_rest = |a: usize| mcu.axes[a].is_drained() && mcu.axes[a].spooler.state == SpoolState::Direct;
        if axes.iter().filter(|&a| a < mcu.axes.len()).all(at_rest) {
            return Flow::Next;
        }
        self.waiting = true;
        Flow::Again
    }

    fn wait(&mut self, samples: u32) -> Flow {
        let left = self.wait.unwrap_or(samples);
        if left == 0 {
            self.wait = None;
            return Flow::Next;
        }
        (self.wait, self.waiting) = (Some(left - 1), true);
        Flow::Again
    }

    fn jump(&mut self, instr: Instr, program: &Program) -> Result<Flow, u32> {
        let next = self.pc as u32 + 1;
        let target = match instr {
            Instr::Jump(to) => to,
            Instr::JumpIfZero(to) => {
                if self.pop()? == 0.0 {
                    to
                } else {
                    next
                }
            }
            Instr::Call(to) => {
                if self.calls.len() == STACK {
                    return Err(runtime_error::STACK_OVERFLOW);
                }
                self.calls.push(next);
                to
            }
            _ => self.calls.pop().ok_or(runtime_error::STACK_UNDERFLOW)?,
        };
        if target as usize >= program.code.len() {
            return Err(runtime_error::BAD_ADDRESS);
        }
        Ok(Flow::Jump(target as usize))
    }

    fn calculate(&mut self, instr: Instr) -> Result<(), u32> {
        let y = self.pop()?;
        let value = match instr {
            Instr::Negate => -y,
            Instr::Not => truth(y == 0.0),
            Instr::Binary(op) => binary(op, self.pop()?, y)?,
            _ => unreachable!("not arithmetic"),
        };
        self.push(value)
    }

    fn push(&mut self, value: f64) -> Result<(), u32> {
        if self.stack.len() == STACK {
            return Err(runtime_error::STACK_OVERFLOW);
        }
        self.stack.push(value);
        Ok(())
    }
    fn pop(&mut self) -> Result<f64, u32> {
        self.stack.pop().ok_or(runtime_error::STACK_UNDERFLOW)
    }
    fn write_value(&mut self) -> Result<(), u32> {
        use std::fmt::Write;
        let value = self.pop()?;
        let _ = write!(self.output, "{value}"); // cannot fail
        Ok(())
    }
}

fn truth(condition: bool) -> f64 {
    f64::from(u8::from(condition))
}

fn binary(op: BinaryOp, x: f64, y: f64) -> Result<f64, u32> {
    let bits = |f: fn(i32, i32) -> i32| f64::from(f(crate::functions::to_int(x), crate::functions::to_int(y)));
    Ok(match op {
        BinaryOp::Add => x + y,
        BinaryOp::Sub => x - y,
        BinaryOp::Mul => x * y,
        BinaryOp::Div | BinaryOp::Mod if y == 0.0 => return Err(runtime_error::BAD_PARAMETER),
        BinaryOp::Div => x / y,
        BinaryOp::Mod => x % y,
        BinaryOp::Eq => truth(x == y),
        BinaryOp::Ne => truth(x != y),
        BinaryOp::Lt => truth(x < y),
        BinaryOp::Le => truth(x <= y),
        BinaryOp::Gt => truth(x > y),
        BinaryOp::Ge => truth(x >= y),
        BinaryOp::And => bits(|a, b| a & b),
        BinaryOp::Or => bits(|a, b| a | b),
        BinaryOp::Xor => bits(|a, b| a ^ b),
    })
}
