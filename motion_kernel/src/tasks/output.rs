//! What a task writes: its output string for the PC (4.4.13, 4.4.14, 6.6.79, 6.6.80), and all of it in order.

/// Bytes that are kept until the application takes them; what is written beyond is lost.
const KEPT: usize = 64 * 1024;
/// Most bytes of one reading of the output string (4.4.14).
pub const STRING: usize = 512;

/// Output of one task.
#[derive(Debug, Default)]
pub struct Output {
    string: String,
    /// tskinfo: bit 0 an unfinished string is pending, bit 1 a finished one.
    info: u32,
    all: String,
}

impl Output {
    pub(crate) fn reserved() -> Output {
        Output { string: String::with_capacity(STRING), info: 0, all: String::with_capacity(KEPT) }
    }
    /// Appends to the output string; behind a finished one a new string begins.
    pub(crate) fn append(&mut self, text: &str) {
        if self.info & 2 != 0 {
            self.string.clear();
        }
        self.info = 1;
        push(&mut self.string, text, STRING);
        push(&mut self.all, text, KEPT);
    }
    /// Closes the output string (writeln).
    pub(crate) fn close(&mut self) {
        if self.info & 2 != 0 {
            self.string.clear();
        }
        self.info = 2;
        push(&mut self.all, "\n", KEPT);
    }
    /// tskinfo (gettskinfo).
    pub fn info(&self) -> u32 {
        self.info
    }
    /// The output string, at most [`STRING`] bytes; reading it clears tskinfo (gettskstr).
    pub fn take_string(&mut self) -> String {
        self.info = 0;
        std::mem::replace(&mut self.string, String::with_capacity(STRING))
    }
    /// Everything written since the last call, lines closed by a line feed.
    pub(crate) fn take_all(&mut self) -> String {
        std::mem::replace(&mut self.all, String::with_capacity(KEPT))
    }
}

/// Appends what fits, whole characters only.
fn push(to: &mut String, text: &str, most: usize) {
    let room = most.saturating_sub(to.len()).min(text.len());
    let fits = (0..=room).rev().find(|&n| text.is_char_boundary(n)).unwrap_or(0);
    to.push_str(&text[..fits]);
}

/// Values are formatted in place: a task does not allocate.
impl std::fmt::Write for Output {
    fn write_str(&mut self, text: &str) -> std::fmt::Result {
        self.append(text);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // shows: pcap.gettskstr.max-512
    #[test]
    fn a_finished_string_is_followed_by_a_new_one() {
        let mut output = Output::reserved();
        output.append("a");
        output.append("b");
        assert_eq!(output.info(), 1);
        output.close();
        assert_eq!(output.info(), 2);
        output.append("c");
        assert_eq!((output.info(), output.take_string().as_str()), (1, "c"));
        assert_eq!(output.info(), 0);
        assert_eq!(output.take_all(), "ab\nc");
        output.append(&"ü".repeat(300)); // two bytes each: 256 fit
        assert_eq!(output.take_string().chars().count(), 256);
    }
}
