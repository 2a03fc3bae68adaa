#!/usr/bin/env python3
"""Compares `petzval lens report` with rayoptics and optiland.

    venv/bin/python benches/lens_peers/lens_report.py LENS... [--petzval FILE]
    venv/bin/python benches/lens_peers/lens_report.py LENS... --speed

All three get the same radii, conics, aspheres, thicknesses, indices, stop and film, and a distant
object (see lens_peers.py, which also says what is left out). rayoptics and optiland trace the same
rays, which are aimed at the stop by Newton's method. Optical paths refer to one sphere.
The table holds the largest difference over all lenses, and the lens where it occurs.

`--speed` prints CPU seconds instead, the median of three turns: of optiland for spots, fans of path
difference and MTFs at 21 fields and 5 wavelengths with about 64 x 64 rays each, and of petzval for
its whole report of 19 analyses on the same fields, wavelengths and rays.
"""

import argparse
import json
import math
import os
import statistics
import subprocess
from pathlib import Path

import lens_peers as peers
import numpy as np

# Plane on which rays start, before the front vertex (mm).
START_Z = -50.0
# Displacement of the neighbours of a chief ray, relative to the entrance pupil.
NEAR = 1e-3
ANALYSES = {
    "focal length": "relative",
    "back focal distance": "mm",
    "Seidel sums": "of the largest",
    "ray fan": "um",
    "path difference": "waves",
    "chief ray": "um",
    "distortion": "%",
    "field curvature": "um",
    "geometric MTF, axis": "",
    "diffraction MTF, axis": "",
    "the same by FFTMTF": "",
}


class Report:
    """Output of `petzval lens report --json all`."""

    def __init__(self, petzval, path, wavelength):
        command = [petzval, "lens", "report", path, "--json", "all", "--focus", "inf", "--pupil-grid", "256",
                   "--wavelengths", repr(wavelength)]
        output = subprocess.run(command, capture_output=True, text=True, check=True).stdout
        self.analyses = {analysis["analysis"]: analysis for analysis in json.loads(output)}

    def figure(self, name, analysis="first-order"):
        return self.analyses[analysis]["figures"][name]["value"]

    def rows(self, analysis, table=""):
        found = next(t for t in self.analyses[analysis]["tables"] if t["name"] == table)
        return [dict(zip(found["columns"], row)) for row in found["rows"]]


class Tracer:
    """Rays of optiland and rayoptics from a distant object."""

    def __init__(self, lens):
        self.lens = lens
        self.optic = peers.optiland_lens(lens)
        self.model = peers.rayoptics_model(lens)
        self.model["seq_model"].gaps[0].thi = -START_Z
        self.model.update_model()
        self.stop = next(i for i, row in enumerate(lens["surfaces"]) if row["stop"]) + 1

    def direction(self, angle):
        return np.array([0.0, math.sin(angle), math.cos(angle)])

    def optiland(self, angle, starts):
        """Points on all surfaces, directions on the film, and optical paths from the plane wave."""
        from optiland.rays import RealRays

        k = self.direction(angle)
        count = len(starts)
        full = np.full
        rays = RealRays(starts[:, 0].copy(), starts[:, 1].copy(), full(count, START_Z), full(count, k[0]),
                        full(count, k[1]), full(count, k[2]), np.ones(count),
                        full(count, self.lens["wavelength"] / 1000.0))
        group = self.optic.surfaces if hasattr(self.optic.surfaces, "trace") else self.optic.surface_group
        group.trace(rays)
        points = np.stack([np.asarray(group.x), np.asarray(group.y)], axis=-1)
        path = np.asarray(rays.opd) + starts @ k[:2]
        return points, np.stack([rays.L, rays.M, rays.N], axis=-1), path

    def rayoptics(self, angle, starts):
        from rayoptics.raytr import raytrace

        k = self.direction(angle)
        indices = np.array([1.0] + [row["index"] for row in self.lens["surfaces"]])
        points, directions, paths = [], [], []
        for start in starts:
            try:
                ray = raytrace.trace(self.model["seq_model"], np.array([*start, 0.0]), k, self.lens["wavelength"])[0]
            except Exception:  # total reflection, or a miss
                ray = None
            points.append(ray[-1][0][:2] if ray else [math.nan] * 2)
            directions.append(ray[-1][1] if ray else [math.nan] * 3)
            steps = np.array([segment[2] for segment in ray[:-1]]) if ray else np.full(len(indices), math.nan)
            paths.append(steps @ indices + start @ k[:2])
        return np.array(points)[None], np.array(directions), np.array(paths)

    def aim(self, angle, targets):
        """Starts of rays that pass these points of the stop (mm)."""
        pupil = self.lens["entrance_pupil"]
        scale = pupil["diameter"] / 2.0 / self.radius
        starts = targets * scale
        starts[:, 1] -= math.tan(angle) * (pupil["position"] - START_Z)
        step = 1e-5
        for _ in range(30):
            at = self.optiland(angle, starts)[0][self.stop] - targets
            columns = [(self.optiland(angle, starts + step * e)[0][self.stop] - targets - at) / step for e in np.eye(2)]
            (a, c), (b, d) = columns[0].T, columns[1].T
            determinant = a * d - b * c
            starts = starts - np.stack([d * at[:, 0] - b * at[:, 1], a * at[:, 1] - c * at[:, 0]], -1) / determinant[:, None]
        return starts


def path_difference(points, directions, path, chief, radius, waves):
    """Waves by which rays are shorter than the first ray, on the sphere around its film point."""
    d = np.column_stack([points - chief, np.zeros(len(points))])
    along = (d * directions).sum(axis=1)
    back = along + np.sign(radius) * np.sqrt(along**2 - (d**2).sum(axis=1) + radius**2)
    path = path - back
    return (path[0] - path) / waves


def compare_fans(report, tracer, note):
    lens, waves = tracer.lens, tracer.lens["wavelength"] * 1e-6
    pupil = report.figure("exit_pupil_position_from_film")
    angles = {round(row["field_mm"], 9): row for row in report.rows("distortion")}
    foci = {round(row["field_mm"], 9): row for row in report.rows("field-curvature")}
    # The image scale on the film, which is not at the paraxial focus.
    small = 1e-3 * math.radians(max(row["angle_deg"] for row in angles.values()))
    paraxial = tracer.optiland(small, tracer.aim(small, np.zeros((1, 2))))[0][-1][0, 1]
    scale = paraxial / math.tan(small)
    for axis, table in enumerate(["sagittal", "tangential"]):
        rays = report.rows("ray-fan", table)
        paths = report.rows("opd-fan", table)
        for field in sorted({row["field_mm"] for row in rays}):
            curve = angles.get(round(field, 9))
            if curve is None:
                continue
            angle = math.radians(curve["angle_deg"])
            chosen = [i for i, row in enumerate(rays) if row["field_mm"] == field and row["passes"]]
            targets = np.zeros((1 + len(chosen), 2))
            targets[1:, axis] = [tracer.radius * rays[i]["pupil"] for i in chosen]
            starts = tracer.aim(angle, targets)
            ours = np.array([[rays[i]["aberration_x_um"], rays[i]["aberration_y_um"]] for i in chosen])
            our_paths = np.array([paths[i]["path_difference_waves"] for i in chosen])
            for peer, trace in [("rayoptics", tracer.rayoptics), ("optiland", tracer.optiland)]:
                points, directions, path = trace(angle, starts)
                film = points[-1]
                note("chief ray", peer, 1e3 * abs(film[0, 1] - curve["height_mm"]))
                if field and axis:
                    percent = 100.0 * (film[0, 1] / (scale * math.tan(angle)) - 1.0)
                    note("distortion", peer, abs(percent - curve["distortion_percent"]))
                if chosen:
                    note("ray fan", peer, np.abs(1e3 * (film - film[0])[1:] - ours).max())
                    radius = math.copysign(math.hypot(pupil, film[0, 1]), -pupil)
                    other = path_difference(film, directions, path, film[0], radius, waves)
                    note("path difference", peer, np.abs(other[1:] - our_paths).max())
                step = NEAR * lens["entrance_pupil"]["diameter"] / 2.0
                near = starts[:1] + step * np.eye(2)[axis] * np.array([[-1.0], [1.0]])
                points, directions, _ = trace(angle, near)
                slope = directions[:, axis] / directions[:, 2]
                focus = -(points[-1][1, axis] - points[-1][0, axis]) / (slope[1] - slope[0])
                note("field curvature", peer, 1e3 * abs(focus - foci[round(field, 9)][f"{table}_focus_mm"]))


def compare_first_order(report, lens, note):
    from rayoptics.parax import thirdorder

    # The invariant is the slope of the chief ray times the radius of the entrance pupil.
    slope = report.figure("lagrange_invariant", "seidel") / (lens["entrance_pupil"]["diameter"] / 2.0)
    degrees = math.degrees(math.atan(slope))
    optic = peers.optiland_lens(lens)
    optic.add_field(y=degrees)
    model = peers.rayoptics_model(lens)
    fov = model["optical_spec"]["fov"]
    fov.value, fov.is_relative = degrees, True
    fov.set_from_list([0.0, 1.0])
    model.update_model()
    first = model["analysis_results"]["parax_data"].fod
    efl, bfd = (report.figure(name) for name in ["effective_focal_length", "back_focal_distance"])
    note("focal length", "rayoptics", abs(first.efl / efl - 1.0))
    note("focal length", "optiland", abs(float(optic.paraxial.f2()) / efl - 1.0))
    note("back focal distance", "rayoptics", abs(first.bfl - bfd))
    last = len(lens["surfaces"])
    y, u = optic.paraxial.trace_generic(1.0, 0.0, -1.0, lens["wavelength"] / 1000.0)
    y, u = np.ravel(y), np.ravel(u)
    note("back focal distance", "optiland", abs(-y[last] / u[last] - bfd))
    rows = report.rows("seidel", "sums")
    ours = np.array([rows[-1][f"s{i}_mm"] for i in range(1, 6)])
    largest = max(abs(row[f"s{i}_mm"]) for row in rows for i in range(1, 6))
    theirs = {
        "rayoptics": thirdorder.compute_third_order(model).loc["sum"].to_numpy(),
        "optiland": np.ravel(optic.aberrations.seidels()),
    }
    for peer, sums in theirs.items():
        # Signs of the peers' marginal and chief rays differ from ours for S II and S V.
        note("Seidel sums", peer, np.abs(np.abs(sums) - np.abs(ours)).max() / largest)


def compare_mtf(report, tracer, note):
    lens = tracer.lens
    ours = [row for row in report.rows("mtf") if row["field_mm"] == 0.0]
    frequency = np.array([row["frequency_per_mm"] for row in ours])
    line = (np.arange(256) + 0.5) / 128.0 - 1.0
    grid = 0.55 * lens["entrance_pupil"]["diameter"] * np.stack(np.meshgrid(line, line), -1).reshape(-1, 2)
    points = tracer.optiland(0.0, grid)[0]
    inside = np.isfinite(points).all(axis=(0, 2))
    for i, row in enumerate(report.rows("prescription")):
        inside &= np.hypot(*points[i + 1].T) <= row["semi_diameter_mm"]
    y = points[-1][inside, 1]
    values = [abs(np.exp(2j * np.pi * f * y).mean()) for f in frequency]
    note("geometric MTF, axis", "optiland", max(abs(v - row["geometric_tangential"]) for v, row in zip(values, ours)))
    values = np.interp(frequency, *transfer_of_fan(tracer, report))
    difference = max(abs(v - row["diffraction_tangential"]) for v, row in zip(values, ours))
    note("diffraction MTF, axis", "optiland", difference)
    from optiland.mtf import FFTMTF

    theirs = FFTMTF(tracer.optic, wavelength=lens["wavelength"] / 1000.0, num_rays=256, grid_size=1024)
    values = np.interp(frequency, np.ravel(theirs.freq), np.ravel(theirs.mtf[0][0]))
    difference = max(abs(v - row["diffraction_tangential"]) for v, row in zip(values, ours))
    note("the same by FFTMTF", "optiland", difference)


def transfer_of_fan(tracer, report, samples=801):
    """Frequencies (cycles/mm) and transfer of a point on the axis, from a fan of optiland's rays.

    The autocorrelation of the pupil function over direction cosines (Hopkins 1957); FFTMTF takes
    these for an affine map of its pupil coordinates.
    """
    nm = tracer.lens["wavelength"] * 1e-6
    height = np.linspace(0.0, 0.6 * tracer.lens["entrance_pupil"]["diameter"], 4001)
    points, directions, path = tracer.optiland(0.0, np.stack([0.0 * height, height], -1))
    passes = np.isfinite(points).all(axis=(0, 2))
    for i, row in enumerate(report.rows("prescription")):
        rim = tracer.radius if i + 1 == tracer.stop else row["semi_diameter_mm"]
        passes &= np.hypot(*points[i + 1].T) <= rim
    count = len(height) if passes.all() else int(np.argmin(passes))
    cosine = directions[:count, 1]
    phase = path[:count] - cosine * points[-1][:count, 1]
    cosine = np.abs(cosine)
    density = np.gradient(height[:count] ** 2) / np.gradient(cosine**2)
    step = 2.0 * cosine[-1] / samples
    line = (np.arange(-samples, samples) + 0.5) * step
    radius = np.hypot(*np.meshgrid(line, line))
    amplitude = np.where(radius <= cosine[-1], np.sqrt(np.interp(radius, cosine, density)), 0.0)
    wave = amplitude * np.exp(2j * np.pi / nm * np.interp(radius, cosine, phase))
    spectrum = np.fft.fft2(wave, (4 * samples, 4 * samples))
    transfer = np.abs(np.fft.ifft2(np.abs(spectrum) ** 2)[0, : 2 * samples])
    return np.arange(2 * samples) * step / nm, transfer / transfer[0]


FIELDS = 21
WAVELENGTHS = [450.0, 500.0, 550.0, 600.0, 650.0]


def cpu_seconds(work):
    """CPU time of this process and of the processes it has waited for, during a piece of work."""
    before = os.times()
    work()
    after = os.times()
    return sum(after[:4]) - sum(before[:4])


def speed(petzval, path, lens):
    """CPU seconds of petzval and of each analysis of optiland, by name."""
    from optiland.analysis import SpotDiagram
    from optiland.mtf import FFTMTF
    from optiland.wavefront import OPDFan

    wavelengths = ",".join(str(nm) for nm in WAVELENGTHS)
    command = [petzval, "lens", "report", path, "--json", "all", "--focus", "inf", "--field-count", str(FIELDS),
               "--pupil-grid", "64", "--wavelengths", wavelengths]
    output = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    report = {analysis["analysis"]: analysis for analysis in json.loads(output)}
    figures = report["first-order"]["figures"]
    lens["film_distance"] = figures["film_distance"]["value"]
    lens["entrance_pupil"]["diameter"] = figures["entrance_pupil_diameter"]["value"]
    table = report["distortion"]["tables"][0]
    angle = table["columns"].index("angle_deg")
    largest = max(row[angle] for row in table["rows"] if row[angle] is not None)
    optic = peers.optiland_lens(lens)
    for i in range(1, FIELDS):
        optic.add_field(y=largest * i / (FIELDS - 1))
    for nm in WAVELENGTHS:
        optic.add_wavelength(value=nm / 1000.0)
    microns = [nm / 1000.0 for nm in WAVELENGTHS]

    def all_transfers():
        for micron in microns:
            FFTMTF(optic, wavelength=micron, num_rays=64, grid_size=256)

    works = {
        "petzval, whole report": lambda: subprocess.run(command, capture_output=True, check=True),
        "optiland, spots": lambda: SpotDiagram(optic, wavelengths=microns, num_rings=36),
        "optiland, path fans": lambda: OPDFan(optic, wavelengths=microns, num_rays=64),
        "optiland, MTF": all_transfers,
    }
    return {name: statistics.median(cpu_seconds(work) for _ in range(3)) for name, work in works.items()}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("lenses", nargs="+")
    parser.add_argument("--petzval", default="target/release/petzval")
    parser.add_argument("--speed", action="store_true", help="CPU seconds instead of differences")
    parser.add_argument("--each", action="store_true", help="print the differences of every lens")
    arguments = parser.parse_args()
    worst, compared = {}, 0
    for path in arguments.lenses:
        name = Path(path).name
        run = subprocess.run([arguments.petzval, "lens", path, "--json"], capture_output=True, text=True)
        lens = json.loads(run.stdout) if run.returncode == 0 else None
        skip = peers.reason_to_skip(lens) if lens else "not read"
        if skip:
            print(f"{name}: left out: {skip}")
            continue

        if arguments.speed:
            for work, seconds in speed(arguments.petzval, path, lens).items():
                print(f"{name:24} {work:24} {seconds:8.2f} s", flush=True)
            continue

        own = {}

        def note(analysis, peer, difference):
            own[analysis, peer] = max(float(np.nan_to_num(difference, nan=math.inf)), own.get((analysis, peer), 0.0))

        parts = [compare_first_order, compare_fans, compare_mtf]
        try:
            report = Report(arguments.petzval, path, lens["wavelength"])
            lens["film_distance"] = report.figure("film_distance")
            lens["entrance_pupil"]["diameter"] = report.figure("entrance_pupil_diameter")
            tracer = Tracer(lens)
            tracer.radius = report.figure("stop_semi_diameter")
        except Exception as error:
            print(f"{name}: left out: {type(error).__name__}: {str(error)[:90]}")
            continue
        for part in parts:
            try:
                part(report, lens if part is compare_first_order else tracer, note)
            except Exception as error:  # a peer's own failure is not ours
                print(f"{name}: {part.__name__}: {type(error).__name__}: {str(error)[:90]}")
        compared += 1
        if arguments.each:
            print(name, {" ".join(key): float(f"{value:.2g}") for key, value in own.items()}, flush=True)
        for key, value in own.items():
            worst[key] = max(worst.get(key, (0.0, "")), (value, name))
    if arguments.speed:
        return
    print(f"\n{compared} lenses; largest difference, and the lens where it occurs")
    for analysis, unit in ANALYSES.items():
        for peer in ["rayoptics", "optiland"]:
            if (analysis, peer) in worst:
                value, name = worst[analysis, peer]
                print(f"{analysis:22} {unit:15} {peer:10} {value:9.1e}  {name}")


if __name__ == "__main__":
    main()
