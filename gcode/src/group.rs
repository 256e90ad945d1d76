//! The axes of the contour group, by slot (position in the group) and by address letter.

use motion_kernel::axes::{AxisList, AxisSet};
use motion_kernel::machine::{AxisKind, Machine};

use crate::block::letter_index;

/// Address letters of axes (X Y Z A B C U V W) and the spindle axis.
pub const SLOTS: usize = 10;

/// One value per slot of the group; mm or degrees.
pub type Point = [f64; SLOTS];

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroupAxis {
    /// Index in the machine.
    pub axis: usize,
    pub letter: u8,
    pub rotary: bool,
    pub rapid: f64,
    pub limits: Option<(f64, f64)>,
    pub reference: f64,
    /// Path length per axis unit (design D7): 1, or effradius * pi / 180 for rotary axes.
    pub metric: f64,
    pub effradius: f64,
    /// Cylinder mode (G07.1): the axis counts as a linear one of radius times angle.
    pub on_surface: bool,
    /// Counts for the path length (no NFRAX axis).
    pub counts: bool,
    /// G00 takes the short way.
    pub modulo: bool,
}

#[derive(Clone, Debug, PartialEq)]
pub struct ContourGroup {
    pub axes: Vec<GroupAxis>,
    pub start: Point,
    /// Slot of the axis that cuts threads; it has no letter.
    pub spindle: Option<usize>,
    slot: [Option<u8>; 26],
}

impl ContourGroup {
    pub fn new(machine: &Machine) -> Self {
        let mut group = ContourGroup { axes: Vec::new(), start: [0.0; SLOTS], spindle: None, slot: [None; 26] };
        for (index, axis) in machine.axes.iter().enumerate() {
            let Some(letter) = axis.letter.filter(|l| "XYZABCUVW".contains(*l)) else { continue };
            group.slot[letter_index(letter as u8)] = Some(group.axes.len() as u8);
            group.push(machine, index, letter as u8);
        }
        if let Some(index) = machine.gcode.spindle.axis.filter(|_| !group.is_empty()) {
            group.spindle = Some(group.axes.len());
            group.push(machine, index, b'S');
        }
        group
    }
    /// The axes in the order of their slots, as commands list them.
    pub fn axis_list(&self) -> AxisList {
        AxisList::new(&self.axes.iter().map(|a| a.axis).collect::<Vec<_>>())
    }
    fn push(&mut self, machine: &Machine, index: usize, letter: u8) {
        let axis = &machine.axes[index];
        let rotary = axis.kind == AxisKind::Rotary;
        self.start[self.axes.len()] = axis.start;
        self.axes.push(GroupAxis {
            axis: index,
            letter,
            rotary,
            rapid: axis.rapid,
            limits: axis.limits.map(|l| (l.left, l.right)),
            reference: axis.reference,
            metric: if rotary { axis.effradius.to_radians() } else { 1.0 },
            effradius: axis.effradius,
            on_surface: false,
            counts: !machine.gcode.nfrax.contains(&index),
            modulo: rotary && axis.modulo,
        });
    }
    /// Bits of the slots that programs name by a letter.
    pub fn lettered(&self) -> u32 {
        (1 << self.spindle.unwrap_or(self.axes.len())) - 1
    }
    pub fn len(&self) -> usize {
        self.axes.len()
    }
    pub fn is_empty(&self) -> bool {
        self.axes.is_empty()
    }
    #[inline]
    pub fn slot(&self, letter: u8) -> Option<usize> {
        self.slot[letter_index(letter)].map(usize::from)
    }
    /// Another effective radius of a rotary axis, mm; `on_surface`: as cylinder mode sets it.
    pub fn set_radius(&mut self, slot: usize, radius: f64, on_surface: bool) {
        let axis = &mut self.axes[slot];
        (axis.effradius, axis.metric, axis.on_surface) = (radius, radius.to_radians(), on_surface);
    }
    pub fn set(&self) -> AxisSet {
        self.axes.iter().map(|a| a.axis).collect()
    }
    /// Rapid path speed such that no axis exceeds its rapid limit.
    pub fn rapid_speed(&self, from: &Point, to: &Point, length: f64) -> f64 {
        let speeds = self.axes.iter().enumerate().filter_map(|(slot, axis)| {
            let d = (to[slot] - from[slot]).abs();
            (d > 0.0).then(|| axis.rapid * length / d)
        });
        speeds.fold(f64::INFINITY, f64::min)
    }
    /// Path length of a straight move (design D7), without the NFRAX axes unless nothing else moves.
    pub fn distance(&self, from: &Point, to: &Point) -> f64 {
        let (mut feed, mut rest) = (0.0, 0.0);
        for (axis, (from, to)) in self.axes.iter().zip(from.iter().zip(to)) {
            let square = ((to - from) * axis.metric).powi(2);
            *(if axis.counts { &mut feed } else { &mut rest }) += square;
        }
        if feed > 0.0 { feed.sqrt() } else { rest.sqrt() }
    }
}
