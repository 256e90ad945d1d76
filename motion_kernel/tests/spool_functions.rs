//! The spooler and its special functions (2.2.8, 4.4.115, 4.4.120, 4.4.121, 4.4.123).

mod common;

use common::*;
use motion_kernel::functions::Entered;
use motion_kernel::registers::{Axst, ErrorReg, ModeReg};
use motion_kernel::spooler::{BYTES_FUNCTION, BYTES_LINEAR, SpoolState};
use motion_kernel::trace::{EventKind, Trace, flag};
use motion_kernel::{Mcu, Stop};

fn ssf(m: &mut Mcu, axes: &[usize], command: u16, value: f64) {
    for &axis in axes {
        assert_eq!(m.ssf(axis, command, value, 7), Entered::Yes);
    }
}
/// 1 mm, a wait, 1 mm; returns the samples from the end of the first move to the begin of the second.
fn samples_waited(command: u16, value: f64, during: impl Fn(&mut Mcu, u64)) -> u64 {
    let mut m = mcu("XY", EXACT);
    line(&mut m, &[1.0, 1.0], 10.0, 100.0, 0.0);
    ssf(&mut m, &[0, 1], command, value);
    line(&mut m, &[2.0, 2.0], 10.0, 100.0, 0.0);
    let all = m.all_axes();
    m.ssms(all);
    let mut waited = 0;
    for sample in 0..3000 {
        let mut trace = Trace::default();
        m.advance(1, &mut trace);
        if trace.is_empty() {
            m.run(1);
        }
        let status = m.status();
        assert!(!status.axes[0].axst.has(Axst::saf));
        if status.entry == 2 {
            break;
        }
        // the sample in which the first move ends is not one of the wait
        waited += u64::from(status.entry == 0 && status.axes[0].dp == 1.0);
        during(&mut m, sample);
    }
    waited - 1
}

// shows: ssf.1003, ssf.1003.rounding
#[test]
fn the_wait_lasts_whole_samples() {
    assert_eq!(samples_waited(1003, 7813.0, |_, _| ()), 390);
    assert_eq!(samples_waited(1003, 20.0, |_, _| ()), 1);
    assert_eq!(samples_waited(1003, 39.0, |_, _| ()), 1);
    assert_eq!(samples_waited(1003, 19.0, |_, _| ()), 0);
}

// shows: ssf.1003.early-end, ssf.1004.early-end
#[test]
fn ssms_ends_waits_early() {
    let start = |m: &mut Mcu, sample: u64| {
        if sample == 400 {
            let all = m.all_axes();
            m.ssms(all);
        }
    };
    let long = samples_waited(1003, 1e6, start);
    assert!(long > 0 && long < 400);
    assert_eq!(samples_waited(1004, 1.0, start), long);
}

// shows: ssf.1004, ssf.bit-coding
#[test]
fn the_wait_for_inputs_needs_all_of_them() {
    let end = |sample: u64| {
        samples_waited(1004, 5.0, move |m, now| {
            m.set_inputs(if now >= sample {
                5
            } else if now > 200 {
                4
            } else {
                0
            })
        })
    };
    assert_eq!(end(600) - end(500), 100);
}

// shows: ssf.1005, ssf.1015, ssf.1025, pcap.clearci99, pcap.clearci99.ssf
#[test]
fn waits_on_ci99_end_with_clear_ci99() {
    for command in [1005, 1015, 1025] {
        let waited = samples_waited(command, 3.0, |m, sample| {
            if sample == 500 {
                let expected = match command {
                    1005 => 3,
                    1015 => 6,
                    _ => 0b11,
                };
                assert_eq!(m.ci(99), expected, "{command}");
                m.ClearCI99();
            }
        });
        assert!(waited > 100 && waited < 500, "{command}: {waited}");
    }
}

// shows: ssf.1006, ssf.1006.sync, interp.parallel.synchronous-spool
#[test]
fn axes_meet_at_1006() {
    let mut m = mcu("XY", EXACT);
    let x = motion_kernel::axes::AxisList::new(&[0]);
    let y = motion_kernel::axes::AxisList::new(&[1]);
    let smla = motion_kernel::autocode::MoveKind::Smla;
    spool(&mut m, smla, &x, &[1.0], [0.0; 2], 0.0, [10.0, 100.0, 0.0]);
    spool(&mut m, smla, &y, &[5.0], [0.0; 2], 0.0, [10.0, 100.0, 0.0]);
    ssf(&mut m, &[0, 1], 1006, 3.0);
    line(&mut m, &[2.0, 6.0], 10.0, 100.0, 0.0);
    let trace = run(&mut m);
    let begin = |axis: usize, from: f64| dp(&trace, axis).iter().rposition(|p| *p == from);
    assert_eq!(begin(0, 1.0), begin(1, 5.0));
    assert!(!m.axst(0).has(Axst::saf));
}

// shows: ssf.1000, pcap.ssms, spool.start-ssms
#[test]
fn the_halt_lasts_until_ssms() {
    let mut m = mcu("X", EXACT);
    line(&mut m, &[1.0], 10.0, 100.0, 0.0);
    ssf(&mut m, &[0], 1000, 0.0);
    line(&mut m, &[2.0], 10.0, 100.0, 0.0);
    m.run(100);
    close(m.status().axes[0].dp, 0.0, 0.0);
    let all = m.all_axes();
    m.ssms(all);
    m.run(2000);
    close(m.status().axes[0].dp, 1.0, 0.0);
    m.ssms(all);
    record(&mut m);
    close(m.status().axes[0].dp, 2.0, 0.0);
}

#[test]
fn waits_for_the_operator_are_told_once_and_acknowledged() {
    for (command, value) in [(1000, 0.0), (1025, 0.0), (1005, 1.0)] {
        let mut m = mcu("XY", EXACT);
        line(&mut m, &[1.0, 1.0], 10.0, 100.0, 0.0);
        ssf(&mut m, &[0, 1], command, value);
        line(&mut m, &[2.0, 2.0], 10.0, 100.0, 0.0);
        let all = m.all_axes();
        m.ssms(all);
        let mut trace = Trace::default();
        assert_eq!(m.advance(5000, &mut trace).stop, Stop::Acknowledge { command });
        assert_eq!(m.status().waits, Some(command));
        let more = m.advance(100, &mut trace);
        assert_eq!((more.samples, more.stop), (100, Stop::Budget));
        assert!(trace.flags.iter().all(|f| f & flag::WAITING != 0) && trace.line[0] == 7);
        m.acknowledge();
        record(&mut m);
        assert!(m.axst(0).has(Axst::pe) && !m.axst(1).has(Axst::saf));
        close(m.status().axes[1].dp, 2.0, 0.0);
    }
}

// shows: ssf.1000.condition, ssf.1003.condition, ssf.1004.condition, ssf.1005.condition, ssf.1006.condition
// shows: ssf.1015.condition, ssf.1025.condition, errorreg.ssf-wait-refused
#[test]
fn a_wait_behind_a_motion_that_does_not_stop_is_ignored() {
    for command in [1000, 1003, 1004, 1005, 1006, 1015, 1025] {
        let mut m = mcu("X", EXACT);
        line(&mut m, &[1.0], 10.0, 100.0, 10.0);
        assert_eq!(m.ssf(0, command, 1000.0, 1), Entered::Discarded);
        assert!(m.errorreg().has(ErrorReg::SsfWaitRefused));
        line(&mut m, &[2.0], 10.0, 100.0, 0.0);
        let trace = run(&mut m);
        assert!(trace.v_plan[100..140].iter().all(|v| *v > 9.0), "{command} did not stop");
        assert_eq!(m.ci(99), 0);
    }
}

// shows: ssf.0-999, ssf.example-ci, ssf.10000-10999, ssf.11000-11999, ssf.20000-20999, ssf.value-conversion, pcap.ssf
#[test]
fn functions_write_common_variables_in_sequence() {
    let mut m = mcu("X", EXACT);
    m.set_ci(5, 0b1010);
    line(&mut m, &[1.0], 10.0, 100.0, 0.0);
    ssf(&mut m, &[0], 125, 999.0);
    ssf(&mut m, &[0], 126, -2.9);
    ssf(&mut m, &[0], 10005, 5.0);
    ssf(&mut m, &[0], 11005, 8.0);
    ssf(&mut m, &[0], 127, 4_294_967_295.0);
    ssf(&mut m, &[0], 20009, 2.5);
    let all = m.all_axes();
    m.ssms(all);
    m.run(50);
    assert_eq!((m.ci(125), m.cd(9)), (0, 0.0));
    record(&mut m);
    assert_eq!((m.ci(125), m.ci(126), m.ci(5), m.ci(127), m.cd(9)), (999, -2, 0b0111, -1, 2.5));
}

#[test]
fn functions_switch_outputs_and_are_told() {
    let mut m = mcu("X", EXACT);
    line(&mut m, &[1.0], 10.0, 100.0, 0.0);
    ssf(&mut m, &[0], 1001, 5.0);
    ssf(&mut m, &[0], 1002, 4.0);
    ssf(&mut m, &[0], 198, 3.0);
    let trace = run(&mut m);
    assert_eq!(m.rddigo(), 1);
    let events = m.events();
    let kinds: Vec<(EventKind, i64, u32)> = events.iter().map(|e| (e.kind, e.value, e.line)).collect();
    assert_eq!(kinds, [(EventKind::Outputs, 5, 7), (EventKind::Outputs, 1, 7), (EventKind::Host, 2, 7)]);
    assert_eq!(events[0].sample as usize, trace.len() - 1);
    assert!(m.events().is_empty());
}

// shows: ssf.2001
#[test]
fn function_2001_stops_the_last_motion() {
    for running in [0, 100] {
        let mut m = mcu("X", EXACT);
        line(&mut m, &[10.0], 20.0, 100.0, 20.0);
        let all = m.all_axes();
        if running > 0 {
            m.ssms(all);
            m.run(running);
        }
        assert_eq!(m.ssf(0, 2001, 0.0, 1), Entered::Yes);
        ssf(&mut m, &[0], 1003, 20.0);
        m.ssms(all);
        let trace = record(&mut m);
        assert_eq!(dp(&trace, 0).last(), Some(&10.0));
        let v = speeds(&trace, 0, dp(&trace, 0)[0]);
        assert!(v.windows(2).skip(1).all(|w| (w[1] - w[0]).abs() <= 101.0 * TA), "no jump");
    }
}

// shows: spool.free-space-decreases, spool.free-space-increases, pcap.rdlsm, pcap.rdlsm.decrease
// shows: pcap.rdlsm.increase, pcap.rdlsm.size, pcap.rdlsm.per-axis, pcap.rdmcis
#[test]
fn memory_and_count_follow_the_entries() {
    let mut m = mcu("XY", EXACT);
    assert_eq!(m.status().axes[0].lsm, 148_480);
    line(&mut m, &[1.0, 0.0], 10.0, 100.0, 0.0);
    line(&mut m, &[2.0, 0.0], 10.0, 100.0, 0.0);
    ssf(&mut m, &[1], 5, 1.0);
    let status = m.status();
    assert_eq!((status.axes[0].mcis, status.axes[0].lsm), (2, 148_480 - 2 * BYTES_LINEAR));
    assert_eq!((status.axes[1].mcis, status.axes[1].lsm), (2, 148_480 - 2 * BYTES_LINEAR - BYTES_FUNCTION));
    let all = m.all_axes();
    m.ssms(all);
    m.run(1);
    let status = m.status();
    assert_eq!((status.axes[0].mcis, status.axes[0].lsm), (1, 148_480 - BYTES_LINEAR));
    record(&mut m);
    assert!(m.status().axes.iter().all(|a| a.lsm == 148_480 && a.mcis == 0));
}

// shows: errorreg.spooler-overrun
#[test]
fn a_full_spooler_takes_no_more() {
    let mut m = mcu("X", EXACT);
    let most = 148_480 / BYTES_LINEAR;
    for n in 1..=most {
        assert_eq!(line(&mut m, &[f64::from(n)], 10.0, 100.0, 0.0), Entered::Yes);
    }
    assert_eq!(m.errorreg().0, 0);
    assert_eq!(line(&mut m, &[-1.0], 10.0, 100.0, 0.0), Entered::Full);
    assert!(m.errorreg().has(ErrorReg::errSpoolerOverrun));
}

// shows: pcap.sstps, pcap.sstps.current-finishes, pcap.sstps.keeps-entries
#[test]
fn sstps_stops_behind_the_current_command() {
    let mut m = mcu("X", EXACT);
    line(&mut m, &[1.0], 10.0, 100.0, 0.0);
    line(&mut m, &[2.0], 10.0, 100.0, 0.0);
    let all = m.all_axes();
    m.ssms(all);
    m.run(50);
    m.sstps(all);
    m.run(500);
    let axis = m.status().axes[0];
    assert_eq!((axis.dp, axis.mcis, axis.spool_state), (1.0, 1, SpoolState::Stopped));
    m.ssms(all);
    record(&mut m);
    close(m.status().axes[0].dp, 2.0, 0.0);
}

// shows: pcap.sstps.target-velocity
#[test]
fn with_a_target_velocity_sstps_lets_the_axis_run_on() {
    let mut m = mcu("X", EXACT);
    line(&mut m, &[1.0], 10.0, 100.0, 10.0);
    line(&mut m, &[20.0], 10.0, 100.0, 0.0);
    let all = m.all_axes();
    m.ssms(all);
    m.run(50);
    m.sstps(all);
    m.run(300);
    assert!(m.status().axes[0].dp > 1.5);
    close(m.status().axes[0].dv, 10.0, 1e-9);
}

// shows: pcap.sdels, pcap.sdels.memory-free, pcap.sdels.current-finishes
#[test]
fn sdels_discards_what_waits() {
    let mut m = mcu("X", EXACT);
    line(&mut m, &[1.0], 10.0, 100.0, 0.0);
    line(&mut m, &[2.0], 10.0, 100.0, 0.0);
    let all = m.all_axes();
    m.ssms(all);
    m.run(50);
    m.sdels(all);
    assert_eq!(m.status().axes[0].lsm, 148_480);
    record(&mut m);
    close(m.status().axes[0].dp, 1.0, 0.0);
}

// shows: spool.direct-mode-after-drain
#[test]
fn a_drained_spooler_must_be_started_again() {
    let mut m = mcu("X", EXACT);
    line(&mut m, &[1.0], 10.0, 100.0, 0.0);
    run(&mut m);
    assert_eq!(m.status().axes[0].spool_state, SpoolState::Direct);
    line(&mut m, &[2.0], 10.0, 100.0, 0.0);
    m.run(500);
    close(m.status().axes[0].dp, 1.0, 0.0);
    run(&mut m);
    close(m.status().axes[0].dp, 2.0, 0.0);
}

// shows: spool.precondition.min-duration, errorreg.profile-too-small, errorreg.profile-too-small.single
#[test]
fn two_moves_shorter_than_a_sample_are_reported() {
    let flagged = |lengths: &[f64], factor: f64| {
        let mut m = mcu("X", EXACT);
        m.wrtrovr(factor);
        m.utrovr(set(&[0]));
        let mut x = 0.0;
        for length in lengths {
            x += length;
            line(&mut m, &[x], 50.0, 5000.0, 50.0);
        }
        line(&mut m, &[x + 5.0], 50.0, 5000.0, 0.0);
        run(&mut m);
        m.errorreg().has(ErrorReg::ProfileToSmall)
    };
    let (short, long) = (0.9 * 50.0 * TA, 1.1 * 50.0 * TA);
    assert!(flagged(&[5.0, short, short], 1.0));
    assert!(!flagged(&[5.0, short, long, short], 1.0));
    assert!(!flagged(&[5.0, long, long], 1.0));
    assert!(flagged(&[5.0, long, long], 1.2));
}

fn chain(m: &mut Mcu) {
    for n in 1..=20 {
        line(m, &[f64::from(n) * 2.0, f64::from(n)], 20.0, 200.0, if n < 20 { 20.0 } else { 0.0 });
    }
    let all = m.all_axes();
    m.ssms(all);
}

// shows: spool.saf.detect, kernel.override.jog-not-for-moves, axst.saf, spool.saf.no-stop-without-bit
#[test]
fn overriding_one_axis_alone_breaks_the_path() {
    let mut m = mcu("XY", EXACT);
    chain(&mut m);
    m.run(200);
    assert!(!m.axst(0).has(Axst::saf));
    m.wrjovr(0, 0.5);
    m.run(100);
    assert!(m.axst(0).has(Axst::saf) && m.axst(1).has(Axst::saf));
    let axes = m.status().axes;
    assert!((axes[0].dp - 2.0 * axes[1].dp).abs() > 0.1, "off the line");
    assert!(axes.iter().all(|a| a.dv != 0.0));
    assert!(!m.errorreg().has(ErrorReg::JSatSAFdone));
    record(&mut m);
    close(m.status().axes[0].dp, 40.0, 0.0);
}

// shows: spool.saf.jog-stop, errorreg.jsatsaf-done, spool.saf.error-indication
#[test]
fn jsatsaf_stops_all_axes() {
    let mut m = mcu("XY", EXACT | ModeReg::JSatSAF);
    chain(&mut m);
    m.run(200);
    m.wrjovr(0, 0.5);
    let mut trace = Trace::default();
    let advanced = m.advance(1000, &mut trace);
    assert!(matches!(advanced.stop, Stop::Fault { .. }), "{advanced:?}");
    assert!(m.errorreg().has(ErrorReg::JSatSAFdone) && m.axst(1).has(Axst::saf));
    m.run(50);
    let stopped = m.status();
    assert!(stopped.axes.iter().all(|a| a.dv == 0.0 && a.mcis == 0 && a.dp > 1.0));
    m.run(100);
    assert_eq!(m.status().axes[0].dp, stopped.axes[0].dp);
}

// shows: spool.synchronous-programming
#[test]
fn a_spooler_started_alone_is_asynchronous() {
    let mut m = mcu("XY", EXACT);
    line(&mut m, &[5.0, 5.0], 20.0, 200.0, 0.0);
    m.ssms(set(&[0]));
    m.run(20);
    m.ssms(set(&[1]));
    m.run(1);
    assert!(m.axst(0).has(Axst::saf));
    m.cl(set(&[0, 1]));
    assert!(!m.axst(0).has(Axst::saf), "cl clears it");
}

// shows: errorreg.target-vel, errorreg.target-vel.reset
#[test]
fn forbid_target_vel_resets_the_system() {
    let mut m = mcu("X", EXACT | ModeReg::ForbidTargetVel);
    line(&mut m, &[1.0], 10.0, 100.0, 10.0);
    let all = m.all_axes();
    m.ssms(all);
    m.run(500);
    assert!(m.errorreg().has(ErrorReg::errTargetVel));
    assert!(!m.axst(0).has(Axst::cl));
}

// shows: pcap.cl.discards-spooler
#[test]
fn closing_the_loop_discards_the_spooler() {
    let mut m = mcu("X", EXACT);
    line(&mut m, &[1.0], 10.0, 100.0, 0.0);
    m.cl(set(&[0]));
    assert_eq!(m.status().axes[0].mcis, 0);
    assert!(run(&mut m).is_empty());
}
