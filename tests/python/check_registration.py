"""Registers pairs with SciPy and holds a registration of Trocar's against it.

Usage: check_registration.py PAIRS.csv REGISTRATION.json
Needs: scipy, numpy. Prints one JSON object: angle_rad (between the two rotations), translation_mm (greatest difference of
the images of the points), rms_mm (difference of the root mean square residuals).

PAIRS.csv has a header and no comments; its column weight is used where it is there. SciPy centres nothing: that is done
here, by the same weights.
"""

import csv
import json
import sys

import numpy as np
from scipy.spatial.transform import Rotation


def read(path):
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    cloud = lambda side: np.array([[float(row[f"{side}_{axis}"]) for axis in "xyz"] for row in rows])
    weights = np.array([float(row.get("weight") or 1.0) for row in rows])
    return cloud("to"), cloud("from"), weights


def main(pairs_path, registration_path):
    to, moving, weights = read(pairs_path)
    centre_to, centre_moving = (np.average(cloud, axis=0, weights=weights) for cloud in (to, moving))
    theirs, _ = Rotation.align_vectors(to - centre_to, moving - centre_moving, weights=weights)
    image = theirs.apply(moving - centre_moving) + centre_to
    rms = np.sqrt(np.average(np.sum((to - image) ** 2, axis=1), weights=weights))

    with open(registration_path) as file:
        ours = json.load(file)
    matrix = np.array(ours["transform"]["matrix"])
    our_image = moving @ matrix[:3, :3].T + matrix[:3, 3]
    difference = Rotation.from_matrix(matrix[:3, :3]) * theirs.inv()
    result = {
        "angle_rad": float(difference.magnitude()),
        "translation_mm": float(np.abs(our_image - image).max()),
        "rms_mm": float(abs(rms - ours["fre_rms_mm"])),
    }
    print(json.dumps(result))


if __name__ == "__main__":
    main(*sys.argv[1:])
