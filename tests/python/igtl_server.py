"""An OpenIGTLink server of other software (pyigtl): a tool that moves along x and a patient that rests, with noise.

    python igtl_server.py PORT VERSION

Frame i has the tool at x = i / 8 mm and the patient at x = -100 mm, both with a tremor along y that no two frames share. In version 2
every fifth frame says MISSING of the tool; in version 1 nothing says anything. It sends until it is killed, to whoever connects.
"""

import sys
import time

import numpy
import pyigtl


def transform(name, x, y, stamp, version, status):
    matrix = numpy.eye(4)
    matrix[:3, 3] = [x, y, -1500.0]
    message = pyigtl.TransformMessage(matrix, device_name=name, timestamp=stamp)
    message.header_version = version
    if version == 2:
        message.metadata = {"TransformStatus": status}
    return message


def main():
    port, version = int(sys.argv[1]), int(sys.argv[2])
    server = pyigtl.OpenIGTLinkServer(port=port, local_server=True)
    print("listening", flush=True)
    frame = 0
    while True:
        if not server.is_connected():
            time.sleep(0.005)
            continue
        # Distinct in every frame, and exact in single precision.
        tremor = (frame % 4096) / 1024.0
        stamp = time.time()
        status = "MISSING" if frame % 5 == 4 else "OK"
        for name, x, said in (("ReferenceToTracker", -100.0, "OK"), ("StylusToTracker", frame / 8.0, status)):
            server.send_message(transform(name, x, tremor, stamp, version, said), wait=False)
        frame += 1
        time.sleep(0.01)


main()
