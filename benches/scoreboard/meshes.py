"""Meshes and image textures of the generated scenes."""

import numpy as np

from pictures import write_png


def write_ply(path, points, faces, normals=None, uv=None):
    """Writes triangles as a binary PLY."""
    columns, names = [points], ["x", "y", "z"]
    if normals is not None:
        columns.append(normals)
        names += ["nx", "ny", "nz"]
    if uv is not None:
        columns.append(uv)
        names += ["u", "v"]
    vertices = np.concatenate([np.asarray(c, "<f4") for c in columns], axis=1)
    triangles = np.zeros(len(faces), [("count", "u1"), ("indices", "<i4", 3)])
    triangles["count"], triangles["indices"] = 3, faces
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(vertices)}"]
    header += [f"property float {name}" for name in names]
    header += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header\n"]
    path.write_bytes("\n".join(header).encode() + vertices.tobytes() + triangles.tobytes())


def write_grid(path, points, uv, closed):
    """Writes a surface given as a grid of points, with smooth normals that agree with its faces.

    closed says for each of the two directions whether the last point is followed by the first.
    """
    m, n, _ = points.shape
    rows, columns = (np.arange(k if shut else k - 1) for k, shut in zip((m, n), closed))
    i, j = (a.ravel() for a in np.meshgrid(rows, columns, indexing="ij"))
    a, b = i * n + j, (i + 1) % m * n + j
    c, d = (i + 1) % m * n + (j + 1) % n, i * n + (j + 1) % n
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])

    flat = points.reshape(-1, 3)
    corners = flat[faces]
    of_face = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals = np.stack(
        [sum(np.bincount(faces[:, k], of_face[:, x], m * n) for k in range(3)) for x in range(3)], 1
    )
    normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-20)[:, None]
    write_ply(path, flat, faces, normals, uv.reshape(-1, 2))


def write_knot(path, size=1, steps=(1530, 180)):
    """Writes a torus knot: at size 1, 2.8 m wide, of a rope 0.34 m thick; 550,800 triangles."""
    along, around = steps
    t = np.linspace(0, 2 * np.pi, along, endpoint=False)
    angle = np.linspace(0, 2 * np.pi, around, endpoint=False)

    def spine(t):
        r = 1 + 0.4 * np.cos(3 * t)
        return np.stack([r * np.cos(2 * t), 0.4 * np.sin(3 * t), r * np.sin(2 * t)], 1)

    step = 1e-4
    ahead = spine(t + step) - spine(t - step)
    ahead /= np.linalg.norm(ahead, axis=1)[:, None]
    side = spine(t + step) - 2 * spine(t) + spine(t - step)
    side -= ahead * (ahead * side).sum(1)[:, None]
    side /= np.linalg.norm(side, axis=1)[:, None]
    up = np.cross(ahead, side)
    radius = 0.17 * (1 + 0.03 * np.sin(20 * angle)[None, :] * np.sin(90 * t)[:, None])
    out = side[:, None] * np.cos(angle)[None, :, None] + up[:, None] * np.sin(angle)[None, :, None]
    points = spine(t)[:, None] + out * radius[:, :, None]
    uv = np.stack(np.broadcast_arrays(t[:, None] * 12 / np.pi, angle[None, :] * 2 / np.pi), 2)
    write_grid(path, size * points[:, ::-1], uv[:, ::-1], (True, True))


def write_vase(path, steps=(120, 160)):
    """Writes a vase, 0.9 m high, as a surface of revolution about the y axis."""
    height, around = steps
    t = np.linspace(0, 1, height)
    angle = np.linspace(0, 2 * np.pi, around)
    radius = 0.2 + 0.1 * np.sin(2.2 * np.pi * t + 0.3) * (1 - 0.3 * t)
    points = np.stack(
        np.broadcast_arrays(
            radius[:, None] * np.cos(angle), 0.9 * t[:, None], radius[:, None] * np.sin(angle)
        ),
        2,
    )
    uv = np.stack(np.broadcast_arrays(angle[None, :] / np.pi, t[:, None]), 2)
    write_grid(path, points, uv, (False, False))


def write_cone(path, radius, height, around=256):
    """Writes a cone without its base, upright on the plane z = 0."""
    angle = np.linspace(0, 2 * np.pi, around, endpoint=False)
    ring = np.stack([np.cos(angle), np.sin(angle), np.zeros(around)], 1)
    tip = np.tile([0, 0, height], (around, 1))
    normals = (ring + [0, 0, radius / height]) / np.hypot(1, radius / height)
    i = np.arange(around)
    faces = np.stack([i, (i + 1) % around, around + i], 1)
    write_ply(path, np.concatenate([radius * ring, tip]), faces, np.concatenate([normals, normals]))


def write_quad(path, corners, repeat=(1, 1)):
    """Writes a quadrilateral, seen anticlockwise from its front, with a texture repeated on it."""
    s, t = repeat
    write_ply(path, corners, [[0, 1, 2], [0, 2, 3]], uv=[[0, 0], [s, 0], [s, t], [0, t]])


def write_tiles(path, size=512):
    """Writes a chequered, uneven pattern; its corners differ, so that a mirrored one is seen."""
    y, x = np.mgrid[0:size, 0:size]
    grey = (x // 64 + y // 64) % 2 * 0.5 + 0.25
    noise = np.random.default_rng(1).normal(0, 0.03, (size, size, 3))
    rgb = np.stack([grey * (0.8 + 0.2 * np.sin(x / 17)), grey * (0.7 + 0.3 * np.sin(y / 23)), grey], 2)
    rgb[:128, :128, 1:] *= 0.4
    write_png(path, (255 * np.clip(rgb + noise, 0, 1)).astype(np.uint8))


def write_wood(path, size=512):
    """Writes boards with grain."""
    y, x = np.mgrid[0:size, 0:size] / size
    board = np.floor(4 * x)
    ring = np.sin(40 * (x + 0.1 * board) + 6 * np.sin(2 * np.pi * y + board) + 3 * np.sin(9 * y))
    value = 0.62 + 0.12 * ring + 0.05 * np.sin(2.4 * board)
    value = value * np.where(4 * x - board < 0.03, 0.5, 1)
    rgb = value[:, :, None] * np.array([0.95, 0.72, 0.5])
    write_png(path, (255 * np.clip(rgb, 0, 1)).astype(np.uint8))
