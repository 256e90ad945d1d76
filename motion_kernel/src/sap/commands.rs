//! The commands of rw_SymPas for axes (6.6), each by the function that PCAP has for it (chapter 4.4).

use super::code::Instr;
use super::processor::{Pause, Processor};
use super::program::{Operand, Program};
use super::tables::{Command, Form};
use crate::analysis::LatchInfos;
use crate::autocode::MoveKind;
use crate::axes::{AxisList, AxisSet, MAX_AXES};
use crate::circle_3d::Circle3d;
use crate::functions::Entered;
use crate::mcu::Mcu;
use crate::motion::MotionCommand;
use crate::registers::ModeReg;

/// Axes and values of a command.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arguments {
    list: AxisList,
    values: [f64; MAX_AXES],
}

impl Processor {
    /// A command, or the wait for its end, with its arguments as they are when it is called: it waits for the axes that
    /// take part (6.5), whatever handlers make of AXIS variables meanwhile.
    pub(super) fn commanded(&mut self, instr: Instr, program: &Program, mcu: &mut Mcu) -> Result<(), Pause> {
        let (Instr::Do(_, list) | Instr::AwaitEnd(_, list)) = instr else {
            return Err(Pause::Error(crate::tasks::runtime_error::BAD_CODE));
        };
        let arguments = match self.given {
            Some(given) => given,
            None => self.arguments(&program.lists[list as usize], mcu)?,
        };
        self.given = Some(arguments);
        let behind = self.pc;
        let result = match instr {
            Instr::Do(command, _) => self.command(command, &arguments, mcu),
            Instr::AwaitEnd(spooler, _) => self.await_end(spooler, arguments.list.set(), mcu),
            _ => Ok(()),
        };
        if self.pc == behind {
            self.given = None; // it does not come again
        }
        result
    }

    fn command(&mut self, command: Command, arguments: &Arguments, mcu: &mut Mcu) -> Result<(), Pause> {
        let Arguments { list, values } = arguments;
        let (axes, values) = (list.set(), &values[..list.len()]);
        match command.form() {
            Form::Axes | Form::OneAxis => for_axes(command, list, axes, mcu),
            Form::Nothing => {
                mcu.rs();
                return Err(Pause::Stop); // rs stops all tasks, this one too
            }
            Form::Values { path: false } => return self.with_values(command, list, values, mcu),
            Form::Circle3d => return self.circle_3d(command, list, values, mcu),
            Form::SpoolFunction => return self.spool_function(list, values, mcu),
            _ => return self.motion(command, list, values, mcu),
        }
        Ok(())
    }

    fn arguments(&self, operands: &[Operand], mcu: &Mcu) -> Result<Arguments, Pause> {
        let mut axes = [0; MAX_AXES];
        let mut values = [0.0; MAX_AXES];
        if operands.len() > MAX_AXES {
            return Err(Pause::Error(crate::tasks::runtime_error::BAD_ARGUMENT));
        }
        for (n, operand) in operands.iter().enumerate() {
            axes[n] = self.axis(operand.axis, mcu)?;
            values[n] = self.real(operand.value);
        }
        Ok(Arguments { list: AxisList::new(&axes[..operands.len()]), values })
    }

    fn with_values(&mut self, command: Command, list: &AxisList, values: &[f64], mcu: &mut Mcu) -> Result<(), Pause> {
        let entered = match command {
            Command::Ja => mcu.ja(list, values),
            Command::Jr => mcu.jr(list, values),
            Command::Jhi => mcu.jhi(list, values),
            _ => {
                for (axis, &value) in list.iter().zip(values) {
                    match command {
                        Command::Shp => mcu.shp(axis, value),
                        Command::Szpa => mcu.szpa(axis, value),
                        _ => mcu.szpr(axis, value),
                    };
                }
                Entered::Yes
            }
        };
        self.again_when(entered == Entered::Full)
    }

    /// A 3-D circle, direct or spooled.
    fn circle_3d(&mut self, command: Command, axes: &AxisList, values: &[f64], mcu: &mut Mcu) -> Result<(), Pause> {
        let registers = &mcu.registers;
        let circle = Circle3d {
            axes,
            relative: matches!(command, Command::Mcr3d | Command::Smcr3d),
            center: std::array::from_fn(|i| values.get(i).copied().unwrap_or(0.0)),
            normal: registers.sap.pn,
            phi: registers.sap.phi,
            vl: registers.trvl,
            ac: registers.trac,
            tvl: registers.trtvl,
            line: self.executed_place(),
        };
        if matches!(command, Command::Mca3d | Command::Mcr3d) {
            let entered = mcu.direct_3d(&circle);
            return self.again_when(entered == Entered::Full);
        }
        self.spooled = self.spooled.union(axes.set());
        mcu.spool_3d(&circle);
        Ok(())
    }

    /// A move, direct or spooled. Values that are not in the list come from the system parameters (errata Q13).
    fn motion(&mut self, command: Command, list: &AxisList, values: &[f64], mcu: &mut Mcu) -> Result<(), Pause> {
        let Some((kind, spooled)) = kind_of(command) else {
            return Err(Pause::Error(crate::tasks::runtime_error::BAD_COMMAND));
        };
        let registers = &mcu.registers;
        let path = &registers.sap;
        let by_target = !kind.is_linear() && path.phi.abs() <= 1e-100;
        let center =
            if by_target { [path.dtca[0], path.dtca[1]] } else { [values[0], values.get(1).copied().unwrap_or(0.0)] };
        let motion = MotionCommand {
            kind,
            axes: list,
            targets: values,
            center: if kind.is_linear() { [0.0; 2] } else { center },
            phi: if kind.is_linear() { 0.0 } else { path.phi },
            vl: registers.trvl,
            ac: registers.trac,
            tvl: registers.trtvl,
            rapid: false,
            line: self.executed_place(),
        };
        if !spooled {
            let entered = mcu.direct(&motion);
            return self.again_when(entered == Entered::Full);
        }
        self.spooled = self.spooled.union(list.set());
        if mcu.registers.modereg.has(ModeReg::AutoSpool) && !mcu.has_room(kind, list) {
            mcu.start_direct(list.set()); // a full spooler starts by itself
            return self.wait_here();
        }
        mcu.spool(&motion);
        Ok(())
    }

    fn spool_function(&mut self, list: &AxisList, values: &[f64], mcu: &mut Mcu) -> Result<(), Pause> {
        self.spooled = self.spooled.union(list.set());
        let code = mcu.registers.sap.ssfp;
        let line = self.executed_place();
        for (axis, &value) in list.iter().zip(values) {
            // what is no code at all is refused like an unknown one
            mcu.ssf(axis, u16::try_from(code).unwrap_or(u16::MAX), value, line);
        }
        Ok(())
    }

    /// More direct commands wait for their effect than the controller holds: this one comes again in the next sample.
    /// All else goes on; what was refused stands in ErrorReg and axst.
    fn again_when(&mut self, full: bool) -> Result<(), Pause> {
        if full { self.wait_here() } else { Ok(()) }
    }
}

fn for_axes(command: Command, list: &AxisList, axes: AxisSet, mcu: &mut Mcu) {
    match command {
        Command::Cl => mcu.cl(axes),
        Command::Clv => mcu.clv(axes),
        Command::Jhl => _ = mcu.jhl(list),
        Command::Jhr => _ = mcu.jhr(list),
        Command::Js => mcu.js(axes),
        Command::Lpr | Command::Lprs => {
            let sap = &mcu.registers.sap;
            let infos = LatchInfos { san: 0, lst: sap.lst, let_: sap.let_ };
            _ = mcu.lprs(axes, &infos);
        }
        Command::Ms => mcu.ms(axes),
        Command::Ol => mcu.ol(axes),
        Command::Ra => mcu.ra(axes),
        Command::Rptodp => mcu.RPtoDP(axes),
        Command::Ssms => mcu.ssms(axes),
        Command::Uf => axes.iter().for_each(|a| mcu.take_written_filter(a)),
        Command::Utrovr => mcu.utrovr(axes),
        _ => {}
    }
}

/// The motion command, and whether it goes to the spoolers.
fn kind_of(command: Command) -> Option<(MoveKind, bool)> {
    Some(match command {
        Command::Mla => (MoveKind::Smla, false),
        Command::Mlr => (MoveKind::Smlr, false),
        Command::Mca => (MoveKind::Smca, false),
        Command::Mcr => (MoveKind::Smcr, false),
        Command::Mha => (MoveKind::Smha, false),
        Command::Mhr => (MoveKind::Smhr, false),
        Command::Smla => (MoveKind::Smla, true),
        Command::Smlr => (MoveKind::Smlr, true),
        Command::Smca => (MoveKind::Smca, true),
        Command::Smcr => (MoveKind::Smcr, true),
        Command::Smha => (MoveKind::Smha, true),
        Command::Smhr => (MoveKind::Smhr, true),
        _ => return None,
    })
}
