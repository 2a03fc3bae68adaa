"""Arrays of a pair: its pictures, their layers and its point spreads, by name."""

import json
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._petzval import read_image
from .layers import read_layers
from .pairs import DataSet, Row


@dataclass
class PairArrays:
    """The arrays of a pair.

    :param stacked: arrays that have one shape in all pairs: ``clean``, ``clean.depth`` ...
    :param single: arrays whose shape depends on the lens and its focus: ``psf``, ``clean.vignetting`` ...
    :param channels: names of the channels of layers
    :param text: the row of the manifest, JSON
    """

    pair: int
    stacked: dict[str, NDArray[Any]]
    single: dict[str, NDArray[Any]]
    channels: dict[str, list[str]]
    text: str


def read(dataset: DataSet, row: Row) -> PairArrays:
    """Read all files of a pair."""
    found = PairArrays(row["pair"], {}, {}, {}, json.dumps(row))
    for kind in row["files"]:
        path = dataset.file(row, kind)
        if path.suffix == ".npy":
            found.single[kind] = np.load(path)
            continue
        if path.suffix == ".dng":
            # The mosaic is in raw.exr too.
            continue
        found.stacked[kind] = read_image(path)
        if path.suffix != ".exr":
            continue
        layers = read_layers(path)
        for name, values in layers.arrays.items():
            (found.single if name == "vignetting" else found.stacked)[f"{kind}.{name}"] = values
            found.channels[f"{kind}.{name}"] = layers.channels[name]
    return found


def check_alike(first: PairArrays, other: PairArrays) -> None:
    """Refuse pairs that cannot be stacked."""
    shapes = [{name: values.shape for name, values in pair.stacked.items()} for pair in (first, other)]
    for name in sorted({*shapes[0], *shapes[1]}):
        found, expected = shapes[1].get(name), shapes[0].get(name)
        if found != expected:
            raise ValueError(
                f"pair {other.pair}: {name} is {_shown(found)}, but {_shown(expected)} in pair {first.pair}; expected "
                "pairs of one specification"
            )


def _shown(shape: Any) -> str:
    return "missing" if shape is None else " x ".join(map(str, shape))


