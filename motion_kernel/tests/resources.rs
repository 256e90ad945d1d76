//! The resource interface from inside: scans and data blocks are the same in chunks of any size, and what is refused
//! changes nothing.

mod common;

use common::*;
use motion_kernel::Mcu;
use motion_kernel::machine::Machine;
use motion_kernel::registers::Options;
use motion_kernel::resources::{Code, OVERFLOW, ObjectDescriptor, READ, Type, WRITE};
use motion_kernel::stimulus::Stimulus;
use motion_kernel::trace::Trace;

/// mill3 on a board for DMA-RTS, in motion, with a strobe of 10 kHz.
fn moving() -> Mcu {
    let mut m = mcu_of(Machine::builtin(), LOOKAHEAD);
    m.resources_mut().options = Options::RESOURCE | Options::DMARTS | Options::EP1K50;
    m.add_stimulus(&Stimulus::parse("at 10 ms: input 14 pulsing 10 kHz", &["X", "Y", "Z"]).expect("valid"));
    line(&mut m, &[20.0, -10.0, 0.0], 50.0, 500.0, 0.0);
    m.ssms(m.all_axes());
    m
}

/// A descriptor that was read once.
fn ready(m: &mut Mcu, mut d: ObjectDescriptor) -> ObjectDescriptor {
    let read =
        if d.data_type == Type::Double as i32 { m.rdOptionDbl(&mut d).map(|_| 0) } else { m.rdOptionInt(&mut d) };
    assert!(matches!(read, Ok(_) | Err(Code::Busy)), "{read:?}");
    d
}

fn block(m: &mut Mcu, rows: i32) -> ObjectDescriptor {
    ready(m, ObjectDescriptor::new(8013, 2 | 3 << 16, rows, Type::DataBlock, READ))
}

/// Scans dp, the following error and a data block over 400 samples, in chunks.
fn scanned(chunks: &[u64]) -> (Vec<f64>, Vec<u8>, Vec<f64>) {
    let mut m = moving();
    let dp = ready(&mut m, ObjectDescriptor::new(1, 0, 0, Type::Double, READ));
    let error = ready(&mut m, ObjectDescriptor::new(7, 1, 0, Type::Double, READ));
    let block = block(&mut m, 14);
    m.scan(&[("dp".into(), dp), ("block".into(), block), ("error".into(), error)]).expect("all can be scanned");
    let mut init = ObjectDescriptor::new(8001, 0, 0, Type::Integer, WRITE);
    assert_eq!(m.wrOptionInt(&mut init, 1), Code::Ok);
    let (mut values, mut blocks, mut dps) = (Vec::new(), Vec::new(), Vec::new());
    let mut trace = Trace::new(3, 400);
    for n in chunks {
        m.pass(*n, &mut trace);
        values.extend_from_slice(&trace.scan.values);
        blocks.extend_from_slice(&trace.scan.blocks);
        dps.extend(trace.dp.iter().step_by(3));
    }
    (values, blocks, dps)
}

#[test]
fn scans_do_not_depend_on_chunks() {
    let whole = scanned(&[400]);
    assert_eq!(whole.0.iter().step_by(2).copied().collect::<Vec<_>>(), whole.2);
    assert!(whole.0[700] != whole.0[698] && whole.0[1] != whole.0[701]);
    let bytes = 16 + 14 * 2 * 8;
    assert_eq!(whole.1.len(), 400 * bytes);
    let count = |k: usize| i32::from_le_bytes(whole.1[k * bytes..][..4].try_into().expect("4 bytes"));
    assert_eq!((0..400).map(count).sum::<i32>(), ((400.0 * 1.28 - 10.0) * 10.0) as i32);
    for chunks in [vec![1; 400], vec![7, 393], vec![399, 1]] {
        assert!(scanned(&chunks) == whole, "{} chunks", chunks.len());
    }
}

/// Scanning and latching look on: the motion is the same to the last bit.
#[test]
fn watching_changes_no_motion() {
    let (mut plain, mut watched) = (moving(), moving());
    let block = block(&mut watched, 14);
    watched.scan(&[("block".into(), block)]).expect("a block can be scanned");
    watched.wrOptionInt(&mut ObjectDescriptor::new(8001, 0, 0, Type::Integer, WRITE), 1);
    let (mut a, mut b) = (Trace::new(3, 500), Trace::new(3, 500));
    plain.pass(500, &mut a);
    watched.pass(500, &mut b);
    assert!(a.scan.blocks.is_empty() && !b.scan.blocks.is_empty());
    assert_eq!((a.dp, a.load, a.rp), (b.dp, b.load, b.rp));
}

#[test]
fn what_cannot_be_scanned_changes_nothing() {
    let mut m = moving();
    let dp = ready(&mut m, ObjectDescriptor::new(1, 0, 0, Type::Double, READ));
    m.scan(&[("dp".into(), dp)]).expect("dp can be scanned");
    let fresh = ObjectDescriptor::new(2, 0, 0, Type::Double, READ);
    let foreign = ObjectDescriptor { index: 1, ..dp };
    let writing = ObjectDescriptor::new(12, 0, 0, Type::Integer, WRITE);
    let wide = ObjectDescriptor { handle: 0, index: 9 | 3 << 16, ..block(&mut m, 14) };
    for (d, code) in [(fresh, Code::Unknown), (foreign, Code::Unknown), (writing, Code::Unknown), (wide, Code::Unknown)]
    {
        assert_eq!(m.scan(&[("dp".into(), dp), ("x".into(), d)]), Err((1, code)), "{d:?}");
    }
    let many: Vec<_> = (0..65).map(|n| (n.to_string(), dp)).collect();
    assert_eq!(m.scan(&many), Err((64, Code::State)));
    let mut trace = Trace::new(3, 10);
    m.pass(10, &mut trace);
    assert_eq!((trace.scan.values.len(), trace.scan.layout.names.len()), (10, 1));
}

/// Rows that nobody takes are bounded, and their loss is told.
#[test]
fn waiting_rows_are_bounded() {
    let mut m = moving();
    m.wrOptionInt(&mut ObjectDescriptor::new(8001, 0, 0, Type::Integer, WRITE), 1);
    m.run(5000);
    let mut waiting = ObjectDescriptor::new(8010, 0, 0, Type::Integer, READ);
    assert_eq!(m.rdOptionInt(&mut waiting), Ok(1024));
    let block = block(&mut m, 128);
    m.scan(&[("block".into(), block)]).expect("a block can be scanned");
    let mut trace = Trace::new(3, 2);
    m.pass(2, &mut trace);
    let bytes = trace.scan.blocks.len() / 2;
    let head =
        |k: usize, at: usize| i32::from_le_bytes(trace.scan.blocks[k * bytes + at..][..4].try_into().expect("4"));
    assert_eq!((head(0, 0), head(0, 4), head(1, 4)), (128, OVERFLOW, 0));
}
