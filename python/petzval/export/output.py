"""Outputs that appear as a whole, or not at all, and never replace what they are made of."""

import os
import shutil
import uuid
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from .pairs import PathLike


def _unfinished(path: Path) -> Path:
    """Return a name beside the output, which no other process uses."""
    return path.with_name(f".{path.name}.{uuid.uuid4().hex[:8]}.tmp")


def check(path: Path, inputs: Iterable[Path]) -> None:
    """Refuse an output that is a file of the data set."""
    if path.exists():
        for source in inputs:
            if source.exists() and os.path.samefile(path, source):
                raise ValueError(f"{path}: this is a file of the data set; choose another name for the output")


@contextmanager
def file(path: PathLike, inputs: Iterable[Path]) -> Iterator[Path]:
    """Give the name of a file to write, which then replaces the output. Its folder is created."""
    final = Path(path)
    check(final, inputs)
    if final.is_dir():
        raise IsADirectoryError(f"{final}: this is a folder; expected the name of a file")
    final.parent.mkdir(parents=True, exist_ok=True)
    unfinished = _unfinished(final)
    try:
        yield unfinished
        os.replace(unfinished, final)
    finally:
        unfinished.unlink(missing_ok=True)


@contextmanager
def folder(path: PathLike) -> Iterator[Path]:
    """Give a new folder to fill, which then takes the name of the output."""
    final = Path(os.path.abspath(path))
    if final.exists() and not (final.is_dir() and not any(final.iterdir())):
        raise FileExistsError(f"{path}: this exists and is no empty folder; remove it, or choose another name")
    final.parent.mkdir(parents=True, exist_ok=True)
    unfinished = _unfinished(final)
    unfinished.mkdir()
    try:
        yield unfinished
        if final.exists():
            final.rmdir()
        unfinished.rename(final)
    finally:
        shutil.rmtree(unfinished, ignore_errors=True)
