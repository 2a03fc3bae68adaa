#!/usr/bin/env python3
"""Writes a head with hair, and measures renders of it.

    python3 benches/hair/hair.py --hairs 100000 head.pbrt
    python3 benches/hair/hair.py --hairs 100000 --petzval PATH [--pbrt PATH] head.pbrt

Prints the time and the largest memory of each program: once with one sample a pixel, which is reading and building
almost alone, and once with all samples. The difference gives the time of a sample.
"""

import argparse
import math
import os
import random
import subprocess
import sys
import tempfile
import time
from pathlib import Path

# Radius of the head, length and width of a hair [m].
RADIUS = 0.1
LENGTH = 0.22
WIDTH = 9e-5
# Control points of a hair, a cubic B-spline of three segments.
POINTS = 6

HEAD = """LookAt 0 -0.62 0.06  0 0 0.0  0 0 1
Camera "perspective" "float fov" 32
Sampler "independent"
Film "rgb" "integer xresolution" {width} "integer yresolution" {height}
Integrator "path" "integer maxdepth" {depth}
WorldBegin
LightSource "infinite" "rgb L" [0.3 0.32 0.36]
AttributeBegin
AreaLightSource "diffuse" "rgb L" [60 56 50]
Translate 0.5 -0.5 0.7
Shape "sphere" "float radius" 0.1
AttributeEnd
Material "diffuse" "rgb reflectance" [0.5 0.35 0.28]
Shape "sphere" "float radius" 0.1
Material "hair" "float eumelanin" 0.5 "float beta_m" 0.25 "float beta_n" 0.3
"""


def hair(draw):
    """Returns the control points of a hair that grows out of the upper head and falls down."""
    z = draw.uniform(-0.35, 1)
    turn = draw.uniform(0, 2 * math.pi)
    across = math.sqrt(1 - z * z)
    out = (across * math.cos(turn), across * math.sin(turn), z)
    # No hair grows on the face.
    while out[1] < -0.55 and out[2] < 0.6:
        z = draw.uniform(-0.35, 1)
        turn = draw.uniform(0, 2 * math.pi)
        across = math.sqrt(1 - z * z)
        out = (across * math.cos(turn), across * math.sin(turn), z)
    length = LENGTH * draw.uniform(0.8, 1.1)
    phase, curl = draw.uniform(0, 2 * math.pi), draw.uniform(0.002, 0.006)
    lift = draw.uniform(1.02, 1.2)
    points = []
    for i in range(POINTS):
        # The first and the last point of a B-spline are beyond its ends.
        t = (i - 1) / (POINTS - 3)
        fall = max(t, 0) ** 1.3 * length
        spread = RADIUS * (1 + (lift - 1) * min(max(t, 0) * 3, 1)) + 0.3 * length * t * (1 - min(t, 1)) * 0.5
        wave = curl * max(t, 0)
        points.append(
            (
                out[0] * spread + wave * math.cos(phase + 9 * t),
                out[1] * spread + wave * math.sin(phase + 9 * t),
                out[2] * spread - fall * (0.3 + 0.7 * min(max(t, 0), 1)),
            )
        )
    return points


def write(path, hairs, options):
    """Writes the scene."""
    draw = random.Random(1)
    with open(path, "w") as file:
        file.write(HEAD.format(width=options.size, height=options.size, depth=options.depth))
        for _ in range(hairs):
            numbers = " ".join(f"{v:.6g}" for point in hair(draw) for v in point)
            file.write(
                f'Shape "curve" "string type" "cylinder" "string basis" "bspline" "point3 P" [{numbers}] '
                f'"float width0" {WIDTH} "float width1" {WIDTH / 2}\n'
            )


def run(command):
    """Runs a program. Returns the CPU time [s], the duration [s] and the largest memory [MiB]."""
    start = time.monotonic()
    child = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode:
        sys.exit(f"{command[0]} ended with exit code {child.returncode}")
    return usage.ru_utime + usage.ru_stime, time.monotonic() - start, usage.ru_maxrss / 1024


def measure(name, command, samples, options):
    """Prints the time and memory of a program."""
    read = run(command(1))
    full = run(command(samples))
    per_sample = (full[0] - read[0]) / ((samples - 1) * options.size**2)
    print(
        f"{name}: read and build {read[1]:.1f} s ({read[0]:.1f} s of CPU), {full[2]:.0f} MiB, "
        f"{per_sample * 1e9:.0f} ns of CPU a sample"
    )


def main():
    parser = argparse.ArgumentParser(description="Writes a head with hair, and measures renders of it.")
    parser.add_argument("scene", type=Path)
    parser.add_argument("--hairs", type=int, default=100_000)
    parser.add_argument("--size", type=int, default=400, help="pixels along a side")
    parser.add_argument("--depth", type=int, default=8, help="longest path")
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--petzval")
    parser.add_argument("--pbrt")
    options = parser.parse_args()
    write(options.scene, options.hairs, options)
    with tempfile.TemporaryDirectory() as folder:
        target = str(Path(folder) / "a.exr")
        scene, threads = str(options.scene), str(options.threads)
        if options.petzval:
            base = [options.petzval, "render", scene, "-o", target, "--threads", threads, "--spp"]
            measure("petzval", lambda spp: [*base, str(spp)], options.samples, options)
        if options.pbrt:
            base = [options.pbrt, "--quiet", "--nthreads", threads, "--outfile", target]
            measure("pbrt-v4", lambda spp: [*base, "--spp", str(spp), scene], options.samples, options)


if __name__ == "__main__":
    main()
