"""Renders a scene description with Mitsuba 3: mitsuba_child.py JSON, or --probe VARIANT."""

import json
import math
import sys
from pathlib import Path

import drjit
import mitsuba as mi
import numpy as np


def main(argument):
    if argument == "--probe":
        mi.set_variant(sys.argv[2])
        # Some versions of LLVM stop the process when they compile a kernel.
        mi.render(mi.load_dict(mi.cornell_box()), spp=1).numpy()
        print("mitsuba", mi.__version__)
        return
    order = json.loads(argument)
    mi.set_variant(order["variant"])
    drjit.set_thread_count(order["threads"])
    path = Path(order["scene"])
    scene = mi.load_dict(convert(json.loads(path.read_text()), path.parent, order["spp"]))
    picture = mi.render(scene, seed=order["seed"], spp=order["spp"])
    np.save(order["out"], np.array(picture)[:, :, :3])


def convert(scene, folder, spp):
    """Returns a description as a dictionary for mi.load_dict."""
    eye, target, up = scene["view"]
    thin = scene["lens"]["thin"]
    way = np.subtract(target, eye)
    eye = np.add(eye, thin["advance"] * way / math.hypot(*way))
    look = mi.ScalarTransform4f().look_at(origin=list(eye), target=target, up=up)
    width, height = scene["size"]
    result = {
        "type": "scene",
        # A path of depth 1 sees only lights in Mitsuba, and one surface in pbrt.
        "integrator": {"type": "path", "max_depth": scene["depth"] + 1},
        "sensor": {
            "type": "thinlens",
            "fov": thin["fov"],
            "fov_axis": "smaller",
            "aperture_radius": thin["radius"],
            "focus_distance": thin["focus"],
            # pbrt's camera space is left-handed, Mitsuba's right-handed.
            "to_world": look @ mi.ScalarTransform4f().scale([-1, 1, 1]),
            "film": {
                "type": "hdrfilm",
                "width": width,
                "height": height,
                "rfilter": {"type": "box"},
                "component_format": "float32",
            },
            "sampler": {"type": "multijitter", "sample_count": spp},
        },
        "sky": {"type": "constant", "radiance": rgb(scene["sky"])},
    }
    for name, material in scene["materials"].items():
        result[f"material {name}"] = convert_material(material, folder)
    for i, shape in enumerate(scene["shapes"]):
        result[f"shape {i}"] = {
            **convert_shape(shape, folder),
            "bsdf": {"type": "ref", "id": f"material {shape['material']}"},
        }
    for i, light in enumerate(scene["lights"]):
        if "point" in light:
            result[f"light {i}"] = {
                "type": "point",
                "position": light["point"],
                "intensity": rgb(light["I"]),
            }
        else:
            result[f"light {i}"] = {
                **convert_shape(light, folder),
                "emitter": {"type": "area", "radiance": rgb(light["L"])},
                # A light reflects half of the light in pbrt too, where no material is named.
                "bsdf": two_sided({"type": "diffuse", "reflectance": 0.5}),
            }
    return result


def rgb(values):
    return {"type": "rgb", "value": list(values)}


def convert_shape(shape, folder):
    if "sphere" in shape:
        return {"type": "sphere", "center": shape["sphere"], "radius": shape["radius"]}
    return {
        "type": "ply",
        "filename": str(folder / shape["mesh"]),
        "face_normals": shape.get("flat", "L" in shape),
        "to_world": mi.ScalarTransform4f().translate(shape.get("move", [0, 0, 0])),
    }


def convert_material(material, folder):
    if "image" in material:
        # Rows count from the bottom in pbrt.
        flip = mi.ScalarTransform4f().scale([1, -1, 1])
        color = {"type": "bitmap", "filename": str(folder / material["image"]), "to_uv": flip}
    elif "color" in material:
        color = rgb(material["color"])
    kind, alpha = material["kind"], {"distribution": "ggx", "alpha": material.get("alpha")}
    if kind == "diffuse":
        return two_sided({"type": "diffuse", "reflectance": color})
    if kind == "coated":
        base = {"diffuse_reflectance": color, "nonlinear": True, "int_ior": 1.5, "ext_ior": 1.0}
        return two_sided({"type": "roughplastic", **base, **alpha})
    if kind == "metal":
        # As pbrt's "reflectance" of a conductor: eta of 1, and k to match.
        k = [2 * math.sqrt(r / (1 - r)) for r in material["color"]]
        return two_sided({"type": "roughconductor", "eta": rgb([1, 1, 1]), "k": rgb(k), **alpha})
    return {"type": "dielectric", "int_ior": material["ior"], "ext_ior": 1.0}


def two_sided(bsdf):
    """Lets a surface reflect on both sides, as pbrt's do."""
    return {"type": "twosided", "bsdf": bsdf}


if __name__ == "__main__":
    main(sys.argv[1])
