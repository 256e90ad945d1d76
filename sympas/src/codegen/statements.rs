//! Statements and commands.

use motion_kernel::sap::code::Instr;
use motion_kernel::sap::program::Operand;
use motion_kernel::sap::tables::Command;

use super::Generator;
use super::expressions::calls;
use crate::tree::{Action, Argument, Expr, ExprKind, Output, Place, Statement, StatementKind};

impl Generator {
    pub(super) fn statements(&mut self, list: &[Statement]) {
        list.iter().for_each(|s| self.statement(s));
    }
    fn statement(&mut self, statement: &Statement) {
        for label in &statement.labels {
            self.frame.labels[*label as usize] = Some(self.here());
        }
        let mark = self.frame.top;
        self.at(statement.span);
        match &statement.kind {
            StatementKind::Empty => {}
            StatementKind::Compound(list) => self.statements(list),
            StatementKind::Repeat { body, condition, until } => {
                let start = self.here();
                self.statements(body);
                self.at(*until);
                self.begin();
                let again = self.unless(condition);
                self.patch(again, start);
            }
            _ => {
                self.begin();
                self.kind(statement);
            }
        }
        self.frame.top = mark;
    }
    /// A statement begins on the present line.
    fn begin(&mut self) {
        self.emit(Instr::Statement(self.frame.place.1));
    }
    fn kind(&mut self, statement: &Statement) {
        match &statement.kind {
            StatementKind::Assign(place, value) => self.assign(place, value),
            StatementKind::Call(number, arguments) => {
                self.call(*number, arguments);
            }
            StatementKind::Act(action) => self.act(action),
            StatementKind::Goto(label) => {
                let jump = self.emit(Instr::Jump(0));
                self.frame.jumps.push((jump, *label));
            }
            StatementKind::If { condition, then, otherwise } => {
                let no = self.unless(condition);
                self.statement(then);
                if let Some(other) = otherwise {
                    let over = self.emit(Instr::Jump(0));
                    self.patch_here(no);
                    self.statement(other);
                    self.patch_here(over);
                } else {
                    self.patch_here(no);
                }
            }
            StatementKind::While { condition, body } => {
                let head = self.here() - 1; // its Statement
                let out = self.unless(condition);
                self.statement(body);
                self.at(statement.span);
                self.emit(Instr::Jump(head));
                self.patch_here(out);
            }
            StatementKind::For { .. } => self.for_statement(statement),
            StatementKind::Empty | StatementKind::Compound(_) | StatementKind::Repeat { .. } => {}
        }
    }
    fn for_statement(&mut self, statement: &Statement) {
        let StatementKind::For { variable, bound, from, to, down, body } = &statement.kind else { return };
        let mark = self.frame.top;
        if matches!(to.kind, ExprKind::Literal(_)) {
            self.into(from, *variable);
            self.into(to, *bound);
        } else {
            let first = self.stable(from, true); // `to` may read or change the variable
            self.into(to, *bound);
            self.emit(Instr::Copy(*variable, first));
        }
        self.frame.top = mark;
        self.emit(if *down { Instr::IfLeI(*bound, *variable) } else { Instr::IfLeI(*variable, *bound) });
        let out = self.emit(Instr::Jump(0));
        let start = self.here();
        self.statement(body);
        self.at(statement.span);
        if !self.program.code[start as usize..].iter().any(|i| matches!(i, Instr::Statement(_))) {
            self.begin(); // an empty loop takes its share of time too
        }
        self.emit(if *down { Instr::NextDown(*variable, *bound) } else { Instr::NextUp(*variable, *bound) });
        self.emit(Instr::Jump(start));
        self.patch_here(out);
    }
    fn assign(&mut self, place: &Place, value: &Expr) {
        let index = match place {
            Place::SysVar(_, index) | Place::AxisVar(_, _, index) => Some(self.stable(index, calls(value))),
            _ => None,
        };
        if let Place::Slot(slot) = place {
            return self.into(value, *slot);
        }
        let from = self.operand(value);
        let instr = match (place, index) {
            (Place::System(parameter), _) => Instr::WriteSystem(*parameter, from),
            (Place::Ci(number), _) => Instr::WriteCi(from, *number),
            (Place::Cd(number), _) => Instr::WriteCd(from, *number),
            (Place::Axis(qualifier, axis), _) => Instr::WriteAxis(*qualifier, *axis, from),
            (Place::Bit(qualifier, bit, axis), _) => Instr::WriteAxisBit(*qualifier, *bit, *axis, from),
            (Place::SysVar(which, _), Some(index)) => Instr::WriteSysVar(*which, index, from),
            (Place::AxisVar(which, axis, _), Some(index)) => Instr::WriteAxisVar(*which, *axis, index, from),
            (Place::Slot(slot), _) => Instr::Copy(*slot, from),
            (Place::SysVar(..) | Place::AxisVar(..), None) => unreachable!("an indexed place has an index"),
        };
        self.emit(instr);
    }
    fn act(&mut self, action: &Action) {
        match action {
            Action::Do { command, wait, arguments } => self.axis_command(*command, *wait, arguments),
            Action::Task(command, number) => self.just(Instr::Task(*command, *number)),
            Action::Azo(set) => self.just(Instr::Azo(*set)),
            Action::Enable(event) => self.just(Instr::Enable(*event)),
            Action::Disable(event) => self.just(Instr::Disable(*event)),
            Action::Stop => self.just(Instr::Stop),
            Action::Abort => self.just(Instr::Abort),
            Action::Wait(ticks) => {
                let slot = self.operand(ticks);
                self.just(Instr::Wait(slot));
            }
            Action::WriteBuffer(of, offset, value) => {
                let offset = self.stable(offset, calls(value));
                let from = self.operand(value);
                self.just(Instr::WriteBuffer(*of, offset, from));
            }
            Action::Write { outputs, line } => {
                outputs.iter().for_each(|o| self.output(o));
                if *line {
                    self.just(Instr::Writeln);
                }
            }
        }
    }
    fn just(&mut self, instr: Instr) {
        self.emit(instr);
    }
    fn output(&mut self, output: &Output) {
        match output {
            Output::Text(text) => {
                let number = self.text(text);
                self.just(Instr::WriteText(number));
            }
            Output::Value(expr) => {
                let mark = self.frame.top;
                let slot = self.operand(expr);
                self.just(Instr::WriteValue(expr.of, slot));
                self.frame.top = mark;
            }
        }
    }
    fn axis_command(&mut self, command: Command, wait: bool, arguments: &[Argument]) {
        let called = |a: &Argument| match a {
            Argument::Axis(_) => false,
            Argument::Value(_, e) | Argument::Parameter(_, e) => calls(e),
        };
        let last_call = arguments.iter().rposition(called).unwrap_or(0);
        let mut operands = Vec::new();
        for (n, argument) in arguments.iter().enumerate() {
            match argument {
                Argument::Axis(axis) => operands.push(Operand { axis: *axis, value: *axis }),
                Argument::Value(axis, value) => {
                    let value = self.stable(value, last_call > n);
                    operands.push(Operand { axis: *axis, value });
                }
                Argument::Parameter(parameter, value) => {
                    let mark = self.frame.top;
                    let slot = self.operand(value);
                    self.just(Instr::WriteSystem(*parameter, slot));
                    self.frame.top = mark;
                }
            }
        }
        let list = self.list(operands);
        self.just(Instr::Do(command, list));
        if wait {
            self.just(Instr::AwaitEnd(command == Command::Ssms, list));
        }
    }
}
