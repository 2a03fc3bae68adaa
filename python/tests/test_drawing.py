"""Drawings of lenses: matplotlib and SVG show the same lines."""

import sys
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

import petzval as pz
from petzval import drawing

SVG = "{http://www.w3.org/2000/svg}"


def places(polyline):
    """Return the points of a line in an SVG drawing (pixels)."""
    return np.array([point.split(",") for point in polyline.get("points").split()], dtype=float)


def test_a_notebook_shows_a_lens_as_svg(lens_path):
    lens = pz.Lens(lens_path)
    assert lens._repr_svg_() == lens.svg()
    root = ElementTree.fromstring(lens.svg(rays=5))
    lines = drawing.section(lens, rays=5)
    polylines = root.findall(f"{SVG}polyline")
    assert [line.get("class") for line in polylines] == [line.kind for line in lines]
    width, height = float(root.get("width")), float(root.get("height"))
    for polyline, line in zip(polylines, lines):
        points = places(polyline)
        assert len(points) == len(line.z)
        assert (points >= 0).all() and (points[:, 0] <= width).all() and (points[:, 1] <= height).all()
    # One scale for both axes, and up is up: the glass of the front reaches as high as its rim.
    ends = {kind: places(next(p for p in polylines if p.get("class") == kind)) for kind in ("glass", "axis")}
    glass = next(line for line in lines if line.kind == "glass")
    axis = next(line for line in lines if line.kind == "axis")
    scale = np.ptp(ends["axis"][:, 0]) / np.ptp(axis.z)
    assert np.ptp(ends["glass"][:, 1]) == pytest.approx(scale * lens.surfaces[0]["diameter"], rel=1e-3)
    assert (ends["glass"][-1, 1] < ends["glass"][0, 1]) == (glass.y[-1] > glass.y[0])
    assert len([line for line in lines if line.kind == "inside"]) == 5
    assert drawing.title(lens) == root.find(f"{SVG}text").text


def test_names_are_escaped_and_the_film_moves():
    table = [(0, 1, 0, 10), (50, 5, 1.5168, 20), (-50, 0, 1, 20)]
    lens = pz.Lens.from_table(table, name="<&>")
    root = ElementTree.fromstring(lens.svg(film_distance=80.0))
    assert root.find(f"{SVG}text").text.startswith("<&>")
    film = next(line for line in drawing.section(lens, film_distance=80.0) if line.kind == "film")
    assert film.z == pytest.approx([86.0, 86.0])


def test_without_matplotlib_the_error_says_how_to_get_it(monkeypatch, lens_path):
    monkeypatch.setitem(sys.modules, "matplotlib.pyplot", None)
    with pytest.raises(ImportError, match="pip install matplotlib, or use Lens.svg"):
        pz.Lens(lens_path).draw()
