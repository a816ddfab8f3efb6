"""Reads a recording with the public Python readers and prints what they see, as one JSON object.

Usage: python check_mcap.py FILE.mcap        (needs: pip install mcap mcap-protobuf-support foxglove-schemas-protobuf)

Every CRC is checked. Doubles are printed as their 64 bits in hexadecimal, so that nothing is rounded on the way.
What carries a name of Foxglove's is held against the schemas that Foxglove publishes, and read with them.
Exit code 1, with the reader's words on stderr, where the file cannot be read.
"""

import importlib
import json
import struct
import sys
from collections import Counter

from google.protobuf import descriptor_pb2
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory


def bits(value: float) -> str:
    return struct.pack(">d", value).hex()


def pose(message) -> dict:
    whole = ("seq", "t_device_ns", "t_capture_ns", "t_publish_ns", "registration_id", "status", "visible")
    fields = {name: getattr(message, name) for name in whole}
    for name in ("q", "t_mm", "covariance"):
        fields[name] = [bits(value) for value in getattr(message, name)]
    fields["fre_rms_mm"] = bits(message.fre_rms_mm)
    fields["tip_mm"] = bits(message.tip_mm)
    return fields


def transform(message) -> dict:
    move, turn = message.translation, message.rotation
    return {
        "parent": message.parent_frame_id,
        "child": message.child_frame_id,
        "t_ns": message.timestamp.seconds * 1_000_000_000 + message.timestamp.nanos,
        "t_metres": [bits(value) for value in (move.x, move.y, move.z)],
        "q_xyzw": [bits(value) for value in (turn.x, turn.y, turn.z, turn.w)],
    }


def emitters(message) -> dict:
    whole = ("seq", "t_device_ns", "t_capture_ns", "t_publish_ns")
    fields = {name: getattr(message, name) for name in whole}
    for name in ("tool_emitter", "reference_emitter"):
        fields[name] = list(getattr(message, name))
    for name in ("tool_mm", "reference_mm"):
        fields[name] = [bits(value) for value in getattr(message, name)]
    return fields


def status(message) -> dict:
    return {name: getattr(message, name) for name in ("t_ns", "process", "pid", "state", "note", "recorded")}


def log(message) -> dict:
    return {name: getattr(message, name) for name in ("level", "message", "name")}


def image(message) -> dict:
    return {"frame_id": message.frame_id, "format": message.format, "head": message.data[:8].hex()}


def every_field(message) -> dict:
    def shown(value):
        if isinstance(value, float):
            return bits(value)
        return value.hex() if isinstance(value, bytes) else value

    def one(value):
        return shown(value) if isinstance(value, (float, bytes, int, str, bool)) else [shown(each) for each in value]

    return {field.name: one(getattr(message, field.name)) for field in message.DESCRIPTOR.fields}


SHOW = {
    "trocar.ToolPose": pose,
    "trocar.EmitterFrame": emitters,
    "trocar.ProcessStatus": status,
    "trocar.Guide": every_field,
    "trocar.Workflow": every_field,
    "trocar.Identity": every_field,
    "foxglove.FrameTransform": transform,
    "foxglove.Log": log,
    "foxglove.CompressedImage": image,
}


def published(name: str):
    """The message of this name as Foxglove publishes it; None for another's."""
    package, _, message = name.rpartition(".")
    if package != "foxglove":
        return None
    return getattr(importlib.import_module(f"foxglove_schemas_protobuf.{message}_pb2"), message)


def fields(message) -> list:
    enums = [[(value.name, value.number) for value in enum.value] for enum in message.enum_type]
    return sorted([f.name, f.number, f.type, f.label, f.type_name] for f in message.field) + enums


def same_as_published(schema) -> bool:
    """Whether every message of Foxglove's in a schema has the fields that Foxglove publishes."""
    files = descriptor_pb2.FileDescriptorSet.FromString(schema.data).file
    ours = {f"{file.package}.{message.name}": message for file in files for message in file.message_type}
    ours = {name: message for name, message in ours.items() if name.startswith("foxglove.")}

    def theirs(name: str):
        message = descriptor_pb2.DescriptorProto()
        published(name).DESCRIPTOR.CopyToProto(message)
        return message

    return schema.name in ours and all(fields(message) == fields(theirs(name)) for name, message in ours.items())


def check(path: str) -> dict:
    counts, schemas, first, foxglove = Counter(), {}, {}, {}
    with open(path, "rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        for schema, channel, record, message in reader.iter_decoded_messages(log_time_order=False):
            counts[channel.topic] += 1
            schemas[channel.topic] = schema.name
            if published(schema.name):
                # Read with Foxglove's own message, nothing is left over.
                again = published(schema.name).FromString(record.data)
                again.DiscardUnknownFields()
                foxglove.setdefault(schema.name, same_as_published(schema))
                foxglove[schema.name] &= again.ByteSize() == len(record.data)
            if channel.topic not in first:
                show = SHOW[schema.name](message)
                first[channel.topic] = {"log_time": record.log_time, "sequence": record.sequence} | show
        statistics = reader.get_summary().statistics
        return {
            "counts": counts,
            "schemas": schemas,
            "first": first,
            "foxglove": foxglove,
            "statistics": {"messages": statistics.message_count, "chunks": statistics.chunk_count},
            "attachments": {a.name: a.data.decode() for a in reader.iter_attachments()},
            "metadata": [{"record": m.name, "facts": m.metadata} for m in reader.iter_metadata()],
        }


def main() -> int:
    try:
        print(json.dumps(check(sys.argv[1])))
    except Exception as error:  # the readers raise many kinds; all mean that the file cannot be read
        print(f"{type(error).__name__}: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
