from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from os import PathLike
from typing import Any, Literal, Optional, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import Unpack

from . import export as export
from . import measure as measure
from .picture_settings import AccuracySettings as AccuracySettings
from .picture_settings import LensModelSettings as LensModelSettings
from .picture_settings import PassSettings as PassSettings
from .picture_settings import RenderSettings as RenderSettings
from .picture_settings import SweepSettings as SweepSettings

__version__: str

Path = Union[str, PathLike[str]]
Point = Sequence[float]

class Lens:
    """A lens: surfaces along an axis, from the scene to the film. Lengths are in mm."""

    def __init__(
        self,
        path: Union[Path, Sequence[tuple[float, float, float, float]]],
        catalogue: Union[Path, Sequence[Path]] = (),
    ) -> None: ...
    @staticmethod
    def from_table(
        rows: Sequence[tuple[float, float, float, float]], name: str = "table"
    ) -> "Lens": ...
    @property
    def name(self) -> str: ...
    @property
    def path(self) -> Optional[str]: ...
    @property
    def efl(self) -> float: ...
    @property
    def bfd(self) -> float: ...
    @property
    def fno(self) -> Optional[float]: ...
    @property
    def stop(self) -> int: ...
    @property
    def surfaces(self) -> list[dict[str, Any]]: ...
    def focus(self, distance: float = ...) -> float: ...
    def trace(
        self,
        points: ArrayLike,
        directions: ArrayLike,
        wavelength: Optional[float] = None,
        side: Literal["scene", "film"] = "scene",
        out: Optional[
            tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.uint16]]
        ] = None,
    ) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.uint16]]: ...
    def intrinsics(
        self,
        resolution: tuple[int, int],
        width: float,
        distance: float = ...,
        model: Optional[str] = None,
    ) -> dict[str, Any]: ...
    def st_map(
        self,
        resolution: tuple[int, int],
        width: float,
        distance: float = ...,
        redistort: bool = False,
    ) -> NDArray[np.float32]: ...
    def mtf(
        self,
        frequencies: Sequence[float],
        *,
        distance: float = ...,
        film_distance: Optional[float] = None,
        image_height: Optional[float] = None,
        fields: int = 5,
        rays: int = 64,
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...
    def distortion(
        self,
        count: int = 20,
        *,
        distance: float = ...,
        film_distance: Optional[float] = None,
        image_height: Optional[float] = None,
        fields: int = 5,
        rays: int = 64,
    ) -> dict[str, NDArray[np.float64]]: ...
    def psf(
        self,
        field: int = 0,
        size: int = 64,
        wavelength: Optional[float] = None,
        channel: Optional[Literal["R", "G", "B"]] = None,
        *,
        distance: float = ...,
        film_distance: Optional[float] = None,
        image_height: Optional[float] = None,
        fields: int = 5,
        rays: int = 64,
    ) -> tuple[NDArray[np.float64], dict[str, Any]]:
        """Return the image of a point of a field (0: on the axis), ``size`` x ``size`` shares of the
        light, and its data: pitch (um), centre (um) and strehl.

        :param wavelength: light of this wavelength alone (nm)
        :param channel: light of a channel of a picture of white light
        """
    def image_quality(
        self,
        distance: float = ...,
        film_distance: Optional[float] = None,
        image_height: Optional[float] = None,
        fields: int = 5,
        rays: int = 64,
    ) -> ImageQuality: ...
    def report(
        self,
        *,
        frequencies: Sequence[float] = (10.0, 20.0, 40.0),
        distance: float = ...,
        film_distance: Optional[float] = None,
        image_height: Optional[float] = None,
        fields: int = 5,
        rays: int = 64,
    ) -> dict[str, Any]: ...
    def draw(
        self, ax: Any = None, rays: int = 9, film_distance: Optional[float] = None
    ) -> Any: ...
    def svg(self, rays: int = 9, film_distance: Optional[float] = None) -> str: ...
    def _repr_svg_(self) -> str: ...

class Sensor:
    """A sensor at one speed, which reads arrays of light out as ``petzval render --sensor`` does.

    :param settings: those of ``sensor=``, such as ``"iso=800,read=2.5,bayer=rggb"`` or ``"camera.toml,iso=800"``
    :param iso: speed of the film, which the settings replace
    :param pitch: distance from pixel to pixel (um)
    :param seconds: exposure time, in which dark current adds up
    """

    def __init__(self, settings: Path = "", *, iso: float = 100.0, pitch: float = 6.0, seconds: float = 0.01) -> None: ...
    @property
    def settings(self) -> str:
        """Settings that readings depend on, of whole pixels: those of ``binning`` are included."""
    @property
    def iso(self) -> float:
        """ISO speed."""
    @property
    def full_well(self) -> float:
        """Full well of a pixel (electrons)."""
    @property
    def white_electrons(self) -> float:
        """Electrons that the value 1 stands for."""
    @property
    def gain(self) -> float:
        """System gain (codes per electron)."""
    @property
    def read_noise(self) -> float:
        """Read noise of a pixel (electrons), without that of rows and columns."""
    @property
    def dark_current(self) -> float:
        """Dark current of a pixel (electrons a second)."""
    @property
    def hdr(self) -> float:
        """Sensitivity relative to that of a second photosite; 1 without one."""
    @property
    def bits(self) -> int:
        """Bits of a code."""
    @property
    def black_level(self) -> int:
        """Code of no light."""
    @property
    def bayer(self) -> Optional[str]:
        """Pattern of the mosaic; ``None`` without one."""
    def read_out(self, pixels: ArrayLike, seed: int = 0) -> NDArray[np.float32]:
        """Read light out, relative to white: height x width x 3, or height x width of one channel or a mosaic."""
    def codes(self, pixels: ArrayLike, seed: int = 0) -> NDArray[np.uint32]:
        """Read light out as codes (DN), of the same shape as :meth:`read_out`."""
    def relative_noise(self, value: float) -> float:
        """Return the noise of grey of a value, % of the signal."""

class ImageQuality:
    """Real rays of a lens, traced once for all analyses."""

    @property
    def fields(self) -> NDArray[np.float64]: ...
    @property
    def field_kind(self) -> Literal["angle", "object_height", "image_height"]: ...
    @property
    def image_heights(self) -> NDArray[np.float64]: ...
    @property
    def wavelengths(self) -> list[float]: ...
    @property
    def film_distance(self) -> float: ...
    def mtf(
        self,
        frequencies: Sequence[float],
        method: Literal["diffraction", "geometric", "limit"] = "diffraction",
        defocus: float = 0.0,
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...
    def distortion(self, count: int = 20) -> dict[str, NDArray[np.float64]]: ...
    def spot(self, field: int, defocus: float = 0.0) -> dict[str, Any]: ...
    def psf(
        self,
        field: int,
        size: int = 64,
        width: Optional[float] = None,
        wavelength: Optional[float] = None,
        channel: Optional[Literal["R", "G", "B"]] = None,
    ) -> tuple[NDArray[np.float64], dict[str, Any]]:
        """Return the image of a point of a field (0: on the axis), ``size`` x ``size`` shares of the
        light, y upwards, and its data: pitch (um), centre (um, relative to the chief ray) and strehl.

        :param width: width of the array (um)
        :param wavelength: light of this wavelength alone (nm); by default that of all ``wavelengths``
        :param channel: light of a channel of a picture of white light
        """

@dataclass
class Mesh:
    """Triangles with a material."""

    vertices: ArrayLike
    faces: ArrayLike
    normals: Optional[ArrayLike] = None
    uv: Optional[ArrayLike] = None
    material: dict[str, Any] = ...
    emission: Optional[tuple[float, float, float]] = None

class Scene:
    """A scene, in memory: a file in the language of pbrt-v4 or in glTF, or arrays."""

    def __init__(self, path: Path, memory: Union[int, str, None] = None) -> None: ...
    @classmethod
    def from_arrays(
        cls,
        meshes: Sequence[Mesh],
        *,
        lens: Union[Lens, Path],
        look_at: Sequence[Point],
        lights: Sequence[dict[str, Any]] = (),
        resolution: tuple[int, int] = (600, 400),
        diagonal: float = 43.27,
        focus: float = 1.0,
        spp: int = 64,
        max_depth: int = 5,
    ) -> "Scene": ...
    @property
    def path(self) -> Optional[str]: ...

class Image:
    """A rendered picture, in linear sRGB: height x width x 3, or height x width for a mosaic."""

    @property
    def pixels(self) -> NDArray[np.float32]: ...
    @property
    def layers(self) -> dict[str, NDArray[np.float32]]: ...
    @property
    def channels(self) -> dict[str, list[str]]: ...
    @property
    def metadata(self) -> dict[str, Union[str, float]]: ...
    @property
    def spectrum(self) -> Optional[NDArray[np.float32]]: ...
    @property
    def wavelengths(self) -> Optional[NDArray[np.float64]]: ...
    @property
    def size(self) -> tuple[int, int]: ...
    def denoise(self) -> "Image": ...
    def __array__(self, dtype: Any = None, copy: Optional[bool] = None) -> NDArray[Any]: ...
    def save(
        self,
        path: Path,
        exposure: Union[float, Literal["auto"]] = 0.0,
        half: bool = False,
        bit_depth: Optional[Literal[8, 16]] = None,
        multipart: bool = False,
    ) -> None: ...
    def _repr_png_(self) -> bytes: ...

class Job:
    """A scene with lens, focus and plan of effects, ready to be rendered."""

    @property
    def plan(self) -> list[dict[str, Any]]: ...
    @property
    def light_paths(self) -> str: ...
    @property
    def warnings(self) -> list[str]: ...
    @property
    def metadata(self) -> dict[str, Union[str, float]]: ...
    def render(
        self,
        threads: int = 0,
        progress: Optional[Callable[[float], Any]] = None,
        checkpoint: Optional[Path] = None,
        checkpoint_interval: float = 60.0,
        resume: bool = False,
        memory: Union[int, str, None] = None,
    ) -> Image: ...
    def passes(self, threads: int = 0) -> Iterator[Image]: ...

@dataclass(frozen=True)
class Camera:
    """A camera, to be given to render and the like. ``None`` keeps what the scene says."""

    lens: Union[Lens, Path, None] = None
    pose: Optional[Sequence[Point]] = None
    film: Optional[float] = None
    focus: Union[float, tuple[int, int], Literal["auto"], None] = None
    fstop: Optional[float] = None
    shutter: Optional[str] = None
    sensor: Optional[str] = None
    resolution: Optional[tuple[int, int]] = None
    film_shift: Optional[tuple[float, float]] = None
    film_tilt: Optional[tuple[float, float]] = None
    zoom: Union[float, str, None] = None
    rolling_shutter: Optional[str] = None
    bayer: Optional[str] = None
    def settings(self) -> dict[str, Any]: ...

def prepare(
    scene: Union[Scene, Path],
    camera: Optional[Camera] = None,
    **settings: Unpack[RenderSettings],
) -> Job: ...
def render(
    scene: Union[Scene, Path],
    camera: Optional[Camera] = None,
    *,
    threads: int = 0,
    progress: Union[bool, Callable[[float], Any], None] = None,
    checkpoint: Optional[Path] = None,
    checkpoint_interval: float = 60.0,
    resume: bool = False,
    memory: Union[int, str, None] = None,
    **settings: Unpack[RenderSettings],
) -> Image: ...
def passes(
    scene: Union[Scene, Path],
    camera: Optional[Camera] = None,
    *,
    threads: int = 0,
    **settings: Unpack[PassSettings],
) -> Iterator[Image]: ...
def sweep(
    scene: Union[Scene, Path],
    camera: Optional[Camera] = None,
    *,
    threads: int = 0,
    progress: Union[bool, Callable[[float], Any], None] = None,
    **settings: Unpack[SweepSettings],
) -> Iterator[tuple[dict[str, Any], Image]]: ...
def dataset(
    spec: Path,
    output: Path,
    *,
    shard: Optional[tuple[int, int]] = None,
    threads: int = 0,
    progress: Union[bool, Callable[[float], Any], None] = None,
) -> list[dict[str, Any]]: ...
def accuracy(
    scene: Union[Scene, Path],
    camera: Optional[Camera] = None,
    *,
    spp: Sequence[int] = (1, 4, 16, 64),
    reference_spp: int = 1024,
    metric: Literal["mse", "relmse", "mape", "flip", "psnr"] = "relmse",
    seed: int = 0,
    threads: int = 0,
    **settings: Unpack[AccuracySettings],
) -> list[dict[str, Any]]: ...
def lens_models(
    scene: Union[Scene, Path],
    camera: Optional[Camera] = None,
    *,
    budget: float = 60.0,
    spp: Optional[int] = None,
    progress: Union[bool, Callable[[float], Any], None] = None,
    **settings: Unpack[LensModelSettings],
) -> list[dict[str, Any]]: ...
def plan(
    scene: Union[Scene, Path], camera: Optional[Camera] = None, **settings: Unpack[RenderSettings]
) -> list[dict[str, Any]]: ...
def compare(
    picture: ArrayLike,
    reference: ArrayLike,
    metric: Literal["mse", "relmse", "mape", "flip", "psnr"] = "flip",
    dynamic_range: Literal["high", "low"] = "high",
) -> float: ...
def read_image(path: Path) -> NDArray[np.float32]:
    """Read a picture: height x width x 3, or height x width of a file of one channel; linear sRGB."""

def chart(
    kind: Literal["edges", "grid", "flat", "leaves", "colours", "star", "greys"],
    lens: Union[Path, Lens],
    path: Path,
    *,
    focus: float,
    resolution: tuple[int, int] = (1200, 800),
    film_size: Union[str, tuple[float, float]] = (36.0, 24.0),
    fstop: Optional[float] = None,
) -> dict[str, Any]:
    """Write the scene of a test chart that fills the picture of a lens, and return its regions."""

def develop(path: Path, white_balance: str = "as-shot") -> NDArray[np.float32]:
    """Develop a raw file (.dng): height x width x 3, or height x width of a sensor without filters; linear sRGB.

    ``white_balance`` is ``"as-shot"``, ``"auto"``, a temperature such as ``"3200K"``, an illuminant such as ``"D65"``,
    or chromaticities ``"0.44,0.41"``.
    """

def write_image(
    path: Path,
    pixels: ArrayLike,
    exposure: Union[float, Literal["auto"]] = 0.0,
    bit_depth: Optional[Literal[8, 16]] = None,
) -> None: ...
