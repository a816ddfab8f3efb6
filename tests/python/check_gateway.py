"""Reads what gateway-proc sends with pyigtl, a client that is not of this project.

Usage: python check_gateway.py HOST PORT poses COUNT
       python check_gateway.py HOST PORT two COUNT
       python check_gateway.py HOST PORT each COUNT
       python check_gateway.py HOST PORT image DEVICE PLACES.json

(needs: pip install pyigtl SimpleITK numpy)

`poses` prints COUNT transforms as pyigtl takes them, the server speaking version 1. `two` speaks version 2 first and prints metadata
too; `each` prints them as they come, a line each. `image` asks for an image, hands it to SimpleITK in LPS, and prints the values of the voxels nearest to the places of the file (LPS
mm), its size, spacing and direction. What is printed is JSON. pyigtl checks no CRC: the C++ client of the tests does.
"""

import json
import socket
import sys
import time

import numpy as np
import pyigtl
from pyigtl.messages import MessageBase


def bare(kind: str, device: str = "", version: int = 1) -> bytes:
    message = MessageBase(device_name=device)
    message._message_type = kind
    message.header_version = version
    return message.pack()


def receive(stream: socket.socket):
    """The next message, through pyigtl's own parser; `None` for types that it does not know."""

    def exactly(count: int) -> bytes:
        parts = bytearray()
        while len(parts) < count:
            part = stream.recv(min(count - len(parts), 1 << 20))
            if not part:
                raise SystemExit("the server closed the connection")
            parts += part
        return bytes(parts)

    fields = MessageBase.parse_header(exactly(MessageBase.IGTL_HEADER_SIZE))
    body = exactly(fields["body_size"])
    message = MessageBase.create_message(fields["message_type"])
    if message is not None:
        message.unpack(fields, body)
    return fields, message


def poses(host: str, port: int, count: int) -> list:
    """pyigtl's own client, as a user has it."""
    client = pyigtl.OpenIGTLinkClient(host, port)
    found = []
    while len(found) < count:
        message = client.wait_for_message("ToolToRas", timeout=20)
        if message is None:
            raise SystemExit("no ToolToRas within 20 s")
        found.append({"matrix": message.matrix.tolist(), "stamp": message.timestamp, "version": message.header_version})
    client.stop()
    return found


def two(host: str, port: int, count: int, is_told_at_once: bool = False) -> list:
    stream = socket.create_connection((host, port), timeout=20)
    stream.sendall(bare("GET_STATUS", version=2))
    found = []
    while len(found) < count:
        fields, message = receive(stream)
        if fields["header_version"] == 2 and fields["message_type"] == "TRANSFORM":
            found.append({
                "device": fields["device_name"],
                "matrix": message.matrix.tolist(),
                "metadata": message.metadata,
                "now": time.time(),
                "stamp": fields["timestamp"],
            })
            if is_told_at_once:
                print(json.dumps(found[-1]), flush=True)
    return found


def image(host: str, port: int, device: str, places: list) -> dict:
    import SimpleITK as sitk

    stream = socket.create_connection((host, port), timeout=60)
    stream.sendall(bare("GET_IMAGE", device))
    while True:
        fields, message = receive(stream)
        if fields["message_type"] == "IMAGE" and fields["device_name"] == device:
            break
    assert message.world_coordinate_system == "ras", message.world_coordinate_system
    lps = np.diag([-1.0, -1.0, 1.0, 1.0]) @ message.ijk_to_world_matrix
    spacing = np.linalg.norm(lps[:3, :3], axis=0)
    picture = sitk.GetImageFromArray(message.image, isVector=message.image.ndim == 4)
    picture.SetSpacing(spacing.tolist())
    picture.SetOrigin(lps[:3, 3].tolist())
    picture.SetDirection((lps[:3, :3] / spacing).ravel().tolist())
    values = []
    for place in places:
        index = picture.TransformPhysicalPointToIndex(place)
        values.append(picture.GetPixel(index))
    return {
        "size": picture.GetSize(),
        "spacing": picture.GetSpacing(),
        "direction": picture.GetDirection(),
        "determinant": float(np.linalg.det(lps[:3, :3] / spacing)),
        "values": values,
    }


def main() -> None:
    host, port, mode = sys.argv[1], int(sys.argv[2]), sys.argv[3]
    if mode == "poses":
        print(json.dumps(poses(host, port, int(sys.argv[4]))))
    elif mode == "each":
        two(host, port, int(sys.argv[4]), is_told_at_once=True)
    elif mode == "two":
        print(json.dumps(two(host, port, int(sys.argv[4]))))
    elif mode == "image":
        with open(sys.argv[5], encoding="utf8") as file:
            print(json.dumps(image(host, port, sys.argv[4], json.load(file))))
    else:
        raise SystemExit(__doc__)


main()
