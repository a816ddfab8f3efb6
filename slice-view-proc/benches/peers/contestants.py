"""Ours, vtkImageReslice and SimpleITK, each drawing the same plane of the same volume on one thread.

A contestant has a name, the filter whose f64 reference it is held against, and `draw(plane)`, which returns CPU ms, wall
ms and the image. Setting the plane is not timed, drawing is, with what each program does for an image each time.
"""

import subprocess
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import SimpleITK as sitk
import vtk
from vtk.util import numpy_support

PADDING_HU = -1024


@dataclass(frozen=True)
class Plane:
    """Centre of the first pixel, directions of columns and rows, in mm LPS."""

    origin: np.ndarray
    right: np.ndarray
    down: np.ndarray
    pixel_mm: float
    size: int


@dataclass(frozen=True)
class Volume:
    """Voxels as z, y, x, and where they lie."""

    voxels: np.ndarray
    spacing_mm: tuple
    origin_mm: tuple


def timed(work):
    """CPU ms of all threads of this process, and wall ms."""
    cpu, wall = time.process_time_ns(), time.monotonic_ns()
    work()
    return (time.process_time_ns() - cpu) / 1e6, (time.monotonic_ns() - wall) / 1e6


class Engine:
    """Our engine: the benchmark program as a child. It says its own times."""

    def __init__(self, command, folder):
        self.folder = Path(folder)
        self.child = subprocess.Popen(
            [*command, "--serve", str(folder)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        line = self.child.stdout.readline().split()
        if not line or line[0] != "ready":
            raise SystemExit(f"the engine did not start: {' '.join(command)}")
        numbers = [float(word) for word in line[1:]]
        nx, ny, nz = (int(n) for n in numbers[:3])
        voxels = np.fromfile(self.folder / "volume.raw", dtype="<i2").reshape(nz, ny, nx)
        self.volume = Volume(voxels, tuple(numbers[3:6]), tuple(numbers[6:9]))

    def draw(self, what, plane):
        file = self.folder / "image.raw"
        steps = (plane.right * plane.pixel_mm, plane.down * plane.pixel_mm)
        numbers = np.concatenate([plane.origin, *steps]).tolist()
        words = [what, *map(repr, numbers), plane.size, plane.size, file]
        print(*words, file=self.child.stdin, flush=True)
        answer = self.child.stdout.readline().split()
        if not answer or answer[0] != "ok":
            raise SystemExit(f"the engine: {' '.join(answer)}")
        image = np.fromfile(file, dtype="<f4").reshape(plane.size, plane.size)
        return int(answer[1]) / 1e6, int(answer[2]) / 1e6, image


class Ours:
    slow = False

    def __init__(self, engine, name, filter, what):
        self.engine, self.name, self.filter, self.what = engine, name, filter, what

    def draw(self, plane):
        return self.engine.draw(self.what, plane)


class Vtk:
    slow = False

    def __init__(self, name, filter, image, interpolation, as_stored=False):
        """`interpolation` is one of the built-in modes, or an interpolator."""
        self.name, self.filter = name, filter
        self.reslice = reslice = vtk.vtkImageReslice()
        reslice.SetInputData(image)
        if isinstance(interpolation, int):
            reslice.SetInterpolationMode(interpolation)
        else:
            reslice.SetInterpolator(interpolation)
        reslice.SetOutputDimensionality(2)
        reslice.SetOutputOrigin(0, 0, 0)
        reslice.SetBackgroundLevel(PADDING_HU)
        reslice.SetNumberOfThreads(1)
        reslice.SetEnableSMP(False)
        if not as_stored:
            reslice.SetOutputScalarType(vtk.VTK_FLOAT)

    def draw(self, plane):
        normal = np.cross(plane.right, plane.down)
        self.reslice.SetResliceAxesDirectionCosines(*plane.right, *plane.down, *normal)
        self.reslice.SetResliceAxesOrigin(*plane.origin)
        self.reslice.SetOutputSpacing(plane.pixel_mm, plane.pixel_mm, 1)
        self.reslice.SetOutputExtent(0, plane.size - 1, 0, plane.size - 1, 0, 0)
        self.reslice.Modified()
        cpu, wall = timed(self.reslice.Update)
        scalars = self.reslice.GetOutput().GetPointData().GetScalars()
        return cpu, wall, numpy_support.vtk_to_numpy(scalars).reshape(plane.size, plane.size)


def vtk_image(volume):
    nz, ny, nx = volume.voxels.shape
    image = vtk.vtkImageData()
    image.SetDimensions(nx, ny, nz)
    image.SetSpacing(*volume.spacing_mm)
    image.SetOrigin(*volume.origin_mm)
    scalars = numpy_support.numpy_to_vtk(volume.voxels.ravel(), deep=False, array_type=vtk.VTK_SHORT)
    image.GetPointData().SetScalars(scalars)
    return image


def vtk_contestants(volume):
    vtk.vtkMultiThreader.SetGlobalMaximumNumberOfThreads(1)
    vtk.vtkSMPTools.SetBackend("Sequential")
    image = vtk_image(volume)
    coefficients = vtk.vtkImageBSplineCoefficients()
    coefficients.SetInputData(image)
    coefficients.SetSplineDegree(3)
    coefficients.Update()

    def sinc(half_width):
        interpolator = vtk.vtkImageSincInterpolator()
        interpolator.SetWindowFunctionToLanczos()
        interpolator.SetWindowHalfWidth(half_width)
        return interpolator

    spline = vtk.vtkImageBSplineInterpolator()
    spline.SetSplineDegree(3)
    return [
        Vtk("VTK, i16 out", "nearest", image, vtk.VTK_RESLICE_NEAREST, as_stored=True),
        Vtk("VTK", "nearest", image, vtk.VTK_RESLICE_NEAREST),
        Vtk("VTK, i16 out", "linear", image, vtk.VTK_RESLICE_LINEAR, as_stored=True),
        Vtk("VTK", "linear", image, vtk.VTK_RESLICE_LINEAR),
        Vtk("VTK", "cubic", image, vtk.VTK_RESLICE_CUBIC),
        Vtk("VTK, kept coefficients", "b-spline", coefficients.GetOutput(), spline),
        Vtk("VTK", "sinc-3", image, sinc(3)),
        Vtk("VTK", "sinc-5", image, sinc(5)),
    ]


class Itk:
    def __init__(self, name, filter, image, interpolator, slow=False):
        self.name, self.filter, self.image, self.slow = name, filter, image, slow
        self.resample = resample = sitk.ResampleImageFilter()
        resample.SetInterpolator(interpolator)
        resample.SetOutputPixelType(sitk.sitkFloat32)
        resample.SetDefaultPixelValue(PADDING_HU)
        resample.SetNumberOfThreads(1)
        resample.SetNumberOfWorkUnits(1)

    def draw(self, plane):
        normal = np.cross(plane.right, plane.down)
        self.resample.SetSize((plane.size, plane.size, 1))
        self.resample.SetOutputOrigin(plane.origin.tolist())
        self.resample.SetOutputSpacing((plane.pixel_mm, plane.pixel_mm, 1.0))
        self.resample.SetOutputDirection(np.stack([plane.right, plane.down, normal], axis=1).ravel().tolist())
        kept = []
        cpu, wall = timed(lambda: kept.append(self.resample.Execute(self.image)))
        return cpu, wall, sitk.GetArrayViewFromImage(kept[0])[0].copy()


def itk_contestants(volume):
    sitk.ProcessObject.SetGlobalDefaultNumberOfThreads(1)
    image = sitk.GetImageFromArray(volume.voxels)
    image.SetSpacing(volume.spacing_mm)
    image.SetOrigin(volume.origin_mm)
    coefficients = sitk.BSplineDecomposition(sitk.Cast(image, sitk.sitkFloat32), 3)
    return [
        Itk("SimpleITK", "nearest", image, sitk.sitkNearestNeighbor),
        Itk("SimpleITK", "linear", image, sitk.sitkLinear),
        Itk("SimpleITK, kept coefficients", "b-spline", coefficients, sitk.sitkBSplineResampler),
        # Prefilters the whole volume for each image.
        Itk("SimpleITK", "b-spline", image, sitk.sitkBSpline, slow=True),
        Itk("SimpleITK", "sinc-5", image, sitk.sitkLanczosWindowedSinc, slow=True),
    ]
