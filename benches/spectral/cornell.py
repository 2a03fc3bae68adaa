#!/usr/bin/env python3
"""Compares raw values of the greys of a chart in a Cornell box with those of a real phone, by channel.

    python3 benches/spectral/cornell.py --petzval PATH

Renders scenes/cornell.pbrt with the chart at three places, by wavelength and in RGB, as a mosaic of the phone's raw
channels without noise, and prints ratios of the means of patches beside the measured ones. Needs numpy.

The raw pictures of Lyu, Goossens, Farrell and Wandell (arXiv:2201.07411) are not in their repository,
github.com/ISET/isetcornellbox, but its page papers/IEEE_2022/Figure_09.html plots a line of their digital values through
the greys. MEASURED has the middles of the marks of each patch, less the black level of 64: read from the plots, whose
pixels are PIXEL digital values high. The three brightest greys are read, as the marks of the others overlap.
"""

import argparse
import math
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "benches/scoreboard"))
import pictures  # noqa: E402

# By the shift of the chart (m): digital values of red, green and blue of the greys.
MEASURED = {
    -0.1: [(182.0, 206.4, 61.5), (133.5, 152.7, 45.1), (84.1, 103.5, 30.6)],
    0.0: [(337.9, 422.3, 125.5), (216.2, 275.2, 81.7), (131.9, 167.8, 51.4)],
    0.1: [(283.0, 375.7, 111.3), (168.6, 230.1, 69.4), (94.2, 129.2, 38.6)],
}
PIXEL = {-0.1: 0.74, 0.0: 1.47, 0.1: 1.33}
PLACES = {-0.1: "left, at the red wall", 0.0: "middle", 0.1: "right, at the green wall"}
# Corners of regions of the back and side walls (m), and red and blue over green there: spectral radiance of
# data/raw/11-Dec-2020/cbox-{whitebackwall,redbackwall,green-backwall}-1.mat times the response of the phone. Where in the
# box the papers were measured is not said.
WALLS = {
    "white": ([(-0.05, 0.12, 0.15), (0.05, 0.2, 0.15)], (0.759, 1, 0.291)),
    "red": ([(-0.15, 0.1, 0), (-0.15, 0.2, 0.1)], (2.013, 1, 0.217)),
    "green": ([(0.15, 0.1, 0), (0.15, 0.2, 0.1)], (0.358, 1, 0.240)),
}
GREYS = ["white", "neutral 8", "neutral 6.5"]
SIZE = (1008, 756)
# A sensor without noise, so that codes are the light of the channels.
RAW = ["--bayer", "rggb", "--sensor", "iso=100,well=1e12,read=0,bits=16,black=0"]


def numbers(text):
    return [float(word) for word in text.split()]


def patches():
    """Returns the corners of the greys in the frame of the chart's place, from the file of the chart."""
    text = (ROOT / "scenes/cornell/chart.pbrt").read_text()
    place = np.eye(4)
    for word, values in re.findall(r"^(Translate|Rotate) (.*)$", text, re.M):
        step, v = np.eye(4), numbers(values)
        if word == "Translate":
            step[:3, 3] = v
        else:
            axis = v[1:].index(1.0)
            i, j = (axis + 1) % 3, (axis + 2) % 3
            c, s = math.cos(math.radians(v[0])), math.sin(math.radians(v[0]))
            step[i, i], step[i, j], step[j, i], step[j, j] = c, -s, s, c
        place = place @ step
    meshes = [np.reshape(numbers(points), (4, 3)) for points in re.findall(r"P\" \[(.*)\]", text)]
    return [mesh @ place[:3, :3].T + place[:3, 3] for mesh in meshes[1:]]


def projected(points, scene):
    """Returns the places of points in the picture (pixels), by the camera of a scene's text."""
    look = numbers(re.search(r"LookAt (.*)", scene).group(1))
    fov = float(re.search(r'"float fov" (\S+)', scene).group(1).rstrip("]"))
    eye, target, up = (np.array(look[i : i + 3]) for i in (0, 3, 6))
    forward = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(up, forward)
    right /= np.linalg.norm(right)
    local = (points - eye) @ np.stack([right, np.cross(forward, right), forward]).T
    scale = SIZE[1] / 2 / math.tan(math.radians(fov) / 2)
    return np.stack([SIZE[0] / 2 + scale * local[:, 0] / local[:, 2], SIZE[1] / 2 - scale * local[:, 1] / local[:, 2]], 1)


def regions(shift, scene):
    """Returns the corners (pixels) of the greys of a chart at a place, and of the WALLS, without a fifth on every side."""
    greys = [corners + [shift, 0, 0] for corners in patches()[: len(GREYS)]]
    boxes = []
    for corners in greys + [np.array(corners) for corners, _ in WALLS.values()]:
        pixels = projected(corners, scene)
        low, high = pixels.min(0), pixels.max(0)
        inset = 0.2 * (high - low)
        boxes.append((np.ceil(low + inset).astype(int), np.floor(high - inset).astype(int)))
    return boxes


def means(petzval, shift, effects, options, folder):
    """Returns the raw means of the greys with a chart at a place, and of the WALLS, with their standard errors."""
    scene = (ROOT / "scenes/cornell.pbrt").read_text()
    found = regions(shift, scene)
    (folder / "scene.pbrt").write_text(scene.replace("Translate 0 0 0", f"Translate {shift} 0 0"))
    values = []
    # Walls are larger than greys.
    parts = [(found[: len(GREYS)], options.spp), *(([wall], options.spp // 16) for wall in found[len(GREYS) :])]
    for part, spp in parts:
        low, high = np.min([box[0] for box in part], 0), np.max([box[1] for box in part], 0)
        low -= low % 2
        command = [petzval, "render", "scene.pbrt", "-o", "raw.exr", "--spp", str(spp), f"--effects={effects}", *RAW]
        window = ["--resolution", "{}x{}".format(*SIZE), "--crop", "{},{},{},{}".format(*low, *high)]
        done = subprocess.run([*command, *window], stdin=subprocess.DEVNULL, capture_output=True, text=True, cwd=folder)
        if done.returncode:
            sys.exit(done.stderr)
        raw = pictures.read(folder / "raw.exr")[:, :, 0]
        for first, end in part:
            (x0, y0), (x1, y1) = first - low, end - low
            rows, columns = np.mgrid[y0:y1, x0:x1]
            region, channel = raw[y0:y1, x0:x1], rows % 2 + columns % 2
            groups = [region[channel == c] for c in range(3)]
            values.append([(group.mean(), group.std() / math.sqrt(group.size)) for group in groups])
    return np.array(values)


def summary(name, found, measured):
    """Prints how far ratios are from the measured ones."""
    off = 100 * (np.array(found) / np.array(measured) - 1)
    print(f"{name}: mean {off.mean():+.1f} %, root mean square {np.sqrt(np.mean(off**2)):.1f} %, largest {np.abs(off).max():.1f} %")


def main():
    parser = argparse.ArgumentParser(description="Compares a Cornell box with raw pictures of a real one.")
    parser.add_argument("--petzval", default="target/release/petzval", help="petzval's program")
    parser.add_argument("--spp", type=int, default=2048, help="samples per pixel")
    parser.add_argument("--lamp", default=str(ROOT / "scenes/cornell/lamp.spd"), help="file of the lamp's spectrum")
    options = parser.parse_args()
    petzval = str(Path(options.petzval).resolve())
    print("| chart | patch | R/G measured | spectra | RGB | B/G measured | spectra | RGB | R, G, B to white measured | spectra |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    ratios, noise, reading = {}, 0, 0
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        shutil.copytree(ROOT / "scenes/cornell", folder / "cornell")
        shutil.copy(options.lamp, folder / "cornell/lamp.spd")
        for shift, measured in MEASURED.items():
            found = [means(petzval, shift, sign + "spectra", options, folder) for sign in "+-"]
            noise = max(noise, *((f[..., 1] / f[..., 0]).max() for f in found))
            reading = max(reading, PIXEL[shift] / np.min(measured))
            all_values = [np.array(measured), *(values[: len(GREYS), :, 0] for values in found)]
            for i, grey in enumerate(GREYS):
                cells = [PLACES[shift] if i == 0 else "", grey]
                for channel, name in ((0, "R/G"), (2, "B/G")):
                    row = [values[i, channel] / values[i, 1] for values in all_values]
                    ratios.setdefault(name, []).append(row)
                    cells += [f"{value:.3f}" for value in row]
                to_white = [values[i] / values[0] for values in all_values[:2]]
                if i:
                    ratios.setdefault("to white", []).extend(zip(*to_white))
                cells += [" ".join(f"{value:.3f}" for value in row) if i else "" for row in to_white]
                print(f"| {' | '.join(cells)} |", flush=True)
            if shift == 0:
                walls = [values[len(GREYS) :, :, 0] for values in found]
    for i, (name, (_, measured)) in enumerate(WALLS.items()):
        values = [measured, *(wall[i] / wall[i, 1] for wall in walls)]
        cells = [f"{value[channel]:.3f}" for channel in (0, 2) for value in values]
        print(f"| {'no chart, spectroradiometer' if i == 0 else ''} | {name} paper | {' | '.join(cells)} | | |")
    print()
    for name, rows in ratios.items():
        measured, spectra, *rgb = zip(*rows)
        summary(f"{name}, spectra", spectra, measured)
        if rgb:
            summary(f"{name}, RGB", rgb[0], measured)
    print(f"One pixel of the plots is at most {100 * reading:.1f} % of a value, the noise of a mean {100 * noise:.1f} %.")


if __name__ == "__main__":
    main()
