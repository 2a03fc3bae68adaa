"""Sections of lenses, by matplotlib or as SVG."""

from dataclasses import dataclass
from xml.sax.saxutils import escape

import numpy as np

#: Width of an SVG drawing (pixels), and the margin around it.
_WIDTH, _MARGIN = 720, 24


@dataclass
class Line:
    """A line of a drawing: places along the axis and above it (mm)."""

    z: np.ndarray
    y: np.ndarray
    kind: str


#: Colour, width (points) and dashes of each kind of line.
_STYLES = {
    "glass": ("tab:blue", 1, "-"),
    "stop": ("black", 2, "-"),
    "ray": ("tab:red", 0.6, "-"),
    "inside": ("tab:red", 0.3, ":"),
    "film": ("black", 1, "-"),
    "axis": ("gray", 0.5, "-."),
}
_SVG_COLOURS = {"tab:blue": "#1f77b4", "tab:red": "#d62728", "black": "#000000", "gray": "#808080"}
_SVG_DASHES = {"-": "", ":": ' stroke-dasharray="1 2"', "-.": ' stroke-dasharray="8 3 1 3"'}


def sag(surface, height):
    """Return the depth of a surface at heights above the axis (mm)."""
    curvature = 0.0 if np.isinf(surface["radius"]) else 1.0 / surface["radius"]
    h2 = height * height
    with np.errstate(invalid="ignore"):
        depth = curvature * h2 / (1 + np.sqrt(1 - (1 + surface["conic"]) * curvature**2 * h2))
    for power, coefficient in surface["asphere"]:
        depth = depth + coefficient * np.abs(height) ** power
    return depth


def draw(lens, ax=None, rays=9, film_distance=None):
    """Draw the section of a lens with rays; see :meth:`petzval.Lens.draw`."""
    if ax is None:
        try:
            import matplotlib.pyplot as plt
        except ImportError as error:
            advice = "pip install matplotlib, or use Lens.svg, which does not need it"
            raise ImportError(f"Lens.draw needs matplotlib: {advice}") from error
        _, ax = plt.subplots(figsize=(8, 4))
    for line in section(lens, rays, film_distance):
        colour, width, dashes = _STYLES[line.kind]
        ax.plot(line.z, line.y, color=colour, lw=width, ls=dashes)
    ax.set_aspect("equal")
    ax.set_xlabel("mm")
    ax.set_ylabel("mm")
    ax.set_title(title(lens))
    return ax


def svg(lens, rays=9, film_distance=None):
    """Return the drawing as the text of an SVG file; see :meth:`petzval.Lens.svg`."""
    lines = section(lens, rays, film_distance)
    z, y = (np.concatenate([getattr(line, axis) for line in lines]) for axis in "zy")
    left, right, top = np.nanmin(z), np.nanmax(z), np.nanmax(np.abs(y))
    scale = (_WIDTH - 2 * _MARGIN) / max(right - left, 1e-9)
    height = 2 * top * scale + 3 * _MARGIN
    middle = 2 * _MARGIN + top * scale
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{_WIDTH}" height="{height:.0f}" '
        f'viewBox="0 0 {_WIDTH} {height:.0f}">',
        f'<rect width="{_WIDTH}" height="{height:.0f}" fill="#ffffff"/>',
        f'<text x="{_MARGIN}" y="{_MARGIN}" font-family="sans-serif" font-size="14">'
        f"{escape(title(lens))}</text>",
    ]
    for line in lines:
        colour, width, dashes = _STYLES[line.kind]
        points = [
            f"{_MARGIN + (a - left) * scale:.2f},{middle - b * scale:.2f}"
            for a, b in zip(line.z, line.y)
            if np.isfinite(a) and np.isfinite(b)
        ]
        parts.append(
            f'<polyline class="{line.kind}" points="{" ".join(points)}" fill="none" '
            f'stroke="{_SVG_COLOURS[colour]}" stroke-width="{width}"{_SVG_DASHES[dashes]}/>'
        )
    return "\n".join([*parts, "</svg>", ""])


def title(lens):
    """Return the name of a lens with its focal length and f-number."""
    return f"{lens.name}: {lens.efl:.1f} mm, f/{lens.fno:.1f}" if lens.fno else lens.name


def section(lens, rays=9, film_distance=None):
    """Return the lines of the section of a lens with rays from infinity."""
    if not 0 <= rays <= 801:
        raise ValueError(f"rays={rays}: expected 0 to 801")
    if film_distance is not None and not np.isfinite(film_distance):
        raise ValueError(f"film_distance={film_distance}: expected mm")
    lines = []

    def add(kind, z, y):
        lines.append(Line(np.asarray(z, dtype=float), np.asarray(y, dtype=float), kind))

    surfaces = lens.surfaces
    vertices = np.concatenate([[0.0], np.cumsum([s["thickness"] for s in surfaces])])[: len(surfaces)]
    rims, before = [], 1.0
    for surface, vertex in zip(surfaces, vertices):
        edge = surface["diameter"] / 2
        height = np.linspace(-edge, edge, 65)
        depth = vertex + sag(surface, height)
        rims.append((depth[[0, -1]], edge))
        if surface["stop"]:
            for sign in (-1, 1):
                add("stop", [vertex, vertex], [sign * edge, sign * 1.3 * edge])
        if surface["index"] != before:
            add("glass", depth, height)
        before = surface["index"]
    for k, surface in enumerate(surfaces[:-1]):
        # Glass follows this surface: join the rims.
        if surface["index"] > 1.01:
            (here, edge), (there, other) = rims[k], rims[k + 1]
            for end, sign in ((0, -1), (1, 1)):
                tall = sign * max(edge, other)
                add(
                    "glass",
                    [here[end], here[end], there[end], there[end]],
                    [sign * edge, tall, tall, sign * other],
                )
    film = vertices[-1] + (lens.focus() if film_distance is None else film_distance)
    front = surfaces[0]["diameter"] / 2
    start = min(-0.4 * (film - vertices[0]), -front)
    tallest = max(surface["diameter"] / 2 for surface in surfaces)
    add("axis", [start, film], [0, 0])
    add("film", [film, film], [-tallest, tallest])
    _add_rays(add, lens, surfaces, vertices, film, start, rays)
    return lines


def _add_rays(add, lens, surfaces, vertices, film, start, count):
    """Add rays parallel to the axis that pass the lens: before it, and behind it to the film."""
    front = surfaces[0]["diameter"] / 2
    heights = np.linspace(-front, front, 801)
    points = np.zeros((3, heights.size), dtype=np.float32)
    points[1], points[2] = heights, start
    directions = np.zeros_like(points)
    directions[2] = 1
    p, d, status = lens.trace(points, directions)
    passed = np.flatnonzero(status == 0)
    if passed.size == 0:
        return
    chosen = passed[np.linspace(0, passed.size - 1, min(count, passed.size)).astype(int)]
    for k in chosen:
        first = float(sag(surfaces[0], heights[k]))
        add("ray", [start, first], [heights[k]] * 2)
        z, y = vertices[-1] + p[2, k], p[1, k]
        add("inside", [first, z], [heights[k], y])
        add("ray", [z, film], [y, y + (film - z) * d[1, k] / d[2, k]])
