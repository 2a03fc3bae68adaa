#!/usr/bin/env python3
"""Compares the spectra of spectral films of petzval, bucket by bucket, with those of pbrt-v4.

    python3 benches/spectral/buckets.py --pbrt PATH --petzval PATH

Prints a table: for each scene the difference of the means of pictures that is the largest, of the brightest bucket, and the
largest difference of two pictures of pbrt. Buckets are those of a film that does not say which, without the first and the
last two, where lamps of the F series end in one program and go on in the other. Needs numpy.
"""

import argparse
import sys
import tempfile
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))
from colours import HEAD, SCENES, pictures, run  # noqa: E402

FILM = HEAD.replace('"rgb"', '"spectral" "bool savefp16" false')
NAMES = [
    "copper, sky of RGB 0.1 0.3 1",
    "red pigment, 2700 K",
    "red pigment, lamp F2",
    "green pigment, lamp F11",
    "ball of glass F11 before orange",
]


def spectrum(path):
    return pictures.read_exr(path, spectra=True).mean((0, 1))[1:-2]


def main():
    parser = argparse.ArgumentParser(description="Compares spectra with those of pbrt-v4.")
    parser.add_argument("--pbrt", default="pbrt", help="pbrt-v4's program")
    parser.add_argument("--petzval", default="target/release/petzval", help="petzval's program")
    options = parser.parse_args()
    print("| scene | largest difference, of the brightest bucket | noise |\n|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for number, name in enumerate(NAMES):
            text, depth = SCENES[name]
            scene = Path(folder) / f"{number}.pbrt"
            scene.write_text(FILM % (1024, depth) + text)
            theirs = []
            for seed in range(2):
                picture = scene.with_suffix(f".{seed}.exr")
                run(options.pbrt, "--quiet", "--seed", str(seed), "--outfile", picture, scene)
                theirs.append(spectrum(picture))
            picture = scene.with_suffix(".petzval.exr")
            run(options.petzval, "render", scene, "-o", picture)
            ours, mean = spectrum(picture), np.mean(theirs, 0)
            off, noise = (np.abs(a - b).max() / mean.max() for a, b in ((ours, mean), theirs))
            print(f"| {name} | {100 * off:.2f} % | {100 * noise:.2f} % |", flush=True)


if __name__ == "__main__":
    main()
