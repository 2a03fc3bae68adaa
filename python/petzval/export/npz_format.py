"""Archives of NumPy arrays: some pairs in each."""

import json
from collections.abc import Callable
from typing import Any, Union

import numpy as np

from .. import progress as _progress
from ..settings import count
from . import output
from .arrays import PairArrays, check_alike, read
from .pairs import DataSet, PathLike


def npz(
    folder: PathLike,
    out: PathLike,
    *,
    pairs_per_file: int = 64,
    progress: Union[bool, Callable[[float], Any], None] = None,
) -> list[str]:
    """Write a folder of compressed archives, ``00000.npz`` and so on.

    An archive has ``clean``, ``degraded`` and ``raw`` (N x height x width x channels, float32, linear sRGB; a mosaic
    N x height x width) and their layers, such as ``clean.depth``. The shape of point spreads and vignetting depends on
    the lens, so each pair has its own, such as ``psf/000012``. ``pair`` has the numbers, ``rows`` the rows of the
    manifest and ``channels`` the names of the channels of layers, both in JSON.

    :param folder: the data set
    :param out: the folder of the archives; new or empty
    :param pairs_per_file: the most pairs of an archive
    :param progress: as in :func:`petzval.render`, with the share of the pairs
    :returns: the names of the archives
    :raises FileExistsError: ``out`` exists and is not empty
    :raises FileNotFoundError: there is no manifest, or a file of a pair is missing
    """
    report = _progress.reporter(progress)
    most = count("pairs_per_file", pairs_per_file, 1) or 1
    dataset = DataSet(folder)
    names = []
    with output.folder(out) as unfinished:
        for start in range(0, len(dataset.rows), most):
            pairs: list[PairArrays] = []
            for row in dataset.rows[start : start + most]:
                pairs.append(read(dataset, row))
                check_alike(pairs[0], pairs[-1])
                if report is not None:
                    report((start + len(pairs)) / len(dataset.rows))
            names.append(f"{start // most:05d}.npz")
            np.savez_compressed(unfinished / names[-1], **_contents(pairs))
    return names


def _contents(pairs: list[PairArrays]) -> dict[str, Any]:
    found: dict[str, Any] = {name: np.stack([pair.stacked[name] for pair in pairs]) for name in pairs[0].stacked}
    for pair in pairs:
        found.update({f"{name}/{pair.pair:06d}": values for name, values in pair.single.items()})
    found["pair"] = np.array([pair.pair for pair in pairs])
    found["rows"] = np.array([pair.text for pair in pairs])
    found["channels"] = np.array(json.dumps(pairs[0].channels))
    return found
