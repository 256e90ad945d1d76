//! Axis registers by name, as PCAP reads and writes them one by one (rd..., wr...): the table behind its methods.

use crate::mcu::Mcu;

/// A register that is one number per axis.
pub struct Register {
    /// As in TSRP (4.3.2.2), or as in the name of the command.
    pub name: &'static str,
    pub read: fn(&Mcu, usize) -> f64,
    /// False: the value is not allowed, the one before it stays. `None`: only read.
    pub write: Option<fn(&mut Mcu, usize, f64) -> bool>,
}

const fn register(
    name: &'static str,
    read: fn(&Mcu, usize) -> f64,
    write: Option<fn(&mut Mcu, usize, f64) -> bool>,
) -> Register {
    Register { name, read, write }
}

/// All of them. Positions, velocities and accelerations in axis units, those of look-ahead in PU and TU.
pub const AXIS_REGISTERS: &[Register] = &[
    register("rp", |m, a| m.rdrp(a), Some(|m, a, v| m.wrrp(a, v))),
    register("dp", |m, a| m.rddp(a), Some(|m, a, v| m.wrdp(a, v))),
    register("tp", |m, a| m.rdtp(a), Some(|m, a, v| m.wrtp(a, v))),
    register("rpd", |m, a| m.displayed(a, m.rdrp(a)), None),
    register("dpd", |m, a| m.displayed(a, m.rddp(a)), None),
    register("tpd", |m, a| m.displayed(a, m.rdtp(a)), None),
    register("rv", |m, a| m.rdrv(a), None),
    register("dv", |m, a| m.rddv(a), None),
    register("poserr", |m, a| m.rdPosErr(a), None),
    register("zerooffset", |m, a| m.zero_offset(a), None),
    register("jac", |m, a| m.rdjac(a), Some(|m, a, v| m.wrjac(a, v))),
    register("jvl", |m, a| m.parameters(a).jvl, Some(|m, a, v| put(&mut m.parameters_mut(a).jvl, v, |_| true))),
    register("jtvl", |m, a| m.parameters(a).jtvl, Some(|m, a, v| put(&mut m.parameters_mut(a).jtvl, v, |_| true))),
    register("jovr", |m, a| m.rdjovr(a), Some(|m, a, v| m.wrjovr(a, v))),
    register("sdec", |m, a| m.parameters(a).sdec, Some(|m, a, v| put(&mut m.parameters_mut(a).sdec, v, |v| v >= 0.0))),
    register("jerkrel", |m, a| m.parameters(a).jerkrel, Some(|m, a, v| m.wrjerkrel(a, v))),
    register("sll", |m, a| m.rdsll(a).unwrap_or(-UNLIMITED), Some(|m, a, v| m.wrsll(a, v))),
    register("slr", |m, a| m.rdslr(a).unwrap_or(UNLIMITED), Some(|m, a, v| m.wrslr(a, v))),
    register("ipw", |m, a| m.rdipw(a), Some(|m, a, v| m.wripw(a, v))),
    register("mpe", |m, a| m.rdmpe(a), Some(|m, a, v| m.wrmpe(a, v))),
    register("mcp", |m, a| f64::from(m.rdmcp(a)), None),
    register("mdvel", |m, a| m.parameters(a).mdvel / m.velocity_unit(a), Some(|m, a, v| m.wrmdvel(a, v))),
    register("maxvel", |m, a| m.parameters(a).maxvel / m.velocity_unit(a), Some(|m, a, v| m.wrmaxvel(a, v))),
    register("maxacc", |m, a| m.parameters(a).maxacc / m.acceleration_unit(a), Some(|m, a, v| m.wrmaxacc(a, v))),
    register("effradius", |m, a| m.rdeffradius(a), Some(|m, a, v| m.wreffradius(a, v))),
    register("hac", |m, a| m.rdhac(a), Some(|m, a, v| m.wrhac(a, v))),
    register("hvl", |m, a| m.rdhvl(a), Some(|m, a, v| m.wrhvl(a, v))),
    register("gf", |m, a| m.rdgf(a), Some(|m, a, v| m.wrgf(a, v))),
    register("gfaux", |m, a| m.rdgfaux(a), Some(|m, a, v| m.wrgfaux(a, v))),
    register("slsp", |m, a| m.rdslsp(a).1, Some(|m, a, v| m.wrslsp(a, v))),
    register("dpoffset", |m, a| m.rddpoffset(a), Some(|m, a, v| m.wrdpoffset(a, v))),
    register("dvoffset", |m, a| m.rddvoffset(a), Some(|m, a, v| m.wrdvoffset(a, v))),
    register("lp", |m, a| m.latched(a), Some(|m, a, v| m.wrlp(a, v))),
    register("lpndx", |m, a| m.rdlpndx(a), Some(|m, a, v| m.wrlpndx(a, v))),
    register("pcapindex", |m, a| f64::from(m.rdPcapIndex(a)), None),
    register("aux", |m, a| m.rdaux(a), Some(|m, a, v| put(&mut m.card.axes[a].aux, v, |_| true))),
];

/// A register of the controller as a whole that is one number.
pub struct SystemRegister {
    pub name: &'static str,
    pub read: fn(&Mcu) -> f64,
    /// False: the value is not allowed.
    pub write: fn(&mut Mcu, f64) -> bool,
}

/// Path values of rw_SymPas programs and the trajectory override (4.4.105 to 4.4.109, 4.4.173 to 4.4.177).
pub const SYSTEM_REGISTERS: &[SystemRegister] = &[
    SystemRegister {
        name: "trac",
        read: |m| m.registers.trac,
        write: |m, v| put(&mut m.registers.trac, v, |v| v >= 0.0),
    },
    SystemRegister {
        name: "trvl",
        read: |m| m.registers.trvl,
        write: |m, v| put(&mut m.registers.trvl, v, |v| v >= 0.0),
    },
    SystemRegister {
        name: "trtvl",
        read: |m| m.registers.trtvl,
        write: |m, v| put(&mut m.registers.trtvl, v, |_| true),
    },
    SystemRegister { name: "trovr", read: |m| m.registers.trovr, write: |m, v| m.wrtrovr(v) },
    SystemRegister {
        name: "trovrst",
        read: |m| m.registers.trovrst,
        write: |m, v| put(&mut m.registers.trovrst, v, |v| v >= 0.0),
    },
];

/// Where an axis has no software limits.
pub(crate) const UNLIMITED: f64 = 1e300;

/// The register of that name.
pub fn axis_register(name: &str) -> Option<&'static Register> {
    AXIS_REGISTERS.iter().find(|r| r.name == name)
}

/// The register of that name.
pub fn system_register(name: &str) -> Option<&'static SystemRegister> {
    SYSTEM_REGISTERS.iter().find(|r| r.name == name)
}

/// Takes a value over if it is a finite number that `allowed` accepts.
pub(crate) fn put(slot: &mut f64, value: f64, allowed: impl Fn(f64) -> bool) -> bool {
    let ok = value.is_finite() && allowed(value);
    if ok {
        *slot = value;
    }
    ok
}

impl Mcu {
    /// Auxiliary register (4.4.44): of a stepper axis with an encoder its counts, else what was written last.
    pub fn rdaux(&self, axis: usize) -> f64 {
        let has_encoder = self.machine.axes[axis].equipment.encoder.is_some();
        if has_encoder { self.encoder_counts(axis) as f64 } else { self.card.axes[axis].aux }
    }
    /// Target position of the last travel command, absolute (4.4.103).
    pub fn rdtp(&self, axis: usize) -> f64 {
        self.axes[axis].component.target
    }
    /// Writes it (4.4.172): refused while the axis travels, where it would be the end of what it drives.
    pub fn wrtp(&mut self, axis: usize, tp: f64) -> bool {
        !self.axes[axis].travels() && put(&mut self.axes[axis].component.target, tp, |_| true)
    }
    /// A position in the display unit of its axis (4.4.58, 4.4.96, 4.4.104).
    pub fn displayed(&self, axis: usize, position: f64) -> f64 {
        position / self.axes[axis].per_unit(self.machine.axes[axis].display, true)
    }
    /// Rounding share of S ramps, limited to 0..1 (4.4.151).
    pub fn wrjerkrel(&mut self, axis: usize, jerkrel: f64) -> bool {
        !jerkrel.is_nan() && put(&mut self.parameters_mut(axis).jerkrel, jerkrel.clamp(0.0, 1.0), |_| true)
    }
    /// Largest velocity step at a corner, in PU and TU (4.4.163); 0 = not watched.
    pub fn wrmdvel(&mut self, axis: usize, mdvel: f64) -> bool {
        let unit = self.velocity_unit(axis);
        put(&mut self.parameters_mut(axis).mdvel, mdvel * unit, |v| v >= 0.0)
    }
    /// Velocity limit, in PU and TU (4.4.161); 0 = not watched.
    pub fn wrmaxvel(&mut self, axis: usize, maxvel: f64) -> bool {
        let unit = self.velocity_unit(axis);
        put(&mut self.parameters_mut(axis).maxvel, maxvel * unit, |v| v >= 0.0)
    }
    /// Acceleration limit, in PU and TU (4.4.160); 0 = not watched.
    pub fn wrmaxacc(&mut self, axis: usize, maxacc: f64) -> bool {
        let unit = self.acceleration_unit(axis);
        put(&mut self.parameters_mut(axis).maxacc, maxacc * unit, |v| v >= 0.0)
    }
    /// Effective radius of a rotary axis in PU (4.4.61), of any other 0; mm where PU is no length.
    pub fn rdeffradius(&self, axis: usize) -> f64 {
        let parameters = self.parameters(axis);
        let mm = self.registers.units.pu.mm().unwrap_or(1.0);
        if parameters.rotary { parameters.scale.to_degrees() / mm } else { 0.0 }
    }
    /// Sets it (4.4.143): above 0, and only for a rotary axis. Moves already spooled keep theirs.
    pub fn wreffradius(&mut self, axis: usize, radius: f64) -> bool {
        let mm = self.registers.units.pu.mm().unwrap_or(1.0);
        let parameters = self.parameters_mut(axis);
        parameters.rotary && put(&mut parameters.scale, (radius * mm).to_radians(), |v| v > 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_register_stands_twice() {
        for (n, register) in AXIS_REGISTERS.iter().enumerate() {
            assert!(AXIS_REGISTERS[..n].iter().all(|r| r.name != register.name), "{}", register.name);
        }
    }
}
