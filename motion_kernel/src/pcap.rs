//! Commands of the application (chapter 4.4), under the manual's names. They act between samples.

use crate::axes::AxisSet;
use crate::axis::{Doing, Override};
use crate::limits::{LIMIT_STATES, Limiting};
use crate::machine::DriveKind;
use crate::mcu::{Mcu, WAIT_CI};
use crate::registers::{Axst, ModeReg};
use crate::spooler::{Entry, NONE, SpoolState};

impl Mcu {
    /// Starts the spoolers of these axes in the next sample (ssms): those in direct mode, stopped (sstps) or
    /// halted (ssf 1000); waits 1003 and 1004 end early.
    pub fn ssms(&mut self, axes: AxisSet) {
        for a in self.known(axes).iter() {
            let axis = &mut self.axes[a];
            match axis.spooler.state {
                SpoolState::Direct if axis.spooler.is_empty() => {}
                SpoolState::Direct | SpoolState::Stopped | SpoolState::Halted => {
                    axis.spooler.state = SpoolState::Running;
                    axis.function = None;
                }
                SpoolState::Running | SpoolState::Held => {}
            }
            if let Doing::Wait(crate::axis::Wait::Samples(_) | crate::axis::Wait::Inputs(_)) = axis.doing {
                (axis.doing, axis.function) = (Doing::Nothing, None);
            }
        }
    }

    /// As [`Mcu::ssms`], but only those in direct mode (design D23): what tasks and a full spooler may start.
    pub fn start_direct(&mut self, axes: AxisSet) {
        for a in self.known(axes).iter() {
            if self.axes[a].spooler.state == SpoolState::Direct {
                self.ssms(AxisSet::single(a));
            }
        }
    }

    /// Stops handing over entries after the current command; they stay (sstps).
    pub fn sstps(&mut self, axes: AxisSet) {
        for a in self.known(axes).iter() {
            let spooler = &mut self.axes[a].spooler;
            if matches!(spooler.state, SpoolState::Running | SpoolState::Direct) {
                spooler.state = SpoolState::Stopped;
            }
        }
    }

    /// Discards all entries; the current command is completed (sdels).
    pub fn sdels(&mut self, axes: AxisSet) {
        for a in self.known(axes).iter() {
            while let Some(entry) = self.axes[a].spooler.pop_back() {
                if let Entry::Move { slot, .. } = entry {
                    self.let_go(slot);
                }
            }
            let axis = &mut self.axes[a];
            let executing = if let Doing::Move(slot) = axis.doing { slot } else { NONE };
            let target = if executing == NONE { axis.dp } else { axis.component.target };
            (axis.queue_end, axis.queue_last) = (target, executing);
            axis.queue_tvl = if executing == NONE { 0.0 } else { self.moves[executing].tvl };
        }
    }

    /// Axes stop, each on its own, with their stop deceleration sdec (js); their spoolers are discarded.
    pub fn js(&mut self, axes: AxisSet) {
        let shaped = self.registers.modereg.has(ModeReg::SProfile);
        self.drop_pending(axes);
        for a in self.known(axes).iter() {
            let axis = &self.axes[a];
            let sdec = if axis.parameters.sdec > 0.0 { axis.parameters.sdec } else { f64::INFINITY };
            let jerkrel = if shaped { axis.parameters.jerkrel } else { 0.0 };
            self.brake_alone(a, sdec, jerkrel);
        }
    }

    /// As [`Mcu::js`], but by a limit or by JSatSAF: until the axes stand, interpolations are not spooled for them
    /// (ErrorReg bit 11, SpoolerLoadError).
    pub(crate) fn stop_by_system(&mut self, axes: AxisSet) {
        self.js(axes);
        for a in axes.iter() {
            self.axes[a].braked_by_system = self.axes[a].doing == Doing::Alone;
        }
    }

    /// The axis leaves what it executes where it is; its spooler is empty and in direct mode.
    pub(crate) fn enter_direct_mode(&mut self, a: usize) {
        self.sdels(AxisSet::single(a));
        if let Doing::Move(slot) = self.axes[a].doing {
            self.tell_cut(slot);
            self.let_go(slot);
        }
        let axis = &mut self.axes[a];
        (axis.doing, axis.function, axis.dv, axis.plan_v) = (Doing::Nothing, None, 0.0, 0.0);
        (axis.run_on_v, axis.path_v, axis.short_moves, axis.last_axes) = (0.0, 0.0, 0, AxisSet::EMPTY);
        axis.braked_by_system = false;
        axis.spooler.drop_points();
        axis.spooler.state = SpoolState::Direct;
        axis.forget_queue();
    }

    /// Closes the loops: the actual position becomes the set point, spoolers are discarded (cl, 4.4.8).
    pub fn cl(&mut self, axes: AxisSet) {
        self.drop_pending(axes);
        self.enable_amplifiers();
        for a in self.known(axes).iter() {
            self.enter_direct_mode(a);
            let axis = &mut self.axes[a];
            axis.dp = self.loops[a].rp() - self.loops[a].offset;
            axis.component.target = axis.dp;
            axis.limiting = Limiting::default();
            axis.forget_queue();
            self.loops[a].close(0.0);
            self.set_status(a, Axst::saf | Axst::mpe | LIMIT_STATES, false);
            self.forget_reference(a);
            self.axes[a].status.set(Axst::cl);
        }
    }

    /// Opens the loops (ol).
    pub fn ol(&mut self, axes: AxisSet) {
        self.drop_pending(axes);
        for a in self.known(axes).iter() {
            self.enter_direct_mode(a);
            self.release_gear(a);
            self.loops[a].open();
            self.axes[a].status.clear(Axst::cl);
            self.forget_reference(a);
        }
        self.disable_amplifiers(self.known(axes));
    }
    /// A stepper axis is no longer referenced as its loop is opened or closed (4.4.45).
    fn forget_reference(&mut self, a: usize) {
        if self.machine.axes[a].drive == DriveKind::Stepper {
            self.set_status(a, Axst::referenced, false);
        }
    }

    /// Resets the system (rs): loops open, spoolers discarded, tasks stopped, overrides 1.0. Common variables,
    /// ErrorReg and MODEREG stay.
    pub fn rs(&mut self) {
        let all = self.all_axes();
        for task in 0..self.tasks.len() {
            self.stopcnct(task);
        }
        self.ol(all);
        self.holding = false;
        self.registers.trovr = 1.0;
        for a in all.iter() {
            let axis = &mut self.axes[a];
            (axis.trajectory, axis.parameters.jovr) = (Override::default(), 1.0);
            self.set_status(a, Axst::saf | Axst::mpe | Axst::dhef | Axst::referenced, false);
        }
        self.reset_outputs();
        self.check_configuration();
        self.set_up_endat();
    }

    /// Marks axes as referenced at their present position (shp; coordinates stay).
    pub fn set_referenced(&mut self, axes: AxisSet) {
        for a in self.known(axes).iter() {
            self.axes[a].status.set(Axst::referenced);
        }
    }

    /// Buffers the trajectory override (wrtrovr); effective after [`Mcu::utrovr`]. False: not above 0.
    pub fn wrtrovr(&mut self, factor: f64) -> bool {
        let ok = factor > 0.0 && factor.is_finite();
        if ok {
            self.registers.trovr = factor;
        }
        ok
    }
    /// The time in s that a change of the override by 1.0 takes (wrtrovrst); 0 and less than a sample: at once.
    pub fn wrtrovrst(&mut self, seconds: f64) {
        self.registers.trovrst = if seconds >= 0.0 && seconds.is_finite() { seconds } else { 0.0 };
    }
    /// Takes the buffered override over for these axes from the next sample on (utrovr).
    pub fn utrovr(&mut self, axes: AxisSet) {
        let step = if self.registers.trovrst < self.ta { 0.0 } else { self.ta / self.registers.trovrst };
        let copies = !self.registers.modereg.has(ModeReg::OvrMode);
        for a in self.known(axes).iter() {
            let axis = &mut self.axes[a];
            axis.trajectory.take(self.registers.trovr, step);
            axis.jovr_follows |= copies;
        }
    }
    /// The jog override of an axis (wrjovr): at once, without ramp. During an interpolation it breaks the path.
    pub fn wrjovr(&mut self, axis: usize, factor: f64) -> bool {
        if !(factor > 0.0 && factor.is_finite()) {
            return false;
        }
        let copies = !self.registers.modereg.has(ModeReg::OvrMode);
        let axis = &mut self.axes[axis];
        (axis.parameters.jovr, axis.jovr_follows) = (factor, false);
        if copies {
            axis.trajectory.take(factor, 0.0);
        }
        true
    }
    /// The jog override; without OvrMode it shows the effective override while that ramps (4.4.175).
    pub fn rdjovr(&self, axis: usize) -> f64 {
        self.axes[axis].jog_override()
    }

    /// CI99 := 0 in step with the system: axes waiting for it go on in the same sample (4.4.7).
    #[allow(non_snake_case)] // the manual's own name
    pub fn ClearCI99(&mut self) {
        self.ci[WAIT_CI] = 0;
    }
}
