"""A client of NDI's combined API of other software (ndicapi): what it reads of two tools, a line of JSON for each reply.

    python ndi_client.py PORT COUNT TOOL.rom PATIENT.rom

Each line has the way of polling, the number of the frame, and for each tool its eight numbers (w x y z, x y z in mm, error in mm) or the
word of a tool that is not seen. The last tool is loaded twice; a device that knows two markers never sees the third tool.
"""

import json
import sys
import time

try:
    import ndicapy
except ImportError:
    print("no ndicapi")
    sys.exit(0)


def main():
    port, count, files = int(sys.argv[1]), int(sys.argv[2]), sys.argv[3:]
    device = ndicapy.ndiOpenNetwork("127.0.0.1", port)

    def command(text):
        reply = ndicapy.ndiCommand(device, text)
        if ndicapy.ndiGetError(device) != ndicapy.NDI_OKAY:
            sys.exit(f"{text}: {ndicapy.ndiErrorString(ndicapy.ndiGetError(device))}")
        return reply

    command("INIT:")
    handles = []
    for file in files + files[-1:]:
        command("PHRQ:*********1****")
        handle = ndicapy.ndiGetPHRQHandle(device)
        if ndicapy.ndiPVWRFromFile(device, handle, file) != ndicapy.NDI_OKAY:
            sys.exit(f"{file} is refused")
        command(f"PINIT:{handle:02X}")
        command(f"PENA:{handle:02X}D")
        handles.append(bytes([handle]))
    command("TSTART:")
    ways = {
        "BX": (ndicapy.ndiGetBXFrame, ndicapy.ndiGetBXTransform),
        "TX": (ndicapy.ndiGetTXFrame, ndicapy.ndiGetTXTransform),
    }
    for _ in range(count):
        time.sleep(0.01)
        for way, (frame, transform) in ways.items():
            command(f"{way}:0801")
            tools = [transform(device, handle) for handle in handles]
            print(json.dumps({"way": way, "frame": frame(device, handles[0]), "tools": tools}), flush=True)
    command("TSTOP:")
    ndicapy.ndiCloseNetwork(device)


main()
