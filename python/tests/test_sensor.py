"""Sensors and charts in Python."""

import json
import pickle
import subprocess

import numpy as np
import pytest

import petzval as pz


def test_a_sensor_reads_light_as_electrons_and_codes():
    sensor = pz.Sensor("iso=200,well=20000,read=3,bits=12,black=64")
    assert (sensor.iso, sensor.full_well, sensor.white_electrons) == (200, 20000, 10000)
    assert (sensor.bits, sensor.black_level, sensor.read_noise, sensor.bayer) == (12, 64, 3, None)
    assert sensor.gain == pytest.approx((4095 - 64) / 10000)
    grey = np.full((400, 500), 0.25)
    codes = sensor.codes(grey, seed=3)
    assert codes.dtype == np.uint32 and codes.shape == grey.shape
    electrons = (codes - 64.0) / sensor.gain
    assert electrons.mean() == pytest.approx(2500, abs=5 * np.sqrt(2509 / grey.size))
    assert electrons.std() == pytest.approx(np.sqrt(2500 + 9 + sensor.gain**-2 / 12), rel=0.01)
    assert electrons.std() / 25 == pytest.approx(sensor.relative_noise(0.25), rel=0.01)
    np.testing.assert_allclose(sensor.read_out(grey, seed=3), (codes - 64.0) / 4031, atol=1e-6)
    assert (sensor.codes(grey, seed=3) == codes).all() and (sensor.codes(grey, seed=4) != codes).any()
    colour = np.ones((4, 6, 3)) * [0.1, 0.2, 0.4]
    assert sensor.codes(colour).shape == (4, 6, 3)
    mosaic = pz.Sensor("bayer=rggb,well=1e12,read=0,bits=16,black=0").read_out(colour)
    np.testing.assert_allclose(mosaic[:2, :2], [[0.1, 0.2], [0.2, 0.4]], atol=1e-4)
    wide = pz.Sensor("hdr=64,bits=14,black=0,well=50000").codes(np.full((20, 20), 30.0))
    assert wide.min() > 400_000


@pytest.mark.parametrize(
    "arguments, message",
    [
        (("iso=0",), "settings='iso=0': iso: expected a speed|settings=\"iso=0\": iso: expected a speed"),
        (("missing.toml",), "missing.toml"),
        (("microlens=20",), "microlens loses light by the angle behind a lens"),
    ],
)
def test_wrong_sensors_are_named(arguments, message):
    with pytest.raises(ValueError, match=message):
        pz.Sensor(*arguments)
    with pytest.raises(ValueError, match="pitch=0: expected"):
        pz.Sensor(pitch=0)
    with pytest.raises(TypeError, match="expected floats of linear light"):
        pz.Sensor().codes(np.ones((2, 2), int))


def test_charts_are_those_of_the_command(tmp_path, lens_path, command):
    options = ["--film-size", "36x24", "--resolution", "600x400", "--focus", "2m", "--fstop", "4"]
    for kind in ("edges", "star", "colours", "grid"):
        found = pz.chart(kind, lens_path, tmp_path / "a.pbrt", focus=2, resolution=(600, 400), fstop=4)
        assert found["scene"] == str(tmp_path / "a.pbrt")
        subprocess.run([command, "chart", kind, lens_path, *options, "-o", tmp_path / "b.pbrt"], check=True)
        own, other = ((tmp_path / name).read_text().splitlines()[2:] for name in ("a.pbrt", "b.pbrt"))
        assert [line.replace("a.png", "b.png") for line in own] == other
        assert (found["texture"] is None) == (kind != "star")
        assert bool(found["edges"]) == (kind == "edges") and bool(found["spacing_mm"]) == (kind == "grid")
    sizes = ("35mm", [36, 24], np.array([36.0, 24.0]))
    same = {pz.chart("flat", lens_path, tmp_path / "f.pbrt", focus=2, film_size=size)["scene"] for size in sizes}
    assert same == {str(tmp_path / "f.pbrt")}
    edges = pz.chart("edges", pz.Lens(lens_path), tmp_path / "e.pbrt", focus=2, resolution=(600, 400), film_size="35mm")
    image = pz.render(edges["scene"], spp=64)
    middle = edges["edges"][len(edges["edges"]) // 2]
    measured = pz.measure.edge(image.pixels, middle)
    assert 0.05 < measured["mtf50"] < 0.8 and json.dumps(measured)


@pytest.mark.parametrize(
    "change, message",
    [
        ({"kind": "edge"}, "kind=\"edge\": expected one of \"edges\""),
        ({"path": "a.png"}, "expected the name of a scene"),
        ({"focus": float("inf")}, "expected a finite 'focus'"),
        ({"film_size": "36 mm"}, "or the name of a film or a camera"),
        ({"film_size": (0, 24)}, "expected width and height in mm"),
        ({"fstop": 0.1}, "fstop=0.1"),
        ({"resolution": (10, 10)}, "at least 400 x 400"),
        ({"resolution": (-600, 400)}, "expected 1 to 65536 pixels"),
        ({"focus": float("nan")}, "focus=NaN: expected a distance"),
        ({"fstop": float("nan")}, "fstop=NaN: expected a number above 0"),
    ],
)
def test_wrong_charts_are_named(tmp_path, lens_path, change, message):
    arguments = {"kind": "edges", "path": tmp_path / "a.pbrt", "focus": 2.0, **change}
    with pytest.raises(ValueError, match=message):
        pz.chart(lens=lens_path, **arguments)
    assert not list(tmp_path.iterdir())


def test_a_lens_of_rows_has_no_file_for_a_chart(tmp_path):
    lens = pz.Lens.from_table([(50, 5, 1.5, 20), (0, 2, 0, 8), (-50, 0, 1, 20)])
    with pytest.raises(ValueError, match="this lens is a table"):
        pz.chart("flat", lens, tmp_path / "a.pbrt", focus=2)


def test_names_that_a_scene_cannot_hold_are_refused_and_missing_folders_are_errors_of_files(tmp_path, lens_path):
    with pytest.raises(ValueError, match="a scene cannot name this file"):
        pz.chart("star", lens_path, tmp_path / "x\ny.pbrt", focus=2)
    with pytest.raises((OSError, ValueError), match="no"):
        pz.chart("flat", lens_path, tmp_path / "no" / "a.pbrt", focus=2)
    assert not list(tmp_path.iterdir())


def test_sensors_take_paths_and_are_pickled(tmp_path):
    (tmp_path / "camera.toml").write_text("well = 7000\nread = 3\nbits = 12\nbayer = 'rggb'\n")
    sensor = pz.Sensor(tmp_path / "camera.toml", pitch=3)
    assert sensor.full_well == 7000 and sensor.bayer == "rggb" and sensor.hdr == 1 and sensor.dark_current == 0
    copied = pickle.loads(pickle.dumps(sensor))
    assert copied == sensor and copied != pz.Sensor("well=7001")
    light = np.full((8, 8), 0.5)
    assert (copied.codes(light) == sensor.codes(light)).all()
