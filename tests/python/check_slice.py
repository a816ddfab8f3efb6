"""Resamples a CT onto the geometry of a slice with ITK and holds the slice against it.

Usage: check_slice.py (CT.nii.gz | FOLDER) SLICE.mha
Needs: SimpleITK, numpy; pydicom for a FOLDER with one DICOM series, whose slices are stacked by their positions: the third axis
is the difference of positions, so that a tilted gantry gives ITK a sheared image, which its series reader would not. Prints one JSON object: pixels (compared), max and rms (absolute difference, HU), range (of the
pixels compared, HU: a slice of air would agree with anything).

The borders differ by rule: Trocar and ITK both hold a voxel's value over the outer half of its cell, but ITK decides
what is inside after its own rounding. Compared are only pixels whose index lies a whole voxel inside the outermost voxel
centres, where both interpolate between eight voxels.
"""

import json
import os
import sys

import numpy as np
import SimpleITK as sitk


def physical_from_index(image):
    """The 3 x 3 matrix and the origin that take a voxel index to LPS mm."""
    direction = np.array(image.GetDirection()).reshape(3, 3)
    return direction * np.array(image.GetSpacing()), np.array(image.GetOrigin())


def indices_in(ct, picture):
    """The continuous index in `ct` of each pixel of `picture`, in the order of its array."""
    from_pixel, origin = physical_from_index(picture)
    to_mm, ct_origin = physical_from_index(ct)
    z, y, x = np.indices(picture.GetSize()[::-1])
    points = np.stack([x, y, z], axis=-1) @ from_pixel.T + origin
    return (points - ct_origin) @ np.linalg.inv(to_mm).T


def stacked(folder):
    """The series in `folder` as an ITK image with its true map, shear and all."""
    import pydicom

    paths = [os.path.join(folder, name) for name in os.listdir(folder)]
    sets = [pydicom.dcmread(path) for path in paths if pydicom.misc.is_dicom(path)]
    row, column = np.split(np.array(sets[0].ImageOrientationPatient, float), 2)
    normal = np.cross(row, column)
    sets.sort(key=lambda data: np.array(data.ImagePositionPatient, float) @ normal)
    places = np.array([data.ImagePositionPatient for data in sets], float)
    step = (places[-1] - places[0]) / (len(sets) - 1)
    hu = [data.pixel_array * float(data.RescaleSlope) + float(data.RescaleIntercept) for data in sets]
    image = sitk.GetImageFromArray(np.array(hu, float))
    down, right = (float(mm) for mm in sets[0].PixelSpacing)
    image.SetSpacing([right, down, float(np.linalg.norm(step))])
    image.SetDirection(np.column_stack([row, column, step / np.linalg.norm(step)]).ravel().tolist())
    image.SetOrigin(places[0].tolist())
    return image


def main(ct_path, slice_path):
    ct = stacked(ct_path) if os.path.isdir(ct_path) else sitk.Cast(sitk.ReadImage(ct_path), sitk.sitkFloat64)
    picture = sitk.ReadImage(slice_path)
    theirs = sitk.Resample(ct, picture, sitk.Transform(), sitk.sitkLinear, -1024.0, sitk.sitkFloat64)
    index = indices_in(ct, picture)
    inside = ((index >= 1.0) & (index <= np.array(ct.GetSize()) - 2.0)).all(axis=-1)
    ours = sitk.GetArrayFromImage(picture).astype(np.float64)[inside]
    difference = np.abs(ours - sitk.GetArrayFromImage(theirs)[inside])
    result = {
        "pixels": int(inside.sum()),
        "max": float(difference.max(initial=0.0)),
        "rms": float(np.sqrt(np.mean(difference**2))) if inside.any() else 0.0,
        "range": float(np.ptp(ours)) if inside.any() else 0.0,
    }
    print(json.dumps(result))


if __name__ == "__main__":
    main(*sys.argv[1:])
