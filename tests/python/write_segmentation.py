"""Writes a DICOM segmentation of a classic CT series, by software that Trocar does not use, and the truth beside it.

Usage: write_segmentation.py FOLDER OUT.dcm KIND TRUTH.npz [STATUS]
KIND: binary, binary-all (no frame is left out), labelmap, fractional. STATUS: ApprovalStatus, where it has one.
Needs: highdicom, pydicom, numpy. Prints one JSON object: frames, and for each label its voxels.

Three structures that leave planes between them without a frame; TRUTH.npz holds the centres of their voxels, LPS mm, and their labels.
"""

import glob
import json
import os
import sys
import warnings

import highdicom
import numpy as np
import pydicom
from highdicom.seg import SegmentAlgorithmTypeValues, Segmentation, SegmentDescription
from highdicom.sr.coding import CodedConcept

LABELS = {1: "liver", 2: "Vena portae", 5: "lymph node"}


def slices(folder):
    paths = [path for path in glob.glob(os.path.join(folder, "**", "*"), recursive=True) if os.path.isfile(path)]
    sets = [pydicom.dcmread(path) for path in sorted(paths) if pydicom.misc.is_dicom(path)]
    sets = [data for data in sets if "ImagePositionPatient" in data]
    sets = [data for data in sets if data.SeriesInstanceUID == sets[0].SeriesInstanceUID]
    row, column = np.split(np.array(sets[0].ImageOrientationPatient, float), 2)
    normal = np.cross(row, column)
    return sorted(sets, key=lambda data: float(np.dot(normal, np.array(data.ImagePositionPatient, float))))


def structures(shape):
    """Labels by plane, row, column."""
    planes, rows, columns = shape
    k, j, i = np.ogrid[:planes, :rows, :columns]
    labels = np.zeros(shape, np.uint8)
    third = planes // 3
    labels[(k < third) & ((j - rows // 3) ** 2 + (i - columns // 3) ** 2 < (rows // 9) ** 2)] = 1
    labels[(k >= 2) & (k < third) & (abs(j - rows // 2) < 3) & (i > columns // 2)] = 2
    labels[(k >= planes - 5) & (k < planes - 2) & (j % 7 == 3) & (i % 11 == 5)] = 5
    return labels


def description(number, name):
    code = CodedConcept("T-D0050", "SRT", "Tissue")
    return SegmentDescription(number, name, code, code, SegmentAlgorithmTypeValues.MANUAL)


def segmentation(sets, labels, kind):
    names = LABELS
    if kind != "labelmap":
        # Segments of the other kinds count from 1 without a gap.
        names = {number: name for number, name in enumerate(LABELS.values(), 1)}
        labels = np.stack([labels == label for label in LABELS], axis=-1).astype(np.uint8)
    kinds = {"labelmap": "LABELMAP", "fractional": "FRACTIONAL"}
    return Segmentation(
        source_images=sets,
        pixel_array=labels.astype(float) if kind == "fractional" else labels,
        segmentation_type=kinds.get(kind, "BINARY"),
        segment_descriptions=[description(number, name) for number, name in names.items()],
        series_instance_uid=highdicom.UID(),
        series_number=9,
        sop_instance_uid=highdicom.UID(),
        instance_number=1,
        manufacturer="none",
        manufacturer_model_name="none",
        software_versions="1",
        device_serial_number="1",
        omit_empty_frames=kind != "binary-all",
    )


def main(folder, out, kind, truth, status=None):
    warnings.simplefilter("ignore")
    sets = slices(folder)
    labels = structures((len(sets), sets[0].Rows, sets[0].Columns))
    written = segmentation(sets, labels, kind)
    if status:
        written.ApprovalStatus = status
    written.save_as(out)
    plane, row, column = np.nonzero(labels)
    origins = np.array([data.ImagePositionPatient for data in sets], float)
    axes = np.array(sets[0].ImageOrientationPatient, float)
    down, right = (float(step) for step in sets[0].PixelSpacing)
    places = origins[plane] + np.outer(column, axes[:3] * right) + np.outer(row, axes[3:] * down)
    found = labels[plane, row, column]
    if kind != "labelmap":
        found = np.searchsorted(list(LABELS), found) + 1
    np.savez(truth, places=places, labels=found)
    numbers, counts = np.unique(found, return_counts=True)
    counts = {str(number): int(count) for number, count in zip(numbers, counts)}
    print(json.dumps({"frames": int(written.NumberOfFrames), "voxels": counts}))


if __name__ == "__main__":
    main(*sys.argv[1:])
