"""Writes an Enhanced CT out of a classic DICOM series, by software that Trocar does not use.

Usage: write_enhanced_ct.py FOLDER OUT.dcm SYNTAX TABLE SEED
SYNTAX: implicit, explicit, big, rle (compressed here), or same (fragments of a compressed series as they stand).
TABLE: basic, extended or none, for compressed frames. SEED: of the order of the frames; 0 keeps the order of positions.
Needs: pydicom, numpy. Prints one JSON object: frames.

Odd seeds write the Legacy Converted class, whose frames state every functional group themselves; even ones the Enhanced class,
where what all frames have alike is shared. Slices of FOLDER that are not of the first one's series are left out.
"""

import glob
import json
import os
import random
import sys

import numpy as np
import pydicom
from pydicom.dataset import Dataset, FileMetaDataset
from pydicom.encaps import encapsulate, encapsulate_extended, generate_frames
from pydicom.pixels.encoders import RLELosslessEncoder
from pydicom.sequence import Sequence
from pydicom.uid import ExplicitVRBigEndian, ExplicitVRLittleEndian, ImplicitVRLittleEndian, RLELossless, generate_uid

SYNTAXES = {
    "implicit": ImplicitVRLittleEndian,
    "explicit": ExplicitVRLittleEndian,
    "big": ExplicitVRBigEndian,
    "rle": RLELossless,
}
ROOT = [
    "PatientName", "PatientID", "StudyInstanceUID", "SeriesInstanceUID", "FrameOfReferenceUID", "Modality", "SamplesPerPixel",
    "PhotometricInterpretation", "Rows", "Columns", "BitsAllocated", "BitsStored", "HighBit", "PixelRepresentation",
    "PixelPaddingValue",
]


def slices(folder):
    paths = glob.glob(os.path.join(folder, "**", "*"), recursive=True)
    sets = [pydicom.dcmread(path) for path in sorted(paths) if os.path.isfile(path) and pydicom.misc.is_dicom(path)]
    sets = [data for data in sets if "ImagePositionPatient" in data]
    sets = [data for data in sets if data.SeriesInstanceUID == sets[0].SeriesInstanceUID]
    row, column = np.split(np.array(sets[0].ImageOrientationPatient, float), 2)
    normal = np.cross(row, column)
    return sorted(sets, key=lambda data: float(np.dot(normal, np.array(data.ImagePositionPatient, float))))


def item(**values):
    data = Dataset()
    for name, value in values.items():
        setattr(data, name, value)
    return Sequence([data])


def shared_groups(data):
    """What the slices of one series mostly have alike."""
    return {
        "PlaneOrientationSequence": item(ImageOrientationPatient=data.ImageOrientationPatient),
        "PixelMeasuresSequence": item(PixelSpacing=data.PixelSpacing, SliceThickness=data.get("SliceThickness", 1)),
        "PixelValueTransformationSequence": item(
            RescaleIntercept=data.get("RescaleIntercept", 0), RescaleSlope=data.get("RescaleSlope", 1), RescaleType="HU"
        ),
        "CTImageFrameTypeSequence": item(
            FrameType=["ORIGINAL", "PRIMARY", "VOLUME", "NONE"], VolumetricProperties="VOLUME", PixelPresentation="MONOCHROME"
        ),
        # In pydicom's own representation of the number.
        "CardiacSynchronizationSequence": item(NominalPercentageOfCardiacPhase=75.0),
    }


def frame_groups(data, number):
    return {
        "PlanePositionSequence": item(ImagePositionPatient=data.ImagePositionPatient),
        "FrameContentSequence": item(StackID="1", InStackPositionNumber=number, TemporalPositionIndex=1),
    }


def dataset(groups):
    data = Dataset()
    for name, sequence in groups.items():
        setattr(data, name, sequence)
    return data


def alike(sets, name):
    first = shared_groups(sets[0])[name]
    return all(shared_groups(data)[name] == first for data in sets)


def swapped(frame, allocated):
    return frame if allocated == 8 else np.frombuffer(frame, "<u2").astype(">u2").tobytes()


def pixels(data, sets, syntax, table):
    if syntax in ("implicit", "explicit", "big"):
        frames = [one.PixelData for one in sets]
        data.PixelData = b"".join(swapped(f, data.BitsAllocated) for f in frames) if syntax == "big" else b"".join(frames)
        data["PixelData"].VR = "OW"
        return
    if syntax == "rle":
        describe = {
            "rows": data.Rows, "columns": data.Columns, "samples_per_pixel": 1, "number_of_frames": 1,
            "photometric_interpretation": "MONOCHROME2", "bits_allocated": data.BitsAllocated,
            "bits_stored": data.BitsStored, "pixel_representation": data.PixelRepresentation, "planar_configuration": 0,
        }
        frames = [RLELosslessEncoder.encode(one.PixelData, index=0, **describe) for one in sets]
    else:
        frames = [next(generate_frames(one.PixelData, number_of_frames=1)) for one in sets]
    if table == "extended":
        data.PixelData, data.ExtendedOffsetTable, data.ExtendedOffsetTableLengths = encapsulate_extended(frames)
    else:
        data.PixelData = encapsulate(frames, has_bot=table == "basic")
    data["PixelData"].VR = "OB"
    data["PixelData"].is_undefined_length = True


def main(folder, out, syntax, table, seed):
    sets, seed = slices(folder), int(seed)
    numbers = {id(one): number for number, one in enumerate(sets, 1)}
    if seed:
        random.Random(seed).shuffle(sets)
    first, legacy = sets[0], seed % 2 == 1
    data = Dataset()
    for name in ROOT:
        if name in first:
            setattr(data, name, first[name].value)
    data.SOPClassUID = "1.2.840.10008.5.1.4.1.1.2." + ("2" if legacy else "1")
    data.SOPInstanceUID = generate_uid(entropy_srcs=[out])
    data.ImageType = ["ORIGINAL", "PRIMARY", "VOLUME", "NONE"]
    data.NumberOfFrames = len(sets)
    names = [name for name in shared_groups(first) if not legacy and alike(sets, name)]
    data.SharedFunctionalGroupsSequence = Sequence([dataset({name: shared_groups(first)[name] for name in names})])
    frames = []
    for one in sets:
        groups = frame_groups(one, numbers[id(one)])
        groups.update({name: group for name, group in shared_groups(one).items() if name not in names})
        frames.append(dataset(groups))
    data.PerFrameFunctionalGroupsSequence = Sequence(frames)
    pixels(data, sets, syntax, table)
    data.file_meta = FileMetaDataset()
    data.file_meta.TransferSyntaxUID = SYNTAXES.get(syntax, first.file_meta.TransferSyntaxUID)
    data.file_meta.MediaStorageSOPClassUID = data.SOPClassUID
    data.file_meta.MediaStorageSOPInstanceUID = data.SOPInstanceUID
    pydicom.dcmwrite(out, data, enforce_file_format=True)
    print(json.dumps({"frames": len(sets)}))


main(*sys.argv[1:])
