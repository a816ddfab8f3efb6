#!/usr/bin/env python3
"""OpenCV's findCirclesGrid on images: what the benchmark of grids runs beside its own.

    python3 grid_opencv.py COLS ROWS IMAGES...

Prints a line for each image: CPU time (ms, the least of three), then x and y of every centre row by row, nothing where no grid
was found. Needs opencv-python-headless.
"""
import sys
import time

import cv2


def detector():
    """The settings that find the most grids: as in the blob detector's own documentation, with small and flat blobs."""
    p = cv2.SimpleBlobDetector_Params()
    p.minThreshold, p.maxThreshold, p.thresholdStep, p.minRepeatability = 10, 240, 5, 3
    p.minDistBetweenBlobs = 2
    p.filterByArea, p.minArea, p.maxArea = True, 10, 600
    p.filterByCircularity = False
    p.filterByInertia, p.minInertiaRatio = True, 0.01
    p.filterByConvexity, p.minConvexity = True, 0.8
    return cv2.SimpleBlobDetector_create(p)


def main():
    cols, rows = int(sys.argv[1]), int(sys.argv[2])
    flags = cv2.CALIB_CB_SYMMETRIC_GRID | cv2.CALIB_CB_CLUSTERING
    cv2.setNumThreads(1)
    for path in sys.argv[3:]:
        grey = cv2.imread(path, cv2.IMREAD_GRAYSCALE)
        times = []
        for _ in range(3):
            start = time.process_time()
            smooth = cv2.GaussianBlur(grey, (0, 0), 1.0)
            found, points = cv2.findCirclesGrid(smooth, (cols, rows), flags=flags, blobDetector=detector())
            times.append(1e3 * (time.process_time() - start))
        centres = points.reshape(-1).tolist() if found else []
        print(min(times), *centres)


main()
