use std::fs::{self, File};
use std::io;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use super::*;
use crate::read::reader;
use crate::testing;
use crate::wire::schema::{LOG, Source, TOOL_POSE};
use crate::write::paths;

mod chosen;
mod removed;

const SECOND: i64 = 1_000_000_000;

struct Rig {
    tmp: tempfile::TempDir,
    series: Series,
    seq: u64,
    now_ns: i64,
}

fn no_facts() -> Metadata {
    Metadata {
        name: "recorder".to_owned(),
        metadata: [].into(),
    }
}

fn rotating(rotate_after: Duration) -> RecordingSpec {
    RecordingSpec {
        rotate_after: Some(rotate_after),
        ..RecordingSpec::default()
    }
}

fn plenty(_: &Path) -> io::Result<u64> {
    Ok(u64::MAX)
}

impl Rig {
    fn new(spec: &RecordingSpec, free: Free) -> Self {
        let tmp = tempfile::tempdir().unwrap();
        let scene = tmp.path().join("scene.toml");
        fs::write(&scene, "seed = 1\n").unwrap();
        let content = Content::new(&scene, &testing::facts());
        let series = Series::start(&tmp.path().join("s.mcap"), content, spec, free).unwrap();
        Self {
            tmp,
            series,
            seq: 0,
            now_ns: 0,
        }
    }

    /// Records for `seconds` at 100 Hz, with a step after each pose; gives what was said.
    fn record(&mut self, seconds: u32) -> Vec<String> {
        self.record_poses(100 * u64::from(seconds))
    }

    fn record_poses(&mut self, count: u64) -> Vec<String> {
        let mut said = Vec::new();
        for _ in 0..count {
            self.series
                .put(self.now_ns, Entry::Pose(Source::Tool, &testing::pose(self.seq)));
            self.seq += 1;
            self.now_ns += SECOND / 100;
            said.extend(self.series.step(self.now_ns));
        }
        said
    }

    /// Each message is in a file, or in none and counted, or in the chunk that grows.
    fn assert_accounted(&self) {
        let unwritten = match &self.series.state {
            State::Writing { file, .. } => file.unwritten().messages,
            State::Stopped { .. } => 0,
        };
        let (written, unrecorded) = (self.series.written(), self.series.unrecorded());
        assert_eq!(
            written + unrecorded + unwritten,
            self.seq,
            "{written} on disk, {unrecorded} in no file, {unwritten} in memory"
        );
        assert!(
            self.series.durable() <= written,
            "{} synced of {written}",
            self.series.durable()
        );
    }

    /// The disk says that it did not keep what it was given.
    fn fail_to_sync(&mut self) {
        let file = Arc::new(File::open(self.tmp.path()).unwrap());
        let (from, to) = (self.path("nowhere"), self.path("never"));
        self.series.syncer.whole(file, from, to);
        self.series.syncer.settle();
    }

    /// The poses that can be read from whatever lies in the folder.
    fn found(&self) -> u64 {
        let Ok(entries) = fs::read_dir(self.tmp.path()) else {
            return 0;
        };
        let files = entries.map(|entry| entry.unwrap().path());
        let files = files.filter(|path| path.to_string_lossy().contains("/s."));
        files
            .map(|path| reader::poses(&path, TOOL_POSE).unwrap().flatten().count() as u64)
            .sum()
    }

    fn path(&self, name: &str) -> PathBuf {
        self.tmp.path().join(name)
    }

    fn seqs(&self, name: &str) -> Vec<u64> {
        let poses = reader::poses(&self.path(name), TOOL_POSE).unwrap();
        poses.map(|pose| pose.unwrap().seq).collect()
    }

    /// The parts in order, then the last file.
    fn all(&self) -> Vec<u64> {
        let out = self.path("s.mcap");
        let parts = (1..).map(|n| paths::part(&out, n)).take_while(|part| part.exists());
        let files: Vec<_> = parts.chain([out.clone()]).collect();
        let name = |path: &PathBuf| path.file_name().unwrap().to_str().unwrap().to_owned();
        files.iter().flat_map(|path| self.seqs(&name(path))).collect()
    }
}

#[test]
fn rotated_by_time_every_part_is_whole_and_nothing_is_lost() {
    let spec = rotating(Duration::from_secs(2));
    let mut rig = Rig::new(&spec, plenty);
    assert!(rig.record(7).is_empty());
    assert_eq!(rig.series.parts(), 3);
    let series = std::mem::replace(&mut rig.series, Rig::new(&spec, plenty).series);
    let finished = series.finish(rig.now_ns, &no_facts()).unwrap();
    assert_eq!((finished.messages, finished.path), (700, rig.path("s.mcap")));
    assert_eq!(rig.all(), (0..700).collect::<Vec<_>>());
    for part in ["s.1.mcap", "s.2.mcap", "s.3.mcap", "s.mcap"] {
        let info = crate::read::info::info(&rig.path(part)).unwrap();
        assert!(
            info.damage.is_empty() && info.attachments.len() == 1,
            "{part}: {:?}",
            info.damage
        );
    }
    // Each but the last says that the session goes on: a report said of them that their end was not recorded.
    let says = |name: &str| {
        let session = crate::read::seek::Session::open(&rig.path(name)).unwrap();
        let record = session.metadata(part::PART).unwrap();
        record.map(|record| record.metadata[part::BEFORE].clone())
    };
    let said = ["s.1.mcap", "s.2.mcap", "s.3.mcap", "s.mcap"].map(says);
    assert_eq!(
        said,
        [Some("0"), Some("1"), Some("2"), None].map(|before| before.map(str::to_owned))
    );
}

#[test]
fn rotated_by_size_no_part_is_much_larger() {
    // A chunk of half a second holds 50 poses of about 90 bytes; the schemas take a kilobyte or two.
    let spec = RecordingSpec {
        rotate_bytes: Some(20_000),
        ..RecordingSpec::default()
    };
    let mut rig = Rig::new(&spec, plenty);
    rig.record(10);
    assert!(rig.series.parts() > 1, "{}", rig.series.parts());
    rig.series.syncer.finish();
    for n in 1..=rig.series.parts() {
        let length = fs::metadata(paths::part(&rig.path("s.mcap"), n)).unwrap().len();
        // The chunk that goes beyond, and the index.
        assert!((20_000..40_000).contains(&length), "part {n}: {length} bytes");
    }
}

static FREE: AtomicU64 = AtomicU64::new(u64::MAX);

#[test]
fn a_disk_that_fills_stops_recording_with_words_and_room_lets_it_go_on() {
    let free: Free = |_| Ok(FREE.load(Ordering::Relaxed));
    let mut rig = Rig::new(&RecordingSpec::default(), free);
    rig.record(2);
    FREE.store(150_000_000, Ordering::Relaxed);
    let said = rig.record(3);
    assert_eq!(said.len(), 1, "{said:?}");
    assert!(
        said[0].contains("NOT RECORDING") && said[0].contains("150 MB are free") && said[0].contains("200 MB must be"),
        "{said:?}"
    );
    // Its folder would take the room that the cause needs in a sign of life.
    let why = rig.series.stopped().unwrap();
    assert!(why.starts_with("recording to s.mcap: 150 MB are free"), "{why}");
    let unrecorded = rig.series.unrecorded();
    let written = rig.series.written();
    assert_eq!(written + unrecorded, 500);
    // More than what it stopped at, less than it wants: it must not start and stop all the time.
    FREE.store(240_000_000, Ordering::Relaxed);
    assert!(rig.record(10).is_empty() && rig.series.stopped().is_some());
    FREE.store(260_000_000, Ordering::Relaxed);
    let said = rig.record(6);
    assert!(said.len() == 1 && said[0].contains("recording goes on"), "{said:?}");
    assert!(rig.series.stopped().is_none());
    rig.series.syncer.finish();
    // What was recorded before is whole, and all of it was acknowledged.
    assert_eq!(rig.seqs("s.1.mcap"), (0..written).collect::<Vec<_>>());
    rig.now_ns += SECOND;
    rig.series.step(rig.now_ns);
    let growing = paths::recording(&rig.path("s.mcap"));
    let logs = crate::read::scan::open(&growing).unwrap().flatten();
    let logs = logs.filter(|item| matches!(item, crate::read::scan::Item::Message(m) if m.channel.topic == LOG));
    assert_eq!(logs.count(), 2);
}

#[test]
fn a_disk_that_is_full_from_the_start_is_refused() {
    let tmp = tempfile::tempdir().unwrap();
    let content = Content::new(tmp.path(), &testing::facts());
    let out = tmp.path().join("s.mcap");
    let error = Series::start(&out, content, &RecordingSpec::default(), |_| Ok(1_000_000)).unwrap_err();
    let text = error.to_string();
    assert!(
        text.contains("1 MB are free") && text.contains("recording.min_free_mb"),
        "{text}"
    );
    assert!(!paths::recording(&out).exists());
}

#[test]
fn what_is_acknowledged_reaches_the_disk_with_the_next_sync() {
    let mut rig = Rig::new(&RecordingSpec::default(), plenty);
    rig.record(3);
    let written = rig.series.written();
    // The clock of this test runs ahead of the disk, and what is asked for while a sync is under way waits for the next one:
    // this thread has none under way.
    rig.series.syncer = Syncer::start(Duration::from_secs(1));
    rig.record(1);
    rig.series.syncer.finish();
    assert!(
        written > 0 && rig.series.durable() >= written,
        "{} of {written}",
        rig.series.durable()
    );
    assert!(rig.series.durable() <= rig.series.written());
}

#[test]
fn a_folder_that_goes_away_is_told_once_and_what_comes_back_with_it_counts_again() {
    let mut rig = Rig::new(&RecordingSpec::default(), plenty);
    rig.record(3);
    let before = rig.series.written();
    let folder = rig.path("");
    let gone = folder.with_extension("gone");
    fs::rename(&folder, &gone).unwrap();
    let said = rig.record(20);
    assert_eq!(said.len(), 1, "{said:?}");
    assert!(said[0].contains("was moved or replaced"), "{said:?}");
    assert_eq!((rig.series.written(), rig.series.unrecorded()), (0, 2300));
    // Back again: the file that kept the name of the growing one is moved aside and not replaced.
    fs::rename(&gone, &folder).unwrap();
    // The clock of this test runs ahead of the disk: whoever still waits for it holds the file.
    rig.series.syncer = Syncer::start(Duration::from_secs(1));
    let said = rig.record(10);
    assert!(said.len() == 1 && said[0].contains("recording goes on"), "{said:?}");
    rig.assert_accounted();
    assert!(rig.series.written() > before);
    rig.series.syncer.finish();
    let part = rig.path("s.1.mcap.recording");
    let found: Vec<u64> = reader::poses(&part, TOOL_POSE)
        .unwrap()
        .flatten()
        .map(|pose| pose.seq)
        .collect();
    assert!(found.len() as u64 >= before, "{} of {before}", found.len());
    assert_eq!(found, (0..found.len() as u64).collect::<Vec<_>>());
}

#[test]
fn a_session_that_ends_while_nothing_is_recorded_is_an_error() {
    static NONE_LEFT: AtomicU64 = AtomicU64::new(u64::MAX);
    let free: Free = |_| Ok(NONE_LEFT.load(Ordering::Relaxed));
    let mut rig = Rig::new(&RecordingSpec::default(), free);
    rig.record(2);
    NONE_LEFT.store(0, Ordering::Relaxed);
    rig.record(3);
    let unrecorded = rig.series.unrecorded();
    let Rig { series, now_ns, .. } = rig;
    let text = series.finish(now_ns, &no_facts()).unwrap_err().to_string();
    assert!(
        text.contains(&format!(
            "not recorded to its end: {unrecorded} messages are in no file"
        )),
        "{text}"
    );
}

/// `90532 on disk` once stood in the status for a file that was nowhere.
#[test]
fn a_file_that_is_removed_while_it_is_written_is_no_recording() {
    let mut rig = Rig::new(&RecordingSpec::default(), plenty);
    rig.record(3);
    assert!(rig.series.written() > 200);
    fs::remove_file(paths::recording(&rig.path("s.mcap"))).unwrap();
    // It is looked for once a second, and another one is begun with the next look.
    let said = rig.record(1);
    assert!(
        said.len() == 1 && said[0].contains("was removed while it was written"),
        "{said:?}"
    );
    assert_eq!(rig.series.written(), 0);
    let said = rig.record(11);
    assert!(said.len() == 1 && said[0].contains("recording goes on"), "{said:?}");
    rig.assert_accounted();
    // Three seconds in the file that is gone, one until that was seen and one until the next look: not more.
    assert!(rig.series.unrecorded() <= 500, "{}", rig.series.unrecorded());
    rig.series.syncer.finish();
}
