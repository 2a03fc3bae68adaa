"""Test charts as scenes, those of ``petzval chart``."""

import json
import os
from typing import Any, Optional, Union

from . import _petzval, keywords

Film = Union[str, tuple[float, float]]


@keywords.named
def chart(
    kind: str,
    lens: Union[str, "os.PathLike[str]", _petzval.Lens],
    path: Union[str, "os.PathLike[str]"],
    *,
    focus: float,
    resolution: tuple[int, int] = (1200, 800),
    film_size: Film = (36.0, 24.0),
    fstop: Optional[float] = None,
) -> dict[str, Any]:
    """Write the scene of a test chart that fills the picture of a lens, in the plane in focus.

    :param kind: ``"edges"``, ``"grid"``, ``"flat"``, ``"leaves"``, ``"colours"``, ``"star"`` or ``"greys"``
    :param lens: a lens file, or a :class:`Lens` of one
    :param path: the scene, ``.pbrt``; leaves and star have a picture beside it
    :param focus: distance in focus, from the film (m)
    :param resolution: width and height of the picture (pixels)
    :param film_size: width and height of the film (mm), of which the picture takes the largest part of its aspect, or a
        name such as ``"35mm"`` or ``"nikon-d850"``
    :param fstop: the f-number to stop down to
    :returns: ``scene``, ``texture`` (paths), ``region`` of patches, star or leaves, ``edges`` (regions) and
        ``spacing_mm`` of dots: what :mod:`petzval.measure` needs to know. Regions are ``[x0, y0, x1, y1]``
    :raises ValueError: the chart cannot fill the picture, or an argument is wrong
    """
    prescription = lens if isinstance(lens, _petzval.Lens) else _petzval.Lens(lens)
    width, height = resolution
    film = film_size if isinstance(film_size, str) else tuple(float(side) for side in film_size)
    text = _petzval.chart(
        kind, prescription, os.fspath(path), (int(width), int(height)), film, float(focus), fstop
    )
    return {"scene": os.fspath(path), **json.loads(text)}
