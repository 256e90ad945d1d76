//! Home searches, index, home position (4.4.20 to 4.4.22, 4.4.116, 4.4.45 bits 17 and 18).

mod common;

use common::*;
use motion_kernel::Mcu;
use motion_kernel::axes::AxisList;
use motion_kernel::functions::Entered;
use motion_kernel::machine::{Home, Index, Machine};
use motion_kernel::registers::{Axst, Digi, ModeReg};

const REF: u32 = 1 << 4;

/// mill3 with index pulses every 5 mm from 1.25 on, REF of X at input 5, hvl 10 and hac 100.
fn mill(change: impl Fn(&mut Machine)) -> Mcu {
    let text =
        format!("{}\n[[input]]\nnumber = 5\naxis = \"X\"\nfunction = \"REF\"\n", motion_kernel::machine::BUILTIN);
    let mut machine = Machine::parse(text.as_bytes()).expect("valid");
    for axis in &mut machine.axes {
        axis.equipment.index = Some(Index { position: 1.25, period: 5.0, width: 0.01, inverted: false });
        axis.equipment.home = Home { velocity: Some(10.0), acceleration: Some(100.0), ..Home::default() };
    }
    change(&mut machine);
    mcu_of(machine, ModeReg(0))
}
fn x() -> AxisList {
    AxisList::new(&[0])
}
/// Runs until the axis is at its profile end; returns its set points.
fn until_pe(mcu: &mut Mcu) -> Vec<f64> {
    let mut course = Vec::new();
    for _ in 0..20_000 {
        mcu.run(1);
        course.push(mcu.rddp(0));
        if mcu.axst(0).has(Axst::pe) {
            return course;
        }
    }
    panic!("no profile end");
}

// shows: pcap.jhi, pcap.jhi.stop-on-index, pcap.jhi.parameters, pcap.jhi.pe
#[test]
fn the_index_search_brakes_at_the_index() {
    let mut mcu = mill(|_| ());
    assert_eq!(mcu.jhi(&x(), &[20.0]), Entered::Yes);
    assert!(!mcu.axst(0).has(Axst::pe), "from the call on");
    let course = until_pe(&mut mcu);
    // index at 1.25, then 10² / 2 / 100 = 0.5 mm of braking; the encoder is a sample behind the set point
    let end = *course.last().expect("samples");
    assert!((end - 1.75).abs() < 2.0 * 10.0 * TA, "{end}");
    let fastest = course.windows(2).map(|w| (w[1] - w[0]) / TA).fold(0.0, f64::max);
    close(fastest, 10.0, 1e-6);
    let hardest = course.windows(3).map(|w| ((w[2] - 2.0 * w[1] + w[0]) / TA / TA).abs()).fold(0.0, f64::max);
    assert!(hardest < 100.0 + 1e-4, "{hardest}");
}

// shows: pcap.jhi.stop-on-distance, pcap.jhi.relative, pcap.jhi.direction
#[test]
fn without_an_index_the_search_ends_after_its_distance() {
    for way in [3.0, -3.0] {
        let mut mcu = mill(|machine| machine.axes[0].equipment.index = None);
        mcu.wrdp(0, 7.0);
        mcu.run(500);
        mcu.jhi(&x(), &[way]);
        until_pe(&mut mcu);
        close(mcu.rddp(0), 7.0 + way, 1e-9);
    }
    let mut mcu = mill(|_| ());
    mcu.jhi(&x(), &[-20.0]);
    until_pe(&mut mcu);
    assert!((-4.4..-4.2).contains(&mcu.rddp(0)), "the index at -3.74, from the right: {}", mcu.rddp(0));
}

// shows: pcap.jhi.index-in-digi, digi.bit16, digi.bit18, pcap.rddigib.17, pcap.rddigib.19, pcap.rdlpndx
// shows: pcap.rdlpndx.realtime
#[test]
fn the_index_shows_in_digi_and_latches_where_it_is() {
    let mut mcu = mill(|_| ());
    assert_eq!(mcu.rddigi(0) & (Digi::index | Digi::index_edge).0, 0);
    mcu.jhi(&x(), &[20.0]);
    let mut seen = false;
    for _ in 0..2000 {
        mcu.run(1);
        let inside = (1.25..1.26).contains(&mcu.rdrp(0));
        assert_eq!(mcu.rddigi(0) & Digi::index.0 != 0, inside, "at {}", mcu.rdrp(0));
        assert_eq!(mcu.rddigib(0, 17) == 1, inside);
        seen |= mcu.rddigib(0, 19) == 1;
        assert_eq!(seen, mcu.rddigi(0) & Digi::index_edge.0 != 0, "the edge is stored");
    }
    assert!(seen && mcu.rddigi(1) & Digi::index_edge.0 == 0, "of this axis only");
    close(mcu.rdlpndx(0), 1.25, 1e-9);
    mcu.wrlpndx(0, -3.5);
    assert_eq!(mcu.rdlpndx(0), -3.5);
}

// shows: pcap.rddigi.index-polarity, pcap.wrlpndx
#[test]
fn the_polarity_of_the_index_is_configured() {
    let mut mcu = mill(|machine| machine.axes[0].equipment.index.as_mut().expect("an index").inverted = true);
    assert_eq!(mcu.rddigib(0, 17), 1, "between the pulses an inverted signal is active");
    mcu.jhi(&x(), &[20.0]);
    until_pe(&mut mcu);
    close(mcu.rdlpndx(0), 1.26, 1e-9);
    mcu.wrlpndx(0, 8.0);
    assert_eq!(mcu.rdlpndx(0), 8.0);
}

// shows: pcap.rddigi.rdigi, pcap.rddigib.rdigi, pcap.rdigi
#[test]
fn rdigi_clears_what_is_stored() {
    let mut mcu = mill(|machine| machine.axes[0].equipment.index.as_mut().expect("an index").width = 4.0);
    mcu.jhi(&x(), &[20.0]);
    until_pe(&mut mcu);
    mcu.cut_encoder(1, true);
    mcu.set_inputs(1 << 13);
    assert_eq!([17, 18, 19, 20].map(|bitnr| mcu.rddigib(0, bitnr)), [1, 0, 1, 1]);
    mcu.rdigi(0);
    assert_eq!([17, 18, 19, 20].map(|bitnr| mcu.rddigib(0, bitnr)), [1, 0, 0, 0], "the live index stays");
    assert_eq!(mcu.rddigib(1, 18), 1, "another axis keeps its own");
    mcu.rdigi(1);
    assert_eq!(mcu.rddigib(1, 18), 0);
}

// shows: pcap.jhl, pcap.jhl.stop-on-ref, pcap.jhl.pe, pcap.jhr
#[test]
fn the_reference_search_runs_until_its_switch() {
    for (direction, rightward) in [(-1.0, false), (1.0, true)] {
        let mut mcu = mill(|_| ());
        let entered = if rightward { mcu.jhr(&x()) } else { mcu.jhl(&x()) };
        assert_eq!(entered, Entered::Yes);
        mcu.run(8000);
        close(mcu.rddv(0), 10.0 * direction, 1e-9);
        assert!(!mcu.axst(0).has(Axst::pe), "endless");
        let from = mcu.rddp(0);
        mcu.set_inputs(REF);
        let course = until_pe(&mut mcu);
        let way = (course.last().expect("samples") - from) * direction;
        assert!((way - 0.5).abs() < 3.0 * 10.0 * TA, "{way}");
        close(course.len() as f64 * TA, 0.1, 4.0 * TA);
    }
}

// shows: axst.refh, digi.bit4
#[test]
fn refh_follows_the_reference_switch() {
    let mut mcu = mill(|_| ());
    for levels in [0, REF, 0] {
        mcu.set_inputs(levels);
        mcu.run(1);
        assert_eq!(mcu.axst(0).has(Axst::refh), levels != 0);
        assert!(!mcu.axst(1).has(Axst::refh));
    }
}

#[test]
fn searches_need_a_closed_loop_and_a_jog_replaces_them() {
    let mut mcu = mill(|_| ());
    mcu.ol(set(&[0]));
    assert_eq!(mcu.jhl(&x()), Entered::Refused);
    mcu.cl(set(&[0]));
    mcu.jhl(&x());
    mcu.run(500);
    mcu.ja(&x(), &[3.0]);
    mcu.set_inputs(REF);
    until_pe(&mut mcu);
    close(mcu.rddp(0), 3.0, 1e-9);
}

// shows: pcap.rdhvl, pcap.rdhvl.default, pcap.wrhvl, pcap.wrhvl.default, pcap.rdhac, pcap.rdhac.default, pcap.wrhac
// shows: pcap.wrhac.default
#[test]
fn home_velocity_and_acceleration_act_on_the_next_search() {
    let mut mcu = mill(|_| ());
    assert_eq!((mcu.rdhvl(0), mcu.rdhac(0)), (10.0, 100.0), "of the system data");
    assert!(mcu.wrhvl(0, 4.0) && mcu.wrhac(0, 20.0));
    assert!(!mcu.wrhvl(0, 0.0) && !mcu.wrhac(0, f64::NAN), "refused");
    assert_eq!((mcu.rdhvl(0), mcu.rdhac(0), mcu.rdhvl(1)), (4.0, 20.0, 10.0));
    mcu.jhl(&x());
    mcu.run(2 + 78); // 0.1 s behind the start
    close(mcu.rddv(0), -20.0 * 78.0 * TA, 1e-6);
    mcu.run(1000);
    close(mcu.rddv(0), -4.0, 1e-9);
}

// shows: pcap.shp, pcap.shp.open-and-closed, pcap.shp.no-motion, pcap.shp.referenced-bit, axst.referenced
#[test]
fn shp_gives_the_position_a_coordinate_and_moves_nothing() {
    for closed in [true, false] {
        let mut mcu = mill(|_| ());
        mcu.jhi(&x(), &[20.0]);
        until_pe(&mut mcu);
        mcu.run(200);
        if !closed {
            mcu.ol(set(&[0]));
        }
        let (place, error) = (mcu.machine_position(0), mcu.rdPosErr(0));
        assert!(!mcu.axst(0).has(Axst::referenced));
        assert!(mcu.shp(0, 100.0) && !mcu.shp(0, f64::INFINITY));
        close(mcu.rdrp(0), 100.0, 1e-9);
        assert!(mcu.axst(0).has(Axst::referenced) && !mcu.axst(1).has(Axst::referenced));
        if closed {
            close(mcu.rdPosErr(0), error, 1e-9);
        }
        mcu.run(300);
        close(mcu.machine_position(0), place, 2e-4);
        close(mcu.rdrp(0), 100.0, 2e-4);
    }
}

// shows: pcap.shp.dpoffset
#[test]
fn shp_leaves_an_offset_to_the_desired_position() {
    let mut mcu = mill(|_| ());
    mcu.wrdpoffset(0, 0.25);
    mcu.run(300);
    let place = mcu.machine_position(0);
    close(place, 0.25, 2e-4);
    mcu.shp(0, 10.0);
    close(mcu.rdrp(0), 10.0, 1e-9);
    close(mcu.rddp(0), 9.75, 2e-4);
    mcu.run(300);
    close(mcu.machine_position(0), place, 2e-4);
}

// shows: pcap.shp.backlash
#[test]
fn shp_keeps_the_backlash_compensation() {
    let mut mcu = mill(|machine| {
        machine.axes[0].equipment.backlash_compensation = 0.05;
        machine.axes[0].plant.backlash = 0.05;
    });
    mcu.ja(&x(), &[-10.0]);
    until_pe(&mut mcu);
    mcu.run(300);
    close(mcu.rdactual_backlash(0), -0.05, 1e-9);
    mcu.shp(0, 0.0);
    close(mcu.rdrp(0), 0.0, 1e-9);
    close(mcu.rdactual_backlash(0), -0.05, 1e-9);
    let place = mcu.machine_position(0);
    mcu.run(300);
    close(mcu.machine_position(0), place, 2e-4);
}

// shows: axst.referenced.reset-wrrp, axst.referenced.stepper
#[test]
fn the_reference_is_lost_where_positions_are() {
    let mut mcu = mill(|_| ());
    mcu.shp(0, 1.0);
    mcu.ol(set(&[0]));
    assert!(mcu.axst(0).has(Axst::referenced), "a servo axis keeps it");
    mcu.wrrp(0, 2.0);
    assert!(!mcu.axst(0).has(Axst::referenced));
    let mut machine = machine("XY");
    machine.axes[1].drive = motion_kernel::machine::DriveKind::Servo;
    let mut mcu = mcu_of(machine, ModeReg(0));
    for change in [Mcu::ol, Mcu::cl] {
        mcu.shp(0, 1.0);
        mcu.shp(1, 1.0);
        change(&mut mcu, set(&[0, 1]));
        assert_eq!([0, 1].map(|a| mcu.axst(a).has(Axst::referenced)), [false, true]);
    }
}

#[test]
fn spooled_motion_goes_to_the_same_place_after_shp() {
    let mut mcu = mill(|_| ());
    line(&mut mcu, &[4.0, 0.0, 0.0], 50.0, 500.0, 0.0);
    mcu.shp(0, 100.0);
    mcu.ssms(mcu.all_axes());
    mcu.run(2000);
    close(mcu.machine_position(0), 4.0, 2e-4);
    close(mcu.rddp(0), 104.0, 1e-9);
}
