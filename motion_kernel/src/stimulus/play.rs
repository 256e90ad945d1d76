//! Rules at work: what happened outside during the sample interval that has just passed.
//!
//! Inputs switch at the instant that their rule says, inside the sample; the controller sees them at its end, strobe
//! inputs latch at that instant. Faults of drives and mechanics act from the next interval on.

use super::{Action, Compare, Condition, Rule, Trigger};
use crate::mcu::Mcu;
use crate::position_loop::PositionLoop;
use crate::trace::EventKind;

/// Inputs of the base board.
const INPUTS: usize = 16;

/// Rules and their state. Nothing is allocated while they play.
#[derive(Debug, Default)]
pub(crate) struct Player {
    rules: Vec<Rule>,
    states: Vec<State>,
    bounces: [Bounce; INPUTS],
    /// Loads a sample ago, on the scale of the machine.
    before: Vec<f64>,
}

#[derive(Clone, Copy, Debug, Default)]
struct State {
    /// A rule that acts once has begun.
    done: bool,
    /// The conditions held a sample ago.
    held: bool,
    /// When delayed actions are due, s. What triggers the rule again before is ignored.
    due: Option<f64>,
    /// A `while` rule has acted and not yet undone it.
    acted: bool,
}

/// A contact that bounces: every sample another level, until that sample.
#[derive(Clone, Copy, Debug, Default)]
struct Bounce {
    until: u64,
    on: bool,
    active: bool,
}

impl Player {
    pub fn add(&mut self, rules: Vec<Rule>) {
        self.rules.extend(rules);
        self.states.resize(self.rules.len(), State::default());
    }
    pub fn begin(&mut self, loops: &[PositionLoop]) {
        self.before = loops.iter().map(PositionLoop::machine_position).collect();
    }
}

impl Mcu {
    /// Plays the rules for the last sample interval.
    pub(crate) fn play_stimulus(&mut self) {
        let mut player = std::mem::take(&mut self.player);
        self.go_on_bouncing(&mut player.bounces);
        for n in 0..player.rules.len() {
            self.play_rule(&mut player, n);
        }
        for (before, position_loop) in player.before.iter_mut().zip(&self.loops) {
            *before = position_loop.machine_position();
        }
        self.player = player;
    }

    fn play_rule(&mut self, player: &mut Player, n: usize) {
        let begin_s = self.sample as f64 * self.ta;
        let rule = &player.rules[n];
        let state = player.states[n];
        let fraction = match rule.trigger {
            Trigger::At(at_s) => {
                let now = at_s < begin_s + self.ta;
                (now && !state.done).then_some(((at_s - begin_s) / self.ta).clamp(0.0, 1.0))
            }
            trigger => {
                let holds = self.all_hold(&rule.conditions, &player.before);
                player.states[n].held = holds.is_some();
                if trigger == Trigger::While && holds.is_none() && (state.acted || state.due.is_some()) {
                    player.states[n].due = None;
                    self.undo(player, n);
                }
                holds.filter(|_| !(state.held || state.done && trigger == Trigger::When))
            }
        };
        if let Some(fraction) = fraction
            && player.states[n].due.is_none()
        {
            player.states[n].done = true;
            player.states[n].due = Some(begin_s + fraction * self.ta + player.rules[n].delay_s);
        }
        if let Some(due_s) = player.states[n].due.filter(|due_s| *due_s < begin_s + self.ta || player.is_at_once(n)) {
            player.states[n].due = None;
            player.states[n].acted = player.rules[n].trigger == Trigger::While;
            let fraction = ((due_s - begin_s) / self.ta).clamp(0.0, 1.0);
            for i in 0..player.rules[n].actions.len() {
                self.act(player.rules[n].actions[i], fraction, &mut player.bounces);
            }
        }
    }

    fn undo(&mut self, player: &mut Player, n: usize) {
        if std::mem::take(&mut player.states[n].acted) {
            for i in 0..player.rules[n].actions.len() {
                if let Some(action) = player.rules[n].actions[i].opposite() {
                    self.act(action, 1.0, &mut player.bounces);
                }
            }
        }
    }

    /// The fraction of the interval from which on all conditions hold; None: they do not.
    fn all_hold(&self, conditions: &[Condition], before: &[f64]) -> Option<f64> {
        conditions.iter().try_fold(0.0_f64, |latest, condition| Some(latest.max(self.holds(condition, before)?)))
    }
    fn holds(&self, condition: &Condition, before: &[f64]) -> Option<f64> {
        let compared = |compare: Compare, left: f64, right: f64| match compare {
            Compare::Above => left > right,
            Compare::Below => left < right,
            Compare::Equal => left == right,
        };
        let holds = match *condition {
            Condition::Position { axis, compare, value } => {
                let (was, now) = (before[axis], self.loops[axis].machine_position());
                if !compared(compare, now, value) {
                    return None;
                }
                return Some(if compared(compare, was, value) { 0.0 } else { (value - was) / (now - was) });
            }
            Condition::Input { number, on } => (self.digi >> (number - 1) & 1 == 1) == on,
            Condition::Output { number, on } => (self.rddigo() >> (number - 1) & 1 == 1) == on,
            Condition::Line { compare, value } => {
                let line = self.current_move(self.leader).map_or(0, |mv| mv.line);
                line > 0 && compared(compare, f64::from(line), value)
            }
            Condition::Ci { number, compare, value } => compared(compare, f64::from(self.ci[number]), value),
        };
        holds.then_some(0.0)
    }

    fn act(&mut self, action: Action, fraction: f64, bounces: &mut [Bounce; INPUTS]) {
        let (name, on, value) = action.told();
        let line = self.current_move(self.leader).map_or(0, |mv| mv.line);
        self.event(EventKind::Stimulus, action.axis().map_or(-1, |a| a as i32), name, on, line, value);
        match action {
            Action::Input { number, on, bounce_s } => {
                let samples = (bounce_s / self.ta).round() as u64;
                let active = samples > 0;
                bounces[number as usize - 1] = Bounce { until: self.sample + samples, on, active };
                self.set_input(number, on, fraction);
                self.pulse(number, 0.0, fraction);
            }
            Action::Pulsing { number, hz } => self.pulse(number, hz, fraction),
            Action::Blocked { axis, on } => self.block(axis, on),
            Action::EncoderCut { axis, on } => self.cut_encoder(axis, on),
            Action::DriveOff { axis, on } => self.drop_drive(axis, on),
            Action::Pushed { axis, distance } => self.push(axis, distance),
            Action::BusError => self.bus_error(),
            Action::SupplyLow { deep } => self.undervoltage(deep),
        }
    }

    fn go_on_bouncing(&mut self, bounces: &mut [Bounce; INPUTS]) {
        for (n, bounce) in bounces.iter_mut().enumerate().filter(|(_, bounce)| bounce.active) {
            bounce.active = self.sample < bounce.until;
            let away = bounce.active && (bounce.until - self.sample) % 2 == 1;
            self.set_input(n as u32 + 1, bounce.on != away, 1.0);
        }
    }
}

impl Player {
    /// Without delay, rounding does not carry an action into the next sample.
    fn is_at_once(&self, n: usize) -> bool {
        self.rules[n].delay_s == 0.0
    }
}
