"""Adjusts a marker's emitters and all poses with SciPy and holds the places of `calib marker` against it.

Usage: check_marker.py FRAMES.csv MARKER.json
Needs: scipy, numpy. Prints one JSON object: distances_mm (greatest difference of a distance between two emitters), rms_mm
(difference of the root mean square residuals).

Every emitter is seen often enough and none is left out. The frame is free: only distances are compared.
"""

import csv
import json
import sys
from itertools import combinations

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation


def main(frames_path, marker_path):
    with open(marker_path) as file:
        record = json.load(file)["marker_body"]
    places = np.array([emitter["at_mm"] for emitter in record["emitters"]])
    views = {}
    with open(frames_path, newline="") as file:
        for row in csv.DictReader(file):
            sighting = (int(row["emitter"]), [float(row[axis]) for axis in "xyz"])
            views.setdefault(row["frame"], []).append(sighting)
    views = [([e for e, _ in view], np.array([p for _, p in view])) for view in views.values()]

    # Begins at our places, disturbed, and at the poses that those give.
    chance = np.random.default_rng(1)
    first = places + chance.normal(0, 0.2, places.shape)
    poses = []
    for emitters, seen in views:
        ours = first[emitters]
        turn, _ = Rotation.align_vectors(seen - seen.mean(0), ours - ours.mean(0))
        poses.append(np.concatenate([turn.as_rotvec(), seen.mean(0) - turn.apply(ours.mean(0))]))

    def residuals(unknowns):
        body = unknowns[: places.size].reshape(-1, 3)
        steps = unknowns[places.size :].reshape(-1, 6)
        off = []
        for (emitters, seen), start, step in zip(views, poses, steps):
            turn = Rotation.from_rotvec(step[:3]) * Rotation.from_rotvec(start[:3])
            off.append(seen - turn.apply(body[emitters]) - start[3:] - step[3:])
        return np.concatenate(off).ravel()

    start = np.concatenate([first.ravel(), np.zeros(6 * len(views))])
    found = least_squares(residuals, start, method="trf", xtol=1e-15, ftol=1e-15, gtol=1e-12)
    theirs = found.x[: places.size].reshape(-1, 3)
    pairs = combinations(range(len(places)), 2)
    difference = [
        abs(np.linalg.norm(theirs[i] - theirs[j]) - np.linalg.norm(places[i] - places[j])) for i, j in pairs
    ]
    rms = np.sqrt(np.mean(np.sum(found.fun.reshape(-1, 3) ** 2, axis=1)))
    print(json.dumps({"distances_mm": max(difference), "rms_mm": float(abs(rms - record["rms_mm"]))}))


if __name__ == "__main__":
    main(*sys.argv[1:3])
