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

__all__ = ["colours", "edge", "grid", "noise", "texture"]


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


def noise(path: Union[str, "_os.PathLike[str]"]) -> list[dict[str, Any]]:
    """Evaluate pictures of uniform light by EMVA 1288.

    :param path: list of pictures in the format of EMVA data sets
    :returns: for each channel of the sensor ``gain`` (codes per electron), ``dark_noise_electrons``, ``dsnu_electrons``
        and ``prnu_percent`` (``total``, ``pixel``, ``row`` and ``column`` of each), ``saturation_electrons``,
        ``quantum_efficiency`` and more; ``None`` for what the pictures do not tell
    """
    return _json.loads(_petzval.measure_noise(path))
