"""Texture and edges that denoising leaves: dead leaves and a slanted edge through a lens, measured.

Usage: python python/benches/texture.py LENS [COMMAND]

Prints the responses of both at several frequencies, for pictures with and without noise and denoising. COMMAND is
the program, `petzval` without it.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

import petzval as pz
from petzval.denoise import denoised

CHART = "--film-size 36x24 --resolution 600x400 --focus 2m --fstop 8".split()
FREQUENCIES = [0.1, 0.2, 0.3, 0.4, 0.5]
# Name, samples, sensor, and whether the picture is denoised: before the sensor with guides, or after it without.
PICTURES = [
    ("256 samples", 256, None, False),
    ("4 samples", 4, None, False),
    ("4 samples, denoised", 4, None, True),
    ("ISO 1600, denoised", 64, "iso=1600,pixel=3", True),
    ("ISO 6400", 64, "iso=6400,pixel=3", False),
    ("ISO 6400, denoised", 64, "iso=6400,pixel=3", True),
]


def run(command, *words):
    """Run the program and return what it prints."""
    return subprocess.run([command, *words], capture_output=True, text=True, check=True).stdout


def write(path, pixels):
    """Write linear light as a PFM file."""
    height, width, _ = pixels.shape
    rows = np.ascontiguousarray(pixels[::-1], dtype="<f4")
    path.write_bytes(f"PF\n{width} {height}\n-1.0\n".encode() + rows.tobytes())


def photograph(scene, seed, samples, sensor, denoise):
    """Return the pixels of a picture."""
    guides = ["albedo", "normal"] if denoise and not sensor else []
    image = pz.render(scene, spp=samples, seed=seed, sensor=sensor, aov=guides, effects="-diffraction")
    if guides:
        image = image.denoise()
    pixels = np.asarray(image.pixels)
    return denoised(np.maximum(pixels, 0.0)) if denoise and sensor else pixels


def main():
    lens = sys.argv[1]
    command = sys.argv[2] if len(sys.argv) > 2 else "petzval"
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        scenes = {kind: folder / f"{kind}.pbrt" for kind in ("leaves", "edges")}
        printed = {kind: run(command, "chart", kind, lens, *CHART, "-o", str(scene)).split() for kind, scene in scenes.items()}
        leaves = printed["leaves"][printed["leaves"].index("--region") :]
        edge = printed["edges"][printed["edges"].index("--edge") :][:2]
        print(f"{'':22s}{'texture':40s}{'edge':40s}\n{'cycles/pixel':22s}" + 2 * "".join(f"{f:<8}" for f in FREQUENCIES))
        for name, *settings in PICTURES:
            files = [folder / "first.pfm", folder / "second.pfm", folder / "edge.pfm"]
            for file, kind, seed in zip(files, ("leaves", "leaves", "edges"), (1, 2, 1)):
                write(file, photograph(str(scenes[kind]), seed, *settings))
            first, second, slanted = map(str, files)
            texture = json.loads(run(command, "measure", "texture", first, "--second", second, *leaves, "--json"))
            edges = json.loads(run(command, "measure", slanted, *edge, "--json"))["edges"][0]
            row = f"{name:22s}"
            for response in (texture, edges):
                values = np.interp(FREQUENCIES, response["cycles_per_pixel"], response["response"])
                row += "".join(f"{value:<8.3f}" for value in values)
            print(row, flush=True)


if __name__ == "__main__":
    main()
