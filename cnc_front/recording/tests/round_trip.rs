//! What is written is read back; what is left of a damaged file is given; foreign files are refused.

use std::path::{Path, PathBuf};

use proptest::prelude::*;
use recording::{Attached, Columns, Content, Header, Item, Reader, Writer};

fn scratch(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR"));
    folder.join(format!("{name}-{:?}.mcap", std::thread::current().id()))
}

fn header() -> Header {
    let text =
        Attached { name: "job.nc".into(), media_type: "text/plain".into(), data: Content::Bytes(b"G0 X1\n".to_vec()) };
    let metadata = [("tolerance_mm".to_owned(), "0.05".to_owned())].into();
    Header {
        axes: vec!["X".into(), "Y".into()],
        sample_time_s: 1.28e-3,
        attachments: vec![text],
        metadata,
        ..Header::default()
    }
}

fn samples(first_sample: u64, n: usize) -> Columns {
    let number = |k: usize| k as f64 * 0.1 + first_sample as f64;
    Columns {
        first_sample,
        axes: 2,
        dp: (0..2 * n).map(number).collect(),
        load: (0..2 * n).map(|k| number(k) - 0.01).collect(),
        rp: (0..2 * n).map(|k| number(k) - 0.02).collect(),
        factor: vec![1.0; n],
        v_plan: (0..n).map(number).collect(),
        line: (0..n as u32).collect(),
        entry: vec![7; n],
        flags: vec![1; n],
        deviation_mm: (0..n).map(|k| if k == 1234 { 0.5 } else { 0.001 }).collect(),
        standing: (100..110).collect(),
    }
}

fn write(path: &Path) {
    let mut writer = Writer::create(path, &header()).expect("created");
    writer.write_samples(&samples(0, 2500).view()).expect("samples");
    writer.write_event(0.5, r#"{"kind":"axst"}"#).expect("event");
    writer.write_samples(&samples(2500, 10).view()).expect("samples");
    writer.finish(r#"{"schema":"cnc-front/run/1"}"#).expect("finished");
}

fn read(path: &Path) -> (Vec<Item>, Option<String>) {
    let mut reader = Reader::open(path).expect("opened");
    let mut items = Vec::new();
    while let Some(item) = reader.next_item().expect("ours") {
        items.push(item);
    }
    (items, reader.damage)
}

fn all_columns(items: &[Item]) -> Vec<&Columns> {
    items.iter().filter_map(|i| if let Item::Columns(c) = i { Some(c) } else { None }).collect()
}

#[test]
fn everything_comes_back() {
    let path = scratch("everything");
    write(&path);
    let (items, damage) = read(&path);
    assert_eq!(damage, None);
    let columns = all_columns(&items);
    assert_eq!(columns.iter().map(|c| c.flags.len()).collect::<Vec<_>>(), [1000, 1000, 500, 10]);
    let all = samples(0, 2500);
    assert_eq!(columns[1].dp, all.dp[2000..4000]);
    assert_eq!(columns[2].first_sample, 2000);
    assert_eq!(columns[1].deviation_mm, all.deviation_mm[1000..2000]);
    // it belongs to the end of what was written at once
    assert_eq!(columns.iter().map(|c| c.standing.len()).collect::<Vec<_>>(), [0, 0, 10, 10]);
    assert_eq!(columns[2].standing, all.standing);
    assert!(matches!(&items[0], Item::Attachment(a) if a.name == "job.nc" && a.data == b"G0 X1\n"));
    assert!(items.iter().any(|i| matches!(i, Item::Metadata(name, map) if name == "run" && *map == header().metadata)));
    assert!(items.iter().any(|i| matches!(i, Item::Event(text) if text.contains("axst"))));
    assert!(matches!(items.last(), Some(Item::Attachment(a)) if a.name == "result.json"));
}

#[test]
fn the_same_run_gives_the_same_bytes() {
    let (a, b) = (scratch("same-a"), scratch("same-b"));
    write(&a);
    write(&b);
    assert_eq!(std::fs::read(a).expect("a"), std::fs::read(b).expect("b"));
}

#[test]
fn a_file_cut_off_yields_its_first_part() {
    let path = scratch("cut");
    let mut writer = Writer::create(&path, &header()).expect("created");
    for k in 0..40 {
        writer.write_samples(&samples(k * 2500, 2500).view()).expect("samples");
    }
    writer.finish("{}").expect("finished");
    let whole = std::fs::read(&path).expect("readable");
    std::fs::write(&path, &whole[..whole.len() * 3 / 4]).expect("written");
    let (items, damage) = read(&path);
    assert!(damage.is_some());
    let count: usize = all_columns(&items).iter().map(|c| c.flags.len()).sum();
    assert!(count > 10_000 && count < 100_000, "{count} samples");
    assert!(matches!(&items[0], Item::Attachment(a) if a.name == "job.nc"));
}

#[test]
fn a_damaged_chunk_gives_no_sample_of_its_own() {
    let path = scratch("bit");
    write(&path);
    let whole = std::fs::read(&path).expect("readable");
    let good = samples(0, 2500);
    let mut stopped = 0;
    for at in (0..whole.len()).step_by(97) {
        let mut bytes = whole.clone();
        bytes[at] ^= 0x10;
        std::fs::write(&path, &bytes).expect("written");
        let mut reader = Reader::open(&path).expect("opened");
        while let Ok(Some(item)) = reader.next_item() {
            let Item::Columns(columns) = item else { continue };
            let first = columns.first_sample as usize;
            if first < 2500 {
                assert_eq!(columns.load, good.load[2 * first..2 * (first + columns.flags.len())], "byte {at}");
            }
        }
        stopped += usize::from(reader.damage.is_some());
    }
    assert!(stopped > 10, "{stopped} of the places");
}

#[test]
fn a_gap_in_the_samples_is_damage() {
    let path = scratch("gap");
    let mut writer = Writer::create(&path, &header()).expect("created");
    writer.write_samples(&samples(0, 100).view()).expect("samples");
    writer.write_samples(&samples(101, 100).view()).expect("samples");
    writer.finish("{}").expect("finished");
    let (items, damage) = read(&path);
    assert_eq!(all_columns(&items).len(), 1);
    assert_eq!(damage.as_deref(), Some("samples are missing here"));
}

#[test]
fn states_lie_between_the_columns_they_belong_to() {
    let path = scratch("order");
    write(&path);
    let bytes = std::fs::read(&path).expect("readable");
    let times: Vec<u64> = mcap::MessageStream::new(&bytes)
        .expect("ours")
        .map(|message| message.expect("sound"))
        .filter(|message| message.channel.topic == recording::STATE)
        .map(|message| message.log_time)
        .collect();
    assert!(times.len() > 2500 / 32 && times.is_sorted());
}

#[test]
fn a_file_that_cannot_be_written_is_an_error() {
    assert!(Writer::create(&scratch("no-such-folder").join("x.mcap"), &header()).is_err());
    let Ok(mut writer) = Writer::create(std::path::Path::new("/dev/full"), &header()) else { return };
    let all = samples(0, 50_000);
    let failed =
        (0..40).any(|k| writer.write_samples(&Columns { first_sample: k * 50_000, ..all.clone() }.view()).is_err());
    assert!(failed || writer.finish("{}").is_err());
}

#[test]
fn a_foreign_file_is_refused() {
    let path = scratch("foreign");
    for bytes in [&b""[..], b"G0 X1\n", b"\x89MCAP0\r\n"] {
        std::fs::write(&path, bytes).expect("written");
        assert!(Reader::open(&path).expect("opened").next_item().is_err());
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn damage_never_panics(place in 0.0..1.0f64, byte in any::<u8>(), cut in 0.0..1.0f64) {
        let path = scratch("damage");
        write(&path);
        let mut bytes = std::fs::read(&path).expect("readable");
        let at = (bytes.len() as f64 * place) as usize;
        bytes[at] ^= byte;
        bytes.truncate((bytes.len() as f64 * cut.sqrt()) as usize);
        std::fs::write(&path, &bytes).expect("written");
        let mut reader = Reader::open(&path).expect("opened");
        while let Ok(Some(_)) = reader.next_item() {}
    }

    #[test]
    fn no_message_makes_the_decoder_panic(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
        let _ = Columns::decode(&bytes);
    }
}

#[test]
fn dropping_waits_until_all_is_written() {
    let path = scratch("dropped");
    let mut writer = Writer::create(&path, &header()).expect("created");
    for k in 0..20 {
        writer.write_samples(&samples(k * 2500, 2500).view()).expect("samples");
    }
    drop(writer);
    let (items, _) = read(&path);
    assert_eq!(all_columns(&items).iter().map(|c| c.flags.len()).sum::<usize>(), 50_000);
    assert!(!items.iter().any(|i| matches!(i, Item::Attachment(a) if a.name == "result.json")));
}
