"""Looks at a run as Foxglove does, by software that Trocar does not use.

Usage: check_foxglove.py PORT SECONDS
Needs: websockets, foxglove-schemas-protobuf, mcap-protobuf-support. Prints one JSON object: the server's name, how many messages came on
each topic, the largest distance between the end of the tool in the scene and the transform of the same moment in mm (null: never both),
the ids of the last scene, what was taken away, the last notice, the frame that the tool hung on last, the sizes of the images, and what the
log said.
"""

import base64
import json
import struct
import sys
import time

from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.Log_pb2 import Log
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from websockets.sync.client import connect


def size_of_png(data):
    assert data[:8] == b"\x89PNG\r\n\x1a\n", data[:8]
    return struct.unpack(">II", data[16:24])


def main(port, seconds):
    found = {"topics": {}, "off_mm": None, "images": {}, "log": [], "deleted": []}
    channels, transforms, tools = {}, [], []
    with connect(f"ws://127.0.0.1:{port}", subprotocols=["foxglove.sdk.v1"], max_size=1 << 24) as socket:
        until = time.monotonic() + float(seconds)
        while (left := until - time.monotonic()) > 0:
            try:
                message = socket.recv(timeout=left)
            except TimeoutError:
                break
            if isinstance(message, str):
                said = json.loads(message)
                if said["op"] == "serverInfo":
                    found["name"] = said["name"]
                if said["op"] == "advertise":
                    for channel in said["channels"]:
                        channels[channel["id"]] = channel
                        assert base64.b64decode(channel["schema"]), channel["topic"]
                        found["topics"].setdefault(channel["topic"], 0)
                    subscriptions = [{"id": channel["id"], "channelId": channel["id"]} for channel in said["channels"]]
                    socket.send(json.dumps({"op": "subscribe", "subscriptions": subscriptions}))
                continue
            opcode, channel, _ = struct.unpack("<BIQ", message[:13])
            if opcode != 1:
                continue
            channel, payload = channels[channel], message[13:]
            found["topics"][channel["topic"]] += 1
            take(found, transforms, tools, channel, payload)
    # The tool's end was where one of the transforms put it; the first scenes may show poses of before the subscription.
    tools = tools[5:]
    off = [min(sum((a - b) ** 2 for a, b in zip(tool, at)) ** 0.5 for at in transforms) for tool in tools if transforms]
    if off:
        found["off_mm"] = 1000 * max(off)
    print(json.dumps(found))


def take(found, transforms, tools, channel, payload):
    kind = channel["schemaName"]
    if kind == "foxglove.FrameTransform":
        transform = FrameTransform.FromString(payload)
        found["hangs_on"] = transform.parent_frame_id
        if transform.parent_frame_id == "ct":
            at = transform.translation
            transforms.append((at.x, at.y, at.z))
    elif kind == "foxglove.SceneUpdate":
        update = SceneUpdate.FromString(payload)
        found["scene"] = [entity.id for entity in update.entities]
        found["deleted"] = [deletion.id for deletion in update.deletions]
        for entity in update.entities:
            assert entity.frame_id == "ct", entity.frame_id
            if entity.id == "tool":
                end = entity.lines[0].points[0]
                tools.append((end.x, end.y, end.z))
            if entity.id == "targets":
                found["targets"] = {
                    text.text: [1000 * getattr(sphere.pose.position, axis) for axis in "xyz"]
                    for text, sphere in zip(entity.texts, entity.spheres)
                }
            if entity.id == "notice":
                found["notice"] = entity.texts[0].text
    elif kind == "foxglove.CompressedImage":
        image = CompressedImage.FromString(payload)
        found["images"][channel["topic"]] = size_of_png(image.data)
    elif kind == "foxglove.Log":
        found["log"].append(Log.FromString(payload).message)


if __name__ == "__main__":
    main(*sys.argv[1:])
