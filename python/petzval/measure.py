"""Measurements of test charts in arrays, those of ``petzval measure``.

Pictures are linear sRGB, height x width x 3. Edges and texture are measured in their luminance, or in an array of
height x width, such as one channel. Divide pictures by that of a white chart if the light falls off. A region is
``(x0, y0, x1, y1)`` in pixels; ``x1`` and ``y1`` are not included.
"""

import json as _json
import os as _os
from collections.abc import Sequence as _Sequence
from typing import Any, Optional, Union

from numpy.typing import ArrayLike

from . import _petzval

__all__ = ["colours", "edge", "greys", "grid", "noise", "shading", "star", "texture"]


def edge(pixels: ArrayLike, region: _Sequence[int]) -> dict[str, Any]:
    """Measure the spatial frequency response of a slanted edge (ISO 12233).

    :returns: ``mtf50`` and ``mtf10`` (cycles/pixel; ``None`` where the response stays above), ``rise_pixels``,
        ``contrast``, ``levels``, ``slant_degrees``, the ``axis`` of the frequencies, and ``response`` by
        ``cycles_per_pixel``
    """
    return _json.loads(_petzval.measure_edge(pixels, tuple(region)))


def texture(
    pixels: ArrayLike, region: _Sequence[int], chart: ArrayLike, second: Optional[ArrayLike] = None
) -> dict[str, Any]:
    """Measure the response to the dead leaves of ``petzval chart leaves``.

    :param chart: the picture of the leaves
    :param second: a picture of the same chart with other noise: the noise of neither counts as texture then
    :returns: ``response`` by ``cycles_per_pixel``
    """
    return _json.loads(_petzval.measure_texture(pixels, tuple(region), chart, second))


def grid(pixels: ArrayLike) -> dict[str, Any]:
    """Measure distortion and lateral colour from a picture of a grid of dark dots.

    :returns: ``distortion_percent`` at the farthest dot, the ``middle`` of the picture, ``steps`` from dot to dot along
        rows and columns (pixels), ``residual`` (pixels), and all ``dots``
    """
    return _json.loads(_petzval.measure_grid(pixels))


def colours(pixels: ArrayLike, region: _Sequence[int]) -> dict[str, Any]:
    """Measure colour errors from a picture of a colour checker.

    :param region: the rectangle of the 24 patches, without the frame of the chart
    :returns: ``mean_de2000``, ``max_de2000``, ``white_balance_error`` in a* and b*, ``brightness``, and the 24
        ``patches``. A mean beyond 15 is that of another region
    """
    return _json.loads(_petzval.measure_colours(pixels, tuple(region)))


def star(
    pixels: ArrayLike, region: _Sequence[int], cycles: int = 72, modulation: float = 0.6
) -> dict[str, Any]:
    """Measure the spatial frequency response of a sinusoidal Siemens star (ISO 12233).

    :param region: the square that the star fills
    :param cycles: cycles around the star; 72 in that of ``petzval chart star``
    :param modulation: that of the star on its chart, 0.6 for a contrast of 4:1
    :returns: ``centre`` (pixels), ``mtf50`` and ``mtf10`` (cycles/pixel; ``None`` where the response stays above),
        ``response`` by ``cycles_per_pixel``, and that of each of eight ``segments``
    """
    return _json.loads(_petzval.measure_star(pixels, tuple(region), cycles, modulation))


def greys(pixels: ArrayLike, region: _Sequence[int]) -> dict[str, Any]:
    """Measure tone, noise and dynamic range from a picture of ``petzval chart greys``.

    :param region: the rectangle of the 20 steps, without the frame of the chart
    :returns: ``exposure`` (the value of a reflectance of 1), ``dynamic_range_stops`` (``None`` beyond the chart), and the
        20 ``steps`` with ``reflectance``, ``value``, ``noise``, ``snr`` (``None`` without noise) and ``deviation_stops``
        from a linear camera
    """
    return _json.loads(_petzval.measure_greys(pixels, tuple(region)))


def shading(pixels: ArrayLike) -> dict[str, Any]:
    """Measure the falloff of light and colours from a picture of a white chart.

    :returns: light relative to the middle in the ``corners``, ``uniformity`` (the least over the most),
        ``colour_shading`` (the largest change of red or blue over green), and all ``zones``
    """
    return _json.loads(_petzval.measure_shading(pixels))


def noise(path: Union[str, "_os.PathLike[str]"]) -> list[dict[str, Any]]:
    """Evaluate pictures of uniform light by EMVA 1288.

    :param path: list of pictures in the format of EMVA data sets
    :returns: for each channel of the sensor ``gain`` (codes per electron), ``dark_noise_electrons``, ``dsnu_electrons``
        and ``prnu_percent`` (``total``, ``pixel``, ``row`` and ``column`` of each), ``saturation_electrons``,
        ``quantum_efficiency`` and more; ``None`` for what the pictures do not tell
    """
    return _json.loads(_petzval.measure_noise(path))
