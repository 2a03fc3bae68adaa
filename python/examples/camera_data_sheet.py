"""The data sheet of a camera, from a lens file and a sensor file.

Run it from anywhere: python camera_data_sheet.py [FOLDER [LENS [SENSOR]]]
Lens files may be of Zemax (.zmx) or any other format that petzval reads. The cells (# %%) open as a notebook in editors
that know them.
"""

# %% The camera: a triplet of 50 mm at f/5.6 before the sensor of a phone, focused at 3 m
import sys
from pathlib import Path

import matplotlib

if "ipykernel" not in sys.modules:
    matplotlib.use("agg")
import matplotlib.pyplot as plt
import numpy as np

import petzval as pz

arguments = sys.argv[1:] if "ipykernel" not in sys.modules else []
out = Path(arguments[0] if arguments else "out")
out.mkdir(parents=True, exist_ok=True)

# The folder of the repository, two above this file. Cells of a notebook run in it.
REPOSITORY = Path(globals().get("__file__", "python/examples/camera_data_sheet.py")).resolve().parent.parent.parent


def named(place, default):
    """Return the path of an argument, or of a file of the repository."""
    path = Path(arguments[place]) if len(arguments) > place else REPOSITORY / default
    if not path.exists():
        raise SystemExit(f"{path} is missing: this example reads it, or the file that you name")
    return path


lens = pz.Lens(named(1, "lenses/triplet.toml"))
settings = str(named(2, "scenes/cornell/pixel4a.toml"))
camera = dict(focus=3.0, fstop=5.6, resolution=(900, 600), film_size="35mm")

# %% Resolution: slanted edges (ISO 12233), their spatial frequency response at nine places
edges = pz.chart("edges", lens, out / "edges.pbrt", **camera)
picture = pz.render(edges["scene"], spp=256, effects="+dispersion")
sharpness = [pz.measure.edge(picture.pixels, region) for region in edges["edges"]]
centres = [((x0 + x1) / 2, (y0 + y1) / 2) for x0, y0, x1, y1 in edges["edges"]]
# Fields: distances from the middle of the picture, as shares of half the diagonal.
middle = np.array(picture.size) / 2
fields = [float(np.hypot(*(np.array(centre) - middle)) / np.hypot(*middle)) for centre in centres]
centre, corner = int(np.argmin(fields)), int(np.argmax(fields))

# %% Distortion and lateral colour: a grid of dots. Shading: a white chart
grid = pz.measure.grid(pz.render(pz.chart("grid", lens, out / "grid.pbrt", **camera)["scene"], spp=32).pixels)
white = pz.render(pz.chart("flat", lens, out / "flat.pbrt", **camera)["scene"], spp=64)
shading = pz.measure.shading(white.pixels)

# %% The sensor: photon transfer (EMVA 1288), from pairs of pictures of even light
pitch = 1000 * 36 / camera["resolution"][0]
sensor = pz.Sensor(f"{settings},iso=100", pitch=pitch)
# All filters of a mosaic see white light alike.
flat = np.ones((600, 600), np.float32)
levels = np.concatenate([[0.0], np.geomspace(0.002, 0.9, 12)])
means, variances = [], []
for number, level in enumerate(levels):
    first, second = (sensor.codes(level * flat, seed=2 * number + k).astype(float) for k in (0, 1))
    means.append((first + second).mean() / 2)
    # The difference of two pictures has twice the temporal noise, and no fixed pattern.
    variances.append((first - second).var() / 2)
signal, noise = np.array(means) - means[0], np.array(variances)
gain = float(np.polyfit(signal, noise, 1)[0])
# Rounding to codes adds a twelfth of a code squared.
read_noise = float(np.sqrt(max(noise[0] - 1 / 12, 0)) / gain)
dynamic_range = float(20 * np.log10(sensor.full_well / max(read_noise, 1e-9)))

# %% The data sheet
rows = [
    ("lens", lens.name),
    ("focal length", f"{lens.efl:.2f} mm"),
    ("MTF50, middle", f"{sharpness[centre]['mtf50']:.3f} cycles/pixel"),
    ("MTF50, corner", f"{sharpness[corner]['mtf50']:.3f} cycles/pixel"),
    ("distortion", f"{grid['distortion_percent']:+.2f} %"),
    ("light in the corners", f"{100 * np.mean(shading['corners']):.0f} %"),
    ("full well", f"{sensor.full_well:.0f} electrons"),
    ("gain", f"{gain:.4f} codes/electron, put in {sensor.gain:.4f}"),
    ("read noise", f"{read_noise:.2f} electrons, put in {sensor.read_noise:g}"),
    ("dynamic range", f"{dynamic_range:.1f} dB"),
]
for name, value in rows:
    print(f"{name:22} {value}")

figure, panels = plt.subplots(2, 3, figsize=(15, 8), constrained_layout=True)
(section, response, table), (distorted, falloff, transfer) = panels
lens.draw(section)
for place, label in ((centre, "middle"), (corner, "corner")):
    found = sharpness[place]
    response.plot(found["cycles_per_pixel"], found["response"], label=label)
response.set(xlim=(0, 0.5), ylim=(0, 1.05), xlabel="cycles/pixel", ylabel="response", title="Slanted edges")
response.legend()
table.axis("off")
for i, (name, value) in enumerate(rows):
    table.text(0.0, 0.95 - 0.095 * i, name, weight="bold", transform=table.transAxes)
    table.text(0.42, 0.95 - 0.095 * i, value, transform=table.transAxes)
table.set_title("Data sheet")
# Near the middle, a fraction of a pixel is a large share of the distance.
dots = [(dot["radius"], dot["distortion_percent"]) for dot in grid["dots"] if dot["radius"] > 30]
distorted.plot(*zip(*dots), ".")
distorted.set(xlabel="distance from the middle (pixels)", ylabel="%", title="Distortion, grid of dots")
falloff.imshow(white.pixels[..., 1] / white.pixels[..., 1].max(), vmin=0, vmax=1, cmap="gray")
falloff.set_title("Shading")
transfer.loglog(signal[1:], noise[1:], "o", label="measured")
transfer.loglog(signal[1:], noise[0] + gain * signal[1:], label="gain and read noise")
transfer.set(xlabel="signal (codes)", ylabel="variance (codes²)", title="Photon transfer")
transfer.legend()
figure.savefig(out / "camera_data_sheet.png", dpi=80)
