"""Writes a label map with names by software that Trocar does not use.

Usage: write_label_map.py (pynrrd | simpleitk) MAP.seg.nrrd
Needs: pynrrd, SimpleITK, numpy.

The map has 12 x 10 x 8 voxels of 20 mm, voxel (i, j, k) at (-20 i, -20 j, 20 k), LPS. Voxel (6, 5, 4) has the label 5, called "vena cava,
inferior", and voxel (6, 6, 5) the label 8, called "Leber \\ rechts"; keys are those of a segmentation of 3D Slicer.
"""

import json
import sys

import nrrd
import numpy as np
import SimpleITK as sitk

kind, path = sys.argv[1:]
labels = np.zeros((12, 10, 8), np.uint8)
labels[6, 5, 4], labels[6, 6, 5] = 5, 8
keys = {
    "Segment0_ID": "Segment_1",
    "Segment0_LabelValue": "5",
    "Segment0_Layer": "0",
    "Segment0_Name": "vena cava, inferior",
    "Segment1_LabelValue": "8",
    "Segment1_Layer": "0",
    "Segment1_Name": "Leber \\ rechts",
    "Segmentation_MasterRepresentation": "Binary labelmap",
}
if kind == "pynrrd":
    header = {
        "space": "left-posterior-superior",
        "space directions": np.diag([-20.0, -20.0, 20.0]),
        "space origin": np.zeros(3),
        "encoding": "gzip",
    }
    nrrd.write(path, labels, {**header, **keys})
else:
    image = sitk.GetImageFromArray(labels.transpose(2, 1, 0))
    image.SetSpacing([20.0] * 3)
    image.SetDirection([-1.0, 0, 0, 0, -1.0, 0, 0, 0, 1.0])
    for key, value in keys.items():
        image.SetMetaData(key, value)
    sitk.WriteImage(image, path, useCompression=True)
print(json.dumps({"written": path}))
