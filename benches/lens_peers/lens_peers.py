#!/usr/bin/env python3
"""Compares lenses with rayoptics and optiland: focal length, back focal distance, real rays.

    python3 -m venv venv && venv/bin/pip install rayoptics optiland
    venv/bin/python benches/lens_peers/lens_peers.py LENS...
    venv/bin/python benches/lens_peers/lens_peers.py --speed LENS...

Every lens is read by petzval (`petzval lens LENS --json`); both peers get the same radii, conics,
aspheres, thicknesses and indices. optiland traces rays from the scene to the film. petzval traces
them back (`petzval lens trace --precision f64`), and must return to where they started. Lenses with
tilts, cylinders, toroids, mirrors or odd powers are left out, which is said.
Exit code 1 if a difference exceeds 1e-9 mm, or 1e-9 of a focal length.

`--speed` prints rays a CPU second instead, in f64: rayoptics one ray at a time, optiland all
rays in NumPy arrays, and `petzval lens trace` as a whole process that reads and writes a CSV. All
trace the same rays. A last line repeats the kernels alone, from `petzval bench`.
"""

import argparse
import json
import math
import resource
import subprocess
import sys
import tempfile
import time
import warnings
from pathlib import Path

import numpy as np

warnings.filterwarnings("ignore")
TOLERANCE = 1e-9
RAYS = 400
# Plane on which rays start, before the front vertex (mm).
START_Z = -10.0
# Rays of a measurement of speed: rayoptics is given a part of them.
SPEED_RAYS = 200_000
SLOW_RAYS = 2_000


def even_terms(row):
    """Coefficients of r^2, r^4, ... of a row; None if it has odd powers."""
    if any(power % 2 for power, _ in row["asphere"]):
        return None
    terms = dict(row["asphere"])
    return [terms.get(power, 0.0) for power in range(2, 2 + 2 * ((max(terms, default=0)) // 2), 2)]


def reason_to_skip(lens):
    if not lens["aligned"]:
        return "tilts or decentres"
    for row in lens["surfaces"]:
        if row["axis"] or row["radius_x"]:
            return "cylinders or toroids"
        if row["mirror"]:
            return "mirrors"
        if even_terms(row) is None:
            return "odd powers"
    if lens["focal_length"] is None or (lens["film_distance"] or -1.0) <= 0.0:
        return "no image behind the lens"
    return None


def optiland_lens(lens):
    from optiland.materials import IdealMaterial
    from optiland.optic import Optic

    optic = Optic()
    add = optic.surfaces.add if hasattr(optic, "surfaces") and hasattr(optic.surfaces, "add") else optic.add_surface
    add(index=0, thickness=np.inf)
    for i, row in enumerate(lens["surfaces"]):
        last = i + 1 == len(lens["surfaces"])
        thickness = lens["film_distance"] if last else row["thickness"]
        terms = even_terms(row)
        add(
            index=i + 1,
            surface_type="even_asphere" if terms else "standard",
            radius=math.inf if row["radius"] is None else row["radius"],
            conic=row["conic"],
            thickness=thickness,
            material=IdealMaterial(n=row["index"]),
            is_stop=row["stop"],
            **({"coefficients": terms, "tol": 1e-14, "max_iter": 200} if terms else {}),
        )
    add(index=len(lens["surfaces"]) + 1)
    optic.set_aperture(aperture_type="EPD", value=lens["entrance_pupil"]["diameter"])
    optic.set_field_type(field_type="angle")
    optic.add_field(y=0)
    optic.add_wavelength(value=lens["wavelength"] / 1000.0, is_primary=True)
    return optic


def rayoptics_model(lens):
    from rayoptics.environment import OpticalModel, PupilSpec, FieldSpec, WvlSpec

    model = OpticalModel()
    sequence, spec = model["seq_model"], model["optical_spec"]
    spec["pupil"] = PupilSpec(spec, key=["object", "epd"], value=lens["entrance_pupil"]["diameter"])
    spec["fov"] = FieldSpec(spec, key=["object", "angle"], value=0.0, flds=[0.0])
    spec["wvls"] = WvlSpec([(lens["wavelength"], 1.0)], ref_wl=0)
    model.radius_mode = False
    sequence.gaps[0].thi = 1e10
    for i, row in enumerate(lens["surfaces"]):
        last = i + 1 == len(lens["surfaces"])
        thickness = lens["film_distance"] if last else row["thickness"]
        terms = even_terms(row)
        curvature = 0.0 if row["radius"] is None else 1.0 / row["radius"]
        # An r^2 term has the power of a curvature, which rayoptics' first order leaves out.
        sequence.add_surface([curvature, thickness, row["index"]])
        if row["conic"] or terms:
            from rayoptics.elem.profiles import EvenPolynomial

            sequence.ifcs[sequence.cur_surface].profile = EvenPolynomial(
                c=curvature, cc=row["conic"], coefs=terms or [0.0]
            )
        if row["stop"]:
            sequence.set_stop()
    model.update_model()
    return model


def starts(lens, random, count):
    """Rays before the lens: x, y, slopes, and the length of the direction's z."""
    entrance = lens["entrance_pupil"]
    # Angles up to 10 degrees through the inner 0.8 of the entrance pupil.
    radius = 0.4 * entrance["diameter"] * np.sqrt(random.random(count))
    turn = 2 * np.pi * random.random(count)
    slope = np.tan(np.radians(10.0 * (random.random((2, count)) - 0.5)))
    run = entrance["position"] - START_Z
    x = radius * np.cos(turn) - slope[0] * run
    y = radius * np.sin(turn) - slope[1] * run
    return x, y, slope, 1.0 / np.sqrt(1.0 + slope[0] ** 2 + slope[1] ** 2)


def optiland_trace(lens, optic, x, y, slope, norm):
    """Rays of optiland on the film, and its CPU time (s)."""
    from optiland.rays import RealRays

    count = len(x)
    wavelength = np.full(count, lens["wavelength"] / 1000.0)
    rays = RealRays(x, y, np.full(count, START_Z), slope[0] * norm, slope[1] * norm, norm, np.ones(count), wavelength)
    group = optic.surfaces if hasattr(optic, "surfaces") and hasattr(optic.surfaces, "trace") else optic.surface_group
    begun = time.process_time()
    group.trace(rays)
    return rays, time.process_time() - begun


def write_reversed(file, lens, ends):
    """Writes rays that end on the film as rays that start there."""
    length = lens["length"] + lens["film_distance"]
    rows = [
        f"{e[0]!r},{e[1]!r},{length!r},{-e[3]!r},{-e[4]!r},{-e[5]!r},{lens['wavelength']!r}" for e in ends.tolist()
    ]
    file.write_text("\n".join(rows) + "\n")


def petzval_trace(petzval, path, file):
    """Output of `petzval lens trace`, and its CPU time (s)."""
    command = [petzval, "lens", "trace", path, "--rays", str(file), "--precision", "f64"]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    output = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return output, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def real_rays(petzval, path, lens, optic, random):
    """Largest distance (mm) of rays that come back, and their number."""
    x, y, slope, norm = starts(lens, random, RAYS)
    rays, _ = optiland_trace(lens, optic, x, y, slope, norm)
    ends = np.array([rays.x, rays.y, rays.z, rays.L, rays.M, rays.N]).T
    finite = np.isfinite(ends).all(axis=1)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "rays.csv")
        write_reversed(file, lens, ends[finite])
        output, _ = petzval_trace(petzval, path, file)
    worst, returned = 0.0, 0
    for line, i in zip(output.splitlines(), np.flatnonzero(finite)):
        words = line.split(",")
        try:
            px, py, pz, dx, dy, dz = (float(word) for word in words[:6])
        except ValueError:
            continue  # cut by a rim
        if not math.isfinite(px):
            continue
        along = (START_Z - pz) / dz
        worst = max(worst, math.hypot(px + along * dx - x[i], py + along * dy - y[i]))
        returned += 1
    return worst, returned


def speeds(petzval, path, lens, random):
    """Rays a second of rayoptics, optiland and `petzval lens trace`, which trace the same rays."""
    from rayoptics.raytr import raytrace

    x, y, slope, norm = starts(lens, random, SPEED_RAYS)
    model = rayoptics_model(lens)
    sequence = model["seq_model"]
    sequence.gaps[0].thi = -START_Z
    model.update_model()
    begun = time.process_time()
    for i in range(SLOW_RAYS):
        try:
            direction = np.array([slope[0][i], slope[1][i], 1.0]) * norm[i]
            raytrace.trace(sequence, np.array([x[i], y[i], 0.0]), direction, lens["wavelength"])
        except Exception:  # total reflection, or a miss
            pass
    rayoptics = SLOW_RAYS / (time.process_time() - begun)
    optic = optiland_lens(lens)
    optiland_trace(lens, optic, x, y, slope, norm)
    rays, seconds = optiland_trace(lens, optic, x, y, slope, norm)
    ends = np.array([rays.x, rays.y, rays.z, rays.L, rays.M, rays.N]).T
    ends = ends[np.isfinite(ends).all(axis=1)]
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "rays.csv")
        write_reversed(file, lens, ends)
        _, ours = petzval_trace(petzval, path, file)
    return rayoptics, SPEED_RAYS / seconds, len(ends) / ours


def speed_table(arguments, random):
    print(f"{'million rays a CPU second, f64':44} {'surfaces':>8} {'rayoptics':>9} {'optiland':>9} {'petzval':>9}")
    for path in arguments.lenses:
        run = subprocess.run([arguments.petzval, "lens", path, "--json"], capture_output=True, text=True)
        name = Path(path).name[-44:]
        lens = json.loads(run.stdout) if run.returncode == 0 else None
        skip = reason_to_skip(lens) if lens else "not read"
        if skip:
            print(f"{name:44} left out: {skip}")
            continue
        try:
            rates = speeds(arguments.petzval, path, lens, random)
        except Exception as error:  # a peer's own failure is not ours
            print(f"{name:44} a peer failed: {type(error).__name__}: {str(error)[:70]}")
            continue
        cells = " ".join(f"{rate / 1e6:9.4f}" for rate in rates)
        print(f"{name:44} {len(lens['surfaces']):8} {cells}")
    run = subprocess.run([arguments.petzval, "bench", "--json"], capture_output=True, text=True, check=True)
    kernels = {row["name"]: row["value"] for row in json.loads(run.stdout)}
    for precision in ["f64", "f32x8"]:
        rate = kernels[f"lens.trace.dgauss.{precision}"]
        print(f"petzval's kernel alone, lenses/dgauss.50mm.dat, {precision}: {rate:.1f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("lenses", nargs="+")
    parser.add_argument("--petzval", default="target/release/petzval")
    parser.add_argument("--speed", action="store_true", help="rays a second instead of differences")
    arguments = parser.parse_args()
    random = np.random.default_rng(1)
    if arguments.speed:
        speed_table(arguments, random)
        return
    print(f"{'lens':44} {'EFL':>10} {'rayoptics':>9} {'optiland':>9} {'BFD':>9} {'rays':>5} {'apart mm':>9}")
    bad = 0
    for path in arguments.lenses:
        run = subprocess.run([arguments.petzval, "lens", path, "--json"], capture_output=True, text=True)
        name = Path(path).name[-44:]
        if run.returncode:
            print(f"{name:44} not read: {run.stderr.strip().splitlines()[-1][:80]}")
            continue
        lens = json.loads(run.stdout)
        skip = reason_to_skip(lens)
        if skip:
            print(f"{name:44} left out: {skip}")
            continue
        efl, bfd = lens["focal_length"], lens["back_focal_distance"]
        try:
            optic = optiland_lens(lens)
            first = rayoptics_model(lens)["analysis_results"]["parax_data"].fod
            square = any(terms and terms[0] for terms in map(even_terms, lens["surfaces"]))
            peers = [abs(first.efl / efl - 1), abs(float(optic.paraxial.f2()) / efl - 1), abs(first.bfl - bfd)]
            worst, returned = real_rays(arguments.petzval, path, lens, optic, random)
        except Exception as error:  # a peer's own failure is not ours
            print(f"{name:44} a peer failed: {type(error).__name__}: {str(error)[:70]}")
            continue
        wrong = worst > TOLERANCE or not square and max(peers[0], peers[1]) > TOLERANCE
        bad += wrong
        note = "  <-- differs" if wrong else "  (r^2 terms, which the peers' first order leaves out)" if square else ""
        print(f"{name:44} {efl:10.5f} {peers[0]:9.1e} {peers[1]:9.1e} {peers[2]:9.1e} {returned:5} {worst:9.1e}{note}")
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    main()
