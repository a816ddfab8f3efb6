"""Reads the DICOM series in a folder by SimpleITK and prints the seconds it took, file names and their order included."""

import sys
import time

import SimpleITK as sitk

folder = sys.argv[1]
began = time.perf_counter()
reader = sitk.ImageSeriesReader()
reader.SetFileNames(sitk.ImageSeriesReader.GetGDCMSeriesFileNames(folder))
image = reader.Execute()
took = time.perf_counter() - began
assert image.GetSize()[2] > 1
print(took)
