//! The controller as a whole: its state, and how emulated time passes.
//!
//! [`Mcu::advance`] is the only way time passes; commands act between samples (pcap.rs, hold.rs).

use crate::analysis::Analysis;
use crate::attention::Attention;
use crate::autocode::Program;
use crate::axes::{AxisSet, MAX_AXES};
use crate::axis::{Axis, Doing, Wait};
use crate::card::Card;
use crate::io::Io;
use crate::latch::Signals;
use crate::lookahead::Lookahead;
use crate::machine::{DriveKind, Machine};
use crate::path::Component;
use crate::position_loop::PositionLoop;
use crate::registers::{Axst, ErrorReg, ModeReg};
use crate::spooler::{BYTES_LINEAR, Move, Moves, NONE, SpoolState};
use crate::stimulus::Player;
use crate::tasks::Task;
use crate::trace::{Event, EventKind, Events, Trace};
use std::sync::Arc;

/// Common variables of tasks and PC (3.2.1).
pub const COMMONS: usize = 1000;
/// The common integer of the waits 1005, 1015 and 1025.
pub const WAIT_CI: usize = 99;
/// CNC tasks.
pub const TASKS: usize = 4;

/// Registers of the controller as a whole.
#[derive(Clone, Debug)]
pub struct Registers {
    pub modereg: ModeReg,
    pub errorreg: ErrorReg,
    /// Units of interpolation commands.
    pub units: crate::units::TrajectoryUnits,
    /// Buffered trajectory override, and the time in s for a change of it by 1.0.
    pub trovr: f64,
    pub trovrst: f64,
    /// Path acceleration, velocity and target velocity of rw_SymPas programs (TRAC also of `ms` with MS_DECEL).
    pub trac: f64,
    pub trvl: f64,
    pub trtvl: f64,
    /// What else commands of rw_SymPas take from system variables.
    pub sap: crate::sap::Parameters,
    /// Axes that do not count for the path velocity.
    pub nfrax: AxisSet,
    pub lookahead_depth: u32,
}

impl Registers {
    fn after_boot(machine: &Machine) -> Self {
        Registers {
            modereg: ModeReg(0),
            errorreg: ErrorReg(0),
            units: crate::units::TrajectoryUnits::default(),
            trovr: 1.0,
            trovrst: 0.0,
            trac: machine.gcode.trac_feed,
            trvl: 0.0,
            trtvl: 0.0,
            sap: crate::sap::Parameters::default(),
            nfrax: AxisSet::EMPTY,
            lookahead_depth: machine.controller.lookahead_depth,
        }
    }
}

/// Why [`Mcu::advance`] came back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// All samples asked for are done.
    Budget,
    /// The tasks have ended, all spoolers are empty, all axes stand (and are in position where that is asked for).
    Finished,
    /// A spooled wait for the application has begun: ssf 1000 (M00) or 1005/1015/1025 (M06). Told once per wait;
    /// [`Mcu::acknowledge`] ends it.
    Acknowledge { command: u16 },
    /// A feed hold has come to rest. Told once per hold.
    Held,
    /// A CNC task stopped with a runtime error (see [`Mcu::task_status`]).
    TaskError { task: usize },
    /// A fault stopped motion: the axis has left its contour (see its axst).
    Fault { axis: usize },
    /// The event list, or that of spooled commands, is half full: drain it and go on.
    Events,
}

/// What [`Mcu::advance`] did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Advanced {
    pub samples: u64,
    pub stop: Stop,
}

/// The point of a move on one clock: axes on the same clock ask for it only once.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PointCache {
    pub slot: u32,
    pub t: f64,
    pub v: f64,
    pub point: crate::path::Point,
}

/// Told-once flags of [`Stop`].
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Told {
    pub acknowledge: bool,
    pub held: bool,
    /// The first axis with a fault that stops motion.
    pub fault: Option<usize>,
    pub task_error: bool,
}

/// The emulated controller.
pub struct Mcu {
    pub(crate) machine: Arc<Machine>,
    /// Sample time, s.
    pub(crate) ta: f64,
    /// Samples since boot.
    pub(crate) sample: u64,
    pub(crate) axes: Vec<Axis>,
    pub(crate) loops: Vec<PositionLoop>,
    pub(crate) moves: Moves,
    pub(crate) lookahead: Lookahead,
    pub(crate) registers: Registers,
    pub(crate) card: Card,
    pub(crate) ci: Vec<i32>,
    pub(crate) cd: Vec<f64>,
    /// Digital inputs after inversion, and what they mean to the axes.
    pub(crate) digi: u32,
    pub(crate) io: Io,
    pub(crate) signals: Vec<Signals>,
    /// Drives that are there, whatever the system data say.
    pub(crate) hardware: Vec<DriveKind>,
    pub(crate) attention: Attention,
    pub(crate) attending: bool,
    pub(crate) player: Player,
    pub(crate) strobes: crate::strobes::Strobes,
    pub(crate) analysis: Analysis,
    pub(crate) resources: crate::resources::Resources,
    /// Status bits that end a job.
    pub(crate) stop_at: Axst,
    pub(crate) axis_inputs: Vec<crate::limits::AxisInputs>,
    pub(crate) tasks: [Box<Task>; TASKS],
    /// Stands in the place of a task that runs: a task that is not loaded.
    pub(crate) stand_in: Option<Box<Task>>,
    /// Contour group of the program, and the axis whose entry the trace names.
    pub(crate) group: AxisSet,
    pub(crate) leader: usize,
    /// Motion commands given by tasks so far.
    pub(crate) commands: u32,
    pub(crate) events: Events,
    /// What is spooled, if that is asked for, and the CNC task that gives commands.
    pub(crate) listing: Option<Box<crate::listing::Listing>>,
    pub(crate) commanding: u8,
    pub(crate) cache: PointCache,
    pub(crate) pending: Vec<crate::direct::Pending>,
    /// Courses of the command being spooled.
    pub(crate) components: Vec<Component>,
    pub(crate) holding: bool,
    /// The hold is at the end of a block (blocks.rs).
    pub(crate) block_hold: bool,
    pub(crate) told: Told,
    /// Samples for which all axes have been in position after the end; needed and longest wait for it.
    pub(crate) settled: u32,
    pub(crate) ended: u32,
    pub(crate) settle: bool,
    /// Waits of this kind exist, so that the sample need not look for them otherwise.
    pub(crate) waiting: bool,
}

/// Samples in position that count as settled, and the longest wait for them (s).
const SETTLED_SAMPLES: u32 = 8;
const SETTLE_LIMIT_S: f64 = 2.0;

impl Mcu {
    /// A controller after boot: loops open, MODEREG and TROVRST 0, axes at the start position of the machine.
    pub fn new(machine: Arc<Machine>) -> Mcu {
        let ta = machine.sample_time_s();
        let memory = machine.controller.spool_memory_bytes;
        let axes: Vec<Axis> = machine.axes.iter().map(|a| Axis::new(a, memory)).collect();
        let loops: Vec<PositionLoop> =
            machine.axes.iter().map(|a| PositionLoop::new(a, ta, machine.controller.clock_hz)).collect();
        let (io, signals) = (Io::new(&machine), Signals::of(&machine, &loops));
        let slots = axes.len() * (memory / BYTES_LINEAR + 2) as usize;
        let mut mcu = Mcu {
            ta,
            sample: 0,
            loops,
            axes,
            moves: Moves::with_capacity(slots),
            lookahead: Lookahead::with_capacity(slots),
            registers: Registers::after_boot(&machine),
            card: Card::new(machine.axes.len()),
            ci: vec![0; COMMONS],
            cd: vec![0.0; COMMONS],
            digi: io.active_inputs(),
            io,
            signals,
            hardware: machine.axes.iter().map(|a| a.drive).collect(),
            attention: Attention::default(),
            attending: false,
            player: Player::default(),
            strobes: crate::strobes::Strobes::for_axes(machine.axes.len()),
            analysis: Analysis::for_axes(machine.axes.len()),
            resources: crate::resources::Resources::of(&machine),
            stop_at: Axst(0),
            axis_inputs: crate::limits::AxisInputs::of(&machine),
            tasks: std::array::from_fn(|_| Box::default()),
            stand_in: Some(Box::default()),
            group: AxisSet::first(machine.axes.len()),
            leader: 0,
            commands: 0,
            events: Events::default(),
            listing: None,
            commanding: 0,
            cache: PointCache { slot: NONE, t: 0.0, v: 0.0, point: crate::path::Point::default() },
            components: Vec::with_capacity(MAX_AXES),
            pending: Vec::with_capacity(crate::direct::MOST_PENDING),
            holding: false,
            block_hold: false,
            told: Told::default(),
            settled: 0,
            ended: 0,
            settle: false,
            waiting: false,
            machine,
        };
        mcu.begin_attending();
        mcu
    }

    fn begin_attending(&mut self) {
        let of = |uses: fn(&Signals) -> bool| (0..self.axes.len()).filter(|&a| uses(&self.signals[a])).collect();
        let (index, backlash) = (of(Signals::has_index), of(|signals| signals.backlash.is_used()));
        (0..self.axes.len()).for_each(|a| self.supply(a));
        self.attend_to(|attention| (attention.index, attention.backlash) = (index, backlash));
        let machine = self.machine.clone();
        if let Some(stimulus) = &machine.stimulus {
            self.add_stimulus(stimulus);
        }
    }

    /// Takes over new system data (txbf2 of a system file): all axes begin anew with them. What `rs` keeps stays, and so
    /// do MODEREG, ErrorReg, units and the programs of the tasks, which stop.
    pub fn initialise(&mut self, machine: Arc<Machine>) {
        let mut fresh = Mcu::new(machine);
        fresh.sample = self.sample;
        std::mem::swap(&mut fresh.ci, &mut self.ci);
        std::mem::swap(&mut fresh.cd, &mut self.cd);
        std::mem::swap(&mut fresh.events, &mut self.events);
        let Registers { trac, lookahead_depth, .. } = fresh.registers;
        fresh.registers = Registers { trac, lookahead_depth, trovr: 1.0, ..self.registers.clone() };
        fresh.registers.nfrax = fresh.known(fresh.registers.nfrax);
        std::mem::swap(&mut fresh.card, &mut self.card);
        std::mem::swap(&mut fresh.hardware, &mut self.hardware);
        fresh.io.keep_outside(&self.io);
        fresh.resources.keep_outside(&mut self.resources);
        fresh.set_up_endat();
        fresh.digi = fresh.io.active_inputs();
        fresh.card.axes.resize_with(fresh.axes.len(), Default::default);
        if fresh.axes.len() == self.axes.len() {
            std::mem::swap(&mut fresh.tasks, &mut self.tasks);
            fresh.tasks.iter_mut().for_each(|t| t.stop());
            (fresh.group, fresh.leader) = (self.group, self.leader);
        }
        fresh.check_configuration();
        fresh.keep_stimulus(self);
        *self = fresh;
    }
    /// The operating system starts again (BootFile): all as after power-up, but for the drives that are there and what
    /// the logic of the interface remembers.
    pub fn reboot(&mut self) {
        let mut fresh = Mcu::new(self.machine.clone());
        std::mem::swap(&mut fresh.hardware, &mut self.hardware);
        fresh.io.keep_outside(&self.io);
        fresh.resources.keep_outside(&mut self.resources);
        fresh.set_up_endat();
        fresh.boot_interface();
        fresh.digi = fresh.io.active_inputs();
        fresh.card.epc = self.card.epc;
        *self = fresh;
    }

    pub fn machine(&self) -> &Arc<Machine> {
        &self.machine
    }
    /// Per axis, how much of the motor command was used since boot.
    pub fn command_use(&self) -> impl Iterator<Item = crate::position_loop::CommandUse> {
        self.loops.iter().map(PositionLoop::command_use)
    }
    /// Samples since boot; emulated time is this times [`Mcu::sample_time_s`].
    pub fn samples(&self) -> u64 {
        self.sample
    }
    pub fn sample_time_s(&self) -> f64 {
        self.ta
    }
    pub fn all_axes(&self) -> AxisSet {
        AxisSet::first(self.axes.len())
    }
    /// Those axes of a set that the machine has.
    pub(crate) fn known(&self, axes: AxisSet) -> AxisSet {
        AxisSet(axes.0 & self.all_axes().0)
    }

    /// Lets up to `samples` sample intervals pass and records them in `trace` (emptied first). Comes back
    /// earlier when there is something to say, see [`Stop`].
    pub fn advance(&mut self, samples: u64, trace: &mut Trace) -> Advanced {
        self.begin_trace(trace);
        trace.reserve(samples.min(1 << 20) as usize);
        for done in 0..samples {
            if let Some(stop) = self.reason_to_stop() {
                return Advanced { samples: done, stop };
            }
            self.step(trace);
        }
        Advanced { samples, stop: self.reason_to_stop().unwrap_or(Stop::Budget) }
    }

    /// Empties a trace and makes it fit: its first row is that of the next sample.
    pub fn begin_trace(&self, trace: &mut Trace) {
        trace.axes = self.axes.len();
        trace.restart(self.sample);
        trace.scan.restart(&self.resources.scanner);
    }

    /// As [`Mcu::advance`], but all samples pass, whatever happens.
    pub fn pass(&mut self, samples: u64, trace: &mut Trace) {
        self.begin_trace(trace);
        trace.reserve(samples.min(1 << 20) as usize);
        for _ in 0..samples {
            self.step(trace);
        }
    }

    /// Goes on with a recording: up to `samples` sample intervals, whatever happens; comes back behind one in which the
    /// interrupt of the PC was raised. Returns how many passed. `trace` begins with [`Mcu::begin_trace`].
    pub fn pass_to_interrupt(&mut self, samples: u64, trace: &mut Trace) -> u64 {
        let interrupts = self.card.interrupts();
        trace.reserve(samples.min(1 << 20) as usize);
        for passed in 1..=samples {
            self.step(trace);
            if self.card.interrupts() != interrupts {
                return passed;
            }
        }
        samples
    }

    /// As [`Mcu::advance`], but without recording and without stopping early.
    pub fn run(&mut self, samples: u64) {
        let mut trace = Trace::new(self.axes.len(), 1);
        for _ in 0..samples {
            trace.restart(self.sample);
            self.step(&mut trace);
        }
    }

    fn reason_to_stop(&mut self) -> Option<Stop> {
        if self.told.task_error {
            self.told.task_error = false;
            let task = self.tasks.iter().position(|t| t.has_failed()).unwrap_or(0);
            return Some(Stop::TaskError { task });
        }
        if let Some(axis) = self.told.fault.take() {
            return Some(Stop::Fault { axis });
        }
        if self.events.is_nearly_full() || self.listing.as_ref().is_some_and(|listing| listing.is_nearly_full()) {
            return Some(Stop::Events);
        }
        if self.waiting
            && !self.told.acknowledge
            && let Some(command) = self.wait_for_application()
        {
            self.told.acknowledge = true;
            return Some(Stop::Acknowledge { command });
        }
        if self.holding && !self.told.held && self.rests() {
            self.told.held = true;
            return Some(Stop::Held);
        }
        self.is_finished().then_some(Stop::Finished)
    }

    /// The command of the wait for the application that an axis is in; 1000 too while a task rests behind writeln.
    pub fn wait_for_application(&self) -> Option<u16> {
        let waits = |a: &Axis| match a.doing {
            Doing::Wait(Wait::Ci99 | Wait::Ci99Bit) => a.function.map(|f| f.command),
            _ => (a.spooler.state == SpoolState::Halted).then_some(1000),
        };
        let resting = || self.tasks.iter().any(|t| t.rests()).then_some(1000);
        self.axes.iter().find_map(waits).or_else(resting)
    }

    /// No axis travels.
    pub fn stands(&self) -> bool {
        self.axes.iter().all(|a| !a.doing.travels() && a.run_on_v == 0.0 && a.pending == 0)
    }

    /// No axis travels, waits or is about to take an entry.
    fn rests(&self) -> bool {
        let busy = |a: &Axis| matches!(a.doing, Doing::Wait(_)) || a.spooler.state == SpoolState::Running;
        self.stands() && !self.axes.iter().any(busy)
    }

    fn is_finished(&mut self) -> bool {
        let idle = !self.holding
            && self.tasks.iter().all(|t| !t.is_active() && !t.rests())
            && self.axes.iter().all(|a| a.is_drained() && a.run_on_v == 0.0);
        if !idle {
            (self.settled, self.ended) = (0, 0);
            return false;
        }
        !self.settle || self.settled >= SETTLED_SAMPLES || f64::from(self.ended) * self.ta >= SETTLE_LIMIT_S
    }

    /// Loads a program into a task (0..3); it runs after [`Mcu::startcnct`]. A running one is stopped.
    pub fn load(&mut self, task: usize, program: Arc<Program>) {
        self.group = if program.group.is_empty() { self.all_axes() } else { program.group };
        self.leader = self.group.iter().next().unwrap_or(0);
        self.tasks[task].load(program);
    }

    pub(crate) fn raise(&mut self, bits: ErrorReg) {
        let new = ErrorReg(bits.0 & !self.registers.errorreg.0);
        if new.0 == 0 {
            return;
        }
        self.registers.errorreg.set(new);
        let line = self.current_move(self.leader).map_or(0, |mv| mv.line);
        for &(number, name, _) in ErrorReg::ALL {
            if new.0 >> number & 1 == 1 {
                self.event(EventKind::ErrorReg, -1, name, true, line, i64::from(number));
            }
        }
    }

    pub(crate) fn event(&mut self, kind: EventKind, axis: i32, name: &'static str, on: bool, line: u32, value: i64) {
        self.events.push(Event { sample: self.sample, kind, axis, name, on, line, value });
    }

    /// The events since the last call, in order.
    pub fn events(&mut self) -> Vec<Event> {
        self.events.drain()
    }

    /// The move that an axis executes.
    pub fn current_move(&self, axis: usize) -> Option<&Move> {
        match self.axes[axis].doing {
            Doing::Move(slot) => Some(&self.moves[slot]),
            _ => None,
        }
    }
}
