"""Measurements of charts in arrays: those of the command, and of known pictures."""

import json
import subprocess

import numpy as np
import pytest
import tifffile

import petzval as pz


@pytest.fixture
def drawn(tmp_path, command, lens_path):
    """Return a function that draws and renders a chart, and returns its picture and the words that measure it."""

    def draw(kind, *more):
        camera = ["--film-size", "36x24", "--resolution", "600x400", "--focus", "2m", "--fstop", "8"]
        scene = tmp_path / f"{kind}.pbrt"
        chart = [command, "chart", kind, str(lens_path), *camera, "-o", str(scene)]
        told = subprocess.run(chart, check=True, capture_output=True, text=True).stdout
        path = scene.with_suffix(".exr")
        subprocess.run([command, "render", scene, "-o", path, "--spp", "16", "-q", *more], check=True)
        return path, told.splitlines()[-1].split()[1:]

    return draw


def numbers(word):
    return [int(number) for number in word.split(",")]


def of_command(command, words):
    run = subprocess.run([command, *words, "--json"], check=True, capture_output=True, text=True)
    return json.loads(run.stdout)


def test_measurements_are_those_of_the_command(drawn, command, tmp_path):
    path, words = drawn("colours")
    region = numbers(words[words.index("--region") + 1])
    expected = of_command(command, words)
    found = pz.measure.colours(pz.read_image(path), region)
    assert found == {key: expected[key] for key in found} and len(found["patches"]) == 24

    path, words = drawn("edges")
    first = words.index("--edge") + 1
    expected = of_command(command, words[: first + 1])["edges"][0]
    found = pz.measure.edge(pz.read_image(path), numbers(words[first]))
    assert found == {key: expected[key] for key in found} and 0.05 < found["mtf50"] < 1

    path, words = drawn("grid")
    expected = of_command(command, words)
    found = pz.measure.grid(pz.read_image(path))
    assert found == {key: expected[key] for key in found} and len(found["dots"]) > 100

    path, words = drawn("leaves")
    expected = of_command(command, words)
    region = numbers(words[words.index("--region") + 1])
    pixels, chart = pz.read_image(path), pz.read_image(tmp_path / "leaves.png")
    found = pz.measure.texture(pixels, region, chart)
    assert found == {key: expected[key] for key in found} and found["response"][5] > 0.5
    # The noise of neither of two pictures counts as texture.
    rng = np.random.default_rng(3)
    noisy = [(pixels + rng.normal(0, 0.02, pixels.shape)).astype(np.float32) for _ in range(2)]
    alone = np.array(pz.measure.texture(noisy[0], region, chart)["response"])
    pair = np.array(pz.measure.texture(noisy[0], region, chart, second=noisy[1])["response"])
    assert abs(pair - found["response"]).max() < 0.5 * abs(alone - found["response"]).max()


def test_stars_greys_and_shading_are_those_of_the_command(drawn, command):
    path, words = drawn("star")
    region = numbers(words[words.index("--region") + 1])
    expected = of_command(command, words)
    found = pz.measure.star(pz.read_image(path), region)
    assert found == {key: expected[key] for key in found} and len(found["segments"][0]) == 8
    half = pz.measure.star(pz.read_image(path), region, modulation=0.3)
    np.testing.assert_allclose(half["response"], 2 * np.array(found["response"]))
    for setting in ({"cycles": 5}, {"modulation": 0}, {"cycles": 144}):
        with pytest.raises(ValueError, match=next(iter(setting))):
            pz.measure.star(pz.read_image(path), region, **setting)

    path, words = drawn("greys")
    region = numbers(words[words.index("--region") + 1])
    expected = of_command(command, words)
    found = pz.measure.greys(pz.read_image(path), region)
    assert found == {key: expected[key] for key in found} and len(found["steps"]) == 20

    path, words = drawn("flat")
    expected = of_command(command, words)
    found = pz.measure.shading(pz.read_image(path))
    assert found == {key: expected[key] for key in found} and found["uniformity"] < 0.9


def test_a_channel_of_an_array_is_measured(drawn):
    path, words = drawn("edges")
    pixels = pz.read_image(path)
    region = numbers(words[words.index("--edge") + 1])
    blurred = pixels.copy()
    for _ in range(4):
        blurred[..., 2] = (blurred[..., 2] + np.roll(blurred[..., 2], 1, 1)) / 2
    green, blue = (pz.measure.edge(blurred[..., channel], region)["mtf50"] for channel in (1, 2))
    assert blue < 0.7 * green


def test_noise_of_simulated_readings(tmp_path):
    rng = np.random.default_rng(1)
    lines = []
    for i, photons in enumerate(np.linspace(300, 9000, 12)):
        lines.append(f"b 1000000 {photons}")
        for k in range(2):
            electrons = rng.poisson(0.5 * photons, (200, 300)) + rng.normal(0, 4, (200, 300))
            codes = np.clip(np.rint(0.8 * np.clip(electrons, None, 4000) + 100), 0, 65535)
            path = tmp_path / f"{i}.{k}.tif"
            tifffile.imwrite(path, codes.astype(np.uint16))
            lines.append(f"i {path.name}")
    lines.append("d 1000000")
    for k in range(2):
        codes = np.clip(np.rint(0.8 * rng.normal(0, 4, (200, 300)) + 100), 0, 65535)
        tifffile.imwrite(tmp_path / f"dark{k}.tif", codes.astype(np.uint16))
        lines.append(f"i dark{k}.tif")
    (tmp_path / "list.txt").write_text("\n".join(lines))
    [grey] = pz.measure.noise(tmp_path / "list.txt")
    assert grey["channel"] == "grey"
    assert abs(grey["gain"] / 0.8 - 1) < 0.01
    assert abs(grey["quantum_efficiency"] / 0.5 - 1) < 0.01
    assert abs(grey["dark_noise_electrons"]["total"] / 4 - 1) < 0.03


def test_bad_input_is_told(tmp_path):
    pixels = np.ones((60, 90, 3), np.float32)
    with pytest.raises(ValueError, match=r"region=\(0, 0, 91, 50\): the picture has 90 x 60 pixels"):
        pz.measure.edge(pixels, (0, 0, 91, 50))
    with pytest.raises(ValueError, match=r"region=\(10, 10, 80, 50\): .*edge"):
        pz.measure.edge(pixels, (10, 10, 80, 50))
    with pytest.raises(ValueError, match="dark dots"):
        pz.measure.grid(pixels)
    with pytest.raises(ValueError, match="patches are about"):
        pz.measure.colours(pixels, (0, 0, 30, 20))
    with pytest.raises(TypeError, match="expected floats"):
        pz.measure.grid(np.ones((60, 90), int))
    (tmp_path / "list.txt").write_text("b x\n")
    with pytest.raises(ValueError, match=r"list\.txt:1"):
        pz.measure.noise(tmp_path / "list.txt")
    with pytest.raises(FileNotFoundError, match=r"none\.txt"):
        pz.measure.noise(tmp_path / "none.txt")
