#!/usr/bin/env python3
"""Photographs a checkerboard with petzval, calibrates the pictures with OpenCV, and compares.

usage: checkerboard.py PETZVAL LENS FOLDER

Needs opencv-python-headless, numpy and OpenEXR. Ends with exit code 1 if the camera matrices differ
by more than 0.1 pixels or the distortion by more than 0.05 pixels.
"""

import json
import math
import subprocess
import sys

import cv2
import numpy as np
import OpenEXR

WIDTH, HEIGHT = 480, 320
SENSOR = (36.0, 24.0)
FOCUS = 2.0
F_NUMBER = 8
SAMPLES = 128
COLUMNS, ROWS = 12, 8  # inner corners
SQUARE = 75.0  # mm
MARGIN = 14  # pixels around all corners
# Rotations of the board (degrees about x, y and z), and the corner of the picture it moves to. The
# more it leans, the better perspective tells the focal length from the distance.
POSES = [
    ((0, 40, 0), (1, 0)), ((0, -40, 0), (-1, 0)), ((40, 0, 0), (0, 1)), ((-40, 0, 0), (0, -1)),
    ((30, 35, 45), (1, 1)), ((-30, 35, -45), (1, -1)), ((30, -35, -45), (-1, 1)),
    ((-30, -35, 45), (-1, -1)), ((0, 40, 90), (-1, 0)), ((0, -40, 90), (1, 0)),
    ((40, 0, 90), (0, -1)), ((-40, 0, 90), (0, 1)), ((0, 0, 0), (0, 0)), ((0, 0, 0), (1, 1)),
    ((0, 0, 0), (-1, -1)),
]


def run(petzval, *arguments):
    command = [petzval, *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{' '.join(command)}\n{done.stderr}")
    return done.stdout


def rotation(angles):
    x, y, z = (cv2.Rodrigues(np.radians(a) * np.eye(3)[i])[0] for i, a in enumerate(angles))
    return x @ y @ z


def corners():
    grid = np.mgrid[0:COLUMNS, 0:ROWS].T.reshape(-1, 2)
    middle = np.array([COLUMNS - 1, ROWS - 1]) / 2
    return np.hstack([(grid - middle) * SQUARE, np.zeros((len(grid), 1))])


def place(angles, towards, shows):
    """The rotation of a pose, and the nearest centre (mm, in OpenCV's axes from the film) whose
    corners are all in the picture. `shows` gives the pixels of points."""
    turn = rotation(angles)
    for depth in (1.9, 2.1, 2.3, 2.5, 2.7):
        for share in np.linspace(1, 0, 21):
            half = share * depth * 1e3 * np.array(SENSOR) / 100
            centre = np.array([towards[0] * half[0], towards[1] * half[1], depth * 1e3])
            pixels = shows(corners() @ turn.T + centre)
            if (pixels > MARGIN).all() and (pixels < np.array([WIDTH, HEIGHT]) - MARGIN).all():
                return turn, centre
    sys.exit(f"no place for the board turned by {angles}")


def board(turn, centre):
    """The white squares and a white margin, as a mesh of pbrt."""
    points, faces = [], []

    def square(x0, y0, x1, y1):
        first = len(points)
        for x, y in ((x0, y0), (x1, y0), (x1, y1), (x0, y1)):
            p = turn @ np.array([x * SQUARE, y * SQUARE, 0]) + centre
            # pbrt's camera looks along z with y up; units are metres.
            points.append((p[0] / 1e3, -p[1] / 1e3, p[2] / 1e3))
        faces.extend((first, first + 1, first + 2, first, first + 2, first + 3))

    low = (-(COLUMNS + 1) / 2, -(ROWS + 1) / 2)
    for i in range(COLUMNS + 1):
        for j in range(ROWS + 1):
            if (i + j) % 2 == 0:
                square(low[0] + i, low[1] + j, low[0] + i + 1, low[1] + j + 1)
    x0, y0, x1, y1 = low[0], low[1], -low[0], -low[1]
    margin = 1.0
    square(x0 - margin, y0 - margin, x1 + margin, y0)
    square(x0 - margin, y1, x1 + margin, y1 + margin)
    square(x0 - margin, y0, x0, y1)
    square(x1, y0, x1 + margin, y1)
    numbers = " ".join(f"{v:.9g}" for p in points for v in p)
    indices = " ".join(map(str, faces))
    return f'Shape "trianglemesh" "point3 P" [{numbers}] "integer indices" [{indices}]'


def scene(lens, turn, centre):
    return f"""
Film "rgb" "integer xresolution" {WIDTH} "integer yresolution" {HEIGHT}
    "float diagonal" {math.hypot(*SENSOR):.9f}
Sampler "sobol" "integer pixelsamples" {SAMPLES}
Integrator "path" "integer maxdepth" 0
Camera "realistic" "string lensfile" "{lens}" "float aperturediameter" 100
    "float focusdistance" {FOCUS}
WorldBegin
AreaLightSource "diffuse" "rgb L" [1 1 1] "bool twosided" true
{board(turn, centre)}
"""


def photograph(petzval, folder, name, text):
    path, picture = f"{folder}/{name}.pbrt", f"{folder}/{name}.exr"
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
    run(petzval, "render", path, "--fstop", F_NUMBER, "--effects", "none", "-o", picture)
    with OpenEXR.File(picture) as file:
        channels = file.channels()
        image = channels["RGB"].pixels if "RGB" in channels else channels["G"].pixels
        header = dict(file.header())
    image = np.asarray(image, np.float32)
    return (image[..., 1] if image.ndim == 3 else image), header


def find(image):
    """Corners of the board, or None, by OpenCV and then as saddle points."""
    light = image / np.percentile(image, 98)
    grey = np.clip(255 * np.sqrt(np.clip(light, 0, 1)), 0, 255).astype(np.uint8)
    found, points = cv2.findChessboardCorners(grey, (COLUMNS, ROWS))
    return saddles(light.astype(float), points.reshape(-1, 2)) if found else None


def saddles(image, points, sigma=2.0, half=8):
    """Saddle points of the image, smoothed by a Gaussian. Light around a corner of four straight
    squares is symmetric about it, so that the saddle is at the corner; cornerSubPix is off by some
    hundredths of a pixel, depending on where the corner is in its pixel."""
    refined = []
    for x, y in points:
        for _ in range(8):
            column, row = int(round(x)), int(round(y))
            part = image[row - half:row + half + 1, column - half:column + half + 1]
            u = np.arange(column - half, column + half + 1) - x
            v = np.arange(row - half, row + half + 1) - y
            # A Gaussian and its first and second derivatives, along both axes.
            (u0, u1, u2), (v0, v1, v2) = (
                (g, t / sigma**2 * g, (t**2 / sigma**4 - 1 / sigma**2) * g)
                for t, g in ((t, np.exp(-t**2 / (2 * sigma**2))) for t in (u, v)))
            slope = np.array([v0 @ part @ u1, v1 @ part @ u0])
            bend = np.array([[v0 @ part @ u2, v1 @ part @ u1], [v1 @ part @ u1, v2 @ part @ u0]])
            step = np.clip(-np.linalg.solve(bend, slope), -1, 1)
            x, y = x + step[0], y + step[1]
        refined.append((x, y))
    return np.array(refined)


def project(matrix, coefficients, points):
    """Pixels of points in the frame of the centre of projection."""
    pixels, _ = cv2.projectPoints(
        points.reshape(-1, 1, 3), np.zeros(3), np.zeros(3), matrix, coefficients)
    return pixels.reshape(-1, 2)


def main():
    petzval, lens, folder = sys.argv[1:4]
    run(petzval, "lens", "calibrate", lens, "--film-size", "x".join(map(str, SENSOR)),
        "--resolution", f"{WIDTH}x{HEIGHT}", "--focus", f"{FOCUS}m", "--fstop", F_NUMBER,
        "-o", f"{folder}/cal")
    exported = cv2.FileStorage(f"{folder}/cal/opencv_brown_conrady.yaml", cv2.FILE_STORAGE_READ)
    matrix = exported.getNode("camera_matrix").mat()
    distortion = exported.getNode("distortion_coefficients").mat().ravel()
    centre = exported.getNode("projection_centre").mat().ravel()
    with open(f"{folder}/cal/calibration.json", encoding="utf-8") as file:
        described = json.load(file)
    assert np.allclose(described["projection_centre"]["position"], centre)

    def shows(points):
        return project(matrix, distortion, points - centre)

    seen, placed, misses = [], [], []
    for i, (angles, towards) in enumerate(POSES):
        turn, position = place(angles, towards, shows)
        text = scene(lens, turn, position)
        image, header = photograph(petzval, folder, f"view{i}", text)
        points = find(image)
        if points is None:
            print(f"view {i}: OpenCV finds no board")
            continue
        # Where the exported model shows the corners of the known pose; the board looks the same
        # after half a turn.
        expected = shows(corners() @ turn.T + position)
        if np.abs(points - expected).max() > np.abs(points[::-1] - expected).max():
            points = points[::-1]
        misses.append(points - expected)
        seen.append(points.astype(np.float32).reshape(-1, 1, 2))
        placed.append(corners().astype(np.float32))
    misses = np.vstack(misses)
    length = np.linalg.norm(misses, axis=1)
    print(f"{len(seen)} views, {len(length)} corners; known poses: error max {length.max():.4f}, "
          f"rms {np.sqrt((length ** 2).mean()):.4f}, mean {misses.mean(axis=0).round(4)} pixels")

    rms, found, k, *_ = cv2.calibrateCamera(placed, seen, (WIDTH, HEIGHT), None, None)
    k = k.ravel()[:5]
    off = np.abs(found - matrix)
    print(f"exported K  {matrix[0, 0]:.4f} {matrix[1, 1]:.4f} {matrix[0, 2]:.4f} {matrix[1, 2]:.4f}")
    print(f"OpenCV's K  {found[0, 0]:.4f} {found[1, 1]:.4f} {found[0, 2]:.4f} {found[1, 2]:.4f}"
          f"  (reprojection error {rms:.4f})")
    print(f"exported distortion  {distortion}")
    print(f"OpenCV's distortion  {k}")
    # Distortion over the frame: how far either moves the point that a pinhole shows.
    x, y = np.meshgrid(np.arange(0, WIDTH, 8.0), np.arange(0, HEIGHT, 8.0))
    rays = np.stack([(x - matrix[0, 2]) / matrix[0, 0], (y - matrix[1, 2]) / matrix[1, 1],
                     np.ones_like(x)], axis=-1).reshape(-1, 3)
    moved = project(matrix, distortion, rays) - project(matrix, k, rays)
    worst = np.linalg.norm(moved, axis=1).max()
    print(f"largest difference: K {off.max():.4f}, distortion {worst:.4f} pixels")
    attribute = header.get("cameraMatrix")
    print(f"attribute of the EXR: {attribute}")
    same = np.allclose(np.array(attribute.split(), float).reshape(3, 3), matrix, atol=1e-6)
    if len(seen) < 10 or off.max() > 0.1 or worst > 0.05 or length.max() > 0.06 or not same:
        sys.exit("the calibrations differ")


if __name__ == "__main__":
    main()
