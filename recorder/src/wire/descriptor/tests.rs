use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use prost::Message as _;
use prost_types::{DescriptorProto, FileDescriptorSet};

use super::*;
use crate::wire::proto;

/// The `.proto` file of each schema, without its ending.
const SCHEMAS: [(&str, &[u8]); 13] = [
    ("trocar/ToolPose", TOOL_POSE),
    ("trocar/EmitterFrame", EMITTER_FRAME),
    ("trocar/MarkerFrame", MARKER_FRAME),
    ("trocar/TissueState", TISSUE_STATE),
    ("trocar/TissueMesh", TISSUE_MESH),
    ("trocar/ProcessStatus", PROCESS_STATUS),
    ("trocar/Guide", GUIDE),
    ("trocar/Workflow", WORKFLOW),
    ("trocar/Identity", IDENTITY),
    ("foxglove/FrameTransform", FRAME_TRANSFORM),
    ("foxglove/Log", LOG),
    ("foxglove/RawImage", RAW_IMAGE),
    ("foxglove/CompressedImage", COMPRESSED_IMAGE),
];

/// What a reader of the file needs: neither comments nor options of code that nobody generates.
fn compiled(name: &str) -> Vec<u8> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("proto");
    let bytes = protox::compile([format!("{name}.proto")], [&folder])
        .unwrap()
        .encode_to_vec();
    let mut set = FileDescriptorSet::decode(&*bytes).unwrap();
    for file in &mut set.file {
        (file.options, file.source_code_info) = (None, None);
        file.message_type.iter_mut().for_each(without_json_names);
    }
    set.encode_to_vec()
}

fn without_json_names(message: &mut DescriptorProto) {
    message.field.iter_mut().for_each(|field| field.json_name = None);
    message.nested_type.iter_mut().for_each(without_json_names);
}

/// With `TROCAR_COMPILE_SCHEMAS=1` they are written anew.
#[test]
fn the_schemas_are_those_of_the_proto_files() {
    for (name, schema) in SCHEMAS {
        let compiled = compiled(name);
        if std::env::var_os("TROCAR_COMPILE_SCHEMAS").is_some() {
            let path = format!("{}/proto/{name}.binpb", env!("CARGO_MANIFEST_DIR"));
            fs::write(path, &compiled).unwrap();
            continue;
        }
        assert_eq!(
            compiled, schema,
            "{name}.proto: compile it with TROCAR_COMPILE_SCHEMAS=1"
        );
    }
}

/// The Python reader adds imported files in the order in which they stand.
#[test]
fn imported_files_come_before_those_that_import_them() {
    for (name, schema) in SCHEMAS {
        let set = FileDescriptorSet::decode(schema).unwrap();
        let names: Vec<_> = set.file.iter().map(|file| file.name().to_owned()).collect();
        for (index, file) in set.file.iter().enumerate() {
            assert!(
                file.dependency.iter().all(|import| names[..index].contains(import)),
                "{name}"
            );
        }
        assert_eq!(names.last().unwrap(), &format!("{name}.proto"));
    }
}

/// The bytes of a message with the numbers of its fields, as anybody reads them who has the schema only.
fn fields(schema: &[u8], message: &str, bytes: &[u8]) -> BTreeMap<String, String> {
    let pool = protox::prost_reflect::DescriptorPool::decode(schema).unwrap();
    let descriptor = pool.get_message_by_name(message).unwrap();
    let read = protox::prost_reflect::DynamicMessage::decode(descriptor.clone(), bytes).unwrap();
    assert!(
        read.unknown_fields().next().is_none(),
        "{message}: a field that the schema does not have"
    );
    assert_eq!(
        read.fields().count(),
        descriptor.fields().count(),
        "{message}: a field that was not written"
    );
    let named = read
        .fields()
        .map(|(field, value)| (field.name().to_owned(), value.to_string()));
    named.collect()
}

/// What we write and what a stranger reads by the schema: every field set, each to a value of its own.
#[test]
fn what_is_written_is_read_by_the_schema() {
    let pose = proto::ToolPose {
        seq: 1,
        t_device_ns: -2,
        t_capture_ns: -3,
        t_publish_ns: 4,
        registration_id: 5,
        status: 6,
        visible: 7,
        q: vec![8.5],
        t_mm: vec![9.5],
        covariance: vec![10.5],
        fre_rms_mm: Some(11.5),
        tip_mm: Some(12.5),
        delay_ns: 13,
        used: 14,
        flags: 15,
    };
    let read = fields(TOOL_POSE, "trocar.ToolPose", &pose.encode_to_vec());
    for (name, value) in [
        ("seq", "1"),
        ("t_device_ns", "-2"),
        ("t_capture_ns", "-3"),
        ("t_publish_ns", "4"),
        ("registration_id", "5"),
        ("status", "6"),
        ("visible", "7"),
        ("q", "[8.5]"),
        ("t_mm", "[9.5]"),
        ("covariance", "[10.5]"),
        ("fre_rms_mm", "11.5"),
        ("tip_mm", "12.5"),
        ("delay_ns", "13"),
        ("used", "14"),
        ("flags", "15"),
    ] {
        assert_eq!(read[name], value, "{name}");
    }
    let frame = proto::EmitterFrame {
        seq: 1,
        t_device_ns: 2,
        t_capture_ns: 3,
        t_publish_ns: 4,
        tool_emitter: vec![5],
        tool_mm: vec![6.5],
        reference_emitter: vec![7],
        reference_mm: vec![8.5],
    };
    let read = fields(EMITTER_FRAME, "trocar.EmitterFrame", &frame.encode_to_vec());
    assert_eq!([&read["tool_emitter"], &read["reference_mm"]], ["[5]", "[8.5]"]);
}

#[test]
fn a_frame_of_markers_is_read_by_the_schema() {
    let frame = proto::MarkerFrame {
        seq: 1,
        t_device_ns: 2,
        t_capture_ns: 3,
        t_publish_ns: 4,
        t_arrival_ns: 5,
        t_uncertain_ns: 6,
        clock: 7,
        device: b"d".to_vec(),
        marker: vec![9],
        status: vec![10],
        q: vec![11.5],
        t_mm: vec![12.5],
        error_mm: vec![13.5],
        age_ns: vec![-14],
    };
    let read = fields(MARKER_FRAME, "trocar.MarkerFrame", &frame.encode_to_vec());
    for (name, value) in [
        ("seq", "1"),
        ("t_device_ns", "2"),
        ("t_capture_ns", "3"),
        ("t_publish_ns", "4"),
        ("t_arrival_ns", "5"),
        ("t_uncertain_ns", "6"),
        ("clock", "7"),
        ("marker", "[9]"),
        ("status", "[10]"),
        ("q", "[11.5]"),
        ("t_mm", "[12.5]"),
        ("error_mm", "[13.5]"),
        ("age_ns", "[-14]"),
    ] {
        assert_eq!(read[name], value, "{name}");
    }
}

#[test]
fn a_state_of_a_process_is_read_by_the_schema() {
    let status = proto::ProcessStatus {
        t_ns: 1,
        process: "tracker".to_owned(),
        pid: 3,
        state: "ready".to_owned(),
        note: "note".to_owned(),
        published: 6,
        lost: 7,
        dropped: 8,
        refused: 9,
        recorded: 10,
    };
    let read = fields(PROCESS_STATUS, "trocar.ProcessStatus", &status.encode_to_vec());
    assert_eq!([&read["process"], &read["note"]], ["\"tracker\"", "\"note\""]);
    let counters = ["published", "lost", "dropped", "refused", "recorded"].map(|name| read[name].clone());
    assert_eq!(counters, ["6", "7", "8", "9", "10"]);
}

#[test]
fn an_identity_is_read_by_the_schema() {
    let identity = proto::Identity {
        t_ns: 1,
        volume_hash: vec![65],
        source: "scene".to_owned(),
        name: "4".to_owned(),
        patient_id: "5".to_owned(),
        birth_date: "6".to_owned(),
        study_date: "7".to_owned(),
        description: "8".to_owned(),
    };
    let read = fields(IDENTITY, "trocar.Identity", &identity.encode_to_vec());
    for (name, value) in [
        ("t_ns", "1"),
        ("volume_hash", "\"A\""),
        ("source", "\"scene\""),
        ("name", "\"4\""),
        ("patient_id", "\"5\""),
        ("birth_date", "\"6\""),
        ("study_date", "\"7\""),
        ("description", "\"8\""),
    ] {
        assert_eq!(read[name], value, "{name}");
    }
}

#[test]
fn what_a_person_chose_is_read_by_the_schema() {
    let guide = proto::Guide {
        t_ns: -1,
        plan_id: 2,
        held_seq: 3,
        held_capture_ns: -4,
        target_mm: vec![5.5],
        radius_mm: Some(6.5),
        entry_mm: vec![7.5],
        stop_mm: Some(8.5),
        flags: 9,
        name: vec![65],
        field_mm: Some(10.5),
        centre_hu: Some(11.5),
        width_hu: Some(12.5),
    };
    let read = fields(GUIDE, "trocar.Guide", &guide.encode_to_vec());
    for (name, value) in [
        ("t_ns", "-1"),
        ("plan_id", "2"),
        ("held_seq", "3"),
        ("held_capture_ns", "-4"),
        ("target_mm", "[5.5]"),
        ("radius_mm", "6.5"),
        ("entry_mm", "[7.5]"),
        ("stop_mm", "8.5"),
        ("flags", "9"),
        ("name", "\"A\""),
        ("field_mm", "10.5"),
        ("centre_hu", "11.5"),
        ("width_hu", "12.5"),
    ] {
        assert_eq!(read[name], value, "{name}");
    }
    let workflow = proto::Workflow {
        t_ns: -1,
        stage: 2,
        flags: 3,
        stage_word: "CONFIRMED".to_owned(),
    };
    let read = fields(WORKFLOW, "trocar.Workflow", &workflow.encode_to_vec());
    assert_eq!([&read["t_ns"], &read["stage"], &read["flags"]], ["-1", "2", "3"]);
}

#[test]
fn what_foxglove_draws_is_read_by_the_schema() {
    let timestamp = Some(prost_types::Timestamp { seconds: 1, nanos: 2 });
    let transform = proto::FrameTransform {
        timestamp,
        parent_frame_id: "ct".to_owned(),
        child_frame_id: "tool".to_owned(),
        translation: Some(proto::Vector3 { x: 1.5, y: 2.5, z: 3.5 }),
        rotation: Some(proto::Quaternion {
            x: 4.5,
            y: 5.5,
            z: 6.5,
            w: 7.5,
        }),
    };
    let read = fields(FRAME_TRANSFORM, "foxglove.FrameTransform", &transform.encode_to_vec());
    assert_eq!(read["child_frame_id"], "\"tool\"");
    assert_eq!(
        [&read["translation"], &read["rotation"]],
        ["{x:1.5,y:2.5,z:3.5}", "{x:4.5,y:5.5,z:6.5,w:7.5}"]
    );
    let log = proto::Log {
        timestamp,
        level: 3,
        message: "message".to_owned(),
        name: "name".to_owned(),
        file: "file".to_owned(),
        line: 6,
    };
    let read = fields(LOG, "foxglove.Log", &log.encode_to_vec());
    assert_eq!([&read["level"], &read["line"]], ["3", "6"]);
    let image = proto::CompressedImage {
        timestamp,
        data: vec![65],
        format: "png".to_owned(),
        frame_id: "axial".to_owned(),
    };
    let read = fields(COMPRESSED_IMAGE, "foxglove.CompressedImage", &image.encode_to_vec());
    assert_eq!([&read["data"], &read["frame_id"]], ["\"A\"", "\"axial\""]);
}

#[test]
fn an_ultrasound_image_is_read_by_the_schema() {
    let image = proto::RawImage {
        timestamp: Some(prost_types::Timestamp { seconds: 1, nanos: 2 }),
        width: 2,
        height: 3,
        encoding: "mono8".to_owned(),
        step: 5,
        data: vec![65],
        frame_id: "7".to_owned(),
        seq: 100,
        t_device_ns: -101,
        t_capture_ns: 102,
        t_arrival_ns: 103,
        t_publish_ns: 104,
        pixel_mm: vec![105.5],
        depth_mm: 106.5,
        beams: vec![107.5],
        array: 108,
        clock: 109,
        device: vec![66],
        orientation: "MF".to_owned(),
    };
    let read = fields(RAW_IMAGE, "foxglove.RawImage", &image.encode_to_vec());
    for (name, value) in [
        ("width", "2"),
        ("height", "3"),
        ("encoding", "\"mono8\""),
        ("step", "5"),
        ("data", "\"A\""),
        ("frame_id", "\"7\""),
        ("seq", "100"),
        ("t_device_ns", "-101"),
        ("t_capture_ns", "102"),
        ("t_arrival_ns", "103"),
        ("t_publish_ns", "104"),
        ("pixel_mm", "[105.5]"),
        ("depth_mm", "106.5"),
        ("beams", "[107.5]"),
        ("array", "108"),
        ("clock", "109"),
        ("device", "\"B\""),
        ("orientation", "\"MF\""),
    ] {
        assert_eq!(read[name], value, "{name}");
    }
}
