//! rw_MOS, the operating system of the APCI-8001/8008 motion controllers, as an emulator.
//!
//! Nothing in this crate reads a clock, a random source or the environment: the same job, machine
//! and inputs give the same trace to the last bit. Emulated time is an integer sample counter.
//! Chapters named in comments are those of the manufacturer's programming manual.

pub mod autocode;
pub mod axes;
pub mod machine;
pub mod registers;
pub mod units;
