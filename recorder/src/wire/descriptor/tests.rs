use super::*;

/// File names in order, and the fields of the last file's message by name and number.
fn parsed(schema: &[u8]) -> (Vec<String>, Vec<(String, i32)>) {
    let set = FileDescriptorSet::decode(schema).unwrap();
    let last = &set.file.last().unwrap().message_type[0];
    let fields = last.field.iter().map(|f| (f.name().to_owned(), f.number())).collect();
    (set.file.iter().map(|f| f.name().to_owned()).collect(), fields)
}

fn numbered(names: &[&str]) -> Vec<(String, i32)> {
    names.iter().map(|&name| name.to_owned()).zip(1..).collect()
}

#[test]
fn foxglove_field_numbers_and_imports() {
    let (files, fields) = parsed(&frame_transform());
    assert_eq!(files.len(), 4);
    assert_eq!(files[0], TIMESTAMP);
    let names = [
        "timestamp",
        "parent_frame_id",
        "child_frame_id",
        "translation",
        "rotation",
    ];
    assert_eq!(fields, numbered(&names));
    let set = FileDescriptorSet::decode(&frame_transform()[..]).unwrap();
    for (index, file) in set.file.iter().enumerate() {
        assert!(file.dependency.iter().all(|import| files[..index].contains(import)));
    }
}

#[test]
fn the_pose_schema_numbers_the_fields_as_the_struct_does() {
    let (files, fields) = parsed(&tool_pose());
    assert_eq!(files, ["trocar/ToolPose.proto"]);
    // The order of bus::message::ToolPose.
    let names = [
        "seq",
        "t_device_ns",
        "t_capture_ns",
        "t_publish_ns",
        "registration_id",
        "status",
        "visible",
        "q",
        "t_mm",
        "covariance",
        "fre_rms_mm",
        "tip_mm",
        "delay_ns",
        "used",
        "flags",
    ];
    assert_eq!(fields, numbered(&names));
}

#[test]
fn only_the_errors_are_optional() {
    let set = FileDescriptorSet::decode(&tool_pose()[..]).unwrap();
    let message = &set.file[0].message_type[0];
    let optional: Vec<_> = message
        .field
        .iter()
        .filter(|f| f.proto3_optional())
        .map(|f| f.name())
        .collect();
    assert_eq!(optional, ["fre_rms_mm", "tip_mm"]);
    assert_eq!(message.oneof_decl[0].name(), "_fre_rms_mm");
    assert_eq!(message.oneof_decl[1].name(), "_tip_mm");
}

#[test]
fn the_emitters_schema_numbers_the_fields_in_order() {
    let (files, fields) = parsed(&emitter_frame());
    assert_eq!(files, ["trocar/EmitterFrame.proto"]);
    let names = [
        "seq",
        "t_device_ns",
        "t_capture_ns",
        "t_publish_ns",
        "tool_emitter",
        "tool_mm",
        "reference_emitter",
        "reference_mm",
    ];
    assert_eq!(fields, numbered(&names));
}

#[test]
fn logs_and_images_are_foxgloves() {
    let (_, fields) = parsed(&log());
    assert_eq!(
        fields,
        numbered(&["timestamp", "level", "message", "name", "file", "line"])
    );
    let (_, mut fields) = parsed(&compressed_image());
    fields.sort_by_key(|(_, number)| *number);
    assert_eq!(fields, numbered(&["timestamp", "data", "format", "frame_id"]));
    let set = FileDescriptorSet::decode(&log()[..]).unwrap();
    // As Foxglove has it, where the others are as one would guess.
    let line = &set.file[1].message_type[0].field[5];
    assert_eq!((line.name(), line.r#type()), ("line", Type::Fixed32));
    let levels = &set.file[1].message_type[0].enum_type[0];
    let levels: Vec<_> = levels
        .value
        .iter()
        .map(|value| (value.name(), value.number()))
        .collect();
    assert_eq!(levels[2..5], [("INFO", 2), ("WARNING", 3), ("ERROR", 4)]);
}

#[test]
fn the_status_schema_numbers_the_fields_in_order() {
    let names = [
        "t_ns",
        "process",
        "pid",
        "state",
        "note",
        "published",
        "lost",
        "dropped",
        "refused",
        "recorded",
    ];
    assert_eq!(parsed(&process_status()).1, numbered(&names));
}
