"""Sections of lenses, by matplotlib."""

import numpy as np


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
        import matplotlib.pyplot as plt

        _, ax = plt.subplots(figsize=(8, 4))
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
                ax.plot([vertex, vertex], [sign * edge, sign * 1.3 * edge], color="black", lw=2)
        if surface["index"] != before:
            ax.plot(depth, height, color="tab:blue", lw=1)
        before = surface["index"]
    for k, surface in enumerate(surfaces[:-1]):
        # Glass follows this surface: join the rims.
        if surface["index"] > 1.01:
            (here, edge), (there, other) = rims[k], rims[k + 1]
            for end, sign in ((0, -1), (1, 1)):
                tall = sign * max(edge, other)
                ax.plot(
                    [here[end], here[end], there[end], there[end]],
                    [sign * edge, tall, tall, sign * other],
                    color="tab:blue",
                    lw=1,
                )
    film = vertices[-1] + (lens.focus() if film_distance is None else film_distance)
    _draw_rays(lens, ax, surfaces, vertices, film, rays)
    ax.axvline(film, color="black", lw=1)
    ax.axhline(0, color="gray", lw=0.5, ls="-.")
    ax.set_aspect("equal")
    ax.set_xlabel("mm")
    ax.set_ylabel("mm")
    ax.set_title(f"{lens.name}: {lens.efl:.1f} mm, f/{lens.fno:.1f}" if lens.fno else lens.name)
    return ax


def _draw_rays(lens, ax, surfaces, vertices, film, count):
    """Draw rays parallel to the axis that pass the lens: before it, and behind it to the film."""
    front = surfaces[0]["diameter"] / 2
    start = min(-0.4 * (film - vertices[0]), -front)
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
        ax.plot([start, first], [heights[k]] * 2, color="tab:red", lw=0.6)
        z, y = vertices[-1] + p[2, k], p[1, k]
        ax.plot([first, z], [heights[k], y], color="tab:red", lw=0.3, ls=":")
        ax.plot([z, film], [y, y + (film - z) * d[1, k] / d[2, k]], color="tab:red", lw=0.6)
