//! Source text: the file of a job, the files that it includes, and places in them.

/// A place in the text. Lines and columns count from 1, columns in characters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Span {
    /// Index into [`Sources`].
    pub file: u16,
    pub line: u32,
    pub column: u32,
    /// Characters; a place that spans lines ends with its first one.
    pub length: u32,
}

impl Span {
    /// From the start of this place to the end of another one on the same line, else this place alone.
    pub fn to(self, end: Span) -> Span {
        let same = self.file == end.file && self.line == end.line && end.column >= self.column;
        let length = if same { end.column + end.length - self.column } else { self.length };
        Span { length, ..self }
    }
}

/// Where the texts come from: the disk, a test's table, an editor.
pub trait Loader {
    /// The bytes of `name` as written in `{$I name}` of the file `from`, and the name to show for it.
    ///
    /// # Errors
    /// The system's own text when there is no such file, or none that can be read.
    fn load(&mut self, name: &str, from: &str) -> Result<(String, Vec<u8>), String>;
}

/// A loader for texts without includes.
pub struct NoIncludes;

impl Loader for NoIncludes {
    fn load(&mut self, _: &str, _: &str) -> Result<(String, Vec<u8>), String> {
        Err("includes are not available here".to_owned())
    }
}

/// One text as it was read.
#[derive(Debug)]
pub struct File {
    pub name: String,
    pub text: String,
}

/// Every text of a compilation; number 0 is the job itself.
#[derive(Debug, Default)]
pub struct Sources {
    pub files: Vec<File>,
}

impl Sources {
    pub fn add(&mut self, name: String, text: String) -> u16 {
        self.files.push(File { name, text });
        (self.files.len() - 1) as u16
    }
    pub fn name(&self, file: u16) -> &str {
        &self.files[usize::from(file)].name
    }
    /// A line without its end; empty beyond the last.
    pub fn line(&self, file: u16, line: u32) -> &str {
        let rest = self.files.get(usize::from(file)).map_or("", |f| f.text.as_str());
        rest.lines().nth(line.saturating_sub(1) as usize).unwrap_or("")
    }
}

/// UTF-8 text, else Windows-1252 (old editors write umlauts in comments that way); a byte order mark is dropped.
pub fn decode(bytes: &[u8]) -> String {
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes.iter().map(|&b| char::from(b)).collect(),
    }
}
