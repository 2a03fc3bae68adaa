#!/usr/bin/env python3
"""Compares the colours of petzval, in RGB and by wavelength, with those of pbrt-v4, which carries four wavelengths.

    python3 benches/spectral/colours.py --pbrt PATH --petzval PATH

Prints a table: for each scene the means of petzval over those of pbrt, by channel, without and with `+spectra`, and the
largest difference of two pictures of pbrt. Needs numpy.
"""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "scoreboard"))
import pictures  # noqa: E402

HEAD = """Film "rgb" "integer xresolution" 32 "integer yresolution" 32
PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5
Sampler "zsobol" "integer pixelsamples" %d
Integrator "volpath" "integer maxdepth" %d
LookAt 0 -4 1.2  0 0 0.6  0 0 1
Camera "perspective" "float fov" 20
WorldBegin
"""
BALL = 'Translate 0 0 0.6 Shape "sphere" "float radius" 0.6\n'
SHEET = """Material "diffuse" "rgb reflectance" [0 0 0] Shape "bilinearmesh" "point3 P" [-4 2 -3  4 2 -3  -4 2 5  4 2 5]
Material "thindielectric" "spectrum eta" "glass-LASF9"
Shape "bilinearmesh" "point3 P" [-4 1 -3  4 1 -3  -4 1 5  4 1 5]
"""
WALL = 'Shape "bilinearmesh" "point3 P" [-4 1 -3  4 1 -3  -4 1 5  4 1 5]\n'
PANEL = """AttributeBegin Translate 0 -2 4 AreaLightSource "diffuse" "spectrum L" "stdillum-D65"
Shape "bilinearmesh" "point3 P" [-1 -1 0  -1 1 0  1 -1 0  1 1 0] AttributeEnd
"""
CORNER = [
    'Shape "bilinearmesh" "point3 P" [-2 0 0  0 1.5 0  -2 0 3  0 1.5 3]\n',
    'Shape "bilinearmesh" "point3 P" [0 1.5 0  2 0 0  0 1.5 3  2 0 3]\n',
]
# Reflectances: three colours, and two pigments by wavelength.
GREY, PINK, TEAL, ORANGE = (
    f'"rgb reflectance" [{rgb}]' for rgb in ("0.5 0.5 0.5", "0.8 0.3 0.4", "0.1 0.5 0.5", "0.8 0.35 0.05")
)
RED = '"spectrum reflectance" [400 0.04 580 0.05 600 0.3 620 0.7 700 0.8]'
GREEN = '"spectrum reflectance" [400 0.05 480 0.08 510 0.5 550 0.55 580 0.2 620 0.08 700 0.1]'
DYE = '"spectrum sigma_a" [360 1.2 560 1 600 0.1 830 0.1] "rgb sigma_s" [0 0 0]'
HAZE = '"spectrum sigma_a" [360 0.6 560 0.5 600 0 830 0] "spectrum sigma_s" [360 4 480 2 580 1 830 0.3]'
D65, F2, F11 = (f'"spectrum L" "stdillum-{name}"' for name in ("D65", "F2", "F11"))


def sky(light):
    return f'LightSource "infinite" {light}\n'


def metal(name):
    index = f'"spectrum eta" "metal-{name}-eta" "spectrum k" "metal-{name}-k"'
    return f'Material "conductor" {index} "float roughness" 0.2\n'


def diffuse(colour):
    return f'Material "diffuse" {colour}\n'


def glass(name):
    return f'Material "dielectric" "spectrum eta" "glass-{name}"\n'


def measured(name):
    file = Path(__file__).resolve().parents[2] / "tests" / "pbrt_language" / f"{name}.bsdf"
    return f'Material "measured" "string filename" "{file}"\n'


def medium(coefficients):
    named = f'MakeNamedMedium "m" "string type" "homogeneous" {coefficients}\n'
    return named + 'Material "interface" MediumInterface "m" ""\n'


def ball(light, material, depth=3):
    return sky(light) + material + BALL, depth


def corner(first, second):
    return PANEL + diffuse(first) + CORNER[0] + diffuse(second) + CORNER[1], 7


SCENES = {
    "copper, white sky": ball('"rgb L" [1 1 1]', metal("Cu")),
    "copper, sky of 20,000 K": ball('"blackbody L" 20000', metal("Cu")),
    "copper, sky of RGB 0.2 0.45 1": ball('"rgb L" [0.2 0.45 1]', metal("Cu")),
    "copper, sky of RGB 0.1 0.3 1": ball('"rgb L" [0.1 0.3 1]', metal("Cu")),
    "copper, sky of RGB 0.05 0.2 1": ball('"rgb L" [0.05 0.2 1]', metal("Cu")),
    "gold, sky of RGB 0.1 0.3 1": ball('"rgb L" [0.1 0.3 1]', metal("Au")),
    "grey, lamp F2": ball(F2, diffuse(GREY)),
    "pink RGB, lamp F2": ball(F2, diffuse(PINK)),
    "orange RGB, lamp F11": ball(F11, diffuse(ORANGE)),
    "teal RGB, lamp F11": ball(F11, diffuse(TEAL)),
    "red pigment, daylight": ball(D65, diffuse(RED)),
    "red pigment, 2700 K": ball('"blackbody L" 2700', diffuse(RED)),
    "red pigment, lamp F2": ball(F2, diffuse(RED)),
    "red pigment, lamp F11": ball(F11, diffuse(RED)),
    "green pigment, lamp F11": ball(F11, diffuse(GREEN)),
    "orange corner, 6 bounces, daylight": corner(ORANGE, ORANGE),
    "orange and teal corner, 6 bounces, daylight": corner(ORANGE, TEAL),
    "measured, lamp F2": ball(F2, measured("isotropic")),
    "measured, lamp F11": ball(F11, measured("isotropic")),
    "red dye, lamp F2": ball(F2, medium(DYE)),
    "red dye, lamp F11": ball(F11, medium(DYE)),
    "red haze, lamp F11": ball(F11, medium(HAZE), 50),
    "sheet of glass LASF9, lamp F11": (sky(F11) + SHEET, 3),
    "ball of glass LASF9 before orange": (sky(D65) + diffuse(ORANGE) + WALL + glass("LASF9") + BALL, 9),
    "ball of glass F11 before orange": (sky(D65) + diffuse(ORANGE) + WALL + glass("F11") + BALL, 9),
}


def run(*command):
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, command))} ends with {done.returncode}:\n{done.stdout}{done.stderr}")


def main():
    parser = argparse.ArgumentParser(description="Compares colours with those of pbrt-v4.")
    parser.add_argument("--pbrt", default="pbrt", help="pbrt-v4's program")
    parser.add_argument("--petzval", default="target/release/petzval", help="petzval's program")
    parser.add_argument("--only", default="", help="part of the names of the scenes to compare")
    options = parser.parse_args()
    print("| scene | RGB: red | green | blue | spectra: red | green | blue | noise |\n|---|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for number, (name, (text, depth)) in enumerate(SCENES.items()):
            if options.only not in name:
                continue
            scene = Path(folder) / f"{number}.pbrt"
            scene.write_text(HEAD % (1024, depth) + text)
            means = []
            for seed in range(2):
                picture = scene.with_suffix(f".{seed}.exr")
                run(options.pbrt, "--quiet", "--seed", str(seed), "--outfile", picture, scene)
                means.append(pictures.read(picture).mean((0, 1)))
            theirs = np.mean(means, 0)
            noise = np.abs((means[0] - means[1]) / theirs).max()
            row = []
            for effects in ("-spectra", "+spectra"):
                picture = scene.with_suffix(".petzval.exr")
                command = [options.petzval, "render", scene, "-o", picture, "--spp", "1024", f"--effects={effects}"]
                run(*command)
                row += [f"{100 * (a / b - 1):+.2f} %" for a, b in zip(pictures.read(picture).mean((0, 1)), theirs)]
            print(f"| {name} | {' | '.join(row)} | {100 * noise:.2f} % |", flush=True)


if __name__ == "__main__":
    main()
