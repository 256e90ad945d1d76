//! Whatever an application calls, in whatever order: no panic, no hang, nothing leaks, no axis is where it cannot be.

mod common;

use common::contour::{Block, block, place, try_enter};
use common::*;
use motion_kernel::Mcu;
use motion_kernel::autocode::MoveKind;
use motion_kernel::axes::{AxisList, AxisSet};
use motion_kernel::registers::{Axst, ModeReg};
use motion_kernel::trace::Trace;
use proptest::prelude::*;

#[derive(Clone, Debug)]
enum Call {
    Spool(Block),
    SpoolOne(usize, f64, f64),
    Ssf(usize, u16, f64),
    Ssms(u32),
    Sstps(u32),
    Sdels(u32),
    Ms(u32),
    Js(u32),
    Ja(usize, f64),
    Direct(f64, f64),
    Hold,
    HoldAtBlockEnd,
    StepBlock,
    Resume,
    Acknowledge,
    ClearCi99,
    Abort,
    Override(u32, f64, f64),
    Wrjovr(usize, f64),
    Modereg(u32),
    Cl(u32),
    Ol(u32),
    Run(u64),
}

fn call() -> impl Strategy<Value = Call> {
    let axis = || 0usize..3;
    let set = || prop_oneof![4 => Just(7u32), 1 => 1u32..8];
    let way = || -20.0..20.0f64;
    prop_oneof![
        10 => block().prop_map(Call::Spool),
        1 => (axis(), way(), prop_oneof![Just(0.0), -30.0..60.0f64]).prop_map(|(a, x, v)| Call::SpoolOne(a, x, v)),
        2 => (axis(), prop_oneof![Just(1000u16), Just(1003), Just(1004), Just(1005), Just(1006), Just(1025), Just(2001), Just(7)], 0.0..3000.0f64)
            .prop_map(|(a, n, v)| Call::Ssf(a, n, v)),
        6 => set().prop_map(Call::Ssms),
        1 => set().prop_map(Call::Sstps),
        1 => set().prop_map(Call::Sdels),
        1 => set().prop_map(Call::Ms),
        1 => set().prop_map(Call::Js),
        1 => (axis(), way()).prop_map(|(a, x)| Call::Ja(a, x)),
        1 => (way(), way()).prop_map(|(x, y)| Call::Direct(x, y)),
        2 => Just(Call::Hold),
        2 => Just(Call::HoldAtBlockEnd),
        2 => Just(Call::StepBlock),
        4 => Just(Call::Resume),
        1 => Just(Call::Acknowledge),
        1 => Just(Call::ClearCi99),
        1 => Just(Call::Abort),
        1 => (set(), 0.1..1.5f64, 0.0..0.3f64).prop_map(|(s, f, t)| Call::Override(s, f, t)),
        1 => (axis(), 0.5..1.5f64).prop_map(|(a, f)| Call::Wrjovr(a, f)),
        1 => prop_oneof![Just(LOOKAHEAD.0), Just(EXACT.0), Just(LOOKAHEAD.0 | 2), Just(LOOKAHEAD.0 | 1 << 28), Just(0)].prop_map(Call::Modereg),
        1 => set().prop_map(Call::Cl),
        1 => (1u32..8).prop_map(Call::Ol),
        12 => (1u64..400).prop_map(Call::Run),
    ]
}

fn obey(m: &mut Mcu, call: &Call) {
    match *call {
        Call::Spool(ref block) => {
            let placed = place(std::slice::from_ref(block));
            _ = try_enter(m, &placed, 0);
        }
        Call::SpoolOne(a, x, tvl) => {
            _ = spool(m, MoveKind::Smlr, &AxisList::new(&[a]), &[x], [0.0; 2], 0.0, [30.0, 400.0, tvl])
        }
        Call::Ssf(a, number, value) => _ = m.ssf(a, number, value, 3),
        Call::Ssms(axes) => m.ssms(AxisSet(axes)),
        Call::Sstps(axes) => m.sstps(AxisSet(axes)),
        Call::Sdels(axes) => m.sdels(AxisSet(axes)),
        Call::Ms(axes) => m.ms(AxisSet(axes)),
        Call::Js(axes) => m.js(AxisSet(axes)),
        Call::Ja(a, x) => _ = m.ja(&AxisList::new(&[a]), &[x]),
        Call::Direct(x, y) => {
            let axes = xy();
            let targets = &[x, y];
            _ = m.direct(&motion_kernel::motion::MotionCommand {
                kind: MoveKind::Smla,
                axes: &axes,
                targets,
                center: [0.0; 2],
                phi: 0.0,
                vl: 40.0,
                ac: 300.0,
                tvl: 0.0,
                rapid: false,
                line: 9,
            });
        }
        Call::Hold => m.hold(),
        Call::HoldAtBlockEnd => m.hold_at_block_end(),
        Call::StepBlock => _ = m.step_block(),
        Call::Resume => m.resume(),
        Call::Acknowledge => m.acknowledge(),
        Call::ClearCi99 => m.ClearCI99(),
        Call::Abort => m.abort(),
        Call::Override(axes, factor, seconds) => {
            m.wrtrovrst(seconds);
            m.wrtrovr(factor);
            m.utrovr(AxisSet(axes));
        }
        Call::Wrjovr(a, factor) => _ = m.wrjovr(a, factor),
        Call::Modereg(bits) => m.set_modereg(ModeReg(bits)),
        Call::Cl(axes) => m.cl(AxisSet(axes)),
        Call::Ol(axes) => m.ol(AxisSet(axes)),
        Call::Run(samples) => {
            let mut trace = Trace::default();
            m.advance(samples, &mut trace);
            m.events();
            assert!(trace.dp.iter().chain(&trace.v_plan).chain(&trace.load).all(|x| x.is_finite()));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, ..ProptestConfig::default() })]

    #[test]
    fn any_order_of_calls_leaves_a_sound_controller(calls in prop::collection::vec(call(), 1..80)) {
        let mut m = mcu("XYZ", LOOKAHEAD);
        for call in &calls {
            obey(&mut m, call);
            for axis in m.status().axes {
                prop_assert!(axis.dp.is_finite() && axis.lsm <= axis.memory);
            }
        }
        // the operator's way out always works
        m.abort();
        m.js(set(&[0, 1, 2]));
        m.run(2000);
        let status = m.status();
        prop_assert!(status.stands && !status.holding, "{status:?}");
        prop_assert!(status.axes.iter().all(|a| a.lsm == a.memory && a.mcis == 0 && a.axst.has(Axst::pe)), "{status:?}");
        prop_assert_eq!(m.moves_in_use(), 0);
    }
}
