#!/usr/bin/env python3
"""Writes the measured materials of the conformance table.

    python3 benches/conformance/measured.py tests/pbrt_language

They are microfacets (GGX) in the parameterization of Dupuy & Jakob 2018, with a made-up colour and brightness that
depend on all parameters. Needs numpy.
"""

import struct
import sys
from pathlib import Path

import numpy as np

WAVELENGTHS = np.array([380.0, 450.0, 520.0, 600.0, 680.0, 780.0])
FLOAT32, UINT8 = 10, 1


def unit_vector(theta, phi):
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1)


def fields(phi_i, theta_i, alpha, side):
    """Returns the arrays of a surface of the given roughness along x and y, with side x side points."""
    u, v = np.meshgrid(np.linspace(0, 1, side), np.linspace(0, 1, side))
    theta, phi = u**2 * np.pi / 2, (2 * v - 1) * np.pi

    def distribution(theta, phi):
        stretch = (np.cos(phi) / alpha[0]) ** 2 + (np.sin(phi) / alpha[1]) ** 2
        cos2 = np.cos(theta) ** 2 + np.sin(theta) ** 2 * stretch
        return 1 / (np.pi * alpha[0] * alpha[1] * cos2**2)

    steps = 400
    fine_theta, fine_phi = np.meshgrid(
        (np.arange(steps) + 0.5) / steps * np.pi / 2, (np.arange(steps) + 0.5) / steps * 2 * np.pi
    )
    normals = unit_vector(fine_theta, fine_phi)
    solid_angle = np.sin(fine_theta) * (np.pi / 2 / steps) * (2 * np.pi / steps)
    weights = distribution(fine_theta, fine_phi) * solid_angle
    directions = unit_vector(theta, phi).reshape(-1, 3)
    sigma = np.array([(np.maximum(normals @ w, 0) * weights).sum() for w in directions]).reshape(side, side)
    ndf = distribution(theta, phi)
    shape = (len(phi_i), len(theta_i), side, side)
    vndf, luminance = np.zeros(shape), np.zeros(shape)
    spectra = np.zeros((*shape[:2], len(WAVELENGTHS), side, side))
    for i, phi_o in enumerate(phi_i):
        for j, theta_o in enumerate(theta_i):
            visible = np.maximum(unit_vector(theta, phi) @ unit_vector(theta_o, phi_o), 0)
            vndf[i, j] = visible * ndf * 2 * np.pi**2 * u * np.sin(theta) + 1e-3
            luminance[i, j] = 0.4 + 0.5 * u + 0.3 * np.cos(2 * np.pi * v) * np.cos(theta_o)
            shade = (0.7 + 0.3 * u) * (1 - 0.4 * np.sin(2 * np.pi * v) ** 2 * (1 - np.cos(theta_o)))
            for k, wavelength in enumerate(WAVELENGTHS):
                spectra[i, j, k] = (0.25 + 0.6 * np.exp(-(((wavelength - 600) / 90) ** 2))) * shade
    arrays = {"theta_i": theta_i, "phi_i": phi_i, "ndf": ndf, "sigma": sigma, "vndf": vndf}
    return arrays | {"luminance": luminance, "spectra": spectra, "wavelengths": WAVELENGTHS}


def write(path, arrays):
    description = b"synthetic microfacets"
    entries = [("description", UINT8, (len(description),), description), ("jacobian", UINT8, (1,), b"\0")]
    for name, array in arrays.items():
        entries.append((name, FLOAT32, array.shape, array.astype("<f4").tobytes()))
    head = b"tensor_file\0" + bytes([1, 0]) + struct.pack("<I", len(entries))
    offset = len(head) + sum(13 + len(name) + 8 * len(shape) for name, _, shape, _ in entries)
    for name, kind, shape, data in entries:
        head += struct.pack("<H", len(name)) + name.encode()
        head += struct.pack("<HBQ", len(shape), kind, offset) + struct.pack(f"<{len(shape)}Q", *shape)
        offset += len(data)
    path.write_bytes(head + b"".join(data for *_, data in entries))


def main():
    folder = Path(sys.argv[1])
    steep = np.pi / 2 * 0.95
    write(folder / "isotropic.bsdf", fields(np.zeros(1), np.linspace(0, steep, 4), (0.35, 0.35), 12))
    around = np.linspace(-np.pi, np.pi, 5)
    write(folder / "anisotropic.bsdf", fields(around, np.linspace(0, steep, 3), (0.5, 0.25), 8))


if __name__ == "__main__":
    main()
