"""Scenes of NumPy arrays."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Optional

import numpy as np

from ._petzval import scene_of_arrays
from .keywords import named
from .settings import count


@dataclass
class Mesh:
    """Triangles with a material.

    :param vertices: V x 3, world space
    :param faces: F x 3, indices of vertices
    :param normals: V x 3, optional: shading normals
    :param uv: V x 2, optional: texture coordinates
    :param material: ``type`` and the parameters of a material of the scene language, such as
        ``{"type": "diffuse", "reflectance": (0.5, 0.2, 0.1)}``; an array of height x width x 3 is a
        texture of linear light, row 0 at v = 1
    :param emission: radiance (r, g, b), optional: the mesh is a light
    """

    vertices: Any
    faces: Any
    normals: Optional[Any] = None
    uv: Optional[Any] = None
    material: dict = field(default_factory=lambda: {"type": "diffuse"})
    emission: Optional[tuple] = None


Mesh.__init__ = named(Mesh.__init__)


def assembled(meshes, lights, lens, resolution, diagonal, look_at, focus, spp, max_depth):
    """Return the scene of arrays, as :class:`Scene` takes it. ``look_at`` is a list of nine numbers."""
    if np.shape(resolution) != (2,):
        raise ValueError(f"resolution={resolution!r}: expected width and height")
    view = (
        [_count("resolution", side, 1) for side in resolution],
        [[_number("look_at", value) for value in look_at[i : i + 3]] for i in (0, 3, 6)],
        _number("diagonal", diagonal),
        _number("focus", focus),
        _count("spp", spp, 1),
        _count("max_depth", max_depth, 0),
    )
    lights, meshes = _listed("lights", lights), _listed("meshes", meshes)
    for number, mesh in enumerate(meshes):
        if not isinstance(mesh, Mesh):
            raise TypeError(f"mesh {number}: expected a petzval.Mesh, not {type(mesh).__name__}")
    return scene_of_arrays(meshes, lights, lens, view)


def _listed(name, values):
    """Return an argument that is a list."""
    if not isinstance(values, Iterable) or isinstance(values, (str, Mapping)):
        raise TypeError(f"{name}: expected a list, not {type(values).__name__}")
    return list(values)


def _count(name, value, least):
    number = count(name, value, least)
    if number is None:
        raise TypeError(f"{name}=None: expected an integer")
    return number


def _number(name, value):
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise TypeError(f"{name}={value!r}: expected a number") from None
    if not np.isfinite(number):
        raise ValueError(f"{name}={value}: expected a finite number")
    return number
