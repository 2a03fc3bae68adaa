#!/usr/bin/env python3
"""Writes a large scene, and measures renders of it.

    python3 benches/large/large.py hair --count 100000 scene.pbrt
    python3 benches/large/large.py cloud --count 256 --petzval PATH [--pbrt PATH] scene.pbrt

hair is a head with --count hairs, cloud a room with a cloud of --count voxels along each axis, street a tiled street
of --count instances with 200 textures. Prints the time and the largest memory of each program: once with one sample
a pixel, which is reading and building almost alone, and once with all samples. The difference gives the time of a
sample.
"""

import argparse
import math
import os
import random
import struct
import subprocess
import sys
import tempfile
import time
import zlib
from pathlib import Path

# Radius of the head, length and width of a hair [m].
RADIUS = 0.1
LENGTH = 0.22
WIDTH = 9e-5
# Control points of a hair, a cubic B-spline of three segments.
POINTS = 6

FILM = """Sampler "independent"
Film "rgb" "integer xresolution" {size} "integer yresolution" {size}
Integrator "volpath" "integer maxdepth" {depth}
WorldBegin
"""
HAIR = """LookAt 0 -0.62 0.06  0 0 0.0  0 0 1
Camera "perspective" "float fov" 32
{film}LightSource "infinite" "rgb L" [0.3 0.32 0.36]
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


def write_hair(file, options):
    """Writes a head with hair."""
    draw = random.Random(1)
    file.write(HAIR.format(film=FILM.format(size=options.size, depth=options.depth)))
    for _ in range(options.count):
        numbers = " ".join(f"{v:.6g}" for point in hair(draw) for v in point)
        file.write(
            f'Shape "curve" "string type" "cylinder" "string basis" "bspline" "point3 P" [{numbers}] '
            f'"float width0" {WIDTH} "float width1" {WIDTH / 2}\n'
        )


CLOUD = """LookAt 0 -3.4 1.2  0 0 1.1  0 0 1
Camera "perspective" "float fov" 50
{film}AttributeBegin
AreaLightSource "diffuse" "rgb L" [14 13 12]
Shape "bilinearmesh" "point3 P" [-0.6 -0.6 2.48  -0.6 0.6 2.48  0.6 -0.6 2.48  0.6 0.6 2.48]
AttributeEnd
"""
WALLS = [
    ("0.7 0.7 0.7", "-2 -2 0  2 -2 0  -2 2 0  2 2 0"),
    ("0.7 0.7 0.7", "-2 -2 2.5  -2 2 2.5  2 -2 2.5  2 2 2.5"),
    ("0.7 0.7 0.7", "-2 2 0  2 2 0  -2 2 2.5  2 2 2.5"),
    ("0.6 0.2 0.15", "-2 -2 0  -2 2 0  -2 -2 2.5  -2 2 2.5"),
    ("0.2 0.5 0.2", "2 2 0  2 -2 0  2 2 2.5  2 -2 2.5"),
]


def write_cloud(file, options):
    """Writes a room with a cloud."""
    count = options.count
    file.write(CLOUD.format(film=FILM.format(size=options.size, depth=options.depth)))
    for colour, corners in WALLS:
        file.write(f'Material "diffuse" "rgb reflectance" [{colour}]\n')
        file.write(f'Shape "bilinearmesh" "point3 P" [{corners}]\n')
    file.write(
        'AttributeBegin\nTranslate -0.8 -0.8 0.5\nScale 1.6 1.6 1.2\nMakeNamedMedium "cloud" "string type" '
        f'"uniformgrid" "integer nx" {count} "integer ny" {count} "integer nz" {count} "float scale" 20 '
        '"rgb sigma_a" [0.02 0.02 0.02] "rgb sigma_s" [1 1 1] "float g" 0.5 "float density" [\n'
    )
    draw = random.Random(2)
    blobs = [[draw.uniform(0.25, 0.75) for _ in range(3)] + [draw.uniform(0.08, 0.2)] for _ in range(24)]
    for k in range(count):
        z = (k + 0.5) / count
        for j in range(count):
            y = (j + 0.5) / count
            near = [(bx, r * r - (y - by) ** 2 - (z - bz) ** 2) for bx, by, bz, r in blobs]
            near = [(bx, left) for bx, left in near if left > 0]
            row = ["0"] * count
            if near:
                wave = 0.5 + 0.5 * math.sin(40 * y + 3 * math.sin(23 * z))
                for i in range(count):
                    x = (i + 0.5) / count
                    inside = max(left - (x - bx) ** 2 for bx, left in near)
                    if inside > 0:
                        row[i] = f"{min(1, 60 * inside) * (0.4 + 0.6 * wave * (0.5 + 0.5 * math.sin(37 * x))):.3g}"
            file.write(" ".join(row) + "\n")
    file.write(
        ']\nAttributeEnd\nMaterial "interface"\nMediumInterface "cloud" ""\nTranslate -0.8 -0.8 0.5\n'
        'Scale 1.6 1.6 1.2\nShape "trianglemesh" "integer indices" '
        "[0 2 1 1 2 3 4 5 6 5 7 6 0 1 4 1 5 4 2 6 3 3 6 7 0 4 2 2 4 6 1 3 5 3 7 5] "
        '"point3 P" [0 0 0  1 0 0  0 1 0  1 1 0  0 0 1  1 0 1  0 1 1  1 1 1]\n'
    )


STREET = """LookAt 0 -4 1.7  1 30 3  0 0 1
Camera "perspective" "float fov" 60
{film}LightSource "infinite" "rgb L" [0.5 0.6 0.8]
LightSource "distant" "point3 from" [-3 -2 4] "point3 to" [0 0 0] "rgb L" [2.4 2.2 1.9]
"""
TEXTURES = 200
TEXELS = 256


def picture(number):
    """Returns a PNG of bricks, slabs or plaster."""
    draw = random.Random(number)
    base = [draw.randint(60, 200) for _ in range(3)]
    width, height = draw.choice([16, 32, 64]), draw.choice([8, 16, 32])
    rows = bytearray()
    for y in range(TEXELS):
        rows.append(0)
        shift = width // 2 * (y // height % 2)
        for x in range(TEXELS):
            joint = y % height == 0 or (x + shift) % width == 0
            stone = hash(((x + shift) // width, y // height, number)) % 40 - 20
            rows.extend(max(0, min(255, c // 2 if joint else c + stone)) for c in base)

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", TEXELS, TEXELS, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(bytes(rows))) + chunk(b"IEND", b"")


def box(width, depth, height, repeat):
    """Returns a box of textured sides."""
    x, y, z = width / 2, depth / 2, height
    corners = [(-x, -y), (x, -y), (x, y), (-x, y)]
    points, uv, indices = [], [], []
    for i in range(4):
        (ax, ay), (bx, by) = corners[i], corners[(i + 1) % 4]
        points += [ax, ay, 0, bx, by, 0, bx, by, z, ax, ay, z]
        uv += [0, 0, repeat, 0, repeat, repeat, 0, repeat]
    points += [v for cx, cy in corners for v in (cx, cy, z)]
    uv += [0, 0, 1, 0, 1, 1, 0, 1]
    for face in range(5):
        indices += [4 * face + k for k in (0, 1, 2, 0, 2, 3)]
    lists = (" ".join(f"{v:g}" for v in values) for values in (points, uv, indices))
    return 'Shape "trianglemesh" "point3 P" [{}] "point2 uv" [{}] "integer indices" [{}]\n'.format(*lists)


def write_street(file, options):
    """Writes a street of slabs and houses, and its pictures beside it."""
    draw = random.Random(3)
    folder = options.scene.parent
    file.write(STREET.format(film=FILM.format(size=options.size, depth=options.depth)))
    for number in range(TEXTURES):
        name = f"street{number}.png"
        (folder / name).write_bytes(picture(number))
        slab = number % 4 > 0
        size = (0.5, 0.5, 0.1 + 0.03 * draw.random(), 1) if slab else (5, 6, draw.uniform(5, 12), 6)
        file.write(
            f'Texture "t{number}" "spectrum" "imagemap" "string filename" "{name}"\nObjectBegin "o{number}"\n'
            f'Material "diffuse" "texture reflectance" "t{number}"\n{box(*size)}ObjectEnd\n'
        )
    houses = options.count // 50
    for i in range(options.count):
        if i < houses:
            side, along = (i % 2) * 2 - 1, i // 2
            place, number = (side * (7 + 8 * (along // 40)), 6 * (along % 40), 0), 4 * draw.randrange(TEXTURES // 4)
        else:
            slab = i - houses
            place = (0.5 * (slab % 24) - 6, 0.5 * (slab // 24) - 6, -0.12)
            number = 4 * draw.randrange(TEXTURES // 4) + draw.randint(1, 3)
        turn = 90 * draw.randint(0, 3)
        file.write(
            f'AttributeBegin\nTranslate {place[0]:g} {place[1]:g} {place[2]:g}\nRotate {turn} 0 0 1\n'
            f'ObjectInstance "o{number}"\nAttributeEnd\n'
        )


# Each scene, and its number of hairs, voxels along an axis, or instances.
SCENES = {"hair": (write_hair, 100_000), "cloud": (write_cloud, 256), "street": (write_street, 50_000)}


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
    parser = argparse.ArgumentParser(description="Writes a large scene, and measures renders of it.")
    parser.add_argument("subject", choices=SCENES)
    parser.add_argument("scene", type=Path)
    parser.add_argument("--count", type=int, help="hairs, voxels along an axis, or instances")
    parser.add_argument("--size", type=int, default=400, help="pixels along a side")
    parser.add_argument("--depth", type=int, default=8, help="longest path")
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--petzval")
    parser.add_argument("--pbrt")
    options = parser.parse_args()
    writer, count = SCENES[options.subject]
    options.count = options.count or count
    with open(options.scene, "w") as file:
        writer(file, options)
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
