"""Surfaces by trimesh.

check_surfaces.py write FOLDER             writes one surface in each format and coding that trimesh has, and prints the paths
check_surfaces.py compare TRIPLES          prints for each [A, B, same|turned] how far the corners of B's triangles are from those of A,
                                           turned by half a circle about z, and how many triangles there are
"""

import json
import sys

import numpy as np
import trimesh


def write(folder):
    mesh = trimesh.creation.icosphere(subdivisions=3)
    mesh.apply_scale([80.0, 55.5, 120.25])
    mesh.apply_translation([-61.25, 138.5, 912.125])
    paths = []
    for name, options in [
        ("binary.stl", {}),
        ("text.stl", {"file_type": "stl_ascii"}),
        ("binary.ply", {}),
        ("text.ply", {"encoding": "ascii"}),
        ("text.obj", {"digits": 12}),
    ]:
        path = f"{folder}/{name}"
        mesh.export(path, **options)
        paths.append(path)
    return paths


def corners(path):
    """As they stand in the file: no corners are merged."""
    mesh = trimesh.load(path, process=False, force="mesh")
    return np.asarray(mesh.vertices, dtype=float)[mesh.faces]


def compared(first, second, how):
    a, b = corners(first), corners(second)
    if how == "turned":
        a = a * [-1.0, -1.0, 1.0]
    assert a.shape == b.shape, (a.shape, b.shape)
    return {"apart_mm": float(np.abs(a - b).max()), "faces": len(a)}


def main():
    if sys.argv[1] == "write":
        print(json.dumps(write(sys.argv[2])))
    else:
        print(json.dumps([compared(*triple) for triple in json.loads(sys.argv[2])]))


main()
