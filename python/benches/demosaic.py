"""Compare the demosaicking of `petzval develop` with that of libraw.

Each picture is sampled by a Bayer mosaic without noise, written as DNG, and developed. The table has the peak signal-to-noise
ratio of signals with a gamma of 2.2 (dB), without eight pixels of border.

    python python/benches/demosaic.py PICTURE...
"""

import sys
import tempfile
from pathlib import Path

import numpy as np
import rawpy

import petzval as pz

METHODS = ["LINEAR", "PPG", "AHD", "DHT"]
SENSOR = "iso=100,well=1e10,read=0,bits=16,black=1000,bayer"
SCENE = Path(__file__).resolve().parents[2] / "scenes" / "dgauss.pbrt"


def write_mosaic(picture, path):
    height, width, _ = picture.shape
    image = pz.render(SCENE, sensor=SENSOR, resolution=(width, height), spp=1)
    for place, channel in enumerate([0, 1, 1, 2]):
        at = np.s_[place // 2 :: 2, place % 2 :: 2]
        image.pixels[at] = picture[at][..., channel]
    image.save(path)


def psnr(found, picture):
    found, picture = (np.clip(pixels[8:-8, 8:-8], 0, 1) ** (1 / 2.2) for pixels in (found, picture))
    return -10 * np.log10(np.mean((found - picture) ** 2))


def of_libraw(path, method):
    with rawpy.imread(str(path)) as raw:
        codes = raw.postprocess(
            demosaic_algorithm=rawpy.DemosaicAlgorithm[method],
            use_camera_wb=True,
            no_auto_bright=True,
            adjust_maximum_thr=0,
            gamma=(1, 1),
            output_bps=16,
        )
    return codes / 65535


def main(names):
    print("picture".ljust(36), "petzval", *(f"{method:>7}" for method in METHODS))
    for name in names:
        picture = np.clip(pz.read_image(name), 0, None)
        picture = np.minimum(picture / np.percentile(picture, 99.5), 1)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "mosaic.dng"
            write_mosaic(picture, path)
            found = [psnr(pz.develop(path), picture)]
            found += [psnr(of_libraw(path, method), picture) for method in METHODS]
        print(Path(name).name.ljust(36), *(f"{ratio:7.2f}" for ratio in found))


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    main(sys.argv[1:])
