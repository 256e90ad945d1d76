//! Autocode files: what is written is read back, and nothing else is accepted.

mod support;

use proptest::prelude::*;
use support::compile;
use sympas::cnc::{CncError, decode, encode};
use sympas::listing::listing;

const JOB: &str = "
program Job;
{$TASK 2} {$FULLSYSTEM}
const sec = 15625;
var i : integer; s : single; t : timer; VA : axis;
function F(n : integer; d : double) : integer;
var k : integer;
begin
  for k := 1 to n do F := F + k;
  if d > 0.5 then F := -F;
end;
procedure EVEO; begin abort; end;
begin
  enev(EVEO);
  t := CLOCK + sec;
  VA.an := 1;
  i := F(3, 1.5) shl 2;
  s := single(i / 3.0);
  mlaw(A1 := 10.0, VA := s, TRVL := 25.0);
  while not A1.axstb.13 do wt(100);
  SysVarInt[i] := A2.varint[3];
  A1.digob.2 := A1.digib.1;
  wrcbs(4, s); CI7 := rdcbi(4); CD3 := power(2.0, sin(A1.rp));
  startcnct(1); azo(3); ssf(A1 := 1, SSFP := 10);
  writeln('i=', i, ' ', s, TRUE);
end.
";

fn file() -> Vec<u8> {
    encode(&compile(JOB).program.expect("a correct job"))
}

/// Puts the right length and checksum in front of a changed program.
fn sealed(mut file: Vec<u8>) -> Vec<u8> {
    let body = &file[18..];
    let mut sum = !0u32;
    for byte in body {
        sum ^= u32::from(*byte);
        for _ in 0..8 {
            sum = if sum & 1 == 1 { sum >> 1 ^ 0xEDB8_8320 } else { sum >> 1 };
        }
    }
    let length = body.len() as u32;
    file[10..14].copy_from_slice(&length.to_le_bytes());
    file[14..18].copy_from_slice(&(!sum).to_le_bytes());
    file
}

#[test]
fn a_program_survives_its_file() {
    let program = compile(JOB).program.expect("a correct job");
    let read = decode(&encode(&program)).expect("a good file");
    assert_eq!(read, program);
    assert_eq!((read.task, read.full_system, read.name.as_str()), (Some(2), true, "Job"));
    assert_eq!(sealed(file()), file());
}

// shows: runtime-error.0x0004, runtime-error.0x0020, runtime-error.0x0040, runtime-error.0x1000
#[test]
fn what_is_no_such_file_is_refused() {
    let good = file();
    assert_eq!(decode(b""), Err(CncError::Magic));
    assert_eq!(decode(JOB.as_bytes()), Err(CncError::Magic));
    let mut newer = good.clone();
    newer[8] = 2;
    assert_eq!(decode(&newer), Err(CncError::Version(2)));
    for length in 8..good.len() {
        assert!(matches!(decode(&good[..length]), Err(CncError::Damaged)), "{length}");
    }
    for at in 18..good.len() {
        let mut bad = good.clone();
        bad[at] ^= 0x10;
        assert_eq!(decode(&bad), Err(CncError::Damaged), "{at}");
    }
    // sealed anew, yet with what no controller knows
    let program = compile("begin js(A1); end.").program.expect("a correct job");
    let bytes = encode(&program);
    let entry = bytes.windows(2).position(|w| w == [120, 7]).expect("Do(js)");
    for (at, value) in [(entry, 255), (entry + 1, 200), (entry + 2, 9)] {
        let mut bad = bytes.clone();
        bad[at] = value;
        assert!(matches!(decode(&sealed(bad)), Err(CncError::Malformed(_) | CncError::Refused(_))), "{at}");
    }
    let mut handler = program;
    handler.events[2] = Some(5);
    assert!(matches!(decode(&encode(&handler)), Err(CncError::Refused(_))));
}

#[test]
fn the_disassembler_names_what_it_can() {
    let text = listing(&compile(JOB).program.expect("a correct job"));
    for part in [
        "program Job: task 2, FULLSYSTEM, 3 axes",
        "function 1 F: 2 parameters",
        "EVEO is handled by routine 2",
        "WriteSystem  TRVL, 25.0",
        "Do           mla (A1 := 10.0, VA := s)",
        "AwaitEnd",
        "WriteText    'i='",
        "line 17",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: support::fuzz_cases(2000), failure_persistence: None, ..ProptestConfig::default() })]

    /// Bytes changed anywhere, checksum mended: an error or a program that lists; never a panic.
    #[test]
    fn changed_files_never_panic(changes in prop::collection::vec((18usize..4000, any::<u8>()), 1..8), cut in 0usize..4000) {
        let mut bytes = file();
        for (at, value) in changes {
            let at = 18 + (at - 18) % (bytes.len() - 18);
            bytes[at] = value;
        }
        if cut < 500 {
            let length = bytes.len().saturating_sub(cut).max(18);
            bytes.truncate(length);
        }
        if let Ok(program) = decode(&sealed(bytes)) {
            prop_assert!(!listing(&program).is_empty());
            if usize::from(program.axes) <= support::axes().len() {
                support::controller::run(&program, 20); // whatever it does, the controller survives it
            }
        }
    }

    /// Slots of the wrong type: whatever bits stand where an Integer, a Double, a Boolean or an axis is read.
    #[test]
    fn any_bits_in_any_variable_are_a_value(bits in prop::collection::vec(prop_oneof![
        any::<u64>(), Just(u64::MAX), Just(f64::NAN.to_bits()), Just(1e300f64.to_bits()), Just(0x8000_0000), 0u64..6,
    ], 64)) {
        let mut program = compile(JOB).program.expect("a correct job");
        for (slot, bits) in program.globals.iter_mut().zip(&bits) {
            *slot = *bits;
        }
        for (constant, bits) in program.constants.iter_mut().zip(bits.iter().rev()) {
            *constant = *bits;
        }
        let program = decode(&encode(&program)).expect("every bit pattern is a value");
        support::controller::run(&program, 20);
    }

    #[test]
    fn any_bytes_are_no_program(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        let mut file = sympas::cnc::MAGIC.to_vec();
        file.extend([1, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
        file.extend(bytes);
        prop_assert!(decode(&sealed(file)).is_err());
    }
}
