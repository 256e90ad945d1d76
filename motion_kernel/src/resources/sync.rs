//! SyncMode, the flying saw (chapter 3): the profile clock of a slave runs with the way of its master.
//!
//! Armed, the clock of the slave stands. Once the master has passed start position + offset in the direction of its
//! nominal velocity, the clock shows way / nominal velocity; a master that comes back does not turn it back.

use super::table::{Device, Place, Range, done};
use super::{Code, Type};
use crate::axes::AxisSet;
use crate::axis::Override;
use crate::mcu::Mcu;

/// Guiding quantities (SYNC SOURCE).
const RP: i32 = 1;
const AUX: i32 = 2;

/// Override of a clock that stands: a direct command divides by it to know the velocity at full clock.
const STANDING: f64 = 1e-12;

/// Synchronisation of one axis as a slave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sync {
    pub master: usize,
    pub source: i32,
    pub start: f64,
    pub offset: f64,
    pub velocity: f64,
    /// Counts per user unit, and counts per count of aux.
    pub gear_factor: f64,
    pub aux_factor: f64,
    /// Way of the master behind the trigger that the clock of the slave has used up.
    way: f64,
    /// Where the master was a sample ago: the trigger is a crossing.
    before: f64,
    triggered: bool,
    moved: bool,
    /// Overrides to return to.
    saved: (Override, bool),
}

impl Default for Sync {
    fn default() -> Self {
        Sync {
            master: 0,
            source: 0,
            start: 0.0,
            offset: 0.0,
            velocity: 0.0,
            gear_factor: 1.0,
            aux_factor: 1.0,
            way: 0.0,
            before: 0.0,
            triggered: false,
            moved: false,
            saved: (Override::default(), false),
        }
    }
}

/// The function is the Index, the slave the SubIndex.
const fn function(index: i32, name: &'static str, kind: Type, read: super::table::Read) -> Device {
    let device = Device::read_only(7000, name, kind, Range::Only(index), read);
    device.with_sub(Range::Axis)
}

pub(super) const DEVICES: &[Device] = &[
    function(1, "SYNCMODE", Type::Integer, |m, p| Ok(f64::from(u8::from(m.attention.slaves.contains(p.sub))))).writing(
        |m, p, v| match v {
            1.0 => m.arm(p.sub),
            0.0 => {
                m.end_sync(p.sub);
                Ok(())
            }
            _ => Err(Code::State),
        },
    ),
    function(2, "MASTER AXIS", Type::Integer, |m, p| Ok(sync(m, p).master as f64)).writing(|m, p, v| {
        done(v >= 0.0 && v < m.axes.len() as f64 && v != p.sub as f64).map(|()| sync(m, p).master = v as usize)
    }),
    function(3, "SYNC SOURCE", Type::Integer, |_, _| Err(Code::Unknown))
        .writing(|m, p, v| done((0.0..=2.0).contains(&v)).map(|()| sync(m, p).source = v as i32))
        .write_only(),
    function(4, "START POSITION", Type::Double, |m, p| Ok(sync(m, p).start))
        .writing(|m, p, v| finite(&mut sync(m, p).start, v)),
    function(5, "POSITION OFFSET", Type::Double, |m, p| Ok(sync(m, p).offset))
        .writing(|m, p, v| finite(&mut sync(m, p).offset, v)),
    function(6, "MASTER VELOCITY", Type::Double, |m, p| Ok(sync(m, p).velocity))
        .writing(|m, p, v| finite(&mut sync(m, p).velocity, v)),
    function(7, "GEAR FACTOR", Type::Double, |m, p| Ok(sync(m, p).gear_factor))
        .writing(|m, p, v| nonzero(&mut sync(m, p).gear_factor, v)),
    function(8, "AUX FACTOR", Type::Double, |m, p| Ok(sync(m, p).aux_factor))
        .writing(|m, p, v| nonzero(&mut sync(m, p).aux_factor, v)),
];

fn sync(mcu: &mut Mcu, place: Place) -> &mut Sync {
    &mut mcu.resources.axes[place.sub].sync
}
fn finite(slot: &mut f64, value: f64) -> Result<(), Code> {
    done(crate::named::put(slot, value, |_| true))
}
fn nonzero(slot: &mut f64, value: f64) -> Result<(), Code> {
    done(crate::named::put(slot, value, |v| v != 0.0))
}

impl Mcu {
    /// Position of the master in its user unit.
    fn guiding(&self, sync: &Sync) -> f64 {
        match sync.source {
            RP => self.rdrp(sync.master),
            AUX => self.rdaux(sync.master) * sync.aux_factor / sync.gear_factor,
            _ => self.rddp(sync.master),
        }
    }
    /// Refused while the loop is open, without a nominal velocity, and while it is armed.
    fn arm(&mut self, slave: usize) -> Result<(), Code> {
        let sync = self.resources.axes[slave].sync;
        let ready = self.loops[slave].closed && sync.velocity != 0.0 && sync.master != slave;
        done(ready && !self.attention.slaves.contains(slave))?;
        let before = self.guiding(&sync);
        let axis = &mut self.axes[slave];
        let saved = (axis.trajectory, axis.jovr_follows);
        axis.trajectory.take(STANDING, 0.0);
        axis.jovr_follows = true;
        self.resources.axes[slave].sync = Sync { way: 0.0, before, triggered: false, moved: false, saved, ..sync };
        self.attend_to(|attention| attention.slaves = attention.slaves.union(AxisSet::single(slave)));
        Ok(())
    }
    /// The slave is an axis like any other again.
    fn end_sync(&mut self, slave: usize) {
        if self.attention.slaves.contains(slave) {
            let axis = &mut self.axes[slave];
            (axis.trajectory, axis.jovr_follows) = self.resources.axes[slave].sync.saved;
            self.attend_to(|attention| attention.slaves = attention.slaves.without(AxisSet::single(slave)));
        }
    }
    /// Before the slave's profile clock runs on: by how much in this sample.
    #[cold]
    pub(crate) fn synchronise(&mut self, slave: usize) {
        let mut sync = self.resources.axes[slave].sync;
        if !self.loops[slave].closed || (sync.moved && self.axes[slave].is_drained()) {
            return self.end_sync(slave);
        }
        let now = self.guiding(&sync);
        let forward = sync.velocity.signum();
        let trigger = sync.start + sync.offset;
        sync.triggered |= (sync.before - trigger) * forward <= 0.0 && (now - trigger) * forward >= 0.0;
        sync.before = now;
        let way = if sync.triggered { ((now - trigger) * forward).max(sync.way) } else { 0.0 };
        let factor = (way - sync.way) / (sync.velocity.abs() * self.ta);
        sync.way = way;
        sync.moved |= sync.triggered && self.axes[slave].doing.travels();
        self.axes[slave].trajectory.take(factor.max(STANDING), 0.0);
        self.resources.axes[slave].sync = sync;
    }
}
