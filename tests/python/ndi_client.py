"""A client of NDI's combined API of other software (ndicapi): what it reads of two tools, a line of JSON for each reply.

    python ndi_client.py PORT COUNT TOOL.rom PATIENT.rom          # BX and TX in turn
    python ndi_client.py PORT COUNT TOOL.rom PATIENT.rom --bx2    # BX2 with the places of single markers

Each line has the way of polling, the number of the frame, and for each tool its eight numbers (w x y z, x y z in mm, error in mm) or the
word of a tool that is not seen. The last tool is loaded twice; a device that knows two markers never sees the third tool.
"""

import ctypes
import json
import sys
import time

try:
    import ndicapy
except ImportError:
    print("no ndicapi")
    sys.exit(0)


class Module:
    """What its Python module has: BX and TX."""

    def __init__(self, port):
        self.device = ndicapy.ndiOpenNetwork("127.0.0.1", port)
        self.ways = {
            "BX": ("BX:0801", ndicapy.ndiGetBXFrame, ndicapy.ndiGetBXTransform),
            "TX": ("TX:0801", ndicapy.ndiGetTXFrame, ndicapy.ndiGetTXTransform),
        }

    def command(self, text):
        ndicapy.ndiCommand(self.device, text)
        if ndicapy.ndiGetError(self.device) != ndicapy.NDI_OKAY:
            sys.exit(f"{text}: {ndicapy.ndiErrorString(ndicapy.ndiGetError(self.device))}")

    def load(self, file):
        handle = ndicapy.ndiGetPHRQHandle(self.device)
        return handle, ndicapy.ndiPVWRFromFile(self.device, handle, file)

    def read(self, way, handles):
        command, frame, transform = self.ways[way]
        self.command(command)
        handles = [bytes([handle]) for handle in handles]
        return frame(self.device, handles[0]), [transform(self.device, handle) for handle in handles]

    def close(self):
        ndicapy.ndiCloseNetwork(self.device)


class Library:
    """The C library beneath, which has BX2 as well."""

    ways = ["BX2"]
    # The words of its codes.
    WORDS = {1: "DISABLED", 2: "MISSING"}

    def __init__(self, port):
        self.c = ctypes.CDLL(ndicapy.__file__)
        self.c.ndiOpenNetwork.restype = ctypes.c_void_p
        self.c.ndiErrorString.restype = ctypes.c_char_p
        self.c.ndiGetBX2Frame.restype = ctypes.c_uint
        self.device = ctypes.c_void_p(self.c.ndiOpenNetwork(b"127.0.0.1", ctypes.c_int(port)))

    def command(self, text):
        self.c.ndiCommand(self.device, b"%s", text.encode())
        error = self.c.ndiGetError(self.device)
        if error != ndicapy.NDI_OKAY:
            sys.exit(f"{text}: {self.c.ndiErrorString(error).decode()}")

    def load(self, file):
        handle = self.c.ndiGetPHRQHandle(self.device)
        return handle, self.c.ndiPVWRFromFile(self.device, handle, file.encode())

    def read(self, _, handles):
        self.command("BX2:--6d=tools --3d=tools")
        tools = []
        for handle in handles:
            place = (ctypes.c_float * 8)()
            found = self.c.ndiGetBX2Transform(self.device, handle, place)
            tools.append(list(place) if found == ndicapy.NDI_OKAY else self.WORDS.get(found, str(found)))
        return self.c.ndiGetBX2Frame(self.device), tools

    def close(self):
        self.c.ndiCloseNetwork(self.device)


def main():
    port, count = int(sys.argv[1]), int(sys.argv[2])
    files = [argument for argument in sys.argv[3:] if argument != "--bx2"]
    client = Library(port) if "--bx2" in sys.argv else Module(port)
    command = client.command
    command("INIT:")
    handles = []
    for file in files + files[-1:]:
        command("PHRQ:*********1****")
        handle, loaded = client.load(file)
        if loaded != ndicapy.NDI_OKAY:
            sys.exit(f"{file} is refused")
        command(f"PINIT:{handle:02X}")
        command(f"PENA:{handle:02X}D")
        handles.append(handle)
    command("TSTART:")
    for _ in range(count):
        time.sleep(0.01)
        for way in client.ways:
            frame, tools = client.read(way, handles)
            print(json.dumps({"way": way, "frame": frame, "tools": tools}), flush=True)
    command("TSTOP:")
    client.close()


main()
