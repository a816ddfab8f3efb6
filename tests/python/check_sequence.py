"""Reads a sequence of ultrasound images with SimpleITK, as 3D Slicer does, and holds it against a recording's own export.

Usage: check_sequence.py SEQUENCE PIXELS
Needs: SimpleITK. SEQUENCE is what `recorder export mha --images` wrote; its grey values go to the new file PIXELS, image after image.
Prints one JSON object: size (columns, rows, images), transforms (how many there are of each name), not_ok (how many of them are not OK),
stamps (seconds), orthogonal (the greatest entry of R R' - 1 of a transform that is OK).
"""

import json
import pathlib
import re
import sys

import SimpleITK as sitk


def main(sequence, pixels):
    reader = sitk.ImageFileReader()
    reader.SetFileName(sequence)
    image = reader.Execute()
    assert image.GetPixelID() == sitk.sitkUInt8, image.GetPixelIDTypeAsString()
    pathlib.Path(pixels).write_bytes(sitk.GetArrayFromImage(image).tobytes())
    transforms, not_ok, off, stamps = {}, 0, 0.0, []
    for number in range(image.GetSize()[2]):
        key = f"Seq_Frame{number:04d}_"
        stamps.append(float(reader.GetMetaData(f"{key}Timestamp")))
        for name in ("ProbeToTracker", "ReferenceToTracker"):
            numbers = [float(word) for word in reader.GetMetaData(f"{key}{name}Transform").split()]
            assert len(numbers) == 16 and numbers[12:] == [0, 0, 0, 1], numbers
            transforms[name] = transforms.get(name, 0) + 1
            if reader.GetMetaData(f"{key}{name}TransformStatus") != "OK":
                not_ok += 1
                continue
            rows = [numbers[4 * i : 4 * i + 3] for i in range(3)]
            products = [sum(a * b for a, b in zip(rows[i], rows[j])) - (i == j) for i in range(3) for j in range(3)]
            off = max([off, *map(abs, products)])
    # A key that nobody expects would be one that another reader trips over.
    known = r"Seq_Frame\d{4,}_(FrameNumber|ImageStatus|Timestamp|UnfilteredTimestamp|\w+Transform(Status)?)"
    strange = [key for key in reader.GetMetaDataKeys() if key.startswith("Seq_") and not re.fullmatch(known, key)]
    assert not strange, strange[:5]
    size = list(image.GetSize())
    print(json.dumps({"size": size, "transforms": transforms, "not_ok": not_ok, "stamps": stamps, "orthogonal": off}))


main(*sys.argv[1:])
