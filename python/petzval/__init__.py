"""petzval: photographs 3-D scenes through real, multi-element camera lenses.

>>> import petzval as pz
>>> image = pz.render(pz.Scene("scenes/dgauss.pbrt"), spp=16)
>>> image.save("dgauss.exr")

Lengths of lenses are in millimetres, distances of scenes in metres. Pictures are linear sRGB. Every
function that takes time releases the interpreter's lock and runs on all cores. Ctrl-C ends renders,
data sets, maps and the reading of scenes.
"""

import itertools as _itertools
import json as _json
from collections.abc import Iterable as _Iterable

from . import cpu as _cpu

_cpu.check()

from . import arrays as _arrays
from . import error_against_time as _error_against_time
from . import export as export
from . import keywords as _keywords
from . import measure as measure
from . import progress as _progress
from . import settings as _settings
from ._petzval import (
    Image,
    ImageQuality,
    Job,
    Lens,
    Sensor,
    __version__,
    compare,
    develop,
    read_image,
    write_image,
)
from ._petzval import Scene as _Scene
from ._petzval import dataset as _dataset
from ._petzval import lens_models as _lens_models
from ._petzval import prepare as _prepare
from .arrays import Mesh
from .camera import Camera
from .charts import chart
from .picture_settings import (
    AccuracySettings,
    LensModelSettings,
    PassSettings,
    RenderSettings,
    SweepSettings,
)

__all__ = [
    "AccuracySettings",
    "Camera",
    "Image",
    "ImageQuality",
    "Job",
    "Lens",
    "LensModelSettings",
    "Mesh",
    "PassSettings",
    "RenderSettings",
    "Scene",
    "Sensor",
    "SweepSettings",
    "__version__",
    "accuracy",
    "chart",
    "compare",
    "dataset",
    "develop",
    "export",
    "lens_models",
    "measure",
    "passes",
    "plan",
    "prepare",
    "read_image",
    "render",
    "sweep",
    "write_image",
]


class Scene(_Scene):
    """A scene, in memory: a file in the language of pbrt-v4 or in glTF, or arrays.

    One scene can be rendered many times, with other lenses, focus or film: its geometry and textures
    are neither read nor copied again.

    :param path: the scene file
    :param memory: the most that it may take: bytes, or a text such as ``"8GiB"``
    :raises MemoryError: the scene declares more than that
    """

    @classmethod
    @_keywords.named
    def from_arrays(
        cls,
        meshes,
        *,
        lens,
        look_at,
        lights=(),
        resolution=(600, 400),
        diagonal=43.27,
        focus=1.0,
        spp=64,
        max_depth=5,
    ):
        """Make a scene of arrays.

        :param meshes: a list of :class:`Mesh`
        :param lens: a :class:`Lens`, or the path of a lens file
        :param look_at: ``(eye, target)`` or ``(eye, target, up)``, world space in metres, left-handed:
            x to the right, y up and z forward for a camera that looks along z
        :param lights: lights of the scene language, such as ``{"type": "infinite", "L": (1, 1, 1)}``
        :param resolution: width and height (pixels)
        :param diagonal: diagonal of the film (mm)
        :param focus: distance in focus, from the film (m)
        :param spp: samples per pixel
        :param max_depth: largest number of bounces
        """
        look_at = _settings.nine_numbers(() if look_at is None else look_at)
        return cls(
            _arrays.assembled(
                meshes, lights, lens, resolution, diagonal, look_at, focus, spp, max_depth
            )
        )


@_keywords.takes(RenderSettings)
def prepare(scene, camera=None, **settings):
    """Prepare a scene: add the lens, its focus and the plan of effects.

    ``None`` keeps what the scene says. The settings are those of ``petzval render``:

    :param scene: a :class:`Scene`, or the path of a scene file
    :param camera: a :class:`Camera`; the settings below count before it
    :param lens: a :class:`Lens`, or the path of a lens file
    :param focus: metres from the film, ``"auto"`` for the middle of the picture, or a pixel ``(x, y)``
    :param fstop: f-number
    :param look_at: ``(eye, target)`` or ``(eye, target, up)``, each three numbers, world space
    :param film_shift: shift to the right and up in the picture (mm)
    :param film_tilt: tilt about the horizontal and the vertical axis (degrees)
    :param film_diagonal: diagonal of the film (mm)
    :param coating: ``"none"``, ``"mgf2"``, ``"broadband"`` or ``"perfect"``, for surfaces without one
    :param resolution: width and height (pixels)
    :param crop: left, top, right, bottom (pixels; the last two are not included)
    :param spp: samples per pixel; with ``noise`` or ``time``, the most
    :param seed: seed of the random numbers
    :param effects: ``"auto"``, ``"all"``, ``"none"``, or a text such as ``"+dispersion,-iris"``
    :param light_paths: whether lamps and caustics are found from the lights; ``None`` where it pays
    :param aov: names of layers, such as ``["depth", "normal", "coc"]``
    :param noise: stop when the picture is this exact, such as 0.02
    :param time: stop after this time (s)
    :param shutter: ``open``, ``close``, ``time``, ``ramp``, ``opening``, ``closing`` (times) or ``curve``,
        such as ``"time=1/60"`` (s) or ``"time=10ms,ramp=1ms"``
    :param rolling_shutter: time from the first row to the last, and a direction, such as ``"20ms,up"``
    :param sensor: sensor, such as ``"iso=800,pixel=4"`` (pixel pitch in um); ``""`` for its defaults
    :param bayer: mosaic of the sensor: ``"rggb"``, ``"bggr"``, ``"grbg"``, ``"gbrg"``, or ``"quad-rggb"`` and so on.
        The pixels of the picture are then height x width
    :param passband: two wavelengths (nm)
    :param buckets: number of buckets of wavelength, or a text such as ``"31@400..710"`` (nm) or ``"none"``
    :param zoom: focal length (mm), or the name of a state of the lens file
    :param focus_model: ``"sharpest"`` or ``"pbrt"``
    :param assume_vd: whether glass that is known by its index alone takes a similar glass's dispersion
    :param catalogue: a glass catalogue (AGF), a folder of them, or a list of these; those of a
        :class:`Lens` count too
    :raises OSError: a file cannot be read
    :raises ValueError: a file is wrong, or a setting does not fit the scene
    """
    return _prepare(_read(scene), _settings.checked(settings, camera))


def _read(scene, memory=None):
    """Return a scene, which is read if it is a path."""
    return scene if isinstance(scene, _Scene) else Scene(scene, memory)


@_keywords.takes(RenderSettings)
def render(
    scene,
    camera=None,
    *,
    threads=0,
    progress=None,
    checkpoint=None,
    checkpoint_interval=60.0,
    resume=False,
    memory=None,
    **settings,
):
    """Render a scene. Returns an :class:`Image`.

    The picture has the bits of ``petzval render`` with the same settings, on any number of threads.

    :param camera: a :class:`Camera`; settings count before it
    :param threads: number of threads; 0 is one for each core
    :param progress: ``True`` for a bar on standard error, or a function that is called with the share
        of the samples that are done, 0 to 1
    :param checkpoint: file for the state of the render, written while it goes on and when Ctrl-C ends
        it, and removed when the picture is finished
    :param checkpoint_interval: time between checkpoints (s)
    :param resume: whether to go on from that file, if it exists, to the same picture bit for bit
    :param memory: the most that the render may take: bytes, or a text such as ``"8GiB"``
    :param settings: those of :func:`prepare`
    :raises MemoryError: the render is expected to take more than ``memory``
    :raises ValueError: also if ``checkpoint`` is of another picture
    """
    report = _progress.reporter(progress)
    return prepare(_read(scene, memory), camera, **settings).render(
        threads=_settings.count("threads", threads, 0),
        progress=report,
        checkpoint=checkpoint,
        checkpoint_interval=checkpoint_interval,
        resume=resume,
        memory=memory,
    )


@_keywords.takes(
    PassSettings,
    refused=dict.fromkeys(
        ("noise", "time"), "passes take all samples; leave the loop to stop earlier"
    ),
)
def passes(scene, camera=None, *, threads=0, **settings):
    """Iterate over the pictures of a render while it goes on, of 1, 2, 4, 8 ... samples a pixel.

    Each is the picture of :func:`render` with so many samples, without layers and diffraction. The last
    has all samples. To leave the loop ends the render.

    :param settings: those of :func:`prepare`, without ``noise`` and ``time``
    """
    return prepare(scene, camera, **settings).passes(threads=_settings.count("threads", threads, 0))


@_keywords.takes(SweepSettings)
def sweep(scene, camera=None, *, threads=0, progress=None, **settings):
    """Iterate over the pictures of all combinations of settings that are lists.

    >>> for changed, image in pz.sweep("scenes/dgauss.pbrt", fstop=[2.8, 4, 5.6], spp=16):
    ...     image.save(f"f{changed['fstop']}.exr")

    The scene is read once. Pairs such as ``resolution`` are tuples, so that lists are unambiguous; the
    setting ``aov`` is always a list of its own.

    :returns: an iterator over pairs: the settings that change, as a dictionary, and the :class:`Image`
    """
    scene = _read(scene)
    lists = {k: v for k, v in settings.items() if isinstance(v, list) and k != "aov"}
    fixed = {k: v for k, v in settings.items() if k not in lists}
    for name, values in lists.items():
        if not values:
            raise ValueError(f"{name}: the list is empty")

    def pictures():
        for values in _itertools.product(*lists.values()):
            changed = dict(zip(lists, values))
            image = render(
                scene, camera, threads=threads, progress=progress, **fixed, **changed
            )
            yield changed, image

    return pictures()


@_keywords.named
def dataset(spec, output, *, shard=None, threads=0, progress=None):
    """Photograph the pairs of a specification, as ``petzval dataset`` does, with the same bits.

    Pairs that are finished are kept, so that the same call continues one that was stopped.

    :param spec: the specification, a TOML file
    :param output: the folder of the pairs and their manifest
    :param shard: ``(i, n)`` takes the i-th of n parts, from 1, with a manifest of its own
    :param threads: number of threads; 0 is one for each core
    :param progress: as in :func:`render`, with the share of the pairs that are done
    :returns: the rows of the manifest, a dictionary for each pair
    """
    part = (1, 1) if shard is None else shard
    if not isinstance(part, (tuple, list)) or len(part) != 2:
        raise TypeError(f"shard={shard!r}: expected (i, n)")
    part = tuple(_settings.count("shard", i, 0) for i in part)
    report = _progress.reporter(progress)
    manifest = _dataset(spec, output, part, _settings.count("threads", threads, 0), report)
    with open(manifest, encoding="utf-8") as rows:
        # A row that another process is writing has no end yet.
        return [_json.loads(row) for row in rows if row.endswith("\n")]


@_keywords.takes(AccuracySettings)
def accuracy(
    scene,
    camera=None,
    *,
    spp=(1, 4, 16, 64),
    reference_spp=1024,
    metric="relmse",
    seed=0,
    threads=0,
    **settings,
):
    """Measure what accuracy costs in time: the error of pictures with more and more samples.

    The reference has another seed, so that no error is common to both. Its own error is about
    ``spp / reference_spp`` of that of a picture, for the metrics that are squares.

    :param spp: samples per pixel of each picture
    :param reference_spp: those of the reference
    :param metric: a metric of :func:`compare`
    :param settings: those of :func:`prepare`
    :returns: a list of dictionaries: spp, seconds (of preparation and render) and error
    """
    scene = _read(scene)
    if not isinstance(spp, _Iterable) or isinstance(spp, str):
        raise TypeError(f"spp={spp!r}: expected a list of whole numbers")
    counts = [_settings.count("spp", samples, 1) for samples in spp]
    most = _settings.count("reference_spp", reference_spp, 1)
    if counts and max(counts) >= most:
        raise ValueError(f"reference_spp={most}: expected more than each of spp")

    def picture(samples, seed):
        return render(scene, camera, spp=samples, seed=seed, threads=threads, **settings)

    return _error_against_time.measure(picture, counts, most, metric, _settings.count("seed", seed, 0))


@_keywords.takes(LensModelSettings)
def lens_models(scene, camera=None, *, budget=60.0, spp=None, progress=None, **settings):
    """Measure what models of a lens cost and how exact they are, as ``petzval accuracy`` does.

    The scene is photographed by a pinhole, a thin lens, a polynomial, every surface in f32 with and
    without effects, and every surface in f64, each with more and more samples. Errors are against the
    richest model, relative to the light of a pixel or that of the picture where it is dark. The
    scene's camera must have a lens file.

    :param budget: time for all of it (s)
    :param spp: the most samples per pixel, if not as many as the time allows
    :param progress: as in :func:`render`, with the share of the time
    :param settings: those of :func:`prepare`; layers, sensor and stop criteria do not count
    :returns: a list of dictionaries, one for each picture: ``model``, ``description``, ``spp``,
        ``seconds``, ``film_error`` (rms distance of its rays on the film, um), ``error`` (rms, with
        noise), ``noise``, ``own_error`` of the model (0 if noise explains it, ``None`` for the richest),
        ``own_error_at_most``, ``mse``, ``relmse``, ``flip``, ``adds`` (the effect that the richest model
        lacks), and ``best``: whether no other picture is as exact in less time
    """
    report = _progress.reporter(progress)
    most = _settings.count("spp", spp, 4) or 2**20
    settings = _settings.checked(settings, camera)
    return _lens_models(_read(scene), settings, float(budget), most, report)


@_keywords.takes(RenderSettings)
def plan(scene, camera=None, **settings):
    """Return which effects a picture needs, and why.

    :param settings: those of :func:`prepare`
    :returns: a list of dictionaries: effect, on, by, reason
    """
    return prepare(scene, camera, **settings).plan
