"""Small data sets for the tests of exports."""

import json

import petzval as pz

WIDTH, HEIGHT = 24, 16
SCENE = """
Film "rgb" "integer xresolution" 24 "integer yresolution" 16 "float diagonal" 43 {film}
PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5
{world}
LookAt 0.3 0.2 -0.1  0.1 0.1 2  0.1 1 0
Camera "realistic" "string lensfile" "{lens}" "float aperturediameter" 6 "float focusdistance" 2
WorldBegin
LightSource "infinite" "rgb L" [ 0.3 0.5 0.7 ]
ObjectBegin "two balls"
  Shape "sphere" "float radius" 0.05
  AttributeBegin Translate 0.09 0.05 0 Shape "sphere" "float radius" 0.04 AttributeEnd
ObjectEnd
AttributeBegin Translate -0.1 0.1 1 Shape "sphere" "float radius" 0.1 AttributeEnd
AttributeBegin Translate 0.25 -0.05 1.1 Shape "disk" "float radius" 0.07 AttributeEnd
AttributeBegin Translate 0.2 0.2 1 ObjectInstance "two balls" AttributeEnd
AttributeBegin Translate 0.0 -0.1 1 Rotate 40 0 0 1 ObjectInstance "two balls" AttributeEnd
Shape "trianglemesh" "point3 P" [-1 -1 2  0.3 -1 2  0.3 1 2  -1 1 2] "integer indices" [0 2 1 0 3 2]
"""
SPEC = """
pairs = {pairs}
resolution = {size}
spp = 16
layers = {layers}
psf = {psf}
[draw]
scene = {scenes}
{draw}
[degraded]
effects = "none"
sensor = "bayer=rggb"
"""
LAYERS = ["depth", "position", "object", "albedo", "vignetting"]
#: The shapes of the scene.
BALL, CARD, WALL = 2, 3, 4


def render_set(
    folder,
    lens_path,
    *,
    film="",
    world="",
    draw="",
    scenes=("scene.pbrt",),
    layers=LAYERS,
    pairs=2,
    psf=False,
    size=(24, 16),
):
    """Return the folder of a new data set."""
    for name in scenes:
        (folder / name).write_text(SCENE.format(film=film, world=world, lens=lens_path))
    values = dict(pairs=pairs, layers=layers, psf=psf, scenes=scenes, size=size)
    texts = {name: json.dumps(value) for name, value in values.items()}
    (folder / "spec.toml").write_text(SPEC.format(**texts, draw=draw))
    pz.dataset(folder / "spec.toml", folder / "set")
    return folder / "set"


def rows_of(folder):
    return [json.loads(line) for line in (folder / "manifest.jsonl").read_text().splitlines()]
