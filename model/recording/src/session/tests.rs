use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use proptest::prelude::*;

use super::*;
use crate::{Error, What};

/// A layout of two channels.
pub(super) fn layout() -> Layout {
    let fields = vec![Field::f64("length_m", "m"), Field::f64("duty", ""), Field::u32("mode"), Field::u32("fault")];
    Layout::new(vec!["Left".into(), "right".into()], fields).unwrap()
}

pub(super) fn about() -> About {
    About {
        rig: "bench".into(),
        rate_hz: 1000.0,
        software: "sinew test".into(),
        kind: "driver".into(),
        simulated: true,
        started_unix_ns: 1_700_000_000_000_000_000,
        started_monotonic_ns: 1_000_000,
        rig_toml: Some("[rig]\nname = \"bench\"\n".into()),
        extra: Default::default(),
    }
}

pub(super) fn head(cycle: u64) -> Head {
    Head { cycle, monotonic_ns: cycle * 1_000_000, missed: cycle / 10 }
}

/// The channels of a cycle: numbers that follow from it.
pub(super) fn bytes(cycle: u64) -> Vec<u8> {
    let mut bytes = Vec::new();
    for channel in 0..2u64 {
        bytes.extend((cycle as f64 + 0.25 * channel as f64).to_le_bytes());
        bytes.extend(f64::from_bits(0x7ff8_0000_0000_0000 | cycle).to_le_bytes());
        bytes.extend((cycle as u32).to_le_bytes());
        bytes.extend((channel as u32).to_le_bytes());
    }
    bytes
}

/// A recording of these cycles, cut into chunks behind some of them.
pub(super) fn recording(
    cycles: impl IntoIterator<Item = u64>,
    cut: impl Fn(u64) -> bool,
    compression: Compression,
) -> Vec<u8> {
    let options = WriteOptions { compression, ..WriteOptions::new("memory") };
    let mut writer = SessionWriter::create(Cursor::new(Vec::new()), &about(), &layout(), options).unwrap();
    for cycle in cycles {
        writer.cycle(&head(cycle), &bytes(cycle)).unwrap();
        if cut(cycle) {
            writer.cut().unwrap();
        }
    }
    writer.finish(Ended::Stopped).unwrap().into_inner()
}

/// A file with this content, in a folder that goes with it.
pub(super) fn file(content: &[u8]) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    fs::write(&path, content).unwrap();
    (folder, path)
}

/// Numbers of the cycles, each of which has to be what was written; and the errors on the way.
pub(super) fn read(session: &Session) -> (Vec<u64>, Vec<Error>) {
    let (mut found, mut errors) = (Vec::new(), Vec::new());
    let mut cycles = session.cycles();
    loop {
        match cycles.next() {
            Ok(Some(cycle)) => {
                assert_eq!(cycle.head, head(cycle.head.cycle));
                assert_eq!(cycle.bytes(), bytes(cycle.head.cycle));
                found.push(cycle.head.cycle);
            }
            Ok(None) => return (found, errors),
            Err(error) => errors.push(error),
        }
    }
}

fn open(path: &Path) -> Session {
    Session::open(path).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn a_recording_says_what_it_is_and_gives_every_bit_back() {
    for compression in [Compression::None, Compression::Lz4, Compression::Zstd] {
        let (_folder, path) = file(&recording(1..=500, |cycle| cycle % 90 == 0, compression));
        let session = open(&path);
        assert_eq!(session.about(), &about());
        assert_eq!(session.layout(), &layout());
        assert!(session.has_summary());
        assert_eq!(session.cycle_count(), 500);
        let size = session.size();
        assert_eq!((size.chunks, size.compression), (6, Some(compression)));
        assert!(size.unpacked > 500 * 48 && size.packed < size.file);
        let (cycles, errors) = read(&session);
        assert!(errors.is_empty() && cycles.iter().copied().eq(1..=500), "{errors:?}");
        let ending = session.ending().unwrap();
        assert_eq!((ending.ended, ending.cycles, ending.lost, ending.missed), (Some(Ended::Stopped), 500, 0, 50));
        assert_eq!(session.span().unwrap(), Some((head(1), head(500))));
    }
}

#[test]
fn values_are_found_by_name() {
    let (_folder, path) = file(&recording(1..4, |_| false, Compression::Lz4));
    let session = open(&path);
    let (right, length, mode) = (
        session.layout().channel("right").unwrap(),
        session.layout().field("length_m").unwrap(),
        session.layout().field("mode").unwrap(),
    );
    let mut cycles = session.cycles();
    let first = cycles.next().unwrap().unwrap();
    assert_eq!((first.get(right, length), first.get(0, mode)), (1.25, 1.0));
    assert!(first.get(right, 99).is_nan() && first.get(99, length).is_nan() && first.get(usize::MAX, 3).is_nan());
    assert_eq!(session.time_s(&first.head), 0.0);
}

#[test]
fn a_gap_is_counted_named_and_told() {
    let options = WriteOptions { after_cycle: Some(7), ..WriteOptions::new("memory") };
    let mut writer = SessionWriter::create(Cursor::new(Vec::new()), &about(), &layout(), options).unwrap();
    for cycle in [10, 11, 20, 21] {
        writer.cycle(&head(cycle), &bytes(cycle)).unwrap();
    }
    for bad in [21, 3] {
        let error = writer.cycle(&head(bad), &bytes(bad)).unwrap_err();
        assert_eq!(error.what, What::Session(Trouble::NotAfter { previous: 21, found: bad }));
    }
    assert!(matches!(writer.cycle(&head(22), &[0; 5]).unwrap_err().what, What::Session(Trouble::CycleBytes { .. })));
    writer.event(&Event::note(21, 21_000_000, "so much for that")).unwrap();
    let figures =
        LoopFigures { cycle: 21, lateness: Durations { max_ns: 5, ..Default::default() }, ..Default::default() };
    writer.loop_stats(&figures).unwrap();
    let (_folder, path) = file(writer.finish(Ended::DriverStopped).unwrap().get_ref());
    let session = open(&path);
    let gaps = [Gap { from: 8, to: 9 }, Gap { from: 12, to: 19 }];
    let ending = session.ending().unwrap();
    assert_eq!((ending.lost, &ending.gaps[..]), (10, &gaps[..]));
    let events = session.events().unwrap();
    let told: Vec<_> = events.iter().map(|e| (e.kind.as_str(), e.from_cycle, e.to_cycle)).collect();
    assert_eq!(told, [(GAP, 8, 9), (GAP, 12, 19), (NOTE, 0, 0)]);
    assert_eq!(session.loop_figures().unwrap(), [figures]);
    assert_eq!(read(&session).0, [10, 11, 20, 21]);
}

#[test]
fn a_part_of_the_time_is_read_without_the_rest() {
    let (_folder, path) = file(&recording(1..=1000, |cycle| cycle % 100 == 0, Compression::Lz4));
    let session = open(&path);
    for (from_s, to_s, first, last) in
        [(0.25, 0.26, 251, 260), (-1.0, 0.001, 1, 1), (0.999, 99.0, 1000, 1000), (0.0995, 0.1005, 101, 101)]
    {
        let mut cycles = session.cycles_between(from_s, to_s);
        let mut found = Vec::new();
        while let Some(cycle) = cycles.next().unwrap() {
            found.push(cycle.head.cycle);
        }
        assert!(found.iter().copied().eq(first..=last), "{from_s}..{to_s}: {found:?}");
    }
    assert!(session.cycles_between(2.0, 3.0).next().unwrap().is_none());
    assert!(session.cycles_between(0.5, 0.4).next().unwrap().is_none());
}

#[test]
fn without_its_end_every_complete_chunk_is_read() {
    let whole = recording(1..=300, |cycle| cycle % 50 == 0, Compression::Lz4);
    let (_folder, path) = file(&whole);
    let session = open(&path);
    // where each chunk with its indexes ends, and how many cycles are in the file up to there
    let mut ends: Vec<u64> = session.contents.chunks.iter().map(|chunk| chunk.offset + chunk.length).collect();
    ends.insert(0, 0);
    for cut in (0..whole.len()).step_by(97).chain(ends.iter().map(|&end| end as usize)) {
        fs::write(&path, &whole[..cut]).unwrap();
        let complete = ends.iter().filter(|&&end| end <= cut as u64).count() as u64 - 1;
        match Session::open(&path) {
            Ok(session) => {
                let (cycles, errors) = read(&session);
                assert!(errors.is_empty(), "{cut}: {errors:?}");
                assert!(cycles.iter().copied().eq(1..=50 * complete), "{cut}: {} cycles", cycles.len());
                assert!(session.has_summary() || session.ending().is_none() || complete == 6);
                assert_eq!(session.about().rig, "bench");
                assert!(session.about().rig_toml.is_some());
            }
            Err(error) => assert!(complete == 0 && error.is_bad_input(), "{cut}: {error}"),
        }
    }
}

#[test]
fn a_damaged_chunk_is_named_and_passed_over() {
    let mut whole = recording(1..=300, |cycle| cycle % 50 == 0, Compression::Lz4);
    let (_folder, path) = file(&whole);
    let third = open(&path).contents.chunks[2].clone();
    let middle = (third.offset + third.length / 2) as usize;
    whole[middle] ^= 0x55;
    fs::write(&path, &whole).unwrap();
    let (cycles, errors) = read(&open(&path));
    assert!(cycles.iter().copied().eq((1..=100).chain(151..=300)), "{} cycles", cycles.len());
    let [error] = &errors[..] else { panic!("{errors:?}") };
    assert!(
        matches!(&error.what, What::Session(Trouble::Damaged { offset, .. }) if *offset == third.offset),
        "{error}"
    );
    assert!(error.to_string().contains("sinew recording recover"), "{error}");
}

#[test]
fn what_is_no_recording_is_called_by_its_name() {
    let refused = |content: &[u8]| {
        let (_folder, path) = file(content);
        let error = Session::open(&path).unwrap_err();
        assert!(error.is_bad_input(), "{error}");
        error.to_string()
    };
    assert!(refused(b"").contains("is empty"));
    assert!(refused(b"time_s,duty\n0,1\n").contains("is text, expected a recording in MCAP"));
    assert!(refused(&[0x1f, 0x8b, 8, 0, 0, 0, 0, 0, 0]).contains("gzip"));
    assert!(refused(mcap::MAGIC).contains("no topic /cycles"));
    assert!(Session::open("no/such/file.mcap").unwrap_err().to_string().contains("cannot be read"));
    let mut other = mcap::Writer::new(Cursor::new(Vec::new())).unwrap();
    let id = other.add_channel(0, "/imu", "json", &Default::default()).unwrap();
    let header = mcap::records::MessageHeader { channel_id: id, sequence: 0, log_time: 1, publish_time: 1 };
    other.write_to_known_channel(&header, b"{}").unwrap();
    other.finish().unwrap();
    assert!(refused(other.into_inner().get_ref()).contains("only /imu"));
}

#[test]
fn what_cannot_be_written_is_an_error_and_leaves_complete_chunks() {
    /// A disk of so many bytes.
    struct Small(Cursor<Vec<u8>>, usize);
    impl std::io::Write for Small {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            let free = self.1.saturating_sub(self.0.get_ref().len());
            if free == 0 {
                return Err(std::io::ErrorKind::StorageFull.into());
            }
            self.0.write(&bytes[..bytes.len().min(free)])
        }
        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }
    impl std::io::Seek for Small {
        fn seek(&mut self, to: std::io::SeekFrom) -> std::io::Result<u64> {
            self.0.seek(to)
        }
    }
    let options = WriteOptions { compression: Compression::None, ..WriteOptions::new("small") };
    let mut writer =
        SessionWriter::create(Small(Cursor::new(Vec::new()), 20_000), &about(), &layout(), options).unwrap();
    let mut written = 0;
    let error = loop {
        written += 1;
        let cut = writer
            .cycle(&head(written), &bytes(written))
            .and_then(|()| if written % 20 == 0 { writer.cut() } else { Ok(()) });
        if let Err(error) = cut {
            break error;
        }
    };
    assert!(matches!(error.what, What::Unwritable { .. }) && error.file == "small", "{error}");
    let left = writer.abandon();
    let mut content = left.sink.0.into_inner();
    assert!(content.len() == 20_000 && left.length < 20_000);
    assert_eq!(left.ending.cycles, written - 20);
    content.truncate(left.length as usize);
    let closed = |content: &[u8]| {
        let (_folder, path) = file(content);
        let session = open(&path);
        let (cycles, errors) = read(&session);
        assert!(errors.is_empty() && cycles.iter().copied().eq(1..=written - 20), "{} cycles", cycles.len());
        session.ending().cloned()
    };
    assert_eq!(closed(&content), None);
    let ending = Ending { ended: Some(Ended::Unwritable), ..left.ending };
    let mut content = Cursor::new(content);
    close_off(&mut content, left.length, &ending).unwrap();
    assert_eq!(closed(content.get_ref()), Some(ending));
    // a whole file to others too
    let messages = mcap::MessageStream::new(content.get_ref()).unwrap().collect::<Result<Vec<_>, _>>().unwrap();
    assert_eq!(messages.len() as u64, written - 20);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// Whatever is done to a file, reading it ends, in an error at worst.
    #[test]
    fn no_damage_makes_a_reader_panic(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
        cut in any::<prop::sample::Index>(),
        is_cut in any::<bool>(),
        packed in 0usize..3,
    ) {
        let compression = [Compression::None, Compression::Lz4, Compression::Zstd][packed];
        let mut content = recording(1..=60, |cycle| cycle % 20 == 0, compression);
        for (place, value) in changes {
            let place = place.index(content.len());
            content[place] = value;
        }
        if is_cut {
            content.truncate(cut.index(content.len()));
        }
        let (_folder, path) = file(&content);
        if let Ok(session) = Session::open(&path) {
            let mut cycles = session.cycles();
            for _ in 0..1000 {
                match cycles.next() {
                    Ok(None) => break,
                    Ok(Some(cycle)) => prop_assert!(cycle.get(0, 0).to_bits() != 1),
                    Err(_) => {}
                }
            }
            let _ = (session.events(), session.loop_figures(), session.span(), session.size());
        }
    }
}

#[test]
fn what_is_lost_at_the_very_end_is_counted_too() {
    let mut writer =
        SessionWriter::create(Cursor::new(Vec::new()), &about(), &layout(), WriteOptions::new("memory")).unwrap();
    writer.cycle(&head(5), &bytes(5)).unwrap();
    writer.lost_to(&head(5)).unwrap();
    writer.lost_to(&head(8)).unwrap();
    let (_folder, path) = file(writer.finish(Ended::Stopped).unwrap().get_ref());
    let session = open(&path);
    let ending = session.ending().unwrap();
    assert_eq!((ending.cycles, ending.lost, &ending.gaps[..]), (1, 3, &[Gap { from: 6, to: 8 }][..]));
}

fn checked(content: &[u8]) -> Checkup {
    let (_folder, path) = file(content);
    check(&path, |_, _| {}).unwrap_or_else(|e| panic!("{e}"))
}

/// What is left of this content, in a file of its own that has to be whole.
fn mended(content: &[u8]) -> (Recovered, Vec<u64>, Option<Ended>) {
    let (folder, path) = file(content);
    let output = folder.path().join("b.mcap");
    let recovered = recover(&path, &output, |_, _| {}).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(fs::read(&path).unwrap(), content, "the damaged file stays as it is");
    let names: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(names.len(), 2, "{names:?}");
    let checkup = check(&output, |_, _| {}).unwrap();
    assert!(checkup.is_whole() && checkup.lost == recovered.lost, "{checkup:?}");
    let session = open(&output);
    assert!(session.has_summary() && session.about().rig_toml == about().rig_toml);
    let (cycles, errors) = read(&session);
    assert!(errors.is_empty() && cycles.len() as u64 == recovered.cycles);
    (recovered, cycles, session.ending().unwrap().ended)
}

#[test]
fn a_whole_recording_is_found_to_be_whole() {
    for compression in [Compression::None, Compression::Lz4, Compression::Zstd] {
        let checkup = checked(&recording(1..=300, |cycle| cycle % 50 == 0, compression));
        assert!(checkup.is_whole() && checkup.findings.is_empty(), "{checkup:?}");
        assert_eq!((checkup.cycles, checkup.chunks, checkup.missed), (300, 6, 30));
    }
    let gaps = checked(&recording((1..=100).chain(111..=200), |_| false, Compression::Lz4));
    assert!(gaps.is_whole() && gaps.lost == 10 && gaps.gaps == [Gap { from: 101, to: 110 }], "{gaps:?}");
}

#[test]
fn every_flipped_bit_is_found() {
    let whole = recording(1..=120, |cycle| cycle % 40 == 0, Compression::Lz4);
    let (_folder, path) = file(&whole);
    for place in (8..whole.len()).step_by(7) {
        let mut content = whole.clone();
        content[place] ^= 1 << (place % 8);
        fs::write(&path, &content).unwrap();
        let checkup = check(&path, |_, _| {});
        assert!(checkup.is_err() || !checkup.unwrap().is_whole(), "a flipped bit in byte {place} of {}", whole.len());
    }
}

#[test]
fn a_recording_that_broke_off_is_mended_to_its_last_message() {
    let whole = recording(1..=600, |cycle| cycle % 200 == 0, Compression::None);
    let (_folder, path) = file(&whole);
    let chunks = open(&path).contents.chunks.clone();
    let ends: Vec<u64> = chunks.iter().map(|chunk| chunk.offset + chunk.length).collect();
    // between chunks, in the middle of one, and behind the last without a summary
    for (cut, expected) in [(ends[1], 400), (chunks[2].offset + chunks[2].length / 2, 500), (ends[2] + 5, 600)] {
        let content = &whole[..cut as usize];
        assert!(!checked(content).is_whole());
        let (recovered, cycles, ended) = mended(content);
        assert!(
            cycles.len().abs_diff(expected) < 8 && cycles.iter().copied().eq(1..=cycles.len() as u64),
            "{recovered:?}"
        );
        assert_eq!((recovered.lost, ended), (0, Some(Ended::Recovered)));
        assert_eq!(recovered.unchecked > 0, expected == 500);
    }
    // compressed, what was packed before the break: whole blocks of 64 KiB
    let packed = recording(1..=1000, |_| false, Compression::Lz4);
    fs::write(&path, &packed).unwrap();
    let chunk = open(&path).contents.chunks[0].clone();
    let (recovered, ..) = mended(&packed[..(chunk.offset + chunk.length * 9 / 10) as usize]);
    assert!((300..1000).contains(&recovered.unchecked), "{recovered:?}");
}

#[test]
fn damage_in_the_middle_costs_one_chunk_with_a_summary_and_without() {
    let whole = recording(1..=500, |cycle| cycle % 100 == 0, Compression::Lz4);
    let (_folder, path) = file(&whole);
    let third = open(&path).contents.chunks[2].clone();
    // its data, its length, and its length in a file without an end
    for (place, keep) in [
        (third.offset + third.length / 2, whole.len()),
        (third.offset + 3, whole.len()),
        (third.offset + 3, whole.len() - 60),
    ] {
        let mut content = whole[..keep].to_vec();
        content[place as usize] ^= 0x7f;
        let checkup = checked(&content);
        assert!(!checkup.is_whole(), "{checkup:?}");
        let (recovered, cycles, _) = mended(&content);
        assert!(cycles.iter().copied().eq((1..=200).chain(301..=500)), "{place} {keep}: {recovered:?}");
        assert_eq!((recovered.lost, &recovered.gaps[..]), (100, &[Gap { from: 201, to: 300 }][..]));
    }
}

#[test]
fn what_cannot_be_mended_leaves_nothing() {
    let whole = recording(1..=50, |_| false, Compression::Lz4);
    let (folder, path) = file(&whole[..200]);
    let error = recover(&path, folder.path().join("b.mcap"), |_, _| {}).unwrap_err();
    assert!(error.is_bad_input(), "{error}");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    let error = recover(&path, folder.path().join("no/b.mcap"), |_, _| {}).unwrap_err();
    assert!(!error.to_string().is_empty());
}
