#!/usr/bin/env python3
"""OpenCV's findCirclesGrid on the images of `calib grid`, beside its result.

    python3 grid_opencv.py grid.json COLS ROWS

`grid.json` is what `calib grid IMAGES... --out grid.json` wrote. Prints for each image whether each found the grid, the root
mean square distance between both sets of centres (px), and OpenCV's time (ms). Needs opencv-python-headless and numpy.
"""
import json
import sys
import time

import cv2
import numpy as np


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
    file, cols, rows = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    flags = cv2.CALIB_CB_SYMMETRIC_GRID | cv2.CALIB_CB_CLUSTERING
    for image in json.load(open(file))["images"]:
        grey = cv2.imread(image["path"], cv2.IMREAD_GRAYSCALE)
        start = time.process_time()
        found, points = cv2.findCirclesGrid(cv2.GaussianBlur(grey, (0, 0), 1.0), (cols, rows), flags=flags, blobDetector=detector())
        ms = 1e3 * (time.process_time() - start)
        words = f"calib {'found' if image['found'] else 'none'}, OpenCV {'found' if found else 'none'} in {ms:.0f} ms CPU"
        if found and image["found"]:
            ours = np.array([[d["x_px"], d["y_px"]] for d in image["discs"]])
            off = np.linalg.norm(ours[:, None] - points.reshape(1, -1, 2), axis=2).min(axis=1)
            words += f", {np.sqrt((off ** 2).mean()):.4f} px RMS apart"
        print(f"{image['path']}: {words}")


main()
