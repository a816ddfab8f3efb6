"""Holds the distances of tubes from the structures of a label map against NumPy and SciPy.

Usage: check_safety.py unpack LABELS.nii.gz FOLDER
       check_safety.py compare LABELS.nii.gz ANSWERS.json
Needs: scipy, numpy.

`unpack` writes FOLDER/labels.i16 (x fastest) and prints dims and ct_from_voxel, in LPS. `compare` reads the map anew and prints one
JSON object: voxels (of each label), distances (compared), numpy_mm (greatest difference from the least signed distance over all voxels
of a label), sections_mm (the same of sections of a tube and all labels), scipy_distances (compared), scipy_above_mm and
scipy_below_mm (by how much SciPy's exact Euclidean distance transform is above and below at most).

The transform is that of the points of a grid three times as fine that lie in the tube; it is read at the voxels of each label.
A tube is a solid cylinder: outside, the distance is that from its nearest point, found by clamping; inside, less than zero, that from
the nearest of side, entry and tip.
"""

import gzip
import json
import sys

import numpy as np
from scipy.ndimage import distance_transform_edt

FINER = 3
# The transform is made this far around a tube, mm; labels farther away are compared with NumPy alone.
AROUND = 30.0


def read(path):
    content = gzip.open(path, "rb").read()
    dims = np.frombuffer(content, "<i2", 3, 42)
    kind = {2: "u1", 4: "<i2", 8: "<i4", 16: "<f4", 64: "<f8", 256: "i1", 512: "<u2"}[int(np.frombuffer(content, "<i2", 1, 70)[0])]
    start = int(np.frombuffer(content, "<f4", 1, 108)[0])
    values = np.frombuffer(content, kind, int(np.prod(dims)), start).reshape(dims, order="F")
    affine = np.eye(4)
    affine[:3] = np.frombuffer(content, "<f4", 12, 280).reshape(3, 4)
    return np.rint(values).astype(np.int16), np.diag([-1.0, -1.0, 1.0, 1.0]) @ affine


def unpack(path, folder):
    labels, affine = read(path)
    labels.ravel(order="F").astype("<i2").tofile(f"{folder}/labels.i16")
    print(json.dumps({"dims": list(map(int, labels.shape)), "ct_from_voxel": affine[:3].tolist()}))


def about(entry, tip, points):
    """Depth and distance from the axis, by the vector product."""
    length = np.linalg.norm(tip - entry)
    axis = (tip - entry) / length
    away = points - entry
    return away @ axis, np.linalg.norm(np.cross(away, axis), axis=-1), length


def outside(depth, off, begin, end, radius):
    return np.hypot(depth - np.clip(depth, begin, end), off - np.minimum(off, radius))


def signed(depth, off, length, radius):
    """Of a cylinder from depth 0 to `length`."""
    inside = np.minimum(np.minimum(radius - off, depth), length - depth)
    return np.where(inside >= 0, -inside, outside(depth, off, 0.0, length, radius))


def transform(affine, shape, entry, tip, radius):
    """SciPy's distance from the finer points of the tube, at the voxels of a box about it; where that box begins."""
    steps = np.linalg.norm(affine[:3, :3], axis=0)
    ends = np.linalg.solve(affine, np.c_[np.array([entry, tip]), [1, 1]].T)[:3]
    pad = (radius + AROUND) / steps
    low = np.clip(np.floor(ends.min(1) - pad), 0, np.array(shape) - 1).astype(int)
    high = np.clip(np.ceil(ends.max(1) + pad), 0, np.array(shape) - 1).astype(int)
    # One voxel more on each side, so that the nearest finer point of the tube lies in the box.
    finer = [(np.arange((h - l) * FINER + 1 + 2 * FINER) / FINER + l - 1) for l, h in zip(low, high)]
    index = np.stack(np.meshgrid(*finer, indexing="ij"), axis=-1)
    depth, off, length = about(entry, tip, index @ affine[:3, :3].T + affine[:3, 3])
    is_out = (depth < 0) | (depth > length) | (off > radius)
    if is_out.all():
        return None, low
    field = distance_transform_edt(is_out, sampling=steps / FINER)
    return field[FINER::FINER, FINER::FINER, FINER::FINER][tuple(slice(0, n) for n in high - low + 1)], low


def compare(path, answers):
    labels, affine = read(path)
    voxels = np.argwhere(labels > 0)
    of = labels[tuple(voxels.T)]
    order = np.argsort(of, kind="stable")
    voxels, of = voxels[order], of[order]
    names, first, counts = np.unique(of, return_index=True, return_counts=True)
    points = voxels @ affine[:3, :3].T + affine[:3, 3]
    seen = {"voxels": counts.tolist(), "distances": 0, "numpy_mm": 0.0, "sections_mm": 0.0}
    seen |= {"scipy_distances": 0, "scipy_above_mm": 0.0, "scipy_below_mm": 0.0}
    with open(answers) as file:
        tubes = json.load(file)
    for tube in tubes:
        entry, tip, radius = np.array(tube["entry"]), np.array(tube["tip"]), tube["radius"]
        depth, off, length = about(entry, tip, points)
        distance = signed(depth, off, length, radius)
        least = dict(zip(names.tolist(), np.minimum.reduceat(distance, first)))
        found = {label: mm for label, (mm, _, _) in tube["structures"]}
        assert found.keys() == least.keys()
        for label, (mm, at, point) in tube["structures"]:
            there = about(entry, tip, np.array(point))
            seen["distances"] += 1
            seen["numpy_mm"] = max(seen["numpy_mm"], abs(mm - least[label]), abs(mm - signed(*there, radius)), abs(at - there[0]))
        for begin, end, label, mm in tube["sections"]:
            here = outside(depth, off, begin, end, radius)
            here = np.where(here > 0, here, distance)
            seen["sections_mm"] = max(seen["sections_mm"], abs(here.min() - mm), abs(here[of == label].min() - mm))
        field, low = transform(affine, labels.shape, entry, tip, radius)
        if field is None:
            continue
        box = labels[tuple(slice(l, l + n) for l, n in zip(low, field.shape))]
        for label in np.unique(box[box > 0]):
            mm = found[int(label)]
            # The nearest voxel of the label must lie in the box, and outside the tube, where the transform is a distance.
            if 0 < mm < AROUND:
                difference = field[box == label].min() - mm
                seen["scipy_distances"] += 1
                seen["scipy_above_mm"] = max(seen["scipy_above_mm"], float(difference))
                seen["scipy_below_mm"] = max(seen["scipy_below_mm"], float(-difference))
    print(json.dumps(seen))


if __name__ == "__main__":
    {"unpack": unpack, "compare": compare}[sys.argv[1]](*sys.argv[2:])
