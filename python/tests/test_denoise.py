"""Denoising: less error than the noisy picture, edges of textures, and a clear error without the library."""

import importlib.util

import numpy as np
import pytest

import petzval as pz
from petzval import denoise


@pytest.fixture
def oidn():
    if importlib.util.find_spec("pyoidn") is None:
        pytest.skip("pyoidn is not installed")


def test_a_denoised_picture_is_nearer_to_the_truth(oidn, scene_path, tmp_path):
    settings = dict(resolution=(120, 80), effects="none", aov=["albedo", "normal"])
    truth = pz.render(scene_path, spp=4096, **settings).pixels
    noisy = pz.render(scene_path, spp=4, seed=7, **settings)
    clean = noisy.denoise()
    before, after = [pz.compare(picture.pixels, truth, "mse") for picture in (noisy, clean)]
    assert after < 0.3 * before
    # Light is neither added nor lost.
    assert clean.pixels.mean() == pytest.approx(truth.mean(), rel=0.01)
    np.testing.assert_array_equal(clean.layers["noisy"], noisy.pixels)
    assert "noisy" not in noisy.layers
    clean.save(tmp_path / "clean.exr")
    np.testing.assert_array_equal(pz.read_image(tmp_path / "clean.exr"), clean.pixels)


def test_albedo_keeps_the_edges_of_textures(oidn, lens_path):
    random = np.random.default_rng(3)
    tiles = np.kron(random.uniform(0.1, 0.9, (24, 24, 3)), np.ones((8, 8, 1)))
    wall = pz.Mesh(
        [[-3, -3, 4], [3, -3, 4], [3, 3, 4], [-3, 3, 4]],
        [[0, 2, 1], [0, 3, 2]],
        uv=[[0, 0], [1, 0], [1, 1], [0, 1]],
        material={"type": "diffuse", "reflectance": tiles},
    )
    lamp = {"type": "infinite", "L": (1, 1, 1)}
    scene = pz.Scene.from_arrays(
        [wall], lens=lens_path, lights=[lamp], look_at=((0, 0, 0), (0, 0, 1)), focus=4.0, resolution=(120, 80)
    )
    truth = pz.render(scene, spp=1024, effects="none").pixels
    noisy = pz.render(scene, spp=1, effects="none", aov=["albedo", "normal"])
    plain = denoise.denoised(noisy.pixels)
    guided = noisy.denoise().pixels
    assert pz.compare(guided, truth, "mse") < pz.compare(plain, truth, "mse")


def test_nonsense_is_refused(oidn):
    with pytest.raises(ValueError, match="height x width x 3"):
        denoise.denoised(np.zeros((4, 4)))
    with pytest.raises(ValueError, match="albedo"):
        denoise.denoised(np.zeros((4, 4, 3)), albedo=np.zeros((3, 4, 3)))


def test_without_the_library_the_error_says_how_to_get_it(monkeypatch):
    monkeypatch.setattr(denoise, "_library", None)
    monkeypatch.setenv(denoise.VARIABLE, "/nowhere/libOpenImageDenoise.so")
    with pytest.raises(ImportError, match="pip install pyoidn") as caught:
        denoise.denoised(np.zeros((4, 4, 3)))
    assert "/nowhere/" in str(caught.value)
