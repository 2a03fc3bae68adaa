#!/usr/bin/env python3
"""Renders the same scenes with petzval and with other renderers, and compares time and noise.

README.md beside this file says what is measured, and how.
"""

import argparse
import contextlib
import json
import os
import platform
import signal
import sys
import tempfile
from pathlib import Path

try:
    import numpy  # noqa: F401
except ImportError:
    sys.exit("scoreboard: numpy is missing; install it: pip install numpy")

sys.dont_write_bytecode = True  # no files in the checkout

import pictures  # noqa: E402
import report  # noqa: E402
import scenes  # noqa: E402
from measure import Failed, Noise, Series, compare, run  # noqa: E402
from renderers import Job, find  # noqa: E402

# Largest difference of means beyond the statistical error. README.md says where it comes from.
TOLERANCES = {"petzval, spectra": 0.015, "pbrt-v4": 0.015, "Mitsuba 3": 0.02, "Cycles": 0.04}
PEERS = ["petzval", "pbrt-v4", "mitsuba", "cycles"]


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    option = parser.add_argument
    option("--scenes", type=names(scenes.names()), metavar="NAMES", default=scenes.names(),
           help=f"scenes, separated by commas: {','.join(scenes.names())}")  # fmt: skip
    option("--renderers", type=names(PEERS), metavar="NAMES", default=[],
           help=f"renderers, separated by commas: {','.join(PEERS)}; default: all that are found")  # fmt: skip
    option("--spp", type=samples, help="samples per pixel, a power of two; default: by scene")
    option("--repeat", type=positive, default=5, help="runs of each renderer [5]")
    option("--threads", type=counts, default=default_threads(), metavar="N,N",
           help="numbers of threads [1,2]")  # fmt: skip
    option("--petzval", metavar="PATH", help="petzval; default: target/release/petzval")
    option("--pbrt", metavar="PATH", default="pbrt", help="pbrt of pbrt-v4 [pbrt]")
    option("--mitsuba", metavar="PATH", default=sys.executable,
           help="Python that has the package mitsuba [the one that runs this script]")  # fmt: skip
    option("--blender", metavar="PATH", default="blender", help="Blender, for Cycles [blender]")
    option("--pictures", metavar="FOLDER", type=Path, help="write a PNG of each renderer's picture")
    option("--json", metavar="FILE", type=Path, help="write all measurements to a file")
    option("--markdown", action="store_true", help="print the table in Markdown")
    return parser.parse_args()


def names(known):
    def parse(text):
        chosen = text.split(",")
        for name in chosen:
            if name not in known:
                raise argparse.ArgumentTypeError(f"{name!r} is unknown; there are {', '.join(known)}")
        return chosen

    return parse


def positive(text):
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"expected a number from 1, found {text!r}")
    return int(text)


def counts(text):
    return [positive(part) for part in text.split(",")]


def samples(text):
    value = positive(text)
    if value < 2 or value & (value - 1):
        raise argparse.ArgumentTypeError(f"expected a power of two from 2, found {text!r}")
    return value


def default_threads():
    return [n for n in (1, 2) if n <= (os.cpu_count() or 1)]


def main():
    options = arguments()
    renderers, missing = find(options)
    if not any(r.name == "petzval" for r in renderers):
        reason = missing.get("petzval", "--renderers leaves it out")
        print(f"scoreboard: petzval is needed for all ratios: {reason}\n"
              "Build it with cargo build --release, or name it with --petzval PATH.", file=sys.stderr)  # fmt: skip
        return 2
    for name, reason in missing.items():
        print(f"{name} is missing: {reason}", file=sys.stderr)
    try:
        # An hour's measurements should not fail at the end.
        if options.pictures:
            options.pictures.mkdir(parents=True, exist_ok=True)
        if options.json:
            options.json.touch()
    except OSError as error:
        print(f"scoreboard: cannot write: {error}", file=sys.stderr)
        return 2

    load = os.getloadavg()[0]
    if load > 0.5:
        print(f"The machine is busy (load average {load:.1f}): times will be longer.", file=sys.stderr)
    results, problems, left_out = [], [], {}
    with tempfile.TemporaryDirectory(prefix="scoreboard.") as folder:
        for name in options.scenes:
            scene = scenes.prepare(name, Path(folder))
            rows, bad = measure_scene(scene, renderers, options, Path(folder))
            for renderer in renderers:
                if not renderer.file(scene) and renderer.name in TOLERANCES:
                    left_out.setdefault(renderer.name, []).append(name)
            results += rows
            problems += bad
    answer = {
        "machine": machine(load),
        "versions": {r.name: r.version for r in renderers},
        "missing": missing,
        "left_out": left_out,
        "repeat": max(2, options.repeat),
        "results": results,
        "problems": problems,
    }
    print(report.text(answer, options.markdown))
    if options.json:
        options.json.write_text(json.dumps(answer, indent=1) + "\n")
    return 1 if problems else 0


def measure_scene(scene, renderers, options, folder):
    """Measures a scene with all renderers that can draw it. Returns rows and problems."""
    spp = options.spp or scene.spp
    base_spp = max(1, spp // 16)
    problems, series, files = [], {}, {}
    here = [r for r in renderers if r.file(scene)]
    if not any(r.compared_with == "petzval, thin lens" for r in here):
        here = [r for r in here if r.name != "petzval, thin lens"]
    for renderer in here:
        if renderer.warm_up:
            with contextlib.suppress(Failed):
                job = Job(scene, base_spp, 0, options.threads[0], folder / "warm up")
                run(renderer.command(job), renderer.environment)
    # At least two pictures, for their noise.
    for i in range(max(2, options.repeat)):
        for threads in options.threads:
            for renderer in list(here):
                of = series.setdefault((renderer.name, threads), Series(spp, base_spp))
                out = folder / f"{scene.name} {renderer.name} {threads} {i}"
                try:
                    for count, runs in ((base_spp, of.base), (spp, of.full)):
                        job = Job(scene, count, i + 1, threads, out)
                        runs.append(run(renderer.command(job), renderer.environment))
                except Failed as error:
                    problems.append(f"{scene.name}, {renderer.name}: {error}")
                    here.remove(renderer)
                    continue
                if threads == options.threads[0]:
                    files.setdefault(renderer.name, []).append(Path(f"{out}{renderer.suffix}"))
                print(f"{scene.name}: {renderer.name}, threads {threads}, run {i + 1}:"
                      f" {of.full[-1].cpu:.1f} CPU s", file=sys.stderr)  # fmt: skip

    noises = {}
    for renderer in list(here):
        try:
            noises[renderer.name] = Noise(files[renderer.name])
        except (Failed, OSError, ValueError, KeyError) as error:
            problems.append(f"{scene.name}, {renderer.name}: {error}")
            here.remove(renderer)
    rows = []
    for threads in options.threads:
        for renderer in here:
            row, bad = result(scene, renderer, threads, series, noises)
            rows.append(row)
            problems += bad if threads == options.threads[0] else []
    for renderer in here:
        if options.pictures:
            brightness = noises[renderer.compared_with or renderer.name]
            image = pictures.for_display(noises[renderer.name].mean_picture, brightness.mean)
            pictures.write_png(options.pictures / f"{scene.name} {renderer.name}.png", image)
    return rows, problems


def result(scene, renderer, threads, series, noises):
    of, noise = series[renderer.name, threads], noises[renderer.name]
    problems, reference = [], noises.get(renderer.compared_with)
    cpu = max(of.render_cpu(), 1e-3)
    row = {
        "too_short": cpu < 0.2 or cpu < 0.05 * of.whole_cpu(),
        "scene": scene.name,
        "renderer": renderer.name,
        "threads": threads,
        "spp": of.spp,
        "render_cpu": cpu,
        "whole_cpu": of.whole_cpu(),
        "wall": of.wall(),
        "samples_per_cpu_second": noise.size[0] * noise.size[1] * of.spp / cpu,
        "relative_variance": noise.relative_variance,
        "relative_variance_raw": noise.raw_variance,
        "cost": noise.relative_variance * cpu,
        "mean": noise.mean,
        "runs": [vars(r) for r in of.full],
        "base_runs": [vars(r) for r in of.base],
    }
    if reference:
        agreement = compare(noise, reference, TOLERANCES[renderer.name])
        row["compared_with"] = renderer.compared_with
        row["mean_difference"], row["mean_error"] = agreement.difference, agreement.error
        problems += [f"{scene.name}, {renderer.name}: {p}" for p in agreement.problems]
    return row, problems


def machine(load):
    model = platform.processor() or platform.machine()
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                model = line.split(":", 1)[1].strip()
                break
    except OSError:
        pass
    return {"cpu": model, "cores": os.cpu_count(), "load": load}


if __name__ == "__main__":
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        print("\nscoreboard: stopped", file=sys.stderr)
        sys.exit(130)
