//! System parameters and axis qualifiers of rw_SymPas: the registers that PCAP reads and writes too.
//!
//! Values are slots (see [`super`]). A value that a register does not allow is not taken over, as with PCAP.

use super::program::{boolean, integer, real, timer};
use super::tables::{BitQualifier, Qualifier, SystemParameter};
use crate::axes::AxisSet;
use crate::card::Led;
use crate::machine::PidfGains;
use crate::mcu::Mcu;
use crate::named::{AXIS_REGISTERS, Register};
use crate::registers::{ControllerFlags, ErrorReg, ModeReg};

/// System parameters that are read by commands of rw_SymPas only (6.3.1, table 32).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Parameters {
    /// Angle of circles, degrees.
    pub phi: f64,
    /// Circle centre of the target form.
    pub dtca: [f64; 3],
    /// Plane normal.
    pub pn: [f64; 3],
    /// Function code of ssf.
    pub ssfp: i32,
    /// Start delay and duration of a recording (lpr), s.
    pub lst: f64,
    pub let_: f64,
    /// CLOCK at boot, ticks of 64 us.
    pub clock_start: u32,
}

/// OSVERSION: main number times 1000 plus minor number (design D12).
pub const OS_VERSION: i32 = 253_126;
/// BOARDTYPE: APCI-8008 (design D12).
const BOARD_TYPE: i32 = 32;

impl Mcu {
    pub(super) fn read_system(&mut self, parameter: SystemParameter) -> u64 {
        use SystemParameter::*;
        match parameter {
            CFLAG => return self.read_qualifier(0, Qualifier::CFLAGS),
            GFAUX => return self.read_qualifier(0, Qualifier::gfaux),
            _ => {}
        }
        let r = &self.registers;
        let path = &r.sap;
        match parameter {
            BOARDTYPE => integer(BOARD_TYPE),
            CLOCK => timer(self.clock()),
            DTCA1 => real(path.dtca[0]),
            DTCA2 => real(path.dtca[1]),
            DTCA3 => real(path.dtca[2]),
            ERRORREG => integer(r.errorreg.0 as i32),
            IRQPC => boolean(self.card.irqpc()),
            LEDGN => boolean(self.card.led(Led::Green)),
            LEDRD => boolean(self.card.led(Led::Red)),
            LEDYL => boolean(self.card.led(Led::Yellow)),
            MODEREG => integer(r.modereg.0 as i32),
            NFRAX => integer(r.nfrax.0 as i32),
            NOA => integer(self.axes.len() as i32),
            OSVERSION => integer(OS_VERSION),
            PHI => real(path.phi),
            PN1 => real(path.pn[0]),
            PN2 => real(path.pn[1]),
            PN3 => real(path.pn[2]),
            PU => integer(r.units.pu as i32),
            SSFP => integer(path.ssfp),
            TRAC => real(r.trac),
            TROVR => real(r.trovr),
            TROVRST => real(r.trovrst),
            TRTVL => real(r.trtvl),
            TRVL => real(r.trvl),
            TU => integer(r.units.tu as i32),
            LET => real(path.let_),
            LST => real(path.lst),
            CFLAG | GFAUX => 0, // above
        }
    }

    pub(super) fn write_system(&mut self, parameter: SystemParameter, slot: u64) {
        use SystemParameter::*;
        let (int, value, on) = (slot as i32, f64::from_bits(slot), slot != 0);
        match parameter {
            BOARDTYPE | CLOCK | NOA | OSVERSION => {} // the compiler refuses it
            CFLAG => self.write_qualifier(0, Qualifier::CFLAGS, slot),
            GFAUX => self.write_qualifier(0, Qualifier::gfaux, slot),
            ERRORREG => self.registers.errorreg = ErrorReg(self.registers.errorreg.0 & int as u32),
            IRQPC => self.card.set_irqpc(on),
            LEDGN => self.card.set_led(Led::Green, on),
            LEDRD => self.card.set_led(Led::Red, on),
            LEDYL => self.card.set_led(Led::Yellow, on),
            MODEREG => self.set_modereg(ModeReg(int as u32)),
            NFRAX => self.registers.nfrax = AxisSet(int as u32 & self.all_axes().0),
            PU => _ = self.ctru(int, self.registers.units.tu as i32),
            TU => _ = self.ctru(self.registers.units.pu as i32, int),
            SSFP => self.registers.sap.ssfp = int,
            TROVR => _ = self.wrtrovr(value),
            TROVRST => self.wrtrovrst(value),
            DTCA1 | DTCA2 | DTCA3 | LET | LST | PHI | PN1 | PN2 | PN3 | TRAC | TRTVL | TRVL => {
                self.write_path(parameter, value)
            }
        }
    }

    fn write_path(&mut self, parameter: SystemParameter, value: f64) {
        use SystemParameter::*;
        let r = &mut self.registers;
        *match parameter {
            DTCA1 => &mut r.sap.dtca[0],
            DTCA2 => &mut r.sap.dtca[1],
            DTCA3 => &mut r.sap.dtca[2],
            LET => &mut r.sap.let_,
            LST => &mut r.sap.lst,
            PN1 => &mut r.sap.pn[0],
            PN2 => &mut r.sap.pn[1],
            PN3 => &mut r.sap.pn[2],
            TRAC => &mut r.trac,
            TRTVL => &mut r.trtvl,
            TRVL => &mut r.trvl,
            _ => &mut r.sap.phi,
        } = value;
    }

    /// Ticks of 64 us since boot, cyclic (CLOCK).
    pub fn clock(&self) -> u32 {
        let ticks = self.sample.wrapping_mul(u64::from(self.machine.controller.sample_ticks));
        (ticks as u32).wrapping_add(self.registers.sap.clock_start)
    }

    pub(super) fn read_qualifier(&mut self, axis: usize, qualifier: Qualifier) -> u64 {
        use Qualifier::*;
        match qualifier {
            axst => integer(self.axst(axis).0 as i32),
            CFLAGS | cflags => integer(self.rdControllerFlags(axis).0 as i32),
            digi => integer(self.rddigi(axis) as i32),
            digo => integer(self.rddigo() as i32),
            epc => integer(self.card.epc),
            gcr => integer(self.card.axes[axis].gcr),
            ifs => integer(self.rdifs().0 as i32),
            lsm => integer(self.axes[axis].spooler.left() as i32),
            mcis => integer(self.axes[axis].spooler.moves() as i32),
            mcp => integer(self.rdmcp(axis)),
            lp => real(self.rdlp(axis)), // clears lpsf
            sf => integer(self.card.axes[axis].sf),
            kp | ki | kd | kpl | kfca | kfcv => real(*coefficient(&mut self.written_filter(axis), qualifier)),
            _ => real(register(qualifier).map_or(0.0, |r| (r.read)(self, axis))),
        }
    }

    pub(super) fn write_qualifier(&mut self, axis: usize, qualifier: Qualifier, slot: u64) {
        use Qualifier::*;
        let (int, value) = (slot as i32, f64::from_bits(slot));
        match qualifier {
            CFLAGS | cflags => self.wrControllerFlags(axis, ControllerFlags(int as u32)),
            digi => self.rdigi(axis),
            digo => self.wrdigo(axis, int as u32),
            gcr => {
                self.wrGCR(axis, int);
            }
            ifs => self.rifs(),
            mcp => self.wrmcp(axis, int),
            sf => self.card.axes[axis].sf = int,
            kp | ki | kd | kpl | kfca | kfcv => {
                let mut gains = self.written_filter(axis);
                *coefficient(&mut gains, qualifier) = value;
                self.card.axes[axis].filter = Some(gains);
            }
            _ => {
                if let Some(write) = register(qualifier).and_then(|r| r.write) {
                    write(self, axis, value);
                }
            }
        }
    }

    pub(super) fn read_qualifier_bit(&self, axis: usize, qualifier: BitQualifier, bit: u8) -> bool {
        let word = match qualifier {
            BitQualifier::axstb => self.axst(axis).0,
            BitQualifier::digib => self.rddigi(axis),
            BitQualifier::digob => self.rddigo(),
            BitQualifier::ifsb => self.rdifs().0,
        };
        word >> (bit - 1) & 1 == 1
    }

    /// The filter coefficients as written by programs, which wait for uf; those never written are the ones in use.
    fn written_filter(&self, axis: usize) -> PidfGains {
        self.card.axes[axis].filter.unwrap_or_else(|| self.rdf(axis))
    }
    /// Takes over what programs have written (SAP uf).
    pub(super) fn take_written_filter(&mut self, axis: usize) {
        let gains = self.written_filter(axis);
        self.uf(axis, &gains);
    }
}

/// The register behind each qualifier, by its number: found by name once, when this is compiled.
static REGISTERS: [Option<&Register>; Qualifier::ALL.len()] = {
    let mut found = [None; Qualifier::ALL.len()];
    let mut n = 0;
    while n < found.len() {
        let mut r = 0;
        while r < AXIS_REGISTERS.len() {
            if same(AXIS_REGISTERS[r].name.as_bytes(), Qualifier::ALL[n].name().as_bytes()) {
                found[n] = Some(&AXIS_REGISTERS[r]);
            }
            r += 1;
        }
        n += 1;
    }
    found
};

fn register(qualifier: Qualifier) -> Option<&'static Register> {
    REGISTERS[qualifier as usize]
}

const fn same(a: &[u8], b: &[u8]) -> bool {
    let mut n = 0;
    while n < a.len() && n < b.len() && a[n] == b[n] {
        n += 1;
    }
    n == a.len() && n == b.len()
}

fn coefficient(gains: &mut PidfGains, qualifier: Qualifier) -> &mut f64 {
    match qualifier {
        Qualifier::ki => &mut gains.ki,
        Qualifier::kd => &mut gains.kd,
        Qualifier::kpl => &mut gains.kpl,
        Qualifier::kfca => &mut gains.kfca,
        Qualifier::kfcv => &mut gains.kfcv,
        _ => &mut gains.kp,
    }
}
