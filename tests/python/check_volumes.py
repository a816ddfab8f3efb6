"""Reads examinations by software that Trocar does not use and holds them against what Trocar exported of the same.

Usage: check_volumes.py (dicom FOLDER | enhanced FILE | sitk FILE | nifti FILE) EXPORTED.nrrd
Needs: pydicom, pynrrd, SimpleITK, numpy; for compressed DICOM pylibjpeg with its libjpeg and openjpeg plug-ins.

EXPORTED is an attached NRRD in LPS. `dicom`: every pixel of every slice of FOLDER, in HU by slope and intercept, is looked
up in EXPORTED at its place in the patient, which follows from the slice's own position and orientation. `enhanced`: the same
for every frame of one file, after its functional groups. `sitk`: every voxel of FILE as SimpleITK reads it. `nifti`: every
voxel of FILE, its place by the sform and, without one, the qform.

Prints one JSON object: voxels (compared), differ (not the same HU), off_grid_mm (greatest distance between the place of a
voxel and that of the voxel of EXPORTED that it was compared with), missing (slices of FOLDER without a place in EXPORTED).
"""

import glob
import gzip
import json
import os
import sys

import nrrd
import numpy as np
import SimpleITK as sitk


def exported(path):
    """Voxels by column, row, slice; the map from them to LPS mm."""
    data, header = nrrd.read(path)
    assert header["space"] == "left-posterior-superior", header["space"]
    affine = np.eye(4)
    affine[:3, :3] = np.array(header["space directions"], float).T
    affine[:3, 3] = header["space origin"]
    return data, affine


class Comparison:
    def __init__(self, path):
        self.data, self.affine = exported(path)
        self.inverse = np.linalg.inv(self.affine)
        self.seen = {"voxels": 0, "differ": 0, "off_grid_mm": 0.0, "missing": 0}

    def add(self, affine, hu):
        """`hu` by column, row, slice, in their places by `affine`; a whole block of EXPORTED's voxels or none."""
        corners = [[i, j, k, 1] for i in (0, hu.shape[0] - 1) for j in (0, hu.shape[1] - 1) for k in (0, hu.shape[2] - 1)]
        place = affine @ np.array(corners, float).T
        index = self.inverse @ place
        whole = np.rint(index)
        off = np.linalg.norm((self.affine @ (whole - index))[:3], axis=0).max()
        inside = all((0 <= whole[a]).all() and (whole[a] < self.data.shape[a]).all() for a in range(3))
        if not inside or off > 0.5 * np.linalg.norm(self.affine[:3, 2]):
            self.seen["missing"] += 1
            return
        self.seen["off_grid_mm"] = max(self.seen["off_grid_mm"], float(off))
        steps = np.rint(self.inverse @ affine)[:3, :3].astype(int)
        order = np.abs(steps).argmax(axis=0)
        ours = self.data
        for axis in range(3):
            if steps[order[axis], axis] < 0:
                ours = np.flip(ours, order[axis])
        ours = np.transpose(ours, order)
        flipped = self.inverse @ affine @ np.array([0, 0, 0, 1.0])
        start = []
        for axis in range(3):
            at = int(np.rint(flipped[order[axis]]))
            start.append(self.data.shape[order[axis]] - 1 - at if steps[order[axis], axis] < 0 else at)
        ours = ours[tuple(slice(s, s + n) for s, n in zip(start, hu.shape))]
        self.seen["voxels"] += hu.size
        self.seen["differ"] += int((ours != hu).sum())


def dicom(folder, comparison):
    import pydicom

    for path in glob.glob(os.path.join(folder, "**", "*"), recursive=True):
        if not os.path.isfile(path) or not pydicom.misc.is_dicom(path):
            continue
        data = pydicom.dcmread(path)
        place = (data.ImageOrientationPatient, data.PixelSpacing, data.ImagePositionPatient)
        scale = float(getattr(data, "RescaleSlope", 1)), float(getattr(data, "RescaleIntercept", 0))
        one_slice(comparison, place, scale, data.pixel_array)


def one_slice(comparison, place, scale, pixels):
    orientation, spacing, position = (np.array(numbers, float) for numbers in place)
    row, column = np.split(orientation, 2)
    affine = np.eye(4)
    affine[:3, 0] = row * spacing[1]
    affine[:3, 1] = column * spacing[0]
    # One slice thick: any direction off the plane serves, and that of EXPORTED's slices is flipped as they are.
    affine[:3, 2] = comparison.affine[:3, 2]
    affine[:3, 3] = position
    hu = np.rint(pixels.astype(float) * scale[0] + scale[1])
    comparison.add(affine, hu.T[:, :, None])


def enhanced(path, comparison):
    import pydicom

    data = pydicom.dcmread(path)
    shared = data.SharedFunctionalGroupsSequence[0]
    for own, pixels in zip(data.PerFrameFunctionalGroupsSequence, data.pixel_array, strict=True):

        def group(name):
            return (own if name in own else shared)[name][0]

        place = (
            group("PlaneOrientationSequence").ImageOrientationPatient,
            group("PixelMeasuresSequence").PixelSpacing,
            group("PlanePositionSequence").ImagePositionPatient,
        )
        numbers = group("PixelValueTransformationSequence")
        one_slice(comparison, place, (float(numbers.RescaleSlope), float(numbers.RescaleIntercept)), pixels)


def by_sitk(path, comparison):
    image = sitk.ReadImage(path)
    affine = np.eye(4)
    affine[:3, :3] = np.array(image.GetDirection()).reshape(3, 3) * np.array(image.GetSpacing())
    affine[:3, 3] = image.GetOrigin()
    comparison.add(affine, held(sitk.GetArrayFromImage(image).T))


def held(values):
    """As whole numbers of 16 bits: what is above or below is held there."""
    return np.clip(np.rint(values), -32768, 32767)


def by_nifti(path, comparison):
    content = (gzip.open if path.endswith(".gz") else open)(path, "rb").read()
    dims = np.frombuffer(content, "<i2", 3, 42)
    kind = {4: "<i2", 8: "<i4", 16: "<f4", 512: "<u2"}[int(np.frombuffer(content, "<i2", 1, 70)[0])]
    start = int(np.frombuffer(content, "<f4", 1, 108)[0])
    slope, intercept = np.frombuffer(content, "<f4", 2, 112)
    values = np.frombuffer(content, kind, int(np.prod(dims)), start).reshape(dims, order="F").astype(float)
    affine = np.eye(4)
    affine[:3] = np.frombuffer(content, "<f4", 12, 280).reshape(3, 4)
    affine = np.diag([-1.0, -1.0, 1.0, 1.0]) @ affine
    comparison.add(affine, held(values * slope + intercept if slope else values))


def main():
    kind, source, path = sys.argv[1:]
    comparison = Comparison(path)
    {"dicom": dicom, "enhanced": enhanced, "sitk": by_sitk, "nifti": by_nifti}[kind](source, comparison)
    print(json.dumps(comparison.seen))


main()
