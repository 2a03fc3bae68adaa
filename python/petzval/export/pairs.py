"""Finished pairs of a data set: the rows of all manifests of a folder, and the files that they name."""

import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple, Union

PathLike = Union[str, "os.PathLike[str]"]
Row = dict[str, Any]

#: Pictures of a pair that have layers of surfaces.
PICTURES = ("clean", "degraded")


class Entry(NamedTuple):
    """A row of a manifest, and where it stands."""

    row: Row
    place: str


class DataSet:
    """The finished pairs of a folder, in the order of their numbers.

    :raises FileNotFoundError: there is no manifest, or a file of a pair is missing
    :raises ValueError: a row is wrong, rows are of several specifications, or a file has another size than its row says
    """

    def __init__(self, folder: PathLike) -> None:
        self.folder = Path(folder)
        self.manifests = sorted(self.folder.glob("manifest.jsonl")) + sorted(self.folder.glob("manifest.*-of-*.jsonl"))
        if not self.manifests:
            raise FileNotFoundError(
                f"{self.folder}: there is no manifest.jsonl or manifest.*-of-*.jsonl; expected a folder that petzval "
                "dataset has written"
            )
        entries: dict[int, list[Entry]] = {}
        for manifest in self.manifests:
            for entry in _entries(manifest):
                entries.setdefault(entry.row["pair"], []).append(entry)
        if not entries:
            raise ValueError(f"{self.folder}: no pair is finished; run petzval dataset")
        self.rows = [self._whole(entries[pair]) for pair in sorted(entries)]
        specs = {row.get("spec") for row in self.rows}
        if len(specs) > 1:
            raise ValueError(
                f"{self.folder}: the manifests are of {len(specs)} specifications; expected those of one data set"
            )

    def _whole(self, entries: list[Entry]) -> Row:
        """Return the last row whose files are there: a pair has several if a file was lost and rendered again."""
        problems = [self._problem(entry) for entry in entries]
        for entry, problem in zip(reversed(entries), reversed(problems)):
            if problem is None:
                return entry.row
        raise next(problem for problem in reversed(problems) if problem is not None)

    def _problem(self, entry: Entry) -> Union[Exception, None]:
        for file in entry.row["files"].values():
            path = self.folder / file["file"]
            try:
                size = path.stat().st_size
            except FileNotFoundError:
                again = "run petzval dataset again, which renders this pair alone"
                return FileNotFoundError(f"{path}: the file is missing, which {entry.place} names; {again}")
            if size != file["bytes"]:
                again = "run petzval dataset again"
                return ValueError(f"{path}: found {size} bytes, expected {file['bytes']} ({entry.place}); {again}")
        return None

    def file(self, row: Row, kind: str) -> Path:
        """Return the path of a file of a pair: ``clean``, ``degraded``, ``raw`` or ``psf``."""
        name: str = row["files"][kind]["file"]
        return self.folder / name

    def inputs(self) -> Iterator[Path]:
        """Iterate over all files that are read."""
        yield from self.manifests
        for row in self.rows:
            yield from (self.file(row, kind) for kind in row["files"])


def checked_picture(picture: str) -> str:
    """Return the name of a picture that has layers of surfaces."""
    if picture not in PICTURES:
        raise ValueError(f"picture={picture!r}: expected 'clean' or 'degraded'")
    return picture


def _entries(manifest: Path) -> Iterator[Entry]:
    """Iterate over the rows of a manifest. A row that is being written has no end yet, and does not count."""
    with open(manifest, encoding="utf-8", newline="\n") as lines:
        for number, line in enumerate(lines, 1):
            if not line.endswith("\n"):
                return
            place = f"{manifest}:{number}"
            try:
                row = json.loads(line)
            except ValueError as error:
                raise ValueError(f"{place}: this is no row of a data set: {error}") from None
            if not isinstance(row, dict) or type(row.get("pair")) is not int or not _has_files(row):
                raise ValueError(f"{place}: expected an object with a number \"pair\" and \"files\" with their sizes")
            yield Entry(row, place)


def _has_files(row: Row) -> bool:
    files = row.get("files")
    return isinstance(files, dict) and all(
        isinstance(file, dict) and isinstance(file.get("file"), str) and isinstance(file.get("bytes"), int)
        for file in files.values()
    )
