"""BOP data sets: pictures, depth, masks and poses by scene (bop.felk.cvut.cz, "BOP-scenewise")."""

import json
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal, Optional, Union

import numpy as np
from numpy.typing import NDArray

from .. import progress as _progress
from .._petzval import read_image, write_image
from ..settings import count
from . import output
from .camera import Pinhole, object_pose, pinhole
from .layers import Layers, layer, read_layers
from .objects import Categories, Naming, Object, find
from .pairs import DataSet, PathLike, Row, checked_picture
from .png import write_grey

#: The least step of depth (mm).
_STEP = 0.1


def bop(
    folder: PathLike,
    out: PathLike,
    *,
    picture: str = "clean",
    categories: Optional[Categories] = None,
    min_pixels: int = 1,
    exposure: Union[float, Literal["auto"]] = 0.0,
    progress: Union[bool, Callable[[float], Any], None] = None,
) -> dict[str, int]:
    """Write pictures for the estimation of poses: a folder of a split, with a folder for each scene file.

    A scene has ``rgb``, ``depth`` (uint16; times ``depth_scale`` in mm, 0 for none), ``mask_visib``,
    ``scene_camera.json`` and ``scene_gt_info.json``; its pictures have the numbers of the pairs. ``objects.json`` names
    the objects. The data set needs the layers ``depth`` and ``object``.

    The camera has x to the right, y down and z forward. A world of pbrt, which is left-handed, has its y negated:
    ``(x, y, z)`` in metres is ``(1000 x, -1000 y, 1000 z)``; that of glTF keeps its axes. ``cam_K`` is that of a
    pinhole: the degraded picture has the distortion of its lens beside it in ``scene_camera.json``, as
    ``cam_distortion``. Depth at an edge is the mean of what the pixel sees. Silhouettes without occlusion are unknown:
    there is no ``mask``, ``bbox_obj`` or ``visib_fract``.

    ``scene_gt.json`` has the poses that rows list in ``objects``: ``name``, ``shapes``, ``instance`` (-1 for none) and
    ``world_from_object`` (3 rows of 4). Instances have poses of their own; a shape outside of objects is a model in the
    space of the world. ``objects.json`` has ``model_from_object``, the matrix that makes a vertex of the model (mm).
    Objects that are sheared, or of several sizes under one name, are no models of BOP: the file is left out, with a
    warning.

    :param folder: the data set
    :param out: the folder of the split, such as ``set/train_pbr``; new or empty
    :param picture: ``"clean"`` or ``"degraded"``, whose pixels, depth and objects count
    :param categories: as in :func:`coco`; the numbers of objects follow it
    :param min_pixels: objects of fewer pixels are left out
    :param exposure: that of ``rgb``: stops, or ``"auto"`` for each
    :param progress: as in :func:`petzval.render`, with the share of the pairs
    :returns: the number of each object by its name
    :raises FileExistsError: ``out`` exists and is not empty
    :raises FileNotFoundError: there is no manifest, or a file of a pair is missing
    :raises ValueError: a layer is missing, a picture has no camera matrix, or only some objects have poses
    """
    report = _progress.reporter(progress)
    least = count("min_pixels", min_pixels, 1) or 1
    dataset = DataSet(folder)
    checked_picture(picture)
    naming = Naming(dataset, categories)
    scenes = {scene: f"{number:06d}" for number, scene in enumerate(naming.scenes)}
    frames: list[tuple[Row, Pinhole, list[Object]]] = []
    cameras: dict[str, dict[str, Any]] = {name: {} for name in scenes.values()}
    with output.folder(out) as unfinished:
        for name in scenes.values():
            for kind in ("rgb", "depth", "mask_visib"):
                (unfinished / name / kind).mkdir(parents=True)
        for done, row in enumerate(dataset.rows, 1):
            scene, source = unfinished / scenes[row["scene"]], dataset.file(row, picture)
            layers, file = read_layers(source), f"{row['pair']:06d}"
            write_image(scene / "rgb" / f"{file}.png", read_image(source), exposure=exposure)
            camera = pinhole(row, picture, layers.origin)
            depth, step = _steps(layers, camera, row, picture)
            write_grey(scene / "depth" / f"{file}.png", depth)
            cameras[scene.name][str(row["pair"])] = _camera(camera, step)
            objects = [each for each in find(row, layers, picture, naming) if each.pixels() >= least]
            for number, each in enumerate(objects):
                write_grey(scene / "mask_visib" / f"{file}_{number:06d}.png", each.mask.astype(np.uint8) * 255)
            frames.append((row, camera, objects))
            if report is not None:
                report(done / len(dataset.rows))
        numbers = naming.numbers(each.category for _, _, objects in frames for each in objects)
        have_poses = _have_poses(frames)
        if not have_poses:
            warnings.warn(f"{out}: scene_gt.json is left out, as the manifest has no poses of objects", stacklevel=2)
        known: dict[int, dict[str, Any]] = {number: {"name": name} for name, number in numbers.items()}
        truth: dict[str, dict[str, Any]] = {}
        if have_poses:
            try:
                for row, camera, objects in frames:
                    of_scene = truth.setdefault(row["scene"], {})
                    of_scene[str(row["pair"])] = _poses((row, camera, objects), numbers, known)
            except ValueError as error:
                warnings.warn(f"{out}: scene_gt.json is left out: {error}", stacklevel=2)
                truth = {}
                known = {number: {"name": name} for name, number in numbers.items()}
        for scene_file, name in scenes.items():
            own = [frame for frame in frames if frame[0]["scene"] == scene_file]
            _write(unfinished / name / "scene_camera.json", cameras[name])
            _write(unfinished / name / "scene_gt_info.json", {str(f[0]["pair"]): _info(f[2], numbers) for f in own})
            if truth:
                _write(unfinished / name / "scene_gt.json", truth.get(scene_file, {}))
        _write(unfinished / "objects.json", known)
    return numbers


def _steps(layers: Layers, camera: Pinhole, row: Row, picture: str) -> tuple[NDArray[np.uint16], float]:
    """Return the depth from the projection centre in steps, and a step (mm) with which the farthest point fits."""
    layer(layers, "depth", row["pair"], picture)
    depth, coverage = (layers.channel("depth", name).astype(np.float64) for name in ("Z", "coverage"))
    found = 1000.0 * np.where(coverage > 0, depth - camera.centre, 0.0)
    step = max(_STEP, float(found.max()) / 65535.0)
    return np.rint(np.clip(found / step, 0, 65535)).astype(np.uint16), step


def _camera(camera: Pinhole, step: float) -> dict[str, Any]:
    found = {
        "cam_K": camera.matrix.ravel().tolist(),
        "cam_R_w2c": camera.rotation.ravel().tolist(),
        "cam_t_w2c": camera.translation.tolist(),
        "depth_scale": step,
    }
    return {**found, "cam_distortion": camera.distortion} if camera.distortion else found


def _info(objects: list[Object], numbers: dict[str, int]) -> list[dict[str, Any]]:
    return [
        {"bbox_visib": each.box(), "px_count_visib": each.pixels(), "obj_id": numbers[each.category]}
        for each in objects
    ]


def _have_poses(frames: list[tuple[Row, Pinhole, list[Object]]]) -> bool:
    """Return whether all objects have poses, and refuse poses of some."""
    without = [(row, each) for row, _, objects in frames for each in objects if each.pose is None]
    if without and len(without) < sum(len(objects) for _, _, objects in frames):
        row, each = without[0]
        raise ValueError(
            f"pair {row['pair']}: objects: {each.category!r} (shapes {list(each.shapes)}, instance {each.instance}) "
            "has no entry, unlike other objects; expected one, or leave it out by categories"
        )
    return not without


def _poses(
    frame: tuple[Row, Pinhole, list[Object]], numbers: dict[str, int], known: dict[int, dict[str, Any]]
) -> list[dict[str, Any]]:
    row, camera, objects = frame
    found = []
    for each in objects:
        assert each.pose is not None
        try:
            rotation, translation, model = object_pose(camera, each.pose)
        except ValueError as error:
            raise ValueError(f"pair {row['pair']}: objects: {each.category!r}: {error}") from None
        number = numbers[each.category]
        first = known[number].setdefault("model_from_object", model.tolist())
        if not np.allclose(first, model, rtol=1e-4):
            raise ValueError(
                f"pair {row['pair']}: objects: {each.category!r} has several sizes; expected a name for each, as a BOP "
                "model has one"
            )
        found.append(
            {"cam_R_m2c": rotation.ravel().tolist(), "cam_t_m2c": translation.tolist(), "obj_id": number}
        )
    return found


def _write(path: Path, value: Any) -> None:
    path.write_text(json.dumps(value, indent=2), encoding="utf-8")
