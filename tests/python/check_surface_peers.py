"""Registration by the surface beside other programs, on the very same points.

    cargo bench -p surface-registration --bench surface -- 40 --dump DIR
    python tests/python/check_surface_peers.py DIR

Needs numpy, vtk and open3d. VTK is called as SlicerIGT's "Fiducials-Model Registration" calls it (vtkIterativeClosestPointTransform, rigid,
at most 100 iterations, the locator built before), Open3D as point to plane with Tukey's kernel, narrowed from 20 over 8 to 2 mm on 20 000
points of the surface: the best of some schedules that were tried on these very points. Both begin at
the guess that the search is given, and know of no echoes. A run is a success with a root mean square TRE below 2 mm at the targets.
Prints one table; times are those that this thread had a processor for, the files read and trees built before.
"""

import json
import sys
import time

import numpy as np
import open3d as o3d
import vtk
from vtk.util import numpy_support


def read_obj(path):
    corners, triangles = [], []
    with open(path) as lines:
        for line in lines:
            kind, *rest = line.split()
            if kind == "v":
                corners.append([float(x) for x in rest])
            elif kind == "f":
                triangles.append([int(x) - 1 for x in rest])
    return np.array(corners), np.array(triangles)


def matrix(rows):
    return np.vstack([np.array(rows), [0, 0, 0, 1]])


def tre(found, truth, targets):
    """Root mean square over the targets of where `found` shows what `truth` shows at them."""
    local = (np.linalg.inv(truth) @ np.c_[targets, np.ones(len(targets))].T)
    shown = (found @ local)[:3].T
    return float(np.sqrt(((shown - targets) ** 2).sum(1).mean()))


class Vtk:
    name = "VTK ICP, 100 iterations"

    def __init__(self, corners, triangles):
        self.model = vtk.vtkPolyData()
        points = vtk.vtkPoints()
        points.SetData(numpy_support.numpy_to_vtk(corners, deep=True))
        self.model.SetPoints(points)
        cells = vtk.vtkCellArray()
        for t in triangles:
            cells.InsertNextCell(3, [int(i) for i in t])
        self.model.SetPolys(cells)
        self.locator = vtk.vtkCellLocator()
        self.locator.SetDataSet(self.model)
        self.locator.BuildLocator()

    def run(self, points, guess):
        # It knows of no start: the points are laid there before.
        moved = (guess @ np.c_[points, np.ones(len(points))].T)[:3].T
        source = vtk.vtkPolyData()
        places, cells = vtk.vtkPoints(), vtk.vtkCellArray()
        places.SetData(numpy_support.numpy_to_vtk(np.ascontiguousarray(moved), deep=True))
        for i in range(len(points)):
            cells.InsertNextCell(1, [i])
        source.SetPoints(places)
        source.SetVerts(cells)
        icp = vtk.vtkIterativeClosestPointTransform()
        icp.SetSource(source)
        icp.SetTarget(self.model)
        icp.SetLocator(self.locator)
        icp.GetLandmarkTransform().SetModeToRigidBody()
        icp.SetMaximumNumberOfIterations(100)
        icp.Update()
        m = icp.GetMatrix()
        return np.array([[m.GetElement(i, j) for j in range(4)] for i in range(4)]) @ guess


class Open3d:
    name = "Open3D point to plane, Tukey"

    def __init__(self, corners, triangles):
        mesh = o3d.geometry.TriangleMesh(
            o3d.utility.Vector3dVector(corners), o3d.utility.Vector3iVector(triangles)
        )
        mesh.compute_vertex_normals()
        # Each call builds a tree over them: 200 000 take ten times as long, and find no more.
        o3d.utility.random.seed(1)
        self.target = mesh.sample_points_uniformly(number_of_points=20_000)

    def run(self, points, guess):
        source = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))
        reg, pose = o3d.pipelines.registration, guess
        for reach, width in [(100.0, 20.0), (50.0, 8.0), (10.0, 2.0)]:
            estimation = reg.TransformationEstimationPointToPlane(reg.TukeyLoss(k=width))
            criteria = reg.ICPConvergenceCriteria(max_iteration=30)
            pose = reg.registration_icp(source, self.target, reach, pose, estimation, criteria).transformation
        return np.array(pose)


def main(folder):
    corners, triangles = read_obj(f"{folder}/bone.obj")
    with open(f"{folder}/runs.json") as file:
        told = json.load(file)
    targets = np.array(told["targets_ct_mm"])
    peers = [Vtk(corners, triangles), Open3d(corners, triangles)]
    # Row, then program: errors and milliseconds.
    table = {}
    for run in told["runs"]:
        row = table.setdefault(run["row"], {})
        truth, guess = matrix(run["ct_from_tracker"]), matrix(run["guess_ct_from_tracker"])
        for ours in run["ours"]:
            found = ours["ct_from_tracker"]
            error = tre(matrix(found), truth, targets) if found else float("inf")
            row.setdefault(f"this, {ours['name']}", []).append((error, ours["ms"]))
        for peer in peers:
            began = time.thread_time()
            found = peer.run(np.array(run["points_mm"]), guess)
            ms = 1e3 * (time.thread_time() - began)
            row.setdefault(peer.name, []).append((tre(found, truth, targets), ms))
    print(f"vtk {vtk.vtkVersion.GetVTKVersion()}, open3d {o3d.__version__}, numpy {np.__version__}")
    print("| row | program | success | median TRE of those, mm | median ms | its time over that of one start |")
    print("|---|---|---|---|---|---|")
    for name, row in table.items():
        unit = np.median([ms for _, ms in row["this, one start"]])
        for program, runs in row.items():
            good = [error for error, _ in runs if error < 2.0]
            ms = np.median([ms for _, ms in runs])
            error = f"{np.median(good):.2f}" if good else "-"
            print(f"| {name} | {program} | {len(good)} of {len(runs)} | {error} | {ms:.1f} | {ms / unit:.1f} |")


if __name__ == "__main__":
    main(sys.argv[1])
