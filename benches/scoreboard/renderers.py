"""Renderers of the scoreboard: how each is found, asked for its version, and run."""

import json
import os
import re
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).resolve().parent


class Missing(Exception):
    """A renderer that this machine does not have, or that does not work; the text says why."""


@dataclass
class Job:
    """A picture to render."""

    scene: object
    spp: int
    seed: int
    threads: int
    out: Path  # without its suffix


def ask(command, environment=None):
    """Returns what a program prints, or raises Missing."""
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=120, env=environment)
    except FileNotFoundError as error:
        raise Missing(f"there is no program {command[0]}") from error
    except (OSError, subprocess.TimeoutExpired) as error:
        raise Missing(f"{command[0]}: {error}") from error
    if done.returncode:
        lines = done.stderr.strip().splitlines() or [f"exit code {done.returncode}"]
        reason = next((line for line in lines if "ERROR" in line), lines[-1])
        raise Missing(f"{command[0]}: {reason[:100]}")
    return done.stdout + done.stderr


class Renderer:
    """What the scoreboard knows of a renderer."""

    name: str
    version: str
    suffix: str  # of its pictures
    compared_with: str | None = None  # renderer whose picture is to be the same
    warm_up = False  # whether the first run on a scene takes longer than the others
    environment: dict | None = None  # of its processes, if it is not that of the scoreboard

    def file(self, scene):
        """Returns the file that it reads, or None if it cannot draw the scene."""
        raise NotImplementedError

    def command(self, job):
        raise NotImplementedError


class Petzval(Renderer):
    """petzval, through the lens's prescription."""

    name, suffix, effects = "petzval", ".exr", "none"

    def __init__(self, program):
        self.program = program
        self.version = ask([program, "--version"]).strip()

    def file(self, scene):
        return scene.real

    def options(self):
        # pbrt places the film by its thick-lens formula.
        return ["--focus-model", "pbrt"]

    def command(self, job):
        return [
            self.program, "render", str(self.file(job.scene)), "--effects", self.effects,
            "--checkpoint", "off", *self.options(), "--spp", str(job.spp), "--seed", str(job.seed),
            "--threads", str(job.threads), "-o", f"{job.out}{self.suffix}",
        ]  # fmt: skip


class PetzvalSpectra(Petzval):
    """petzval by wavelength, as pbrt renders, without any other effect."""

    name, compared_with = "petzval, spectra", "petzval"
    effects = "+spectra" + "".join(
        f",-{effect}" for effect in ("dispersion", "ghosts", "fresnel", "iris", "diffraction", "motion",
                                     "rolling_shutter", "sensor", "tilt_shift", "media")
    )  # fmt: skip


class PetzvalThin(Petzval):
    """petzval, through a thin lens: what the renderers without lens prescriptions draw."""

    name = "petzval, thin lens"

    def file(self, scene):
        return scene.thin

    def options(self):
        return []


class Pbrt(Renderer):
    """pbrt-v4, on the files that petzval reads."""

    name, suffix, compared_with = "pbrt-v4", ".pfm", "petzval"

    def __init__(self, program):
        self.program = program
        # pbrt does not tell its version.
        if "--nthreads" not in ask([program, "--help"]):
            raise Missing(f"{program} is not pbrt-v4: its help does not list --nthreads")
        self.version = "pbrt-v4"

    def file(self, scene):
        return scene.real

    def command(self, job):
        return [
            self.program, "--quiet", "--nthreads", str(job.threads), "--spp", str(job.spp),
            "--seed", str(job.seed), "--outfile", f"{job.out}{self.suffix}", str(job.scene.real),
        ]  # fmt: skip


class Mitsuba(Renderer):
    """Mitsuba 3, with the Python that has it."""

    name, suffix, compared_with = "Mitsuba 3", ".npy", "petzval, thin lens"
    # The first run on a scene compiles it, and later runs find the code in a folder of the user.
    warm_up = True

    def __init__(self, python):
        self.child = [python, str(HERE / "mitsuba_child.py")]
        try:
            ask([python, "-c", "import mitsuba"])
        except Missing as error:
            raise Missing(f"{error}; install it with pip, or name a Python that has it") from error
        failures = []
        for self.variant in ("llvm_ad_rgb", "scalar_rgb"):
            try:
                answer = ask([*self.child, "--probe", self.variant])
                version = re.search(r"^mitsuba (\S+)$", answer, re.MULTILINE)[1]
                self.version = f"Mitsuba {version}, {self.variant}"
                break
            except Missing as error:
                failures.append(f"{self.variant}: {error}")
        else:
            raise Missing("; ".join(failures))
        if failures:
            self.version += f" (slower than llvm_ad_rgb, which does not work: {failures[0]})"

    def file(self, scene):
        return scene.description

    def command(self, job):
        order = {
            "scene": str(job.scene.description), "variant": self.variant,
            "spp": job.spp, "seed": job.seed, "threads": job.threads, "out": f"{job.out}{self.suffix}",
        }  # fmt: skip
        return [*self.child, json.dumps(order)]


class Cycles(Mitsuba):
    """Cycles, in Blender without a window."""

    name, suffix, variant, warm_up = "Cycles", ".exr", None, False

    def __init__(self, program):
        # Blender takes the modules of the first Python on PATH, and needs those beside itself.
        folder = os.path.dirname(shutil.which(program) or program)
        self.environment = {**os.environ, "PATH": folder + os.pathsep + os.environ.get("PATH", "")}
        self.version = ask([program, "--background", "--version"]).splitlines()[0]
        test = [program, "--background", "--factory-startup", "--python-exit-code", "1"]
        ask([*test, "--python-expr", "import numpy"], self.environment)
        self.child = [
            program, "--background", "--factory-startup", "--python-exit-code", "1",
            "--python", str(HERE / "cycles_child.py"), "--",
        ]  # fmt: skip


def petzval_program(given):
    """Returns the petzval to measure: the option, else $PETZVAL, else the build, else on PATH."""
    built = HERE.parents[1] / "target" / "release" / "petzval"
    for place in (given, os.environ.get("PETZVAL"), built if built.exists() else None):
        if place:
            return str(place)
    return shutil.which("petzval") or "petzval"


def find(options):
    """Returns the renderers of this machine, and why each of the others is missing."""
    makers = [
        (Petzval, petzval_program(options.petzval)),
        (PetzvalSpectra, petzval_program(options.petzval)),
        (PetzvalThin, petzval_program(options.petzval)),
        (Pbrt, options.pbrt),
        (Mitsuba, options.mitsuba),
        (Cycles, options.blender),
    ]
    found, missing = [], {}
    for maker, program in makers:
        if options.renderers and maker.name.split()[0].rstrip(",").lower() not in options.renderers:
            continue
        try:
            found.append(maker(program))
        except Missing as error:
            missing[maker.name] = str(error)
    return found, missing
