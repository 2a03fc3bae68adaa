"""Runs of a renderer, and what follows from their times and pictures."""

import os
import re
import subprocess
import time
from dataclasses import dataclass, field
from statistics import median

import numpy as np

import pictures

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
# Share of the pixels whose variance counts as no more than that of the others.
FIREFLIES = 0.001
# Parts of the picture, along each side, whose means are compared.
PARTS = 8


class Failed(Exception):
    """A run that ended with an error."""


@dataclass
class Run:
    cpu: float
    wall: float


def run(command, environment=None):
    """Runs a child process and returns its CPU time (user and system) and its duration."""
    start = time.monotonic()
    child = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, bufsize=0, env=environment
    )
    try:
        with child.stdout:
            text = child.stdout.read().decode(errors="replace")
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
    except BaseException:
        child.kill()
        child.wait()
        raise
    if child.returncode:
        plain = re.sub(r"\x1b\[[0-9;]*m", "", text)
        last = "\n".join(plain.strip().splitlines()[-5:])
        raise Failed(f"{command[0]} ended with exit code {child.returncode}:\n{last}")
    return Run(usage.ru_utime + usage.ru_stime, time.monotonic() - start)


@dataclass
class Series:
    """The runs of one renderer on one scene with one number of threads."""

    spp: int
    base_spp: int
    full: list = field(default_factory=list)
    base: list = field(default_factory=list)

    def render_cpu(self):
        """Returns the median CPU time of the samples alone, by the difference to few samples."""
        part = self.spp / (self.spp - self.base_spp)
        times = [part * (a.cpu - b.cpu) for a, b in zip(self.full, self.base)]
        return median(times)

    def whole_cpu(self):
        return median(r.cpu for r in self.full)

    def wall(self):
        return median(r.wall for r in self.full)


class Noise:
    """Statistics of pictures of one scene that differ in their seeds."""

    def __init__(self, paths):
        stack = np.stack([pictures.read(path) for path in paths])
        self.size = stack.shape[1:3]
        self.mean_picture = stack.mean(0)
        luminance = stack @ LUMINANCE
        if not np.isfinite(luminance).all():
            raise Failed(f"{paths[0]}: the picture has values that are not finite")
        # Of two pictures a and b this is (a - b)^2 / 2.
        variance = luminance.var(0, ddof=1)
        self.mean = float(luminance.mean())
        if self.mean <= 0:
            raise Failed(f"{paths[0]}: the picture is black")
        self.raw_variance = float(variance.mean()) / self.mean**2
        limit = np.quantile(variance, 1 - FIREFLIES)
        self.relative_variance = float(np.minimum(variance, limit).mean()) / self.mean**2
        # Means of the picture and of its parts, with the squares of their standard errors.
        self.error2 = float(variance.mean()) / variance.size / len(stack)
        self.parts, self.parts_error2 = blocks(luminance.mean(0)), blocks(variance)
        self.parts_error2 *= PARTS**2 / variance.size / len(stack)


def blocks(values):
    """Returns the means of PARTS x PARTS parts of a picture."""
    rows = np.array_split(values, PARTS, axis=0)
    return np.array([[part.mean() for part in np.array_split(row, PARTS, axis=1)] for row in rows])


@dataclass
class Agreement:
    """How far a picture is from the one that it is compared with, relative to the means."""

    difference: float
    error: float
    problems: list


def compare(noise, reference, tolerance):
    """Compares the mean, and the means of parts, which shift if the pictures show different things."""
    if noise.size != reference.size:
        return Agreement(float("nan"), 0, [f"sizes differ: {noise.size} and {reference.size}"])
    scale = reference.mean
    difference = noise.mean / scale - 1
    error = (noise.error2 + reference.error2) ** 0.5 / scale
    problems = []
    if abs(difference) > tolerance + 3 * error:
        problems.append(
            f"the mean differs by {difference:+.2%}; allowed are {tolerance:.1%} and 3 standard errors"
            f" of {error:.2%}"
        )
    allowed = 0.1 * np.abs(reference.parts) + 2 * tolerance * scale
    allowed += 4 * np.sqrt(noise.parts_error2 + reference.parts_error2)
    excess = np.abs(noise.parts - reference.parts) / allowed
    if excess.max() > 1:
        row, column = np.unravel_index(excess.argmax(), excess.shape)
        a, b = noise.parts[row, column], reference.parts[row, column]
        problems.append(
            f"{(excess > 1).sum()} of {PARTS * PARTS} parts differ, most of all the part in row"
            f" {row + 1}, column {column + 1}: {a:.4g}, not {b:.4g}"
        )
    return Agreement(difference, error, problems)
