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


def test_point_images_have_a_wavelength_or_a_channel(root):
    lens = pz.Lens(root / "lenses/triplet.toml")
    quality = lens.image_quality(image_height=15.0, fields=4)
    size, width = 64, 40.0
    light = {nm: quality.psf(0, size, width, wavelength=nm) for nm in (450.0, 550.0, 650.0)}
    for image, data in light.values():
        assert image.shape == (size, size) and 0 < data["strehl"] <= 1.001 and 0.5 < image.sum() < 1.02
    # Each colour has its own focus and its own diffraction.
    assert len({round(data["strehl"], 4) for _, data in light.values()}) == 3
    # The light of all wavelengths is the sum of theirs.
    parts = [quality.psf(0, size, width, wavelength=nm)[0] for nm in quality.wavelengths]
    whole, _ = quality.psf(0, size, width)
    assert np.abs(np.mean(parts, 0) - whole).max() < 0.05 * whole.max()
    # A channel is between its wavelengths: red lies apart from blue off the axis.
    centres = [quality.psf(3, size, width, channel=name)[1]["centre"] for name in "RGB"]
    long, short = [quality.psf(3, size, width, wavelength=nm)[1]["centre"] for nm in (620.0, 460.0)]
    assert np.sign(centres[0][1] - centres[2][1]) == np.sign(long[1] - short[1])
    assert long[1] != short[1]
    short_form = lens.psf(1, image_height=15.0, fields=4, wavelength=550.0)
    np.testing.assert_array_equal(short_form[0], quality.psf(1, wavelength=550.0)[0])


def test_light_that_makes_no_sense_is_refused(quality):
    for wavelength in (0.55, -1.0, np.nan, np.inf, 1e9):
        with pytest.raises(ValueError, match="wavelength=.*: expected nm"):
            quality.psf(0, wavelength=wavelength)
    with pytest.raises(TypeError, match="wavelength"):
        quality.psf(0, wavelength="green")
    with pytest.raises(ValueError, match='channel="green": expected one of "R", "G", "B"'):
        quality.psf(0, channel="green")
    with pytest.raises(ValueError, match="not both"):
        quality.psf(0, wavelength=550.0, channel="G")


def test_a_glass_without_data_at_a_wavelength_is_named(root):
    quality = pz.Lens(root / "lenses/triplet.toml").image_quality(fields=2, rays=16)
    with pytest.raises(ValueError, match="20000 nm"):
        quality.psf(0, wavelength=20_000.0)


@pytest.mark.parametrize("wavelength", [486.1, 550.0, 656.3])
def test_the_point_image_of_a_wavelength_is_that_of_the_command(root, command, wavelength):
    lens = root / "lenses/triplet.toml"
    film = pz.Lens(lens).focus()
    options = ["--json", "psf", "--film-distance", str(film), "--wavelengths", str(wavelength)]
    options += ["--image-height", "15"]
    run = subprocess.run([command, "lens", "report", str(lens), *options], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    report = json.loads(run.stdout)
    sizes = _table(report, "field", "strehl")["rows"]
    rows = [row for row in _table(report, "field", "x_um")["rows"] if row[0] == 0]
    side = round(len(rows) ** 0.5)
    quality = pz.Lens(lens).image_quality(film_distance=film, image_height=15.0)
    # The command traces a finer grid where the image needs it.
    image, data = quality.psf(0, side, sizes[0][2], wavelength=wavelength)
    assert data["strehl"] == pytest.approx(sizes[0][1], rel=0.02)
    found = np.array([row[3] for row in rows]).reshape(side, side)
    assert np.abs(image - found).max() < 0.03 * found.max()
