"""One HDF5 file of a data set, by h5py."""

import importlib
import json
from collections.abc import Callable
from typing import Any, Union

from .. import progress as _progress
from . import output
from .arrays import PairArrays, check_alike, read
from .pairs import DataSet, PathLike


def hdf5(
    folder: PathLike,
    path: PathLike,
    *,
    progress: Union[bool, Callable[[float], Any], None] = None,
) -> None:
    """Write one HDF5 file, compressed, in chunks of a picture.

    It has ``clean``, ``degraded`` and ``raw`` (N x height x width x channels, float32, linear sRGB; a mosaic
    N x height x width) and their layers, such as ``clean.depth``, whose attribute ``channels`` names the channels. The
    shape of point spreads and vignetting depends on the lens, so they are groups with an array for each pair, such as
    ``psf/000012``. ``pair`` has the numbers, and ``rows`` the rows of the manifest in JSON.

    :param folder: the data set
    :param path: the file to write
    :param progress: as in :func:`petzval.render`, with the share of the pairs
    :raises ImportError: h5py is not installed
    :raises FileNotFoundError: there is no manifest, or a file of a pair is missing
    :raises ValueError: the output is a file of the data set
    """
    report = _progress.reporter(progress)
    try:
        h5py: Any = importlib.import_module("h5py")
    except ImportError as error:
        raise ImportError(f"HDF5 files need h5py: {error}; pip install h5py") from error
    dataset = DataSet(folder)
    with output.file(path, dataset.inputs()) as unfinished, h5py.File(unfinished, "w") as file:
        text = h5py.string_dtype()
        file.create_dataset("pair", data=[row["pair"] for row in dataset.rows])
        file.create_dataset("rows", data=[json.dumps(row) for row in dataset.rows], dtype=text)
        first = read(dataset, dataset.rows[0])
        for number, row in enumerate(dataset.rows):
            pair = read(dataset, row) if number else first
            check_alike(first, pair)
            _add(file, number, len(dataset.rows), pair)
            if report is not None:
                report((number + 1) / len(dataset.rows))


def _add(file: Any, number: int, count: int, pair: PairArrays) -> None:
    """Add the arrays of a pair to the file."""
    packed = {"compression": "gzip", "compression_opts": 4, "shuffle": True}
    for name, values in pair.stacked.items():
        if number == 0:
            file.create_dataset(
                name, (count, *values.shape), values.dtype, chunks=(1, *values.shape), **packed
            )
            if name in pair.channels:
                file[name].attrs["channels"] = pair.channels[name]
        file[name][number] = values
    for name, values in pair.single.items():
        added = file.create_dataset(f"{name}/{pair.pair:06d}", data=values, **packed)
        if name in pair.channels:
            added.attrs["channels"] = pair.channels[name]
