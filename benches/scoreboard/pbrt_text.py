"""Scene descriptions as text in pbrt-v4's scene language."""

import math


def pbrt_text(scene, lens):
    """Returns a scene file with the "real" or the "thin" lens of the description."""
    width, height = scene["size"]
    real = scene["lens"]
    lines = [
        f'Film "rgb" "integer xresolution" {width} "integer yresolution" {height}'
        f' "float diagonal" {real["diagonal"]} "bool savefp16" false',
        'Sampler "zsobol"',
        'PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5',
        f'Integrator "path" "integer maxdepth" {scene["depth"]}',
    ]
    eye, target, up = scene["view"]
    if lens == "thin":
        thin = real["thin"]
        eye = advance(eye, target, thin["advance"])
        camera = f'"perspective" "float fov" {thin["fov"]:.6f} "float lensradius" {thin["radius"]}'
        camera += f' "float focaldistance" {thin["focus"]:.6f}'
    else:
        camera = f'"realistic" "string lensfile" "{real["file"]}"'
        camera += f' "float aperturediameter" {real["aperture"]} "float focusdistance" {real["focus"]}'
    lines += [f"LookAt {row(eye)}  {row(target)}  {row(up)}", f"Camera {camera}", "WorldBegin"]
    lines.append(f'LightSource "infinite" "rgb L" [ {row(scene["sky"])} ]')
    for light in scene["lights"]:
        lines += light_lines(light)
    for i, (name, material) in enumerate(scene["materials"].items()):
        lines += material_lines(f"image {i}", name, material)
    for shape in scene["shapes"]:
        lines += ["AttributeBegin", f'NamedMaterial "{shape["material"]}"', *shape_lines(shape)]
        lines.append("AttributeEnd")
    return "\n".join(lines) + "\n"


def advance(eye, target, distance):
    """Returns the point at a distance from the eye towards the target."""
    way = [t - e for e, t in zip(eye, target)]
    length = math.hypot(*way)
    return [e + distance * w / length for e, w in zip(eye, way)]


def row(values):
    return " ".join(f"{v:.7g}" for v in values)


def light_lines(light):
    if "point" in light:
        at = row(light["point"])
        return [f'LightSource "point" "rgb I" [ {row(light["I"])} ] "point3 from" [ {at} ]']
    shine = f'AreaLightSource "diffuse" "rgb L" [ {row(light["L"])} ]'
    return ["AttributeBegin", shine, *shape_lines(light), "AttributeEnd"]


def shape_lines(shape):
    if "sphere" in shape:
        return [f"Translate {row(shape['sphere'])}", f'Shape "sphere" "float radius" {shape["radius"]}']
    move = [f"Translate {row(shape['move'])}"] if "move" in shape else []
    return [*move, f'Shape "plymesh" "string filename" "{shape["mesh"]}"']


def material_lines(texture, name, material):
    lines, color = [], ""
    if "image" in material:
        lines.append(f'Texture "{texture}" "spectrum" "imagemap" "string filename" "{material["image"]}"')
        color = f' "texture reflectance" "{texture}"'
    elif "color" in material:
        color = f' "rgb reflectance" [ {row(material["color"])} ]'
    rough = f' "float roughness" {material.get("alpha")} "bool remaproughness" false'
    kind = {
        "diffuse": f'"diffuse"{color}',
        "coated": f'"coateddiffuse"{color}{rough}',
        "metal": f'"conductor"{color}{rough}',
        "glass": f'"dielectric" "float eta" {material.get("ior")}',
    }[material["kind"]]
    return [*lines, f'MakeNamedMaterial "{name}" "string type" {kind}']
