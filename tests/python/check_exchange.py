"""Slicer's files of points, by other means than Trocar's: written from the schema of .mrk.json and from what Slicer's own reader and
writer of .fcsv do, with Python's own json and csv.

check_exchange.py read FILE                    prints the points as JSON: label, position in LPS, mm, and the axes' own columns in LPS
check_exchange.py write FILE AXES POINTS       writes points, given in LPS, along the axes
check_exchange.py map FILE POINTS              prints where SimpleITK puts these points by the transform of FILE
check_exchange.py plus FILE FROM TO POINTS     prints where the one transform of a device set of PLUS from FROM to TO puts them
check_exchange.py transforms FOLDER POINTS     writes a transform of each kind with SimpleITK, and prints where each puts these points
"""

import csv
import json
import sys
from xml.etree import ElementTree

import numpy as np

SCHEMA = (
    "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/Resources/Schema/"
    "markups-schema-v1.0.3.json#"
)
COLUMNS = "id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID"
STATUSES = {"undefined", "preview", "defined"}


def to_lps(axes, v):
    assert axes in ("LPS", "RAS"), axes
    return [-v[0], -v[1], v[2]] if axes == "RAS" else list(v)


def checked(markup):
    """What the schema asks of a markup."""
    assert markup["type"] in ("Fiducial", "Line", "Angle", "Curve", "ClosedCurve"), markup["type"]
    assert markup["coordinateSystem"] in ("LPS", "RAS") and markup["coordinateUnits"] == "mm"
    for point in markup["controlPoints"]:
        for key in ("id", "label", "description", "associatedNodeID"):
            assert isinstance(point.get(key, ""), str), key
        for key in ("selected", "locked", "visibility"):
            assert isinstance(point.get(key, True), bool), key
        assert point.get("positionStatus", "defined") in STATUSES
        if "position" in point:
            assert len(point["position"]) == 3
    return markup


def read_markups(path):
    with open(path, encoding="utf-8") as file:
        text = file.read()
    # Slicer tells the kind of file by these words within its first 300 characters.
    assert "/markups-schema-v" in text[:300], text[:300]
    points = []
    for markup in json.loads(text)["markups"]:
        for point in checked(markup)["controlPoints"]:
            if point.get("positionStatus", "defined") == "defined":
                lps = to_lps(markup["coordinateSystem"], point["position"])
                points.append({"label": point["label"], "lps": lps, "of": markup["type"], "description": point["description"]})
    return points


def read_fcsv(path):
    head, points = {}, []
    with open(path, encoding="utf-8", newline="") as file:
        lines = file.read().splitlines()
    for line in lines:
        if line.startswith("#"):
            key, _, value = line[1:].partition("=")
            head[key.strip()] = value.strip()
    assert head["columns"] == COLUMNS
    axes = {"0": "RAS", "1": "LPS"}[head["CoordinateSystem"]]
    for row in csv.reader(line for line in lines if not line.startswith("#")):
        assert len(row) == 14, row
        lps = to_lps(axes, [float(x) for x in row[1:4]])
        points.append({"label": row[11], "lps": lps, "of": "Fiducial", "description": row[12]})
    return points


def write_markups(path, axes, points):
    control = [
        {
            "id": str(i + 1),
            "label": point["label"],
            "description": point.get("description", ""),
            "associatedNodeID": "",
            "position": to_lps(axes, point["lps"]),
            "orientation": [-1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 1.0],
            "selected": True,
            "locked": False,
            "visibility": True,
            "positionStatus": "defined",
        }
        for i, point in enumerate(points)
    ]
    markup = {
        "type": "Fiducial",
        "coordinateSystem": axes,
        "coordinateUnits": "mm",
        "locked": False,
        "fixedNumberOfControlPoints": False,
        "labelFormat": "%N-%d",
        "lastUsedControlPointNumber": len(points),
        "controlPoints": control,
        "measurements": [],
        "display": {"visibility": True, "opacity": 1.0},
    }
    with open(path, "w", encoding="utf-8") as file:
        json.dump({"@schema": SCHEMA, "markups": [markup]}, file, indent=4)


def write_fcsv(path, axes, points):
    with open(path, "w", encoding="utf-8", newline="") as file:
        file.write(f"# Markups fiducial file version = 5.6\n# CoordinateSystem = {axes}\n# columns = {COLUMNS}\n")
        writer = csv.writer(file)
        for i, point in enumerate(points):
            place = [repr(x) for x in to_lps(axes, point["lps"])]
            row = [i + 1, *place, 0, 0, 0, 1, 1, 1, 0, point["label"], point.get("description", ""), "", 2, 0]
            writer.writerow(row)


def map_plus(path, source, target, points):
    """As PLUS's guide has it: Matrix, row by row, takes points of the coordinate frame From to To."""
    root = ElementTree.parse(path).getroot()
    assert root.tag == "PlusConfiguration", root.tag
    found = [t for t in root.iter("Transform") if (t.get("From"), t.get("To")) == (source, target)]
    assert len(found) == 1, len(found)
    rows = np.array([float(x) for x in found[0].get("Matrix").split()]).reshape(4, 4)
    assert (rows[3] == [0.0, 0.0, 0.0, 1.0]).all(), rows
    return [(rows @ [*point, 1.0])[:3].tolist() for point in points]


def map_points(transform, points):
    return [transform.TransformPoint(point) for point in points]


def write_transforms(folder, points):
    """Of each kind that is rigid, turned about a centre, as text and as HDF5."""
    import SimpleITK as sitk

    euler = sitk.Euler3DTransform((11.0, -7.0, 5.0), 0.3, -0.5, 0.7, (12.5, -40.25, 160.125))
    zyx = sitk.Euler3DTransform(euler)
    zyx.SetComputeZYX(True)
    versor = sitk.VersorRigid3DTransform((0.6, 0.0, 0.8), 1.1, (12.5, -40.25, 160.125), (3.0, 2.0, 1.0))
    affine = sitk.AffineTransform(3)
    affine.SetMatrix(euler.GetMatrix())
    affine.SetTranslation((-120.0, 30.5, 7.25))
    affine.SetCenter((9.0, 8.0, 7.0))
    similarity = sitk.Similarity3DTransform(1.0, (0.6, 0.0, 0.8), 1.1, (12.5, -40.25, 160.125), (3.0, 2.0, 1.0))
    shift = sitk.TranslationTransform(3, (1.0, -20.0, 33.0))
    composite = sitk.CompositeTransform([shift, euler, affine])
    transforms = {
        "euler": euler,
        "zyx": zyx,
        "versor": versor,
        "affine": affine,
        "similarity": similarity,
        "translation": shift,
        "composite": composite,
    }
    written = {}
    for name, transform in transforms.items():
        for ending in ("tfm", "txt", "h5"):
            path = f"{folder}/{name}.{ending}"
            sitk.WriteTransform(transform, path)
            written[path] = map_points(transform, points)
    return written


def main():
    what, path = sys.argv[1:3]
    if what == "map":
        import SimpleITK as sitk

        print(json.dumps(map_points(sitk.ReadTransform(path), json.loads(sys.argv[3]))))
        return
    if what == "plus":
        print(json.dumps(map_plus(path, sys.argv[3], sys.argv[4], json.loads(sys.argv[5]))))
        return
    if what == "transforms":
        print(json.dumps(write_transforms(path, json.loads(sys.argv[3]))))
        return
    is_markups = path.endswith(".mrk.json")
    if what == "read":
        print(json.dumps((read_markups if is_markups else read_fcsv)(path)))
    else:
        axes, points = sys.argv[3], json.loads(sys.argv[4])
        (write_markups if is_markups else write_fcsv)(path, axes, points)
        print("[]")


main()
