"""A sender of images that knows nothing of Trocar: pynetdicom, against `volume-loader receive`.

Usage: dicom_peer.py PORT CALLED CALLING WORK [FOLDER [NUMBER]]
WORK: echo      C-ECHO
      store     sends every file of FOLDER, then releases
      abort     sends NUMBER files of FOLDER, then aborts (A-ABORT)
      vanish    sends NUMBER files, then closes the connection without a word
      change    sends the first file with another voxel under the same name
      classes   proposes MR, CT in JPEG baseline and CT; says what was accepted
      hold      sends NUMBER files, says so, and waits for a line on stdin before it releases
      compare   says whether each file of FOLDER is the same data set as the one of that name below CALLED (no network)
Needs: pydicom, pynetdicom. Prints one JSON object: connected, rejected (result, source, reason), statuses (hexadecimal), accepted.
"""

import glob
import json
import os
import sys

import pydicom
from pynetdicom import AE
from pynetdicom.sop_class import CTImageStorage, MRImageStorage, Verification

JPEG_BASELINE = "1.2.840.10008.1.2.4.50"


def files(folder):
    return sorted(path for path in glob.glob(os.path.join(folder, "**", "*.dcm"), recursive=True))


def compare(folder, kept):
    by_name = {data.SOPInstanceUID: data for data in map(pydicom.dcmread, files(kept))}
    sent = [pydicom.dcmread(path) for path in files(folder)]
    same = sum(by_name.get(data.SOPInstanceUID) == data for data in sent)
    meta = all(
        data.file_meta.MediaStorageSOPInstanceUID == data.SOPInstanceUID
        and data.file_meta.MediaStorageSOPClassUID == data.SOPClassUID
        for data in by_name.values()
    )
    return {"sent": len(sent), "kept": len(by_name), "same": same, "meta": bool(meta)}


def associate(port, called, calling, work, folder):
    ae = AE(ae_title=calling)
    ae.acse_timeout = ae.dimse_timeout = ae.network_timeout = 60
    if work == "echo":
        ae.add_requested_context(Verification)
    elif work == "classes":
        ae.add_requested_context(MRImageStorage)
        ae.add_requested_context(CTImageStorage, [JPEG_BASELINE])
        ae.add_requested_context(CTImageStorage, ["1.2.840.10008.1.2.1"])
    else:
        pairs = {(data.SOPClassUID, data.file_meta.TransferSyntaxUID) for data in map(pydicom.dcmread, files(folder))}
        for sop_class, syntax in sorted(pairs):
            ae.add_requested_context(sop_class, [syntax])
    return ae.associate("127.0.0.1", port, ae_title=called)


def main():
    _, port, called, calling, work, *more = sys.argv
    folder = more[0] if more else None
    if work == "compare":
        print(json.dumps(compare(folder, called)))
        return
    said = {"connected": False, "rejected": None, "statuses": []}
    assoc = associate(int(port), called, calling, work, folder)
    if assoc.is_rejected:
        answer = assoc.acceptor.primitive
        said["rejected"] = [answer.result, answer.result_source, answer.diagnostic]
    if not assoc.is_established:
        print(json.dumps(said))
        return
    said["connected"] = True
    said["accepted"] = len(assoc.accepted_contexts)
    if work == "echo":
        said["statuses"].append(f"{assoc.send_c_echo().Status:04x}")
    elif work == "change":
        data = pydicom.dcmread(files(folder)[0])
        voxels = bytearray(data.PixelData)
        voxels[0] ^= 1
        data.PixelData = bytes(voxels)
        said["statuses"].append(f"{assoc.send_c_store(data).Status:04x}")
    elif work != "classes":
        paths = files(folder)[: int(more[1]) if len(more) > 1 else None]
        for path in paths:
            answer = assoc.send_c_store(path)
            said["statuses"].append(f"{answer.Status:04x}" if "Status" in answer else "none")
    if work == "hold":
        print("holding", flush=True)
        sys.stdin.readline()
    if work == "abort":
        assoc.abort()
    elif work == "vanish":
        print(json.dumps(said), flush=True)
        os._exit(0)
    else:
        assoc.release()
    said["aborted"] = assoc.is_aborted
    print(json.dumps(said))


main()
