"""Reads a recording with the public Python readers and prints what they see, as one JSON object.

Usage: python check_mcap.py FILE.mcap        (needs: pip install mcap mcap-protobuf-support)

Every CRC is checked. Doubles are printed as their 64 bits in hexadecimal, so that nothing is rounded on the way.
Exit code 1, with the reader's words on stderr, where the file cannot be read.
"""

import json
import struct
import sys
from collections import Counter

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


SHOW = {
    "trocar.ToolPose": pose,
    "trocar.EmitterFrame": emitters,
    "trocar.ProcessStatus": status,
    "foxglove.FrameTransform": transform,
    "foxglove.Log": log,
    "foxglove.CompressedImage": image,
}


def check(path: str) -> dict:
    counts, schemas, first = Counter(), {}, {}
    with open(path, "rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        for schema, channel, record, message in reader.iter_decoded_messages(log_time_order=False):
            counts[channel.topic] += 1
            schemas[channel.topic] = schema.name
            if channel.topic not in first:
                show = SHOW[schema.name](message)
                first[channel.topic] = {"log_time": record.log_time, "sequence": record.sequence} | show
        statistics = reader.get_summary().statistics
        return {
            "counts": counts,
            "schemas": schemas,
            "first": first,
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
