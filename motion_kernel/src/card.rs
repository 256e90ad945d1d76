//! What the card keeps besides motion: LEDs, the interrupt of the PC, variables of the application, common buffers of
//! the tasks, and axis registers whose meaning belongs to applications (2.5, 4.3.2.9, 4.4.44, 4.4.65, 4.4.114).
//! All of it survives `rs`.

use crate::machine::PidfGains;
use crate::mcu::{Mcu, TASKS};

/// Bytes of the common buffer of a CNC task (4.3.2.9).
pub const COMMON_BUFFER: usize = 1000;
/// Application variables of the system and of each axis, of either type (2.5 leaves their number open).
pub const APPLICATION_VARIABLES: usize = 100;
/// Controller parameters of an axis: 15 x 15 (4.4.114).
pub const CONTROLLER_PARAMETERS: usize = 225;
/// ControllerParams[8][0].
pub const DEAD_BAND: usize = 8 * 15;

/// The three LEDs (4.4.79 to 4.4.81).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Led {
    Green,
    Red,
    Yellow,
}

/// Variables of the application: whole numbers and doubles.
#[derive(Clone, Debug, PartialEq)]
pub struct Variables {
    pub int: Vec<i32>,
    pub dbl: Vec<f64>,
}

impl Default for Variables {
    fn default() -> Self {
        Variables { int: vec![0; APPLICATION_VARIABLES], dbl: vec![0.0; APPLICATION_VARIABLES] }
    }
}

/// Registers of one axis that the base system stores and does not use.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisRegisters {
    pub variables: Variables,
    /// Auxiliary register (4.4.44).
    pub aux: f64,
    /// Gear configuration register (4.4.65), for the gears of the resource interface.
    pub gcr: i32,
    /// Special register of applications (6.3.3).
    pub sf: i32,
    /// Filter coefficients that a rw_SymPas program has written and `uf` will take over.
    pub filter: Option<PidfGains>,
    /// The field of `scp`, row by row.
    pub parameters: Vec<f64>,
}

impl Default for AxisRegisters {
    fn default() -> Self {
        let parameters = vec![0.0; CONTROLLER_PARAMETERS];
        AxisRegisters { variables: Variables::default(), aux: 0.0, gcr: 0, sf: 0, filter: None, parameters }
    }
}

/// State of the card.
#[derive(Clone, Debug, PartialEq)]
pub struct Card {
    leds: [bool; 3],
    irqpc: bool,
    /// Interrupts of the PC raised so far.
    interrupts: u64,
    /// Times that the EEPROM was programmed (4.4.62); a boot keeps it.
    pub epc: i32,
    pub variables: Variables,
    pub axes: Vec<AxisRegisters>,
    /// Common buffers of the tasks, [`COMMON_BUFFER`] bytes each.
    buffers: [Vec<u8>; TASKS],
}

impl Card {
    pub fn new(axes: usize) -> Card {
        Card {
            leds: [false; 3],
            irqpc: false,
            interrupts: 0,
            epc: 0,
            variables: Variables::default(),
            axes: vec![AxisRegisters::default(); axes],
            buffers: std::array::from_fn(|_| vec![0; COMMON_BUFFER]),
        }
    }
    /// State of an LED (rdledgn, rdledrd, rdledyl).
    pub fn led(&self, led: Led) -> bool {
        self.leds[led as usize]
    }
    /// Switches an LED (wrledgn, wrledrd, wrledyl; 4.4.155 to 4.4.157).
    pub fn set_led(&mut self, led: Led, on: bool) {
        self.leds[led as usize] = on;
    }
    /// The interrupt request to the PC (rdirqpc, 4.4.74).
    pub fn irqpc(&self) -> bool {
        self.irqpc
    }
    /// Raises or clears it (system variable IRQPC, ssf 1101). The routine of the PC runs as it is raised.
    pub fn set_irqpc(&mut self, on: bool) {
        self.interrupts += u64::from(on && !self.irqpc);
        self.irqpc = on;
    }
    /// Times that the interrupt was raised.
    pub fn interrupts(&self) -> u64 {
        self.interrupts
    }
    /// The first `size` bytes of the common buffer of a task, or the error code of 4.4.47: bit 0 task number,
    /// bit 1 size.
    pub fn common_buffer(&self, task: usize, size: usize) -> Result<&[u8], i32> {
        check_buffer(task, size).map(|()| &self.buffers[task][..size])
    }
    /// The whole common buffer of a task.
    pub(crate) fn buffer_mut(&mut self, task: usize) -> &mut [u8] {
        &mut self.buffers[task]
    }
    /// Writes the beginning of the common buffer of a task (4.4.134); errors as for reading.
    pub fn set_common_buffer(&mut self, task: usize, bytes: &[u8]) -> Result<(), i32> {
        check_buffer(task, bytes.len()).map(|()| self.buffers[task][..bytes.len()].copy_from_slice(bytes))
    }
}

fn check_buffer(task: usize, size: usize) -> Result<(), i32> {
    let code = i32::from(task >= TASKS) | i32::from(size > COMMON_BUFFER) << 1;
    if code == 0 { Ok(()) } else { Err(code) }
}

impl Mcu {
    pub fn card(&self) -> &Card {
        &self.card
    }
    /// Writes a controller parameter (scp), row by row: 120 is ControllerParams[8][0], the dead band of ControllerFlags
    /// in digits (6.3.1.4).
    pub fn set_controller_parameter(&mut self, axis: usize, cell: usize, value: f64) {
        self.card.axes[axis].parameters[cell] = value;
        if cell == DEAD_BAND {
            self.set_dead_band(axis, value);
        }
    }
    pub fn card_mut(&mut self) -> &mut Card {
        &mut self.card
    }
}
