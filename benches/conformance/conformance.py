#!/usr/bin/env python3
"""Remakes the data of the conformance table with pbrt-v4.

    python3 benches/conformance/conformance.py --pbrt PATH

Writes tests/pbrt_language/rows.jsonl: for each row of rows.py its scene, the mean of pbrt's picture with its standard
error, and a thumbnail of 16 x 16 luminances. Rows whose scene has not changed are kept. tests/pbrt_language renders
the scenes with petzval and compares. Needs numpy.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

import rows

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
sys.path.insert(0, str(HERE.parent / "scoreboard"))
import pictures  # noqa: E402

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
# Independent pictures, whose spread gives the standard error, and samples a pixel of each.
SEEDS = 4
SAMPLES = 256
# Texels along a side of the thumbnails.
TEXELS = 16
TARGET = ROOT / "tests/pbrt_language/rows.jsonl"


class Failed(Exception):
    """A scene that pbrt refuses."""


def main():
    parser = argparse.ArgumentParser(description="Remakes the data of the conformance table.")
    parser.add_argument("--pbrt", default="pbrt", help="pbrt-v4's program")
    parser.add_argument("--threads", type=int, default=2, help="rows rendered at a time")
    parser.add_argument("--all", action="store_true", help="renders unchanged rows again, too")
    options = parser.parse_args()
    kept = {}
    if TARGET.exists() and not options.all:
        entries = map(json.loads, TARGET.read_text().splitlines())
        kept = {entry["scene"]: entry for entry in entries}
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(options.threads) as pool:
        jobs = [
            pool.submit(entry, options.pbrt, row, kept.get(row.scene), Path(folder) / f"{number}.pbrt")
            for number, row in enumerate(rows.ROWS)
        ]
        found, failed = [], []
        for job in jobs:
            try:
                found.append(json.dumps(job.result()))
            except Failed as error:
                failed.append(str(error))
    TARGET.parent.mkdir(exist_ok=True)
    TARGET.write_text("\n".join(found) + "\n")
    print(f"{TARGET}: {len(found)} rows")
    if failed:
        sys.exit("\n".join(failed))


def entry(pbrt, row, kept, scene):
    """Returns the entry of a row: what pbrt gives, and what rows.py says of it."""
    measured = kept or measure(pbrt, row, scene)
    keys = ("mean", "error", "thumbnail")
    new = {"group": row.group, "name": row.name, "scene": row.scene}
    new |= {key: measured[key] for key in keys}
    new |= {key: getattr(row, key) for key in ("differs", "missing") if getattr(row, key)}
    if row.spectra:
        new["spectra"] = True
    return new | {"tolerance": row.tolerance}


def measure(pbrt, row, scene):
    """Renders a row with pbrt."""
    scene.write_text(row.scene.replace("@ROOT@", str(ROOT)))
    all_pictures = np.array([render(pbrt, scene, seed) for seed in range(SEEDS)])
    means = all_pictures.mean((1, 2))
    picture = all_pictures.mean(0)
    luminance = picture @ LUMINANCE
    # Samples of neighbouring pixels are not independent: the spread of whole pictures counts.
    error = means.std(0, ddof=1) / np.sqrt(SEEDS)
    print(f"{row.group}: {row.name}: {means.mean(0)} +- {error}", file=sys.stderr, flush=True)
    return {
        "mean": rounded(means.mean(0)),
        "error": rounded(error),
        "thumbnail": thumbnail(luminance),
    }


def render(pbrt, scene, seed):
    """Renders a scene and returns its picture."""
    target = scene.with_suffix(f".{seed}.exr")
    command = [pbrt, "--quiet", "--nthreads", "1", "--seed", str(seed), "--spp", str(SAMPLES)]
    done = subprocess.run(
        [*command, "--outfile", target, scene], stdin=subprocess.DEVNULL, capture_output=True, text=True
    )
    if done.returncode or not target.exists():
        raise Failed(f"{scene.read_text()}\npbrt ends with {done.returncode}:\n{done.stdout}{done.stderr}")
    return pictures.read(target)


def thumbnail(luminance):
    """Returns the maximum of block means, and the means as bytes of it in hexadecimal, row by row."""
    height, width = luminance.shape
    rows_at = [height * i // TEXELS for i in range(TEXELS + 1)]
    columns_at = [width * i // TEXELS for i in range(TEXELS + 1)]
    blocks = np.array(
        [
            [luminance[y0:y1, x0:x1].mean() for x0, x1 in zip(columns_at, columns_at[1:])]
            for y0, y1 in zip(rows_at, rows_at[1:])
        ]
    )
    most = max(float(blocks.max()), 1e-30)
    texels = np.clip(np.round(blocks / most * 255), 0, 255).astype(np.uint8)
    return {"white": rounded(most), "texels": texels.tobytes().hex()}


def rounded(values):
    """Returns numbers with five digits."""
    if np.ndim(values):
        return [rounded(value) for value in values]
    return float(f"{float(values):.5g}")


if __name__ == "__main__":
    main()
