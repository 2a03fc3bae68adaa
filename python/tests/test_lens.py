"""Lenses: their data, and rays against a tracer in plain NumPy."""

import numpy as np
import pytest

import petzval as pz


def naive_trace(lens, points, directions):
    """Trace rays from the scene through spheres and planes, one surface after another, in float64."""
    p, d = np.array(points, dtype=np.float64), np.array(directions, dtype=np.float64)
    d /= np.linalg.norm(d, axis=0)
    status = np.zeros(p.shape[1], dtype=int)
    before = 1.0
    for number, surface in enumerate(lens.surfaces, start=1):
        radius, after = surface["radius"], surface["index"]
        with np.errstate(invalid="ignore"):
            if np.isinf(radius):
                p = p - d * (p[2] / d[2])
                normal = np.array([[0.0], [0.0], [-1.0]]) * np.ones_like(p)
            else:
                centre = p - np.array([[0.0], [0.0], [radius]])
                b = (centre * d).sum(0)
                root = np.sqrt(b * b - (centre * centre).sum(0) + radius * radius)
                p = p + d * (-b - root if radius > 0 else -b + root)
                normal = (p - np.array([[0.0], [0.0], [radius]])) / radius
            cos = -(d * normal).sum(0)
            ratio = before / after
            inside = 1 - ratio**2 * (1 - cos**2)
            d = ratio * d + (ratio * cos - np.sqrt(inside)) * normal
            passes = (np.hypot(p[0], p[1]) <= surface["diameter"] / 2) & (inside >= 0)
        status[(status == 0) & ~passes] = number
        before = after
        if number < len(lens.surfaces):
            p = p - np.array([[0.0], [0.0], [surface["thickness"]]])
    p[:, status > 0] = d[:, status > 0] = np.nan
    return p, d, status


def rays(lens, count, seed=1):
    random = np.random.default_rng(seed)
    reach = 0.7 * lens.surfaces[0]["diameter"]
    points = np.zeros((3, count))
    points[:2] = random.uniform(-reach, reach, (2, count))
    points[2] = -20
    directions = np.ones((3, count))
    directions[:2] = random.uniform(-0.2, 0.2, (2, count))
    points[:2] -= 20 * directions[:2]
    return points.astype(np.float32), directions.astype(np.float32)


def test_a_lens_has_its_first_order_data(lens_path):
    lens = pz.Lens(lens_path)
    assert abs(lens.efl - 50) < 1
    assert 1.5 < lens.fno < 3
    assert len(lens.surfaces) == 11
    assert lens.surfaces[lens.stop]["stop"]
    # An object at 1 m is farther behind the lens than one at infinity.
    assert lens.focus(1000.0) > lens.focus() > lens.bfd - 1


def test_rays_agree_with_a_plain_tracer(lens_path):
    lens = pz.Lens(lens_path)
    points, directions = rays(lens, 20_000)
    p, d, status = lens.trace(points, directions)
    expected_p, expected_d, expected_status = naive_trace(lens, points, directions)
    assert p.shape == d.shape == (3, 20_000) and p.dtype == d.dtype == np.float32
    assert status.dtype == np.uint16
    # Rounding decides at rims.
    assert (status != expected_status).mean() < 1e-3
    passed = (status == 0) & (expected_status == 0)
    assert 1000 < passed.sum() < 19_000
    assert len(np.unique(status)) > 4
    assert np.abs(p - expected_p)[:, passed].max() < 2e-4
    assert np.abs(d - expected_d)[:, passed].max() < 2e-5
    assert np.isnan(p[:, status > 0]).all() and np.isnan(d[:, status > 0]).all()


def test_a_ray_goes_back_where_it_came_from(lens_path):
    lens = pz.Lens(lens_path)
    points, directions = rays(lens, 2000, seed=2)
    p, d, status = lens.trace(points, directions)
    passed = status == 0
    # Behind the lens, start the reversed rays in the plane of the rear vertex.
    p, d = p[:, passed], d[:, passed]
    start = p - d * (p[2] / d[2])
    mirror = np.array([[1], [1], [-1]], dtype=np.float32)
    back, direction, back_status = lens.trace(start * mirror, -d * mirror, side="film")
    assert (back_status == 0).mean() > 0.99
    ok = back_status == 0
    unit = directions / np.linalg.norm(directions, axis=0)
    assert np.abs(direction * mirror + unit[:, passed])[:, ok].max() < 2e-4


def test_a_lens_of_a_table_has_the_power_of_its_formula():
    lens = pz.Lens.from_table(
        [(0.0, 1.0, 0.0, 10.0), (50.0, 5.0, 1.5168, 20.0), (-50.0, 40.0, 1.0, 20.0)], name="mine"
    )
    # The lensmaker's equation for a thick lens.
    n, r, t = 1.5168, 50.0, 5.0
    power = (n - 1) * (2 / r - (n - 1) * t / (n * r * r))
    assert abs(lens.efl - 1 / power) < 1e-3
    with pytest.raises(ValueError, match="radius|stop|surface"):
        pz.Lens.from_table([])
    with pytest.raises(ValueError):
        pz.Lens.from_table([(50.0, 5.0, float("nan"), 20.0)])


def test_rows_make_a_lens(scene_path):
    rows = [(50.0, 5.0, 1.5168, 20.0), (-50.0, 2.0, 1.0, 20.0), (0.0, 1.0, 0.0, 10.0)]
    lens = pz.Lens(np.array(rows))
    assert lens.efl == pz.Lens.from_table(rows).efl
    assert pz.render(scene_path, lens=lens, effects="none").pixels.mean() > 0
    # Messages name the row, not the file that holds it.
    with pytest.raises(ValueError, match=r'^rows\[1\]: "NaN" is not'):
        pz.Lens([rows[0], (np.nan, 1, 1, 1), rows[2]])
    with pytest.raises(ValueError, match="^rows: no surface"):
        pz.Lens([])
    with pytest.raises(ValueError, match="expected a path, or rows"):
        pz.Lens([(1, 2, 3)])
    for wrong in (None, 3, [(1, 2, 3, "BK7")]):
        with pytest.raises(TypeError, match="expected a path, or rows"):
            pz.Lens(wrong)
    with pytest.raises(TypeError, match="catalogue=3: expected the path"):
        pz.Lens(rows, catalogue=3)


def test_colours_leave_a_lens_in_different_directions(root):
    lens = pz.Lens(root / "lenses" / "triplet.toml")
    points, directions = np.array([[3.0], [0.0], [-1.0]]), np.array([[0.0], [0.0], [1.0]])
    slopes = {}
    for nm in (None, 486.1, 587.6, 656.3):
        _, d, status = lens.trace(points, directions, wavelength=nm)
        assert status[0] == 0
        slopes[nm] = float(d[0, 0])
    assert slopes[None] == pytest.approx(slopes[587.6], abs=1e-7)
    assert slopes[486.1] != slopes[656.3] != slopes[587.6]
    with pytest.raises(ValueError, match="wavelength"):
        lens.trace(points, directions, wavelength=-3.0)


def test_arrays_of_other_types_and_layouts_are_read(lens_path):
    lens = pz.Lens(lens_path)
    points, directions = rays(lens, 100)
    expected, _, _ = lens.trace(points, directions)
    for p, d in [
        (points.astype(np.float64), directions.astype(np.float64)),
        (np.asfortranarray(points), np.asfortranarray(directions)),
        (points.tolist(), directions.tolist()),
        (np.repeat(points, 2, axis=1)[:, ::2], np.repeat(directions, 2, axis=1)[:, ::2]),
    ]:
        found, _, _ = lens.trace(p, d)
        np.testing.assert_array_equal(found, expected)
    empty, _, status = lens.trace(np.zeros((3, 0)), np.zeros((3, 0)))
    assert empty.shape == (3, 0) and status.shape == (0,)


def test_arrays_of_an_earlier_call_take_the_result(lens_path):
    lens = pz.Lens(lens_path)
    points, directions = rays(lens, 3000)
    first = lens.trace(points, directions)
    other = lens.trace(points[:, ::-1], directions)
    again = lens.trace(points, directions, out=other)
    for mine, expected, array in zip(again, first, other):
        assert mine is array
        np.testing.assert_array_equal(mine, expected)
    for out in [(first[0], first[1], first[2][1:]), (first[0][:2], first[1], first[2])]:
        with pytest.raises(ValueError, match="out: expected"):
            lens.trace(points, directions, out=out)
    # One array cannot take points and directions.
    with pytest.raises(ValueError, match="out"):
        lens.trace(points, directions, out=(first[0], first[0], first[2]))
    read_only = first[0].copy()
    read_only.setflags(write=False)
    with pytest.raises(ValueError, match="out"):
        lens.trace(points, directions, out=(read_only, first[1], first[2]))
    # Arrays whose columns are together would be filled in the wrong order.
    for turned in (np.asfortranarray(first[0]), first[0].astype(np.float64), None):
        with pytest.raises((TypeError, ValueError), match="out: expected arrays in C order"):
            lens.trace(points, directions, out=(turned, first[1], first[2]))


@pytest.mark.parametrize("length", [1e30, 1e-30])
def test_directions_may_have_any_length(lens_path, length):
    lens = pz.Lens(lens_path)
    points, directions = rays(lens, 3000)
    plain = lens.trace(points, directions)
    scaled = lens.trace(points, directions * np.float32(length))
    np.testing.assert_array_equal(scaled[2] == 0, plain[2] == 0)
    np.testing.assert_allclose(scaled[1], plain[1], atol=1e-5)


def test_nonsense_is_refused(lens_path, tmp_path):
    lens = pz.Lens(lens_path)
    with pytest.raises(ValueError, match="4 x 2; expected 3 x N"):
        lens.trace(np.zeros((4, 2)), np.zeros((3, 2)))
    with pytest.raises(ValueError, match="2 points but 1 directions"):
        lens.trace(np.zeros((3, 2)), np.zeros((3, 1)))
    with pytest.raises(ValueError, match='expected "scene" or "film"'):
        lens.trace(np.zeros((3, 2)), np.zeros((3, 2)), side="top")
    with pytest.raises((TypeError, ValueError)):
        lens.trace("rays", np.zeros((3, 2)))
    with pytest.raises(FileNotFoundError, match="none.dat"):
        pz.Lens(tmp_path / "none.dat")
    with pytest.raises(ValueError, match="nearest"):
        lens.focus(10.0)
    with pytest.raises(ValueError, match="distance=NaN"):
        lens.focus(np.nan)
    # A wavelength in um or in m.
    for wavelength in (0.55, 550e-9):
        with pytest.raises(ValueError, match="expected nm"):
            lens.trace(np.zeros((3, 2)), np.ones((3, 2)), wavelength=wavelength)
    broken = tmp_path / "broken.dat"
    broken.write_text("58.950 7.520 1.670 50.4\nfifty 0.24 1 50.4\n")
    with pytest.raises(ValueError, match="broken.dat:2"):
        pz.Lens(broken)
    # Rays without a direction end somewhere; they are no numbers.
    p, _, status = lens.trace(np.zeros((3, 1)), np.zeros((3, 1)))
    assert np.isnan(p).all() and status[0] > 0


def test_a_camera_matrix_is_that_of_the_lens(lens_path):
    lens = pz.Lens(lens_path)
    fit = lens.intrinsics((600, 400), 36.0)
    assert fit["matrix"].shape == (3, 3)
    # The focal length in pixels of 60 um.
    assert abs(fit["matrix"][0, 0] * 0.06 - lens.efl) < 0.5
    assert len(fit["distortion"]) == len(fit["names"])
    assert fit["rms"] <= fit["max"] < 0.5
    named = lens.intrinsics((600, 400), 36.0, model=fit["model"])
    assert named["model"] == fit["model"]
    # Maps that do not fit into memory would end the process.
    for resolution in [(0, 4), (-1, 4), (10**6, 10**6), (2**40, 1)]:
        for method in (lens.st_map, lens.intrinsics):
            with pytest.raises(ValueError, match=r"resolution=\(.*134217728 pixels at most"):
                method(resolution, 36.0)
    with pytest.raises(ValueError, match="width=-36"):
        lens.st_map((6, 4), -36.0)
    with pytest.raises(ValueError, match="expected one of"):
        lens.intrinsics((600, 400), 36.0, model="pinhole camera")
