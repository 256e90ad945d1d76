//! Digital inputs and outputs of the base board, the digi word of an axis, and the interface status (2.4, 4.4.52 to
//! 4.4.55, 4.4.70 to 4.4.72, 4.4.138, 4.4.139). The outputs are not grouped by axis: all axes have the same.

use crate::axes::AxisSet;
use crate::machine::Machine;
use crate::mcu::Mcu;
use crate::registers::{Axst, Digi, ErrorReg, Ifs};
use crate::trace::EventKind;

/// Digital inputs and outputs there are.
const INPUTS: u32 = 0xffff;
const OUTPUTS: u32 = 0xff;
/// Flags that rdigi and rifs clear.
const STORED_DIGI: Digi = Digi(Digi::error.0 | Digi::index_edge.0 | Digi::strobe.0);
const STORED_IFS: Ifs = Ifs(Ifs::pfe.0 | Ifs::wdog.0 | Ifs::iae.0 | Ifs::scwdog.0 | Ifs::scpfe.0);

/// State of inputs, outputs and interface.
#[derive(Clone, Debug)]
pub(crate) struct Io {
    /// Levels of the inputs from outside, and those that are inverted.
    levels: u32,
    inverted: u32,
    pub digo: u32,
    /// Outputs after a reset, and those that enable the amplifier of each axis (PAE).
    defaults: u32,
    amplifiers: Vec<u32>,
    /// Drives that have dropped out.
    dropped: AxisSet,
    pub ifs: Ifs,
    /// Flags of the logic that the next boot copies into ifs.
    logic: Ifs,
}

impl Io {
    /// After power-up and boot: the world outside rests.
    pub fn new(machine: &Machine) -> Io {
        let mut amplifiers = vec![0; machine.axes.len()];
        for output in &machine.outputs {
            if let Some(axis) = output.amplifier_of {
                amplifiers[axis] |= 1 << (output.number - 1);
            }
        }
        let defaults = machine.outputs.iter().filter(|o| o.on).fold(0, |mask, o| mask | 1 << (o.number - 1));
        let (levels, inverted) = (machine.resting_inputs(), machine.inverted_inputs());
        let ifs = Ifs::edv | Ifs::cncrdy | Ifs::pfe | Ifs::scpfe;
        let dropped = AxisSet::EMPTY;
        Io { levels, inverted, digo: defaults, defaults, amplifiers, dropped, ifs, logic: Ifs(0) }
    }
    /// Takes over what system data do not change: levels of the inputs, the interface.
    pub fn keep_outside(&mut self, before: &Io) {
        (self.levels, self.ifs, self.logic) = (before.levels, before.ifs, before.logic);
    }
    /// Inputs that are inverted.
    pub fn inverted(&self) -> u32 {
        self.inverted
    }
    /// The inputs after inversion.
    pub fn active_inputs(&self) -> u32 {
        self.levels ^ self.inverted
    }
}

impl Mcu {
    /// Digi word of an axis (4.4.52): bits 0 to 15 the inputs 1 to 16 after inversion, above them signals of the axis.
    pub fn rddigi(&self, axis: usize) -> u32 {
        self.digi & INPUTS | self.signals[axis].digi.0
    }
    /// One of its bits; `bitnr` counts from 1 (4.4.53).
    pub fn rddigib(&self, axis: usize, bitnr: u32) -> i32 {
        bit(self.rddigi(axis), bitnr)
    }
    /// Clears the stored bits 17 to 19 of the digi word (4.4.72); the index signal itself stays as it is.
    pub fn rdigi(&mut self, axis: usize) {
        self.signals[axis].digi.clear(STORED_DIGI);
    }
    /// Levels of the digital inputs as the world outside has them, bit n-1 = input n.
    pub fn set_inputs(&mut self, levels: u32) {
        self.io.levels = levels;
        self.take_inputs(1.0);
    }
    pub fn inputs(&self) -> u32 {
        self.io.levels
    }
    /// An input becomes active or inactive (after inversion) at this fraction of the last sample.
    pub fn set_input(&mut self, number: u32, active: bool, fraction: f64) {
        let mask = 1 << (number - 1);
        let level = active != (self.io.inverted & mask != 0);
        self.io.levels = if level { self.io.levels | mask } else { self.io.levels & !mask };
        self.take_inputs(fraction);
    }
    fn take_inputs(&mut self, fraction: f64) {
        let mut active = self.io.active_inputs();
        for a in self.io.dropped.iter() {
            active &= !self.axis_inputs.get(a).map_or(0, |inputs| inputs.drive_ready);
        }
        let risen = active & !self.digi;
        self.digi = active;
        if risen != 0 {
            self.latch_inputs(risen, fraction);
        }
    }

    /// Digital outputs, bit n-1 = output n (4.4.54).
    pub fn rddigo(&self) -> u32 {
        self.io.digo
    }
    /// One of them; `bitnr` counts from 1 (4.4.55).
    pub fn rddigob(&self, bitnr: u32) -> i32 {
        bit(self.io.digo, bitnr)
    }
    /// Sets all digital outputs (4.4.138); bits 8 to 31 have no effect.
    pub fn wrdigo(&mut self, axis: usize, digo: u32) {
        self.write_outputs(axis as i32, digo, 0);
    }
    /// Sets or resets one output (4.4.139); `bitnr` counts from 1, 9 to 32 have no effect.
    pub fn wrdigob(&mut self, axis: usize, bitnr: u32, on: bool) {
        if (1..=8).contains(&bitnr) {
            let mask = 1 << (bitnr - 1);
            self.wrdigo(axis, if on { self.io.digo | mask } else { self.io.digo & !mask });
        }
    }
    /// The outputs change, and with them the power of the drives that they enable.
    pub(crate) fn write_outputs(&mut self, axis: i32, outputs: u32, line: u32) {
        self.io.digo = outputs & OUTPUTS;
        self.event(EventKind::Outputs, axis, "digo", true, line, i64::from(self.io.digo));
        for a in 0..self.axes.len() {
            self.supply(a);
        }
    }
    fn change_outputs(&mut self, outputs: u32) {
        if outputs != self.io.digo {
            self.write_outputs(-1, outputs, 0);
        }
    }
    /// Closing a loop sets all outputs with function PAE (4.4.8).
    pub(crate) fn enable_amplifiers(&mut self) {
        let all = self.io.amplifiers.iter().fold(0, |all, mask| all | mask);
        self.change_outputs(self.io.digo | all);
    }
    /// Opening loops resets those of their axes (4.4.41).
    pub(crate) fn disable_amplifiers(&mut self, axes: AxisSet) {
        let theirs = axes.iter().fold(0, |all, a| all | self.io.amplifiers[a]);
        self.change_outputs(self.io.digo & !theirs);
    }
    /// ra and rs: all outputs as configured, also those that enable other axes.
    pub(crate) fn reset_outputs(&mut self) {
        self.change_outputs(self.io.defaults);
    }
    pub(crate) fn supply(&mut self, a: usize) {
        let enable = self.io.amplifiers[a];
        self.loops[a].power(!self.io.dropped.contains(a) && (enable == 0 || self.io.digo & enable != 0));
    }
    /// A drive drops out, and its ready signal with it, or comes back.
    pub fn drop_drive(&mut self, a: usize, dropped: bool) {
        let one = AxisSet::single(a);
        self.io.dropped = if dropped { self.io.dropped.union(one) } else { self.io.dropped.without(one) };
        self.supply(a);
        self.take_inputs(1.0);
    }
    /// The encoder of an axis loses its connection, or gets it back: the alarms follow, the stored error stays.
    pub fn cut_encoder(&mut self, a: usize, cut: bool) {
        self.loops[a].cut_encoder(cut);
        let digi = &mut self.signals[a].digi;
        digi.put(Digi::AEA | Digi::AEB | Digi::AEN | Digi::AES, cut);
        if cut {
            digi.set(Digi::error);
            digi.clear(Digi::index);
        }
    }

    /// The mechanics of an axis jam or come free.
    pub fn block(&mut self, a: usize, blocked: bool) {
        self.loops[a].block(blocked);
    }
    /// Something from outside moves an axis by a distance, axis units.
    pub fn push(&mut self, a: usize, distance: f64) {
        self.loops[a].push(distance);
    }
    /// Where the load of an axis stands on the scale of the machine, axis units: coordinates at boot, which shp, wrrp
    /// and zero offsets do not shift.
    pub fn machine_position(&self, axis: usize) -> f64 {
        self.loops[axis].machine_position()
    }

    /// Interface status (4.4.70).
    pub fn rdifs(&self) -> Ifs {
        self.io.ifs
    }
    /// One of its bits; `bitnr` counts from 1 (4.4.71).
    pub fn rdifsb(&self, bitnr: u32) -> i32 {
        bit(self.io.ifs.0, bitnr)
    }
    /// Clears the error flags 16 to 20 (4.4.111).
    pub fn rifs(&mut self) {
        self.io.ifs.clear(STORED_IFS);
    }
    /// What a boot does to the interface status: flags of the logic come up once, those of before are gone.
    pub fn boot_interface(&mut self) {
        self.io.ifs = Ifs(Ifs::edv.0 | Ifs::cncrdy.0 | self.io.logic.0);
        self.io.logic = Ifs(0);
    }
    /// The supply falls below 4.75 V (and below 2.85 V): the logic remembers it for the next boot.
    pub fn undervoltage(&mut self, deep: bool) {
        self.io.logic.set(Ifs::scpfe);
        self.io.logic.put(Ifs::pfe, deep);
        self.io.ifs.set(self.io.logic);
    }
    /// A communication error (ENDAT, SSI, EtherCAT).
    pub fn bus_error(&mut self) {
        self.io.ifs.set(Ifs::bus_error);
    }

    /// Compares the drives that are there with the system data (axst cef): after rs and after new system data.
    pub fn check_configuration(&mut self) {
        for a in 0..self.axes.len() {
            let differs = self.hardware.get(a) != Some(&self.machine.axes[a].drive);
            self.set_status(a, Axst::cef, differs);
        }
    }

    /// Limits of the motor command mcpmax, mcpmin and zero compensation mcpcp, mcpcn in digits (32767 = 10 V). Invalid
    /// numbers change nothing and set ErrorReg LimitDefError.
    pub fn set_port(&mut self, axis: usize, port: &crate::machine::Port) -> bool {
        const FULL: f64 = crate::controller::FULL_SCALE;
        let crate::machine::Port { max, min, positive, negative, .. } = *port;
        let range = |v: f64| (-FULL..=FULL).contains(&v);
        let added = |v: f64| (0.0..=FULL).contains(&v);
        let ok = range(max) && range(min) && min < max && added(positive) && added(negative);
        if ok {
            let inverted = self.loops[axis].special.port.inverted; // wiring, not a register
            let port = crate::machine::Port { inverted, ..*port };
            self.loops[axis].set_special(|special| special.port = port);
        } else {
            self.raise(ErrorReg::LimitDefError);
        }
        ok
    }
    pub fn port(&self, axis: usize) -> crate::machine::Port {
        self.loops[axis].special.port
    }
}

fn bit(word: u32, bitnr: u32) -> i32 {
    if (1..=32).contains(&bitnr) { (word >> (bitnr - 1) & 1) as i32 } else { 0 }
}
