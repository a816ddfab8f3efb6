"""Locates the calibration base with SciPy and holds the place of `calib base` against it.

Usage: check_base.py TOUCHES.csv DRAWING.toml BASE.json
Needs: scipy, numpy, Python 3.11. Prints one JSON object: apart_mm (greatest distance between the images of the grooves' ends),
covariance (greatest entry by which the covariance differs, in units of SciPy's deviations).

Touches are labelled, of a sharp tip, without outliers. The residuals are those of the definition: the distance from the plane,
and the two distances across the groove; SciPy differentiates by differences.
"""

import csv
import json
import sys
import tomllib

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation


def rows_of(touches, drawing):
    """Each touch with the point and the axes of the base that hold it."""
    normal = np.array(drawing["plane"]["normal"], float)
    normal /= np.linalg.norm(normal)
    features = {"plane": (np.array(drawing["plane"]["at_mm"], float), [normal])}
    for k, groove in enumerate(drawing["groove"]):
        start, end = np.array(groove["start_mm"], float), np.array(groove["end_mm"], float)
        along = (end - start) / np.linalg.norm(end - start)
        up = normal - along * (normal @ along)
        up /= np.linalg.norm(up)
        features[f"groove {k}"] = (start, [up, np.cross(along, up)])
    for row in touches:
        at, axes = features[row["on"]]
        yield np.array([float(row[axis]) for axis in "xyz"]), at, axes


def main(touches_path, drawing_path, base_path):
    with open(touches_path, newline="") as file:
        touches = list(csv.DictReader(file))
    with open(drawing_path, "rb") as file:
        drawing = tomllib.load(file)
    with open(base_path) as file:
        ours = json.load(file)["base"]
    w, x, y, z = ours["quaternion_wxyz"]
    rotation = Rotation.from_quat([x, y, z, w])
    translation = np.array(ours["translation_mm"])
    held = list(rows_of(touches, drawing))
    centre = np.mean([touch for touch, _, _ in held], axis=0)

    def pose(step):
        """The small motion about the touches' centre, after our place."""
        turn = Rotation.from_rotvec(step[:3])
        return turn * rotation, turn.apply(translation - centre) + centre + step[3:]

    def residuals(step):
        r, t = pose(step)
        return [r.apply(axis) @ (touch - r.apply(at) - t) for touch, at, axes in held for axis in axes]

    start = np.array([0.01, -0.02, 0.015, 0.5, -0.4, 0.3])
    found = least_squares(residuals, start, xtol=1e-15, ftol=1e-15, gtol=1e-15, x_scale=[0.01] * 3 + [1.0] * 3)
    ends = np.array([groove[end] for groove in drawing["groove"] for end in ("start_mm", "end_mm")], float)
    r, t = pose(found.x)
    apart = np.linalg.norm((r.apply(ends) + t) - (rotation.apply(ends) + translation), axis=1).max()

    # Ours is of (w, v) about the tracker's origin; SciPy's, for a noise of 0.2 mm, of the motion about the centre.
    theirs = np.linalg.inv(found.jac.T @ found.jac) * 0.2**2
    upper = np.zeros((6, 6))
    upper[np.triu_indices(6)] = ours["covariance_upper"]
    full = upper + np.triu(upper, 1).T
    cross = lambda c: np.array([[0, -c[2], c[1]], [c[2], 0, -c[0]], [-c[1], c[0], 0]])
    carry = np.eye(6)
    carry[3:, :3] = -cross(centre)
    deviations = np.sqrt(np.diag(theirs))
    difference = (carry @ full @ carry.T - theirs) / np.outer(deviations, deviations)
    print(json.dumps({"apart_mm": float(apart), "covariance": float(np.abs(difference).max())}))


if __name__ == "__main__":
    main(*sys.argv[1:4])
