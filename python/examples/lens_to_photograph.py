"""From a Zemax file to MTF and a photograph.

Run it from anywhere: python lens_to_photograph.py [FOLDER]
The cells (# %%) open as a notebook in editors that know them.
"""

# %% A lens file of Zemax: here a triplet, as a designer would hand it on
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
REPOSITORY = Path(globals().get("__file__", "python/examples/lens_to_photograph.py")).resolve().parent.parent.parent


def of_repository(name):
    """Return the path of a file of the repository."""
    path = REPOSITORY / name
    if not path.exists():
        raise SystemExit(f"{path} is missing: this example reads {name} of petzval's repository")
    return path


ZMX = """VERS 140124 258 36214
MODE SEQ
NAME Cooke triplet, scaled to 50 mm
UNIT MM X W X CM MR CPMM
ENPD 10
FTYP 0 0 3 3 0 0 0
YFLN 0 14 20
WAVM 1 0.4861 1
WAVM 2 0.5876 1
WAVM 3 0.6563 1
PWAV 2
SURF 0
  TYPE STANDARD
  CURV 0
  DISZ INFINITY
SURF 1
  TYPE STANDARD
  CURV 0.0454194
  DISZ 3.25896
  GLAS SK16 0 0 1.62041 60.32
  DIAM 9.5 1 0 0 1
SURF 2
  TYPE STANDARD
  CURV -0.00229461
  DISZ 6.00755
  DIAM 9.5 1 0 0 1
SURF 3
  TYPE STANDARD
  CURV -0.0450176
  DISZ 0.99998
  GLAS F2 0 0 1.62004 36.37
  DIAM 5 1 0 0 1
SURF 4
  STOP
  TYPE STANDARD
  CURV 0.0492825
  DISZ 4.75041
  DIAM 5 1 0 0 1
SURF 5
  TYPE STANDARD
  CURV 0.0125504
  DISZ 2.95208
  GLAS SK16 0 0 1.62041 60.32
  DIAM 7.5 1 0 0 1
SURF 6
  TYPE STANDARD
  CURV -0.0543588
  DISZ 42.2078
  DIAM 7.5 1 0 0 1
SURF 7
  TYPE STANDARD
  CURV 0
  DISZ 0
"""
(out / "triplet.zmx").write_text(ZMX)
lens = pz.Lens(out / "triplet.zmx")
print(lens, f"f/{lens.fno:.2f}")

# %% Section, and modulation over the field
quality = lens.image_quality(image_height=18, fields=10)
figure, (section, transfer) = plt.subplots(1, 2, figsize=(13, 4.5), constrained_layout=True)
lens.draw(section)
frequencies = [10, 20, 40]
tangential, sagittal = quality.mtf(frequencies)
heights = np.abs(quality.image_heights)
for k, frequency in enumerate(frequencies):
    (line,) = transfer.plot(heights, tangential[:, k], label=f"{frequency} cycles/mm")
    transfer.plot(heights, sagittal[:, k], "--", color=line.get_color())
transfer.set(xlabel="image height (mm)", ylabel="modulation", ylim=(0, 1), title="MTF: tangential (solid), sagittal")
transfer.legend()
figure.savefig(out / "lens_to_photograph.png", dpi=100)

# %% A photograph through it
image = pz.render(
    of_repository("scenes/snowman.pbrt"),
    lens=lens,
    focus="auto",
    spp=64,
    resolution=(480, 320),
    aov=["albedo", "normal"],
)
image.save(out / "photograph.png", exposure="auto")
print(image)
