"""Error of pictures with and without denoising, against a picture of many samples.

Usage: python python/benches/denoise.py SCENE [FOLDER]

Prints the error by two metrics for several numbers of samples, and the time that denoising takes. FOLDER takes
the pictures, to look at them.
"""

import sys
import time
from pathlib import Path

import petzval as pz

REFERENCE = 2048
SETTINGS = dict(resolution=(300, 200), effects="-diffraction", aov=["albedo", "normal"])


def main():
    scene = pz.Scene(sys.argv[1])
    truth = pz.render(scene, spp=REFERENCE, seed=1, **SETTINGS)
    print(f"{'samples':>8s} {'noisy flip':>11s} {'denoised':>9s} {'noisy relmse':>13s} {'denoised':>9s} {'render s':>9s} {'denoise s':>10s}")
    for samples in (4, 16, 64, 256):
        start = time.perf_counter()
        noisy = pz.render(scene, spp=samples, seed=2, **SETTINGS)
        rendered = time.perf_counter()
        clean = noisy.denoise()
        ended = time.perf_counter()
        errors = [
            pz.compare(picture.pixels, truth.pixels, metric)
            for metric in ("flip", "relmse")
            for picture in (noisy, clean)
        ]
        print(
            f"{samples:8d} {errors[0]:11.4f} {errors[1]:9.4f} {errors[2]:13.5f} {errors[3]:9.5f}"
            f" {rendered - start:9.2f} {ended - rendered:10.2f}",
            flush=True,
        )
        if len(sys.argv) > 2:
            folder = Path(sys.argv[2])
            folder.mkdir(parents=True, exist_ok=True)
            for name, picture in [("noisy", noisy), ("denoised", clean), ("truth", truth)]:
                picture.save(folder / f"{name}{samples}.png", exposure="auto")


if __name__ == "__main__":
    main()
