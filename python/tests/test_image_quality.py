"""Spots, MTF and point images, against formulas and against the command's report."""

import json
import subprocess

import numpy as np
import pytest

import petzval as pz


@pytest.fixture
def quality(lens_path):
    return pz.Lens(lens_path).image_quality(image_height=15.0, fields=4)


def test_fields_go_from_the_axis_to_the_edge(quality):
    assert quality.fields[0] == 0 and (np.diff(quality.fields) > 0).all()
    assert len(quality.fields) == 4
    assert abs(abs(quality.image_heights[-1]) - 15) < 1
    assert quality.field_kind in ("angle", "image_height")
    assert quality.wavelengths


def test_the_mtf_starts_at_one_and_stays_below_that_of_a_perfect_lens(quality):
    frequencies = [0.0, 10.0, 20.0, 50.0]
    tangential, sagittal = quality.mtf(frequencies)
    limits = quality.mtf(frequencies, "limit")
    assert tangential.shape == sagittal.shape == (4, 4)
    np.testing.assert_allclose(tangential[:, 0], 1, atol=1e-9)
    assert (tangential <= limits[0] + 1e-6).all() and (sagittal <= limits[1] + 1e-6).all()
    # On the axis both directions are the same.
    np.testing.assert_allclose(tangential[0], sagittal[0], atol=1e-6)
    defocused, _ = quality.mtf(frequencies, defocus=0.3)
    assert defocused[0, 2] < 0.5 * tangential[0, 2]


def test_the_mtf_is_the_fourier_transform_of_the_spot(quality):
    frequencies = [5.0, 15.0, 30.0]
    tangential, sagittal = quality.mtf(frequencies, "geometric")
    for k in range(4):
        spot = quality.spot(k)
        light = spot["light"] / spot["light"].sum()
        for axis, found in ((1, tangential[k]), (0, sagittal[k])):
            phase = 2e-3 * np.pi * np.outer(frequencies, spot["points"][:, axis])
            expected = np.abs((np.exp(1j * phase) * light).sum(1))
            # Each cell of the pupil has an extent, a ray has none.
            np.testing.assert_allclose(found, expected, atol=0.02)


def test_spots_and_point_images_belong_together(quality):
    spot = quality.spot(1)
    light = spot["light"] / spot["light"].sum()
    centroid = (spot["points"] * light[:, None]).sum(0)
    np.testing.assert_allclose(centroid, spot["centroid"], atol=1e-6)
    rms = np.sqrt((((spot["points"] - centroid) ** 2).sum(1) * light).sum())
    # Each cell of the pupil has an extent, a ray has none.
    assert rms == pytest.approx(spot["rms"], rel=0.01)
    image, data = quality.psf(1, size=128)
    assert image.shape == (128, 128) and 0 < data["strehl"] <= 1.001
    assert 0.8 < image.sum() < 1.02
    with pytest.raises(IndexError, match="there are 4"):
        quality.spot(4)
    with pytest.raises(ValueError, match="resolve"):
        quality.psf(0, width=1e9)


def test_the_mtf_is_that_of_the_command(lens_path, command):
    arguments = [command, "lens", "report", str(lens_path), "--json", "mtf", "--image-height", "15"]
    run = subprocess.run(arguments, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    report = json.loads(run.stdout)
    rows = _table(report, "field", "frequency")
    names = rows["columns"]
    tangential = next(i for i, name in enumerate(names) if "diffraction" in name and "tang" in name)
    quality = pz.Lens(lens_path).image_quality(image_height=15.0, fields=len({row[0] for row in rows["rows"]}))
    checked = 0
    for row in rows["rows"]:
        k = np.flatnonzero(np.isclose(quality.fields, row[0], atol=1e-9))
        if k.size and row[tangential] is not None:
            found, _ = quality.mtf([row[1]])
            assert found[k[0], 0] == pytest.approx(row[tangential], abs=2e-3)
            checked += 1
    assert checked > 50


def _table(report, *columns):
    """Return the first table in a report whose first columns have these words in their names."""
    found = []

    def search(part):
        if isinstance(part, dict):
            names = part.get("columns")
            if names and len(names) >= len(columns) and all(w in n for w, n in zip(columns, names)):
                found.append(part)
            for value in part.values():
                search(value)
        elif isinstance(part, list):
            for value in part:
                search(value)

    search(report)
    assert found, report
    return found[0]


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"fields": 1}, "fields"),
        ({"rays": 100_000}, "rays"),
        ({"rays": -4}, "rays=-4"),
        ({"fields": 1000, "rays": 512}, "fields x rays x rays up to"),
        ({"image_height": -5.0}, "height"),
        ({"distance": 1.0}, "nearest|focus"),
    ],
)
def test_conditions_that_make_no_sense_are_refused(lens_path, settings, message):
    with pytest.raises(ValueError, match=message):
        pz.Lens(lens_path).image_quality(**settings)


def test_arguments_that_make_no_sense_are_refused(quality):
    with pytest.raises(ValueError, match="10000 at most"):
        quality.mtf(np.zeros(20_000))
    for wrong in (20, None, ["a"]):
        with pytest.raises(TypeError, match="frequencies=.*: expected a list"):
            quality.mtf(wrong)
    with pytest.raises(ValueError, match="defocus=inf"):
        quality.spot(0, defocus=np.inf)
    for field in (-1, 99):
        with pytest.raises(IndexError, match=f"field {field}: there are"):
            quality.psf(field)
    with pytest.raises(ValueError, match="count=-1"):
        quality.distortion(-1)


@pytest.mark.parametrize("drawing", [{"rays": -1}, {"rays": 10**9}, {"film_distance": np.nan}])
def test_drawings_that_make_no_sense_are_refused(lens_path, drawing):
    with pytest.raises(ValueError, match=next(iter(drawing))):
        pz.Lens(lens_path).svg(**drawing)


def test_a_section_is_drawn(lens_path, tmp_path):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("agg")
    ax = pz.Lens(lens_path).draw(rays=5)
    ax.figure.savefig(tmp_path / "lens.png")
    assert (tmp_path / "lens.png").stat().st_size > 5000
    # Ten surfaces and the axis, the film, two blades of the stop, four elements and three lines a ray.
    assert len(ax.lines) > 25
