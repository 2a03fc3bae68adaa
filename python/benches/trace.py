"""Rays through a lens by petzval in Python, by its kernel alone, and by optiland: the same rays.

Usage: python python/benches/trace.py [LENS]

Set RAYON_NUM_THREADS=1 for one thread. Rates are per second of CPU time, medians of runs that take turns.
"""

import statistics
import sys
import time
from pathlib import Path

import numpy as np

import petzval as pz

COUNT = 4_000_000
RUNS = 7


def rays(lens, count):
    """Return rays parallel to the axis up to 2 degrees, over the middle of the front element."""
    random = np.random.default_rng(1)
    reach = 0.2 * lens.surfaces[0]["diameter"]
    points = np.zeros((3, count), dtype=np.float32)
    points[:2] = random.uniform(-reach, reach, (2, count))
    points[2] = -5
    directions = np.ones((3, count), dtype=np.float32)
    directions[:2] = random.uniform(-0.03, 0.03, (2, count))
    return points, directions


def optiland_trace(lens):
    """Return a function that traces the same rays by optiland, or None."""
    try:
        from optiland.optic import Optic
        from optiland.rays import RealRays
    except ImportError:
        return None
    optic = Optic()
    optic.add_surface(index=0, thickness=np.inf)
    from optiland.materials import IdealMaterial

    for number, surface in enumerate(lens.surfaces, start=1):
        optic.add_surface(
            index=number,
            radius=surface["radius"],
            thickness=surface["thickness"],
            material=IdealMaterial(n=surface["index"]),
            is_stop=surface["stop"],
            aperture=surface["diameter"],
        )
    optic.add_surface(index=len(lens.surfaces) + 1)
    optic.set_aperture(aperture_type="EPD", value=10)
    optic.set_field_type(field_type="angle")
    optic.add_field(y=0)
    optic.add_wavelength(value=0.5876, is_primary=True)

    def trace(points, directions):
        unit = directions / np.linalg.norm(directions, axis=0)
        ones = np.ones(points.shape[1])
        traced = RealRays(*points.astype(float), *unit.astype(float), ones, 0.5876 * ones)
        optic.surfaces.trace(traced)
        return traced

    return trace


def main():
    lens = pz.Lens(sys.argv[1] if len(sys.argv) > 1 else "lenses/dgauss.50mm.dat")
    points, directions = rays(lens, COUNT)
    out = lens.trace(points, directions)
    ways = {
        "petzval, out": (COUNT, lambda: lens.trace(points, directions, out=out)),
        "petzval": (COUNT, lambda: lens.trace(points, directions)),
    }
    other = optiland_trace(lens)
    if other is not None:
        few = COUNT // 20
        ways["optiland"] = (few, lambda: other(points[:, :few], directions[:, :few]))
    times = {name: [] for name in ways}
    kernel = []
    for _ in range(RUNS):
        kernel.append(lens._kernel_seconds(points, directions))
        for name, (_, run) in ways.items():
            start = time.process_time()
            run()
            times[name].append(time.process_time() - start)
    if other is not None:
        theirs, ours = other(points[:, :few], directions[:, :few]), out[1][:, :few]
        both = (out[2][:few] == 0) & np.isfinite(theirs.L)
        apart = np.hypot(theirs.L - ours[0], theirs.M - ours[1])[both].max()
        print(f"largest difference of directions: {apart:.1e}, over {both.sum()} rays")
    print(f"{'kernel':14s} {COUNT / statistics.median(kernel) / 1e6:8.2f} million rays/s on one thread")
    for name, (count, _) in ways.items():
        print(f"{name:14s} {count / statistics.median(times[name]) / 1e6:8.2f} million rays/s of CPU time")


if __name__ == "__main__":
    if not Path("lenses").is_dir():
        sys.exit("run it in the folder of the repository")
    main()
