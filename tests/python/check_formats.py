"""Holds Trocar's NRRD and MetaImage files against SimpleITK and pynrrd, both ways.

Usage: check_formats.py CONVERT FOLDER
Needs: SimpleITK, pynrrd, numpy. CONVERT is volume-loader, called as CONVERT export IN OUT --overwrite [--compress]; FOLDER is an empty folder.
Prints one JSON object: files (how many were compared), voxels_wrong (of all files together), world_mm (the greatest
distance of a corner of one file's voxels from where it was written).

(a) Others write int16 and float32, compressed and not, mirrored and oblique; CONVERT reads it and writes NRRD.
(b) CONVERT writes each of our formats; SimpleITK and pynrrd read it. Files are written by one library and read by another.
"""

import itertools
import json
import math
import pathlib
import subprocess
import sys

import nrrd
import numpy as np
import SimpleITK as sitk

SIZE = (7, 6, 5)
CORNERS = np.array(list(itertools.product(*((0, n - 1) for n in SIZE))), dtype=float)


def directions():
    c, s = math.cos(0.3), math.sin(0.3)
    c2, s2 = math.cos(1.1), math.sin(1.1)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    tilt = np.array([[1, 0, 0], [0, c2, -s2], [0, s2, c2]])
    yield "straight", np.eye(3)
    yield "oblique", turn @ tilt
    yield "mirrored", turn @ np.diag([1.0, 1.0, -1.0])
    yield "swapped", np.array([[0.0, 0, 1], [1, 0, 0], [0, -1, 0]])


def image(direction, dtype):
    values = np.random.default_rng(5).integers(-1100, 3000, SIZE[::-1])
    picture = sitk.GetImageFromArray(values.astype(dtype))
    picture.SetSpacing((0.7, 1.0 / 3.0, 2.5))
    picture.SetOrigin((-123.456789012345, 77.1, 1e-3))
    picture.SetDirection(direction.flatten())
    return picture


def corners_of(picture):
    index = lambda corner: tuple(float(v) for v in corner)
    return np.array([picture.TransformContinuousIndexToPhysicalPoint(index(c)) for c in CORNERS])


class Comparison:
    """Sums up the differences."""

    def __init__(self):
        self.files, self.voxels_wrong, self.world_mm = 0, 0, 0.0

    def add(self, picture, voxels, corners):
        """`voxels` has z first, as SimpleITK's arrays have."""
        assert np.isfinite(corners).all(), corners
        want = sitk.GetArrayFromImage(picture)
        self.files += 1
        self.voxels_wrong += int(np.sum(np.rint(want) != voxels))
        self.world_mm = max(self.world_mm, float(np.abs(corners - corners_of(picture)).max()))

    def with_pynrrd(self, picture, path):
        voxels, header = nrrd.read(str(path))
        assert header["space"] == "left-posterior-superior", header
        corners = CORNERS @ np.array(header["space directions"], dtype=float) + header["space origin"]
        self.add(picture, voxels.T, corners)

    def with_sitk(self, picture, path):
        read = sitk.ReadImage(str(path))
        self.add(picture, sitk.GetArrayFromImage(read), corners_of(read))


def write_with_pynrrd(picture, path, space, signs, **options):
    directions = np.array(picture.GetDirection()).reshape(3, 3).T * np.array(picture.GetSpacing())[:, None]
    header = {
        "space": space,
        "space directions": directions * signs,
        "space origin": np.array(picture.GetOrigin()) * signs,
        **options,
    }
    nrrd.write(str(path), np.ascontiguousarray(sitk.GetArrayFromImage(picture).T), header)


def convert(program, source, target, *flags):
    subprocess.run([program, "export", source, target, "--overwrite", *flags], check=True, stderr=subprocess.DEVNULL)
    return target


def theirs(program, folder, seen):
    kinds = itertools.product(directions(), (np.int16, np.float32, np.uint16, np.int32), (False, True))
    for (name, direction), dtype, compress in kinds:
        picture = image(direction, np.int16 if dtype == np.uint16 else dtype)
        if dtype == np.uint16:
            picture = sitk.Cast(sitk.Abs(picture), sitk.sitkUInt16)
        stem = f"{name}-{np.dtype(dtype).name}-{compress}"
        for ending in (".nrrd", ".nhdr", ".mha", ".mhd"):
            source = folder / (stem + ending)
            sitk.WriteImage(picture, str(source), compress)
            seen.with_pynrrd(picture, convert(program, source, folder / "ours.nrrd"))
        for space, signs in (("RAS", [-1, -1, 1]), ("left-anterior-superior", [1, -1, 1])):
            for encoding in ("raw", "gzip", "ascii"):
                source = folder / f"{stem}-{space}-{encoding}.nrrd"
                write_with_pynrrd(picture, source, space, signs, encoding=encoding)
                seen.with_sitk(picture, convert(program, source, folder / "ours.nrrd"))
        big = folder / (stem + "-big.nhdr")
        write_with_pynrrd(picture, big, "LPS", [1, 1, 1], encoding="raw", endian="big")
        seen.with_pynrrd(picture, convert(program, big, folder / "ours.nrrd"))


def ours(program, folder, seen):
    for name, direction in directions():
        picture = image(direction, np.int16)
        source = folder / f"{name}-source.nrrd"
        sitk.WriteImage(picture, str(source))
        for ending, flags in itertools.product((".nrrd", ".nhdr", ".mha", ".mhd"), ((), ("--compress",))):
            # Two headers of one name would share their voxels, which is refused.
            target = convert(program, source, folder / f"ours-{ending[1:]}{ending}", *flags)
            seen.with_sitk(picture, target)
            if ending in (".nrrd", ".nhdr"):
                seen.with_pynrrd(picture, target)


def main(program, folder):
    seen = Comparison()
    theirs(program, pathlib.Path(folder), seen)
    ours(program, pathlib.Path(folder), seen)
    print(json.dumps(vars(seen)))


if __name__ == "__main__":
    main(*sys.argv[1:])
