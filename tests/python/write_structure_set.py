"""Writes a DICOM structure set with points and contours, by software that Trocar does not use.

Usage: write_structure_set.py SLICE.dcm OUT.dcm NAME=X,Y,Z...
SLICE.dcm is a slice of the examination, whose frame of reference the points are in. Beside the points there are a region of contours and
one of nothing. Needs: pydicom. Prints one JSON object: the points as pydicom reads them again.
"""

import json
import sys

import pydicom
from pydicom.dataset import Dataset, FileMetaDataset
from pydicom.sequence import Sequence
from pydicom.uid import ExplicitVRLittleEndian, RTStructureSetStorage, generate_uid


def region(number, name, frame):
    item = Dataset()
    item.ROINumber, item.ROIName, item.ReferencedFrameOfReferenceUID = number, name, frame
    item.ROIGenerationAlgorithm = "MANUAL"
    return item


def contours(number, kind, data):
    item, contour = Dataset(), Dataset()
    item.ReferencedROINumber, item.ROIDisplayColor = number, [255, 0, 0]
    contour.ContourGeometricType, contour.NumberOfContourPoints, contour.ContourData = kind, len(data) // 3, data
    item.ContourSequence = Sequence([contour])
    return item


def main(slice_path, out, *points):
    of = pydicom.dcmread(slice_path, stop_before_pixels=True)
    written = Dataset()
    written.file_meta = FileMetaDataset()
    written.file_meta.TransferSyntaxUID = ExplicitVRLittleEndian
    written.file_meta.MediaStorageSOPClassUID = written.SOPClassUID = RTStructureSetStorage
    written.file_meta.MediaStorageSOPInstanceUID = written.SOPInstanceUID = generate_uid()
    written.SpecificCharacterSet, written.Modality = "ISO_IR 192", "RTSTRUCT"
    # Whose it is, its frame of reference alone says.
    written.PatientName, written.StudyInstanceUID, written.SeriesInstanceUID = "", generate_uid(), generate_uid()
    written.ApprovalStatus = "UNAPPROVED"
    frame = of.FrameOfReferenceUID
    regions, drawn = [region(1, "liver", frame), region(2, "nothing", frame)], []
    drawn.append(contours(1, "CLOSED_PLANAR", [float(i) for i in range(3 * 5000)]))
    for number, text in enumerate(points, 3):
        name, place = text.rsplit("=", 1)
        regions.append(region(number, name, frame))
        drawn.append(contours(number, "POINT", [float(part) for part in place.split(",")]))
    written.StructureSetROISequence, written.ROIContourSequence = Sequence(regions), Sequence(drawn)
    written.save_as(out, enforce_file_format=True)
    again = pydicom.dcmread(out)
    names = {item.ROINumber: item.ROIName for item in again.StructureSetROISequence}
    found = {
        names[item.ReferencedROINumber]: [float(mm) for mm in item.ContourSequence[0].ContourData]
        for item in again.ROIContourSequence
        if item.ContourSequence[0].ContourGeometricType == "POINT"
    }
    print(json.dumps(found))


if __name__ == "__main__":
    main(*sys.argv[1:])
