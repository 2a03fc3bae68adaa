"""The command ``petzval-denoise``: the arguments of Open Image Denoise's program that ``petzval render
--denoise`` needs, for machines that have its library alone."""

import argparse
import os
import sys

import numpy as np

from . import denoise


def main(arguments=None):
    """Denoise a picture. Returns the exit code."""
    options = _parser().parse_args(arguments)
    files = {"color": options.hdr, "albedo": options.alb, "normal": options.nrm}
    files = {name: path for name, path in files.items() if path is not None}
    if not files:
        print("petzval-denoise: error: no picture is given: --hdr, --alb or --nrm", file=sys.stderr)
        return 2
    flags = {"hdr": options.hdr is not None, "cleanAux": options.clean_aux}
    try:
        images = {name: read_pfm(path) for name, path in files.items()}
        for path in files.values():
            if os.path.exists(options.output) and os.path.samefile(options.output, path):
                raise ValueError(f"cannot write {options.output}: it is the same file as {path}, an input")
        result = denoise.filtered(images, [name for name, on in flags.items() if on])
        write_pfm(options.output, result)
    except (ImportError, OSError, RuntimeError, ValueError) as problem:
        print(f"petzval-denoise: error: {problem}", file=sys.stderr)
        return 1
    return 0


def _parser():
    parser = argparse.ArgumentParser(
        prog="petzval-denoise",
        description="Removes the noise of a picture by Open Image Denoise. All files are PFM.",
    )
    parser.add_argument("--hdr", metavar="FILE", help="picture in linear light")
    parser.add_argument("--alb", metavar="FILE", help="albedo; denoised if there is no picture")
    parser.add_argument("--nrm", metavar="FILE", help="normals; denoised if there is no picture")
    parser.add_argument("--clean_aux", action="store_true", help="albedo and normals have no noise")
    parser.add_argument("-o", "--output", metavar="FILE", required=True, help="denoised picture")
    return parser


def read_pfm(path):
    """Return a portable float map of three channels: height x width x 3, row 0 at the top."""
    with open(path, "rb") as file:
        kind, width, height, scale = (_word(file) for _ in range(4))
        values = file.read()
    try:
        size, scale = (int(height), int(width)), float(scale)
    except ValueError:
        raise ValueError(f"{path}: its header is not width, height and scale") from None
    if kind != b"PF" or min(size) < 1 or len(values) != 12 * size[0] * size[1]:
        raise ValueError(f"{path}: it is not a PFM file of three channels")
    # A negative scale means little-endian.
    pixels = np.frombuffer(values, "<f4" if scale < 0 else ">f4").reshape(*size, 3)
    return np.ascontiguousarray(pixels[::-1], dtype=np.float32) * np.float32(abs(scale))


def _word(file):
    """Return a word of a header and skip the single blank after it."""
    word = b""
    while len(word) < 32:
        byte = file.read(1)
        if byte.isspace() and word:
            break
        if not byte:
            break
        word += byte.strip()
    return word


def write_pfm(path, pixels):
    """Write height x width x 3 as a portable float map."""
    height, width = pixels.shape[:2]
    with open(path, "wb") as file:
        file.write(b"PF\n%d %d\n-1.0\n" % (width, height))
        file.write(pixels[::-1].astype("<f4").tobytes())
