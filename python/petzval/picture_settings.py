"""Settings of pictures as types, for editors and type checkers."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from typing import TYPE_CHECKING, Literal, Optional, TypedDict, Union

if TYPE_CHECKING:
    from . import Lens

    _Path = Union[str, PathLike[str]]
    _Focus = Union[float, tuple[int, int], Literal["auto"], None]
    _LookAt = Optional[Sequence[Sequence[float]]]
    _Pose = tuple[Sequence[float], ...]
    _Coating = Optional[Literal["none", "mgf2", "broadband", "perfect"]]
    _Floats = Union[list[float], list[int]]
    _FocusModel = Optional[Literal["sharpest", "pbrt"]]


class _CommonSettings(TypedDict, total=False):
    """Settings that every function takes."""

    lens: Union[Lens, _Path, None]
    """A :class:`Lens`, or the path of a lens file."""
    focus: _Focus
    """Metres from the film, ``"auto"`` for the middle of the picture, or a pixel ``(x, y)``."""
    fstop: Optional[float]
    """f-number."""
    look_at: _LookAt
    """``(eye, target)`` or ``(eye, target, up)``, each three numbers, world space."""
    film_shift: Optional[tuple[float, float]]
    """Shift to the right and up in the picture (mm)."""
    film_tilt: Optional[tuple[float, float]]
    """Tilt about the horizontal and the vertical axis (degrees)."""
    film_diagonal: Optional[float]
    """Diagonal of the film (mm)."""
    coating: _Coating
    """Coating of the surfaces without one."""
    resolution: Optional[tuple[int, int]]
    """Width and height (pixels)."""
    crop: Optional[tuple[int, int, int, int]]
    """Left, top, right, bottom (pixels; the last two are not included)."""
    effects: str
    """``"auto"``, ``"all"``, ``"none"``, or a text such as ``"+dispersion,-iris"``."""
    light_paths: Optional[bool]
    """Whether lamps and caustics are found from the lights; ``None`` where it pays."""
    aov: Union[str, Sequence[str]]
    """Names of layers, such as ``["depth", "normal", "coc"]``."""
    shutter: Optional[str]
    """Shutter: ``open``, ``close``, ``time``, ``ramp``, ``opening``, ``closing`` (times) or ``curve``, such as
    ``"time=1/60"`` (s) or ``"time=10ms,ramp=1ms"``."""
    rolling_shutter: Optional[str]
    """Time from the first row to the last, and a direction, such as ``"20ms"`` or ``"20ms,up"``."""
    sensor: Optional[str]
    """Sensor, such as ``"iso=800,pixel=4"`` (pixel pitch in um); ``""`` for its defaults."""
    bayer: Optional[str]
    """Mosaic of the sensor: ``"rggb"``, ``"bggr"``, ``"grbg"``, ``"gbrg"``, or ``"quad-rggb"`` and so on."""
    passband: Optional[tuple[float, float]]
    """Two wavelengths (nm)."""
    buckets: Union[int, str, None]
    """Number of buckets of wavelength, or a text such as ``"31@400..710"`` (nm) or ``"none"``."""
    zoom: Union[float, str, None]
    """Focal length (mm), or the name of a state of the lens file."""
    focus_model: _FocusModel
    """Whether the film stands where the picture is sharpest, or where pbrt-v4 puts it."""
    assume_vd: bool
    """Whether glass that is known by its index alone takes a similar glass's dispersion."""
    catalogue: Union[_Path, Sequence[_Path]]
    """A glass catalogue (AGF), a folder of them, or a list of these."""


class PassSettings(_CommonSettings, total=False):
    """Settings of :func:`passes`."""

    spp: Optional[int]
    """Samples per pixel; with ``noise`` or ``time``, the most."""
    seed: Optional[int]
    """Seed of the random numbers."""


class AccuracySettings(_CommonSettings, total=False):
    """Settings of :func:`accuracy`."""

    noise: Optional[float]
    """Stop when the picture is this exact, such as 0.02."""
    time: Optional[float]
    """Stop after this time (s)."""


class LensModelSettings(AccuracySettings, total=False):
    """Settings of :func:`lens_models`."""

    seed: Optional[int]
    """Seed of the random numbers."""


class RenderSettings(PassSettings, AccuracySettings, total=False):
    """Settings of :func:`prepare`, :func:`render` and :func:`plan`."""


class SweepSettings(TypedDict, total=False):
    """Settings of :func:`sweep`: those of :func:`render`, and lists of them but for ``aov``."""

    lens: Union[Lens, _Path, None, Sequence[Union[Lens, _Path]]]
    """:class:`Lens`, or the path of a lens file."""
    focus: Union[_Focus, Sequence[_Focus]]
    """Metres from the film, ``"auto"`` for the middle of the picture, or a pixel ``(x, y)``."""
    fstop: Union[float, None, _Floats]
    """f-number."""
    look_at: Union[_Pose, None, list[_Pose]]
    """Poses ``(eye, target)`` or ``(eye, target, up)``, tuples of three numbers each, world space."""
    film_shift: Union[tuple[float, float], None, list[tuple[float, float]]]
    """Shift to the right and up in the picture (mm)."""
    film_tilt: Union[tuple[float, float], None, list[tuple[float, float]]]
    """Tilt about the horizontal and the vertical axis (degrees)."""
    film_diagonal: Union[float, None, _Floats]
    """Diagonal of the film (mm)."""
    coating: Union[_Coating, Sequence[_Coating]]
    """Coating of the surfaces without one."""
    resolution: Union[tuple[int, int], None, list[tuple[int, int]]]
    """Width and height (pixels)."""
    crop: Union[tuple[int, int, int, int], None, list[tuple[int, int, int, int]]]
    """Left, top, right, bottom (pixels; the last two are not included)."""
    effects: Union[str, list[str]]
    """``"auto"``, ``"all"``, ``"none"``, or a text such as ``"+dispersion,-iris"``."""
    light_paths: Union[bool, None, Sequence[Optional[bool]]]
    """Whether lamps and caustics are found from the lights; ``None`` where it pays."""
    aov: Union[str, Sequence[str]]
    """Names of layers, such as ``["depth", "normal", "coc"]``."""
    shutter: Union[str, None, list[str]]
    """Shutter: ``open``, ``close``, ``time``, ``ramp``, ``opening``, ``closing`` (times) or ``curve``, such as
    ``"time=1/60"`` (s) or ``"time=10ms,ramp=1ms"``."""
    rolling_shutter: Union[str, None, list[str]]
    """Time from the first row to the last, and a direction, such as ``"20ms"`` or ``"20ms,up"``."""
    sensor: Union[str, None, Sequence[Optional[str]]]
    """Sensor, such as ``"iso=800,pixel=4"`` (pixel pitch in um); ``""`` for its defaults."""
    bayer: Union[str, None, Sequence[Optional[str]]]
    """Mosaic of the sensor: ``"rggb"``, ``"bggr"``, ``"grbg"``, ``"gbrg"``, or ``"quad-rggb"`` and so on."""
    passband: Union[tuple[float, float], None, list[tuple[float, float]]]
    """Two wavelengths (nm)."""
    buckets: Union[int, str, None, Sequence[Union[int, str]]]
    """Number of buckets of wavelength, or a text such as ``"31@400..710"`` (nm) or ``"none"``."""
    zoom: Union[float, str, None, Sequence[Union[float, str]]]
    """Focal length (mm), or the name of a state of the lens file."""
    focus_model: Union[_FocusModel, Sequence[_FocusModel]]
    """Whether the film stands where the picture is sharpest, or where pbrt-v4 puts it."""
    assume_vd: Union[bool, list[bool]]
    """Whether glass that is known by its index alone takes a similar glass's dispersion."""
    catalogue: Union[_Path, Sequence[_Path]]
    """A glass catalogue (AGF), or a folder of them; a list is swept."""
    spp: Union[int, None, list[int]]
    """Samples per pixel; with ``noise`` or ``time``, the most."""
    seed: Union[int, None, list[int]]
    """Seed of the random numbers."""
    noise: Union[float, None, _Floats]
    """Stop when the picture is this exact, such as 0.02."""
    time: Union[float, None, _Floats]
    """Stop after this time (s)."""


#: Values of the settings that are not given; those that are missing here are ``None``.
DEFAULTS = {
    **dict.fromkeys(RenderSettings.__annotations__),
    "effects": "auto",
    "aov": (),
    "assume_vd": False,
    "catalogue": (),
}
