//! Reading a recording from front to back in bounded memory; what is left of a damaged one is given as far as it
//! goes.

use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::io::Read;
use std::path::Path;

use mcap::records::Record;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};

use crate::writer::Attached;
use crate::{COLUMNS, Columns, EVENTS, Error, PROFILE};

/// Records longer than this are damage, not data.
const RECORD_LIMIT: usize = 1 << 30;

/// One thing found in a recording, in the order of the file.
#[derive(Clone, Debug, PartialEq)]
pub enum Item {
    Attachment(Attached),
    Metadata(String, BTreeMap<String, String>),
    Columns(Columns),
    /// JSON text of an event.
    Event(String),
}

/// A recording being read.
pub struct Reader {
    file: File,
    linear: LinearReader,
    topics: HashMap<u16, String>,
    known: bool,
    /// Why reading ended before the end of the file, if it did.
    pub damage: Option<String>,
}

impl Reader {
    /// Opens a recording.
    ///
    /// # Errors
    /// If the file cannot be opened. A file that is no recording is found at the first [`Reader::next_item`].
    pub fn open(path: &Path) -> Result<Reader, Error> {
        let options =
            LinearReaderOptions::default().with_validate_chunk_crcs(true).with_record_length_limit(RECORD_LIMIT);
        Ok(Reader {
            file: File::open(path)?,
            linear: LinearReader::new_with_options(options),
            topics: HashMap::new(),
            known: false,
            damage: None,
        })
    }

    /// The next item, or None at the end; at a truncated or damaged place `damage` says what is wrong there.
    ///
    /// # Errors
    /// If the file is no recording of ours.
    pub fn next_item(&mut self) -> Result<Option<Item>, Error> {
        loop {
            let found = match self.linear.next_event() {
                None => return self.ended(None),
                Some(Err(error)) => return self.ended(Some(error.to_string())),
                Some(Ok(LinearReadEvent::ReadRequest(need))) => {
                    let got = self.file.read(self.linear.insert(need))?;
                    self.linear.notify_read(got);
                    continue;
                }
                Some(Ok(LinearReadEvent::Record { data, opcode })) => match mcap::parse_record(opcode, data) {
                    Err(error) => return self.ended(Some(error.to_string())),
                    Ok(record) => Self::item(record, &mut self.topics, &mut self.known),
                },
            };
            match found {
                Ok(None) => {}
                Ok(item) => return self.checked(item),
                Err(error) => return self.ended(Some(error.to_string())),
            }
        }
    }

    fn item(record: Record<'_>, topics: &mut HashMap<u16, String>, known: &mut bool) -> Result<Option<Item>, Error> {
        match record {
            Record::Header(header) => *known = header.profile == PROFILE,
            Record::Channel(channel) => {
                topics.insert(channel.id, channel.topic);
            }
            Record::Attachment { header, data, .. } => {
                let attached = Attached { name: header.name, media_type: header.media_type, data: data.into_owned() };
                return Ok(Some(Item::Attachment(attached)));
            }
            Record::Metadata(metadata) => return Ok(Some(Item::Metadata(metadata.name, metadata.metadata))),
            Record::Message { header, data } => match topics.get(&header.channel_id).map(String::as_str) {
                Some(COLUMNS) => return Ok(Some(Item::Columns(Columns::decode(&data)?))),
                Some(EVENTS) => return Ok(Some(Item::Event(String::from_utf8_lossy(&data).into_owned()))),
                _ => {}
            },
            _ => {}
        }
        Ok(None)
    }

    fn checked(&self, item: Option<Item>) -> Result<Option<Item>, Error> {
        if self.known { Ok(item) } else { Err(Self::foreign()) }
    }
    fn ended(&mut self, damage: Option<String>) -> Result<Option<Item>, Error> {
        if !self.known {
            return Err(Self::foreign());
        }
        self.damage = self.damage.take().or(damage);
        Ok(None)
    }
    fn foreign() -> Error {
        Error::Content("not a recording of cnc-front".to_owned())
    }
}
