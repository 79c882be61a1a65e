"""Frames a second of OpenCV: decoding by its FFmpeg, pyramidal Lucas-Kanade forward and backward for three points, on one thread.

python opencv.py FILM X,Y X,Y X,Y
"""
import os
import sys
import time

os.environ["OPENCV_FFMPEG_CAPTURE_OPTIONS"] = "threads;1"
import cv2  # noqa: E402
import numpy as np  # noqa: E402

cv2.setNumThreads(1)
start = time.perf_counter()
film = cv2.VideoCapture(sys.argv[1])
points = np.array([[float(c) for c in place.split(",")] for place in sys.argv[2:]], np.float32).reshape(-1, 1, 2)
flow = dict(winSize=(21, 21), maxLevel=2)
before, frames = None, 0
while True:
    there, picture = film.read()
    if not there:
        break
    gray = cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)
    if before is not None:
        points, status, _ = cv2.calcOpticalFlowPyrLK(before, gray, points, None, **flow)
        back, _, _ = cv2.calcOpticalFlowPyrLK(gray, before, points, None, **flow)
    before, frames = gray, frames + 1
print(frames / (time.perf_counter() - start))
