//! The texts of a program that the compilation holds itself.

use std::cell::OnceCell;

/// What was read of the program; it lives as long as the compilation.
pub struct Files {
    /// The main file, where it is read in windows at first.
    pub main: OnceCell<Vec<u8>>,
    /// Name and text of the others.
    pub slots: Vec<OnceCell<(String, Vec<u8>)>>,
}

const MAX_FILES: usize = 256;

impl Default for Files {
    fn default() -> Self {
        Files { main: OnceCell::new(), slots: (0..MAX_FILES).map(|_| OnceCell::new()).collect() }
    }
}
