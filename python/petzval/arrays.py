"""Scenes of NumPy arrays: written as a scene file with PLY meshes, which the engine reads."""

import tempfile
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Optional

import numpy as np

from ._petzval import write_image
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


def scene_file(
    folder, meshes, lights, lens, resolution, diagonal, look_at, focus, spp, max_depth
):
    """Write a scene and all that it names into a folder. Returns the path of the scene file."""
    folder = Path(folder)
    copied = folder / Path(lens).name
    copied.write_bytes(Path(lens).read_bytes())
    [eye, target, up] = [look_at[i : i + 3] for i in (0, 3, 6)]
    if np.shape(resolution) != (2,):
        raise ValueError(f"resolution={resolution!r}: expected width and height")
    width, height = (_count("resolution", side, 1) for side in resolution)
    spp, max_depth = _count("spp", spp, 1), _count("max_depth", max_depth, 0)
    lines = [
        f'Film "rgb" "integer xresolution" {width} "integer yresolution" {height}',
        f'    "float diagonal" {_number("diagonal", diagonal)}',
        f'Sampler "zsobol" "integer pixelsamples" {spp}',
        f'Integrator "path" "integer maxdepth" {max_depth}',
        f"LookAt {_numbers('look_at', eye)}  {_numbers('look_at', target)}  {_numbers('look_at', up)}",
        f'Camera "realistic" "string lensfile" {_text(copied.name)}',
        f'    "float focusdistance" {_number("focus", focus)}',
        "WorldBegin",
    ]
    for number, light in enumerate(_listed("lights", lights)):
        lines.append(f"LightSource {_typed(light, f'light {number}', folder, lines, f'light{number}')}")
    for number, mesh in enumerate(_listed("meshes", meshes)):
        if not isinstance(mesh, Mesh):
            raise TypeError(f"mesh {number}: expected a petzval.Mesh, not {type(mesh).__name__}")
        name = f"mesh{number}"
        _write_ply(folder / f"{name}.ply", mesh, f"mesh {number}")
        lines.append("AttributeBegin")
        if mesh.emission is not None:
            if np.shape(mesh.emission) != (3,):
                raise ValueError(f"mesh {number}: emission={mesh.emission!r}: expected (r, g, b)")
            lines.append(f'AreaLightSource "diffuse" {_parameter("L", mesh.emission)}')
        material = _typed(mesh.material, f"the material of mesh {number}", folder, lines, name)
        lines += [f"Material {material}", f'Shape "plymesh" "string filename" "{name}.ply"', "AttributeEnd"]
    path = folder / "arrays.pbrt"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


# Most vertices or faces of a mesh. A broadcast view states far more than there is memory for.
MOST = 1 << 28


def _check_count(what, name, array):
    """Check the rows of an array before any of them is looked at."""
    if array.ndim and len(array) > MOST:
        raise ValueError(f"{what}: {len(array)} {name}; expected at most {MOST}")


def _write_ply(path, mesh, what):
    """Write a mesh as binary PLY."""
    columns = [("vertices", mesh.vertices, "xyz")]
    if mesh.normals is not None:
        columns.append(("normals", mesh.normals, ("nx", "ny", "nz")))
    if mesh.uv is not None:
        columns.append(("uv", mesh.uv, "uv"))
    arrays, names = [], []
    for name, values, channels in columns:
        array = np.asarray(values)
        _check_count(what, name, array)
        if array.dtype.kind not in "fiub":
            raise TypeError(f"{what}: {name} are of {array.dtype}; expected real numbers")
        array = array.astype("<f4")
        if array.ndim != 2 or array.shape[1] != len(channels):
            raise ValueError(f"{what}: {name} have the shape {array.shape}; expected N x {len(channels)}")
        if arrays and len(array) != len(arrays[0]):
            raise ValueError(f"{what}: {len(array)} {name} for {len(arrays[0])} vertices")
        if not np.isfinite(array).all():
            raise ValueError(f"{what}: {name} are not all finite")
        arrays.append(array)
        names += channels
    faces = np.asarray(mesh.faces)
    _check_count(what, "faces", faces)
    if faces.ndim != 2 or faces.shape[1] != 3 or faces.dtype.kind not in "iu":
        raise ValueError(f"{what}: faces are {faces.dtype} of the shape {faces.shape}; expected integers, F x 3")
    if faces.size and (faces.min() < 0 or faces.max() >= len(arrays[0])):
        raise ValueError(f"{what}: faces name vertices beyond the {len(arrays[0])} there are")
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(arrays[0])}"]
    header += [f"property float {name}" for name in names]
    header += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header", ""]
    rows = np.empty(len(faces), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    rows["count"], rows["corners"] = 3, faces
    with open(path, "wb") as file:
        file.write("\n".join(header).encode("ascii"))
        file.write(np.concatenate(arrays, axis=1).tobytes())
        file.write(rows.tobytes())


def _listed(name, values):
    """Return the items of an argument that is a list."""
    if not isinstance(values, Iterable) or isinstance(values, (str, Mapping)):
        raise TypeError(f"{name}: expected a list, not {type(values).__name__}")
    return values


def _typed(description, what, folder, lines, name):
    """Return type and parameters in the scene language; textures are written and declared before."""
    if not isinstance(description, Mapping):
        raise TypeError(f'{what}: expected a dictionary with "type", not {type(description).__name__}')
    description = dict(description)
    kind = description.pop("type", None)
    if not isinstance(kind, str):
        raise ValueError(f'{what} has no "type"')
    parts = [_text(kind)]
    for parameter, value in description.items():
        if isinstance(value, np.ndarray) and value.ndim == 3:
            if value.dtype.kind != "f" or value.shape[2] != 3:
                raise ValueError(
                    f"{what}: {parameter} is an array of {value.dtype} of the shape {value.shape}; "
                    "expected floats of linear light, height x width x 3"
                )
            file = f"{name}.{parameter}.exr"
            write_image(folder / file, value)
            texture = f"{name}.{parameter}"
            lines.append(f'Texture "{texture}" "spectrum" "imagemap" "string filename" "{file}"')
            parts.append(f'"texture {parameter}" "{texture}"')
        else:
            parts.append(_parameter(parameter, value))
    return " ".join(parts)


def _parameter(name, value):
    """Return a parameter in the scene language."""
    if isinstance(value, str):
        return f'"string {name}" {_text(value)}'
    if isinstance(value, bool):
        return f'"bool {name}" {str(value).lower()}'
    kinds = {(): "float", (3,): "rgb"}
    kind = kinds.get(np.shape(value))
    # Positions of lights are points, not colours.
    if kind == "rgb" and name in ("from", "to"):
        kind = "point3"
    if kind is None:
        raise ValueError(f"{name}: expected a number, three numbers, a text or a texture")
    return f'"{kind} {name}" [ {_numbers(name, np.atleast_1d(value))} ]'


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
    return repr(number)


def _numbers(name, values):
    return " ".join(_number(name, value) for value in values)


def _text(text):
    if any(character in text for character in '"\\\n'):
        raise ValueError(f"{text!r}: quotes, backslashes and line ends are not allowed")
    return f'"{text}"'


def temporary_folder():
    """Return a folder that is removed with its object."""
    return tempfile.TemporaryDirectory(prefix="petzval-scene-")
