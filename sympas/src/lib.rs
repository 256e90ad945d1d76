//! rw_SymPas: the language of stand-alone jobs (chapters 5 and 6 of the programming manual).

pub mod ast;
pub mod catalogue;
pub mod diagnostics;
pub mod lexer;
pub mod parser;
pub mod source;
pub mod token;
