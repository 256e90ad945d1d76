//! Reads a recording and writes its samples again: `cargo run --release -p recording --example record_speed -- RUN.mcap`.
//! Prints seconds and megabytes of columns per second, both ways, on one core.

use std::time::Instant;

use recording::{Header, Item, Reader, Writer};

fn main() -> Result<(), recording::Error> {
    let path = std::env::args().nth(1).expect("usage: bench RUN.mcap");
    let begun = Instant::now();
    let mut reader = Reader::open(path.as_ref())?;
    let mut columns = Vec::new();
    while let Some(item) = reader.next_item()? {
        if let Item::Columns(part) = item {
            columns.push(part);
        }
    }
    let read_s = begun.elapsed().as_secs_f64();
    let axes = columns.first().map_or(0, |c| c.axes);
    let samples: usize = columns.iter().map(|c| c.flags.len()).sum();
    let megabytes = (samples * (24 * axes + 32)) as f64 / 1e6;

    let copy = std::env::temp_dir().join(format!("recording-bench-{}.mcap", std::process::id()));
    let header = Header {
        axes: (0..axes).map(|a| format!("A{a}")).collect(),
        sample_time_s: 1.28e-3,
        resolution: vec![1.0 / 10_000.0; axes],
        ..Header::default()
    };
    let begun = Instant::now();
    let mut writer = Writer::create(&copy, &header)?;
    for part in &columns {
        writer.write_samples(&part.view())?;
    }
    writer.finish("{}")?;
    let write_s = begun.elapsed().as_secs_f64();
    let share = std::fs::metadata(&copy)?.len() as f64 / 1e6 / megabytes;
    std::fs::remove_file(&copy)?;
    println!("{samples} samples of {axes} axes, {megabytes:.0} MB of columns");
    println!("read  {read_s:.2} s, {:.0} MB/s", megabytes / read_s);
    println!("write {write_s:.2} s, {:.0} MB/s, file {:.0} % of the columns", megabytes / write_s, 100.0 * share);
    Ok(())
}
