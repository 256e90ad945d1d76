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

/// No record or unpacked chunk of ours is longer than this or than the whole file: anything else is damage.
const CHUNK_LIMIT: u64 = 16 << 20;
const RECORD_LIMIT: u64 = 1 << 30;

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
    next_sample: u64,
    axes: Option<usize>,
    /// Only attachments whose names begin so are asked for.
    only: Option<String>,
    /// Why reading ended before the end of the file, if it did.
    pub damage: Option<String>,
}

impl Reader {
    /// Opens a recording.
    ///
    /// # Errors
    /// If the file cannot be opened. A file that is no recording is found at the first [`Reader::next_item`].
    pub fn open(path: &Path) -> Result<Reader, Error> {
        let file = File::open(path)?;
        let limit = file.metadata()?.len().clamp(CHUNK_LIMIT, RECORD_LIMIT) as usize;
        // checked before a chunk is unpacked: no damaged sample ever comes out
        let options = LinearReaderOptions::default().with_prevalidate_chunk_crcs(true).with_record_length_limit(limit);
        Ok(Reader {
            file,
            linear: LinearReader::new_with_options(options),
            topics: HashMap::new(),
            known: false,
            next_sample: 0,
            axes: None,
            only: None,
            damage: None,
        })
    }

    /// As [`Reader::open`]; nothing is told but the attachments whose names begin with `prefix`.
    pub fn attachments(path: &Path, prefix: &str) -> Result<Reader, Error> {
        Ok(Reader { only: Some(prefix.to_owned()), ..Reader::open(path)? })
    }

    /// The next item, or None at the end; at a truncated or damaged place `damage` says what is wrong there.
    ///
    /// # Errors
    /// If the file is no recording of ours.
    pub fn next_item(&mut self) -> Result<Option<Item>, Error> {
        if self.damage.is_some() {
            return Ok(None);
        }
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
                    Ok(Record::Message { .. }) if self.only.is_some() => Ok(None),
                    Ok(Record::Attachment { header, .. })
                        if self.only.as_ref().is_some_and(|prefix| !header.name.starts_with(prefix)) =>
                    {
                        Ok(None)
                    }
                    Ok(record) => Self::item(record, &mut self.topics, &mut self.known),
                },
            };
            match found {
                Ok(None) => {}
                Ok(Some(Item::Columns(columns))) if !self.follow_on(&columns) => {
                    return self.ended(Some("samples are missing here".to_owned()));
                }
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

    /// True if these columns continue those before; then they count as read.
    fn follow_on(&mut self, columns: &Columns) -> bool {
        let continues =
            columns.first_sample == self.next_sample && *self.axes.get_or_insert(columns.axes) == columns.axes;
        self.next_sample = columns.first_sample.saturating_add(columns.flags.len() as u64);
        continues
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
