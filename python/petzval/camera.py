"""Camera: lens, pose, film, focus, stop, shutter and sensor, as one value."""

from dataclasses import dataclass, fields
from typing import Any, Optional

from . import keywords


@dataclass(frozen=True)
class Camera:
    """A camera, to be given to :func:`petzval.render` and the like. ``None`` keeps what the scene says.

    :param lens: a :class:`Lens`, or the path of a lens file
    :param pose: ``(eye, target)`` or ``(eye, target, up)``, each three numbers, world space
    :param film: diagonal of the film (mm)
    :param focus: metres from the film, ``"auto"`` for the middle of the picture, or a pixel ``(x, y)``
    :param fstop: f-number
    :param shutter: shutter, such as ``"time=1/60"`` (s) or ``"time=10ms,ramp=1ms"``
    :param sensor: sensor, such as ``"iso=800,pixel=4"`` (pixel pitch in um); ``""`` for its defaults
    :param resolution: width and height (pixels)
    :param film_shift: shift to the right and up in the picture (mm)
    :param film_tilt: tilt about the horizontal and the vertical axis (degrees)
    :param zoom: focal length (mm), or the name of a state of the lens file
    :param rolling_shutter: time from the first row to the last, and a direction, such as ``"20ms,up"``
    :param bayer: mosaic of the sensor: ``"rggb"``, ``"bggr"``, ``"grbg"``, ``"gbrg"``, or ``"quad-rggb"`` and so on
    """

    lens: Any = None
    pose: Any = None
    film: Optional[float] = None
    focus: Any = None
    fstop: Optional[float] = None
    shutter: Optional[str] = None
    sensor: Optional[str] = None
    resolution: Optional[tuple] = None
    film_shift: Optional[tuple] = None
    film_tilt: Optional[tuple] = None
    zoom: Any = None
    rolling_shutter: Optional[str] = None
    bayer: Optional[str] = None

    def settings(self):
        """Return the settings of :func:`petzval.prepare` that are not ``None``."""
        names = {"pose": "look_at", "film": "film_diagonal"}
        given = ((names.get(f.name, f.name), getattr(self, f.name)) for f in fields(self))
        return {name: value for name, value in given if value is not None}


Camera.__init__ = keywords.named(Camera.__init__)
