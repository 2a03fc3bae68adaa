"""COCO annotations: boxes and masks of the objects of a data set (cocodataset.org/#format-data)."""

import json
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from typing import Any, Literal, Optional, Union

import numpy as np
from numpy.typing import NDArray

from .. import progress as _progress
from .._petzval import read_image, write_image
from ..settings import count
from . import output
from .layers import read_layers
from .objects import Categories, Naming, Object, find
from .pairs import DataSet, PathLike, checked_picture


def coco(
    folder: PathLike,
    path: PathLike,
    *,
    picture: str = "degraded",
    categories: Optional[Categories] = None,
    min_pixels: int = 1,
    pictures: Union[Literal["png", "jpg"], bool] = "png",
    exposure: Union[float, Literal["auto"]] = 0.0,
    progress: Union[bool, Callable[[float], Any], None] = None,
) -> dict[str, Any]:
    """Write boxes and masks of objects for COCO loaders.

    An object is a shape, or all shapes of an instance with the same name, as the first sample of each pixel sees it:
    the data set needs the layer ``object``. Masks are in uncompressed RLE.

    :param folder: the data set
    :param path: the file of annotations, JSON
    :param picture: ``"degraded"`` or ``"clean"``, whose pixels and objects count
    :param categories: ``{number of a shape: name}``; shapes of one name are one category, and others are left out. For
        several scenes ``{name of the scene file: {number: name}}``. By default all shapes count, as ``"shape 3"``
    :param min_pixels: objects of fewer pixels are left out
    :param pictures: ``"png"`` or ``"jpg"`` writes pictures into a folder beside the annotations, which has their name and
        is new or empty; ``True`` means PNG, and ``False`` names the EXR of the data set
    :param exposure: that of these pictures: stops, or ``"auto"`` for each
    :param progress: as in :func:`petzval.render`, with the share of the pairs
    :returns: what is in the file
    :raises FileExistsError: the folder of the pictures exists and is not empty
    :raises FileNotFoundError: there is no manifest, or a file of a pair is missing
    :raises ValueError: the data set has no layer ``object``, or the output is one of its files
    """
    report = _progress.reporter(progress)
    least = count("min_pixels", min_pixels, 1) or 1
    ending = _ending(pictures)
    dataset, final = DataSet(folder), Path(path)
    checked_picture(picture)
    naming = Naming(dataset, categories)
    inputs = list(dataset.inputs())
    images: list[dict[str, Any]] = []
    found: list[tuple[int, Object]] = []
    shown = final.with_suffix("")
    if ending is not None and shown == final and not final.is_dir():
        raise ValueError(f"{final}: expected a name such as {final}.json, as the folder of the pictures has it without")
    pictures_folder = output.folder(shown) if ending is not None else nullcontext()
    with output.file(final, inputs) as unfinished, pictures_folder as drawn:
        for done, row in enumerate(dataset.rows, 1):
            source = dataset.file(row, picture)
            layers = read_layers(source)
            name = row["files"][picture]["file"]
            if drawn is not None:
                name = f"{shown.name}/{row['pair']:06d}.{picture}.{ending}"
                write_image(drawn / Path(name).name, read_image(source), exposure=exposure)
            width, height = layers.size
            images.append({"id": row["pair"], "file_name": name, "width": width, "height": height})
            objects = find(row, layers, picture, naming)
            found += [(row["pair"], each) for each in objects if each.pixels() >= least]
            if report is not None:
                report(done / len(dataset.rows))
        numbers = naming.numbers(each.category for _, each in found)
        written = {
            "info": {"description": f"{picture} pictures of {dataset.folder.name}, rendered by petzval"},
            "licenses": [],
            "images": images,
            "annotations": [
                _annotation(number, image, numbers[each.category], each)
                for number, (image, each) in enumerate(found, 1)
            ],
            "categories": [{"id": i, "name": name, "supercategory": "object"} for name, i in numbers.items()],
        }
        unfinished.write_text(json.dumps(written), encoding="utf-8")
    return written


def _ending(pictures: Any) -> Optional[str]:
    if pictures is False:
        return None
    if pictures is True:
        return "png"
    if pictures not in ("png", "jpg"):
        raise ValueError(f"pictures={pictures!r}: expected 'png', 'jpg' or False")
    return str(pictures)


def _annotation(number: int, image: int, category: int, found: Object) -> dict[str, Any]:
    return {
        "id": number,
        "image_id": image,
        "category_id": category,
        "bbox": found.box(),
        "area": found.pixels(),
        "segmentation": run_lengths(found.mask),
        "iscrowd": 0,
        "shapes": list(found.shapes),
        "instance": found.instance,
    }


def run_lengths(mask: NDArray[np.bool_]) -> dict[str, Any]:
    """Return a mask in COCO's uncompressed RLE: lengths of runs down the columns, of which the first is outside."""
    pixels = mask.ravel(order="F")
    ends = np.flatnonzero(pixels[1:] != pixels[:-1]) + 1
    edges = np.concatenate([[0] if pixels[0] else [], [0], ends, [pixels.size]]).astype(int)
    return {"size": list(mask.shape), "counts": np.diff(edges).tolist()}
