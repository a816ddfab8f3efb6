use super::*;
use crate::testing;
use mcap::records::MessageHeader;
use std::collections::BTreeMap;

fn of(bytes: &[u8]) -> Result<Facts, FactsError> {
    let tmp = tempfile::tempdir().unwrap();
    let path = tmp.path().join("s.mcap");
    std::fs::write(&path, bytes).unwrap();
    facts(&path)
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
    log.pose(crate::schema::Source::Tool, &pose).unwrap();
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
    let mut later = FileDescriptorSet::decode(&*descriptor::tool_pose()).unwrap();
    let fields = &mut later.file[0].message_type[0].field;
    let mut more = fields[0].clone();
    (more.name, more.number) = (Some("grip".to_owned()), Some(16));
    fields.push(more);
    let text = of(&foreign(POSE_SCHEMA, &later.encode_to_vec(), b""))
        .unwrap_err()
        .to_string();
    assert!(text.contains("does not know (grip = 16)"), "{text}");
    let text = of(&foreign(POSE_SCHEMA, &descriptor::tool_pose(), b""))
        .unwrap_err()
        .to_string();
    assert!(
        text.contains("message 1 of topic /tool_pose: message 0: q has 0 values instead of 4"),
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
