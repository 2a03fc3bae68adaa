"""Renders: the command's bits, arrays, files, errors, Ctrl-C and memory."""

import _thread
import subprocess
import threading
import time

import numpy as np
import pytest

import petzval as pz


def test_a_picture_has_the_bits_of_the_command(scene_path, tmp_path, command):
    options = ["--spp", "8", "--seed", "3", "--fstop", "4", "--focus", "1.9", "--aov", "depth,normal"]
    subprocess.run(
        [command, "render", str(scene_path), "-o", "command.exr", *options],
        cwd=tmp_path,
        check=True,
        capture_output=True,
    )
    image = pz.render(scene_path, spp=8, seed=3, fstop=4, focus=1.9, aov=["depth", "normal"], threads=1)
    image.save(tmp_path / "python.exr")
    # The headers differ: they name the command, and times.
    [mine, its] = [exr_data(tmp_path / name) for name in ("python.exr", "command.exr")]
    assert len(mine) > 10_000 and mine == its
    other = pz.render(scene_path, spp=8, seed=4, fstop=4, focus=1.9, aov=["depth", "normal"])
    other.save(tmp_path / "other.exr")
    assert exr_data(tmp_path / "other.exr") != its


def test_halves_of_the_pupil_are_layers_that_add_up(scene_path):
    settings = dict(spp=4, resolution=(48, 32), aov=["dual_pixel"])
    image = pz.render(scene_path, effects="none", **settings)
    assert list(image.layers) == ["left", "right"]
    np.testing.assert_allclose(image.layers["left"] + image.layers["right"], image.pixels, rtol=1e-5, atol=1e-7)
    assert np.abs(image.layers["left"] - image.layers["right"]).mean() > 0
    mosaic = pz.render(scene_path, sensor="iso=100,well=1e9,read=0,bits=16", bayer="rggb", **settings)
    assert mosaic.pixels.shape == (32, 48)
    assert [mosaic.layers[half].shape for half in ("left", "right")] == 2 * [(32, 48, 1)]
    assert [mosaic.channels[half] for half in ("left", "right")] == 2 * [["Y"]]


def exr_data(path):
    """Return the pixels of an OpenEXR file of one part, as they are stored, without its header."""
    data = path.read_bytes()
    at = 8
    while data[at]:
        at = data.index(b"\0", data.index(b"\0", at) + 1) + 1
        at += 4 + int.from_bytes(data[at : at + 4], "little")
    first = int.from_bytes(data[at + 1 : at + 9], "little")
    return data[first:]


def test_a_picture_is_an_array_with_layers(scene_path):
    image = pz.render(scene_path, resolution=(40, 30), aov=["depth", "coc"])
    assert image.size == (40, 30)
    assert image.pixels.shape == (30, 40, 3) and image.pixels.dtype == np.float32
    assert np.isfinite(image.pixels).all() and image.pixels.mean() > 0
    assert set(image.layers) == {"depth", "coc"}
    depth = image.layers["depth"][..., 0]
    # The front of the ball is 1.8 m from the origin of the camera, the wall 4 m.
    assert abs(depth[15, 20] - 1.8) < 0.05 and abs(depth[1, 1] - 4.0) < 0.3
    assert len(image.channels["depth"]) == image.layers["depth"].shape[2]
    assert image.metadata


def test_settings_change_the_picture(scene_path):
    scene = pz.Scene(scene_path)
    effects = "-ghosts,-diffraction"
    base = pz.render(scene, effects=effects).pixels
    same = pz.render(scene, effects=effects, threads=2).pixels
    np.testing.assert_array_equal(base, same)
    for change in [
        {"seed": 9},
        {"spp": 2},
        {"focus": 1.0},
        {"focus": "auto"},
        {"focus": (3, 3)},
        {"fstop": 8},
        {"film_tilt": (3, 0)},
        {"film_shift": (1, 2)},
        {"film_diagonal": 20.0},
        {"look_at": ((0.1, 0, 0), (0, 0, 2))},
    ]:
        other = pz.render(scene, effects=effects, **change).pixels
        assert not np.array_equal(base, other), change
    crop = pz.render(scene, effects=effects, crop=(10, 5, 20, 9)).pixels
    np.testing.assert_array_equal(crop, base[5:9, 10:20])


def test_a_lens_of_a_table_takes_pictures(scene_path):
    rows = [
        (60.0, 6.0, 1.6, 30.0),
        (-60.0, 2.0, 1.0, 30.0),
        (0.0, 1.0, 0.0, 12.0),
    ]
    lens = pz.Lens.from_table(rows)
    image = pz.render(scene_path, lens=lens, focus=2.0, effects="none")
    assert image.pixels.mean() > 0


def test_pictures_are_written_and_shown(scene_path, tmp_path):
    image = pz.render(scene_path, resolution=(16, 12), aov=["depth"])
    for name, start in [("a.exr", b"v/1\x01"), ("a.png", b"\x89PNG"), ("a.jpg", b"\xff\xd8")]:
        image.save(tmp_path / name, exposure="auto")
        assert (tmp_path / name).read_bytes().startswith(start)
    assert image._repr_png_().startswith(b"\x89PNG")
    with pytest.raises(ValueError, match="known are"):
        image.save(tmp_path / "a.webp")
    with pytest.raises(OSError):
        image.save(tmp_path / "no" / "folder" / "a.exr")
    with pytest.raises(ValueError, match="exposure"):
        image.save(tmp_path / "a.png", exposure="bright")


def test_the_plan_says_why(scene_path):
    decisions = pz.plan(scene_path)
    assert {"dispersion", "ghosts", "diffraction"} < {row["effect"] for row in decisions}
    assert all(row["reason"] and isinstance(row["on"], bool) for row in decisions)
    switched = pz.plan(scene_path, effects="+fresnel")
    assert next(row for row in switched if row["effect"] == "fresnel")["on"]


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"spp": 0}, "spp"),
        ({"fstop": -2}, "fstop"),
        ({"focus": -1.0}, "focus"),
        ({"focus": "near"}, "focus"),
        ({"effects": "ghosts"}, "expected auto, all, none"),
        ({"aov": ["deph"]}, "expected one of depth"),
        ({"coating": "paint"}, "expected one of"),
        ({"resolution": (0, 10)}, "resolution"),
        ({"noise": 2.0}, "noise"),
        ({"time": -1.0}, "time"),
        ({"film_tilt": (1e9, 0)}, "film_tilt"),
        ({"film_diagonal": -1.0}, "film_diagonal"),
        ({"look_at": ((0, 0, 0), (0, 0, 0))}, "look_at"),
        ({"look_at": ((0, 0), (0, 0, 0))}, "look_at"),
        ({"crop": (10, 10, 5, 5)}, "crop"),
        ({"crop": (0, 0, 1000, 1000)}, "crop"),
        ({"crop": (0, 0, -1, 2)}, r"crop=\(0, 0, -1, 2\): expected four whole numbers"),
        ({"resolution": (5,)}, r"resolution=\(5,\): expected two whole numbers"),
        ({"focus": (-1, 2)}, "a pixel"),
    ],
)
def test_settings_that_make_no_sense_are_refused(scene_path, settings, message):
    with pytest.raises(ValueError, match=message):
        pz.prepare(scene_path, **settings)


@pytest.mark.parametrize(
    "settings",
    [
        {"spp": "many"},
        {"resolution": 3},
        {"fstop": "f/4"},
        {"fstop": {}},
        {"aov": None},
        {"aov": 3},
        {"aov": [3]},
        {"effects": ["+dispersion"]},
        {"effects": None},
        {"sensor": 800},
        {"shutter": 0.01},
        {"bayer": True},
        {"lens": 3},
        {"look_at": 3},
        {"look_at": (1, 2, 3)},
        {"assume_vd": 3},
        {"catalogue": 3},
    ],
)
def test_settings_of_another_type_are_refused(scene_path, settings):
    with pytest.raises(TypeError, match=f"{next(iter(settings))}.*: expected"):
        pz.prepare(scene_path, **settings)
    with pytest.raises(TypeError, match="sp"):
        pz.prepare(scene_path, sp=3)


def test_exceptions_of_foreign_objects_come_through(scene_path):
    class Broken:
        def __float__(self):
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        pz.prepare(scene_path, fstop=Broken())


def test_a_list_that_lies_about_its_length_is_read(scene_path):
    class Liar(list):
        def __len__(self):
            return 2**62

    job = pz.prepare(scene_path, aov=Liar(["depth"]), resolution=(8, 8), spp=1)
    assert list(job.render().layers) == ["depth"]


def test_a_picture_does_not_replace_a_file_of_its_scene(scene_path, tmp_path):
    before = scene_path.read_bytes()
    image = pz.render(scene_path, spp=1, effects="none", resolution=(8, 8))
    link = tmp_path / "link.exr"
    link.symlink_to(scene_path)
    for path in (link, tmp_path / "." / "link.exr"):
        with pytest.raises(ValueError, match="same file"):
            image.save(path)
    assert scene_path.read_bytes() == before
    image.save(tmp_path / "a.exr")
    image.save(tmp_path / "a.exr")


def test_layers_that_do_not_fit_are_not_written(scene_path, tmp_path):
    image = pz.render(scene_path, aov=["depth"])
    path = tmp_path / "a.exr"
    for layer, names, error in [
        (np.zeros((3, 3, 1), np.float32), ["Y"], ValueError),
        (np.zeros((32, 48), np.float32), ["Y"], ValueError),
        (np.zeros((32, 48, 2), np.float32), ["Y"], ValueError),
        (None, ["Y"], TypeError),
        (np.zeros((32, 48, 1), np.float32), 3, TypeError),
    ]:
        image.layers["mine"], image.channels["mine"] = layer, names
        with pytest.raises(error, match="mine"):
            image.save(path)
    assert not path.exists()
    # Other numbers become float32.
    image.layers["mine"], image.channels["mine"] = np.ones((32, 48, 1)), ["Y"]
    image.save(path)
    with pytest.raises(TypeError, match="exposure=None"):
        image.save(path, exposure=None)


def test_files_that_are_missing_or_wrong_are_named(scene_path, tmp_path):
    with pytest.raises(FileNotFoundError, match="none.pbrt"):
        pz.Scene(tmp_path / "none.pbrt")
    with pytest.raises(FileNotFoundError, match="none.dat"):
        pz.prepare(scene_path, lens=tmp_path / "none.dat")
    wrong = tmp_path / "wrong.pbrt"
    wrong.write_text(scene_path.read_text().replace("Translate", "Translat"))
    with pytest.raises(ValueError, match=r"wrong.pbrt:\d+:\d+"):
        pz.Scene(wrong)


def test_progress_grows_and_its_errors_come_through(scene_path):
    shares = []
    pz.render(scene_path, spp=2000, effects="none", progress=shares.append)
    assert shares == sorted(shares) and shares[-1] == 1.0

    def fail(_):
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        pz.render(scene_path, spp=1_000_000, effects="none", progress=fail)


def test_ctrl_c_ends_a_render(scene_path):
    job = pz.prepare(scene_path, spp=10_000_000, effects="none")
    threading.Timer(0.3, _thread.interrupt_main).start()
    start = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        job.render()
    assert time.monotonic() - start < 20


def test_other_threads_run_during_a_render(scene_path):
    job = pz.prepare(scene_path, spp=20_000, effects="none")
    done = threading.Event()
    counts = [0]

    def count():
        while not done.is_set():
            counts[0] += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    before = counts[0]
    job.render(threads=1)
    during = counts[0] - before
    done.set()
    thread.join()
    assert during > 20


def test_many_renders_leak_nothing(scene_path):
    def resident():
        with open("/proc/self/statm") as file:
            return int(file.read().split()[1]) * 4096

    try:
        resident()
    except OSError:
        pytest.skip("this system has no /proc/self/statm")
    job = pz.prepare(scene_path, resolution=(64, 64), spp=1, effects="none", aov=["depth"])
    for _ in range(100):
        job.render(threads=1)
    before = resident()
    for _ in range(500):
        job.render(threads=1)
    # A leak of the pixels alone would be 500 x 64 x 64 x 12 bytes = 25 MB.
    assert resident() - before < 8e6


def test_words_of_the_command_set_sensor_shutter_and_zoom(scene_path, root):
    job = pz.prepare(scene_path, sensor="", shutter="open=0,close=0.01", seed=1)
    on = {row["effect"] for row in job.plan if row["on"]}
    assert "sensor" in on
    mosaic = pz.render(scene_path, bayer="rggb", spp=1).pixels
    # Every photosite has one colour: the others are interpolated or empty, but never those of the film.
    assert not np.array_equal(mosaic, pz.render(scene_path, spp=1).pixels)
    for setting, words in [
        ("sensor", "iso=fast"),
        ("shutter", "slow"),
        ("rolling_shutter", "upwards?"),
        ("bayer", "rgb"),
        ("zoom", -3.0),
        ("focus_model", "pbrt-v4"),
        ("passband", (900.0, 100.0)),
        ("buckets", "16@300..700"),
        ("buckets", 0),
    ]:
        with pytest.raises(ValueError, match=setting):
            pz.prepare(scene_path, **{setting: words})
    with pytest.raises(ValueError, match="zoom"):
        pz.prepare(scene_path, zoom=35.0)


def test_a_spectral_film_gives_radiance_by_wavelength(scene_path, tmp_path):
    image = pz.render(scene_path, spp=4, buckets="8@400..720", resolution=(12, 8))
    assert image.spectrum.shape == (8, 12, 8) and image.spectrum.dtype == np.float32
    np.testing.assert_allclose(image.wavelengths, 420 + 40 * np.arange(8))
    np.testing.assert_array_equal(image.spectrum, image.layers["S0"])
    image.save(tmp_path / "a.npy")
    np.testing.assert_array_equal(np.load(tmp_path / "a.npy"), image.spectrum)
    plain = pz.render(scene_path, spp=4, effects="+spectra", resolution=(12, 8))
    assert plain.spectrum is None and plain.wavelengths is None
    np.testing.assert_array_equal(plain.pixels, image.pixels)
    plain.save(tmp_path / "b.npy")
    np.testing.assert_array_equal(np.load(tmp_path / "b.npy"), plain.pixels)


def test_pictures_are_read_written_and_compared(tmp_path):
    random = np.random.default_rng(5)
    pixels = random.uniform(0, 1, (7, 9, 3)).astype(np.float32)
    pz.write_image(tmp_path / "a.exr", pixels)
    np.testing.assert_array_equal(pz.read_image(tmp_path / "a.exr"), pixels)
    pz.write_image(tmp_path / "a.png", pixels)
    assert np.abs(pz.read_image(tmp_path / "a.png") - pixels).max() < 0.01
    brighter = pixels + 0.1
    assert pz.compare(brighter, pixels, "mse") == pytest.approx(0.01, rel=1e-4)
    assert pz.compare(pixels, pixels) == 0.0
    assert pz.compare(brighter, pixels, metric="flip") > 0.01
    with pytest.raises(ValueError, match="metric"):
        pz.compare(pixels, pixels, "ssim")
    with pytest.raises(ValueError, match="size|7"):
        pz.compare(pixels, pixels[:5])
    with pytest.raises(ValueError, match="height x width x 3"):
        pz.write_image(tmp_path / "a.exr", pixels[..., :2])
    with pytest.raises(FileNotFoundError):
        pz.read_image(tmp_path / "none.exr")


def test_a_mosaic_is_height_x_width(scene_path, tmp_path, root):
    settings = dict(sensor="iso=400", seed=3, spp=4)
    mosaic = pz.render(scene_path, bayer="gbrg", **settings)
    whole = pz.render(scene_path, **settings)
    assert mosaic.pixels.shape == (32, 48) and mosaic.size == (48, 32)
    assert whole.pixels.shape == (32, 48, 3)
    # A photosite reads what it reads without the other two.
    channels = np.array([[1, 2], [0, 1]])
    filters = np.tile(channels, (16, 24))
    expected = np.take_along_axis(whole.pixels, filters[..., None], 2)[..., 0]
    np.testing.assert_array_equal(mosaic.pixels, expected)
    # The mosaic alone has the shape: with the sensor off there is none.
    assert pz.render(scene_path, bayer="gbrg", effects="-sensor", spp=1).pixels.ndim == 3
    passed = [image.pixels.shape for image in pz.passes(scene_path, bayer="rggb", spp=2)]
    assert passed == [(32, 48)] * 2
    # A file has one channel, and comes back as it was.
    mosaic.save(tmp_path / "a.exr")
    np.testing.assert_array_equal(pz.read_image(tmp_path / "a.exr"), mosaic.pixels)
    for name, magic in [("a.png", b"IHDR"), ("a.jpg", b"\xff\xc0")]:
        mosaic.save(tmp_path / name)
        file = (tmp_path / name).read_bytes()
        at = file.index(magic)
        assert file[at + 4 + 9 if name == "a.png" else at + 9] == (0 if name == "a.png" else 1)
        back = pz.read_image(tmp_path / name)
        assert back.shape == (32, 48)
        assert np.abs(back - np.clip(mosaic.pixels, 0, 1)).max() < 0.05
    pz.write_image(tmp_path / "b.exr", mosaic.pixels * 2)
    np.testing.assert_array_equal(pz.read_image(tmp_path / "b.exr"), mosaic.pixels * 2)
    assert pz.compare(mosaic.pixels, mosaic.pixels, "mse") == 0
    np.testing.assert_array_equal(np.asarray(mosaic), mosaic.pixels)
    assert mosaic._repr_png_().startswith(b"\x89PNG")
    with pytest.raises(ValueError, match="a mosaic cannot be denoised"):
        mosaic.denoise()


def test_the_command_writes_the_same_mosaic(scene_path, tmp_path, command):
    options = ["--spp", "4", "--seed", "3", "--bayer", "gbrg", "-o", "a.exr", "--aov", "depth"]
    run = subprocess.run([command, "render", str(scene_path), *options], cwd=tmp_path, capture_output=True)
    assert run.returncode == 0, run.stderr
    found = pz.read_image(tmp_path / "a.exr")
    mine = pz.render(scene_path, spp=4, seed=3, bayer="gbrg", aov=["depth"])
    np.testing.assert_array_equal(found, mine.pixels)
    mine.save(tmp_path / "b.exr")
    assert [channel_names(tmp_path / name) for name in ("a.exr", "b.exr")] == [["Y", "depth.Z", "depth.coverage"]] * 2


def channel_names(path):
    """Return the names of the channels of an EXR file."""
    file = path.read_bytes()
    at = file.index(b"channels\0chlist\0") + len(b"channels\0chlist\0") + 4
    names = []
    while file[at]:
        end = file.index(b"\0", at)
        names.append(file[at:end].decode())
        at = end + 1 + 16
    return names
