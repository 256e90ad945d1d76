//! Commands beyond what the drive can do: accepted, and seen as following error (2.2.1 to 2.2.5).

mod common;

use common::*;
use motion_kernel::Mcu;
use motion_kernel::axes::AxisList;
use motion_kernel::functions::Entered;
use motion_kernel::machine::Machine;

/// The built-in mill: 10 V are 250 mm/s.
fn mill() -> Mcu {
    mcu_of(Machine::builtin(), EXACT)
}
/// Following errors of X, sample by sample.
fn errors(m: &mut Mcu, samples: u64) -> Vec<f64> {
    (0..samples)
        .map(|_| {
            m.run(1);
            let axis = m.status().axes[0];
            (axis.dp - axis.rp).abs()
        })
        .collect()
}
fn most(errors: &[f64]) -> f64 {
    errors.iter().copied().fold(0.0, f64::max)
}
fn start(m: &mut Mcu, target: f64, vl: f64, ac: f64, tvl: f64) {
    assert_eq!(line(m, &[target, 0.0, 0.0], vl, ac, tvl), Entered::Yes);
    let all = m.all_axes();
    m.ssms(all);
}

// shows: kernel.maxvel.unreachable, kernel.maxvel.float
#[test]
fn a_velocity_beyond_the_drive_is_following_error_while_travelling() {
    let mut m = mill();
    start(&mut m, 100.0, 200.0, 1000.0, 0.0);
    let reachable = most(&errors(&mut m, 2000));
    let mut m = mill();
    start(&mut m, 500.0, 400.0, 1000.0, 0.0);
    let travelling = errors(&mut m, 1200);
    assert!(travelling[900] > 50.0 * reachable && travelling[1000] > travelling[900], "it falls behind");
    let mut m = mill();
    start(&mut m, 1e-3, 1e12, 1000.0, 0.0);
    m.run(100);
    close(m.status().axes[0].dp, 1e-3, 0.0);
}

// shows: kernel.accel.unreachable, kernel.accel.float
#[test]
fn an_acceleration_beyond_the_drive_is_following_error_in_the_ramp() {
    let in_ramp = |ac: f64| {
        let mut m = mill();
        start(&mut m, 200.0, 200.0, ac, 0.0);
        let errors = errors(&mut m, 500);
        (most(&errors[..60]), errors[499])
    };
    let (gentle, _) = in_ramp(500.0);
    let (hard, later) = in_ramp(1e7);
    assert!(hard > 10.0 * gentle, "{hard} against {gentle}");
    assert!(later < 0.1 * hard, "controlled out while travelling: {later}");
}

// shows: kernel.tvl.unreachable, kernel.tvl.float
#[test]
fn a_target_velocity_beyond_the_drive_is_following_error() {
    let mut m = mill();
    start(&mut m, 50.0, 100.0, 1000.0, 600.0);
    let before = most(&errors(&mut m, 400));
    let after = errors(&mut m, 600);
    assert!(m.status().axes[0].dp > 50.0);
    assert!(*after.last().expect("samples") > 20.0 * before);
}

// shows: kernel.profile.move.jump-following-error
#[test]
fn a_velocity_jump_of_a_move_is_controlled_out() {
    let mut m = mill();
    line(&mut m, &[50.0, 0.0, 0.0], 100.0, 1000.0, 100.0);
    line(&mut m, &[100.0, 0.0, 0.0], 20.0, 1000.0, 0.0); // the start above the maximum jumps down
    let all = m.all_axes();
    m.ssms(all);
    let errors = errors(&mut m, 2500);
    let jump = (0..errors.len()).max_by(|a, b| errors[*a].total_cmp(&errors[*b])).expect("samples");
    assert!(errors[jump] > 5.0 * most(&errors[200..jump - 5]), "the jump shows");
    assert!(most(&errors[jump + 300..]) < 0.1 * errors[jump], "and is gone again");
}

// shows: kernel.profile.jog.jump-following-error
#[test]
fn a_velocity_jump_of_a_jog_is_controlled_out() {
    let mut m = mill();
    let p = m.parameters_mut(0);
    (p.jvl, p.jac, p.jog_brake) = (100.0, 1000.0, 1000.0);
    let x = AxisList::new(&[0]);
    m.ja(&x, &[300.0]);
    m.run(400);
    let target = m.status().axes[0].dp + 1.0; // 5 mm would be needed to brake
    m.ja(&x, &[target]);
    let errors = errors(&mut m, 1000);
    assert!(most(&errors) > 0.02);
    assert!(most(&errors[500..]) < 0.1 * most(&errors));
    close(m.status().axes[0].dp, target, 0.0);
}
