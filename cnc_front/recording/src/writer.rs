//! Writing a recording while the run goes on, in a thread of its own.
//!
//! What is written is copied and put into a bounded queue; compressing and writing take about as long as the run
//! itself. Records reach the file in the order of the calls, so the same run gives the same bytes.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex};
use std::thread::{Builder, JoinHandle};

use crate::Error;
use crate::columns::{Columns, ColumnsView};
use crate::mcap_file::McapFile;

/// A file inside the recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Attached<D = Vec<u8>> {
    pub name: String,
    pub media_type: String,
    pub data: D,
}

/// The content of a file to be attached.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Content {
    Bytes(Vec<u8>),
    /// It is copied piece by piece.
    File(PathBuf),
}

/// What is known before the run.
#[derive(Clone, Debug, Default)]
pub struct Header {
    /// Axis names: 1 to 8 letters, digits or `_`.
    pub axes: Vec<String>,
    pub sample_time_s: f64,
    /// Axis units per count of the encoders, as far as it is known: positions are then packed as counts.
    pub resolution: Vec<f64>,
    /// Job, machine file, sequence.
    pub attachments: Vec<Attached<Content>>,
    /// Arguments of the run, kept as the metadata record `run`.
    pub metadata: BTreeMap<String, String>,
    /// Scanned resources; none: there is no topic for them.
    pub scan: Vec<String>,
}

/// Calls that may wait for the thread: enough that neither side waits for a short stop of the other, few enough that
/// memory stays bounded by a few chunks.
const QUEUE: usize = 2;

/// A recording being written. A call that fails for the thread's sake (no space left on the disk ...) returns the error
/// of an earlier one; [`Writer::finish`] returns what is left of them. Without `finish` the file has no index, but all
/// that was written so far; dropping waits until it is there.
pub struct Writer {
    axes: usize,
    thread: Option<Thread>,
    spare: Spare,
}

struct Thread {
    queue: SyncSender<Order>,
    handle: JoinHandle<Result<(), Error>>,
}

enum Order {
    Samples(Box<Columns>),
    /// First sample, and rows of the scanner.
    Scan(u64, Vec<f64>),
    Event(f64, String),
    Attach(Attached<Content>),
    Finish(String),
}

/// Columns that have been written, to be filled again.
type Spare = Arc<Mutex<Vec<Columns>>>;

impl Writer {
    /// Creates the file (an existing one is replaced) and writes all that is known before the run.
    pub fn create(path: &Path, header: &Header) -> Result<Writer, Error> {
        let file = McapFile::create(path, header)?;
        let (queue, orders) = sync_channel(QUEUE);
        let spare = Spare::default();
        let back = Arc::clone(&spare);
        let handle = Builder::new().name("recording".to_owned()).spawn(move || carry_out(file, orders, &back))?;
        Ok(Writer { axes: header.axes.len(), thread: Some(Thread { queue, handle }), spare })
    }

    /// Writes samples: full rate, and thinned for plots. Waits while the queue is full.
    pub fn write_samples(&mut self, view: &ColumnsView) -> Result<(), Error> {
        if !view.is_consistent() || view.axes != self.axes {
            return Err(Error::Content("columns of different length".to_owned()));
        }
        let used = self.spare.lock().ok().and_then(|mut spare| spare.pop());
        let mut columns = used.unwrap_or_default();
        columns.copy_from(view);
        self.order(Order::Samples(Box::new(columns)))
    }

    /// Writes rows of the scanner, a value for each of `Header::scan`, from that sample on.
    pub fn write_scan(&mut self, first_sample: u64, values: &[f64]) -> Result<(), Error> {
        self.order(Order::Scan(first_sample, values.to_vec()))
    }

    /// Writes an event (a JSON object) at an emulated time.
    pub fn write_event(&mut self, t_s: f64, json: &str) -> Result<(), Error> {
        self.order(Order::Event(t_s, json.to_owned()))
    }

    /// Attaches another file.
    pub fn attach(&mut self, attached: Attached<Content>) -> Result<(), Error> {
        self.order(Order::Attach(attached))
    }

    /// Adds the result and closes the file.
    pub fn finish(mut self, result_json: &str) -> Result<(), Error> {
        self.order(Order::Finish(result_json.to_owned()))?;
        self.join()
    }

    fn order(&mut self, order: Order) -> Result<(), Error> {
        let thread = self.thread.as_ref().ok_or_else(ended)?;
        match thread.queue.send(order) {
            Ok(()) => Ok(()),
            // the thread has ended, which it does early only for an error
            Err(_) => self.join().and(Err(ended())),
        }
    }

    /// Waits for the thread and takes its error.
    fn join(&mut self) -> Result<(), Error> {
        let Some(Thread { queue, handle }) = self.thread.take() else { return Ok(()) };
        drop(queue);
        handle.join().unwrap_or_else(|_| Err(ended()))
    }
}

impl Drop for Writer {
    fn drop(&mut self) {
        let _ = self.join(); // whoever wants the error calls finish
    }
}

fn ended() -> Error {
    Error::Content("the recording has ended after an error".to_owned())
}

fn carry_out(mut file: McapFile, orders: Receiver<Order>, spare: &Spare) -> Result<(), Error> {
    for order in orders {
        match order {
            Order::Samples(columns) => {
                file.write_samples(&columns.view())?;
                if let Ok(mut spare) = spare.lock() {
                    spare.push(*columns);
                }
            }
            Order::Scan(first_sample, values) => file.write_scan(first_sample, &values)?,
            Order::Event(t_s, json) => file.write_event(t_s, &json)?,
            Order::Attach(attached) => file.attach(&attached)?,
            Order::Finish(result) => return file.finish(&result),
        }
    }
    Ok(())
}
