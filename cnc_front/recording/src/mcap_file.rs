//! The file of a recording: columns, states, events and attachments as MCAP records.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Read};
use std::path::Path;

use mcap::records::{AttachmentHeader, MessageHeader};

use crate::columns::ColumnsView;
use crate::writer::{Attached, Content, Header};
use crate::{COLUMNS, EVENTS, Error, PROFILE, SCAN, STATE, scan, state};

/// Samples per `/columns` message.
const PER_MESSAGE: usize = 1000;

/// zstd's fast levels are negative, and the library hands the number on as it is. What packing leaves is mostly noise to a
/// compressor: -12 makes the file a quarter larger and saves a twentieth of the time.
const COMPRESSION_LEVEL: i32 = -3;

/// A recording being written. Without [`McapFile::finish`] the file has no index, but all that was written so far.
pub(crate) struct McapFile {
    mcap: mcap::Writer<BufWriter<File>>,
    axes: Vec<String>,
    sample_time_s: f64,
    resolution: Vec<f64>,
    columns: u16,
    state: u16,
    events: u16,
    scan: Option<u16>,
    scanned: Vec<String>,
    sequence: [u32; 4],
    buffer: Vec<u8>,
    text: Vec<u8>,
}

const EVENT_SCHEMA: &str = concat!(
    r#"{"type":"object","title":"Event","properties":{"t_s":{"type":"number"},"kind":{"type":"string"},"#,
    r#""axis":{"type":"string"},"name":{"type":"string"},"on":{"type":"boolean"},"line":{"type":"integer"},"#,
    r#""value":{"type":"integer"},"text":{"type":"string"}}}"#
);

impl McapFile {
    /// Creates the file (an existing one is replaced) and writes all that is known before the run.
    pub fn create(path: &Path, header: &Header) -> Result<McapFile, Error> {
        let options = mcap::WriteOptions::new()
            .profile(PROFILE)
            .library("cnc-front")
            .compression(Some(mcap::Compression::Zstd))
            .compression_level(COMPRESSION_LEVEL as u32)
            .compression_threads(0);
        let mut mcap = options.create(BufWriter::with_capacity(1 << 20, File::create(path)?))?;
        for attached in &header.attachments {
            attach(&mut mcap, attached)?;
        }
        let metadata = mcap::records::Metadata { name: "run".to_owned(), metadata: header.metadata.clone() };
        mcap.write_metadata(&metadata)?;
        let state_schema = mcap.add_schema("cnc_front.State", "jsonschema", state::schema(&header.axes).as_bytes())?;
        let event_schema = mcap.add_schema("cnc_front.Event", "jsonschema", EVENT_SCHEMA.as_bytes())?;
        let none = BTreeMap::new();
        let scan = match &header.scan[..] {
            [] => None,
            names => {
                let schema = mcap.add_schema("cnc_front.Scan", "jsonschema", scan::schema(names).as_bytes())?;
                Some(mcap.add_channel(schema, SCAN, "json", &none)?)
            }
        };
        Ok(McapFile {
            columns: mcap.add_channel(0, COLUMNS, "cnc-front.columns.2", &none)?,
            state: mcap.add_channel(state_schema, STATE, "json", &none)?,
            events: mcap.add_channel(event_schema, EVENTS, "json", &none)?,
            mcap,
            axes: header.axes.clone(),
            sample_time_s: header.sample_time_s,
            resolution: header.resolution.clone(),
            scan,
            scanned: header.scan.clone(),
            sequence: [0; 4],
            buffer: Vec::new(),
            text: Vec::new(),
        })
    }

    /// Writes samples: full rate, and thinned for plots.
    pub fn write_samples(&mut self, view: &ColumnsView) -> Result<(), Error> {
        for from in (0..view.len()).step_by(PER_MESSAGE) {
            let part = view.slice(from, (from + PER_MESSAGE).min(view.len()));
            self.buffer.clear();
            part.encode(&self.resolution, &mut self.buffer);
            let (channel, time) = (self.columns, self.time_ns(part.first_sample + 1));
            let buffer = std::mem::take(&mut self.buffer);
            self.message(0, channel, time, &buffer)?;
            self.buffer = buffer;
            self.write_states(&part)?;
        }
        Ok(())
    }

    /// The thinned channel goes between the columns, so that the file stays in the order of time.
    fn write_states(&mut self, part: &ColumnsView) -> Result<(), Error> {
        for k in state::chosen(part) {
            let mut text = std::mem::take(&mut self.text);
            text.clear();
            state::message(part, k, &self.axes, self.sample_time_s, &mut text);
            let (channel, time) = (self.state, self.time_ns(part.first_sample + k as u64 + 1));
            self.message(1, channel, time, &text)?;
            self.text = text;
        }
        Ok(())
    }

    /// Writes rows of the scanner.
    pub fn write_scan(&mut self, first_sample: u64, values: &[f64]) -> Result<(), Error> {
        let Some(channel) = self.scan else { return Ok(()) };
        for (row, sample) in values.chunks_exact(self.scanned.len()).zip(first_sample + 1..) {
            let mut text = std::mem::take(&mut self.text);
            text.clear();
            scan::message(sample as f64 * self.sample_time_s, &self.scanned, row, &mut text);
            self.message(3, channel, self.time_ns(sample), &text)?;
            self.text = text;
        }
        Ok(())
    }

    /// Writes an event (a JSON object) at an emulated time.
    pub fn write_event(&mut self, t_s: f64, json: &str) -> Result<(), Error> {
        let channel = self.events;
        self.message(2, channel, nanoseconds(t_s), json.as_bytes())
    }

    /// Attaches a file, behind what was written so far.
    pub fn attach(&mut self, attached: &Attached<Content>) -> Result<(), Error> {
        attach(&mut self.mcap, attached)
    }

    /// Adds the result and closes the file.
    pub fn finish(mut self, result_json: &str) -> Result<(), Error> {
        let result = Attached {
            name: "result.json".to_owned(),
            media_type: "application/json".to_owned(),
            data: Content::Bytes(result_json.as_bytes().to_vec()),
        };
        self.attach(&result)?;
        self.mcap.finish()?;
        self.mcap.into_inner().into_inner().map_err(|error| Error::Io(error.into_error()))?;
        Ok(())
    }

    fn time_ns(&self, samples: u64) -> u64 {
        nanoseconds(samples as f64 * self.sample_time_s)
    }

    fn message(&mut self, stream: usize, channel_id: u16, time_ns: u64, data: &[u8]) -> Result<(), Error> {
        let sequence = self.sequence[stream];
        self.sequence[stream] += 1;
        let header = MessageHeader { channel_id, sequence, log_time: time_ns, publish_time: time_ns };
        Ok(self.mcap.write_to_known_channel(&header, data)?)
    }
}

fn nanoseconds(t_s: f64) -> u64 {
    (t_s * 1e9).round() as u64
}

fn attach(mcap: &mut mcap::Writer<BufWriter<File>>, attached: &Attached<Content>) -> Result<(), Error> {
    let Attached { name, media_type, data } = attached;
    let header = AttachmentHeader { log_time: 0, create_time: 0, name: name.clone(), media_type: media_type.clone() };
    match data {
        Content::Bytes(bytes) => {
            mcap.start_attachment(bytes.len() as u64, header)?;
            mcap.put_attachment_bytes(bytes)?;
        }
        Content::File(path) => {
            let mut file = File::open(path)?;
            let mut left = file.metadata()?.len();
            mcap.start_attachment(left, header)?;
            let mut piece = vec![0; 1 << 16];
            while left > 0 {
                let most = piece.len().min(left as usize);
                file.read_exact(&mut piece[..most])?;
                mcap.put_attachment_bytes(&piece[..most])?;
                left -= most as u64;
            }
        }
    }
    Ok(mcap.finish_attachment()?)
}
