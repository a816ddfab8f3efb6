//! The schemas of the file as protobuf descriptors, built here so that no `protoc` is needed to build this crate.
//!
//! An MCAP schema of encoding `protobuf` is a binary `FileDescriptorSet` with every imported file in it.

use prost::Message as _;
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{
    DescriptorProto, FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet, OneofDescriptorProto,
};

const TIMESTAMP: &str = "google/protobuf/timestamp.proto";
const VECTOR3: &str = "foxglove/Vector3.proto";
const QUATERNION: &str = "foxglove/Quaternion.proto";

/// The schema of [`crate::proto::ToolPose`].
pub fn tool_pose() -> Vec<u8> {
    let mut message = message(
        "ToolPose",
        vec![
            scalar("seq", 1, Type::Uint64),
            scalar("t_device_ns", 2, Type::Sint64),
            scalar("t_capture_ns", 3, Type::Sint64),
            scalar("t_publish_ns", 4, Type::Sint64),
            scalar("registration_id", 5, Type::Fixed64),
            scalar("status", 6, Type::Uint32),
            scalar("visible", 7, Type::Uint32),
            repeated("q", 8, Type::Double),
            repeated("t_mm", 9, Type::Double),
            repeated("covariance", 10, Type::Double),
            scalar("fre_rms_mm", 11, Type::Double),
            scalar("tip_mm", 12, Type::Double),
            scalar("delay_ns", 13, Type::Sint64),
            scalar("used", 14, Type::Uint32),
            scalar("flags", 15, Type::Uint32),
        ],
    );
    make_optional(&mut message, "fre_rms_mm");
    make_optional(&mut message, "tip_mm");
    set(vec![file("trocar/ToolPose.proto", "trocar", &[], message)])
}

/// The schema of [`crate::proto::FrameTransform`], with the field numbers that Foxglove publishes.
pub fn frame_transform() -> Vec<u8> {
    let xyz = || ["x", "y", "z"].into_iter().zip(1..);
    let doubles = |names: &mut dyn Iterator<Item = (&'static str, i32)>| {
        names.map(|(name, number)| scalar(name, number, Type::Double)).collect()
    };
    let transform = message(
        "FrameTransform",
        vec![
            nested("timestamp", 1, ".google.protobuf.Timestamp"),
            scalar("parent_frame_id", 2, Type::String),
            scalar("child_frame_id", 3, Type::String),
            nested("translation", 4, ".foxglove.Vector3"),
            nested("rotation", 5, ".foxglove.Quaternion"),
        ],
    );
    let timestamp = message(
        "Timestamp",
        vec![scalar("seconds", 1, Type::Int64), scalar("nanos", 2, Type::Int32)],
    );
    let vector = message("Vector3", doubles(&mut xyz()));
    let quaternion = message("Quaternion", doubles(&mut xyz().chain([("w", 4)])));
    // Imported files come before those that import them: the Python reader adds them in this order.
    set(vec![
        file(TIMESTAMP, "google.protobuf", &[], timestamp),
        file(VECTOR3, "foxglove", &[], vector),
        file(QUATERNION, "foxglove", &[], quaternion),
        file(
            "foxglove/FrameTransform.proto",
            "foxglove",
            &[TIMESTAMP, VECTOR3, QUATERNION],
            transform,
        ),
    ])
}

fn set(file: Vec<FileDescriptorProto>) -> Vec<u8> {
    FileDescriptorSet { file }.encode_to_vec()
}

fn file(name: &str, package: &str, imports: &[&str], message: DescriptorProto) -> FileDescriptorProto {
    FileDescriptorProto {
        name: Some(name.to_owned()),
        package: Some(package.to_owned()),
        dependency: imports.iter().map(|&import| import.to_owned()).collect(),
        message_type: vec![message],
        syntax: Some("proto3".to_owned()),
        ..Default::default()
    }
}

fn message(name: &str, field: Vec<FieldDescriptorProto>) -> DescriptorProto {
    DescriptorProto {
        name: Some(name.to_owned()),
        field,
        ..Default::default()
    }
}

fn scalar(name: &str, number: i32, kind: Type) -> FieldDescriptorProto {
    FieldDescriptorProto {
        name: Some(name.to_owned()),
        number: Some(number),
        label: Some(Label::Optional.into()),
        r#type: Some(kind.into()),
        ..Default::default()
    }
}

fn repeated(name: &str, number: i32, kind: Type) -> FieldDescriptorProto {
    FieldDescriptorProto {
        label: Some(Label::Repeated.into()),
        ..scalar(name, number, kind)
    }
}

fn nested(name: &str, number: i32, type_name: &str) -> FieldDescriptorProto {
    FieldDescriptorProto {
        type_name: Some(type_name.to_owned()),
        ..scalar(name, number, Type::Message)
    }
}

/// Marks a field as `optional` in the sense of proto3: a field alone in a "synthetic" oneof.
fn make_optional(message: &mut DescriptorProto, name: &str) {
    let Some(field) = message.field.iter_mut().find(|field| field.name() == name) else {
        return;
    };
    field.proto3_optional = Some(true);
    // A handful of fields.
    field.oneof_index = Some(message.oneof_decl.len() as i32);
    message.oneof_decl.push(OneofDescriptorProto {
        name: Some(format!("_{name}")),
        ..Default::default()
    });
}

#[cfg(test)]
mod tests {
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
}
