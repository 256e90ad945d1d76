//! Read-only system variables (docs/dialect.md, section 15.1).

use crate::frame::Zero;
use crate::translate::Translator;

/// Axes 1 to 9 of the numbering.
const LETTERS: &[u8; 9] = b"XYZABCUVW";

/// The value of `#n` in the unit of the program; `None`: there is no such variable.
pub(crate) fn variable(t: &Translator, n: u32) -> Option<f64> {
    let (state, frame) = (&t.state, &t.state.frame);
    let axis = |first: u32, of: &dyn Fn(usize) -> f64| axis(t, n - first, of);
    match n {
        3001 => Some(0.0),
        4001..=4016 => state.group_code(n - 4000),
        4109 => Some(state.modal.feed.map_or(0.0, |f| f.raw)),
        4119 => Some(state.modal.speed.unwrap_or(0.0)),
        4120 => Some(f64::from(state.modal.tool)),
        5001..=5009 => axis(5001, &|slot| state.program[slot]),
        5021..=5029 => axis(5021, &|slot| state.machine[slot]),
        5041..=5049 => axis(5041, &|slot| state.program[slot]),
        5221..=5329 if (1..=9).contains(&(n % 20)) => {
            let set = (n - 5221) / 20;
            axis(5221 + 20 * set, &|slot| frame.work[set as usize][slot])
        }
        _ if t.dialect.oword => linuxcnc(t, n),
        _ => None,
    }
}

/// What LinuxCNC numbers in its own way.
fn linuxcnc(t: &Translator, n: u32) -> Option<f64> {
    let (state, frame) = (&t.state, &t.state.frame);
    let axis = |first: u32, of: &dyn Fn(usize) -> f64| axis(t, n - first, of);
    match n {
        5211..=5219 => axis(5211, &|slot| frame.g92[slot]),
        5220 => match frame.zero {
            Zero::Work(set) => Some(set as f64 + 1.0),
            _ => None,
        },
        5400 => Some(f64::from(state.modal.in_spindle)),
        5401..=5409 => axis(5401, &|slot| frame.length.filter(|l| l.0 == slot).map_or(0.0, |l| l.1)),
        5420..=5428 => axis(5420, &|slot| state.program[slot]),
        _ => None,
    }
}

fn axis(t: &Translator, number: u32, of: &dyn Fn(usize) -> f64) -> Option<f64> {
    let slot = t.group.slot(*LETTERS.get(number as usize)?)?;
    let unit = if t.group.axes[slot].rotary { 1.0 } else { t.state.modal.unit() };
    Some(of(slot) / unit)
}
