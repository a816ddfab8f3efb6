//! What cannot be reported, and what is not written over.

use std::os::unix::fs::PermissionsExt;

use super::*;

fn refused(rig: &Rig) -> String {
    let error = rig.made(false).unwrap_err();
    assert!(!rig.path("r.html").exists() && !rig.path("r.html.partial").exists());
    error.to_string()
}

#[test]
fn what_is_no_recording_is_refused_by_name() {
    let rig = Rig::new(b"");
    assert!(
        refused(&rig).contains("s.mcap is not an MCAP file"),
        "{}",
        refused(&rig)
    );
    fs::write(rig.path("s.mcap"), "hello, this is text").unwrap();
    assert!(refused(&rig).contains("is not an MCAP file"));
    fs::write(rig.path("s.mcap"), mcap::MAGIC).unwrap();
    let said = refused(&rig);
    assert!(
        said.contains("no messages") && said.contains("never finished"),
        "{said}"
    );
    fs::remove_file(rig.path("s.mcap")).unwrap();
    assert!(refused(&rig).contains("No such file"));
    fs::create_dir(rig.path("s.mcap")).unwrap();
    assert!(refused(&rig).contains("folder"), "{}", refused(&rig));
}

/// A file with one message of a topic, of a schema with these bytes.
fn other(topic: &str, schema: &str, descriptor: &[u8]) -> Rig {
    let mut out = mcap::Writer::new(io::Cursor::new(Vec::new())).unwrap();
    let schema = out.add_schema(schema, "protobuf", descriptor).unwrap();
    let channel = out.add_channel(schema, topic, "protobuf", &Default::default()).unwrap();
    let header = mcap::records::MessageHeader {
        channel_id: channel,
        sequence: 0,
        log_time: 1,
        publish_time: 1,
    };
    out.write_to_known_channel(&header, b"").unwrap();
    out.finish().unwrap();
    Rig::new(&out.into_inner().into_inner())
}

#[test]
fn another_kind_and_a_later_version_are_refused_by_name() {
    let said = refused(&other("/camera", "sensor_msgs/Image", b""));
    assert!(said.contains("It holds: /camera (sensor_msgs/Image)"), "{said}");
    let said = refused(&other("/tool_pose", "trocar.ToolPose2", b""));
    assert!(said.contains("topic /tool_pose holds \"trocar.ToolPose2\""), "{said}");
    // One field more than this version knows.
    use prost::Message as _;
    let mut files = prost_types::FileDescriptorSet::decode(crate::wire::descriptor::TOOL_POSE).unwrap();
    let field = prost_types::FieldDescriptorProto {
        name: Some("tissue_mm".to_owned()),
        number: Some(16),
        ..Default::default()
    };
    files.file[0].message_type[0].field.push(field);
    let said = refused(&other("/tool_pose", "trocar.ToolPose", &files.encode_to_vec()));
    assert!(
        said.contains("tissue_mm = 16") && said.contains("a later one"),
        "{said}"
    );
}

#[test]
fn a_recording_without_poses_is_reported_as_one() {
    let mut log = testing::log(0, 0);
    say(&mut log, 3_000_000_000, Level::Warning, "nobody came");
    say(&mut log, 9_000_000_000, Level::Info, "mark: end");
    let (page, facts) = Rig::of(ended(log)).said();
    assert!(words(&facts).contains(&"NO POSES"));
    assert_eq!(state(&facts, "no sample yet"), 6_000_000_000);
    assert!(page.contains("UNKNOWN") && facts["tip"]["predicted_95_mm"].is_null() && facts["latency_ms"].is_null());
    // Facts of a run and no message at all.
    let (_, facts) = Rig::of(ended(testing::log(0, 0))).said();
    assert!(facts["recording"]["span_ns"].is_null());
}

#[test]
fn stamps_of_no_clock_are_counted_and_drawn_nowhere() {
    let mut log = testing::log(1, 30);
    for t_ns in [i64::MAX, i64::MIN, 1 << 61] {
        let mut pose = testing::pose(31);
        pose.t_capture_ns = t_ns;
        log.pose(crate::wire::schema::Source::Tool, &pose).unwrap();
    }
    let (_, facts) = Rig::of(ended(log)).said();
    // Three poses, and for those of the future their transforms.
    assert_eq!(
        (&facts["poses"]["samples"], &facts["damage"]["unreadable"]),
        (&30.into(), &5.into())
    );
    assert!(facts["recording"]["span_ns"][1].as_u64().unwrap() < 1_000_000_000);
}

#[test]
fn nothing_is_written_over_unasked_and_never_the_recording() {
    let rig = Rig::new(&ended(testing::log(1, 10)).finish().unwrap().into_inner());
    let input = rig.path("s.mcap");
    let bytes = fs::read(&input).unwrap();
    let wanted = Wanted::default();
    let page = rig.path("r.html");
    report(&input, &page, wanted).unwrap();
    assert_eq!(fs::metadata(&page).unwrap().permissions().mode() & 0o777, 0o600);
    let said = report(&input, &page, wanted).unwrap_err().to_string();
    assert!(
        said.contains("r.html exists already") && said.contains("--force"),
        "{said}"
    );
    let force = Wanted { force: true, ..wanted };
    report(&input, &page, force).unwrap();
    std::os::unix::fs::symlink(&input, rig.path("link.html")).unwrap();
    for out in [input.clone(), rig.path("link.html")] {
        assert!(matches!(report(&input, &out, force), Err(ReportError::Itself(_))));
    }
    let json = Wanted { json: true, ..force };
    assert!(matches!(
        report(&input, &rig.path("r.json"), json),
        Err(ReportError::Itself(_))
    ));
    let said = report(&input, &rig.path("nowhere/r.html"), wanted)
        .unwrap_err()
        .to_string();
    assert!(said.contains("nowhere") && said.contains("--out"), "{said}");
    assert_eq!(fs::read(&input).unwrap(), bytes);
    let names = fs::read_dir(rig.path("")).unwrap().count();
    assert_eq!(names, 3, "recording, page and link");
}

/// The report of another run, an empty one and the last of two were believed: "Problems: None".
#[test]
fn a_report_of_another_run_or_of_none_is_not_believed() {
    let of = |reports: &[&str]| {
        let mut log = testing::log(1, 10);
        log.facts(&crate::wire::schema::RunFacts {
            volume_hash: Some(bus::message::VolumeHash([7; 32])),
            ..testing::facts()
        })
        .unwrap();
        for report in reports {
            log.attach("report.json", "application/json", report.as_bytes(), 0)
                .unwrap();
        }
        let (_, facts) = Rig::of(ended(log)).said();
        let notices = facts["notices"].as_array().unwrap();
        let found = notices.iter().find(|notice| notice["word"] == "RUN REPORT NOT READ");
        found.map(|notice| notice["words"].as_str().unwrap().to_owned())
    };
    let with = |more: &str| format!(r#"{{"trocar_version": "0.2.0", "problems": [], {more}}}"#);
    let [same, run, hash] = [
        r#""run": "demo", "volume": {"hash": "0707070707070707070707070707070707070707070707070707070707070707"}"#,
        r#""run": "other""#,
        r#""volume": {"hash": "0808"}"#,
    ]
    .map(with);
    assert_eq!(of(&[&same]), None);
    for (reports, words) in [
        (&[&run[..]][..], "it is of run other, and the recording of demo"),
        (&[&hash], "it is of examination 0808, and the recording of 0707"),
        (&["{}"], "it is no report of a run: it has no \"trocar_version\""),
        (&[&run, &same], "two files of that name are attached"),
    ] {
        let said = of(reports).unwrap_or_default();
        assert!(said.contains(words), "{words}: {said}");
    }
}
