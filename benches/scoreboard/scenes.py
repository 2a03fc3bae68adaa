"""Scenes of the scoreboard: those of the repository, and two that this module describes.

A description is plain data (numbers, strings, lists), from which pbrt_text writes a scene file and
the children of Mitsuba and Cycles build theirs.
"""

import json
import math
import random
import re
import shutil
from dataclasses import dataclass
from pathlib import Path

import meshes
from pbrt_text import pbrt_text

REPOSITORY = Path(__file__).resolve().parents[2]

# Name, resolution and samples of the scenes in scenes/.
STORED = {
    "dgauss": ((300, 300), 64),
    "fisheye": ((300, 300), 64),
    "telephoto": ((300, 300), 64),
    "wide": ((300, 300), 64),
    "atelier": ((480, 320), 32),
    "night": ((450, 300), 32),
}


@dataclass
class Scene:
    """A scene, ready to be rendered."""

    name: str
    spp: int
    real: Path  # pbrt file with the lens's prescription
    thin: Path | None = None  # the same scene with a thin lens
    description: Path | None = None  # the same as data, with a thin lens


def names():
    return [*STORED, *GENERATED]


def prepare(name, folder):
    """Writes what a scene needs into a folder, and returns the scene."""
    if name in STORED:
        return prepare_stored(name, folder)
    scene, spp = GENERATED[name](folder)
    real, thin, data = (folder / f"{name}{end}" for end in (".pbrt", ".thin.pbrt", ".json"))
    real.write_text(pbrt_text(scene, "real"))
    thin.write_text(pbrt_text(scene, "thin"))
    data.write_text(json.dumps(scene))
    return Scene(name, spp, real, thin, data)


def prepare_stored(name, folder):
    """Copies a scene of the repository, with the changes that all renderers can read."""
    for part in ("scenes", "lenses"):
        if not (folder / part).exists():
            skip = shutil.ignore_patterns("gallery", "slurm", "*.exr", "*.petzval", "*.checkpoint")
            shutil.copytree(REPOSITORY / part, folder / part, ignore=skip)
            if part == "scenes":
                replace_cones(folder / part)
    path = folder / "scenes" / f"{name}.pbrt"
    text = path.read_text()
    (width, height), spp = STORED[name]
    text = re.sub(r'("integer xresolution") +\d+', rf"\1 {width}", text)
    text = re.sub(r'("integer yresolution") +\d+', rf"\1 {height}", text)
    # pbrt-v4 has no "directlighting"; a path of one bounce is the same.
    text = text.replace('Integrator "directlighting"', 'Integrator "path" "integer maxdepth" 1')
    # pbrt rounds its film to half floats by default, and does not read lenses in TOML.
    text = text.replace('Film "rgb"', 'Film "rgb" "bool savefp16" false')
    text = text.replace("wide.22mm.pentagon.toml", "wide.22mm.dat")
    text = text.replace("double-gauss.50mm.toml", "dgauss.50mm.dat")
    path.write_text(text)
    return Scene(name, spp, path)


def replace_cones(folder):
    """Makes meshes of the cones in all scene files of a folder: pbrt-v4 has no cones."""
    for path in folder.rglob("*.pbrt"):

        def mesh(found, path=path):
            parameters = dict(re.findall(r'"float (\w+)"\s+([\d.]+)', found[0]))
            radius, height = float(parameters["radius"]), float(parameters["height"])
            file = f"cone {radius} {height}.ply"
            meshes.write_cone(path.parent / file, radius, height)
            # pbrt looks for files from the scene's folder on.
            return f'Shape "plymesh" "string filename" "{path.parent / file}"'

        cone = r'Shape "cone"(\s+"float \w+"\s+[\d.]+)+'
        path.write_text(re.sub(cone, mesh, path.read_text()))


def double_gauss(folder, focus):
    """Returns the lens dgauss.50mm.dat, focused at this distance from the film [m], wide open.

    The thin lens has the entrance pupil of the real one, in place and size, and its field of view;
    the numbers are those of `petzval lens lenses/dgauss.50mm.dat`, in mm.
    """
    focal, back_focus, length, pupil, pupil_diameter = 50.3582, 36.1059, 32.04, 19.9465, 24.8051
    front_focus = 27.1
    between = 1000 * focus - front_focus - length - back_focus
    extension = (between - math.sqrt(between**2 - 4 * focal**2)) / 2
    pupil_from_film = (back_focus + extension + length - pupil) / 1000
    half_side = 43.27 / math.sqrt(2) / 2
    half_object = half_side * focal / extension / 1000
    shutil.copy(REPOSITORY / "lenses" / "dgauss.50mm.dat", folder)
    return {
        "file": "dgauss.50mm.dat",
        "aperture": 17.1,
        "focus": focus,
        "diagonal": 43.27,
        "thin": {
            "advance": pupil_from_film,
            "radius": pupil_diameter / 2000,
            "focus": focus - pupil_from_film,
            "fov": math.degrees(2 * math.atan(half_object / (focus - pupil_from_film))),
        },
    }


def knot(folder):
    """One mesh of 550,800 triangles on a tiled floor, all diffuse."""
    meshes.write_knot(folder / "knot.ply")
    floor = [[-8, -0.8, 8], [8, -0.8, 8], [8, -0.8, -8], [-8, -0.8, -8]]
    meshes.write_quad(folder / "floor.ply", floor, (6, 6))
    window = [[-2.8, 4, -1.8], [-1.2, 4, -1.8], [-1.2, 4, -0.2], [-2.8, 4, -0.2]]
    meshes.write_quad(folder / "window.ply", window)
    meshes.write_tiles(folder / "tiles.png")
    scene = {
        "size": [512, 512],
        "depth": 5,
        "view": [[0.4, 2.2, -4.0], [0, 0, 0], [0, 1, 0]],
        "lens": double_gauss(folder, 4.2),
        "sky": [0.2, 0.25, 0.35],
        "materials": {"tiles": {"kind": "diffuse", "image": "tiles.png"}},
        "shapes": [
            {"mesh": "floor.ply", "flat": True, "material": "tiles"},
            {"mesh": "knot.ply", "material": "tiles"},
        ],
        "lights": [
            {"mesh": "window.ply", "L": [12, 11, 9]},
            {"sphere": [2.5, 2, -2], "radius": 0.25, "L": [6, 8, 12]},
        ],
    }
    return scene, 16


def still(folder):
    """Still life: diffuse, glossy, metal and glass surfaces, image textures and 201 lights."""
    meshes.write_knot(folder / "small knot.ply", 0.62)
    meshes.write_vase(folder / "vase.ply")
    table = [[-4, -0.8, 3], [4, -0.8, 3], [4, -0.8, -4], [-4, -0.8, -4]]
    meshes.write_quad(folder / "table.ply", table, (3, 3))
    wall = [[-6, -0.8, 3], [-6, 5, 3], [6, 5, 3], [6, -0.8, 3]]
    meshes.write_quad(folder / "wall.ply", wall, (3, 6))
    window = [[-3.4, 4, -2], [-1.8, 4, -2], [-1.8, 4, -0.4], [-3.4, 4, -0.4]]
    meshes.write_quad(folder / "window.ply", window)
    meshes.write_tiles(folder / "tiles.png")
    meshes.write_wood(folder / "wood.png")
    scene = {
        "size": [512, 512],
        "depth": 5,
        "view": [[0.3, 0.9, -4.4], [0, -0.2, 0], [0, 1, 0]],
        "lens": double_gauss(folder, 4.2),
        "sky": [0.06, 0.07, 0.1],
        "materials": {
            "table": {"kind": "coated", "image": "wood.png", "alpha": 0.1},
            "wall": {"kind": "diffuse", "image": "tiles.png"},
            "copper": {"kind": "metal", "color": [0.93, 0.62, 0.5], "alpha": 0.2},
            "steel": {"kind": "metal", "color": [0.6, 0.6, 0.62], "alpha": 0.08},
            "red": {"kind": "coated", "color": [0.5, 0.06, 0.05], "alpha": 0.15},
            "glass": {"kind": "glass", "ior": 1.5},
            "clay": {"kind": "diffuse", "color": [0.55, 0.45, 0.35]},
            "painted": {"kind": "diffuse", "image": "tiles.png"},
        },
        "shapes": [
            {"mesh": "table.ply", "flat": True, "material": "table"},
            {"mesh": "wall.ply", "flat": True, "material": "wall"},
            {"mesh": "small knot.ply", "move": [0.05, -0.42, 0.6], "material": "copper"},
            {"mesh": "vase.ply", "move": [-1.05, -0.8, -0.1], "material": "painted"},
            {"sphere": [0.55, -0.5, -1.2], "radius": 0.3, "material": "glass"},
            {"sphere": [-0.5, -0.55, -1.1], "radius": 0.25, "material": "red"},
            {"sphere": [1.15, -0.4, -0.1], "radius": 0.4, "material": "steel"},
            {"sphere": [0.02, -0.62, -1.35], "radius": 0.18, "material": "clay"},
        ],
        "lights": [{"mesh": "window.ply", "L": [9, 8.5, 7.5]}, *small_lights()],
    }
    return scene, 16


def small_lights():
    """Returns 160 small spheres that shine in four strings, and 40 point lights above them."""
    dice = random.Random(7)
    lights = []
    for row in range(4):
        for i in range(40):
            x = -4 + 8 * (i + 0.5) / 40 + 0.1 * dice.random()
            sag = 0.25 * math.cos(2 * math.pi * x / 2.7 + row)
            color = [dice.uniform(0.5, 1.5) for _ in range(3)]
            lights.append(
                {
                    "sphere": [x, 2.6 - sag - 0.2 * row, 2.4 - 1.6 * row],
                    "radius": 0.03 + 0.02 * dice.random(),
                    "L": [8 * c for c in color],
                }
            )
    for i in range(40):
        at = [dice.uniform(-4, 4), dice.uniform(2.8, 4), dice.uniform(-4, 2.6)]
        lights.append({"point": at, "I": [0.12 * dice.uniform(0.5, 1.5) for _ in range(3)]})
    return lights


GENERATED = {"knot": knot, "still": still}
