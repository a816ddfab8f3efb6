"""Looks at a run as Foxglove does, by software that Trocar does not use.

Usage: check_foxglove.py PORT SECONDS
Needs: websockets, foxglove-schemas-protobuf, mcap-protobuf-support. Prints one JSON object: the server's name, how many messages came on
each topic, the largest distance between the end of the tool in a scene and the numbers and the transform of the same pose in mm (null: none
came together),
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
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from websockets.sync.client import connect


def size_of_png(data):
    assert data[:8] == b"\x89PNG\r\n\x1a\n", data[:8]
    return struct.unpack(">II", data[16:24])


def message_class(channel):
    """The class that the schema describes which the server gives with a channel."""
    pool = descriptor_pool.DescriptorPool()
    for file in descriptor_pb2.FileDescriptorSet.FromString(base64.b64decode(channel["schema"])).file:
        pool.Add(file)
    return message_factory.GetMessageClass(pool.FindMessageTypeByName(channel["schemaName"]))


def main(port, seconds):
    found = {"topics": {}, "off_mm": None, "images": {}, "log": [], "deleted": []}
    channels, transforms, poses, tools = {}, {}, {}, {}
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
            take(found, (transforms, poses, tools), channel, payload)
    # By the number of the pose: any message may be lost to a client that is slow.
    for seq, tool in tools.items():
        if seq in poses and (at := transforms.get(poses[seq][0])):
            for place in (at, poses[seq][1]):
                off = sum((1000 * a - b) ** 2 for a, b in zip(tool, place)) ** 0.5
                found["off_mm"] = max(off, found["off_mm"] or 0.0)
    print(json.dumps(found))


def take(found, known, channel, payload):
    transforms, poses, tools = known
    kind = channel["schemaName"]
    if kind == "foxglove.FrameTransform":
        transform = FrameTransform.FromString(payload)
        found["hangs_on"] = transform.parent_frame_id
        if transform.parent_frame_id == "ct":
            at, t = transform.translation, transform.timestamp
            transforms[t.seconds * 10**9 + t.nanos] = [1000 * at.x, 1000 * at.y, 1000 * at.z]
    elif kind == "trocar.ToolPose":
        channel["class"] = channel.get("class") or message_class(channel)
        pose = channel["class"].FromString(payload)
        poses[pose.seq] = (pose.t_capture_ns, list(pose.t_mm))
    elif kind == "foxglove.SceneUpdate":
        update = SceneUpdate.FromString(payload)
        found["scene"] = [entity.id for entity in update.entities]
        found["deleted"] = [deletion.id for deletion in update.deletions]
        ends = [entity.lines[0].points[0] for entity in update.entities if entity.id == "tool"]
        for entity in update.entities:
            assert entity.frame_id == "ct", entity.frame_id
            if entity.id == "targets":
                found["targets"] = {
                    text.text: [1000 * getattr(sphere.pose.position, axis) for axis in "xyz"]
                    for text, sphere in zip(entity.texts, entity.spheres)
                }
            if entity.id == "notice":
                found["notice"] = entity.texts[0].text
                for end in ends:
                    tools[int(found["notice"].rsplit("pose ", 1)[1])] = (end.x, end.y, end.z)
    elif kind == "foxglove.CompressedImage":
        image = CompressedImage.FromString(payload)
        found["images"][channel["topic"]] = size_of_png(image.data)
    elif kind == "foxglove.Log":
        found["log"].append(Log.FromString(payload).message)


if __name__ == "__main__":
    main(*sys.argv[1:])
