"""Cameras, sweeps, passes, data sets, progress, foreign arrays and processes."""

import io
import json
import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import petzval as pz
from petzval import cpu
from petzval.progress import Bar


def test_a_camera_is_the_same_as_its_settings(scene_path, lens_path):
    camera = pz.Camera(
        lens=lens_path,
        pose=((0.1, 0, 0), (0, 0, 2)),
        film=30.0,
        focus=1.5,
        fstop=4,
        sensor="iso=800",
        resolution=(30, 20),
        film_shift=(1, 0),
    )
    settings = dict(
        lens=lens_path,
        look_at=((0.1, 0, 0), (0, 0, 2)),
        film_diagonal=30.0,
        focus=1.5,
        fstop=4,
        sensor="iso=800",
        resolution=(30, 20),
        film_shift=(1, 0),
    )
    assert camera.settings().keys() == settings.keys()
    expected = pz.render(scene_path, **settings).pixels
    np.testing.assert_array_equal(pz.render(scene_path, camera).pixels, expected)
    # Settings count before the camera.
    wide = pz.render(scene_path, camera, fstop=2.8).pixels
    assert not np.array_equal(wide, expected)
    with pytest.raises(TypeError, match="expected a petzval.Camera"):
        pz.render(scene_path, lens_path)


def test_sweeps_take_every_combination_once(scene_path):
    seen = []
    for changed, image in pz.sweep(scene_path, fstop=[4, 8], focus=[1.0, "auto"], resolution=(24, 16)):
        seen.append(tuple(changed.values()))
        expected = pz.render(scene_path, resolution=(24, 16), **changed).pixels
        np.testing.assert_array_equal(image.pixels, expected)
    assert seen == [(4, 1.0), (4, "auto"), (8, 1.0), (8, "auto")]
    with pytest.raises(ValueError, match="fstop: the list is empty"):
        pz.sweep(scene_path, fstop=[])
    with pytest.raises(FileNotFoundError):
        pz.sweep("none.pbrt", fstop=[2])


def test_passes_have_the_pictures_of_renders(scene_path):
    counts = []
    for image in pz.passes(scene_path, spp=11, effects="-diffraction", threads=1):
        counts.append(int(image.metadata["samplesPerPixel"]))
        expected = pz.render(scene_path, spp=counts[-1], effects="-diffraction").pixels
        np.testing.assert_array_equal(image.pixels, expected)
    assert counts == [1, 2, 4, 8, 11]
    # The first picture of a render that would take hours, and its end.
    first = next(iter(pz.passes(scene_path, spp=2**30, resolution=(300, 200))))
    assert first.size == (300, 200)


def test_progress_is_a_bar_or_a_function(scene_path, capsys):
    pz.render(scene_path, spp=1, progress=True)
    assert "100 %" in capsys.readouterr().err
    shares = []
    pz.render(scene_path, spp=1, progress=shares.append)
    assert shares[-1] == 1.0 and all(0 <= share <= 1 for share in shares)
    with pytest.raises(TypeError, match="progress"):
        pz.render(scene_path, progress="yes")
    with pytest.raises(ZeroDivisionError):
        pz.render(scene_path, spp=4, progress=lambda share: 1 / 0)
    file = io.StringIO()
    bar = Bar(file, width=10)
    bar(0.5), bar(0.501), bar(1.0)
    assert file.getvalue().count("\r") == 2 and "[#####.....]  50 %" in file.getvalue()


SPEC = """
pairs = 3
resolution = [40, 30]
spp = 4
layers = ["depth"]
[draw]
scene = "ball.pbrt"
focus = { from = 1.0, to = 4.0 }
"""


def test_a_data_set_has_the_bits_of_the_command(scene_path, tmp_path, command):
    spec = tmp_path / "spec.toml"
    spec.write_text(SPEC)
    shares = []
    rows = pz.dataset(spec, tmp_path / "a", progress=shares.append)
    assert [row["pair"] for row in rows] == [0, 1, 2] and shares[-1] == 1.0
    subprocess.run(
        [command, "dataset", "spec.toml", "-o", "b"], cwd=tmp_path, check=True, capture_output=True
    )
    for name in ["000001.clean.exr", "000002.degraded.exr"]:
        mine, its = (pz.read_image(tmp_path / folder / name) for folder in "ab")
        np.testing.assert_array_equal(mine, its)
    # Each goes on with what the other has begun, and parts add up.
    before = (tmp_path / "b" / "000000.clean.exr").stat().st_mtime_ns
    assert len(pz.dataset(spec, tmp_path / "b")) == 3
    assert (tmp_path / "b" / "000000.clean.exr").stat().st_mtime_ns == before
    parts = [pz.dataset(spec, tmp_path / "c", shard=(i, 2)) for i in (1, 2)]
    assert sorted(row["pair"] for part in parts for row in part) == [0, 1, 2]


def test_passes_take_all_samples(scene_path):
    for setting in ({"noise": 0.1}, {"time": 1.0}):
        with pytest.raises(ValueError, match="passes take all samples"):
            pz.passes(scene_path, **setting)


def test_lists_that_are_none_are_refused(scene_path, tmp_path):
    with pytest.raises(TypeError, match="spp=4: expected a list"):
        pz.accuracy(scene_path, spp=4)
    for shard in (3, (1, 2, 3), "1/4"):
        with pytest.raises(TypeError, match="shard=.*: expected"):
            pz.dataset(tmp_path / "spec.toml", tmp_path / "out", shard=shard)


def test_files_that_are_cut_off_are_value_errors(tmp_path):
    for name in ("a.png", "a.exr", "a.jpg"):
        path = tmp_path / name
        pz.write_image(path, np.full((8, 8, 3), 0.5, np.float32))
        path.write_bytes(path.read_bytes()[:40])
        with pytest.raises(ValueError, match=name):
            pz.read_image(path)


def test_wrong_data_sets_are_refused(tmp_path, scene_path):
    spec = tmp_path / "spec.toml"
    spec.write_text(SPEC + "nonsense = 3\n")
    with pytest.raises(ValueError, match="spec.toml"):
        pz.dataset(spec, tmp_path / "out")
    with pytest.raises(FileNotFoundError, match="none.toml"):
        pz.dataset(tmp_path / "none.toml", tmp_path / "out")
    spec.write_text(SPEC)
    for shard in [(0, 2), (3, 2)]:
        with pytest.raises(ValueError, match="shard"):
            pz.dataset(spec, tmp_path / "out", shard=shard)
    (tmp_path / "file").write_text("")
    with pytest.raises(FileExistsError, match="cannot write"):
        pz.dataset(spec, tmp_path / "file")
    spec.write_text(SPEC.replace("ball.pbrt", "gone.pbrt"))
    with pytest.raises((FileNotFoundError, ValueError), match="gone.pbrt"):
        pz.dataset(spec, tmp_path / "out")


def rays(count=64):
    points = np.zeros((3, count), np.float32)
    points[0] = np.linspace(-8, 8, count)
    points[2] = -1
    directions = np.zeros_like(points)
    directions[2] = 1
    return points, directions


def test_rays_of_foreign_arrays_are_those_of_plain_ones(lens_path):
    lens = pz.Lens(lens_path)
    points, directions = rays()
    expected = lens.trace(points, directions)[0]
    record = np.zeros(64, dtype=[("status", "u1"), ("p", "<f4", 3)])
    record["p"] = points.T
    raw = np.frombuffer(b"x" + points.tobytes(), dtype=np.uint8)[1:]
    misaligned = raw.view(np.float32).reshape(3, 64)
    assert not misaligned.flags.aligned
    foreign = {
        "fields of records": record["p"].T,
        "misaligned": misaligned,
        "Fortran order": np.asfortranarray(points),
        "double": points.astype(np.float64),
        "big-endian": points.astype(">f4"),
        "strided": np.repeat(points, 3, axis=1)[:, ::3],
        "reversed": points[:, ::-1][:, ::-1],
        "lists": points.tolist(),
        "locked": points.copy(),
    }
    foreign["locked"].flags.writeable = False
    for name, array in foreign.items():
        found = lens.trace(array, directions)[0]
        np.testing.assert_array_equal(found, expected, err_msg=name)
    for wrong in [points.astype(complex), points.astype(str), None, object()]:
        with pytest.raises((TypeError, ValueError)):
            lens.trace(wrong, directions)
    for shape in [(3,), (3, 4, 5), (2, 64), ()]:
        with pytest.raises(ValueError, match="expected 3 x N"):
            lens.trace(np.zeros(shape, np.float32), directions)


def test_pictures_of_foreign_arrays(tmp_path):
    pixels = np.random.default_rng(1).random((6, 5, 3)).astype(np.float32)
    for array in [pixels.astype(">f8"), np.asfortranarray(pixels), pixels[::-1][::-1]]:
        pz.write_image(tmp_path / "a.exr", array)
        np.testing.assert_array_equal(pz.read_image(tmp_path / "a.exr"), pixels)
    with pytest.raises(TypeError, match="uint8; expected floats"):
        pz.compare((255 * pixels).astype(np.uint8), pixels)
    wrong = pixels.copy()
    wrong[2, 3, 1] = np.nan
    with pytest.raises(ValueError, match="picture: the pixel 3, 2 is not finite"):
        pz.compare(wrong, pixels)
    high, low = (pz.compare(pixels, pixels[::-1], "flip", dynamic_range=r) for r in ("high", "low"))
    assert high > 0 and low > 0 and high != low
    with pytest.raises(ValueError, match="dynamic_range"):
        pz.compare(pixels, pixels, dynamic_range="medium")


def test_an_image_is_an_array(scene_path):
    image = pz.render(scene_path, spp=1)
    np.testing.assert_array_equal(np.asarray(image), image.pixels)
    assert np.asarray(image, dtype=np.float64).dtype == np.float64
    assert np.array(image) is not image.pixels


def test_counts_outside_their_range_are_value_errors(scene_path):
    for setting in [{"spp": -1}, {"spp": 0}, {"spp": 2**40}, {"seed": -1}, {"threads": -2}]:
        with pytest.raises(ValueError, match=next(iter(setting))):
            pz.render(scene_path, **setting)
    for setting in [{"spp": 1.5}, {"seed": "x"}]:
        with pytest.raises(TypeError, match=next(iter(setting))):
            pz.render(scene_path, **setting)


def test_missing_files_inside_a_scene_are_file_errors(tmp_path):
    scene = tmp_path / "a.pbrt"
    for line in [
        'Include "gone.pbrt"',
        'Shape "plymesh" "string filename" "gone.ply"',
        'Texture "t" "spectrum" "imagemap" "string filename" "gone.png"',
    ]:
        scene.write_text("WorldBegin\n" + line)
        with pytest.raises(FileNotFoundError, match="gone"):
            pz.Scene(scene)


def test_a_gltf_scene_is_rendered(root, lens_path):
    image = pz.render(root / "scenes/boxes.gltf", lens=lens_path, spp=2, resolution=(60, 40))
    assert image.pixels.mean() > 0


def test_old_cpus_are_named(tmp_path):
    if not (sys.platform.startswith("linux") and __import__("platform").machine() == "x86_64"):
        pytest.skip("only Linux on x86-64 is checked")
    cpu.check()
    info = tmp_path / "cpuinfo"
    info.write_text("processor : 0\nflags : fpu sse2 avx fma bmi2 f16c\n")
    with pytest.raises(ImportError, match="has no avx2"):
        cpu.check(info)
    info.write_text("nothing\n")
    cpu.check(info)


def render_in_child(path, queue):
    try:
        queue.put(float(pz.render(path, spp=1).pixels.mean()))
    except Exception as error:
        queue.put(f"{type(error).__name__}: {error}")


@pytest.mark.skipif(not hasattr(__import__("os"), "fork"), reason="there is no fork")
def test_a_forked_process_is_refused_and_a_spawned_one_is_not(scene_path):
    pz.render(scene_path, spp=1)
    for method, good in [("fork", False), ("spawn", True)]:
        context = multiprocessing.get_context(method)
        queue = context.Queue()
        child = context.Process(target=render_in_child, args=(str(scene_path), queue))
        child.start()
        found = queue.get(timeout=120)
        child.join()
        if good:
            assert isinstance(found, float) and found > 0
        else:
            assert "RuntimeError" in found and "spawn" in found


@pytest.mark.skipif(sys.platform == "win32", reason="needs signals")
def test_ctrl_c_ends_a_map(lens_path):
    lens = pz.Lens(lens_path)
    start = time.monotonic()
    timer = threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        lens.st_map((10_000, 5_000), 36.0)
    timer.join()
    # It takes much longer than this.
    assert time.monotonic() - start < 5


def test_maps_straighten_a_lens(lens_path):
    lens = pz.Lens(lens_path)
    size, width = (60, 40), 36.0
    model = lens.intrinsics(size, width, model="brown-conrady")
    straight = lens.st_map(size, width)
    back = lens.st_map(size, width, redistort=True)
    assert straight.shape == back.shape == (40, 60, 2)
    # One map undoes the other, next to the middle of the picture.
    x, y = 40, 12
    there = straight[y, x]
    near = back[int(round(there[1])), int(round(there[0]))]
    assert np.abs(near - (x, y)).max() < 0.75
    # The same place by the camera model, in OpenCV's terms.
    names = dict(zip(model["names"], model["distortion"]))
    matrix = model["matrix"]
    pixels = np.argwhere(np.isfinite(straight[..., 0]))[:, ::-1][::17].astype(float)
    u = (pixels[:, 0] - matrix[0, 2]) / matrix[0, 0]
    v = (pixels[:, 1] - matrix[1, 2]) / matrix[1, 1]
    r2 = u * u + v * v
    radial = 1 + sum(names.get(f"k{i}", 0.0) * r2**i for i in (1, 2, 3))
    expected = np.stack([u * radial * matrix[0, 0], v * radial * matrix[1, 1]], 1) + matrix[:2, 2]
    found = straight[pixels[:, 1].astype(int), pixels[:, 0].astype(int)]
    assert np.abs(found - expected).max() < max(0.05, 3 * model["max"])
    with pytest.raises(ValueError, match="above 0"):
        lens.st_map((0, 4), width)


def test_short_forms_equal_image_quality(lens_path):
    lens = pz.Lens(lens_path)
    quality = lens.image_quality(image_height=15.0, fields=3, rays=32)
    short = lens.mtf([10, 20], image_height=15.0, fields=3, rays=32)
    for mine, its in zip(short, quality.mtf([10, 20])):
        np.testing.assert_array_equal(mine, its)
    image, data = lens.psf(1, image_height=15.0, fields=3, rays=32)
    np.testing.assert_array_equal(image, quality.psf(1)[0])
    assert data["strehl"] > 0
    curve = lens.distortion(image_height=15.0, count=4)
    assert len(curve["height"]) == 5 and abs(curve["height"][-1] - 15.0) < 1.0
    assert np.isnan(curve["distortion"][0]) and abs(curve["distortion"][-1]) < 0.1
    assert json.dumps(list(curve)) == '["height", "distortion", "f_theta"]'


def test_accuracy_costs_time(scene_path):
    rows = pz.accuracy(scene_path, spp=(1, 16, 64), reference_spp=2048, effects="none")
    assert [row["spp"] for row in rows] == [1, 16, 64]
    assert all(row["seconds"] > 0 for row in rows)
    errors = [row["error"] for row in rows]
    # The relative MSE falls as 1 / spp, or faster with points that are spread evenly.
    assert errors[0] > 8 * errors[1] > 0 and errors[1] > 2.5 * errors[2] > 0
    with pytest.raises(ValueError, match="reference_spp"):
        pz.accuracy(scene_path, spp=(1, 64), reference_spp=64)
    with pytest.raises(ValueError, match="spp"):
        pz.accuracy(scene_path, spp=(0,))


def test_a_report_holds_the_numbers_of_the_analyses(lens_path):
    lens = pz.Lens(lens_path)
    report = lens.report(image_height=15.0, fields=3, rays=32, frequencies=[20])
    assert json.loads(json.dumps(report)) == report
    quality = lens.image_quality(image_height=15.0, fields=3, rays=32)
    tangential, sagittal = quality.mtf([20])
    assert [row["mtf_tangential"][0] for row in report["fields"]] == tangential[:, 0].tolist()
    assert [row["mtf_sagittal"][0] for row in report["fields"]] == sagittal[:, 0].tolist()
    assert report["fields"][2]["spot_rms"] == quality.spot(2)["rms"]
    assert report["efl"] == lens.efl and report["fno"] == lens.fno
    edge = quality.distortion(20)["distortion"]
    assert report["largest_distortion"] == edge[np.nanargmax(np.abs(edge))]
