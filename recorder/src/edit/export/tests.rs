use std::fs;

use super::*;
use crate::testing;
use crate::wire::schema::{EMITTERS, TF, TOOL_POSE};

fn exported(topic: &str, format: Format) -> Result<(Exported, String), String> {
    let tmp = tempfile::tempdir().unwrap();
    let (input, out) = (tmp.path().join("s.mcap"), tmp.path().join("out"));
    fs::write(&input, testing::finished(2, 5)).unwrap();
    let exported = export(&input, topic, format, &out, false).map_err(|e| e.to_string())?;
    assert!(matches!(
        export(&input, topic, format, &out, false),
        Err(ExportError::Exists(_))
    ));
    Ok((exported, fs::read_to_string(&out).unwrap()))
}

#[test]
fn a_table_of_poses_brings_back_their_bits() {
    let (exported, text) = exported(TOOL_POSE, Format::Csv).unwrap();
    assert_eq!(exported.messages, 10);
    let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let names = lines.next().unwrap();
    let column = |name: &str| names.iter().position(|other| *other == name).unwrap();
    for (seq, cells) in (0..).zip(lines) {
        let pose = testing::pose(seq);
        assert_eq!(cells.len(), names.len());
        assert_eq!(cells[column("seq")], seq.to_string());
        assert_eq!(cells[column("words")], "valid");
        for (name, x) in [("qx", pose.q[1]), ("tz_mm", pose.t_mm[2]), ("c55", pose.covariance[20])] {
            assert_eq!(
                cells[column(name)].parse::<f64>().unwrap().to_bits(),
                x.to_bits(),
                "{name}"
            );
        }
    }
}

#[test]
fn a_table_of_emitters_has_a_row_for_each() {
    let (exported, text) = exported(EMITTERS, Format::Csv).unwrap();
    assert_eq!(exported.messages, 10);
    assert_eq!(text.lines().count(), 1 + 10 * (8 + 2));
    assert!(
        text.starts_with(
            "seq,t_device_ns,t_capture_ns,t_publish_ns,marker,emitter,x_mm,y_mm,z_mm\n0,1,0,1500000,tool,0,"
        )
    );
}

#[test]
fn json_is_a_list_of_objects() {
    let (_, text) = exported(TOOL_POSE, Format::Json).unwrap();
    let lines: Vec<_> = text.lines().collect();
    assert_eq!((lines[0], lines[11], lines.len()), ("[", "]", 12));
    assert!(
        lines[1].starts_with("{\"seq\": 0, ") && lines[1].ends_with("},"),
        "{}",
        lines[1]
    );
}

#[test]
fn a_topic_that_is_not_there_is_told_with_those_that_are() {
    for (topic, format) in [("/other", Format::Csv), (TF, Format::Json), (EMITTERS, Format::Mha)] {
        let text = exported(topic, format).unwrap_err();
        assert!(
            text.contains("can be exported") && text.contains("/tool_pose (trocar.ToolPose)"),
            "{text}"
        );
    }
}

#[test]
fn a_lost_pose_has_no_numbers() {
    let tmp = tempfile::tempdir().unwrap();
    let (input, out) = (tmp.path().join("s.mcap"), tmp.path().join("out"));
    let mut log = testing::log(0, 1);
    log.pose(crate::wire::schema::Source::Tool, &bus::message::ToolPose::EMPTY)
        .unwrap();
    fs::write(&input, log.finish().unwrap().into_inner()).unwrap();
    export(&input, TOOL_POSE, Format::Csv, &out, false).unwrap();
    let text = fs::read_to_string(&out).unwrap();
    assert!(
        text.lines()
            .nth(1)
            .unwrap()
            .contains(",1,marker not seen,0,0,,,,,,,,,,0,0,,"),
        "{text}"
    );
}
