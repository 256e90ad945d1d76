//! Feed hold, resume and motion stop (4.4.39, design D5, D17).

mod common;

use common::*;
use motion_kernel::registers::{Axst, ModeReg};
use motion_kernel::spooler::SpoolState;
use motion_kernel::trace::{Trace, flag};
use motion_kernel::{Mcu, Stop};

fn cruising() -> Mcu {
    let mut m = mcu("XY", LOOKAHEAD);
    line(&mut m, &[60.0, 80.0], 20.0, 100.0, 20.0);
    line(&mut m, &[60.0, 100.0], 20.0, 100.0, 0.0);
    let all = m.all_axes();
    m.ssms(all);
    m.run(500);
    m
}
fn held(m: &mut Mcu) -> Trace {
    m.hold();
    let mut trace = Trace::default();
    assert_eq!(m.advance(20_000, &mut trace).stop, Stop::Held);
    trace
}

// shows: pcap.ms, pcap.ms.pe
#[test]
fn ms_brakes_with_the_path_acceleration_and_discards_the_rest() {
    let mut m = cruising();
    let all = m.all_axes();
    let before = m.status();
    m.ms(all);
    assert_eq!(m.status().axes[0].mcis, 0);
    m.run(150);
    assert!(!m.axst(0).has(Axst::pe));
    record(&mut m);
    let after = m.status();
    let way = (after.axes[0].dp - before.axes[0].dp).hypot(after.axes[1].dp - before.axes[1].dp);
    close(way, 20.0 * 20.0 / 200.0, 1e-9);
    assert!(m.axst(0).has(Axst::pe | Axst::cl));
    // a new command starts where it stands
    line(&mut m, &[0.0, 0.0], 20.0, 100.0, 0.0);
    run(&mut m);
    close(m.status().axes[1].dp, 0.0, 0.0);
}

// shows: pcap.wrtrac.ms-decel
#[test]
fn ms_decel_brakes_with_trac() {
    let mut m = cruising();
    m.set_modereg(LOOKAHEAD | ModeReg::MS_DECEL);
    m.registers_mut().trac = 400.0;
    let before = m.status().axes[0].dp;
    let all = m.all_axes();
    m.ms(all);
    record(&mut m);
    close((m.status().axes[0].dp - before) / 0.6, 20.0 * 20.0 / 800.0, 1e-9);
}

// shows: pcap.ms.end-velocity-axes
#[test]
fn axes_that_run_on_brake_with_sdec() {
    let mut m = mcu("X", EXACT);
    line(&mut m, &[1.0], 20.0, 400.0, 20.0);
    let all = m.all_axes();
    m.ssms(all);
    m.run(200);
    m.parameters_mut(0).sdec = 50.0;
    let before = m.status().axes[0].dp;
    m.ms(all);
    record(&mut m);
    close(m.status().axes[0].dp - before, 20.0 * 20.0 / 100.0, 1e-9);
}

// shows: pcap.ms.independent
#[test]
fn groups_stop_each_on_its_own_contour() {
    let mut m = mcu("XYZ", EXACT);
    let smla = motion_kernel::autocode::MoveKind::Smla;
    let z = motion_kernel::axes::AxisList::new(&[2]);
    line(&mut m, &[100.0, 100.0], 20.0, 100.0, 0.0);
    spool(&mut m, smla, &z, &[100.0], [0.0; 2], 0.0, [40.0, 100.0, 0.0]);
    let all = m.all_axes();
    m.ssms(all);
    m.run(500);
    m.ms(all);
    m.run(200);
    assert!(m.axst(0).has(Axst::pe) && !m.axst(2).has(Axst::pe));
    m.run(200);
    assert!(m.axst(2).has(Axst::pe));
    close(m.status().axes[0].dp, m.status().axes[1].dp, 1e-9);
}

#[test]
fn a_hold_keeps_what_lies_behind() {
    let mut m = cruising();
    let braking = held(&mut m);
    assert!(braking.flags.iter().all(|f| f & flag::HELD != 0));
    let status = m.status();
    assert_eq!((status.axes[0].mcis, status.axes[0].spool_state), (2, SpoolState::Held));
    assert!(m.is_holding() && status.stands);
    let all = m.all_axes();
    m.ssms(all);
    m.run(100);
    assert_eq!(m.status().axes[0].dp, status.axes[0].dp, "only resume goes on");
    m.resume();
    let trace = record(&mut m);
    let first = (trace.dp[0] - status.axes[0].dp).hypot(trace.dp[1] - status.axes[1].dp);
    close(first, 0.5 * 100.0 * TA * TA, 1e-12); // from standstill, where it stopped
    assert_eq!((trace.entry[0], trace.line[0]), (1, 1), "the numbers stay");
    close(m.status().axes[1].dp, 100.0, 0.0);
}

/// The hold costs its ramps: the rest of the motion is as planned from standstill.
#[test]
fn a_hold_in_a_chain_of_short_blocks_brakes_across_them() {
    let mut m = mcu("XY", LOOKAHEAD);
    for n in 1..=400 {
        line(&mut m, &[f64::from(n) * 0.1, 0.0], 20.0, 100.0, if n < 400 { 20.0 } else { 0.0 });
    }
    let all = m.all_axes();
    m.ssms(all);
    m.run(700);
    let before = m.status();
    close(before.path_v, 20.0, 1e-9);
    held(&mut m);
    close(m.status().axes[0].dp - before.axes[0].dp, 2.0, 1e-9);
    assert_eq!(m.status().axes[0].mcis, 400 - (before.entry + 20) + 1);
    m.resume();
    let trace = record(&mut m);
    assert_eq!(trace.entry[0], before.entry + 20);
    close(m.status().axes[0].dp, 40.0, 0.0);
}

#[test]
fn functions_passed_while_braking_wait_for_the_resume() {
    let mut m = mcu("XY", LOOKAHEAD);
    for n in 1..=40 {
        line(&mut m, &[f64::from(n), 0.0], 20.0, 100.0, if n < 40 { 20.0 } else { 0.0 });
        m.ssf(0, n, f64::from(n), 0);
    }
    let all = m.all_axes();
    m.ssms(all);
    m.run(700);
    let done = |m: &Mcu| (1..=40).filter(|n| m.ci(*n) != 0).count();
    let before = done(&m);
    held(&mut m);
    assert_eq!(done(&m), before, "two were passed and not executed");
    assert_eq!(m.status().axes[0].dp.ceil() as usize, before + 3);
    m.resume();
    m.run(2);
    assert_eq!(done(&m), before + 2, "in their order, before the rest of the cut block");
    record(&mut m);
    assert_eq!(done(&m), 40);
}

#[test]
fn a_broken_wait_is_repeated_in_full() {
    let mut m = mcu("XY", LOOKAHEAD);
    line(&mut m, &[1.0, 0.0], 20.0, 100.0, 0.0);
    m.ssf(0, 1003, 20.0 * 200.0, 3);
    m.ssf(1, 1003, 20.0 * 200.0, 3);
    line(&mut m, &[2.0, 0.0], 20.0, 100.0, 0.0);
    let all = m.all_axes();
    m.ssms(all);
    m.run(300);
    held(&mut m);
    m.run(1000);
    close(m.status().axes[0].dp, 1.0, 0.0);
    m.resume();
    let mut trace = Trace::default();
    m.advance(199, &mut trace);
    assert!(trace.flags[1..].iter().all(|f| f & flag::WAITING != 0));
    m.run(3);
    assert!(m.status().axes[0].dp > 1.0);
    record(&mut m);
    assert!(!m.axst(0).has(Axst::saf));
}

#[test]
fn a_programmed_stop_is_not_passed_by_hold_and_resume() {
    let mut m = mcu("X", LOOKAHEAD);
    line(&mut m, &[1.0], 20.0, 100.0, 0.0);
    m.ssf(0, 1000, 0.0, 3);
    line(&mut m, &[2.0], 20.0, 100.0, 0.0);
    let all = m.all_axes();
    m.ssms(all);
    m.run(1000);
    m.hold();
    m.run(10);
    m.resume();
    m.run(1000);
    close(m.status().axes[0].dp, 1.0, 0.0);
    m.acknowledge();
    record(&mut m);
    close(m.status().axes[0].dp, 2.0, 0.0);
}

#[test]
fn resuming_while_braking_goes_on_from_the_stop() {
    let mut m = cruising();
    m.hold();
    m.run(20);
    m.resume();
    let trace = record(&mut m);
    close(m.status().axes[1].dp, 100.0, 0.0);
    assert!(trace.v_plan.iter().take(200).any(|v| *v < 0.2), "it came to rest");
}

#[test]
fn an_abort_ends_motion_and_hold() {
    for hold_first in [false, true] {
        let mut m = cruising();
        if hold_first {
            m.hold();
            m.run(20);
        }
        m.abort();
        record(&mut m);
        let status = m.status();
        assert!(!status.holding && status.axes.iter().all(|a| a.mcis == 0 && a.lsm == a.memory));
        line(&mut m, &[0.0, 0.0], 20.0, 100.0, 0.0);
        run(&mut m);
        close(m.status().axes[0].dp, 0.0, 0.0);
    }
}

/// Without look-ahead the plan of the next block may start lower, by a jump (2.2.2); so does the braking.
#[test]
fn braking_into_a_block_too_short_to_brake_stays_on_the_path() {
    let mut m = mcu("XY", EXACT);
    line(&mut m, &[10.0, 0.0], 60.0, 400.0, 60.0);
    line(&mut m, &[10.0, 0.05], 60.0, 1700.0, 0.0);
    let all = m.all_axes();
    m.ssms(all);
    while m.status().axes[0].dp < 9.5 {
        m.run(1);
    }
    let trace = held(&mut m);
    let second = trace.entry.iter().position(|e| *e == 2).expect("second block");
    assert!(trace.v_plan[second..].iter().all(|v| v * v <= 2.0 * 1700.0 * 0.05), "as the plan, it starts lower");
    assert!(trace.dp.chunks(2).all(|p| (p[1] == 0.0 || p[0] == 10.0) && p[1] <= 0.05), "never behind the target");
    m.resume();
    record(&mut m);
    close(m.status().axes[1].dp, 0.05, 0.0);
}
