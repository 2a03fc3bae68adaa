#!/usr/bin/env python3
"""Writes the generated parts of ../snowman.pbrt: ground.ply, trees.pbrt and lights.pbrt.

Run it in this folder. Same seed, same files; nothing but Python's standard library.
"""
import math
import random
import struct

random.seed(1840)  # the year of Petzval's portrait lens


def height(x, z):
    """Snow: a gentle rise towards the back, with soft drifts, m."""
    drift = 0.012 * math.sin(3.1 * x + 0.7) * math.cos(2.3 * z) + 0.006 * math.sin(9 * x - 4 * z)
    return drift + 0.02 * max(0.0, z) ** 1.5 - height.zero


height.zero = 0.0
height.zero = height(0.0, 0.0)


def ground(path, columns=110, rows=130):
    """A height field, finer in front: x from -5 to 5, z from -1.2 to 9."""
    vertices, faces = [], []
    for j in range(rows):
        t = j / (rows - 1)
        z = -1.2 + 10.2 * t ** 1.8
        width = 1.0 + 0.62 * (z + 1.2)
        for i in range(columns):
            x = width * (2 * i / (columns - 1) - 1)
            vertices.append((x, height(x, z), z))
    for j in range(rows - 1):
        for i in range(columns - 1):
            a = j * columns + i
            faces += [(a, a + columns, a + columns + 1), (a, a + columns + 1, a + 1)]

    def normal(x, z, e=1e-3):
        dx = (height(x + e, z) - height(x - e, z)) / (2 * e)
        dz = (height(x, z + e) - height(x, z - e)) / (2 * e)
        n = math.sqrt(dx * dx + dz * dz + 1)
        return -dx / n, 1 / n, -dz / n

    with open(path, "wb") as out:
        out.write(
            f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices)}\n"
            "property float x\nproperty float y\nproperty float z\n"
            "property float nx\nproperty float ny\nproperty float nz\n"
            f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n".encode()
        )
        for x, y, z in vertices:
            out.write(struct.pack("<6f", x, y, z, *normal(x, z)))
        for face in faces:
            out.write(struct.pack("<B3i", 3, *face))


def trees(path):
    """Firs behind and beside the snowman; answers where they stand."""
    places = []
    while len(places) < 46:
        z = random.uniform(0.25, 5.5)
        x = random.uniform(-1, 1) * (0.5 + 0.6 * (z + 0.6))
        clear = 0.20 if z < 1.0 else 0.10 + 0.04 * z
        if abs(x) < clear and z < 1.6:
            continue
        if all(math.hypot(x - a, z - b) > 0.17 for a, b, _ in places):
            places.append((x, z, random.uniform(0.8, 1.5) * (1 + 0.12 * z)))
    with open(path, "w") as out:
        for x, z, size in places:
            out.write(
                "AttributeBegin\n"
                f"    Translate {x:.4f} {height(x, z) - 0.005:.4f} {z:.4f}\n"
                f"    Rotate {random.uniform(0, 360):.1f}  0 1 0\n"
                f"    Scale {size:.3f} {size * random.uniform(0.95, 1.2):.3f} {size:.3f}\n"
                '    ObjectInstance "fir"\n'
                "AttributeEnd\n"
            )
    return places


COLOURS = [(1.0, 0.62, 0.22), (1.0, 0.45, 0.12), (1.0, 0.16, 0.10), (0.25, 0.9, 0.35),
           (0.2, 0.5, 1.0), (1.0, 0.8, 0.5), (1.0, 0.3, 0.6)]


def lamp(out, x, y, z, radius, radiance):
    r, g, b = radiance
    out.write(
        "AttributeBegin\n"
        f'    AreaLightSource "diffuse" "rgb L" [ {r:.3g} {g:.3g} {b:.3g} ]\n'
        f"    Translate {x:.4f} {y:.4f} {z:.4f}\n"
        f'    Shape "sphere" "float radius" {radius:.4f}\n'
        "AttributeEnd\n"
    )


def lights(path, firs):
    with open(path, "w") as out:
        # Lamps all through the wood, spread evenly over the picture as the camera sees it.
        placed = []
        while len(placed) < 120:
            z = random.uniform(1.1, 6.0)
            right = math.tan(math.radians(random.uniform(-23, 23)))
            up = math.tan(math.radians(random.uniform(0.5, 14.5)))
            if all(math.hypot(right - a, up - b) > 0.035 for a, b in placed):
                placed.append((right, up))
                depth = z + 0.7
                colour = random.choice(COLOURS)
                power = random.uniform(1.5, 3.5)
                lamp(out, depth * right, max(0.115 + depth * up, height(depth * right, z) + 0.12),
                     z, 0.010 + 0.0042 * z, [power * c for c in colour])
        # A lamp on the tip of every third fir.
        for x, z, size in firs[::3]:
            lamp(out, x, height(x, z) + 0.30 * size * 1.05, z, 0.006 + 0.002 * z, (4.0, 2.9, 1.3))


if __name__ == "__main__":
    ground("ground.ply")
    lights("lights.pbrt", trees("trees.pbrt"))
