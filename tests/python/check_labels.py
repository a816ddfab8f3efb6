"""Compares a label map as NRRD with the truth of write_segmentation.py, by software that Trocar does not use.

Usage: check_labels.py MAP.seg.nrrd TRUTH.npz
Needs: pynrrd, numpy. Prints one JSON object: voxels with a label, those of them that the truth has not or elsewhere, the largest distance
between a voxel's centre and its own in the truth in mm, and the names of the labels.
"""

import json
import sys

import nrrd
import numpy as np


def main(path, truth):
    voxels, header = nrrd.read(path)
    truth = np.load(truth)
    index = np.argwhere(voxels != 0)
    places = header["space origin"] + index @ header["space directions"]
    labels = voxels[tuple(index.T)]
    # The truth's voxels by the index nearest to them.
    inverse = np.linalg.inv(header["space directions"])
    nearest = np.rint((truth["places"] - header["space origin"]) @ inverse).astype(int)
    off = np.abs(header["space origin"] + nearest @ header["space directions"] - truth["places"]).max()
    wanted = {tuple(at): int(label) for at, label in zip(nearest, truth["labels"])}
    found = {tuple(at): int(label) for at, label in zip(index, labels)}
    differ = sum(wanted.get(at) != label for at, label in found.items()) + len(wanted.keys() - found.keys())
    names = {}
    for key, name in header.items():
        if key.endswith("_Name"):
            names[header[key.replace("_Name", "_LabelValue")]] = name
    print(json.dumps({"voxels": len(places), "differ": differ, "off_mm": float(off), "names": names}))


if __name__ == "__main__":
    main(*sys.argv[1:])
