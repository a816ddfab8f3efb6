"""Reads a DICOM series that Trocar wrote, by software that Trocar does not use, and holds it against a NIfTI file of the same
volume.

Usage: check_dicom_export.py FOLDER VOLUME.nii.gz
Needs: pydicom, SimpleITK, numpy; runs dciodvfy and dcentvfy (package dicom3tools) where they are on the PATH or in the folder
that DICOM3TOOLS names. Prints one JSON object: files, voxels_differ (count of voxels that are not the same), spacing_mm,
origin_mm, direction (greatest differences between what SimpleITK finds in the series and in the file), corner_mm (greatest
distance of a voxel's place, from the positions and orientations of the files themselves), tilt_degrees (from the tag, or null),
named (attributes that could name a patient and are not empty), validators (each with its lines of errors).

A series with a tilted gantry is sheared, which SimpleITK's images cannot be: spacing, origin and direction are null then.
"""

import glob
import gzip
import json
import os
import shutil
import subprocess
import sys
import warnings

import numpy as np
import pydicom
import SimpleITK as sitk

EMPTY = [
    "PatientName",
    "PatientID",
    "PatientBirthDate",
    "PatientSex",
    "StudyDate",
    "StudyTime",
    "StudyID",
    "AccessionNumber",
    "ReferringPhysicianName",
]


def read_files(folder):
    """The data sets in the order of their positions along the slices' normal; any doubt of pydicom's is an error."""
    pydicom.config.settings.reading_validation_mode = pydicom.config.RAISE
    warnings.simplefilter("error")
    sets = [pydicom.dcmread(path) for path in sorted(glob.glob(os.path.join(folder, "*.dcm")))]
    for data in sets:
        for element in data.iterall():
            element.value  # converts, and with that validates
    warnings.simplefilter("default")
    row, column = np.split(np.array(sets[0].ImageOrientationPatient, float), 2)
    normal = np.cross(row, column)
    return sorted(sets, key=lambda data: np.array(data.ImagePositionPatient, float) @ normal)


def read_nifti(path):
    """Voxels (slices, rows, columns) and the affine of a little-endian NIfTI-1 file from its sform, in LPS: shear and all."""
    with (gzip.open if path.endswith(".gz") else open)(path, "rb") as file:
        content = file.read()
    columns, rows, slices = np.frombuffer(content, "<i2", 3, 42)
    datatype = {4: "<i2", 8: "<i4"}[int(np.frombuffer(content, "<i2", 1, 70)[0])]
    start = int(np.frombuffer(content, "<f4", 1, 108)[0])
    voxels = np.frombuffer(content, datatype, int(columns) * int(rows) * int(slices), start).reshape(slices, rows, columns)
    ras = np.frombuffer(content, "<f4", 12, 280).reshape(3, 4).astype(float)
    return voxels, np.diag([-1.0, -1.0, 1.0]) @ ras


def corner_distance(sets, affine, reverse):
    """The greatest distance of a slice's corners from where the affine puts them."""
    worst = 0.0
    for k, data in enumerate(sets):
        index = len(sets) - 1 - k if reverse else k
        row, column = np.split(np.array(data.ImageOrientationPatient, float), 2)
        down, across = (float(x) for x in data.PixelSpacing)
        for i in (0, data.Columns - 1):
            for j in (0, data.Rows - 1):
                there = np.array(data.ImagePositionPatient, float) + row * across * i + column * down * j
                want = affine @ np.array([i, j, index, 1.0])
                worst = max(worst, float(np.linalg.norm(there - want)))
    return worst


def series_image(folder):
    reader = sitk.ImageSeriesReader()
    names = reader.GetGDCMSeriesFileNames(folder)
    reader.SetFileNames(names)
    return reader.Execute()


def validators(folder):
    """Lines of errors of dicom3tools, each validator's."""
    path = os.pathsep.join(filter(None, [os.environ.get("DICOM3TOOLS"), os.environ.get("PATH")]))
    files = sorted(glob.glob(os.path.join(folder, "*.dcm")))
    found = {}
    for tool, runs in (("dciodvfy", [["-new", file] for file in files]), ("dcentvfy", [files])):
        binary = shutil.which(tool, path=path)
        if binary is None:
            continue
        outputs = [subprocess.run([binary, *run], capture_output=True, text=True) for run in runs]
        lines = "".join(output.stdout + output.stderr for output in outputs).splitlines()
        found[tool] = sorted({line for line in lines if line.startswith("Error")})
    return found


def main(folder, nifti_path):
    sets = read_files(folder)
    ours, affine = read_nifti(nifti_path)
    # Files are in the order of the normal; the volume's slices may run the other way.
    reverse = bool(np.linalg.det(affine[:, :3]) < 0)
    pixels = np.stack([data.pixel_array * int(data.RescaleSlope) + int(data.RescaleIntercept) for data in sets])
    result = {
        "files": len(sets),
        "voxels_differ": int(np.count_nonzero((pixels[::-1] if reverse else pixels) != ours)),
        "corner_mm": corner_distance(sets, affine, reverse),
        "tilt_degrees": float(sets[0].GantryDetectorTilt) if "GantryDetectorTilt" in sets[0] else None,
        "named": sorted({name for data in sets for name in EMPTY if str(data.get(name, "absent"))}),
        "spacing_mm": None,
        "origin_mm": None,
        "direction": None,
        "validators": validators(folder),
    }
    if result["tilt_degrees"] is None and not reverse:
        image, theirs = sitk.ReadImage(nifti_path), series_image(folder)
        result["voxels_differ"] += int(np.count_nonzero(sitk.GetArrayFromImage(theirs) != ours))
        for key, get in (("spacing_mm", "GetSpacing"), ("origin_mm", "GetOrigin"), ("direction", "GetDirection")):
            difference = np.array(getattr(theirs, get)()) - np.array(getattr(image, get)())
            result[key] = float(np.abs(difference).max())
    print(json.dumps(result))


if __name__ == "__main__":
    main(*sys.argv[1:])
