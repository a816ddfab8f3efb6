use super::*;
use crate::testing;
use mcap::records::MessageHeader;
use std::collections::BTreeMap;

mod one_run;

fn of(bytes: &[u8]) -> Result<Facts, FactsError> {
    let tmp = tempfile::tempdir().unwrap();
    let path = tmp.path().join("s.mcap");
    std::fs::write(&path, bytes).unwrap();
    let (found, read) = (facts(&path), facts_of_all(&path));
    // By the index, and by every message.
    assert_eq!(found.as_ref().ok(), read.as_ref().ok());
    assert_eq!(
        found.as_ref().err().map(ToString::to_string),
        read.as_ref().err().map(ToString::to_string)
    );
    found
}

/// Why the index is not gone by; `None` where it is.
fn why_read(bytes: &[u8]) -> Option<String> {
    let tmp = tempfile::tempdir().unwrap();
    let path = tmp.path().join("s.mcap");
    std::fs::write(&path, bytes).unwrap();
    indexed::facts(&path).err()
}

#[test]
fn whole_files_are_known_by_their_index_and_others_are_read() {
    for (chunks, per_chunk) in [(0, 1), (1, 1), (1, 30), (2, 30), (7, 5)] {
        assert_eq!(
            why_read(&testing::finished(chunks, per_chunk)),
            None,
            "{chunks} of {per_chunk}"
        );
    }
    let words = |bytes: &[u8]| why_read(bytes).unwrap();
    assert_eq!(
        words(&testing::unfinished(2, 30)),
        "the file has no index that can be read"
    );
    let whole = testing::finished(3, 5);
    assert!(words(&whole[..whole.len() - 9]).contains("no index that can be read"));
    // A chunk's opcode: the index has it where none is, which the replay finds beside its work (`heads`); at either end the file is
    // read for it.
    let chunks: Vec<usize> = whole
        .windows(4)
        .enumerate()
        .filter(|(_, w)| w == b"zstd")
        .map(|(at, _)| at - (1 + 8 + 16 + 8 + 4 + 4))
        .collect();
    let flipped = |k: usize| {
        let mut flipped = whole.clone();
        flipped[chunks[k]] ^= 0x40;
        why_read(&flipped)
    };
    assert_eq!(flipped(2), None);
    for end in [1, 3] {
        assert_eq!(
            flipped(end),
            Some(format!("its chunk at byte {} cannot be read", chunks[end]))
        );
    }
}

/// A session of 300 poses was replayed as one of 31: its index had the lists of two chunks under each other's channels.
#[test]
fn a_list_that_names_another_channel_is_no_end_of_the_session() {
    let bytes = testing::swapped_lists();
    let words = why_read(&bytes).unwrap();
    assert!(words.contains("is not that of its poses"), "{words}");
    let facts = of(&bytes).unwrap();
    assert_eq!((facts.poses, facts.last_ns), (15, testing::pose(14).t_publish_ns));
}

/// A session of 20 s was replayed as one of 0 s: the last chunk counted as sound and empty.
#[test]
fn a_damaged_chunk_at_either_end_is_no_end_of_the_session() {
    let tmp = tempfile::tempdir().unwrap();
    let (path, attached) = (tmp.path().join("s.mcap"), tmp.path().join("report.json"));
    std::fs::write(&path, testing::finished(4, 30)).unwrap();
    // As the pilot does at the end of a run: behind the last chunk.
    std::fs::write(&attached, "{}").unwrap();
    crate::edit::attach::attach(&path, &attached).unwrap();
    let whole = std::fs::read(&path).unwrap();
    let names = whole.windows(4).enumerate().filter(|(_, w)| w == b"zstd");
    let chunks: Vec<usize> = names.map(|(at, _)| at).collect();
    let mut damaged = 0;
    for chunk in chunks {
        let mut flipped = whole.clone();
        // Behind the name and the length, in the packed records.
        flipped[chunk + 4 + 8 + 30] ^= 0x10;
        std::fs::write(&path, flipped).unwrap();
        let (by_index, read) = (facts(&path).unwrap(), facts_of_all(&path).unwrap());
        // At either end the file is read, and says what is wrong; in the middle that is met on the way.
        assert!(by_index == read || by_index.damage.is_empty());
        let seconds = (by_index.last_ns - by_index.first_ns) as f64 / 1e9;
        let expected = (read.last_ns - read.first_ns) as f64 / 1e9;
        assert!(
            (seconds - expected).abs() < 1e-9 && seconds > 1.4,
            "{seconds} {expected}"
        );
        damaged += usize::from(!by_index.damage.is_empty());
    }
    assert!(damaged >= 2, "{damaged}");
}

#[test]
fn files_that_were_cut_recovered_or_attached_to_are_known_by_their_index_too() {
    let tmp = tempfile::tempdir().unwrap();
    let (path, part) = (tmp.path().join("s.mcap"), tmp.path().join("part.mcap"));
    std::fs::write(&path, testing::finished(4, 30)).unwrap();
    let stretch = crate::edit::cut::Stretch {
        from_ns: 500_000_000,
        to_ns: 1_200_000_000,
    };
    crate::edit::cut::cut(&path, stretch, &part, false).unwrap();
    let bytes = std::fs::read(&part).unwrap();
    let facts = of(&bytes).unwrap();
    assert_eq!((why_read(&bytes), facts.poses, facts.emitters), (None, 43, 43));
    let attached = tmp.path().join("report.json");
    std::fs::write(&attached, "{}").unwrap();
    crate::edit::attach::attach(&path, &attached).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    assert_eq!((why_read(&bytes), of(&bytes).unwrap().files.len()), (None, 1));
}

#[test]
fn a_whole_recording() {
    let facts = of(&testing::finished(2, 30)).unwrap();
    let (first, last) = (testing::pose(0), testing::pose(59));
    assert_eq!((facts.poses, facts.truths, facts.emitters), (60, 60, 60));
    assert_eq!((facts.emitters_refused, facts.files), (None, Vec::new()));
    assert_eq!((facts.first_ns, facts.last_ns), (first.t_publish_ns, last.t_publish_ns));
    assert_eq!(facts.scene.as_deref(), Some("seed = 1\n"));
    assert_eq!((facts.run.as_deref(), &facts.volume_hash), (Some("demo"), &None));
    assert!(facts.damage.is_empty());
}

#[test]
fn damage_is_told_and_no_poses_are_refused() {
    // Cut off within the second chunk.
    let cut = testing::unfinished(1, 30).len() + 100;
    let facts = of(&testing::unfinished(2, 30)[..cut]).unwrap();
    assert_eq!((facts.poses, facts.damage.len()), (30, 1));
    let text = of(&testing::finished(0, 1)).unwrap_err().to_string();
    assert!(text.contains("holds no poses"), "{text}");
}

#[test]
fn times_that_no_clock_shows_are_refused() {
    let mut log = testing::log(1, 2);
    let mut pose = testing::pose(2);
    pose.t_capture_ns = i64::MIN;
    log.pose(crate::wire::schema::Source::Tool, &pose).unwrap();
    let text = of(&log.finish().unwrap().into_inner()).unwrap_err().to_string();
    assert!(
        text.contains("message 3 of topic /tool_pose: pose 2 was captured at -9223372036854775808 ns"),
        "{text}"
    );
}

/// A file with one message of `data` on the pose topic, under this schema.
fn foreign(name: &str, schema: &[u8], data: &[u8]) -> Vec<u8> {
    foreign_on(TOOL_POSE, name, schema, data)
}

fn foreign_on(topic: &str, name: &str, schema: &[u8], data: &[u8]) -> Vec<u8> {
    let mut mcap = mcap::Writer::new(std::io::Cursor::new(Vec::new())).unwrap();
    let schema = mcap.add_schema(name, "protobuf", schema).unwrap();
    let channel = mcap.add_channel(schema, topic, "protobuf", &BTreeMap::new()).unwrap();
    let header = MessageHeader {
        channel_id: channel,
        sequence: 0,
        log_time: 0,
        publish_time: 0,
    };
    mcap.write_to_known_channel(&header, data).unwrap();
    mcap.finish().unwrap();
    mcap.into_inner().into_inner()
}

#[test]
fn other_schemas_and_later_ones_are_refused() {
    let text = of(&foreign("trocar.ToolPose9", b"", b"")).unwrap_err().to_string();
    assert!(
        text.contains("holds \"trocar.ToolPose9\" where \"trocar.ToolPose\" is needed"),
        "{text}"
    );
    let mut later = FileDescriptorSet::decode(descriptor::TOOL_POSE).unwrap();
    let fields = &mut later.file[0].message_type[0].field;
    let mut more = fields[0].clone();
    (more.name, more.number) = (Some("grip".to_owned()), Some(16));
    fields.push(more);
    let text = of(&foreign(POSE_SCHEMA, &later.encode_to_vec(), b""))
        .unwrap_err()
        .to_string();
    assert!(text.contains("does not know (grip = 16)"), "{text}");
    let text = of(&foreign(POSE_SCHEMA, descriptor::TOOL_POSE, b""))
        .unwrap_err()
        .to_string();
    assert!(
        text.contains("message 1 of topic /tool_pose: message 0: q has 0 values instead of 4"),
        "{text}"
    );
}

#[test]
fn choices_of_a_later_version_are_refused() {
    let refused = |bytes: &[u8]| of(bytes).unwrap_err().to_string();
    let text = refused(&foreign_on(GUIDE, "trocar.Guide9", b"", b""));
    assert!(
        text.contains("topic /guide holds \"trocar.Guide9\" where \"trocar.Guide\" is needed"),
        "{text}"
    );
}

#[test]
fn emitters_of_another_kind_are_told_and_refuse_no_replay_of_poses() {
    let facts = read_bytes(&foreign_on(EMITTERS, "trocar.EmitterFrame9", b"", b""));
    let why = facts.emitters_refused.unwrap();
    assert!(
        why.contains("topic /emitters holds \"trocar.EmitterFrame9\" where \"trocar.EmitterFrame\" is needed"),
        "{why}"
    );
}

/// The facts of a file that may have no poses.
fn read_bytes(bytes: &[u8]) -> Facts {
    let tmp = tempfile::tempdir().unwrap();
    let path = tmp.path().join("s.mcap");
    std::fs::write(&path, bytes).unwrap();
    read(&path).unwrap()
}

#[test]
fn attached_calibrations_are_told_and_what_is_no_text_is_not() {
    let mut log = testing::log(1, 1);
    for (name, bytes) in [("tool.json", &b"{}"[..]), ("bad.json", b"\xff"), ("x.png", b"{}")] {
        log.attach(name, "application/json", bytes, 0).unwrap();
    }
    let facts = of(&log.finish().unwrap().into_inner()).unwrap();
    let tool = AttachedText {
        name: "tool.json".to_owned(),
        text: "{}".to_owned(),
    };
    assert_eq!(facts.files, [tool]);
}
