"""What an editor and a type checker know: the keywords of functions, and mypy's verdicts."""

import inspect
import re
import subprocess
import sys
import textwrap

import pytest

import petzval as pz

#: Functions that take settings, with the class of these.
TAKERS = {
    pz.prepare: pz.RenderSettings,
    pz.render: pz.RenderSettings,
    pz.plan: pz.RenderSettings,
    pz.passes: pz.PassSettings,
    pz.sweep: pz.SweepSettings,
    pz.accuracy: pz.AccuracySettings,
    pz.lens_models: pz.LensModelSettings,
}


@pytest.mark.parametrize("function", TAKERS, ids=lambda function: function.__name__)
def test_a_misspelt_setting_names_the_near_one(function, scene_path):
    with pytest.raises(TypeError, match=rf"{function.__name__}\(\) .*'fstp'; did you mean 'fstop'\?"):
        function(scene_path, fstp=4)
    with pytest.raises(TypeError, match="keyword argument 'xyzzy'$"):
        function(scene_path, xyzzy=4)


def test_misspelt_arguments_of_other_functions_name_the_near_one(tmp_path):
    for call, near in [
        (lambda: pz.Camera(fstp=4), "fstop"),
        (lambda: pz.Mesh([], [], materal={}), "material"),
        (lambda: pz.Scene.from_arrays([], lense="a.dat"), "lens"),
        (lambda: pz.dataset("a.toml", tmp_path, sharp=(1, 2)), "shard"),
    ]:
        with pytest.raises(TypeError, match=f"did you mean '{near}'"):
            call()


@pytest.mark.parametrize("function", TAKERS, ids=lambda function: function.__name__)
def test_the_engine_takes_the_keys_of_the_class_and_no_others(function, scene_path):
    shown = inspect.signature(function).parameters
    keys = TAKERS[function].__annotations__
    assert set(keys) <= set(shown), function.__name__
    assert not any(p.kind is p.VAR_KEYWORD for p in shown.values())
    own = {"scene", "camera", "threads", "progress", "checkpoint", "checkpoint_interval", "resume"}
    own |= {"memory", "spp", "reference_spp", "metric", "seed", "budget"}
    assert set(shown) - own <= set(keys), function.__name__
    # Sweeps and measurements would take long; all hand their settings on to this.
    if function in (pz.prepare, pz.plan):
        defaults = {name: p.default for name, p in shown.items() if name in keys}
        function(scene_path, **defaults)


def test_settings_are_documented():
    for name in pz.RenderSettings.__annotations__:
        assert f":param {name}: " in pz.prepare.__doc__, name


def mypy(tmp_path, text, *options):
    """Return what mypy says about a program."""
    pytest.importorskip("mypy")
    program = tmp_path / "program.py"
    program.write_text(textwrap.dedent(text))
    command = [sys.executable, "-m", "mypy", "--strict", "--no-incremental", *options, str(program)]
    run = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    return run.stdout + run.stderr


def test_mypy_passes_right_calls(tmp_path):
    said = mypy(
        tmp_path,
        """
        from pathlib import Path

        import petzval as pz

        scene = pz.Scene("a.pbrt")
        lens = pz.Lens(Path("a.dat"))
        stops = [2, 4, 8]
        settings: pz.RenderSettings = {"fstop": 4, "focus": "auto"}
        pz.render(scene, fstop=4, focus=(3, 4), spp=16, aov=["depth"], lens=lens).save("a.exr")
        pz.render(scene, threads=2, **settings)
        pz.plan(scene, coating="mgf2")
        pz.prepare(scene, pz.Camera(fstop=4), bayer="rggb").render(memory="8GiB")
        for changed, image in pz.sweep(scene, fstop=stops, focus=[1.0, "auto"], lens=[lens, "b.dat"]):
            image.save(f"{changed['fstop']}.png", exposure="auto")
        for image in pz.passes(scene, spp=256):
            image.pixels.mean()
        pz.accuracy(scene, spp=(1, 4), fstop=2.8)
        pz.lens_models(scene, seed=3)
        lens.psf(1, wavelength=550.0)
        lens.image_quality().psf(1, channel="G")
        """,
    )
    assert "Success" in said, said


def test_mypy_finds_wrong_settings(tmp_path):
    wrong = [
        'pz.render("a.pbrt", fstp=4)',
        'pz.prepare("a.pbrt", fstp=4)',
        'pz.plan("a.pbrt", fstp=4)',
        'pz.sweep("a.pbrt", fstp=[4])',
        'pz.passes("a.pbrt", noise=0.1)',
        'pz.accuracy("a.pbrt", fstp=4)',
        'pz.lens_models("a.pbrt", fstp=4)',
        'pz.render("a.pbrt", fstop="4")',
        'pz.render("a.pbrt", coating="gold")',
        'pz.sweep("a.pbrt", fstop=["4"])',
        "pz.Camera(fstp=4)",
        'pz.Lens("a.dat").psf(channel="green")',
    ]
    said = mypy(tmp_path, "\n".join(["import petzval as pz", *wrong]))
    for line, call in enumerate(wrong, 2):
        assert f"program.py:{line}: error" in said, (call, said)
    assert said.count("error:") == len(wrong), said


def test_no_help_names_an_option_of_the_command():
    classes = [pz.Camera, pz.Image, pz.ImageQuality, pz.Job, pz.Lens, pz.Mesh, pz.Scene]
    members = [member for found in classes for member in vars(found).values()]
    for found in [*TAKERS, pz, *classes, *members, pz.compare, pz.dataset, pz.read_image, pz.write_image]:
        assert "--" not in (getattr(found, "__doc__", None) or ""), found


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"focus": (999, 0)}, "'focus' on the pixel 999,0: the picture has 48 x 32"),
        ({"fstop": 0.5}, "'fstop' 0.5: "),
        ({"spp": 1, "noise": 0.1}, "'spp' 1: 'noise' and 'time' need"),
        ({"shutter": "time=1/60,speed=2"}, "shutter='time=1/60,speed=2': expected NAME=VALUE"),
    ],
)
def test_no_message_names_an_option_of_the_command(scene_path, settings, message):
    with pytest.raises((ValueError, OSError)) as error:
        pz.prepare(scene_path, **settings)
    assert message in str(error.value) and "--" not in str(error.value)


def test_no_warning_names_an_option_of_the_command(root, scene_path):
    job = pz.prepare(scene_path, lens=root / "lenses/phone.toml", focus=0.5)
    assert any("'film_diagonal' " in warning for warning in job.warnings), job.warnings
    assert not any("--" in warning for warning in job.warnings)
    assert not any("--" in decision["reason"] for decision in job.plan)


def test_the_code_of_the_manual_is_typed(root, tmp_path):
    blocks = [
        re.findall(r"^```python\n(.*?)^```", (root / page).read_text(), re.M | re.S)
        for page in ("docs/python.md", "python/README.md")
    ]
    manual, readme = map("".join, blocks)
    assert "pz.sweep(" in manual and "pz.render(" in readme
    given = """
    from typing import Any

    import numpy as np

    show: Any
    checkers: Any
    points: Any
    directions: Any
    """
    for text in (manual, readme):
        # Names stand for a value after another in the manual, and values stand alone.
        said = mypy(tmp_path, textwrap.dedent(given) + text, "--allow-redefinition")
        assert "Success" in said, said


def test_the_sweep_of_the_manual_runs(scene_path):
    # The lens of 50 mm opens to f/2.02; the manual's f/2 means that.
    scene = pz.Scene(scene_path)
    stops = [changed["fstop"] for changed, _ in pz.sweep(scene, fstop=[2, 4, 8], focus=[1.0, 2.0], spp=1)]
    assert stops == [2, 2, 4, 4, 8, 8]
    warnings = pz.prepare(scene, fstop=2).warnings
    assert any("2.0" in warning for warning in warnings), warnings
