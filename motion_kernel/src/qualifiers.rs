//! Reading and writing the values of one axis (chapter 4.4, rd... and wr...), in its own units: mm or degrees, s.
//!
//! Axes are indices of the machine. What is not a number is refused (`false`), and the value before it stays.
#![allow(non_snake_case)] // the manual's own names

use crate::axes::AxisSet;
use crate::axis::Override;
use crate::limits::Limiting;
use crate::machine::{LimitFunction, PidfGains, SoftwareLimits};
use crate::mcu::Mcu;
use crate::named::{UNLIMITED, put};
use crate::plant::ServoPlant;
use crate::registers::{Axst, ControllerFlags};

impl Mcu {
    /// Actual position (4.4.95).
    pub fn rdrp(&self, axis: usize) -> f64 {
        self.loops[axis].rp()
    }
    /// Actual velocity (4.4.97), also in open loop.
    pub fn rdrv(&self, axis: usize) -> f64 {
        self.loops[axis].rv()
    }
    /// Desired position, as the position loop sees it (4.4.56).
    pub fn rddp(&self, axis: usize) -> f64 {
        self.axes[axis].set_point()
    }
    /// Desired velocity of the profile generator (4.4.59).
    pub fn rddv(&self, axis: usize) -> f64 {
        self.axes[axis].dv
    }
    /// Following error dp - rp (4.4.93), with dpoffset: what the loop sees.
    pub fn rdPosErr(&self, axis: usize) -> f64 {
        self.loops[axis].error(self.rddp(axis))
    }
    /// Axis status word (4.4.45).
    pub fn rdaxst(&self, axis: usize) -> Axst {
        self.axst(axis)
    }
    /// One bit of the status word (4.4.46). `bitnr` counts from 1: pe is 13.
    pub fn rdaxstb(&self, axis: usize, bitnr: u32) -> i32 {
        let bit = (1..=32).contains(&bitnr).then(|| self.axst(axis).0 >> (bitnr - 1) & 1);
        bit.unwrap_or(0) as i32
    }
    /// Sample time in microseconds; success is 1 (4.4.98).
    pub fn rdSampleTime(&self) -> (i32, i32) {
        (1, self.machine.controller.sample_ticks as i32 * 64)
    }

    /// Desired position without a profile (4.4.140): the drive follows as fast as it can. Only in closed loop; a
    /// running profile replaces it at once.
    pub fn wrdp(&mut self, axis: usize, dp: f64) -> bool {
        if !self.loops[axis].closed || !put(&mut self.axes[axis].dp, dp, |_| true) {
            return false;
        }
        if self.axes[axis].is_drained() {
            self.axes[axis].forget_queue();
        }
        true
    }
    /// Another coordinate for the present position (4.4.167), which shifts the machine zero point. Only in open
    /// loop; the axis is no longer referenced.
    pub fn wrrp(&mut self, axis: usize, rp: f64) -> bool {
        if self.loops[axis].closed || !rp.is_finite() {
            return false;
        }
        self.loops[axis].set_rp(rp);
        self.axes[axis].dp = self.loops[axis].rp();
        self.meet_master(axis);
        self.axes[axis].forget_queue();
        self.set_status(axis, Axst::referenced, false);
        true
    }
    /// The actual position becomes the desired position (4.4.112), at once. A running profile replaces it again.
    pub fn RPtoDP(&mut self, axes: AxisSet) {
        for a in self.known(axes).iter() {
            self.axes[a].dp = self.loops[a].rp() - self.loops[a].offset;
            if self.axes[a].is_drained() {
                self.axes[a].forget_queue();
            }
        }
    }
    /// Closes the loops of axes that may be moving (4.4.9): actual positions and velocities become the desired ones.
    pub fn clv(&mut self, axes: AxisSet) {
        for a in self.known(axes).iter() {
            let v = self.loops[a].rv();
            self.cl(AxisSet::single(a));
            self.loops[a].close(v);
            let axis = &mut self.axes[a];
            (axis.dv, axis.run_on_v) = (v, v / axis.trajectory.factor);
        }
    }
    /// Resets axes (4.4.42): profiles and spoolers discarded, loops open, command outputs off, positions and override
    /// at their start; software limits are watched again after shp. System data stay.
    pub fn ra(&mut self, axes: AxisSet) {
        self.ol(axes);
        for a in self.known(axes).iter() {
            self.loops[a].set_rp(0.0);
            self.meet_master(a);
            let axis = &mut self.axes[a];
            (axis.dp, axis.limiting) = (0.0, Limiting::default());
            (axis.trajectory, axis.parameters.jovr) = (Override::default(), 1.0);
            axis.forget_queue();
            let cleared = Axst::referenced | Axst::saf | Axst::mpe | Axst::dhef | Axst::lsls | Axst::lsrs;
            self.set_status(a, cleared, false);
        }
        self.reset_outputs();
    }
    /// Options of the position loop of a servo axis (4.4.51).
    pub fn rdControllerFlags(&self, axis: usize) -> ControllerFlags {
        self.loops[axis].special.flags
    }
    /// Sets them (4.4.137). Bits without a meaning are kept and do nothing.
    pub fn wrControllerFlags(&mut self, axis: usize, flags: ControllerFlags) {
        self.loops[axis].set_special(|special| special.flags = flags);
    }
    /// Dead band of the control deviation in counts for ControllerFlags (ControllerParams[8][0], 6.3.1.4).
    pub(crate) fn set_dead_band(&mut self, axis: usize, counts: f64) {
        self.loops[axis].set_special(|special| special.dead_band = counts);
    }
    /// Counts of the encoder of a stepper axis (register aux with encoder verification, 4.4.44).
    pub fn encoder_counts(&self, axis: usize) -> i64 {
        self.loops[axis].aux()
    }
    /// Steps per encoder count of a stepper axis with encoder verification (4.4.67).
    pub fn rdgfaux(&self, axis: usize) -> f64 {
        self.loops[axis].special.gfaux
    }
    /// Sets it (4.4.146); 0 is refused.
    pub fn wrgfaux(&mut self, axis: usize, gfaux: f64) -> bool {
        let ok = gfaux != 0.0 && gfaux.is_finite();
        if ok {
            self.loops[axis].set_special(|special| special.gfaux = gfaux);
        }
        ok
    }

    /// Coefficients of the PIDF filter (4.4.64).
    pub fn rdf(&self, axis: usize) -> PidfGains {
        *self.loops[axis].gains()
    }
    /// Sets all coefficients of the PIDF filter together (4.4.131), at any time. KPL goes from 0 to 1.
    pub fn uf(&mut self, axis: usize, gains: &PidfGains) -> bool {
        let PidfGains { kp, ki, kd, kpl, kfcv, kfca } = *gains;
        let ok = [kp, ki, kd, kfcv, kfca].iter().all(|k| k.is_finite()) && (0.0..=1.0).contains(&kpl);
        if ok {
            self.loops[axis].set_gains(gains);
        }
        ok
    }
    /// Motor command port (4.4.88): servo axes in digits (32767 = 10 V), stepper axes the delay of the step output.
    pub fn rdmcp(&self, axis: usize) -> i32 {
        self.loops[axis].mcp()
    }
    /// Writes the motor command port (4.4.162), clamped to its range: moves the axis in open loop.
    pub fn wrmcp(&mut self, axis: usize, mcp: i32) {
        self.loops[axis].set_mcp(mcp);
    }

    /// In-position window (4.4.73).
    pub fn rdipw(&self, axis: usize) -> f64 {
        self.axes[axis].parameters.ipw
    }
    /// Sets it (4.4.149).
    pub fn wripw(&mut self, axis: usize, ipw: f64) -> bool {
        put(&mut self.axes[axis].parameters.ipw, ipw, |v| v >= 0.0)
    }
    /// Following error limit (4.4.92).
    pub fn rdmpe(&self, axis: usize) -> f64 {
        self.axes[axis].parameters.mpe
    }
    /// Sets it (4.4.165).
    pub fn wrmpe(&mut self, axis: usize, mpe: f64) -> bool {
        put(&mut self.axes[axis].parameters.mpe, mpe, |v| v >= 0.0)
    }
    /// Encoder counts or stepper pulses per motor revolution; success is 1 (4.4.102).
    pub fn rdslsp(&self, axis: usize) -> (i32, f64) {
        (1, self.axes[axis].parameters.slsp)
    }
    /// Left software limit (4.4.100), a position of the machine whatever its virtual zero point; `None` where no limits are configured.
    pub fn rdsll(&self, axis: usize) -> Option<f64> {
        let axis = &self.axes[axis];
        axis.parameters.limits.map(|l| l.left + axis.zero)
    }
    /// Right software limit (4.4.101).
    pub fn rdslr(&self, axis: usize) -> Option<f64> {
        let axis = &self.axes[axis];
        axis.parameters.limits.map(|l| l.right + axis.zero)
    }
    /// Sets the left software limit (4.4.169); it counts once the axis is referenced (shp).
    pub fn wrsll(&mut self, axis: usize, sll: f64) -> bool {
        let sll = sll - self.axes[axis].zero;
        put(&mut self.limits_mut(axis).left, sll, |_| true)
    }
    /// Sets the right software limit (4.4.170).
    pub fn wrslr(&mut self, axis: usize, slr: f64) -> bool {
        let slr = slr - self.axes[axis].zero;
        put(&mut self.limits_mut(axis).right, slr, |_| true)
    }
    /// The limits of an axis; without configured ones there is room, and no function.
    fn limits_mut(&mut self, axis: usize) -> &mut SoftwareLimits {
        const NONE: SoftwareLimits =
            SoftwareLimits { left: -UNLIMITED, right: UNLIMITED, function: LimitFunction::Off };
        self.axes[axis].parameters.limits.get_or_insert(NONE)
    }

    /// The mechanics of a servo axis, to play faults: a jam, a push from outside.
    pub fn plant_mut(&mut self, axis: usize) -> Option<&mut ServoPlant> {
        self.loops[axis].plant_mut()
    }
}
