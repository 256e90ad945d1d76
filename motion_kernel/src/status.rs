//! What the application sees of the controller between samples, and what it does at the start of a job.

use crate::axes::AxisSet;
use crate::axis::{Doing, Wait};
use crate::mcu::Mcu;
use crate::registers::{Axst, ErrorReg, ModeReg};
use crate::spooler::{Entry, SpoolState};

/// A snapshot of one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisSnapshot {
    pub axst: Axst,
    /// Set point, encoder position and load side, axis units.
    pub dp: f64,
    pub rp: f64,
    pub load: f64,
    /// Velocity of the set point.
    pub dv: f64,
    /// End point of the motion command being executed (the set point where there is none).
    pub target: f64,
    /// Motion commands waiting in the spooler, free and all memory of it in bytes.
    pub mcis: u32,
    pub lsm: u32,
    pub memory: u32,
    pub jovr: f64,
    pub spool_state: SpoolState,
    /// Outputs.
    pub digo: u32,
}

/// A snapshot of the whole controller.
#[derive(Clone, Debug, PartialEq)]
pub struct Snapshot {
    pub sample: u64,
    pub axes: Vec<AxisSnapshot>,
    /// Number and source line of the motion command of the first group axis, or of what it executes next where
    /// its spooler stands; 0 = none.
    pub entry: u32,
    pub line: u32,
    /// Length of that command and how much of it is done, mm.
    pub length: f64,
    pub done: f64,
    pub rapid: bool,
    /// Path velocity now, and as programmed, mm/s.
    pub path_v: f64,
    pub programmed_v: f64,
    pub factor: f64,
    pub trovr: f64,
    pub errorreg: ErrorReg,
    pub holding: bool,
    /// All axes stand.
    pub stands: bool,
    /// The spooled command that waits for the application, if any.
    pub waits: Option<u16>,
    /// Ends by itself: what an axis waits for.
    pub wait: Option<Wait>,
}

impl Mcu {
    /// Everything a screen shows.
    pub fn status(&self) -> Snapshot {
        let leader = &self.axes[self.leader];
        let mv = self.current_move(self.leader);
        let (entry, line, done) =
            mv.map_or_else(|| self.standing_before(self.leader), |mv| (mv.number, mv.line, mv.profile.at(leader.t).0));
        Snapshot {
            sample: self.sample,
            axes: (0..self.axes.len()).map(|a| self.axis_snapshot(a)).collect(),
            entry,
            line,
            length: mv.map_or(0.0, |mv| mv.length),
            done,
            rapid: mv.is_some_and(|mv| mv.rapid),
            path_v: leader.plan_v * leader.trajectory.factor,
            programmed_v: mv.map_or(0.0, |mv| mv.programmed_v),
            factor: leader.trajectory.factor,
            trovr: self.registers.trovr,
            errorreg: self.registers.errorreg,
            holding: self.holding,
            stands: self.stands(),
            waits: self.wait_for_application(),
            wait: self.axes.iter().find_map(|a| if let Doing::Wait(wait) = a.doing { Some(wait) } else { None }),
        }
    }

    /// Number and line of the wait that an axis is in, or of what comes next where its spooler stands, and how much
    /// of that was done before a hold cut it.
    fn standing_before(&self, a: usize) -> (u32, u32, f64) {
        let axis = &self.axes[a];
        if let Some(function) = axis.function {
            return (0, function.line, 0.0);
        }
        match axis.spooler.entries().front() {
            Some(Entry::Move { slot, .. }) if axis.spooler.state == SpoolState::Held => {
                (self.moves[*slot].number, self.moves[*slot].line, self.moves[*slot].from)
            }
            Some(Entry::Function(function)) if axis.spooler.state == SpoolState::Held => (0, function.line, 0.0),
            _ => (0, 0, 0.0),
        }
    }

    /// Where the present block of an axis ends, also while a hold stands in it; else where the axis is.
    fn target_of(&self, a: usize) -> f64 {
        let axis = &self.axes[a];
        match axis.spooler.entries().front() {
            _ if axis.travels() => axis.component.target,
            Some(Entry::Move { component, .. }) if axis.spooler.state == SpoolState::Held => component.target,
            _ => axis.dp,
        }
    }

    fn axis_snapshot(&self, a: usize) -> AxisSnapshot {
        let axis = &self.axes[a];
        AxisSnapshot {
            axst: axis.status,
            dp: axis.set_point(),
            rp: self.loops[a].rp(),
            load: self.loops[a].load(),
            dv: axis.dv,
            target: self.target_of(a),
            mcis: axis.spooler.moves(),
            lsm: axis.spooler.left(),
            memory: self.machine.controller.spool_memory_bytes,
            jovr: self.rdjovr(a),
            spool_state: axis.spooler.state,
            digo: self.rddigo(),
        }
    }

    /// A G-code run begins (design D19): MODEREG and TROVRST of the machine file, axes at the start position,
    /// in closed loop and referenced; [`Mcu::advance`] waits at the end until they are in position.
    pub fn prepare_gcode(&mut self) {
        let all = self.all_axes();
        self.registers.modereg = ModeReg(self.machine.gcode.modereg);
        self.registers.units = crate::units::TrajectoryUnits::default(); // part programs are in mm and s
        self.wrtrovrst(self.machine.gcode.trovrst_s);
        // the drive of a spindle by motor command stays in open loop
        let spindle = self.machine.gcode.spindle.command.map(|c| c.0);
        self.cl(all.iter().filter(|a| Some(*a) != spindle).collect());
        self.registers.nfrax = self.machine.gcode.nfrax.iter().copied().collect();
        self.set_referenced(all);
        self.settle = true;
        self.stop_at = self.machine.controller.stop_at;
    }

    /// What the application does at a fault: tasks stop and all axes with them, in their loops as far as there is power.
    pub fn stop_job(&mut self) {
        (0..self.tasks.len()).for_each(|task| self.stopcnct(task));
        (self.holding, self.block_hold) = (false, false);
        let all = self.all_axes();
        let dead = |a: usize| self.axes[a].status.any(Axst::eo | Axst::dnr);
        let without_power: AxisSet = (0..self.axes.len()).filter(|&a| dead(a)).collect();
        self.js(all.without(without_power));
        self.ol(without_power);
    }

    /// The application has done what the spooler waits for: halted spoolers (ssf 1000) go on, CI99 becomes 0.
    pub fn acknowledge(&mut self) {
        let halted = (0..self.axes.len()).filter(|&a| self.axes[a].spooler.state == SpoolState::Halted);
        let halted: AxisSet = halted.collect();
        self.ssms(halted);
        self.ClearCI99();
        self.tasks.iter_mut().filter(|t| t.rests()).for_each(|t| t.resume());
    }

    /// Moves that any spooler or axis still holds.
    pub fn moves_in_use(&self) -> usize {
        self.moves.live()
    }
    /// How many moves look-ahead has looked at since boot: a measure of its work.
    pub fn planning_steps(&self) -> u64 {
        self.lookahead.steps()
    }
    pub fn modereg(&self) -> ModeReg {
        self.registers.modereg
    }
    pub fn set_modereg(&mut self, modereg: ModeReg) {
        self.registers.modereg = modereg;
        let simulated = modereg.has(ModeReg::SimulationMode);
        self.loops.iter_mut().for_each(|position_loop| position_loop.simulate(simulated));
        if modereg.has(ModeReg::ClearZeroPosition) {
            self.clear_zero_offsets();
        }
    }
    pub fn errorreg(&self) -> ErrorReg {
        self.registers.errorreg
    }
    /// Writing 0 is the only way to clear bits (6.3.1.3).
    pub fn clear_errorreg(&mut self) {
        self.registers.errorreg = ErrorReg(0);
    }
    pub fn axst(&self, axis: usize) -> Axst {
        self.axes[axis].status
    }
    /// Common integers and doubles.
    pub fn ci(&self, number: usize) -> i32 {
        self.ci[number]
    }
    pub fn set_ci(&mut self, number: usize, value: i32) {
        self.ci[number] = value;
    }
    pub fn cd(&self, number: usize) -> f64 {
        self.cd[number]
    }
    pub fn set_cd(&mut self, number: usize, value: f64) {
        self.cd[number] = value;
    }
    /// Axis qualifiers, in PU and TU: rdMDVel, rdMaxVel, ... and their writers.
    pub fn parameters(&self, axis: usize) -> &crate::axis::Parameters {
        &self.axes[axis].parameters
    }
    pub fn parameters_mut(&mut self, axis: usize) -> &mut crate::axis::Parameters {
        &mut self.axes[axis].parameters
    }
    /// Controller registers without a method of their own (TRAC, NFRAX, LookAheadDepth).
    pub fn registers_mut(&mut self) -> &mut crate::mcu::Registers {
        &mut self.registers
    }
}
