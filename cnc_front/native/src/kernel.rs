//! `cnc_front._native.motion_kernel`: the machine file and the controller.

use motion_kernel::Mcu as Kernel;
use motion_kernel::autocode::MoveKind;
use motion_kernel::axes::{AxisList, AxisSet, MAX_AXES};
use motion_kernel::axis::Wait;
use motion_kernel::cause::Cause;
use motion_kernel::functions::Entered;
use motion_kernel::motion::MotionCommand;
use motion_kernel::registers::{Axst, ControllerFlags, Digi, ErrorReg, Ifs, ModeReg};
use motion_kernel::trace::Trace;
use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::chunk::{Chunk, standing};
use crate::machine::{Machine, MachineError};
use crate::program::Program;
use crate::stream::Stream;

pub fn fill(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("MachineError", module.py().get_type::<MachineError>())?;
    module.add_class::<Machine>()?;
    module.add_class::<Mcu>()?;
    module.add_class::<Chunk>()?;
    module.add("MOST_AUTOCODE_BYTES", ::sympas::cnc::MAX_BYTES)?;
    module.add_class::<crate::stimulus::Stimulus>()?;
    module.add_function(wrap_pyfunction!(register_bits, module)?)?;
    module.add_function(wrap_pyfunction!(causes, module)?)?;
    module.add_function(wrap_pyfunction!(crate::resources::resource_devices, module)?)?;
    module.add_function(wrap_pyfunction!(crate::pcap::trajectory_units, module)?)?;
    Ok(())
}

/// The emulated controller. Axes are given by index; motion_kernel.Mcu adds names.
#[pyclass(module = "cnc_front._native.motion_kernel")]
pub struct Mcu {
    pub(crate) kernel: Kernel,
    /// What `pass_on` has recorded since `begin_recording`.
    pub(crate) recording: Trace,
}

pub fn set(axes: &[usize]) -> PyResult<AxisSet> {
    match axes.iter().find(|&&a| a >= MAX_AXES) {
        Some(a) => Err(PyIndexError::new_err(format!("there is no axis {a}"))),
        None => Ok(axes.iter().copied().collect()),
    }
}

/// Axes with one value each.
pub fn axis_list(axes: &[usize], values: &[f64]) -> PyResult<AxisList> {
    set(axes)?;
    if axes.len() > MAX_AXES || values.len() != axes.len() {
        return Err(PyValueError::new_err("one value for each axis"));
    }
    Ok(AxisList::new(axes))
}

pub fn outcome(entered: Entered) -> &'static str {
    match entered {
        Entered::Yes => "entered",
        Entered::Full => "full",
        Entered::Refused => "refused",
        Entered::Discarded => "discarded",
    }
}

/// (sample, kind, axis or task, name, on, line, value)
type EventRow = (u64, &'static str, i32, &'static str, bool, u32, i64);

#[pymethods]
impl Mcu {
    #[new]
    fn new(machine: &Machine) -> Mcu {
        Mcu { kernel: Kernel::new(machine.inner.clone()), recording: Trace::default() }
    }

    /// Loads a program, of either language, into a task (0..3); startcnct starts it. ValueError where a rw_SymPas
    /// program does not fit the machine. The commands of a `Stream` are executed as they come.
    fn load(&mut self, py: Python<'_>, task: usize, program: &Bound<'_, PyAny>) -> PyResult<()> {
        let task = known_task(task)?;
        if let Ok(program) = program.cast::<crate::sympas::Program>() {
            let loaded = self.kernel.load_sap(task, program.get().inner.clone());
            return loaded.map_err(|refusal| PyValueError::new_err(refusal.to_string()));
        }
        if let Ok(stream) = program.cast::<Stream>() {
            let segments = stream.get().segments()?;
            py.detach(|| self.kernel.load_segments(task, segments));
            return Ok(());
        }
        self.kernel.load(task, program.cast::<Program>()?.get().inner.clone());
        Ok(())
    }

    fn axis_count(&self) -> usize {
        self.kernel.machine().axes.len()
    }
    /// Per axis: largest motor command in digits (32767 = 10 V), samples at full scale.
    fn motor_commands(&self) -> Vec<(f64, u64)> {
        self.kernel.command_use().map(|used| (used.peak_digits, used.saturated)).collect()
    }
    fn samples(&self) -> u64 {
        self.kernel.samples()
    }
    /// Lets up to `samples` sample intervals pass; comes back earlier when there is something to say (Chunk.stop).
    fn advance(&mut self, py: Python<'_>, samples: u64) -> PyResult<Chunk> {
        let kernel = &mut self.kernel;
        let (trace, stop) = py.detach(|| {
            let mut trace = Trace::default();
            let advanced = kernel.advance(samples, &mut trace);
            (trace, advanced.stop)
        });
        Chunk::new(py, trace, stop, standing(kernel))
    }
    fn prepare_gcode(&mut self) {
        self.kernel.prepare_gcode();
    }
    fn hold(&mut self) {
        self.kernel.hold();
    }
    fn hold_at_block_end(&mut self) {
        self.kernel.hold_at_block_end();
    }
    fn step_block(&mut self) -> bool {
        self.kernel.step_block()
    }
    fn resume(&mut self) {
        self.kernel.resume();
    }
    fn is_holding(&self) -> bool {
        self.kernel.is_holding()
    }
    fn abort(&mut self) {
        self.kernel.abort();
    }
    fn acknowledge(&mut self) {
        self.kernel.acknowledge();
    }
    /// Events since the last call.
    fn events(&mut self) -> Vec<EventRow> {
        let row = |e: motion_kernel::trace::Event| (e.sample, e.kind.name(), e.axis, e.name, e.on, e.line, e.value);
        self.kernel.events().into_iter().map(row).collect()
    }

    fn startcnct(&mut self, task: usize) -> PyResult<()> {
        self.kernel.startcnct(known_task(task)?);
        Ok(())
    }
    fn stopcnct(&mut self, task: usize) -> PyResult<()> {
        self.kernel.stopcnct(known_task(task)?);
        Ok(())
    }
    fn contcnct(&mut self, task: usize) -> PyResult<()> {
        self.kernel.contcnct(known_task(task)?);
        Ok(())
    }
    fn stepcnct(&mut self, task: usize) -> PyResult<()> {
        self.kernel.stepcnct(known_task(task)?);
        Ok(())
    }
    /// CNCTS of a task (4.3.2.10): error number and its line, state bits, source line being executed.
    fn rdcncts(&self, task: usize) -> PyResult<(u32, u32, u32, u32, u32)> {
        let status = self.kernel.task_status(known_task(task)?);
        Ok((status.errnum, status.errline, status.running, status.csrcline, status.stackfree))
    }
    /// What the tasks wrote since the last call.
    fn take_output(&mut self, task: usize) -> PyResult<String> {
        Ok(self.kernel.take_output(known_task(task)?))
    }

    /// A motion command by its spooled name (smla, smlr, smca, smcr, smha, smhr), into the spooler or in direct mode:
    /// "entered", "full", "refused" (open loop, D11) or "discarded" (ErrorReg).
    #[allow(clippy::too_many_arguments)] // the command has these parameters
    #[pyo3(signature = (kind, direct, axes, targets, vl, ac, tvl, phi, center, pcap_index=None))]
    fn motion(
        &mut self,
        kind: &str,
        direct: bool,
        axes: Vec<usize>,
        targets: Vec<f64>,
        vl: f64,
        ac: f64,
        tvl: f64,
        phi: f64,
        center: [f64; 2],
        pcap_index: Option<i32>,
    ) -> PyResult<&'static str> {
        let kind = MoveKind::ALL.into_iter().find(|k| k.name() == kind);
        let kind = kind.ok_or_else(|| PyValueError::new_err("unknown motion command"))?;
        let list = axis_list(&axes, &targets)?;
        let command =
            MotionCommand { kind, axes: &list, targets: &targets, center, phi, vl, ac, tvl, rapid: false, line: 0 };
        Ok(outcome(match pcap_index {
            _ if direct => self.kernel.direct(&command),
            Some(index) => self.kernel.spool_indexed(&command, index),
            None => self.kernel.spool(&command),
        }))
    }
    /// Jogs (ja, jr): outcome as for `motion`.
    fn jog(&mut self, axes: Vec<usize>, ways: Vec<f64>, relative: bool) -> PyResult<&'static str> {
        let list = axis_list(&axes, &ways)?;
        Ok(outcome(if relative { self.kernel.jr(&list, &ways) } else { self.kernel.ja(&list, &ways) }))
    }
    #[pyo3(signature = (axis, command, value, pcap_index=None))]
    fn ssf(&mut self, axis: usize, command: u16, value: f64, pcap_index: Option<i32>) -> PyResult<&'static str> {
        self.check(axis)?;
        Ok(outcome(match pcap_index {
            Some(index) => self.kernel.ssfi(axis, command, value, index),
            None => self.kernel.ssf(axis, command, value, 0),
        }))
    }
    fn ssms(&mut self, axes: Vec<usize>) -> PyResult<()> {
        self.kernel.ssms(set(&axes)?);
        Ok(())
    }
    fn sstps(&mut self, axes: Vec<usize>) -> PyResult<()> {
        self.kernel.sstps(set(&axes)?);
        Ok(())
    }
    fn sdels(&mut self, axes: Vec<usize>) -> PyResult<()> {
        self.kernel.sdels(set(&axes)?);
        Ok(())
    }
    fn ms(&mut self, axes: Vec<usize>) -> PyResult<()> {
        self.kernel.ms(set(&axes)?);
        Ok(())
    }
    fn js(&mut self, axes: Vec<usize>) -> PyResult<()> {
        self.kernel.js(set(&axes)?);
        Ok(())
    }
    fn cl(&mut self, axes: Vec<usize>) -> PyResult<()> {
        self.kernel.cl(set(&axes)?);
        Ok(())
    }
    fn ol(&mut self, axes: Vec<usize>) -> PyResult<()> {
        self.kernel.ol(set(&axes)?);
        Ok(())
    }
    fn rs(&mut self) {
        self.kernel.rs();
    }
    fn utrovr(&mut self, axes: Vec<usize>) -> PyResult<()> {
        self.kernel.utrovr(set(&axes)?);
        Ok(())
    }
    fn clearci99(&mut self) {
        self.kernel.ClearCI99();
    }
    fn rdmodereg(&self) -> u32 {
        self.kernel.modereg().0
    }
    fn wrmodereg(&mut self, value: u32) {
        self.kernel.set_modereg(ModeReg(value));
    }
    fn rderrorreg(&self) -> u32 {
        self.kernel.errorreg().0
    }
    fn clear_errorreg(&mut self) {
        self.kernel.clear_errorreg();
    }
    fn rdaxst(&self, axis: usize) -> PyResult<u32> {
        self.check(axis)?;
        Ok(self.kernel.axst(axis).0)
    }
    fn rdci(&self, number: usize) -> PyResult<i32> {
        Ok(self.kernel.ci(common(number)?))
    }
    fn wrci(&mut self, number: usize, value: i32) -> PyResult<()> {
        self.kernel.set_ci(common(number)?, value);
        Ok(())
    }
    fn rdcd(&self, number: usize) -> PyResult<f64> {
        Ok(self.kernel.cd(common(number)?))
    }
    fn wrcd(&mut self, number: usize, value: f64) -> PyResult<()> {
        self.kernel.set_cd(common(number)?, value);
        Ok(())
    }
    fn set_inputs(&mut self, digi: u32) {
        self.kernel.set_inputs(digi);
    }

    /// One axis as in `status`.
    fn read_axis<'py>(&self, py: Python<'py>, axis: usize) -> PyResult<Bound<'py, PyDict>> {
        self.check(axis)?;
        axis_dict(py, &self.kernel.status().axes[axis])
    }
    /// Axes of NFRAX, and LookAheadDepth.
    fn read_registers(&mut self) -> (Vec<usize>, u32) {
        let r = self.kernel.registers_mut();
        (r.nfrax.iter().collect(), r.lookahead_depth)
    }
    fn write_nfrax(&mut self, axes: Vec<usize>) -> PyResult<()> {
        self.kernel.registers_mut().nfrax = set(&axes)?;
        Ok(())
    }
    fn write_lookahead_depth(&mut self, entries: u32) {
        self.kernel.registers_mut().lookahead_depth = entries;
    }

    /// Everything a screen shows: the controller as a dict, its axes as a list of dicts.
    fn status<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let s = self.kernel.status();
        let dict = PyDict::new(py);
        dict.set_item("sample", s.sample)?;
        dict.set_item("entry", s.entry)?;
        dict.set_item("line", s.line)?;
        dict.set_item("length", s.length)?;
        dict.set_item("done", s.done)?;
        dict.set_item("rapid", s.rapid)?;
        dict.set_item("path_v", s.path_v)?;
        dict.set_item("programmed_v", s.programmed_v)?;
        dict.set_item("factor", s.factor)?;
        dict.set_item("trovr", s.trovr)?;
        dict.set_item("errorreg", s.errorreg.names().collect::<Vec<_>>())?;
        dict.set_item("holding", s.holding)?;
        dict.set_item("stands", s.stands)?;
        dict.set_item("waits", s.waits)?;
        let wait = match s.wait {
            Some(Wait::Samples(left)) => Some(("dwell", left)),
            Some(Wait::Inputs(mask)) => Some(("inputs", u64::from(mask))),
            Some(Wait::Ci99 | Wait::Ci99Bit) => Some(("host", 0)),
            Some(Wait::Axes(_)) => Some(("axes", 0)),
            None => None,
        };
        dict.set_item("wait", wait)?;
        let axes: PyResult<Vec<_>> = s.axes.iter().map(|a| axis_dict(py, a)).collect();
        dict.set_item("axes", axes?)?;
        Ok(dict)
    }
}

impl Mcu {
    pub fn check(&self, axis: usize) -> PyResult<()> {
        if axis < self.axis_count() { Ok(()) } else { Err(PyIndexError::new_err(format!("there is no axis {axis}"))) }
    }
}

fn axis_dict<'py>(py: Python<'py>, a: &motion_kernel::status::AxisSnapshot) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("axst", a.axst.names().collect::<Vec<_>>())?;
    dict.set_item("dp", a.dp)?;
    dict.set_item("rp", a.rp)?;
    dict.set_item("load", a.load)?;
    dict.set_item("dv", a.dv)?;
    dict.set_item("target", a.target)?;
    dict.set_item("mcis", a.mcis)?;
    dict.set_item("lsm", a.lsm)?;
    dict.set_item("memory", a.memory)?;
    dict.set_item("jovr", a.jovr)?;
    dict.set_item("spooler", format!("{:?}", a.spool_state))?;
    dict.set_item("digo", a.digo)?;
    Ok(dict)
}

pub fn known_task(task: usize) -> PyResult<usize> {
    if task < motion_kernel::mcu::TASKS { Ok(task) } else { Err(PyIndexError::new_err("tasks are 0 to 3")) }
}

fn common(number: usize) -> PyResult<usize> {
    if number < motion_kernel::mcu::COMMONS {
        Ok(number)
    } else {
        Err(PyIndexError::new_err("common variables are 0 to 999"))
    }
}

/// What can limit the path velocity: (number, name, English, German).
#[pyfunction]
pub fn causes() -> Vec<(u8, &'static str, &'static str, &'static str)> {
    Cause::ALL.iter().map(|&(cause, name, english, german)| (cause as u8, name, english, german)).collect()
}

/// Bit tables for Python: (number, name, text).
#[pyfunction]
pub fn register_bits(register: &str) -> PyResult<Vec<(u32, &'static str, &'static str)>> {
    match register {
        "axst" => Ok(Axst::ALL.to_vec()),
        "errorreg" => Ok(ErrorReg::ALL.to_vec()),
        "modereg" => Ok(ModeReg::ALL.to_vec()),
        "controllerflags" => Ok(ControllerFlags::ALL.to_vec()),
        "digi" => Ok(Digi::ALL.to_vec()),
        "ifs" => Ok(Ifs::ALL.to_vec()),
        _ => Err(PyValueError::new_err("axst, errorreg, modereg, controllerflags, digi or ifs")),
    }
}
