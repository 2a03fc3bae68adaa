"""The command: petzval render --denoise gives the picture of image.denoise(), by both programs."""

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import petzval as pz
from petzval import denoise_command

SETTINGS = dict(resolution=(120, 80), spp=2, seed=3, aov=["albedo", "normal"])
OPTIONS = ["--resolution", "120x80", "--spp", "2", "--seed", "3"]


@pytest.fixture
def oidn():
    """The folder of Open Image Denoise."""
    found = importlib.util.find_spec("pyoidn")
    if found is None:
        pytest.skip("pyoidn is not installed")
    return Path(found.origin).parent / "oidn"


def run(command, scene_path, path, output, *options, denoiser=None):
    environment = {**os.environ, "PATH": str(path)}
    environment.pop("PETZVAL_DENOISER", None)
    if denoiser:
        environment["PETZVAL_DENOISER"] = str(denoiser)
    words = [command, "render", str(scene_path), "-o", str(output), *OPTIONS, *options]
    done = subprocess.run(words, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_the_command_gives_the_picture_of_denoise(oidn, scene_path, tmp_path, command):
    image = pz.render(scene_path, **SETTINGS)
    expected = image.denoise().pixels
    assert not np.array_equal(expected, image.pixels)
    # The package's program is beside the interpreter.
    run(command, scene_path, Path(sys.executable).parent, tmp_path / "package.exr", "--denoise")
    np.testing.assert_array_equal(pz.read_image(tmp_path / "package.exr"), expected)
    program = oidn / "bin" / "oidnDenoise"
    if program.exists():
        # The wheel leaves out the bit that makes it a program.
        copy = tmp_path / "oidnDenoise"
        copy.write_bytes(program.read_bytes())
        copy.chmod(0o755)
        start = tmp_path / "start"
        start.write_text(f'#!/bin/sh\nLD_LIBRARY_PATH="{oidn / "lib"}" exec "{copy}" "$@"\n')
        start.chmod(0o755)
        run(command, scene_path, "/usr/bin:/bin", tmp_path / "intel.exr", f"--denoise={start}")
        np.testing.assert_array_equal(pz.read_image(tmp_path / "intel.exr"), expected)


def test_without_the_library_the_command_says_how_to_get_it(scene_path, tmp_path, command):
    environment = {**os.environ, "PATH": str(Path(sys.executable).parent), "PETZVAL_OIDN": "/nowhere"}
    words = [command, "render", str(scene_path), "-o", str(tmp_path / "a.exr"), "--denoise"]
    done = subprocess.run(words, env=environment, capture_output=True, text=True)
    assert done.returncode == 2 and not (tmp_path / "a.exr").exists()
    assert "pip install pyoidn" in done.stderr


def test_the_picture_is_not_written_over_its_input(tmp_path, capsys):
    path = tmp_path / "a.pfm"
    denoise_command.write_pfm(path, np.ones((2, 2, 3), np.float32))
    before = path.read_bytes()
    (tmp_path / "b.pfm").symlink_to(path)
    for output in (path, tmp_path / "b.pfm"):
        assert denoise_command.main(["--hdr", str(path), "-o", str(output)]) == 1
        assert "same file" in capsys.readouterr().err
    assert path.read_bytes() == before


def test_files_keep_their_rows_and_bits(tmp_path):
    pixels = np.random.default_rng(1).normal(size=(5, 7, 3)).astype(np.float32)
    denoise_command.write_pfm(tmp_path / "a.pfm", pixels)
    np.testing.assert_array_equal(denoise_command.read_pfm(tmp_path / "a.pfm"), pixels)
    # The reader of the renderer agrees.
    np.testing.assert_array_equal(pz.read_image(tmp_path / "a.pfm"), pixels)
    big = b"PF\n7 5\n0.5\n" + (2 * pixels[::-1]).astype(">f4").tobytes()
    (tmp_path / "big.pfm").write_bytes(big)
    np.testing.assert_array_equal(denoise_command.read_pfm(tmp_path / "big.pfm"), pixels)


@pytest.mark.parametrize("content", [b"", b"PF\n1 1\n", b"Pf 1 1 -1 1234", b"PF 1 x -1 1234", b"PF 2 2 -1 1234"])
def test_what_is_no_picture_is_an_error(content, tmp_path, capsys):
    (tmp_path / "a.pfm").write_bytes(content)
    out = tmp_path / "out.pfm"
    assert denoise_command.main(["--hdr", str(tmp_path / "a.pfm"), "-o", str(out)]) == 1
    assert "a.pfm" in capsys.readouterr().err and not out.exists()
    assert denoise_command.main(["--hdr", str(tmp_path / "none.pfm"), "-o", str(out)]) == 1
    assert denoise_command.main(["-o", str(out)]) == 2
