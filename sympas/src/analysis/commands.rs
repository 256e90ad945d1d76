//! Commands (6.6): the forms of their arguments.

use motion_kernel::axes::MAX_AXES;
use motion_kernel::sap::code::Slot;
use motion_kernel::sap::tables::{Command, Event, Form, SystemParameter, TaskCommand, Type, command};

use super::Analyser;
use crate::ast::{self, ExprKind as Syntax, Name};
use crate::diagnostics::{Fault, Id, Phrase};
use crate::scope::{Found, Predefined, Symbol};
use crate::tree::{Action, Argument, ExprKind, Output};

/// The path parameters that may stand in the list of a command (6.6, "Systemparameter").
fn parameters(form: Form) -> &'static [SystemParameter] {
    use SystemParameter::{DTCA1, DTCA2, DTCA3, PHI, PN1, PN2, PN3, SSFP, TRAC, TRTVL, TRVL};
    match form {
        Form::Values { path: true } => &[TRAC, TRVL, TRTVL],
        Form::Circle => &[TRAC, TRVL, TRTVL, PHI],
        Form::Helix => &[TRAC, TRVL, TRTVL, PHI, DTCA1, DTCA2],
        Form::Circle3d => &[TRAC, TRVL, TRTVL, PHI, PN1, PN2, PN3, DTCA1, DTCA2, DTCA3],
        Form::SpoolFunction => &[SSFP],
        _ => &[],
    }
}

/// How many axes a form takes: fewest, most.
fn axis_count(form: Form) -> (usize, usize) {
    match form {
        Form::Nothing => (0, 0),
        Form::OneAxis => (1, 1),
        Form::Circle => (2, 2),
        Form::Circle3d => (3, 3),
        Form::Helix => (2, usize::MAX),
        Form::Axes | Form::Values { .. } | Form::SpoolFunction => (1, usize::MAX),
    }
}

/// A number of axes as messages say it.
fn axes_phrase((least, most): (usize, usize)) -> Phrase {
    match (least, most) {
        (1, 1) => Phrase::new("one axis", "eine Achse"),
        (1, _) => Phrase::new("at least one axis", "mindestens eine Achse"),
        (n, m) if n == m => Phrase::new(&format!("{n} axes"), &format!("{n} Achsen")),
        (n, _) => Phrase::new(&format!("at least {n} axes"), &format!("mindestens {n} Achsen")),
    }
}

impl Analyser<'_> {
    pub(super) fn command(&mut self, call: &ast::Call) -> Option<Action> {
        let name = call.name.text.to_ascii_lowercase();
        if let Some((command, wait)) = command(&name) {
            let arguments = self.axis_arguments(command, call)?;
            return Some(Action::Do { command, wait, arguments });
        }
        if let Some(command) = TaskCommand::by_name(&name) {
            return self.small_constant(call, 3).map(|n| Action::Task(command, n));
        }
        match name.as_str() {
            "abort" => self.check_count(call, 0).then_some(Action::Abort),
            "stop" => self.check_count(call, 0).then_some(Action::Stop),
            "azo" => self.small_constant(call, 4).map(Action::Azo),
            "enev" => self.event(call, true).map(Action::Enable),
            "disev" => self.event(call, false).map(Action::Disable),
            "wt" => {
                let fits = self.check_count(call, 1);
                let ticks = fits.then(|| self.integer(&call.arguments[0].value))??;
                Some(Action::Wait(ticks))
            }
            "wrcbi" => self.write_buffer(Type::Integer, call),
            "wrcbs" => self.write_buffer(Type::Single, call),
            "wrcbd" => self.write_buffer(Type::Double, call),
            line @ ("write" | "writeln") => self.write(call, line == "writeln"),
            _ => unreachable!("the table of special names has no '{name}'"),
        }
    }
    fn axis_arguments(&mut self, command: Command, call: &ast::Call) -> Option<Vec<Argument>> {
        let form = command.form();
        let values = !matches!(form, Form::Nothing | Form::Axes | Form::OneAxis);
        let mut list = Vec::new();
        let mut whole = true;
        for argument in &call.arguments {
            let read = match (values, &argument.name) {
                (true, Some(name)) => self.value_argument(form, call, name, &argument.value),
                (false, None) => self.axis_of(call, argument).map(Argument::Axis),
                _ => {
                    let what = if values {
                        Phrase::new("axis := value", "Achse := Wert")
                    } else {
                        Phrase::new("the name of an axis", "den Namen einer Achse")
                    };
                    let span = argument.name.as_ref().map_or(argument.value.span, |n| n.span);
                    self.report(Fault::new(Id::SP410, span).with(&call.name.text).with(what));
                    None
                }
            };
            whole &= read.is_some();
            list.extend(read);
        }
        (whole && self.check_axes(form, call, &list)).then_some(list)
    }
    fn check_axes(&mut self, form: Form, call: &ast::Call, list: &[Argument]) -> bool {
        let mut axes: Vec<Slot> = Vec::new();
        let mut given: Vec<SystemParameter> = Vec::new();
        for (argument, syntax) in list.iter().zip(&call.arguments) {
            let span = syntax.name.as_ref().map_or(syntax.value.span, |n| n.span);
            match argument {
                Argument::Axis(slot) | Argument::Value(slot, _) => {
                    if axes.len() <= MAX_AXES && axes.contains(slot) {
                        let name = syntax.name.as_ref().map_or("", |n| &n.text);
                        self.report(Fault::new(Id::SW910, span).with(name));
                    }
                    axes.push(*slot);
                }
                Argument::Parameter(parameter, _) => {
                    if given.contains(parameter) {
                        self.report(Fault::new(Id::SP414, span).with(parameter.name()));
                    }
                    given.push(*parameter);
                }
            }
        }
        if axes.len() > MAX_AXES {
            let what = Phrase::new("axes of a command", "Achsen eines Befehls");
            self.report(Fault::new(Id::SP501, call.name.span).with(what).with(MAX_AXES));
            return false;
        }
        let count = axis_count(form);
        let fits = (count.0..=count.1).contains(&axes.len());
        if !fits {
            let what =
                if count == (0, 0) { Phrase::new("no parameters", "keine Parameter") } else { axes_phrase(count) };
            self.report(Fault::new(Id::SP410, call.name.span).with(&call.name.text).with(what));
        }
        fits
    }
    /// True for an argument that is the bare name of an axis.
    pub(super) fn is_axis(&self, argument: &ast::Argument) -> bool {
        match &argument.value.kind {
            Syntax::Reference(r) if r.index.is_none() && r.qualifier.is_none() => {
                matches!(self.scopes.find(&r.name.text), Some(Found::User(Symbol::Axis(_))))
            }
            _ => false,
        }
    }
    fn axis_of(&mut self, call: &ast::Call, argument: &ast::Argument) -> Option<Slot> {
        let span = argument.value.span;
        if let Syntax::Reference(r) = &argument.value.kind {
            match self.scopes.find(&r.name.text) {
                Some(Found::User(Symbol::Axis(slot))) if r.index.is_none() && r.qualifier.is_none() => {
                    return Some(slot);
                }
                Some(Found::User(Symbol::Unknown)) => return None,
                None => {
                    self.undeclared(&r.name);
                    return None;
                }
                Some(_) => {}
            }
        }
        let what = Phrase::new("the name of an axis", "den Namen einer Achse");
        self.report(Fault::new(Id::SP410, span).with(&call.name.text).with(what));
        None
    }
    /// `axis := value` or `PHI := value`.
    fn value_argument(&mut self, form: Form, call: &ast::Call, name: &Name, value: &ast::Expr) -> Option<Argument> {
        match self.scopes.find(&name.text) {
            Some(Found::User(Symbol::Axis(slot))) => {
                let value = self.double(value)?;
                return Some(Argument::Value(slot, value));
            }
            Some(Found::Predefined(Predefined::System(parameter))) if parameters(form).contains(&parameter) => {
                let source = self.expression(value)?;
                let value = self.assign(parameter.kind(), source, value.span)?;
                return Some(Argument::Parameter(parameter, value));
            }
            Some(Found::User(Symbol::Unknown)) => {}
            None => self.undeclared(name),
            Some(_) => self.report(Fault::new(Id::SP411, name.span).with(&name.text).with(&call.name.text)),
        }
        self.expression(value);
        None
    }
    /// An Integer constant from 0 to `most` as the only argument.
    fn small_constant(&mut self, call: &ast::Call, most: u8) -> Option<u8> {
        if !self.check_count(call, 1) {
            return None;
        }
        let argument = &call.arguments[0].value;
        let value = self.expression(argument)?;
        if let (ExprKind::Literal(bits), Type::Integer) = (&value.kind, value.of)
            && *bits <= u64::from(most)
        {
            return Some(*bits as u8);
        }
        let fault = Fault::new(Id::SP412, argument.span).with(&call.name.text).with(format!("0..{most}"));
        self.report(fault);
        None
    }
    fn event(&mut self, call: &ast::Call, needs_handler: bool) -> Option<Event> {
        if !self.check_count(call, 1) {
            return None;
        }
        let argument = &call.arguments[0].value;
        if let Syntax::Reference(r) = &argument.kind {
            let event = Event::ALL.iter().copied().find(|e| e.name() == &*r.name.text);
            let found = self.scopes.find(&r.name.text);
            match (event, found) {
                (Some(event), Some(Found::User(Symbol::Routine(_)))) => return Some(event),
                (Some(event), Some(Found::Predefined(_))) => {
                    if !needs_handler {
                        return Some(event);
                    }
                    self.report(Fault::new(Id::SW913, argument.span).with(event.name()));
                    return Some(event);
                }
                _ => {}
            }
        }
        self.report(Fault::new(Id::SP413, argument.span).with(&call.name.text));
        None
    }
    fn write_buffer(&mut self, of: Type, call: &ast::Call) -> Option<Action> {
        let offset = self.offset(of, call, 2);
        if call.arguments.len() != 2 {
            return None;
        }
        let argument = &call.arguments[1].value;
        let source = self.expression(argument)?;
        let value = self.assign(of, source, argument.span)?;
        Some(Action::WriteBuffer(of, offset?, value))
    }
    fn write(&mut self, call: &ast::Call, line: bool) -> Option<Action> {
        if !self.check_count(call, call.arguments.len()) {
            return None;
        }
        let mut outputs = Vec::new();
        let mut whole = true;
        for argument in &call.arguments {
            let output = match &argument.value.kind {
                Syntax::Text(text) => Some(Output::Text(text.to_string())),
                _ => self.expression(&argument.value).map(Output::Value),
            };
            whole &= output.is_some();
            outputs.extend(output);
        }
        whole.then_some(Action::Write { outputs, line })
    }
}
