"""Reads what Trocar derived from a DICOM series, a segmentation and a structure set, by software that Trocar does not use.

Usage: check_derived.py segmentation OBJECT.dcm FOLDER TRUTH.npz
       check_derived.py points OBJECT.dcm FOLDER
FOLDER is the series; TRUTH.npz holds the centres of the voxels, LPS mm, and their labels. Needs: highdicom, pydicom, numpy; runs dciodvfy
(package dicom3tools) where it is on the PATH or in the folder that DICOM3TOOLS names. Prints one JSON object.

Of both: strangers (elements by which it would belong to another patient, study or frame of reference than the series), references
(identifiers of the series' own files that it names, and others), errors (lines of the validator, or null where there is none).
Of a segmentation: names by segment, differ (voxels that the truth has not, or has and the file has not, each with its label), off_mm (the
greatest distance of a voxel's centre from its own in the truth), planes (places of frames, as highdicom finds them).
Of a structure set: points by name, LPS mm.
"""

import json
import os
import shutil
import subprocess
import sys
import warnings

import numpy as np
import pydicom

from write_segmentation import slices

OF_THE_SERIES = ["PatientName", "PatientID", "PatientBirthDate", "PatientSex", "StudyInstanceUID", "StudyDate", "FrameOfReferenceUID"]


def read(path):
    """Every value converted, and with that validated: a doubt of pydicom's is an error."""
    pydicom.config.settings.reading_validation_mode = pydicom.config.RAISE
    warnings.simplefilter("error")
    data = pydicom.dcmread(path)
    for element in data.iterall():
        element.value
    warnings.simplefilter("ignore")
    pydicom.config.settings.reading_validation_mode = pydicom.config.WARN
    return data


def errors(path):
    where = os.pathsep.join(filter(None, [os.environ.get("DICOM3TOOLS"), os.environ.get("PATH")]))
    binary = shutil.which("dciodvfy", path=where)
    if binary is None:
        return None
    output = subprocess.run([binary, "-new", path], capture_output=True, text=True)
    return sorted({line for line in (output.stdout + output.stderr).splitlines() if line.startswith("Error")})


def belongs(data, sets):
    of = sets[0]
    strangers = [name for name in OF_THE_SERIES if str(data.get(name, "")) != str(of.get(name, ""))]
    own = {item.SOPInstanceUID for item in sets}
    named = {item.value for item in data.iterall() if item.keyword == "ReferencedSOPInstanceUID"} - {of.StudyInstanceUID}
    return {"strangers": strangers, "references": [len(named & own), len(named - own)], "slices": len(own)}


def segmentation(path, truth):
    """By highdicom: which frame is of which segment and lies where; the bits by pydicom."""
    import highdicom

    data = highdicom.seg.segread(path)
    pixels, axes = data.pixel_array, None
    shared = data.SharedFunctionalGroupsSequence[0]
    axes = np.array(shared.PlaneOrientationSequence[0].ImageOrientationPatient, float)
    down, right = (float(step) for step in shared.PixelMeasuresSequence[0].PixelSpacing)
    places, labels, planes = [], [], set()
    for frame, group in zip(pixels, data.PerFrameFunctionalGroupsSequence):
        origin = np.array(group.PlanePositionSequence[0].ImagePositionPatient, float)
        planes.add(tuple(origin))
        row, column = np.nonzero(frame)
        places.append(origin + np.outer(column, axes[:3] * right) + np.outer(row, axes[3:] * down))
        labels.append(np.full(len(row), group.SegmentIdentificationSequence[0].ReferencedSegmentNumber))
    places, labels = np.concatenate(places), np.concatenate(labels)
    truth = np.load(truth)

    def ordered(places, labels):
        return np.lexsort((*np.round(places, 3).T, labels))

    ours, theirs = ordered(places, labels), ordered(truth["places"], truth["labels"])
    if len(ours) != len(theirs):
        return {"differ": abs(len(ours) - len(theirs)), "off_mm": None}
    off = np.abs(places[ours] - truth["places"][theirs]).max()
    names = {str(item.SegmentNumber): item.SegmentLabel for item in data.SegmentSequence}
    differ = int(np.count_nonzero(labels[ours] != truth["labels"][theirs]))
    found = data.get_segment_numbers(segment_label=names["1"])
    return {"names": names, "differ": differ, "off_mm": float(off), "planes": len(planes), "found": [int(n) for n in found]}


def points(data):
    names = {item.ROINumber: item.ROIName for item in data.StructureSetROISequence}
    kinds = {item.ContourSequence[0].ContourGeometricType for item in data.ROIContourSequence}
    assert kinds == {"POINT"}, kinds
    places = {names[item.ReferencedROINumber]: [float(mm) for mm in item.ContourSequence[0].ContourData] for item in data.ROIContourSequence}
    return {"points": places}


def main(kind, path, folder, truth=None):
    data, sets = read(path), slices(folder)
    said = {**belongs(data, sets), "errors": errors(path)}
    said.update(points(data) if kind == "points" else segmentation(path, truth))
    print(json.dumps(said))


if __name__ == "__main__":
    main(*sys.argv[1:])
