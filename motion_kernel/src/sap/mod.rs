//! rw_SymPas in the controller (chapters 3.2, 5, 6): what its compiler emits and how a CNC task executes it.
//!
//! The contract between the compiler (crate `sympas`) and the controller:
//!
//! - [`tables`] holds every predefined name: system parameters, axis qualifiers, bits, functions, commands, events.
//!   Compiler, controller and documentation read the same lines.
//! - [`program::Program`] is the compiled program. Its code is register code: each instruction names the slots it reads
//!   and writes. A [`code::Slot`] with bit 15 set is global, any other belongs to the frame of the running routine.
//! - A slot holds 64 bits: Integer as sign-extended i32, Timer as zero-extended u32, Boolean as 0 or 1, Single and
//!   Double as the bits of an f64 (a Single is rounded when stored: [`code::Instr::RoundS`]). Literals are globals with
//!   an initial value, axis names and AXIS variables are globals holding the axis number: `A1.an` is that slot.
//! - The main program is routine 0; its variables are globals. A call puts the arguments into the slots of the caller's
//!   frame from `base` on: a procedure finds them as its slots 0, 1, ...; a function has its result in slot 0 and its
//!   parameters from slot 1 on, so the caller finds the result in `base`. The result and the rest of a new frame are 0.
//! - Each statement begins with [`code::Instr::Statement`]: there the task counts its share of the sample, serves
//!   events, steps and breaks. Temporaries do not live across it, loop bounds do.
//! - A conditional instruction (`If...`) executes the instruction behind it, a jump, when its condition is **false**,
//!   and skips that jump when it is true.
//! - [`verify::verify`] accepts only what cannot harm the controller; the machine checks the rest as it runs (table 40).

mod access;
mod actions;
pub mod code;
mod commands;
mod compute;
pub mod events;
pub(crate) mod processor;
pub mod program;
pub mod tables;
pub mod verify;

pub use access::Parameters;
