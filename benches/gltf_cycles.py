"""Compares petzval with Blender's Cycles on a scene that Blender exports to glTF.

    pip install bpy==5.0.1 OpenEXR numpy          # Python 3.11
    python benches/gltf_cycles.py target/release/petzval [folder]

Builds the scene with Blender's own modules, exports it, renders it with Cycles and with petzval, and
prints the mean of each object in petzval over that in Cycles. Both pictures stay in the folder.
"""

import math
import subprocess
import sys
import tempfile
from pathlib import Path

import bpy
import numpy as np
import OpenEXR

SAMPLES = 512
SIZE = (480, 320)


def material(name, **inputs):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    shader = made.node_tree.nodes["Principled BSDF"]
    for key, value in inputs.items():
        shader.inputs[key.replace("_", " ")].default_value = value
    return made


def textured(name):
    """A rough plastic with an image of coloured checks."""
    made = material(name, Roughness=0.6)
    size = 256
    image = bpy.data.images.new("checks", size, size)
    y, x = np.mgrid[:size, :size] // 32
    pixels = np.ones((size, size, 4), np.float32)
    pixels[..., :3] = np.where(((x + y) % 2)[..., None], [0.9, 0.3, 0.1], [0.1, 0.4, 0.8])
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    nodes, links = made.node_tree.nodes, made.node_tree.links
    node = nodes.new("ShaderNodeTexImage")
    node.image = image
    links.new(node.outputs["Color"], nodes["Principled BSDF"].inputs["Base Color"])
    return made


def build():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    white, red = (0.8, 0.8, 0.8, 1), (0.7, 0.15, 0.1, 1)
    spheres = [
        material("matt", Base_Color=red, Roughness=1.0),
        material("satin", Base_Color=red, Roughness=0.5),
        material("gloss", Base_Color=red, Roughness=0.15),
        material("metal", Base_Color=(0.9, 0.6, 0.3, 1), Metallic=1.0, Roughness=0.35),
        material("half metal", Base_Color=white, Metallic=0.5, Roughness=0.4),
        material("coated metal", Base_Color=red, Metallic=1.0, Roughness=0.6, Coat_Weight=1.0),
        material("coated plastic", Base_Color=red, Roughness=0.6, Coat_Weight=1.0),
        textured("checks"),
    ]
    for i, made in enumerate(spheres):
        place = ((i % 4 - 1.5) * 1.2, (i // 4 - 0.5) * 1.6, 0.5)
        bpy.ops.mesh.primitive_uv_sphere_add(segments=96, ring_count=48, radius=0.5, location=place)
        bpy.ops.object.shade_smooth()
        add(made, i + 1)
    bpy.ops.mesh.primitive_plane_add(size=12)
    add(material("floor", Base_Color=white, Roughness=1.0), len(spheres) + 1)
    bpy.ops.mesh.primitive_plane_add(size=1.5, location=(-1.5, 1, 4), rotation=(math.pi, 0, 0))
    lamp = material("lamp", Base_Color=(0, 0, 0, 1), Emission_Color=(1, 0.9, 0.8, 1))
    lamp.node_tree.nodes["Principled BSDF"].inputs["Emission Strength"].default_value = 20
    add(lamp, len(spheres) + 2)
    bpy.ops.object.light_add(type="POINT", location=(3, -3, 4))
    bpy.context.object.data.energy = 500
    bpy.context.object.data.shadow_soft_size = 0
    bpy.ops.object.camera_add(location=(0, -6.5, 3.4), rotation=(math.radians(64), 0, 0))
    bpy.context.object.data.lens = 45
    bpy.context.scene.camera = bpy.context.object
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    return [made.name for made in spheres] + ["floor"]


def add(made, index):
    bpy.context.object.data.materials.append(made)
    bpy.context.object.pass_index = index


def cycles(path):
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples = SAMPLES
    scene.cycles.use_denoising = False
    scene.cycles.use_adaptive_sampling = False
    scene.cycles.sample_clamp_indirect = 0
    scene.cycles.max_bounces = 8
    scene.cycles.diffuse_bounces = scene.cycles.glossy_bounces = 8
    scene.view_layers[0].use_pass_object_index = True
    settings = scene.render.image_settings
    settings.media_type = "MULTI_LAYER_IMAGE"
    settings.file_format = "OPEN_EXR_MULTILAYER"
    settings.color_depth = "32"
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)


def channel(path, end):
    """Returns the channel of a picture whose name ends so."""
    for part in OpenEXR.File(str(path), separate_channels=True).parts:
        for name, channel in part.channels.items():
            if name.endswith(end):
                return channel.pixels
    raise KeyError(end)


def main():
    command = Path(sys.argv[1]).resolve()
    folder = Path(sys.argv[2] if len(sys.argv) > 2 else tempfile.mkdtemp())
    folder.mkdir(exist_ok=True)
    names = build()
    scene, ours, theirs = folder / "scene.glb", folder / "petzval.exr", folder / "cycles.exr"
    # Watts become candela without the 683 lm/W of the default.
    bpy.ops.export_scene.gltf(
        filepath=str(scene),
        export_cameras=True,
        export_lights=True,
        export_import_convert_lighting_mode="COMPAT",
    )
    cycles(theirs)
    size = f"{SIZE[0]}x{SIZE[1]}"
    line = [command, "render", scene, "-o", ours, "--resolution", size, "--spp", str(SAMPLES)]
    subprocess.run([str(word) for word in line], check=True)
    index = np.rint(channel(theirs, "Object Index.X"))
    print(f"{'object':16}  red    green  blue   petzval / Cycles")
    for i, name in enumerate(names):
        mask = index == i + 1
        ratios = [
            channel(ours, colour)[mask].mean() / channel(theirs, f"Combined.{colour}")[mask].mean()
            for colour in "RGB"
        ]
        print(f"{name:16}  " + "  ".join(f"{ratio:.3f}" for ratio in ratios))


main()
