//! The schemas of the file as protobuf descriptors, built here so that no `protoc` is needed to build this crate.
//!
//! An MCAP schema of encoding `protobuf` is a binary `FileDescriptorSet` with every imported file in it.

use prost::Message as _;
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{
    DescriptorProto, EnumDescriptorProto, EnumValueDescriptorProto, FieldDescriptorProto, FileDescriptorProto,
    FileDescriptorSet, OneofDescriptorProto,
};

const TIMESTAMP: &str = "google/protobuf/timestamp.proto";
const VECTOR3: &str = "foxglove/Vector3.proto";
const QUATERNION: &str = "foxglove/Quaternion.proto";

/// The schema of [`crate::wire::proto::ToolPose`].
pub(crate) fn tool_pose() -> Vec<u8> {
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

/// The schema of [`crate::wire::proto::FrameTransform`], with the field numbers that Foxglove publishes.
pub(crate) fn frame_transform() -> Vec<u8> {
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
    let vector = message("Vector3", doubles(&mut xyz()));
    let quaternion = message("Quaternion", doubles(&mut xyz().chain([("w", 4)])));
    // Imported files come before those that import them: the Python reader adds them in this order.
    set(vec![
        timestamp_file(),
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

/// The schema of [`crate::wire::proto::EmitterFrame`].
pub(crate) fn emitter_frame() -> Vec<u8> {
    let message = message(
        "EmitterFrame",
        vec![
            scalar("seq", 1, Type::Uint64),
            scalar("t_device_ns", 2, Type::Sint64),
            scalar("t_capture_ns", 3, Type::Sint64),
            scalar("t_publish_ns", 4, Type::Sint64),
            repeated("tool_emitter", 5, Type::Uint32),
            repeated("tool_mm", 6, Type::Double),
            repeated("reference_emitter", 7, Type::Uint32),
            repeated("reference_mm", 8, Type::Double),
        ],
    );
    set(vec![file("trocar/EmitterFrame.proto", "trocar", &[], message)])
}

/// The schema of [`crate::wire::proto::ProcessStatus`].
pub(crate) fn process_status() -> Vec<u8> {
    let mut fields = vec![
        scalar("t_ns", 1, Type::Sint64),
        scalar("process", 2, Type::String),
        scalar("pid", 3, Type::Uint32),
        scalar("state", 4, Type::String),
        scalar("note", 5, Type::String),
    ];
    let counters = ["published", "lost", "dropped", "refused", "recorded"];
    fields.extend(
        counters
            .into_iter()
            .zip(6..)
            .map(|(name, number)| scalar(name, number, Type::Uint64)),
    );
    let message = message("ProcessStatus", fields);
    set(vec![file("trocar/ProcessStatus.proto", "trocar", &[], message)])
}

/// The schema of [`crate::wire::proto::Log`], with the field numbers that Foxglove publishes.
pub(crate) fn log() -> Vec<u8> {
    let mut log = message(
        "Log",
        vec![
            nested("timestamp", 1, ".google.protobuf.Timestamp"),
            FieldDescriptorProto {
                type_name: Some(".foxglove.Log.Level".to_owned()),
                ..scalar("level", 2, Type::Enum)
            },
            scalar("message", 3, Type::String),
            scalar("name", 4, Type::String),
            scalar("file", 5, Type::String),
            scalar("line", 6, Type::Fixed32),
        ],
    );
    let levels = ["UNKNOWN", "DEBUG", "INFO", "WARNING", "ERROR", "FATAL"];
    let value = |(name, number): (&str, i32)| EnumValueDescriptorProto {
        name: Some(name.to_owned()),
        number: Some(number),
        ..Default::default()
    };
    log.enum_type.push(EnumDescriptorProto {
        name: Some("Level".to_owned()),
        value: levels.into_iter().zip(0..).map(value).collect(),
        ..Default::default()
    });
    set(vec![
        timestamp_file(),
        file("foxglove/Log.proto", "foxglove", &[TIMESTAMP], log),
    ])
}

/// The schema of [`crate::wire::proto::CompressedImage`], with the field numbers that Foxglove publishes.
pub(crate) fn compressed_image() -> Vec<u8> {
    let image = message(
        "CompressedImage",
        vec![
            nested("timestamp", 1, ".google.protobuf.Timestamp"),
            scalar("frame_id", 4, Type::String),
            scalar("data", 2, Type::Bytes),
            scalar("format", 3, Type::String),
        ],
    );
    let file = file("foxglove/CompressedImage.proto", "foxglove", &[TIMESTAMP], image);
    set(vec![timestamp_file(), file])
}

fn timestamp_file() -> FileDescriptorProto {
    let fields = vec![scalar("seconds", 1, Type::Int64), scalar("nanos", 2, Type::Int32)];
    file(TIMESTAMP, "google.protobuf", &[], message("Timestamp", fields))
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
mod tests;
