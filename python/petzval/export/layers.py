"""Layers of the pictures of a data set."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Optional

import numpy as np
from numpy.typing import NDArray

from .._petzval import read_layers as _read_layers

#: Files hold channels in alphabetical order.
_ORDER = {name: place for place, name in enumerate(["R", "G", "B", "shape", "instance", "taken", "passed"])}


@dataclass
class Layers:
    """The layers of a picture, without its colours.

    :param origin: column and row of the first pixel in the whole frame
    :param size: width and height
    :param arrays: float32, height x width x channels, by name
    :param channels: the names of their channels
    """

    origin: tuple[int, int]
    size: tuple[int, int]
    arrays: dict[str, NDArray[np.float32]]
    channels: dict[str, list[str]]

    def channel(self, layer: str, name: str) -> NDArray[np.float32]:
        """Return a channel of a layer: height x width."""
        return self.arrays[layer][..., self.channels[layer].index(name)]


def read_layers(path: Path) -> Layers:
    """Read the layers of a picture, with their channels in the order of :func:`petzval.render`.

    :raises OSError: the file cannot be read
    :raises ValueError: the file is damaged, or no OpenEXR file
    """
    (arrays, channels), origin, size = _read_layers(path)
    found = Layers(origin, size, {}, {})
    for name in sorted(arrays):
        order = sorted(channels[name], key=_place)
        found.channels[name] = order
        found.arrays[name] = np.ascontiguousarray(arrays[name][..., [channels[name].index(c) for c in order]])
    return found


def layer(layers: Layers, name: str, pair: int, picture: str) -> NDArray[np.float32]:
    """Return a layer that an export needs."""
    found: Optional[NDArray[np.float32]] = layers.arrays.get(name)
    if found is None:
        raise ValueError(
            f"pair {pair}: the {picture} picture has no layer {name!r}; add it to 'layers' of the specification, and "
            "render to another folder"
        )
    return found


def natural_order(name: str) -> list[Any]:
    """Return the key that sorts names by their numbers: 2 before 10."""
    return [int(word) if word.isdigit() else word for word in re.split(r"(\d+)", name)]


def _place(channel: str) -> Any:
    """Return the key that sorts channels as the engine does."""
    return _ORDER.get(channel, len(_ORDER)), natural_order(channel)
