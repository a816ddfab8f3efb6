//! The recorder where things go wrong: full disks, cut and flipped files, two at once, another version.

use std::fs;
use std::path::{Path, PathBuf};

use crate::recorder_rig::{CHUNK_S, Rig, command, frame, pose, said};
use recorder::read::seek::Session;
use recorder::read::{info, reader};
use recorder::wire::schema::{EMITTERS, TOOL_POSE};
use recorder::write::paths;
use rustix::process::{Pid, Resource, Rlimit, prlimit};

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// A recording of `n` poses and frames of emitters, through the process.
fn recorded(n: u64) -> (Rig, PathBuf) {
    let rig = Rig::new();
    let recorder = rig.start();
    for seq in 0..n {
        rig.emitters.send(frame(seq)).unwrap();
        rig.tool.send(pose(seq)).unwrap();
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    recorder.terminate();
    let out = rig.out();
    (rig, out)
}

fn seqs(path: &Path) -> Vec<u64> {
    let poses = reader::poses(path, TOOL_POSE).unwrap().flatten();
    poses
        .map(|found| {
            assert_eq!(found, pose(found.seq));
            found.seq
        })
        .collect()
}

#[test]
fn cut_at_every_thousandth_byte_the_file_is_read_and_recovered() {
    let (rig, out) = recorded(1500);
    let bytes = fs::read(&out).unwrap();
    let (torn, whole) = (rig.tmp.path().join("torn.mcap"), rig.tmp.path().join("whole.mcap"));
    let mut most = 0;
    for cut in (1000..bytes.len()).step_by(1000) {
        fs::write(&torn, &bytes[..cut]).unwrap();
        let found = seqs(&torn);
        assert_eq!(found, (0..found.len() as u64).collect::<Vec<_>>(), "cut at {cut}");
        assert!(found.len() >= most, "cut at {cut}");
        most = found.len();
        let from = Session::open(&torn).unwrap().poses_from(0).unwrap().flatten().count();
        assert_eq!(from, found.len(), "cut at {cut}");
    }
    // The last cut is in the index: no message is lost.
    assert_eq!(most, 1500);
    let recovered = said(&["recover", torn.to_str().unwrap(), "--out", whole.to_str().unwrap()]);
    assert!(recovered.status.success(), "{}", text(&recovered.stderr));
    assert_eq!(seqs(&whole), (0..1500).collect::<Vec<_>>());
}

#[test]
fn a_tail_of_zeros_as_a_power_cut_leaves_it_is_passed_over() {
    let (rig, out) = recorded(300);
    let bytes = fs::read(&out).unwrap();
    let torn = rig.tmp.path().join("torn.mcap");
    let before = info::info(&out).unwrap().tally.messages();
    for (cut, zeros) in [(bytes.len() - 200, 4096), (bytes.len() / 2, 65_536), (9_000, 5)] {
        fs::write(&torn, [&bytes[..cut], &vec![0; zeros][..]].concat()).unwrap();
        let found = info::info(&torn).unwrap();
        assert!(!found.damage.is_empty() && found.tally.messages() <= before);
        assert_eq!(seqs(&torn), (0..seqs(&torn).len() as u64).collect::<Vec<_>>());
    }
}

/// The numbers in `N of /tool_pose (numbers A to B, ...`.
fn lost_poses(words: &str) -> (u64, u64) {
    let (_, rest) = words.split_once(" of /tool_pose (number").unwrap();
    let (numbers, _) = rest.split_once(',').unwrap();
    let numbers = numbers.trim_start_matches('s');
    let (first, last) = numbers.split_once(" to ").unwrap_or((numbers, numbers));
    (first.trim().parse().unwrap(), last.trim().parse().unwrap())
}

#[test]
fn a_flipped_bit_is_named_with_its_place_and_costs_its_chunk_only() {
    let (rig, out) = recorded(1000);
    let bytes = fs::read(&out).unwrap();
    let flipped_file = rig.tmp.path().join("flipped.mcap");
    // Each chunk says how it is compressed, then how long it is, then comes what it holds.
    let data = 9 * bytes.len() / 10;
    let chunks: Vec<_> = (0..data).filter(|&at| bytes[at..].starts_with(b"zstd")).collect();
    for share in [0.3, 0.5, 0.7] {
        let mut flipped = bytes.clone();
        let at = chunks[(share * chunks.len() as f64) as usize] + 4 + 8 + 100;
        flipped[at] ^= 4;
        fs::write(&flipped_file, flipped).unwrap();
        let verified = said(&["verify", flipped_file.to_str().unwrap()]);
        let words = text(&verified.stderr);
        assert_eq!(verified.status.code(), Some(1), "{words}");
        assert!(words.contains("at byte ") && words.contains("damaged chunk"), "{words}");
        assert!(words.contains("Data section CRC failed"), "{words}");
        // The poses that it names are those that are missing, and no others.
        let (first, last) = lost_poses(&words);
        let others: Vec<u64> = (0..1000).filter(|seq| !(first..=last).contains(seq)).collect();
        assert!(first <= last, "{words}");
        assert_eq!(seqs(&flipped_file), others, "at {share}: {words}");
    }
    let verified = said(&["verify", out.to_str().unwrap()]);
    assert!(verified.status.success(), "{}", text(&verified.stderr));
    assert!(
        text(&verified.stdout).contains(": whole; "),
        "{}",
        text(&verified.stdout)
    );
}

#[test]
fn another_version_of_the_schema_is_refused_by_name() {
    let tmp = tempfile::tempdir().unwrap();
    let path = tmp.path().join("later.mcap");
    let mut out = mcap_with_schema("trocar.ToolPose.9");
    out.flush();
    fs::write(&path, out.bytes()).unwrap();
    let error = reader::poses(&path, TOOL_POSE)
        .unwrap()
        .next()
        .unwrap()
        .unwrap_err()
        .to_string();
    assert!(
        error.contains(
            "topic /tool_pose holds trocar.ToolPose.9 instead of trocar.ToolPose: another version of this program"
        ),
        "{error}"
    );
    let csv = tmp.path().join("poses.csv");
    let exported = said(&["export", "csv", path.to_str().unwrap(), "--out", csv.to_str().unwrap()]);
    let words = text(&exported.stderr);
    assert!(
        !exported.status.success() && words.contains("/tool_pose (trocar.ToolPose.9)"),
        "{words}"
    );
    assert!(!csv.exists());
}

/// A file of one message, put together by hand: only the recorder's crate knows how to write such files.
struct ByHand(Vec<u8>);

fn mcap_with_schema(name: &str) -> ByHand {
    let mut file = ByHand(b"\x89MCAP0\r\n".to_vec());
    file.record(1, &[text_field(""), text_field("")].concat());
    let schema = [
        &1_u16.to_le_bytes()[..],
        &text_field(name),
        &text_field("protobuf"),
        &0_u32.to_le_bytes(),
    ]
    .concat();
    file.record(3, &schema);
    let ids = [1_u16.to_le_bytes(), 1_u16.to_le_bytes()].concat();
    let channel = [
        &ids[..],
        &text_field(TOOL_POSE),
        &text_field("protobuf"),
        &0_u32.to_le_bytes(),
    ]
    .concat();
    file.record(4, &channel);
    file.record(5, &[&1_u16.to_le_bytes()[..], &[0; 4 + 8 + 8], b"\x08\x07"].concat());
    file
}

fn text_field(text: &str) -> Vec<u8> {
    [&(text.len() as u32).to_le_bytes(), text.as_bytes()].concat()
}

impl ByHand {
    fn record(&mut self, opcode: u8, body: &[u8]) {
        self.0.push(opcode);
        self.0.extend((body.len() as u64).to_le_bytes());
        self.0.extend(body);
    }

    fn flush(&mut self) {
        self.record(15, &[0; 4]);
        self.record(2, &[0; 20]);
        self.0.extend(b"\x89MCAP0\r\n");
    }

    fn bytes(&self) -> &[u8] {
        &self.0
    }
}

#[test]
fn a_file_that_may_not_grow_stops_recording_and_what_was_acknowledged_is_intact() {
    let rig = Rig::new();
    // Its log is beyond the limit from the start: a line that cannot be said is no reason to end.
    let log = rig.tmp.path().join("log");
    fs::write(&log, vec![b'.'; 1_000_000]).unwrap();
    let full = fs::OpenOptions::new().append(true).open(&log).unwrap();
    let recorder = rig.start_logging_to(full.into());
    rig.publish(0..200);
    rig.wait_for_beat(|beat| beat.counters.recorded == 400);
    let growing = paths::recording(&rig.out());
    // Room for one more chunk or so; the next file has room for its schemas and nothing else.
    let most = Some(fs::metadata(&growing).unwrap().len() + 3_000);
    let limit = Rlimit {
        current: most,
        maximum: most,
    };
    let pid = Pid::from_raw(recorder.0.id().cast_signed()).unwrap();
    prlimit(Some(pid), Resource::Fsize, limit).unwrap();
    let mut acknowledged = 0;
    // The first beat that says so counts: the recorder goes on in another file soon, which has room again.
    let mut stopped = None;
    for from in (200..20_000).step_by(50) {
        rig.publish(from..from + 50);
        match rig.beats.newest().unwrap() {
            Some(beat) if beat.note_text().starts_with("NOT RECORDING") => stopped = Some(beat),
            Some(beat) => acknowledged = beat.counters.recorded,
            None => {}
        }
        if stopped.is_some() {
            break;
        }
    }
    let beat = stopped.unwrap();
    assert!(
        beat.counters.recorded >= acknowledged && beat.counters.dropped > 0,
        "{beat:?}"
    );
    let part = paths::recording(&paths::part(&rig.out(), 1));
    let found = info::info(&part).unwrap();
    // Cut back to what was acknowledged: not even half a record is behind it.
    assert_eq!(found.damage.len(), 1, "{:?}", found.damage);
    assert!(found.damage[0].to_string().contains("never finished"));
    let poses = seqs(&part);
    assert_eq!(2 * poses.len() as u64, beat.counters.recorded);
    assert_eq!(poses, (0..poses.len() as u64).collect::<Vec<_>>());
}

/// A file that is rotated is completed, and what is in memory by then goes to the disk first. Where that failed, nobody counted it.
#[test]
fn what_the_completion_of_a_file_loses_is_counted() {
    // 0.01 min are 0.6 s: each chunk is closed by a rotation.
    let rig = Rig::of("[recording]\nchunk_s = 1.0\nrotate_min = 0.01\n");
    let recorder = rig.start();
    rig.publish(0..50);
    // Not one byte more, in this file or in another.
    let limit = Rlimit {
        current: Some(1),
        maximum: Some(1),
    };
    let pid = Pid::from_raw(recorder.0.id().cast_signed()).unwrap();
    prlimit(Some(pid), Resource::Fsize, limit).unwrap();
    rig.publish(50..100);
    let beat = rig.wait_for_beat(|beat| {
        let counters = beat.counters;
        beat.note_text().starts_with("NOT RECORDING") && counters.recorded + counters.lost >= 200
    });
    assert_eq!(beat.counters.recorded + beat.counters.lost, 200, "{beat:?}");
    assert!(beat.counters.lost >= 100, "{beat:?}");
}

#[test]
fn a_disk_without_room_is_refused_before_anything_is_recorded() {
    let rig = Rig::of("[recording]\nmin_free_mb = 1e6\n");
    let said = said(&[
        "record",
        "--run-dir",
        rig.run_dir(),
        "--out",
        rig.out().to_str().unwrap(),
    ]);
    let words = text(&said.stderr);
    // A million megabytes: no machine that runs tests has them.
    assert_eq!(said.status.code(), Some(1), "{words}");
    assert!(
        words.contains("at least 1000000 MB must be (recording.min_free_mb)"),
        "{words}"
    );
    assert!(!paths::recording(&rig.out()).exists());
}

#[test]
fn two_recorders_of_one_run_or_of_one_file_are_refused_by_name() {
    let rig = Rig::new();
    let first = rig.start();
    let elsewhere = rig.tmp.path().join("other.mcap");
    let second = said(&[
        "record",
        "--run-dir",
        rig.run_dir(),
        "--out",
        elsewhere.to_str().unwrap(),
    ]);
    let words = text(&second.stderr);
    assert_eq!(second.status.code(), Some(1), "{words}");
    assert!(words.contains("heartbeat/recorder"), "{words}");
    let other = Rig::new();
    let third = said(&[
        "record",
        "--run-dir",
        other.run_dir(),
        "--out",
        rig.out().to_str().unwrap(),
    ]);
    let words = text(&third.stderr);
    assert_eq!(third.status.code(), Some(1), "{words}");
    assert!(words.contains("is being written by another recorder"), "{words}");
    // The first one is not disturbed.
    rig.publish(0..50);
    first.terminate();
    assert_eq!(seqs(&rig.out()), (0..50).collect::<Vec<_>>());
}

#[test]
fn rotated_and_killed_no_part_is_missing() {
    let rig = Rig::of(&format!("[recording]\nchunk_s = {CHUNK_S}\nrotate_min = 0.01\n"));
    let recorder = rig.start();
    // 0.01 min is 0.6 s; however long the recorder takes for it.
    let mut count = 0;
    while !paths::part(&rig.out(), 2).exists() {
        rig.publish(count..count + 100);
        count += 100;
        assert!(count < 50_000, "no second part in 100 s");
    }
    rig.wait_for_beat(|beat| beat.counters.recorded == 2 * count);
    recorder.kill();
    rig.start().terminate();
    let parts = (1..)
        .map(|n| paths::part(&rig.out(), n))
        .take_while(|part| part.exists());
    let parts: Vec<_> = parts.collect();
    assert!(parts.len() >= 3, "{parts:?}");
    let all: Vec<_> = parts.iter().flat_map(|part| seqs(part)).collect();
    assert_eq!(all, (0..count).collect::<Vec<_>>());
    // What a replay must know of a part is the same by its index and by all of it.
    for part in parts {
        let by_index = said(&["facts", part.to_str().unwrap()]);
        let by_all = said(&["facts", "--whole", part.to_str().unwrap()]);
        assert!(by_index.status.success(), "{}", text(&by_index.stderr));
        assert_eq!(by_index.stderr, b"", "{}", text(&by_index.stderr));
        assert_eq!(text(&by_index.stdout), text(&by_all.stdout));
    }
}

#[test]
fn emitters_are_on_disk_bit_for_bit() {
    let (_rig, out) = recorded(200);
    let frames: Vec<_> = reader::emitters(&out).unwrap().map(Result::unwrap).collect();
    assert_eq!(frames, (0..200).map(frame).collect::<Vec<_>>());
    assert_eq!(info::info(&out).unwrap().tally.topics[EMITTERS].messages, 200);
    // The command line has help with examples for each of its commands.
    for tool in [
        "record", "info", "recover", "verify", "export", "import", "cut", "attach",
    ] {
        let help = command(&[tool, "--help"]).output().unwrap();
        assert!(
            help.status.success() && text(&help.stdout).contains("Example"),
            "{tool}"
        );
    }
}
