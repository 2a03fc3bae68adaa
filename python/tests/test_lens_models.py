"""Models of a lens: their errors within a budget of time."""

import pytest

import petzval as pz


def test_models_are_compared_with_the_richest(scene_path):
    shares = []
    rows = pz.lens_models(scene_path, resolution=(24, 16), budget=20, spp=64, progress=shares.append)
    names = [row["model"] for row in rows]
    assert {"real f32", "real f64"} <= set(names) and any("pinhole" in name for name in names)
    last = {row["model"]: row for row in rows}
    pinhole = next(row for name, row in last.items() if "pinhole" in name)
    # The rays of a pinhole are far from those of the lens, those in f32 are not.
    assert pinhole["film_error"] > 1 > 100 * last["real f32"]["film_error"]
    assert pinhole["error"] > last["real f32"]["error"]
    assert last["real f64"]["own_error"] is None and pinhole["own_error_at_most"] > 0
    assert all(row["spp"] <= 64 and row["seconds"] > 0 for row in rows)
    assert any(row["best"] for row in rows)
    assert shares == sorted(shares) and shares[-1] <= 1


def test_what_cannot_be_compared_is_refused(scene_path, tmp_path):
    with pytest.raises(ValueError, match="budget"):
        pz.lens_models(scene_path, budget=0)
    with pytest.raises(RuntimeError, match="longer budget"):
        pz.lens_models(scene_path, budget=1e-3)
    with pytest.raises(TypeError, match="speed"):
        pz.lens_models(scene_path, speed=3)
    pinhole = tmp_path / "pinhole.pbrt"
    pinhole.write_text('Camera "perspective" WorldBegin Shape "sphere"')
    with pytest.raises(ValueError, match="no lens file"):
        pz.lens_models(pinhole)


def test_a_failing_progress_ends_the_comparison(scene_path):
    def fail(share):
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        pz.lens_models(scene_path, budget=60, progress=fail)
