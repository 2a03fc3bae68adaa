"""Objects of a picture: the pixels that show them, and their categories."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import PurePath
from typing import Any, Optional

import numpy as np
from numpy.typing import NDArray

from .layers import Layers, layer, natural_order
from .pairs import DataSet, Row

#: Names of shapes by their number; by scene first, if there are several.
Categories = Mapping[Any, Any]


@dataclass
class Object:
    """An object of a picture.

    :param category: its name
    :param shapes: the numbers of its visible shapes
    :param instance: the number of its instance; -1 for none
    :param mask: the pixels that show it: height x width
    :param pose: ``world_from_object`` of the manifest, 3 x 4; ``None`` if the manifest has none
    """

    category: str
    shapes: tuple[int, ...]
    instance: int
    mask: NDArray[np.bool_]
    pose: Optional[NDArray[np.float64]] = None

    def box(self) -> list[int]:
        """Return left, top, width and height of the pixels."""
        rows, columns = (np.flatnonzero(self.mask.any(axis)) for axis in (1, 0))
        left, top = int(columns[0]), int(rows[0])
        return [left, top, int(columns[-1]) - left + 1, int(rows[-1]) - top + 1]

    def pixels(self) -> int:
        """Return the number of pixels."""
        return int(self.mask.sum())


class Naming:
    """Names of the shapes of a data set, as the user gives them or as the manifest does.

    :raises ValueError: the data set has several scenes, and the names are not by scene
    :raises TypeError: the names are no dictionary from numbers to texts
    """

    def __init__(self, dataset: DataSet, categories: Optional[Categories]) -> None:
        self.scenes = sorted({row["scene"] for row in dataset.rows})
        self.names: Optional[dict[str, dict[int, str]]] = None
        if categories is None:
            return
        if not isinstance(categories, Mapping):
            raise TypeError(f"categories={categories!r}: expected a dictionary from numbers of shapes to names")
        by_scene = any(isinstance(names, Mapping) for names in categories.values())
        if not by_scene and len(self.scenes) > 1:
            raise ValueError(
                f"categories: the data set has {len(self.scenes)} scenes, whose shapes have the same numbers; expected "
                f"a dictionary for each, such as {{{_short(self.scenes[0])!r}: {{0: 'name'}}}}"
            )
        if by_scene:
            known = {*self.scenes, *map(_short, self.scenes)}
            for scene in categories:
                if scene not in known:
                    expected = ", ".join(map(repr, map(_short, self.scenes)))
                    raise ValueError(f"categories: no pair has the scene {scene!r}; expected {expected}")
        self.names = {
            scene: _checked(categories.get(scene, categories.get(_short(scene), {})) if by_scene else categories)
            for scene in self.scenes
        }

    def numbers(self, found: Iterable[str]) -> dict[str, int]:
        """Return the numbers of categories, from 1: those of the user in the user's order, or all that are found."""
        order = sorted(set(found), key=natural_order)
        if self.names is not None:
            order = [name for names in self.names.values() for name in names.values()]
        return {name: number for number, name in enumerate(dict.fromkeys(order), 1)}

    def name(self, scene: str, shape: int, listed: Optional[str]) -> Optional[str]:
        """Return the category of a shape; ``None`` if it is left out.

        :param listed: its name in the manifest
        """
        if self.names is not None:
            return self.names[scene].get(shape)
        own = f"shape {shape}" if listed is None else listed
        # Names in the manifest are the same in all scenes; numbers are not.
        return own if listed is not None or len(self.scenes) == 1 else f"{_short(scene)} {own}"


def find(row: Row, layers: Layers, picture: str, naming: Naming) -> Iterator[Object]:
    """Iterate over the objects of a picture, by instance and shape.

    Visible shapes of one instance with the same name are one object, and so are those of one entry of the row's
    ``objects``. Shapes without an instance are objects of their own otherwise.
    """
    layer(layers, "object", row["pair"], picture)
    shape, instance = (layers.channel("object", name).astype(np.int64) for name in ("shape", "instance"))
    listed = _listed(row)
    groups: dict[Any, list[tuple[int, int]]] = {}
    ids = np.stack([instance, shape], -1)[shape >= 0]
    for one, number in np.unique(ids, axis=0).tolist():
        entry = listed.get((number, one))
        category = naming.name(row["scene"], number, None if entry is None else entry["name"])
        if category is not None:
            part = id(entry) if entry is not None else None if one >= 0 else number
            groups.setdefault((category, one, part), []).append((number, one))
    for (category, one, _), parts in groups.items():
        shapes = tuple(number for number, _ in parts)
        entry = listed.get(parts[0])
        pose = None if entry is None else np.array(entry["world_from_object"], np.float64)
        yield Object(category, shapes, one, (instance == one) & np.isin(shape, shapes), pose)


def _listed(row: Row) -> dict[tuple[int, int], Any]:
    """Return the entries of the row's ``objects`` by shape and instance."""
    expected = "expected name (a text or null), shapes, instance and world_from_object (3 rows of 4) of each"
    found = {}
    for entry in row.get("objects") or []:
        if not isinstance(entry, dict) or not {"name", "shapes", "instance", "world_from_object"} <= set(entry):
            raise ValueError(f"pair {row['pair']}: objects: found {entry!r}; {expected}")
        if not isinstance(entry["name"], (str, type(None))) or np.shape(entry["world_from_object"]) != (3, 4):
            raise ValueError(f"pair {row['pair']}: objects: found {entry!r}; {expected}")
        found.update({(shape, entry["instance"]): entry for shape in entry["shapes"]})
    return found


def _checked(names: Any) -> dict[int, str]:
    if not isinstance(names, Mapping) or not all(
        type(shape) is int and isinstance(name, str) for shape, name in names.items()
    ):
        raise TypeError(f"categories: {names!r}: expected a dictionary from numbers of shapes to names")
    return dict(names)


def _short(scene: str) -> str:
    return PurePath(scene).name
