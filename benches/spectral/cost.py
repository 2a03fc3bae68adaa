#!/usr/bin/env python3
"""Compares the time and the noise of pictures by wavelength with those of pictures in RGB, in the same run.

    python3 benches/spectral/cost.py --petzval PATH

Prints a table: for each scene the median of the user CPU time and the mean of the variance over the pixels, by channel,
both divided by those of RGB. Needs numpy.
"""

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "scoreboard"))
import pictures  # noqa: E402

OFF = "-diffraction,-ghosts,-dispersion"
SETTINGS = ["--spp", "64", "--resolution", "150x100", "--threads", "1", "--light-paths", "off"]
SEEDS = 5


def render(petzval, scene, sign, seed, picture):
    """Returns the CPU time of a picture (s), and the picture."""
    before = os.times().children_user
    command = [petzval, "render", f"scenes/{scene}.pbrt", "-o", picture, "--seed", str(seed), *SETTINGS]
    done = subprocess.run([*command, f"--effects={sign}spectra,{OFF}"], stdin=subprocess.DEVNULL, capture_output=True, text=True)
    if done.returncode:
        sys.exit(done.stderr)
    return os.times().children_user - before, pictures.read(picture)


def main():
    parser = argparse.ArgumentParser(description="Compares the cost of spectra with RGB.")
    parser.add_argument("--petzval", default="target/release/petzval", help="petzval's program")
    options = parser.parse_args()
    print("| 64 samples, 150 x 100 pixels | time | variance: red | green | blue |\n|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for scene in ("snowman", "dgauss", "night", "atelier"):
            times, images = {"-": [], "+": []}, {"-": [], "+": []}
            for seed in range(SEEDS):
                for sign in "-+":
                    time, image = render(options.petzval, scene, sign, seed, Path(folder) / "picture.exr")
                    times[sign].append(time)
                    images[sign].append(image)
            slower = statistics.median(times["+"]) / statistics.median(times["-"])
            variance = {sign: np.var(np.stack(images[sign]), 0, ddof=1).mean((0, 1)) for sign in "-+"}
            noisier = " | ".join(f"{ratio:.2f}" for ratio in variance["+"] / variance["-"])
            print(f"| `{scene}` | {slower:.2f} | {noisier} |", flush=True)


if __name__ == "__main__":
    main()
