//! DIN 66025 part programs -> autocode (docs/dialect.md).
//!
//! Lines go through one after the other: text -> block ([`parser`]) -> modal state and motions
//! ([`translate`]) -> merging and junctions ([`sink`]) -> autocode. The crate knows no axis state,
//! only modal state; dynamics live in the kernel (design D22).

// several points and tables run in parallel by slot
#![allow(clippy::needless_range_loop)]

mod aftermath;
pub mod arc;
mod arithmetic;
pub mod block;
mod catalogue;
pub mod codes;
pub mod correction;
mod cycles;
mod cylinder;
pub mod diagnostics;
pub mod dialect;
pub mod expression;
pub mod facts;
mod feed;
mod files;
pub mod flow;
pub mod frame;
pub mod group;
mod index;
mod late;
mod lint;
mod listing;
mod loops;
mod merging;
pub mod mfunc;
pub mod modal;
mod motion;
pub mod number;
mod offset_path;
mod offsets;
mod once;
mod outputs;
pub mod parser;
mod part;
mod pieces;
pub mod program;
mod report;
mod rules;
mod seen;
mod segments;
pub mod sequence;
mod sheet;
pub mod sink;
pub mod source;
mod spindle;
mod statements;
mod stray;
pub mod stream;
mod system;
mod tape;
mod target;
mod threads;
mod tool;
pub mod translate;
pub mod variables;
mod write;

pub use diagnostics::{CATALOGUE, Diagnostic, Id};
pub use dialect::{Library, Limits, Options};
pub use facts::Facts;
pub use once::{Input, MOST_CHANGES, Open, WINDOW, compile_once};
pub use part::{At, Start};
pub use pieces::Pieces;
pub use program::{Compiled, compile};
pub use segments::Deliver;
pub use sequence::{SequenceColumns, Sequencer, sequence};
pub use sheet::{Sheet, listing_json};
