"""Paths of the repository, and a small scene."""

import os
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def root():
    return ROOT


@pytest.fixture
def lens_path():
    return ROOT / "lenses" / "dgauss.50mm.dat"


@pytest.fixture
def scene_path(tmp_path, lens_path):
    """A ball before a wall, under a sky."""
    path = tmp_path / "ball.pbrt"
    path.write_text(
        f"""
        Film "rgb" "integer xresolution" 48 "integer yresolution" 32
        Sampler "zsobol" "integer pixelsamples" 4
        Camera "realistic" "string lensfile" "{lens_path}" "float focusdistance" 2
        WorldBegin
        LightSource "infinite" "rgb L" [0.4 0.45 0.5]
        Material "diffuse" "rgb reflectance" [0.6 0.3 0.2]
        AttributeBegin Translate 0 0 2 Shape "sphere" "float radius" 0.2 AttributeEnd
        Shape "trianglemesh" "point3 P" [-3 -3 4  3 -3 4  3 3 4  -3 3 4]
            "integer indices" [0 2 1 0 3 2]
        """
    )
    return path


@pytest.fixture
def command():
    """The command petzval, if PETZVAL_COMMAND names it."""
    path = os.environ.get("PETZVAL_COMMAND")
    if not path:
        pytest.skip("PETZVAL_COMMAND does not name the command petzval")
    return str((ROOT / path).resolve())
