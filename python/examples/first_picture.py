"""A first picture: read a scene, see what it needs, render it, and stop the lens down.

Run it from anywhere: python first_picture.py [FOLDER]
The cells (# %%) open as a notebook in editors that know them.
"""

# %% Read the scene once
import sys
from pathlib import Path

import matplotlib

if "ipykernel" not in sys.modules:
    matplotlib.use("agg")
import matplotlib.pyplot as plt
import numpy as np

import petzval as pz

out = Path(sys.argv[1] if len(sys.argv) > 1 and "ipykernel" not in sys.modules else "out")
out.mkdir(parents=True, exist_ok=True)

# The folder of the repository, two above this file. Cells of a notebook run in it.
REPOSITORY = Path(globals().get("__file__", "python/examples/first_picture.py")).resolve().parent.parent.parent


def of_repository(name):
    """Return the path of a file of the repository."""
    path = REPOSITORY / name
    if not path.exists():
        raise SystemExit(f"{path} is missing: this example reads {name} of petzval's repository")
    return path


scene = pz.Scene(of_repository("scenes/snowman.pbrt"))

# %% What the picture needs, and why
for decision in pz.plan(scene):
    print(f"{decision['effect']:16s} {'on' if decision['on'] else 'off':4s} {decision['reason']}")

# %% Three apertures: the same light, another depth of field
stops = [2.8, 5.6, 11]
images = [
    pz.render(scene, fstop=stop, focus="auto", spp=32, resolution=(360, 240), aov=["coc"])
    for stop in stops
]


# %% The pictures, each as bright as the first, and their circles of confusion
def shown(image, factor):
    """Return linear light as sRGB for the screen."""
    light = np.clip(image.pixels * factor, 0, 1)
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)


figure, axes = plt.subplots(2, 3, figsize=(13, 6), constrained_layout=True)
for column, stop, image in zip(axes.T, stops, images):
    column[0].imshow(shown(image, 0.9 / np.percentile(image.pixels, 99)))
    column[0].set_title(f"f/{stop}")
    blur = column[1].imshow(np.abs(image.layers["coc"][..., 0]), vmin=0, vmax=300, cmap="magma")
    for axis in column:
        axis.set_axis_off()
figure.colorbar(blur, ax=axes[1], label="circle of confusion (um)")
figure.savefig(out / "first_picture.png", dpi=100)
images[0].save(out / "first_picture.exr")
