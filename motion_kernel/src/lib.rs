//! rw_MOS, the operating system of the APCI-8001/8008 motion controllers, as an emulator.
//!
//! Nothing in this crate reads a clock, a random source or the environment: the same job, machine
//! and inputs give the same trace to the last bit. Emulated time is an integer sample counter.
//! Chapters named in comments are those of the manufacturer's programming manual.

pub mod analysis;
mod attention;
pub mod autocode;
pub mod axes;
pub mod axis;
mod blocks;
pub mod card;
pub mod cause;
pub mod circle_3d;
pub mod controller;
mod cycle;
mod direct;
pub mod functions;
mod gear;
mod hold;
pub mod homing;
mod io;
mod latch;
pub mod limits;
pub mod listing;
pub mod lookahead;
pub mod machine;
pub mod mcu;
pub mod motion;
pub mod named;
mod offsets;
pub mod path;
mod pcap;
pub mod plant;
pub mod points;
mod port;
pub mod position_loop;
pub mod profile;
mod profile_check;
pub mod qualifiers;
pub mod registers;
pub mod resources;
pub mod sap;
pub mod spooler;
pub mod status;
pub mod stimulus;
mod strobes;
pub mod tasks;
pub mod trace;
pub mod trajectory;
pub mod units;
pub mod zero;

pub use mcu::{Advanced, Mcu, Stop};
