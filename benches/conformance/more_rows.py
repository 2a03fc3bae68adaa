"""Rows of the conformance table for parameters, beside those of rows.py for each part of the language."""

from rows import (
    BALL, CAMERA, COLOURS, FILM, GREY, GROUND, IMAGE, LIGHTS, LOOK, PICTURE, TETRAHEDRON, WORLD, light, material, row,
    shape, texture,
)

SQUARE = '"point3 P" [-0.8 0 0.1  0.8 0 0.1  -0.8 0.3 1.2  0.8 0.3 1.2]'
UP = "Translate 0 0 0.6\n"
FILES = "@ROOT@/tests/pbrt_language"

# Shapes
for name, text in [
    ("sphere, phimax", 'Shape "sphere" "float radius" 0.6 "float phimax" 130'),
    ("sphere, zmin", 'Shape "sphere" "float radius" 0.6 "float zmin" 0.1'),
    ("sphere, zmax", 'Rotate 60 1 0 0\nShape "sphere" "float radius" 0.6 "float zmax" 0.2'),
    ("sphere, stretched", 'Scale 1 0.7 0.4\nShape "sphere" "float radius" 0.6'),
    ("sphere, sheared", 'ConcatTransform [1 0 0 0  0.4 1 0 0  0 0.3 1 0  0 0 0 1]\nShape "sphere" "float radius" 0.5'),
    ("cylinder, phimax", 'Shape "cylinder" "float radius" 0.5 "float zmin" -0.5 "float zmax" 0.5 "float phimax" 90'),
    ("cylinder, lying", 'Rotate 90 0 1 0\nRotate 20 1 1 0\nShape "cylinder" "float radius" 0.3 "float zmin" -0.8 "float zmax" 0.6'),
    ("cylinder, stretched", 'Scale 1.2 0.5 1\nShape "cylinder" "float radius" 0.5 "float zmin" -0.4 "float zmax" 0.4'),
    ("disk, height", 'Shape "disk" "float height" 0.3 "float radius" 0.7'),
    ("disk, innerradius", 'Rotate 60 1 0 0\nShape "disk" "float radius" 0.7 "float innerradius" 0.4'),
    ("disk, phimax", 'Rotate 50 1 0 0\nShape "disk" "float radius" 0.7 "float phimax" 100'),
    ("disk, stretched", 'Rotate 60 1 0 0\nScale 1.4 0.5 1\nShape "disk" "float radius" 0.6'),
]:
    shape(name, UP + text)
for levels in [0, 1, 2]:
    shape(f"loopsubdiv, levels {levels}", f'Translate 0 0 0.5\nShape "loopsubdiv" "integer levels" {levels} "point3 P" [0 0 0.8  -0.8 -0.5 -0.3  0.8 -0.5 -0.3  0 0.8 -0.3] "integer indices" [0 1 2  0 2 3  0 3 1  1 3 2]')
shape("loopsubdiv, open", 'Shape "loopsubdiv" "integer levels" 3 "point3 P" [-0.8 0 0.1  0.8 0 0.1  -0.8 0.3 1.2  0.8 0.3 1.2] "integer indices" [0 1 2  1 3 2]')
shape("trianglemesh, one triangle without indices", 'Shape "trianglemesh" "point3 P" [-0.8 0 0.1  0.8 0 0.1  0 0.3 1.2]')
shape("bilinearmesh, indices", 'Shape "bilinearmesh" "point3 P" [-0.8 0 0.1  0 -0.3 0.1  0.8 0 0.1  -0.8 0 1  0 -0.3 1.2  0.8 0 1] "integer indices" [0 1 3 4  1 2 4 5]')
shape("plymesh, transformed", 'Translate 0 0 0.5\nRotate 70 1 1 0\nScale 9 4 6\nShape "plymesh" "string filename" "@ROOT@/scenes/atelier/knob.ply.gz"')
for name, text in [
    ("disk", 'Rotate 50 1 0 0\nShape "disk" "float radius" 0.7 "float alpha" 0.3'),
    ("cylinder", 'Shape "cylinder" "float radius" 0.5 "float alpha" 0.6'),
    ("bilinearmesh", f'Translate 0 0 -0.6\nShape "bilinearmesh" {SQUARE} "float alpha" 0.5'),
]:
    shape(f"alpha, {name}", UP + text)
HOLES = 'Texture "holes" "float" "checkerboard" "float uscale" 6 "float vscale" 6 "float tex1" 1 "float tex2" 0\n'
shape("alpha, texture", f'{HOLES}{UP}Shape "sphere" "float radius" 0.6 "texture alpha" "holes"')
shape("alpha, imagemap", f'Texture "leaf" "float" "imagemap" "string filename" "@ROOT@/scenes/atelier/leaf-alpha.png"\nShape "bilinearmesh" {SQUARE} "texture alpha" "leaf"')
GRID = f'Texture "t" "spectrum" "imagemap" {IMAGE}\nMaterial "diffuse" "texture reflectance" "t"\n'
for name, text in [
    ("trianglemesh, uv", 'Shape "trianglemesh" "point3 P" [-0.8 0 0.1  0.8 0 0.1  0 0.3 1.2] "point2 uv" [0.1 0.2  0.8 0.1  0.4 0.9]'),
    ("trianglemesh, no uv", f'Shape "trianglemesh" {TETRAHEDRON}'),
    ("bilinearmesh, uv", f'Shape "bilinearmesh" {SQUARE} "point2 uv" [0.1 0.2  0.8 0.1  0.2 0.7  0.9 0.9]'),
    ("disk, uv", UP + 'Rotate 60 1 0 0\nShape "disk" "float radius" 0.7 "float innerradius" 0.1'),
    ("cylinder, uv", UP + 'Shape "cylinder" "float radius" 0.5 "float zmin" -0.5 "float zmax" 0.5 "float phimax" 300'),
    ("sphere, uv of a part", UP + 'Shape "sphere" "float radius" 0.6 "float zmin" -0.3 "float phimax" 250'),
]:
    row("shapes", name, GRID + text)
SILVER = 'Material "conductor" "rgb reflectance" [0.8 0.8 0.8] "float uroughness" 0.05 "float vroughness" 0.4\n'
row("shapes", "trianglemesh, S", SILVER + f'Shape "trianglemesh" {TETRAHEDRON} "normal N" [0 0 1  -0.7 -0.5 0.5  0.7 -0.5 0.5  0 0.7 0.7] "vector3 S" [1 0 0  0 1 0  0 1 0  1 0 0]')
LEANING = '"vector3 S" [1 0 0  1 1 0  0.2 1 0.5  1 0 0.3]'
WITH_S = f'Shape "trianglemesh" {TETRAHEDRON} {LEANING}\n'
ACROSS = '"vector3 S" [0 0 1  0 0 1  0 0 1  0 0 1]'
row("shapes", "trianglemesh, S without N", SILVER + WITH_S)
row("shapes", "trianglemesh, S along z", SILVER + f'Shape "trianglemesh" {TETRAHEDRON} {ACROSS}')
row("shapes", "trianglemesh, S, ObjectInstance", SILVER + f'ObjectBegin "o"\n{WITH_S}ObjectEnd\nRotate 130 0 0 1\nScale 1 0.7 1.2\nObjectInstance "o"')
row("shapes", "trianglemesh, S, mirrored", SILVER + f"Scale -1 1 1\n{WITH_S}")
row("shapes", "trianglemesh, S, isotropic", GREY + WITH_S)
row("shapes", "trianglemesh, S, normalmap", 'Material "conductor" "rgb reflectance" [0.8 0.8 0.8] "float roughness" 0.2 "string normalmap" "@ROOT@/scenes/atelier/knurl.png"\n' + WITH_S)
row("shapes", "trianglemesh, S, displacement", 'Texture "bumps" "float" "wrinkled"\nMaterial "conductor" "rgb reflectance" [0.8 0.8 0.8] "float roughness" 0.2 "texture displacement" "bumps"\n' + WITH_S)

DISPLACED = 'Texture "h" "float" "imagemap" "string filename" "@ROOT@/tests/pbrt_language/colours.png" "float scale" 0.4\n'
SHEET = 'Shape "plymesh" "string filename" "@ROOT@/tests/pbrt_language/sheet.ply"'
for name, text, settings in [
    ("", f'{SHEET} "texture displacement" "h" "float edgelength" 0.02', ""),
    (", coarse", f'{SHEET} "texture displacement" "h" "float edgelength" 0.3', ""),
    (", scaled and mirrored", f'Scale -1.4 1.2 0.8\n{SHEET} "texture displacement" "h" "float edgelength" 0.05', ""),
    (", default edgelength", f'{SHEET} "texture displacement" "h"', ""),
    (", displacementedgescale", f'{SHEET} "texture displacement" "h" "float edgelength" 0.4', 'Option "displacementedgescale" 0.1\n'),
]:
    row("shapes", f"plymesh, displacement{name}", DISPLACED + GREY + text, settings=settings)
row("shapes", "plymesh, displacement, AreaLightSource", f'{DISPLACED}{GREY}AreaLightSource "diffuse" "rgb L" [1 1 1] "bool twosided" true\n{SHEET} "texture displacement" "h" "float edgelength" 0.1')

# Materials
for name, text in [
    ("diffuse, spectrum", '"diffuse" "spectrum reflectance" [400 0.1 550 0.7 650 0.5 700 0.2]'),
    ("diffuse, spectrum file", f'"diffuse" "spectrum reflectance" "{FILES}/green.spd"'),
    ("conductor, k", '"conductor" "rgb eta" [0.9 0.9 0.9] "rgb k" [2 2 2] "float roughness" 0.2'),
    ("conductor, default", '"conductor"'),
    ("conductor, metal-Al", '"conductor" "spectrum eta" "metal-Al-eta" "spectrum k" "metal-Al-k" "float roughness" 0.2'),
    ("conductor, metal-Cu", '"conductor" "spectrum eta" "metal-Cu-eta" "spectrum k" "metal-Cu-k" "float roughness" 0.2'),
    ("conductor, metal-CuZn", '"conductor" "spectrum eta" "metal-CuZn-eta" "spectrum k" "metal-CuZn-k" "float roughness" 0.2'),
    ("conductor, metal-MgO", '"conductor" "spectrum eta" "metal-MgO-eta" "spectrum k" "metal-MgO-k" "float roughness" 0.2'),
    ("conductor, metal-TiO2", '"conductor" "spectrum eta" "metal-TiO2-eta" "spectrum k" "metal-TiO2-k" "float roughness" 0.2'),
    ("conductor, rough", '"conductor" "rgb reflectance" [0.8 0.6 0.4] "float roughness" 1'),
    ("conductor, remaproughness false", '"conductor" "rgb reflectance" [0.8 0.8 0.8] "float roughness" 0.3 "bool remaproughness" false'),
    ("dielectric, eta", '"dielectric" "float eta" 1.33'),
    ("dielectric, anisotropic", '"dielectric" "float uroughness" 0.1 "float vroughness" 0.5'),
    ("dielectric, rough, remaproughness false", '"dielectric" "float roughness" 0.2 "bool remaproughness" false'),
    ("dielectric, eta below 1", '"dielectric" "float eta" 0.8'),
    ("thindielectric, default", '"thindielectric"'),
    ("diffusetransmission, coloured", '"diffusetransmission" "rgb reflectance" [0.5 0.2 0.1] "rgb transmittance" [0.1 0.3 0.5]'),
    ("diffusetransmission, default", '"diffusetransmission"'),
    ("coateddiffuse, smooth", '"coateddiffuse" "rgb reflectance" [0.5 0.5 0.5] "float roughness" 0'),
    ("coateddiffuse, anisotropic", '"coateddiffuse" "rgb reflectance" [0.5 0.5 0.5] "float uroughness" 0.05 "float vroughness" 0.5'),
    ("coateddiffuse, eta", '"coateddiffuse" "rgb reflectance" [0.5 0.5 0.5] "float eta" 2'),
    ("coateddiffuse, coloured", '"coateddiffuse" "rgb reflectance" [0.6 0.3 0.1] "float roughness" 0.2'),
    ("coateddiffuse, maxdepth", '"coateddiffuse" "rgb reflectance" [0.7 0.7 0.7] "integer maxdepth" 3'),
    ("coateddiffuse, remaproughness false", '"coateddiffuse" "rgb reflectance" [0.5 0.5 0.5] "float roughness" 0.3 "bool remaproughness" false'),
    ("coatedconductor, default", '"coatedconductor"'),
    ("coatedconductor, eta k", '"coatedconductor" "rgb conductor.eta" [0.9 0.9 0.9] "rgb conductor.k" [2 2 2] "float interface.eta" 1.3'),
    ("coatedconductor, thick", '"coatedconductor" "rgb reflectance" [0.8 0.8 0.8] "float thickness" 0.4 "rgb albedo" [0.5 0.5 0.5] "float g" -0.4'),
    ("coatedconductor, anisotropic", '"coatedconductor" "rgb reflectance" [0.8 0.8 0.8] "float conductor.uroughness" 0.1 "float conductor.vroughness" 0.4 "float interface.uroughness" 0.2 "float interface.vroughness" 0.05'),
]:
    metal = name.split("metal-")[-1] in ("Cu", "CuZn")
    material(name, f"Material {text}", spectra=metal)
for glass in ["BAF10", "FK51A", "LASF9", "F5", "F10", "F11"]:
    name = f"glass-{glass}"
    material(f"dielectric, {name}", f'Material "dielectric" "spectrum eta" "{name}"', differs="no dispersion at surfaces of the scene", tolerance=0.015)
ROUGH = 'Texture "r" "float" "checkerboard" "float uscale" 4 "float vscale" 4 "float tex1" 0.05 "float tex2" 0.6\n'
TINT = f'Texture "c" "spectrum" "imagemap" "string filename" "{COLOURS}"\n'
for name, text in [
    ("conductor, texture roughness", ROUGH + 'Material "conductor" "rgb reflectance" [0.8 0.8 0.8] "texture roughness" "r"'),
    ("conductor, texture uroughness", ROUGH + 'Material "conductor" "rgb reflectance" [0.8 0.8 0.8] "texture uroughness" "r" "float vroughness" 0.2'),
    ("conductor, texture reflectance", TINT + 'Material "conductor" "texture reflectance" "c" "float roughness" 0.2'),
    ("dielectric, texture roughness", ROUGH + 'Material "dielectric" "texture roughness" "r"'),
    ("coateddiffuse, texture reflectance", TINT + 'Material "coateddiffuse" "texture reflectance" "c"'),
    ("coateddiffuse, texture roughness", ROUGH + 'Material "coateddiffuse" "rgb reflectance" [0.5 0.5 0.5] "texture roughness" "r"'),
    ("coateddiffuse, texture thickness", ROUGH + 'Material "coateddiffuse" "rgb reflectance" [0.5 0.5 0.5] "texture thickness" "r" "rgb albedo" [0.6 0.6 0.6]'),
    ("coatedconductor, texture roughness", ROUGH + 'Material "coatedconductor" "rgb reflectance" [0.8 0.8 0.8] "texture conductor.roughness" "r"'),
    ("diffusetransmission, texture", TINT + 'Material "diffusetransmission" "texture reflectance" "c" "texture transmittance" "c"'),
    ("mix, texture amount", ROUGH + 'MakeNamedMaterial "a" "string type" "diffuse" "rgb reflectance" [0.1 0.1 0.1]\nMakeNamedMaterial "b" "string type" "diffuse" "rgb reflectance" [0.9 0.9 0.9]\nMaterial "mix" "string materials" ["a" "b"] "texture amount" "r"'),
    ("mix, nested", 'MakeNamedMaterial "a" "string type" "diffuse" "rgb reflectance" [0.1 0.1 0.1]\nMakeNamedMaterial "b" "string type" "conductor" "rgb reflectance" [0.9 0.9 0.9]\nMakeNamedMaterial "c" "string type" "mix" "string materials" ["a" "b"] "float amount" 0.5\nMaterial "mix" "string materials" ["c" "a"] "float amount" 0.4'),
    ("mix, default amount", 'MakeNamedMaterial "a" "string type" "diffuse" "rgb reflectance" [0.1 0.1 0.1]\nMakeNamedMaterial "b" "string type" "dielectric"\nMaterial "mix" "string materials" ["a" "b"]'),
    ("normalmap, conductor", 'Material "conductor" "rgb reflectance" [0.8 0.8 0.8] "float roughness" 0.2 "string normalmap" "@ROOT@/scenes/atelier/knurl.png"'),
    ("normalmap, coateddiffuse", 'Material "coateddiffuse" "rgb reflectance" [0.5 0.5 0.5] "string normalmap" "@ROOT@/scenes/atelier/knurl.png"'),
    ("displacement, conductor", 'Texture "bumps" "float" "wrinkled" "integer octaves" 4\nTexture "low" "float" "scale" "texture tex" "bumps" "float scale" 0.05\nMaterial "conductor" "rgb reflectance" [0.8 0.8 0.8] "float roughness" 0.3 "texture displacement" "low"'),
    ("displacement, imagemap", f'Texture "bumps" "float" "imagemap" {IMAGE} "float scale" 0.02 "float uscale" 2\nMaterial "diffuse" "rgb reflectance" [0.6 0.6 0.6] "texture displacement" "bumps"'),
]:
    material(name, text)

# Textures
FLOOR = "Shape \"bilinearmesh\" \"point3 P\" [-9 -3 0  9 -3 0  -9 40 0  9 40 0]\n"
LOW = 'LookAt 0 -4 0.5  0 0 0.2  0 0 1\nCamera "perspective" "float fov" 36\n'
for name, filters in [("EWA", '"EWA"'), ("EWA, maxanisotropy 2", '"EWA" "float maxanisotropy" 2'), ("EWA, maxanisotropy 32", '"EWA" "float maxanisotropy" 32')]:
    texture(f"imagemap, {name}, grazing floor", f'Texture "t" "spectrum" "imagemap" {IMAGE} "string filter" {filters} "float uscale" 9 "float vscale" 20', use=f'Material "diffuse" "texture reflectance" "t"\n{FLOOR}Material "conductor" "rgb reflectance" [0.8 0.8 0.8] "float roughness" 0', camera=LOW, ground="")
texture("imagemap, EWA, turned floor", f'Texture "t" "spectrum" "imagemap" "string filename" "{COLOURS}" "string filter" "EWA" "float uscale" 9 "float vscale" 20', use=f'Material "diffuse" "texture reflectance" "t"\nAttributeBegin\nRotate 40 0 0 1\n{FLOOR}AttributeEnd', camera=LOW, ground="")
for kind in ["point", "bilinear", "trilinear", "EWA"]:
    texture(f"imagemap, filter {kind}, far", f'Texture "t" "spectrum" "imagemap" {IMAGE} "string filter" "{kind}" "float uscale" 12 "float vscale" 12')
for wrap in ["repeat", "clamp", "black", "octahedralsphere"]:
    texture(f"imagemap, wrap {wrap}", f'Texture "t" "spectrum" "imagemap" "string filename" "{COLOURS}" "string wrap" "{wrap}" "float uscale" 2 "float vscale" 1.5 "float udelta" -0.4')
for name, text in [
    ("imagemap, encoding gamma", f'"imagemap" {IMAGE} "string encoding" "gamma 1.8"'),
    ("imagemap, encoding sRGB", f'"imagemap" {IMAGE} "string encoding" "sRGB"'),
    ("imagemap, vdelta", f'"imagemap" "string filename" "{COLOURS}" "float vdelta" 0.3 "float udelta" 0.1'),
    ("imagemap, maxanisotropy", f'"imagemap" {IMAGE} "string filter" "EWA" "float maxanisotropy" 2 "float uscale" 6'),
    ("imagemap, planar, deltas", f'"imagemap" {IMAGE} "string mapping" "planar" "vector3 v1" [0.5 0 0] "vector3 v2" [0 0.3 0.6] "float udelta" 0.2 "float vdelta" 0.4'),
    ("checkerboard, colours", '"checkerboard" "float uscale" 4 "float vscale" 4 "rgb tex1" [0.9 0.3 0.1] "rgb tex2" [0.1 0.3 0.6]'),
    ("checkerboard, planar", '"checkerboard" "string mapping" "planar" "vector3 v1" [3 0 0] "vector3 v2" [0 0 3] "rgb tex1" [0.9 0.9 0.9] "rgb tex2" [0.1 0.1 0.1]'),
    ("checkerboard, spherical", '"checkerboard" "string mapping" "spherical" "rgb tex1" [0.9 0.9 0.9] "rgb tex2" [0.1 0.1 0.1]'),
    ("dots, colours", '"dots" "float uscale" 5 "float vscale" 5 "rgb inside" [0.8 0.3 0.1] "rgb outside" [0.1 0.3 0.6]'),
    ("marble, octaves roughness", '"marble" "float scale" 2 "float variation" 0.6 "integer octaves" 4 "float roughness" 0.3'),
    ("constant, spectrum", '"constant" "spectrum value" [400 0.1 550 0.7 650 0.5 700 0.2]'),
]:
    texture(name, f'Texture "t" "spectrum" {text}')
texture("checkerboard, textures", f'Texture "a" "spectrum" "imagemap" {IMAGE}\nTexture "t" "spectrum" "checkerboard" "float uscale" 3 "float vscale" 3 "texture tex1" "a" "rgb tex2" [0.2 0.2 0.2]')
texture("checkerboard, 3-D, transformed", 'AttributeBegin\nRotate 30 1 1 0\nScale 0.3 0.3 0.3\nTexture "t" "spectrum" "checkerboard" "integer dimension" 3 "rgb tex1" [0.9 0.9 0.9] "rgb tex2" [0.1 0.1 0.1]\nAttributeEnd')
texture("mix, texture amount", f'Texture "a" "float" "checkerboard" "float uscale" 3 "float vscale" 3 "float tex1" 0.1 "float tex2" 0.9\nTexture "t" "spectrum" "mix" "rgb tex1" [0.1 0.1 0.1] "rgb tex2" [0.9 0.9 0.9] "texture amount" "a"')
texture("mix, textures", f'Texture "a" "spectrum" "imagemap" {IMAGE}\nTexture "b" "spectrum" "constant" "rgb value" [0.7 0.4 0.2]\nTexture "t" "spectrum" "mix" "texture tex1" "a" "texture tex2" "b" "float amount" 0.6')
texture("scale, texture scale", f'Texture "a" "spectrum" "imagemap" {IMAGE}\nTexture "f" "float" "bilerp" "float v00" 0.1 "float v01" 0.9 "float v10" 0.5 "float v11" 0.3\nTexture "t" "spectrum" "scale" "texture tex" "a" "texture scale" "f"')
texture("directionmix, textures", f'Texture "a" "spectrum" "imagemap" {IMAGE}\nTexture "t" "spectrum" "directionmix" "texture tex1" "a" "rgb tex2" [0.2 0.2 0.2] "vector3 dir" [1 0 0]')
for name, settings in [("fbm, octaves roughness", '"fbm" "integer octaves" 4 "float roughness" 0.7'), ("wrinkled, octaves roughness", '"wrinkled" "integer octaves" 3 "float roughness" 0.4')]:
    texture(name, f'Texture "f" "float" {settings}\nTexture "t" "spectrum" "scale" "texture scale" "f" "rgb tex" [0.5 0.5 0.5]')
texture("imagemap of an EXR with chromaticities", f'Texture "t" "spectrum" "imagemap" "string filename" "{FILES}/wide.exr"')

# Lights
for name, text in [
    ("point, default", '"point" "point3 from" [1 -1 2] "float scale" 6'),
    ("point, spectrum", '"point" "spectrum I" [400 1 550 3 700 5] "point3 from" [1 -1 2] "float scale" 8'),
    ("point, blackbody", '"point" "blackbody I" 3000 "point3 from" [1 -1 2] "float scale" 8'),
    ("spot, default cone", '"spot" "point3 from" [0 -1 3] "float scale" 20 "point3 to" [0 0 0]'),
    ("spot, power", '"spot" "point3 from" [1 -1 3] "point3 to" [0 0 0] "float power" 60'),
    ("spot, wide edge", '"spot" "rgb I" [20 20 20] "point3 from" [1 -1 3] "point3 to" [0 0 0] "float coneangle" 40 "float conedeltaangle" 40'),
    ("distant, default", '"distant" "float scale" 2'),
    ("distant, scale", '"distant" "rgb L" [0.7 0.8 0.9] "float scale" 3 "point3 from" [-1 -2 2] "point3 to" [0 0 0]'),
    ("distant, spectrum illuminance", '"distant" "spectrum L" "stdillum-A" "float illuminance" 4 "point3 from" [0 -1 2]'),
    ("infinite, default", '"infinite"'),
    ("infinite, scale", '"infinite" "rgb L" [0.4 0.5 0.6] "float scale" 1.7'),
    ("infinite, blackbody", '"infinite" "blackbody L" 5000'),
    ("infinite, filename, illuminance", f'"infinite" "string filename" "{COLOURS}" "float illuminance" 3'),
]:
    light(name, f"LightSource {text}")
# The sampler bvh of pbrt never chooses a spot without a soft edge.
UNIFORM = 'Integrator "path" "integer maxdepth" 6 "string lightsampler" "uniform"\n'
light("spot, hard edge", 'LightSource "spot" "rgb I" [20 20 20] "point3 from" [1 -1 3] "point3 to" [0 0 0] "float coneangle" 15 "float conedeltaangle" 0', settings=UNIFORM)
for name, transform, text in [
    ("point, transformed", "Translate 1 -1 2\nScale 2 2 2", '"point" "rgb I" [9 9 9]'),
    ("spot, transformed", "Translate 0 -1 3\nRotate 170 1 0 0", '"spot" "rgb I" [20 20 20] "float coneangle" 25'),
    ("distant, transformed", "Rotate 160 1 0.2 0", '"distant" "rgb L" [2 2 2]'),
    ("infinite, filename, rotated", "Rotate 50 1 0 1", f'"infinite" "string filename" "{COLOURS}"'),
    ("infinite, filename, mirrored", "Scale -1 1 1\nRotate 20 0 1 0", f'"infinite" "string filename" "{COLOURS}"'),
    ("projection, power", "Translate 0 -1 3\nRotate -160 1 0 0", f'"projection" "string filename" "{COLOURS}" "float fov" 60 "float power" 40'),
    ("goniometric, power", "Translate 0 -1 3", f'"goniometric" "string filename" "{PICTURE}" "float power" 60'),
    ("goniometric, scale", "Translate 0 -1 3\nRotate 40 0 1 1", f'"goniometric" "string filename" "{COLOURS}" "float scale" 12'),
]:
    light(name, f"AttributeBegin\n{transform}\nLightSource {text}\nAttributeEnd")
# Where pbrt does not sample lights, with the integrator randomwalk, these agree.
PBRT_SAMPLES = {
    "partial disk": ("pbrt samples a partial disk as a whole one", 0.4),
    "stretched sphere": ("pbrt samples a stretched sphere as a round one", 0.7),
}
DISK = 'Translate 0 0 2.6\nRotate 180 1 0 0\nShape "disk" "float radius" 0.7'
for name, emission, text in [
    ("scale", '"rgb L" [2 2 2] "float scale" 3', DISK),
    ("blackbody", '"blackbody L" 4000 "float scale" 5', DISK),
    ("default L", '"float scale" 5', DISK),
    ("spectrum", '"spectrum L" "stdillum-F11" "float scale" 5', DISK),
    ("power, twosided", '"rgb L" [1 1 1] "float power" 40 "bool twosided" true', DISK),
    ("power, blackbody", '"blackbody L" 3000 "float power" 40', DISK),
    ("ReverseOrientation", '"rgb L" [5 5 5]', 'ReverseOrientation\nTranslate 0 0 2.6\nShape "disk" "float radius" 0.7'),
    ("partial disk", '"rgb L" [9 9 9]', 'Translate 0 0 2.6\nRotate 180 1 0 0\nShape "disk" "float radius" 0.7 "float innerradius" 0.2 "float phimax" 200'),
    ("partial sphere", '"rgb L" [9 9 9]', 'Translate 0 0 2.4\nShape "sphere" "float radius" 0.5 "float zmax" 0.2'),
    ("stretched sphere", '"rgb L" [9 9 9]', 'Translate 0 0 2.4\nScale 1 0.6 0.5\nShape "sphere" "float radius" 0.5'),
    ("trianglemesh", '"rgb L" [8 8 8] "bool twosided" true', 'Shape "trianglemesh" "point3 P" [-0.8 -0.8 2.5  0.8 -0.8 2.5  0 0.9 2.9]'),
    ("alpha", '"rgb L" [9 9 9]', DISK + ' "float alpha" 0.5'),
    ("filename, scale", f'"string filename" "{COLOURS}" "float scale" 9', 'Shape "bilinearmesh" "point3 P" [-1 -1 3  -1 1 3  1 -1 3  1 1 3] "point2 uv" [0 0  1 0  0 1  1 1]'),
    ("filename, power", f'"string filename" "{COLOURS}" "float power" 60', 'Shape "bilinearmesh" "point3 P" [-1 -1 3  -1 1 3  1 -1 3  1 1 3]'),
]:
    why, most = PBRT_SAMPLES.get(name, ("", 0.01))
    light(f"diffuse, {name}", f'AttributeBegin\nAreaLightSource "diffuse" {emission}\n{text}\nAttributeEnd', differs=why, tolerance=most)
light("two of each kind", f'LightSource "infinite" "rgb L" [0.1 0.1 0.2]\nLightSource "infinite" "string filename" "{COLOURS}" "float scale" 0.3\nLightSource "point" "rgb I" [3 3 3] "point3 from" [1 -1 3]\nLightSource "distant" "rgb L" [0.5 0.5 0.5] "point3 from" [1 -1 2]\nLightSource "distant" "rgb L" [0.3 0.4 0.5] "point3 from" [-1 -1 2]')
light("inside an object, ignored", 'LightSource "infinite" "rgb L" [0.3 0.3 0.3]\nObjectBegin "o"\nAreaLightSource "diffuse" "rgb L" [6 6 6]\nShape "disk" "float height" 1.8 "float radius" 0.4\nObjectEnd\nObjectInstance "o"')

# Spectra
for name in ["stdillum-A", "stdillum-D50", "illum-acesD60", "stdillum-F1", "stdillum-F4", "stdillum-F9", "stdillum-F12"]:
    odd = "pbrt's table of D50 has another colour than the CIE's" if name == "stdillum-D50" else ""
    row("spectra", name, GREY + BALL, lights=f'LightSource "infinite" "spectrum L" "{name}"\n', differs=odd, tolerance=0.1 if odd else 0.01)
for kelvin in [2200, 2700, 10000]:
    row("spectra", f"blackbody {kelvin}", GREY + BALL, lights=f'LightSource "infinite" "blackbody L" {kelvin}\n')
row("spectra", "wavelengths and values", GREY + BALL, lights='LightSource "infinite" "spectrum L" [360 1 500 0.4 600 2 830 1]\n')
row("spectra", "file", GREY + BALL, lights=f'LightSource "infinite" "spectrum L" "{FILES}/green.spd"\n')
row("spectra", "of light and surface", 'Material "diffuse" "spectrum reflectance" [400 0.2 500 0.4 600 0.6 700 0.7]\n' + BALL, lights='LightSource "infinite" "spectrum L" "stdillum-A"\n', spectra=True)

# Cameras
for name, text in [
    ("perspective, fov 20", '"perspective" "float fov" 20'),
    ("perspective, fov 100", '"perspective" "float fov" 100'),
    ("perspective, lens, near", '"perspective" "float fov" 40 "float lensradius" 0.3 "float focaldistance" 2.5'),
    ("perspective, screenwindow and frameaspectratio", '"perspective" "float fov" 40 "float frameaspectratio" 2 "float screenwindow" [-1 1 -1 1]'),
    ("orthographic, default", '"orthographic"'),
    ("orthographic, frameaspectratio", '"orthographic" "float frameaspectratio" 1.4'),
]:
    row("cameras", name, WORLD, camera=f"{LOOK}Camera {text}\n")
REALISTIC = f'{LOOK}Camera "realistic" "string lensfile" "@ROOT@/lenses/%s" "float aperturediameter" %s "float focusdistance" 2\n'
SENSOR = 'Film "rgb" "integer xresolution" 32 "integer yresolution" 32 "float diagonal" %s\n'
for name in ["gaussian", "pentagon", "star"]:
    camera = REALISTIC % ("dgauss.50mm.dat", "14")
    row("cameras", f"realistic, aperture {name}", WORLD, camera=camera.rstrip() + f' "string aperture" "{name}"\n', film=SENSOR % 40)
SQUARE_STOP = (REALISTIC % ("dgauss.50mm.dat", "14")).rstrip() + ' "string aperture" "square"\n'
row("cameras", "realistic, aperture square", WORLD, camera=SQUARE_STOP, film=SENSOR % 40, differs="pbrt samples the pupil in bounds that turn with the film point, and loses the corners of the square", tolerance=0.12)
for lens, diameter, diagonal in [("wide.22mm.dat", "5", 30), ("telephoto.250mm.dat", "20", 40), ("fisheye.10mm.dat", "4", 12)]:
    row("cameras", f"realistic, {lens}", WORLD, camera=REALISTIC % (lens, diameter), film=SENSOR % diagonal)
row("cameras", "perspective, wide picture", WORLD, film='Film "rgb" "integer xresolution" 48 "integer yresolution" 16\n')
row("cameras", "perspective, tall picture", WORLD, film='Film "rgb" "integer xresolution" 16 "integer yresolution" 48\n')
row("cameras", "mirrored", WORLD, camera=f'Scale -1 1 1\n{LOOK}Camera "perspective" "float fov" 36\n')
row("cameras", "turned", WORLD, camera=f'Rotate 20 0 0 1\nTranslate 0.2 -0.1 0\n{LOOK}Camera "perspective" "float fov" 36\n')
row("cameras", "moving", WORLD, camera=f'{LOOK}ActiveTransform EndTime\nTranslate 0.6 0 0\nActiveTransform All\nCamera "perspective" "float fov" 36\n')

# Filters
for name, text in [("box", ""), ("box", '"float xradius" 1.5 "float yradius" 1'), ("triangle", ""), ("gaussian", ""), ("gaussian", '"float sigma" 1 "float xradius" 3 "float yradius" 2'), ("mitchell", ""), ("mitchell", '"float B" 0 "float C" 0.5'), ("sinc", ""), ("sinc", '"float tau" 2')]:
    label = ", ".join([name, " ".join(text.replace('"float ', "").replace('"', "").split()) or "default"])
    row("filters", label, WORLD, settings=f'PixelFilter "{name}" {text}\n')

# Samplers and integrators
for name in ["independent", "halton", "sobol", "paddedsobol", "zsobol", "pmj02bn"]:
    row("samplers", name, WORLD, settings=f'Sampler "{name}" "integer pixelsamples" 64 "integer seed" 3\n')
row("samplers", "stratified", WORLD, settings='Sampler "stratified" "integer xsamples" 8 "integer ysamples" 8 "bool jitter" true\n')
for name in ["owen", "fastowen", "permutedigits", "none"]:
    row("samplers", f"sobol, randomization {name}", WORLD, settings=f'Sampler "sobol" "string randomization" "{name}"\n')
for name, text in [
    ("path, maxdepth 0", '"path" "integer maxdepth" 0'),
    ("path, maxdepth 1", '"path" "integer maxdepth" 1'),
    ("path, maxdepth 2", '"path" "integer maxdepth" 2'),
    ("path, default", '"path"'),
    ("path, lightsampler uniform", '"path" "string lightsampler" "uniform"'),
    ("path, lightsampler power", '"path" "string lightsampler" "power"'),
    ("volpath", '"volpath" "integer maxdepth" 4'),
    ("simplepath", '"simplepath" "integer maxdepth" 4'),
    ("randomwalk", '"randomwalk" "integer maxdepth" 3'),
    ("bdpt", '"bdpt" "integer maxdepth" 4'),
]:
    row("integrators", name, WORLD, settings=f"Integrator {text}\n")
GLASS = 'Material "dielectric"\n'
REGULAR = 'Integrator "path" "integer maxdepth" 6 "bool regularize" true\n'
row("integrators", "path, regularize, glass", GLASS + BALL, settings=REGULAR)
row("integrators", "path, regularize, metal", 'Material "conductor" "float roughness" 0.01\n' + BALL, settings=REGULAR)
row("integrators", "path, regularize, coats", 'Material "coateddiffuse" "rgb reflectance" [0.7 0.7 0.7] "float roughness" 0\n' + BALL, settings=REGULAR)
row("integrators", "path, regularize, mirror behind glass", f'{GLASS}{BALL}Material "conductor" "rgb reflectance" [0.9 0.9 0.9]\nTranslate 1 0.3 -0.3\nShape "sphere" "float radius" 0.3\n', settings=REGULAR)
MIRROR = 'Material "conductor" "rgb reflectance" [0.9 0.9 0.9]\n'
row("integrators", "path, maxdepth 2, mirror", MIRROR + BALL, settings='Integrator "path" "integer maxdepth" 2\n')

# Transforms
for name, text in [
    ("Identity", "Translate 5 5 5\nIdentity\n" + UP),
    ("Scale, mirrored", UP + "Scale -1 0.8 1.2\nRotate 30 0 1 0\n"),
    ("Rotate about three axes", UP + "Rotate 40 1 0 0\nRotate 30 0 1 0\nRotate 20 0 0 1\nScale 1 0.5 0.8\n"),
    ("LookAt in the world", "LookAt 0.3 0.2 0.5  1 0 0.8  0 0 1\nScale 1 0.5 0.7\n"),
    ("CoordSysTransform camera", 'CoordSysTransform "camera"\nTranslate 0 0 4.2\nScale 1 0.6 0.8\n'),
    ("AttributeBegin, nested", UP + "AttributeBegin\nTranslate 9 9 9\nAttributeBegin\nScale 3 3 3\nAttributeEnd\nAttributeEnd\n"),
    ("TransformTimes", "TransformTimes 0.2 0.8\n" + UP + "ActiveTransform EndTime\nTranslate 0.5 0 0\nActiveTransform All\n"),
    ("ActiveTransform, moving", UP + "ActiveTransform EndTime\nTranslate 0.6 0 0.2\nActiveTransform All\n"),
    ("ActiveTransform, turning", UP + "ActiveTransform EndTime\nRotate 70 0 1 0\nActiveTransform All\nScale 1 0.6 0.3\n"),
    ("ActiveTransform, growing", UP + "ActiveTransform EndTime\nScale 1.5 1.5 1.5\nActiveTransform All\n"),
]:
    before = text.startswith("TransformTimes")
    times, text = text.split("\n", 1) if before else ("", text)
    row("transforms", name, GREY + text + 'Shape "sphere" "float radius" 0.6\n', camera=(times + "\n" if times else "") + CAMERA)

# Structure
for name, text in [
    ("Include", f'Include "{FILES}/part.pbrt"\n{GREY}{BALL}'),
    ("Include, transformed", f'Scale 1.2 1.2 1.2\nRotate 100 0 0 1\nInclude "{FILES}/part.pbrt"\n'),
    ("Import", f'Import "{FILES}/part.pbrt"\n{GREY}{BALL}'),
    ("Import, transformed", f'AttributeBegin\nTranslate -0.5 0 0\nImport "{FILES}/part.pbrt"\nAttributeEnd\n{GREY}{BALL}'),
    ("Attribute material", 'Attribute "material" "rgb reflectance" [0.6 0.2 0.1]\nMaterial "diffuse"\n' + BALL),
    ("Attribute light", 'Attribute "light" "float scale" 3\nLightSource "point" "point3 from" [1 -1 2]\n' + GREY + BALL),
    ("Attribute texture", 'Attribute "texture" "float uscale" 5 "float vscale" 5\nTexture "t" "spectrum" "checkerboard" "rgb tex1" [0.9 0.9 0.9] "rgb tex2" [0.1 0.1 0.1]\nMaterial "diffuse" "texture reflectance" "t"\n' + BALL),
    ("Attribute, in a block", 'AttributeBegin\nAttribute "shape" "float radius" 0.3\nAttributeEnd\n' + GREY + UP + 'Shape "sphere"\n'),
    ("NamedMaterial in a block", 'MakeNamedMaterial "m" "string type" "diffuse" "rgb reflectance" [0.7 0.2 0.1]\nAttributeBegin\nNamedMaterial "m"\nAttributeEnd\n' + GREY + BALL),
    ("default material", BALL),
    ("ObjectInstance, nested transforms", f'{GREY}Translate 0 0 0.1\nObjectBegin "o"\nTranslate 0 0 0.4\nScale 0.5 0.5 0.5\nShape "sphere"\nObjectEnd\nRotate 50 0 0 1\nTranslate 0.5 0 0\nObjectInstance "o"\nScale -1 1 1.5\nTranslate 1 0 0\nObjectInstance "o"\n'),
    ("ObjectInstance, several shapes", f'{GREY}ObjectBegin "o"\nShape "sphere" "float radius" 0.3\nMaterial "conductor"\nTranslate 0 0 0.5\nShape "disk" "float radius" 0.5\nShape "trianglemesh" {TETRAHEDRON}\nObjectEnd\nTranslate -0.4 0 0.3\nScale 0.6 0.6 0.6\nObjectInstance "o"\nTranslate 1.5 0 0\nObjectInstance "o"\n'),
    ("ObjectInstance, moving", f'{GREY}ObjectBegin "o"\nShape "sphere" "float radius" 0.5\nObjectEnd\n{UP}ActiveTransform EndTime\nTranslate 0.6 0 0.2\nActiveTransform All\nObjectInstance "o"\n'),
    ("ObjectInstance, textured", f'{GRID}ObjectBegin "o"\nShape "sphere" "float radius" 0.5\nObjectEnd\n{UP}Scale 1 0.6 1.2\nObjectInstance "o"\n'),
    ("ColorSpace of lights", 'AttributeBegin\nColorSpace "rec2020"\nLightSource "point" "rgb I" [3 2 1] "point3 from" [1 -1 2]\nAttributeEnd\n' + GREY + BALL),
    ("ColorSpace dci-p3 of a texture", f'ColorSpace "dci-p3"\nTexture "t" "spectrum" "bilerp" "rgb v00" [0.5 0.3 0.3] "rgb v01" [0.3 0.5 0.3] "rgb v10" [0.3 0.3 0.5] "rgb v11" [0.5 0.5 0.3]\nMaterial "diffuse" "texture reflectance" "t"\n' + BALL),
    ("ReverseOrientation of a patch", f'{GREY}ReverseOrientation\nShape "bilinearmesh" {SQUARE}\n'),
    ("comments and spacing", f'# a comment\n{GREY.strip()} # another\n\n\tTranslate 0 0\n0.6 Shape "sphere"\n"float radius" [ 0.6 ]# end\n'),
]:
    row("structure", name, text)
for name, settings in [
    ("Option seed", 'Option "seed" 5\n'),
    ("Option disablepixeljitter false", 'Option "disablepixeljitter" false\n'),
    ("Option rendercoordsys", 'Option "rendercoordsys" "world"\n'),
    ("Accelerator", 'Accelerator "bvh" "string splitmethod" "middle"\n'),
]:
    row("structure", name, WORLD, camera=settings + CAMERA)

# Films
for name, text in [
    ("diagonal", '"float diagonal" 20'),
    ("iso 25", '"float iso" 25'),
    ("cropwindow at an edge", '"float cropwindow" [0 0.5 0 1]'),
]:
    row("films", f"rgb, {name}", WORLD, film=FILM.strip() + f" {text}\n")
for name in ["camera", "world"]:
    row("films", f"gbuffer, coordinatesystem {name}", WORLD, film=FILM.replace('"rgb"', '"gbuffer"').strip() + f' "string coordinatesystem" "{name}"\n')
row("films", "spectral", WORLD, film=FILM.replace('"rgb"', '"spectral"').strip() + ' "integer nbuckets" 8\n')
