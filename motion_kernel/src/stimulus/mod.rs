//! The world outside of the controller: a list of rules that switch inputs and play faults, so that a run with them is
//! as repeatable as one without. `docs/stimulus.md` explains the text to people.
//!
//! ```text
//! at 2.5 s: input 3 on
//! when X > 100: X blocked
//! while X < -50: input 5 on bouncing 4 ms
//! ```

mod parse;
mod play;

pub use parse::{ST_IDS, WORDS};
pub(crate) use play::Player;

use crate::axes::AxisSet;
use crate::mcu::Mcu;

/// What starts a rule.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Trigger {
    /// A machine time, s.
    At(f64),
    /// The first time that the conditions hold.
    When,
    /// Every time that they begin to hold.
    Whenever,
    /// As long as they hold; then the opposite.
    While,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compare {
    Above,
    Below,
    Equal,
}

/// What must hold. Positions are those of the load on the scale of the machine (coordinates at boot), axis units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Condition {
    Position {
        axis: usize,
        compare: Compare,
        value: f64,
    },
    Input {
        number: u32,
        on: bool,
    },
    Output {
        number: u32,
        on: bool,
    },
    /// Source line of the motion command being executed.
    Line {
        compare: Compare,
        value: f64,
    },
    Ci {
        number: usize,
        compare: Compare,
        value: f64,
    },
}

/// What a rule does. `on` is the way the words say it; a `while` rule ends with the opposite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Action {
    /// An input becomes active or inactive; before, its contact bounces for a time in s.
    Input {
        number: u32,
        on: bool,
        bounce_s: f64,
    },
    /// A strobe input becomes active for an instant, that many times a second.
    Pulsing {
        number: u32,
        hz: f64,
    },
    Blocked {
        axis: usize,
        on: bool,
    },
    EncoderCut {
        axis: usize,
        on: bool,
    },
    DriveOff {
        axis: usize,
        on: bool,
    },
    /// The load is moved by a distance.
    Pushed {
        axis: usize,
        distance: f64,
    },
    BusError,
    /// The supply falls below 4.75 V, or even 2.85 V.
    SupplyLow {
        deep: bool,
    },
}

#[derive(Clone, Debug, PartialEq)]
pub struct Rule {
    pub trigger: Trigger,
    pub conditions: Vec<Condition>,
    /// Time from the trigger to the actions.
    pub delay_s: f64,
    pub actions: Vec<Action>,
}

/// The rules of a text, for the axes of one machine.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stimulus {
    pub text: String,
    pub rules: Vec<Rule>,
}

impl Mcu {
    /// From now on these rules act too; their times count from boot.
    pub fn add_stimulus(&mut self, stimulus: &Stimulus) {
        let known = |rule: &&Rule| rule.axes().without(self.all_axes()).is_empty();
        let rules: Vec<Rule> = stimulus.rules.iter().filter(known).cloned().collect();
        let any = !rules.is_empty();
        self.player.add(rules);
        self.player.begin(&self.loops);
        self.attend_to(|attention| attention.stimulus |= any);
    }
}

impl Mcu {
    /// New system data do not change the world outside, as far as the axes are the same.
    pub(crate) fn keep_stimulus(&mut self, before: &mut Mcu) {
        if self.axes.len() == before.axes.len() {
            std::mem::swap(&mut self.player, &mut before.player);
            std::mem::swap(&mut self.strobes, &mut before.strobes);
            self.look_for_strobes();
            self.attend_to(|attention| attention.stimulus = before.attention.stimulus);
        }
    }
}

impl Rule {
    fn axes(&self) -> AxisSet {
        let of_condition = |condition: &Condition| match condition {
            Condition::Position { axis, .. } => Some(*axis),
            _ => None,
        };
        let of_action = |action: &Action| action.axis();
        self.conditions.iter().filter_map(of_condition).chain(self.actions.iter().filter_map(of_action)).collect()
    }
}

impl Action {
    /// The axis that it is about.
    pub fn axis(&self) -> Option<usize> {
        match *self {
            Action::Blocked { axis, .. }
            | Action::EncoderCut { axis, .. }
            | Action::DriveOff { axis, .. }
            | Action::Pushed { axis, .. } => Some(axis),
            _ => None,
        }
    }
    /// What undoes it.
    fn opposite(self) -> Option<Action> {
        match self {
            Action::Input { number, on, bounce_s } => Some(Action::Input { number, on: !on, bounce_s }),
            Action::Pulsing { number, .. } => Some(Action::Input { number, on: false, bounce_s: 0.0 }),
            Action::Blocked { axis, on } => Some(Action::Blocked { axis, on: !on }),
            Action::EncoderCut { axis, on } => Some(Action::EncoderCut { axis, on: !on }),
            Action::DriveOff { axis, on } => Some(Action::DriveOff { axis, on: !on }),
            _ => None,
        }
    }
    /// Name, state and number for an event.
    fn told(self) -> (&'static str, bool, i64) {
        match self {
            Action::Input { number, on, .. } => ("input", on, i64::from(number)),
            Action::Pulsing { number, .. } => ("pulsing", true, i64::from(number)),
            Action::Blocked { on, .. } => ("blocked", on, 0),
            Action::EncoderCut { on, .. } => ("encoder_cut", on, 0),
            Action::DriveOff { on, .. } => ("drive_off", on, 0),
            Action::Pushed { .. } => ("pushed", true, 0),
            Action::BusError => ("bus_error", true, 0),
            Action::SupplyLow { .. } => ("supply_low", true, 0),
        }
    }
}
