//! Recordings of runs in MCAP (design 3.5, D31): readable by the stock readers and by Foxglove as they are.
//!
//! | what | where |
//! |---|---|
//! | job and machine text, modal states, run arguments, translated sequence | attachments at the start: a file cut off later still has them |
//! | a sequence of more than 65,536 commands | further attachments `sequence.1.npz` ..., each before the samples that are on it |
//! | every sample, full rate | topic `/columns`, about 1,000 samples a message, packed ([`columns`]) |
//! | a thinned channel for plots | topic `/state`, JSON, one message a sample |
//! | alarms, outputs, what the program announced | topic `/events`, JSON |
//! | resources that `run --scan` names | topic `/scan`, JSON, every sample, `dp.X` as `dp_X` |
//! | the result object of the run | attachment `result.json` at the end |
//!
//! Message times are emulated nanoseconds from 0. No clock is read: the same run gives the same bytes.

pub mod columns;
mod mcap_file;
mod packed;
mod reader;
mod scan;
mod state;
mod writer;

pub use columns::{Columns, ColumnsView};
pub use reader::{Item, Reader};
pub use writer::{Attached, Content, Header, Writer};

use std::fmt;

/// Topics of a recording.
pub const COLUMNS: &str = "/columns";
pub const STATE: &str = "/state";
pub const EVENTS: &str = "/events";
pub const SCAN: &str = "/scan";
/// Profile in the MCAP header, by which we know our own.
pub const PROFILE: &str = "cnc-front";

/// Why a recording cannot be written or read.
#[derive(Debug)]
pub enum Error {
    Io(std::io::Error),
    Mcap(mcap::McapError),
    /// Not one of our recordings, or a message that contradicts itself.
    Content(String),
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::Io(error) => write!(f, "{error}"),
            Error::Mcap(error) => write!(f, "{error}"),
            Error::Content(what) => f.write_str(what),
        }
    }
}

impl std::error::Error for Error {}

impl From<std::io::Error> for Error {
    fn from(error: std::io::Error) -> Self {
        Error::Io(error)
    }
}
impl From<mcap::McapError> for Error {
    fn from(error: mcap::McapError) -> Self {
        match error {
            mcap::McapError::Io(error) => Error::Io(error),
            other => Error::Mcap(other),
        }
    }
}
