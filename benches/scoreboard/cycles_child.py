"""Renders a scene description with Cycles: blender --background --python cycles_child.py -- JSON."""

import json
import math
import sys
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix, Vector

PLY_COLUMNS = {3: (None, None), 5: (None, 3), 6: (3, None), 8: (3, 6)}


def main(order):
    path = Path(order["scene"])
    scene, folder = json.loads(path.read_text()), path.parent
    bpy.ops.wm.read_factory_settings(use_empty=True)
    settings(scene, order)
    camera(scene)
    sky(scene["sky"])
    materials = {name: material(m, folder) for name, m in scene["materials"].items()}
    for shape in scene["shapes"]:
        add(shape, folder, materials[shape["material"]])
    for light in scene["lights"]:
        if "point" in light:
            add_point(light["point"], light["I"], 0)
        elif "sphere" in light:
            radius = light["radius"]
            intensity = [math.pi * radius**2 * value for value in light["L"]]
            add_point(light["sphere"], intensity, radius)
        else:
            add(light, folder, emission(light["L"]))
    bpy.ops.render.render(write_still=True)


def world(point):
    """Exchanges y and z: Blender's world is right-handed, and its z points up."""
    return Vector((point[0], point[2], point[1]))


def settings(scene, order):
    target = bpy.context.scene
    render, cycles = target.render, target.cycles
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y = scene["size"]
    render.resolution_percentage = 100
    render.threads_mode, render.threads = "FIXED", order["threads"]
    render.filepath = order["out"]
    render.image_settings.file_format = "OPEN_EXR"
    render.image_settings.color_depth = "32"
    render.image_settings.exr_codec = "ZIP"
    render.image_settings.color_mode = "RGB"
    target.view_settings.view_transform = "Raw"
    cycles.device = "CPU"
    cycles.samples, cycles.seed = order["spp"], order["seed"]
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.blur_glossy = 0
    cycles.light_sampling_threshold = 0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.pixel_filter_type = "BOX"
    # Direct light is bounce 0 in Cycles, and depth 1 in pbrt.
    bounces = scene["depth"] - 1
    cycles.max_bounces = cycles.diffuse_bounces = bounces
    cycles.glossy_bounces = cycles.transmission_bounces = bounces


def camera(scene):
    thin = scene["lens"]["thin"]
    eye, target, up = (world(v) for v in scene["view"])
    data = bpy.data.cameras.new("camera")
    data.sensor_fit, data.angle = "AUTO", math.radians(thin["fov"])
    data.dof.use_dof = True
    data.dof.focus_distance = thin["focus"]
    data.dof.aperture_fstop = data.lens / 1000 / (2 * thin["radius"])
    data.clip_end = 1000
    ahead = (target - eye).normalized()
    right = ahead.cross(up).normalized()
    turn = Matrix((right, right.cross(ahead), -ahead)).transposed().to_4x4()
    holder = bpy.data.objects.new("camera", data)
    holder.matrix_world = Matrix.Translation(eye + thin["advance"] * ahead) @ turn
    bpy.context.collection.objects.link(holder)
    bpy.context.scene.camera = holder


def sky(color):
    background = bpy.data.worlds.new("sky")
    background.use_nodes = True
    background.node_tree.nodes["Background"].inputs["Color"].default_value = (*color, 1)
    bpy.context.scene.world = background


def material(description, folder):
    kind, alpha = description["kind"], description.get("alpha", 0)
    result, nodes, output = new_material(kind)
    links = result.node_tree.links
    if "image" in description:
        image = nodes.new("ShaderNodeTexImage")
        image.image = bpy.data.images.load(str(folder / description["image"]))
        color = image.outputs["Color"]
    else:
        value = nodes.new("ShaderNodeRGB")
        value.outputs[0].default_value = (*description.get("color", [1, 1, 1]), 1)
        color = value.outputs[0]
    if kind == "glass":
        shader = nodes.new("ShaderNodeBsdfGlass")
        shader.inputs["IOR"].default_value = description["ior"]
        shader.inputs["Roughness"].default_value = 0
        shader = shader.outputs[0]
    elif kind == "metal":
        shader = glossy(nodes, alpha)
        links.new(color, shader.inputs["Color"])
        shader = shader.outputs[0]
    elif kind == "coated":
        shader = coated(nodes, links, color, alpha)
    else:
        shader = nodes.new("ShaderNodeBsdfDiffuse")
        links.new(color, shader.inputs["Color"])
        shader = shader.outputs[0]
    links.new(shader, output)
    return result


def glossy(nodes, alpha):
    shader = nodes.new("ShaderNodeBsdfGlossy")
    shader.distribution = "GGX"
    shader.inputs["Color"].default_value = (1, 1, 1, 1)
    # Roughness in Blender is the square root of alpha.
    shader.inputs["Roughness"].default_value = math.sqrt(alpha)
    return shader


def coated(nodes, links, color, alpha):
    """Returns a diffuse surface below a coat of index 1.5.

    The coat lets 0.908 of diffuse light in and reflects 0.596 of the light that comes from below, so
    that a colour c becomes 0.908 / 1.5^2 c / (1 - 0.596 c). Blender's principled shader does not
    take this loss into account, and is brighter.
    """

    def vector(operation, *inputs):
        node = nodes.new("ShaderNodeVectorMath")
        node.operation = operation
        for entrance, value in zip(node.inputs, inputs):
            if isinstance(value, float):
                entrance.default_value = (value, value, value)
            else:
                links.new(value, entrance)
        return node.outputs[0]

    let_out = vector("MULTIPLY", color, 0.4036)
    below = nodes.new("ShaderNodeBsdfDiffuse")
    kept = vector("MULTIPLY_ADD", color, -0.5964, 1.0)
    links.new(vector("DIVIDE", let_out, kept), below.inputs["Color"])
    fresnel, mix = nodes.new("ShaderNodeFresnel"), nodes.new("ShaderNodeMixShader")
    fresnel.inputs["IOR"].default_value = 1.5
    links.new(fresnel.outputs[0], mix.inputs[0])
    links.new(below.outputs[0], mix.inputs[1])
    links.new(glossy(nodes, alpha).outputs[0], mix.inputs[2])
    return mix.outputs[0]


def emission(radiance):
    """Returns a light that shines from its front only."""
    result, nodes, output = new_material("light")
    shine, dark = nodes.new("ShaderNodeEmission"), nodes.new("ShaderNodeBsdfDiffuse")
    dark.inputs["Color"].default_value = (0.5, 0.5, 0.5, 1)
    shine.inputs["Color"].default_value = (*radiance, 1)
    mix, side = nodes.new("ShaderNodeMixShader"), nodes.new("ShaderNodeNewGeometry")
    links = result.node_tree.links
    links.new(side.outputs["Backfacing"], mix.inputs[0])
    links.new(shine.outputs[0], mix.inputs[1])
    links.new(dark.outputs[0], mix.inputs[2])
    links.new(mix.outputs[0], output)
    return result


def new_material(name):
    result = bpy.data.materials.new(name)
    result.use_nodes = True
    nodes = result.node_tree.nodes
    nodes.clear()
    return result, nodes, nodes.new("ShaderNodeOutputMaterial").inputs["Surface"]


def add_point(place, intensity, radius):
    """Adds a light of this radiant intensity; Blender's unit is the flux."""
    data = bpy.data.lights.new("point", "POINT")
    data.color, data.energy = intensity, 4 * math.pi
    data.shadow_soft_size = radius
    data.cycles.use_multiple_importance_sampling = radius > 0
    holder = bpy.data.objects.new("point", data)
    holder.location = world(place)
    bpy.context.collection.objects.link(holder)


def add(shape, folder, surface):
    if "sphere" in shape:
        bpy.ops.mesh.primitive_uv_sphere_add(
            segments=96, ring_count=48, radius=shape["radius"], location=world(shape["sphere"])
        )
        holder = bpy.context.object
        bpy.ops.object.shade_smooth()
    else:
        mesh = read_mesh(folder / shape["mesh"], shape.get("flat", "L" in shape))
        holder = bpy.data.objects.new(shape["mesh"], mesh)
        holder.location = world(shape.get("move", [0, 0, 0]))
        bpy.context.collection.objects.link(holder)
    holder.data.materials.append(surface)


def read_mesh(path, flat):
    """Returns the mesh of a binary PLY of meshes.write_ply; Blender computes the smooth normals."""
    header, body = path.read_bytes().split(b"end_header\n", 1)
    words = header.split()
    vertices, faces = (int(words[words.index(k) + 1]) for k in (b"vertex", b"face"))
    columns = words.count(b"float")
    values = np.frombuffer(body, "<f4", vertices * columns).reshape(-1, columns)
    record = np.dtype([("count", "u1"), ("indices", "<i4", 3)])
    corners = np.frombuffer(body, record, faces, values.nbytes)["indices"]
    # y and z change places, so the front is on the other side, unless the order is turned too.
    corners = np.ascontiguousarray(corners[:, ::-1]).ravel()
    mesh = bpy.data.meshes.new(path.name)
    mesh.vertices.add(vertices)
    mesh.vertices.foreach_set("co", np.ascontiguousarray(values[:, [0, 2, 1]]).ravel())
    mesh.loops.add(3 * faces)
    mesh.loops.foreach_set("vertex_index", corners)
    mesh.polygons.add(faces)
    mesh.polygons.foreach_set("loop_start", np.arange(0, 3 * faces, 3, dtype=np.int32))
    mesh.polygons.foreach_set("loop_total", np.full(faces, 3, dtype=np.int32))
    mesh.polygons.foreach_set("use_smooth", np.full(faces, not flat))
    at = PLY_COLUMNS[columns][1]
    if at is not None:
        uv = mesh.uv_layers.new(name="uv")
        uv.data.foreach_set("uv", np.ascontiguousarray(values[corners, at : at + 2]).ravel())
    mesh.update(calc_edges=True)
    return mesh


if __name__ == "__main__":
    argument = sys.argv[sys.argv.index("--") + 1 :]
    main(json.loads(argument[0]))
