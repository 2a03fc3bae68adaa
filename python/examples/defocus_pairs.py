"""A data set of sharp and blurred pictures with depth: pairs that share their samples.

Run it from anywhere: python defocus_pairs.py [FOLDER] [PAIRS]
The cells (# %%) open as a notebook in editors that know them.
"""

# %% A random scene of arrays for every pair
import json
import sys
from pathlib import Path

import matplotlib

if "ipykernel" not in sys.modules:
    matplotlib.use("agg")
import matplotlib.pyplot as plt
import numpy as np

import petzval as pz

arguments = [] if "ipykernel" in sys.modules else sys.argv[1:]
out = Path(arguments[0] if arguments else "out/defocus")
pairs = int(arguments[1]) if len(arguments) > 1 else 4
out.mkdir(parents=True, exist_ok=True)

# The folder of the repository, two above this file. Cells of a notebook run in it.
REPOSITORY = Path(globals().get("__file__", "python/examples/defocus_pairs.py")).resolve().parent.parent.parent


def of_repository(name):
    """Return the path of a file of the repository."""
    path = REPOSITORY / name
    if not path.exists():
        raise SystemExit(f"{path} is missing: this example reads {name} of petzval's repository")
    return path


LENS = pz.Lens(of_repository("lenses/dgauss.50mm.dat"))


def card(random, depth):
    """Return a card with a random texture, somewhere in the view."""
    x, y = random.uniform(-0.25, 0.25, 2) * depth
    half = random.uniform(0.05, 0.15) * depth
    corners = [[x - half, y - half], [x + half, y - half], [x + half, y + half], [x - half, y + half]]
    turned = random.uniform(-0.3, 0.3, 2) * half
    vertices = [[cx, cy, depth + turned @ np.sign([cx - x, cy - y])] for cx, cy in corners]
    texture = np.kron(random.uniform(0.05, 0.9, (8, 8, 3)), np.ones((16, 16, 1)))
    return pz.Mesh(
        vertices,
        [[0, 2, 1], [0, 3, 2]],
        uv=[[0, 0], [1, 0], [1, 1], [0, 1]],
        material={"type": "diffuse", "reflectance": texture},
    )


def make(seed):
    """Return a scene, and the distance that is in focus (m)."""
    random = np.random.default_rng(seed)
    depths = np.sort(random.uniform(0.8, 4.0, 12))[::-1]
    wall = card(random, 6.0)
    wall.vertices = [[-4, -4, 6], [4, -4, 6], [4, 4, 6], [-4, 4, 6]]
    meshes = [wall] + [card(random, depth) for depth in depths]
    focus = float(random.choice(depths))
    scene = pz.Scene.from_arrays(
        meshes,
        lens=LENS,
        lights=[{"type": "infinite", "L": (1.0, 1.0, 1.0)}],
        look_at=((0, 0, 0), (0, 0, 1)),
        focus=focus,
    )
    return scene, focus


# %% Sharp (f/32) and blurred (f/2.1) with the same seed, and layers
manifest = out / "manifest.jsonl"
done = {json.loads(line)["seed"] for line in manifest.read_text().splitlines()} if manifest.exists() else set()
settings = dict(resolution=(256, 192), spp=32, effects="none")
for seed in range(pairs):
    if seed in done:
        continue
    scene, focus = make(seed)
    pictures = {
        name: pz.render(scene, fstop=stop, seed=seed, aov=["depth", "coc", "normal"], **settings)
        for name, stop in [("sharp", 32.0), ("blurred", 2.1)]
    }
    for name, picture in pictures.items():
        picture.save(out / f"{seed:05d}.{name}.exr")
    fit = LENS.intrinsics(settings["resolution"], width=34.6, distance=1000 * focus)
    row = {
        "seed": seed,
        "focus_m": focus,
        "fstop": {"sharp": 32.0, "blurred": 2.1},
        "matrix": fit["matrix"].tolist(),
        "distortion": dict(zip(fit["names"], fit["distortion"].tolist())),
        **settings,
    }
    # A pair counts once its row is written: a run that was stopped goes on behind the last row.
    with manifest.open("a") as file:
        file.write(json.dumps(row) + "\n")

# %% Look at the last pair
last = f"{pairs - 1:05d}"
sharp, blurred = [pz.read_image(out / f"{last}.{name}.exr") for name in ("sharp", "blurred")]
figure, axes = plt.subplots(1, 2, figsize=(11, 4.5), constrained_layout=True)
for axis, picture, name in zip(axes, (sharp, blurred), ("sharp", "blurred")):
    axis.imshow(np.clip(picture / np.percentile(picture, 99), 0, 1) ** (1 / 2.2))
    axis.set_title(name)
    axis.set_axis_off()
figure.savefig(out / "defocus_pairs.png", dpi=100)
