//! Reports of files that were made for them: whole, cut off, damaged, hostile.

use std::fs;
use std::path::PathBuf;

use bus::message::{Level, Lost, Tracked};
use serde_json::Value;

use super::*;
use crate::testing;
use crate::wire::proto::{self, CompressedImage, Log};
use crate::wire::schema::Source;
use crate::write::pose_log::{Entry, PoseLog};

mod organs;
mod refused;
mod timeline;
mod workflow;

type Written = PoseLog<io::Cursor<Vec<u8>>>;

/// A folder with a recording in it.
struct Rig {
    folder: tempfile::TempDir,
}

impl Rig {
    fn new(bytes: &[u8]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("s.mcap"), bytes).unwrap();
        Self { folder }
    }

    fn of(log: Written) -> Self {
        Self::new(&log.finish().unwrap().into_inner())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn made(&self, identity: bool) -> Result<(String, Value), ReportError> {
        let (json, force) = (true, true);
        report(
            &self.path("s.mcap"),
            &self.path("r.html"),
            Wanted { identity, json, force },
        )?;
        let json = fs::read_to_string(self.path("r.json")).unwrap();
        Ok((
            fs::read_to_string(self.path("r.html")).unwrap(),
            serde_json::from_str(&json).unwrap(),
        ))
    }

    fn said(&self) -> (String, Value) {
        self.made(false).unwrap()
    }
}

fn words(facts: &Value) -> Vec<&str> {
    let notices = facts["notices"].as_array().unwrap();
    notices.iter().map(|notice| notice["word"].as_str().unwrap()).collect()
}

fn state(facts: &Value, name: &str) -> u64 {
    let states = facts["states_ns"].as_array().unwrap();
    let found = states.iter().find(|state| state[0] == name);
    found.map_or(0, |state| state[1].as_u64().unwrap())
}

/// What the recorder writes at its end.
fn ended(mut log: Written) -> Written {
    let facts = [("missing", "0"), ("refused", "0"), ("files_before", "0")];
    log.metadata(&mcap::records::Metadata {
        name: "recorder".to_owned(),
        metadata: facts.map(|(key, value)| (key.to_owned(), value.to_owned())).into(),
    })
    .unwrap();
    log
}

fn say(log: &mut Written, t_ns: i64, level: Level, words: &str) {
    let line = Log::new(t_ns, level, "pilot", words.to_owned());
    log.put(Entry::Log(t_ns, &line)).unwrap();
}

/// Poses of `seqs`, lost where `lost` says so, with their truth 0.3 mm beside them.
fn poses(log: &mut Written, seqs: impl Iterator<Item = u64>, lost: impl Fn(u64) -> Option<Lost>) {
    for seq in seqs {
        let mut pose = testing::pose(seq);
        pose.flags |= bus::message::ToolPose::NOISELESS;
        if let Some(reason) = lost(seq) {
            pose.set(Tracked::Lost(reason));
        }
        log.pose(Source::Tool, &pose).unwrap();
        let mut truth = testing::pose(seq);
        truth.t_mm[1] += 0.3;
        log.pose(Source::Truth, &truth).unwrap();
    }
}

/// Checks of the registration stood in no table: only whoever read the log knew that one had failed.
#[test]
fn each_check_has_its_row_with_the_registration_that_was_in_use() {
    let mut log = testing::log(0, 0);
    say(
        &mut log,
        0,
        Level::Info,
        "check passed: 3 points, the worst 0.80 mm off",
    );
    poses(&mut log, 0..60, |_| None);
    let fails = "check FAILED: 1 points, the worst 5.25 mm off (<nasion>: 5.25 mm off, 2.10 mm hold 95 % of errors)";
    say(&mut log, 1_000_000_000, Level::Info, fails);
    // Nobody else checks, and a line that is no check is none.
    log.put(Entry::Log(
        2,
        &Log::new(
            2,
            Level::Info,
            "guest",
            "check passed: 3 points, the worst 0.1 mm off".to_owned(),
        ),
    ))
    .unwrap();
    say(&mut log, 3, Level::Info, "check is to be made");
    let (page, facts) = Rig::of(ended(log)).said();
    let checks = &facts["story"]["checks"];
    let id = format!("{:016x}", testing::pose(0).registration_id);
    assert_eq!(
        (&checks["count"], &checks["listed"][0]["registration"]),
        (&2.into(), &Value::Null)
    );
    let failed = &checks["listed"][1];
    assert_eq!(
        (
            &failed["t_ns"],
            &failed["verdict"],
            &failed["points"],
            &failed["worst_mm"],
            &failed["registration"]
        ),
        (
            &1_000_000_000_u64.into(),
            &"FAILED".into(),
            &1.into(),
            &5.25.into(),
            &id.clone().into()
        )
    );
    let row = format!(
        "<td>00:01.0</td><td><code>{id}</code></td><td>1</td><td>5.25 mm</td><td><strong>FAILED</strong></td>\
         <td><bdi>&lt;nasion&gt;: 5.25 mm off, 2.10 mm hold 95 % of errors</bdi></td>"
    );
    assert!(page.contains(&row), "{page}");
    assert!(
        page.contains("<td>UNKNOWN</td><td>3</td><td>0.800 mm</td><td>passed</td>"),
        "{page}"
    );
    // Whether there was none, or nobody said so.
    let (page, _) = Rig::new(&testing::finished(1, 5)).said();
    assert!(
        page.contains("whether known points were touched is not known"),
        "{page}"
    );
    let mut log = testing::log(1, 5);
    say(&mut log, 1, Level::Info, "everybody ready");
    let (page, _) = Rig::of(log).said();
    assert!(page.contains("no known point was touched"), "{page}");
}

#[test]
fn a_whole_recording_says_what_it_holds() {
    let mut log = testing::log(0, 0);
    poses(&mut log, 0..600, |seq| {
        (300..330).contains(&seq).then_some(Lost::NotSeen)
    });
    say(&mut log, 2_000_000_000, Level::Info, "mark: first biopsy");
    let (page, facts) = Rig::of(ended(log)).said();
    assert_eq!(words(&facts), ["SIMULATED TOOL", "NO RUN REPORT"], "{page}");
    assert_eq!(facts["poses"]["samples"], 600);
    assert_eq!(facts["poses"]["lost"]["marker not seen"], 30);
    // 30 samples at 60 Hz, as `recorder info` has it.
    let lost = state(&facts, "lost: marker not seen");
    // Published 1.5 ms after its capture.
    assert_eq!(facts["lost_longest"][0]["from_ns"], 5_001_500_000_u64);
    assert!((499_999_990..=500_000_010).contains(&lost), "{lost}");
    let span = &facts["recording"]["span_ns"];
    let all: u64 = facts["states_ns"]
        .as_array()
        .unwrap()
        .iter()
        .map(|s| s[1].as_u64().unwrap())
        .sum();
    assert_eq!(all, span[1].as_u64().unwrap() - span[0].as_u64().unwrap());
    let tip = &facts["tip"];
    assert!((tip["true_mm"]["max"].as_f64().unwrap() - 0.3).abs() < 1e-9);
    assert_eq!(
        (&tip["true_mm"]["count"], &tip["compared"], &tip["beyond"]),
        (&570.into(), &570.into(), &0.into())
    );
    assert!((tip["predicted_95_mm"]["max"].as_f64().unwrap() - 0.91).abs() < 1e-3);
    assert_eq!(facts["latency_ms"]["max"], 1.5);
    assert!(
        page.contains("<bdi>first biopsy</bdi>") && page.contains("00:02.0"),
        "{page}"
    );
    assert!(page.contains("no mark has one"), "a recording without pictures says so");
}

#[test]
fn samples_that_are_missing_are_not_live() {
    let mut log = testing::log(0, 0);
    poses(&mut log, (0..60).chain(240..300), |_| None);
    let (_, facts) = Rig::of(ended(log)).said();
    // 181 intervals of 60 Hz, of which the first 100 ms are of a pose that was young enough, until the next is published 1.5 ms after its capture.
    let unknown = state(&facts, "lost: samples missing");
    assert!((2_918_166_000..=2_918_167_000).contains(&unknown), "{unknown}");
    assert_eq!(facts["poses"]["missing"], 180);
    assert_eq!(state(&facts, "stale"), 0);
}

/// A file that was cut off was said to have a silent tracker from its last readable pose to its last readable line.
#[test]
fn what_is_behind_the_end_of_a_file_is_not_a_silent_tracker() {
    let mut log = testing::log(0, 0);
    poses(&mut log, 0..60, |_| None);
    say(&mut log, 9_000_000_000, Level::Info, "mark: later than the poses");
    log.flush().unwrap();
    poses(&mut log, 60..600, |_| None);
    let whole = ended(log).finish().unwrap().into_inner();
    let rig = Rig::new(&whole);
    assert_eq!(state(&rig.said().1, "not readable"), 0);
    // Within the chunk of the other poses.
    fs::write(rig.path("s.mcap"), &whole[..whole.len() / 2]).unwrap();
    let (_, facts) = rig.said();
    assert_eq!(state(&facts, "lost: tracker silent"), 0, "{facts:#}");
    assert!(state(&facts, "not readable") > 7_000_000_000, "{facts:#}");
}

#[test]
fn whatever_is_cut_off_says_so_and_no_cut_is_called_whole() {
    let mut log = testing::log(4, 30);
    say(&mut log, 1_000_000_000, Level::Info, "mark: here");
    let whole = ended(log).finish().unwrap().into_inner();
    let rig = Rig::new(&whole);
    assert!(!words(&rig.said().1).contains(&"INCOMPLETE"));
    for length in (9..whole.len()).step_by(whole.len() / 97) {
        fs::write(rig.path("s.mcap"), &whole[..length]).unwrap();
        match rig.made(false) {
            Ok((page, facts)) => {
                assert!(words(&facts).contains(&"INCOMPLETE"), "{length}: {:?}", words(&facts));
                assert!(!page.contains("is whole and was ended"), "{length}");
            }
            Err(error) => assert!(matches!(error, ReportError::Nothing { .. }), "{length}: {error}"),
        }
    }
}

#[test]
fn damage_is_counted_at_the_top_and_the_rest_is_reported() {
    let mut bytes = ended(testing::log(6, 30)).finish().unwrap().into_inner();
    let whole = Rig::new(&bytes).said().1;
    // In the middle of a chunk.
    let at = bytes.len() / 2;
    bytes[at] ^= 0x10;
    let (page, facts) = Rig::new(&bytes).said();
    assert_eq!(words(&facts)[0], "DAMAGED");
    let lost = facts["damage"]["lost"]["/tool_pose"].as_u64().unwrap();
    let read = facts["poses"]["samples"].as_u64().unwrap();
    assert_eq!((lost, read + lost), (30, whole["poses"]["samples"].as_u64().unwrap()));
    assert!(page.contains("30 of /tool_pose"), "{page}");
    // Half a second is gone, and nobody knows what it was.
    let unknown = state(&facts, "not readable");
    assert!((400_000_000..450_000_000).contains(&unknown), "{unknown}");
}

#[test]
fn a_recording_that_a_kill_left_and_recovery_made_whole_does_not_pass_for_one_that_ended() {
    let rig = Rig::new(&testing::unfinished(2, 30));
    assert!(words(&rig.said().1).contains(&"INCOMPLETE"));
    crate::edit::recover::recover(&rig.path("s.mcap"), &rig.path("whole.mcap")).unwrap();
    fs::rename(rig.path("whole.mcap"), rig.path("s.mcap")).unwrap();
    let (page, facts) = rig.said();
    assert!(words(&facts).contains(&"END NOT RECORDED"), "{:?}", words(&facts));
    assert!(!page.contains("was ended in an orderly way;"));
}

/// Whole parts of a session that was recorded in several files were called such as no recorder had ended.
#[test]
fn a_part_of_a_session_is_called_one() {
    for (before, words_of) in [(0, "0 files"), (2, "2 files")] {
        let mut log = testing::log(1, 30);
        log.metadata(&crate::write::series::part::record(before)).unwrap();
        let (page, facts) = Rig::new(&log.finish().unwrap().into_inner()).said();
        let words = words(&facts);
        assert!(
            words.contains(&"ONE PART") && !words.contains(&"END NOT RECORDED"),
            "{words:?}"
        );
        assert!(page.contains(&format!(
            "{words_of} of the session came before this one; the session went on"
        )));
    }
}

#[test]
fn a_stretch_and_a_replay_are_named_as_such() {
    let rig = Rig::new(&ended(testing::log(4, 30)).finish().unwrap().into_inner());
    let stretch = crate::edit::cut::Stretch {
        from_ns: 500_000_000,
        to_ns: 1_000_000_000,
    };
    crate::edit::cut::cut(&rig.path("s.mcap"), stretch, &rig.path("cut.mcap"), false).unwrap();
    fs::rename(rig.path("cut.mcap"), rig.path("s.mcap")).unwrap();
    let (page, facts) = rig.said();
    assert!(words(&facts).contains(&"A STRETCH"), "{:?}", words(&facts));
    assert!(page.contains("a part of s.mcap, from 0.5 s to 1.0 s"), "{page}");

    let mut log = testing::log(1, 30);
    log.attach(
        "report.json",
        "application/json",
        br#"{"trocar_version": "0.2.0", "simulated_time": true, "problems": ["<i>"]}"#,
        0,
    )
    .unwrap();
    log.facts(&crate::wire::schema::RunFacts {
        remade_from: Some("/data/SMITH/s.mcap".to_owned()),
        ..testing::facts()
    })
    .unwrap();
    let (page, facts) = Rig::of(ended(log)).said();
    for word in ["REPLAY", "SIMULATED TIME", "PROBLEMS"] {
        assert!(words(&facts).contains(&word), "{word}: {:?}", words(&facts));
    }
    assert!(!page.contains("SMITH") && page.contains("a replay of s.mcap") && page.contains("&lt;i&gt;"));
}

#[test]
fn whose_examination_it_is_is_said_only_where_that_is_asked() {
    let identity = proto::Identity {
        source: "examination".to_owned(),
        name: "SECRET^A".to_owned(),
        patient_id: "SECRET-7".to_owned(),
        ..proto::Identity::default()
    };
    let mut log = testing::log(1, 10);
    log.with_identity().unwrap();
    log.put(Entry::Identity(&identity)).unwrap();
    let rig = Rig::of(ended(log));
    let (page, facts) = rig.said();
    assert!(!page.contains("SECRET") && !facts.to_string().contains("SECRET"));
    assert_eq!(facts["identity"]["known"], "not_asked");
    let (page, facts) = rig.made(true).unwrap();
    assert!(page.contains("SECRET^A") && page.contains("SECRET-7"));
    assert_eq!(facts["identity"]["name"], "SECRET^A");
    let (page, facts) = Rig::of(ended(testing::log(1, 10))).made(true).unwrap();
    assert!(page.contains("the recording holds no identity"));
    assert_eq!(facts["identity"]["known"], "not_recorded");
}

#[test]
fn whatever_a_file_says_is_read_as_text() {
    const EVIL: &str = "<script>alert(1)</script>\"'&\u{202e}\0\u{1b}]0;x\u{7}<img src=x onerror=a>";
    let mut log = PoseLog::new(
        io::Cursor::new(Vec::new()),
        scene::Compression::Zstd,
        &["<b>v".to_owned()],
    )
    .unwrap();
    log.facts(&crate::wire::schema::RunFacts {
        name: EVIL.to_owned(),
        ..testing::facts()
    })
    .unwrap();
    log.attach("<script>.json", EVIL, EVIL.as_bytes(), u64::MAX).unwrap();
    log.attach("scene.toml", "application/toml", EVIL.as_bytes(), 0)
        .unwrap();
    let problems = serde_json::json!({"trocar_version": EVIL, "scene": EVIL, "problems": [EVIL], "notes": [EVIL], "held": [EVIL],
        "views": [{"name": EVIL}], "restarts": [{"process": EVIL, "cause": EVIL}], "latency_ms": {EVIL: {"p50": 1.0}},
        "volume": {"hash": EVIL, "marks": EVIL},
        "tissue": {"images": {EVIL: 3}, "refused_because": {EVIL: 1}}});
    log.attach("report.json", "application/json", problems.to_string().as_bytes(), 0)
        .unwrap();
    poses(&mut log, 0..10, |_| None);
    say(&mut log, 5, Level::Info, &format!("mark: {EVIL}"));
    say(&mut log, 6, Level::Error, EVIL);
    let status = proto::ProcessStatus {
        process: EVIL.to_owned(),
        state: EVIL.to_owned(),
        note: EVIL.to_owned(),
        ..proto::ProcessStatus::default()
    };
    log.put(Entry::Status(&status)).unwrap();
    let png = picture::encode_png(&picture::Canvas::new(4, 4), &[]).unwrap();
    let image = &CompressedImage::png(5, EVIL, png);
    let (view, seq, t_ns) = (0, 1, 5);
    log.put(Entry::Image { view, seq, t_ns, image }).unwrap();
    let (page, _) = Rig::of(ended(log)).said();
    let style = page.split_once("</style>").unwrap().1;
    assert!(
        !style.contains("<script") && !style.contains("<img src=x") && !style.contains("<b>v"),
        "{style}"
    );
    assert!(!page.contains(|c: char| c == '\u{202e}' || (c.is_control() && c != '\n')));
    assert!(page.contains("[U+202E]") && page.contains("&lt;script&gt;"));
    // Nothing is loaded from anywhere, and nothing runs.
    let loads = [
        "src=\"http",
        "href=",
        "url(",
        "@import",
        "<link",
        "<iframe",
        "<object",
        "onload=\"",
    ];
    assert!(loads.iter().all(|word| !page.contains(word)));
    assert_eq!(
        page.matches("<img ").count(),
        page.matches("src=\"data:image/png;base64,").count()
    );
}
