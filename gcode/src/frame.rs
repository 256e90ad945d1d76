//! Coordinates (docs/dialect.md, section 10): program position -> machine position and back.

use std::collections::BTreeMap;

use crate::arithmetic::degrees;
use crate::group::{Point, SLOTS};

/// Which zero offset is active.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Zero {
    /// G53 without axis words: machine coordinates.
    Machine,
    /// G54..G59 as 0..5
    Work(usize),
    /// G54.1 Pn
    Extra(u32),
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    pub centre: Point,
    pub factor: Point,
}

/// G68 in the plane of two slots.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rotation {
    pub slots: [usize; 2],
    pub centre: [f64; 2],
    sin: f64,
    cos: f64,
}

impl Rotation {
    pub fn new(slots: [usize; 2], centre: [f64; 2], angle: f64) -> Self {
        let (sin, cos) = degrees(angle);
        Rotation { slots, centre, sin, cos }
    }
    fn turn(&self, p: &mut Point, sin: f64) {
        let [a, b] = self.slots;
        let (x, y) = (p[a] - self.centre[0], p[b] - self.centre[1]);
        p[a] = self.centre[0] + x * self.cos - y * sin;
        p[b] = self.centre[1] + x * sin + y * self.cos;
    }
}

/// Everything between a programmed coordinate and the machine.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    pub work: [Point; 6],
    pub extra: BTreeMap<u32, Point>,
    pub zero: Zero,
    pub g52: Point,
    pub g92: Point,
    /// The shift that G92.2 put aside.
    pub g92_kept: Point,
    pub scale: Option<Scale>,
    /// Mirror line per slot.
    pub mirror: [Option<f64>; SLOTS],
    pub rotation: Option<Rotation>,
    /// Tool length and the slot it acts on.
    pub length: Option<(usize, f64)>,
    /// From program to machine (resources 17 and 18); 1 where the axis is not mirrored.
    pub factor: Point,
    shift: Point,
    plain: bool,
}

impl Frame {
    pub fn new(work: [Point; 6], factor: Point) -> Self {
        let mut frame = Frame {
            work,
            extra: BTreeMap::new(),
            zero: Zero::Work(0),
            g52: [0.0; SLOTS],
            g92: [0.0; SLOTS],
            g92_kept: [0.0; SLOTS],
            scale: None,
            mirror: [None; SLOTS],
            rotation: None,
            length: None,
            factor,
            shift: [0.0; SLOTS],
            plain: true,
        };
        frame.refresh();
        frame
    }
    pub fn offset(&self, zero: Zero) -> Point {
        match zero {
            Zero::Machine => [0.0; SLOTS],
            Zero::Work(set) => self.work[set],
            Zero::Extra(n) => self.extra.get(&n).copied().unwrap_or([0.0; SLOTS]),
        }
    }
    pub fn set_offset(&mut self, zero: Zero, slot: usize, value: f64) {
        match zero {
            Zero::Machine => {}
            Zero::Work(set) => self.work[set][slot] = value,
            Zero::Extra(n) => self.extra.entry(n).or_insert([0.0; SLOTS])[slot] = value,
        }
    }
    /// To be called after any change.
    pub fn refresh(&mut self) {
        let zero = self.offset(self.zero);
        for slot in 0..SLOTS {
            self.shift[slot] = zero[slot] + self.factor[slot] * (self.g52[slot] + self.g92[slot]);
        }
        if let Some((slot, length)) = self.length {
            self.shift[slot] += length;
        }
        let own = self.scale.is_none() && self.rotation.is_none() && self.mirror.iter().all(Option::is_none);
        self.plain = own && self.factor == [1.0; SLOTS];
    }
    /// No scaling, mirror or rotation: every axis stands for itself.
    #[inline]
    pub fn is_plain(&self) -> bool {
        self.plain
    }
    #[inline]
    pub fn shift(&self) -> &Point {
        &self.shift
    }
    pub fn to_machine(&self, program: &Point) -> Point {
        let mut p = *program;
        if let Some(s) = &self.scale {
            for slot in 0..SLOTS {
                p[slot] = s.centre[slot] + s.factor[slot] * (p[slot] - s.centre[slot]);
            }
        }
        if let Some(r) = &self.rotation {
            r.turn(&mut p, r.sin);
        }
        for slot in 0..SLOTS {
            p[slot] = self.factor[slot] * self.mirrored(slot, p[slot]) + self.shift[slot];
        }
        p
    }
    pub fn to_program(&self, machine: &Point) -> Point {
        let mut p = *machine;
        for slot in 0..SLOTS {
            p[slot] = self.mirrored(slot, (p[slot] - self.shift[slot]) / self.factor[slot]);
        }
        if let Some(r) = &self.rotation {
            r.turn(&mut p, -r.sin);
        }
        if let Some(s) = &self.scale {
            for slot in 0..SLOTS {
                p[slot] = s.centre[slot] + (p[slot] - s.centre[slot]) / s.factor[slot];
            }
        }
        p
    }
    fn mirrored(&self, slot: usize, value: f64) -> f64 {
        self.mirror[slot].map_or(value, |m| 2.0 * m - value)
    }
    /// True if circles in that plane turn the other way; `None` if they become ellipses.
    pub fn reverses(&self, [a, b]: [usize; 2]) -> Option<bool> {
        let factor = |slot: usize| self.scale.map_or(1.0, |s| s.factor[slot]) * self.factor[slot];
        if (factor(a).abs() - factor(b).abs()).abs() > 1e-12 * factor(a).abs() {
            return None;
        }
        let flips = [factor(a) < 0.0, factor(b) < 0.0, self.mirror[a].is_some(), self.mirror[b].is_some()];
        Some(flips.iter().filter(|f| **f).count() % 2 == 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn back_and_forth_is_the_same_point(
            p in prop::array::uniform10(-100.0..100.0f64), factor in 0.1..5.0f64, angle in -400.0..400.0f64, m in -9.0..9.0f64,
        ) {
            let mut frame = Frame::new([[3.0; SLOTS]; 6], [-2.0; SLOTS]);
            frame.scale = Some(Scale { centre: [1.0; SLOTS], factor: [-factor; SLOTS] });
            frame.rotation = Some(Rotation::new([0, 1], [2.0, -5.0], angle));
            frame.mirror[1] = Some(m);
            frame.length = Some((2, 40.0));
            frame.refresh();
            let back = frame.to_program(&frame.to_machine(&p));
            prop_assert!(p.iter().zip(&back).all(|(a, b)| (a - b).abs() < 1e-9));
        }
    }
}
