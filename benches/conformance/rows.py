"""Rows of the conformance table: one small scene for each part of pbrt-v4's language."""

from dataclasses import dataclass

CAMERA = """LookAt 0 -4 1.6  0 0 0.45  0 0 1
Camera "perspective" "float fov" 36
"""
FILM = 'Film "rgb" "integer xresolution" 32 "integer yresolution" 32\n'
INTEGRATOR = 'Integrator "path" "integer maxdepth" 6\n'
VOLUME_INTEGRATOR = 'Integrator "volpath" "integer maxdepth" 6\n'
GROUND = """AttributeBegin
Material "diffuse" "rgb reflectance" [0.5 0.5 0.5]
Shape "bilinearmesh" "point3 P" [-4 -4 0  4 -4 0  -4 4 0  4 4 0]
AttributeEnd
"""
LIGHTS = """LightSource "infinite" "rgb L" [0.3 0.3 0.3]
AttributeBegin
AreaLightSource "diffuse" "rgb L" [6 6 6]
Shape "bilinearmesh" "point3 P" [-1 -1 3  -1 1 3  1 -1 3  1 1 3]
AttributeEnd
"""
GREY = 'Material "diffuse" "rgb reflectance" [0.6 0.6 0.6]\n'
BALL = 'Translate 0 0 0.6\nShape "sphere" "float radius" 0.6\n'
# A picture of the repository; the reader of the table puts its folder in place of @ROOT@.
PICTURE = "@ROOT@/scenes/grid.png"
# A square picture in colour, without symmetry.
COLOURS = "@ROOT@/tests/pbrt_language/colours.png"


@dataclass(frozen=True)
class Row:
    group: str
    name: str
    scene: str
    # Why the picture differs from pbrt's, and by how much at most; or what is not supported.
    differs: str = ""
    tolerance: float = 0.01
    missing: str = ""
    # Whether paths of petzval carry wavelengths (`--effects +spectra`).
    spectra: bool = False


ROWS = []


def row(group, name, world, camera=CAMERA, film=FILM, integrator=INTEGRATOR, settings="", lights=LIGHTS, ground=GROUND, **more):
    """Adds a row. `settings` are directives before WorldBegin that come after the film."""
    scene = camera + film + integrator + settings + "WorldBegin\n" + lights + ground + world
    ROWS.append(Row(group, name, scene, **more))


def shape(name, text, **more):
    row("shapes", name, GREY + text, **more)


def material(name, text, **more):
    row("materials", name, text + "\n" + BALL, **more)


def texture(name, text, use='Material "diffuse" "texture reflectance" "t"', **more):
    row("textures", name, text + "\n" + use + "\n" + BALL, **more)


def light(name, text, **more):
    row("lights", name, GREY + BALL, lights=text + "\n", **more)


def media(name, text, **more):
    row("media", name, text, **({"integrator": VOLUME_INTEGRATOR} | more))


# Shapes
shape("sphere", BALL)
shape("sphere, zmin zmax phimax", 'Translate 0 0 0.6\nShape "sphere" "float radius" 0.6 "float zmin" -0.3 "float zmax" 0.4 "float phimax" 250')
shape("cylinder", 'Translate 0 0 0.5\nShape "cylinder" "float radius" 0.5 "float zmin" -0.4 "float zmax" 0.5 "float phimax" 270')
shape("disk", 'Translate 0 0 0.5\nRotate 30 1 0 0\nShape "disk" "float radius" 0.7 "float innerradius" 0.2 "float phimax" 300')
TETRAHEDRON = '"point3 P" [0 0 1.2  -0.8 -0.5 0.1  0.8 -0.5 0.1  0 0.8 0.1] "integer indices" [0 1 2  0 2 3  0 3 1]'
shape("trianglemesh", f'Shape "trianglemesh" {TETRAHEDRON}')
shape("trianglemesh, N", f'Shape "trianglemesh" {TETRAHEDRON} "normal N" [0 0 1  -0.7 -0.5 0.5  0.7 -0.5 0.5  0 0.7 0.7]')
shape("plymesh", 'Translate 0 0 0.5\nScale 8 8 8\nShape "plymesh" "string filename" "@ROOT@/scenes/atelier/barrel.ply.gz"')
shape("bilinearmesh, flat", 'Shape "bilinearmesh" "point3 P" [-0.8 0 0  0.8 0 0  -0.8 0 1  0.8 0 1]')
shape("bilinearmesh, twisted", 'Shape "bilinearmesh" "point3 P" [-0.8 0 0.1  0.8 0.6 0.1  -0.8 0.7 1  0.8 -0.8 1.2]')
shape("bilinearmesh, N", 'Shape "bilinearmesh" "point3 P" [-0.8 0 0.1  0.8 0.6 0.1  -0.8 0.7 1  0.8 -0.8 1.2] "normal N" [-0.5 -1 0  0.5 -1 0  -0.5 -1 0.3  0.5 -1 0.3]')
shape("loopsubdiv", 'Translate 0 0 0.5\nShape "loopsubdiv" "integer levels" 3 "point3 P" [0 0 0.8  -0.8 -0.5 -0.3  0.8 -0.5 -0.3  0 0.8 -0.3] "integer indices" [0 1 2  0 2 3  0 3 1  1 3 2]')
CURVE = '"point3 P" [-0.9 0 0.2  -0.3 -0.5 1.3  0.4 0.5 -0.1  0.9 0 0.9]'
shape("curve, flat", f'Shape "curve" {CURVE} "float width" 0.3')
shape("curve, cylinder", f'Shape "curve" {CURVE} "string type" "cylinder" "float width0" 0.3 "float width1" 0.1')
shape("curve, ribbon", f'Shape "curve" {CURVE} "string type" "ribbon" "float width" 0.3 "normal N" [0 -1 0  0.3 -1 0]')
SPLINE = '"string basis" "bspline" "point3 P" [-1.9 0 0.2  -0.9 -0.5 1  -0.3 0.3 0.4  0.4 0.2 1.2  0.8 0 0.3  1.6 0 0.9]'
shape("curve, bspline", f'Shape "curve" {SPLINE} "float width" 0.2')
shape("curve, quadratic bspline", f'Shape "curve" {SPLINE} "integer degree" 2 "string type" "cylinder" "float width" 0.2')
shape("curve, quadratic bezier", 'Shape "curve" "integer degree" 2 "point3 P" [-0.9 0 0.2  -0.5 -0.5 1.3  0 0 0.6  0.4 0.5 -0.1  0.9 0 0.9] "float width" 0.2')
shape("curve, Scale", f'Scale 1 1.5 0.6\nShape "curve" {CURVE} "string type" "cylinder" "float width" 0.3')
shape("curve, mirrored", f'Scale -1 1 1\nShape "curve" {CURVE} "string type" "cylinder" "float width" 0.3')
shape("curve, ObjectInstance", f'ObjectBegin "o"\nShape "curve" {SPLINE} "string type" "cylinder" "float width" 0.2\nObjectEnd\nObjectInstance "o"\nRotate 40 0 0 1\nScale 0.7 1.2 1.2\nObjectInstance "o"')
shape("curve, alpha", f'Shape "curve" {CURVE} "float width" 0.3 "float alpha" 0.5')
shape("ReverseOrientation", f"ReverseOrientation\n{BALL}")
shape("alpha", 'Translate 0 0 0.6\nShape "sphere" "float radius" 0.6 "float alpha" 0.5')
shape("ObjectInstance", f'ObjectBegin "o"\n{BALL}ObjectEnd\nScale 0.5 0.5 0.5\nObjectInstance "o"\nTranslate 1.4 0 0\nScale 1 0.6 1.5\nObjectInstance "o"')

# Materials
material("diffuse", GREY)
material("diffuse, coloured", 'Material "diffuse" "rgb reflectance" [0.7 0.3 0.1]')
material("coateddiffuse", 'Material "coateddiffuse" "rgb reflectance" [0.5 0.5 0.5]')
material("coateddiffuse, rough and thick", 'Material "coateddiffuse" "rgb reflectance" [0.5 0.5 0.5] "float roughness" 0.4 "float thickness" 0.1 "float eta" 1.7')
material("coateddiffuse, absorbing coat", 'Material "coateddiffuse" "rgb reflectance" [0.6 0.6 0.6] "float thickness" 0.5 "rgb albedo" [0.4 0.4 0.4] "float g" 0.5 "integer maxdepth" 20 "integer nsamples" 4')
material("conductor, metal-Au", 'Material "conductor" "spectrum eta" "metal-Au-eta" "spectrum k" "metal-Au-k" "float roughness" 0.1', spectra=True)
material("conductor, metal-Ag", 'Material "conductor" "spectrum eta" "metal-Ag-eta" "spectrum k" "metal-Ag-k" "float roughness" 0.3')
material("conductor, smooth", 'Material "conductor" "rgb reflectance" [0.8 0.8 0.8] "float roughness" 0')
material("conductor, anisotropic", 'Material "conductor" "rgb reflectance" [0.8 0.8 0.8] "float uroughness" 0.05 "float vroughness" 0.4 "bool remaproughness" false')
material("coatedconductor", 'Material "coatedconductor" "rgb reflectance" [0.7 0.7 0.7] "float interface.roughness" 0.1 "float conductor.roughness" 0.3')
material("dielectric", 'Material "dielectric"')
material("dielectric, rough", 'Material "dielectric" "float roughness" 0.3 "float eta" 1.6')
material("dielectric, glass-BK7", 'Material "dielectric" "spectrum eta" "glass-BK7"', differs="no dispersion at surfaces of the scene", tolerance=0.015)
material("thindielectric", 'Material "thindielectric" "float eta" 1.8')
material("diffusetransmission", 'Material "diffusetransmission" "rgb reflectance" [0.3 0.3 0.3] "rgb transmittance" [0.4 0.4 0.4] "float scale" 0.9')
material("mix", 'MakeNamedMaterial "a" "string type" "diffuse" "rgb reflectance" [0.1 0.1 0.1]\nMakeNamedMaterial "b" "string type" "conductor" "rgb reflectance" [0.9 0.9 0.9] "float roughness" 0.2\nMaterial "mix" "string materials" ["a" "b"] "float amount" 0.3')
material("interface", 'Material "interface"')
material("displacement", 'Texture "bumps" "float" "checkerboard" "float uscale" 8 "float vscale" 8 "float tex1" 0 "float tex2" 0.01\nMaterial "diffuse" "rgb reflectance" [0.6 0.6 0.6] "texture displacement" "bumps"')
material("normalmap", f'Material "diffuse" "rgb reflectance" [0.6 0.6 0.6] "string normalmap" "@ROOT@/scenes/atelier/knurl.png"')
MEASURED = "@ROOT@/tests/pbrt_language"
material("measured, isotropic", f'Material "measured" "string filename" "{MEASURED}/isotropic.bsdf"')
material("measured, anisotropic", f'Material "measured" "string filename" "{MEASURED}/anisotropic.bsdf"')
material("measured, normalmap", f'Material "measured" "string filename" "{MEASURED}/isotropic.bsdf" "string normalmap" "@ROOT@/scenes/atelier/knurl.png"')
material("hair", 'Material "hair"')
# Hairs thick enough for a few pixels.
LOCK = "".join(
    f'Shape "curve" "string type" "{("flat", "cylinder")[i % 2]}" "float width0" 0.12 "float width1" 0.06 '
    f'"point3 P" [{x:.2f} 0 1.3  {x - 0.2:.2f} -0.4 0.9  {x + 0.3:.2f} {-0.3 + 0.05 * i:.2f} 0.5  {x:.2f} 0.2 0.1]\n'
    for i, x in enumerate(k * 0.18 - 0.8 for k in range(10))
)


def hair(name, text, **more):
    row("materials", f"hair, {name}", f'Material "hair" {text}\n{LOCK}', **more)


hair("eumelanin", '"float eumelanin" 0.3')
hair("pheomelanin", '"float pheomelanin" 0.8 "float eumelanin" 0.1')
hair("reflectance", '"rgb reflectance" [0.7 0.5 0.3]')
hair("sigma_a", '"rgb sigma_a" [0.05 0.1 0.3] "float eta" 1.4')
hair("smooth", '"rgb sigma_a" [0.1 0.1 0.1] "float beta_m" 0.1 "float beta_n" 0.15 "float alpha" 4')
hair("rough", '"rgb sigma_a" [0 0 0] "float beta_m" 0.8 "float beta_n" 0.9 "float alpha" 0')
PROBES = "a random walk keeps light that the probe rays of pbrt lose"
material("subsurface", 'Material "subsurface" "rgb reflectance" [0.5 0.5 0.5] "rgb mfp" [0.1 0.1 0.1]', integrator=VOLUME_INTEGRATOR, differs=PROBES, tolerance=0.2)
material("subsurface, sigma", 'Material "subsurface" "rgb sigma_a" [0.5 1 2] "rgb sigma_s" [20 20 20] "float eta" 1.4', integrator=VOLUME_INTEGRATOR, differs=PROBES, tolerance=0.2)

# Textures
IMAGE = f'"string filename" "{PICTURE}"'
texture("constant", 'Texture "t" "spectrum" "constant" "rgb value" [0.3 0.3 0.3]')
texture("scale", 'Texture "c" "spectrum" "constant" "rgb value" [0.8 0.8 0.8]\nTexture "t" "spectrum" "scale" "texture tex" "c" "float scale" 0.4')
texture("mix", 'Texture "t" "spectrum" "mix" "rgb tex1" [0.1 0.1 0.1] "rgb tex2" [0.9 0.9 0.9] "float amount" 0.3')
texture("directionmix", 'Texture "t" "spectrum" "directionmix" "rgb tex1" [0.1 0.1 0.1] "rgb tex2" [0.9 0.9 0.9] "vector3 dir" [0 -0.6 0.8]')
texture("bilerp", 'Texture "t" "spectrum" "bilerp" "rgb v00" [0.1 0.1 0.1] "rgb v01" [0.9 0.9 0.9] "rgb v10" [0.5 0.5 0.5] "rgb v11" [0.3 0.3 0.3]')
texture("checkerboard", 'Texture "t" "spectrum" "checkerboard" "float uscale" 6 "float vscale" 5 "rgb tex1" [0.9 0.9 0.9] "rgb tex2" [0.1 0.1 0.1]')
texture("checkerboard, 3-D", 'Texture "t" "spectrum" "checkerboard" "integer dimension" 3 "rgb tex1" [0.9 0.9 0.9] "rgb tex2" [0.1 0.1 0.1]')
texture("imagemap", f'Texture "t" "spectrum" "imagemap" {IMAGE}')
texture("imagemap, coloured", 'Texture "t" "spectrum" "imagemap" "string filename" "@ROOT@/scenes/atelier/leaf.png"')
texture("imagemap, scale invert", f'Texture "t" "spectrum" "imagemap" {IMAGE} "float scale" 0.6 "bool invert" true "float uscale" 3 "float vscale" 2')
texture("imagemap, linear clamp", f'Texture "t" "spectrum" "imagemap" {IMAGE} "string encoding" "linear" "string wrap" "clamp" "float udelta" 0.3')
texture("imagemap, trilinear", f'Texture "t" "spectrum" "imagemap" {IMAGE} "string filter" "trilinear" "float uscale" 4')
texture("imagemap, ewa", f'Texture "t" "spectrum" "imagemap" {IMAGE} "string filter" "ewa" "float uscale" 4')
texture("imagemap, planar", f'Texture "t" "spectrum" "imagemap" {IMAGE} "string mapping" "planar" "vector3 v1" [1 0 0] "vector3 v2" [0 0 1]')
texture("imagemap, spherical", f'Texture "t" "spectrum" "imagemap" {IMAGE} "string mapping" "spherical"')
texture("imagemap, cylindrical", f'Texture "t" "spectrum" "imagemap" {IMAGE} "string mapping" "cylindrical"')
for name, settings in [
    ("dots", '"rgb inside" [0.9 0.9 0.9] "rgb outside" [0.2 0.2 0.2] "float uscale" 8 "float vscale" 6'),
    ("marble", '"float scale" 3 "float variation" 0.3'),
]:
    texture(name, f'Texture "t" "spectrum" "{name}" {settings}')
for name in ["fbm", "wrinkled", "windy"]:
    texture(name, f'Texture "f" "float" "{name}"\nTexture "t" "spectrum" "scale" "texture scale" "f" "rgb tex" [0.5 0.5 0.5]')

texture("hair, eumelanin", 'Texture "t" "float" "checkerboard" "float uscale" 6 "float vscale" 5 "float tex1" 0 "float tex2" 2', use='Material "hair" "texture eumelanin" "t"')
# Lights
light("infinite", 'LightSource "infinite" "rgb L" [0.8 0.8 0.8]')
light("infinite, illuminance", 'LightSource "infinite" "rgb L" [1 1 1] "float illuminance" 2')
light("infinite, filename", f'LightSource "infinite" "string filename" "{COLOURS}" "float scale" 0.7')
# A wall with a window of 2 x 1, behind which is the sky.
WALL = GREY + 'Shape "bilinearmesh" "point3 P" [-4 2 0  4 2 0  -4 2 0.5  4 2 0.5]\nShape "bilinearmesh" "point3 P" [-4 2 1.5  4 2 1.5  -4 2 4  4 2 4]\nShape "bilinearmesh" "point3 P" [-4 2 0.5  -1 2 0.5  -4 2 1.5  -1 2 1.5]\nShape "bilinearmesh" "point3 P" [1 2 0.5  4 2 0.5  1 2 1.5  4 2 1.5]\n'
PORTAL = '"point3 portal" [-1 2 0.5  1 2 0.5  1 2 1.5  -1 2 1.5]'
row("lights", "infinite, portal", WALL + BALL, lights=f'LightSource "infinite" "string filename" "{COLOURS}" {PORTAL} "float scale" 3\n')
row("lights", "infinite, portal, rotated", WALL + BALL, lights=f'AttributeBegin\nRotate 70 0 0 1\nRotate 40 1 0 0\nLightSource "infinite" "string filename" "{COLOURS}" {PORTAL} "float illuminance" 5\nAttributeEnd\n')
row("lights", "infinite, portal, L", WALL + BALL, lights=f'LightSource "infinite" "rgb L" [0.03 0.02 0.01] {PORTAL}\n')
row("lights", "infinite, portal, open scene", GREY + BALL, lights=f'LightSource "infinite" "string filename" "{COLOURS}" {PORTAL} "float scale" 3\n')
row("lights", "infinite, portal and area light", WALL + BALL, lights=f'LightSource "infinite" "string filename" "{COLOURS}" {PORTAL}\nAttributeBegin\nAreaLightSource "diffuse" "rgb L" [6 6 6]\nShape "disk" "float height" 3 "float radius" 0.3\nAttributeEnd\n')
light("point", 'LightSource "point" "rgb I" [9 9 9] "point3 from" [1 -1 3]')
light("point, power", 'LightSource "point" "rgb I" [1 1 1] "float power" 100 "point3 from" [1 -1 3]')
light("spot", 'LightSource "spot" "rgb I" [20 20 20] "point3 from" [1 -1 3] "point3 to" [0 0 0] "float coneangle" 20 "float conedeltaangle" 8')
light("projection", f'AttributeBegin\nTranslate 0 -1 3\nRotate -160 1 0 0\nLightSource "projection" "string filename" "{COLOURS}" "float fov" 50 "float scale" 20\nAttributeEnd')
light("goniometric", f'AttributeBegin\nTranslate 0 -1 3\nLightSource "goniometric" "string filename" "{PICTURE}" "rgb I" [9 9 9]\nAttributeEnd')
light("distant", 'LightSource "distant" "rgb L" [2 2 2] "point3 from" [1 -1 2] "point3 to" [0 0 0]')
light("distant, illuminance", 'LightSource "distant" "rgb L" [1 1 1] "float illuminance" 3 "point3 from" [1 -1 2]')
light("distant, blackbody", 'LightSource "distant" "blackbody L" 6500 "float scale" 2 "point3 from" [1 -1 2]')
light("diffuse, twosided", 'AttributeBegin\nAreaLightSource "diffuse" "rgb L" [5 5 5] "bool twosided" true\nShape "disk" "float height" 2.5 "float radius" 0.7\nAttributeEnd')
light("diffuse, power", 'AttributeBegin\nTranslate 0 0 2.5\nAreaLightSource "diffuse" "rgb L" [1 1 1] "float power" 60\nShape "sphere" "float radius" 0.4\nAttributeEnd')
light("diffuse, filename", f'AttributeBegin\nAreaLightSource "diffuse" "string filename" "{COLOURS}" "float scale" 12\nShape "bilinearmesh" "point3 P" [-1 -1 3  -1 1 3  1 -1 3  1 1 3]\nAttributeEnd')
light("diffuse, twisted patch", 'AttributeBegin\nAreaLightSource "diffuse" "rgb L" [6 6 6] "bool twosided" true\nShape "bilinearmesh" "point3 P" [-1 -1 3  -1 1 2  1 -1 2  1 1 3]\nAttributeEnd')
light("diffuse, cylinder", 'AttributeBegin\nTranslate 0 0 2.5\nRotate 90 0 1 0\nAreaLightSource "diffuse" "rgb L" [8 8 8]\nShape "cylinder" "float radius" 0.2 "float zmin" -1 "float zmax" 1\nAttributeEnd')
light("spectrum stdillum-D65", 'LightSource "infinite" "spectrum L" "stdillum-D65"')

# Media
def grid(values, scale):
    """Voxels of a cube: a pattern without symmetry."""
    return " ".join(f"{scale * ((7 * i + i * i // 3) % 11) / 11:.3g}" for i in range(values))


MEDIUM = 'MakeNamedMedium "m" "string type"'
SIDE = '"integer nx" 4 "integer ny" 4 "integer nz" 4'
CUBE = f'"point3 p0" [-0.6 -0.6 0] "point3 p1" [0.6 0.6 1.2] {SIDE}'
CHROMATIC = '"rgb sigma_a" [0.2 0.3 0.4] "rgb sigma_s" [3 2 1]'
BOUNDARY = 'Material "interface"\nMediumInterface "m" ""\n' + BALL
media("homogeneous", f'{MEDIUM} "homogeneous" {CHROMATIC}\n{BOUNDARY}')
media("homogeneous, g 0.7", f'{MEDIUM} "homogeneous" {CHROMATIC} "float g" 0.7\n{BOUNDARY}')
media("homogeneous, g -0.5, scale", f'{MEDIUM} "homogeneous" {CHROMATIC} "float g" -0.5 "float scale" 2\n{BOUNDARY}')
media("homogeneous, preset", f'{MEDIUM} "homogeneous" "string preset" "Wholemilk"\n{BOUNDARY}')
media(
    "homogeneous, Le",
    f'{MEDIUM} "homogeneous" "rgb sigma_a" [0.5 0.5 0.5] "rgb sigma_s" [0.5 0.5 0.5] "rgb Le" [1 1 1] "float Lescale" 0.5\n{BOUNDARY}',
)
media("homogeneous, absorption only", f'{MEDIUM} "homogeneous" "rgb sigma_a" [0.2 1 2] "rgb sigma_s" [0 0 0]\n{BOUNDARY}', spectra=True)
media("homogeneous in glass", f'{MEDIUM} "homogeneous" {CHROMATIC}\nMaterial "dielectric"\nMediumInterface "m" ""\n{BALL}')
media("uniformgrid", f'{MEDIUM} "uniformgrid" {CUBE} "float density" [{grid(64, 3)}] {CHROMATIC}\n{BOUNDARY}')
media(
    "uniformgrid, Le",
    f'{MEDIUM} "uniformgrid" {CUBE} "float density" [{grid(64, 3)}] "rgb sigma_a" [1 1 1] "rgb sigma_s" [1 1 1] "rgb Le" [2 2 2]\n{BOUNDARY}',
)
media(
    "uniformgrid, Lescale",
    f'{MEDIUM} "uniformgrid" {CUBE} "float density" [{grid(64, 3)}] "float Lescale" [{grid(64, 2)}] "rgb Le" [1 1 1]\n{BOUNDARY}',
)
media(
    "uniformgrid, temperature",
    f'{MEDIUM} "uniformgrid" {CUBE} "float density" [{grid(64, 3)}] "float temperature" [{grid(64, 3000)}] "float temperatureoffset" 100\n{BOUNDARY}',
    spectra=True,
)
media("rgbgrid", f'{MEDIUM} "rgbgrid" {CUBE} "rgb sigma_a" [{grid(192, 0.5)}] "rgb sigma_s" [{grid(192, 4)}]\n{BOUNDARY}')
media(
    "rgbgrid, Le",
    f'{MEDIUM} "rgbgrid" {CUBE} "rgb sigma_a" [{grid(192, 0.5)}] "rgb Le" [{grid(192, 0.03)}] "float scale" 0.5\n{BOUNDARY}',
    spectra=True,
)
media(
    "cloud",
    f'{MEDIUM} "cloud" "float density" 2 "float frequency" 4 "point3 p0" [-1 -1 0] "point3 p1" [1 1 1.2] "rgb sigma_a" [0.1 0.1 0.1] "rgb sigma_s" [6 6 6]\n{BOUNDARY}',
)
NANOVDB = '"string filename" "@ROOT@/tests/pbrt_language/smoke.nvdb" "rgb sigma_a" [0.2 0.2 0.2] "rgb sigma_s" [1 1 1]'
media("nanovdb", f'{MEDIUM} "nanovdb" {NANOVDB} "float Lescale" 0\n{BOUNDARY}')
media(
    "nanovdb, temperature",
    f'{MEDIUM} "nanovdb" {NANOVDB} "float Lescale" 0.1\n{BOUNDARY}',
    spectra=True,
)
FOG = f'{MEDIUM} "homogeneous" "rgb sigma_a" [0.01 0.01 0.01] "rgb sigma_s" [0.05 0.05 0.05]\nMediumInterface "" "m"\n'
media("around the camera", "Material \"diffuse\"\n" + BALL, camera=FOG + CAMERA)
media(
    "nested",
    f'{MEDIUM} "homogeneous" {CHROMATIC}\nAttributeBegin\n{BOUNDARY}AttributeEnd\nMakeNamedMedium "n" "string type" "homogeneous"\n'
    'Material "interface"\nMediumInterface "n" "m"\nTranslate 0 0 0.6\nShape "sphere" "float radius" 0.3\n',
)
media("with the integrator path", f'{MEDIUM} "homogeneous" {CHROMATIC}\n{BOUNDARY}', integrator=INTEGRATOR, missing="the integrator path ignores media")

# Cameras
WORLD = GREY + BALL
LOOK = "LookAt 0 -4 1.6  0 0 0.45  0 0 1\n"
for name, text in [
    ("perspective, fov", '"perspective" "float fov" 60'),
    ("perspective, screenwindow", '"perspective" "float fov" 50 "float screenwindow" [-1.2 0.4 -0.5 1.1]'),
    ("perspective, lens", '"perspective" "float fov" 36 "float lensradius" 0.2 "float focaldistance" 4'),
    ("orthographic", '"orthographic" "float screenwindow" [-1.5 1.5 -1.5 1.5]'),
    ("orthographic, lens", '"orthographic" "float screenwindow" [-1.5 1.5 -1.5 1.5] "float lensradius" 0.2 "float focaldistance" 4'),
    ("spherical, equalarea", '"spherical"'),
    ("spherical, equirectangular", '"spherical" "string mapping" "equirectangular"'),
]:
    row("cameras", name, WORLD, camera=f"{LOOK}Camera {text}\n")
row("cameras", "perspective, frameaspectratio", WORLD, camera=f'{LOOK}Camera "perspective" "float fov" 40 "float frameaspectratio" 1.5\n')
row("cameras", "realistic", WORLD, camera=f'{LOOK}Camera "realistic" "string lensfile" "@ROOT@/lenses/dgauss.50mm.dat" "float aperturediameter" 17.1 "float focusdistance" 4.1\n', film='Film "rgb" "integer xresolution" 32 "integer yresolution" 32 "float diagonal" 40\n')

# Films
for name, text in [
    ("iso", '"float iso" 400'),
    ("maxcomponentvalue", '"float maxcomponentvalue" 0.5'),
    ("cropwindow", '"float cropwindow" [0.25 0.75 0.5 1]'),
    ("pixelbounds", '"integer pixelbounds" [4 28 8 24]'),
]:
    why = "the clamp takes more of pbrt's samples, whose four wavelengths make colours noisy" if name == "maxcomponentvalue" else ""
    film = FILM.strip() + f" {text}\n"
    row("films", f"rgb, {name}", WORLD, film=film, differs=why, tolerance=0.35 if why else 0.01)
COLOURED = 'Material "diffuse" "rgb reflectance" [0.6 0.3 0.15]\n' + BALL
for camera in ["canon_eos_100d", "nikon_d850", "sony_ilce_9"]:
    row("films", f"rgb, sensor {camera}", WORLD, film=FILM.strip() + f' "string sensor" "{camera}"\n')
row("films", "rgb, sensor canon_eos_5d, coloured", COLOURED, film=FILM.strip() + ' "string sensor" "canon_eos_5d"\n', spectra=True)
row("films", "rgb, sensor canon_eos_5d, iso, whitebalance", COLOURED, film=FILM.strip() + ' "string sensor" "canon_eos_5d" "float iso" 200 "float whitebalance" 5000\n', spectra=True)
row("films", "rgb, sensor cie1931", COLOURED, film=FILM.strip() + ' "string sensor" "cie1931"\n')
row("films", "rgb, whitebalance", COLOURED, film=FILM.strip() + ' "float whitebalance" 4500\n')
row("films", "rgb, exposure time", WORLD, camera=CAMERA.strip() + ' "float shutteropen" 0 "float shutterclose" 0.5\n')
row("films", "rgb, savefp16", WORLD, film=FILM.strip() + ' "bool savefp16" false\n')
for space in ["dci-p3", "rec2020", "aces2065-1"]:
    row("films", f"rgb, ColorSpace {space}", COLOURED, camera=f'ColorSpace "{space}"\n{CAMERA}', settings='ColorSpace "srgb"\n')
    clipped = "colours outside sRGB are clipped" if space == "aces2065-1" else ""
    row("films", f"rgb, ColorSpace {space} everywhere", COLOURED, camera=f'ColorSpace "{space}"\n{CAMERA}', differs=clipped, tolerance=0.02 if clipped else 0.01)
row("films", "rgb, ColorSpace aces2065-1, whitebalance", COLOURED, camera=f'ColorSpace "aces2065-1"\n{CAMERA}', film=FILM.strip() + ' "float whitebalance" 5000\n', settings='ColorSpace "srgb"\n')
row("films", "rgb, ColorSpace rec2020, sensor", COLOURED, camera=f'ColorSpace "rec2020"\n{CAMERA}', film=FILM.strip() + ' "string sensor" "nikon_d850"\n', settings='ColorSpace "srgb"\n', spectra=True)
row("films", "gbuffer", WORLD, film=FILM.replace('"rgb"', '"gbuffer"'))

# Filters
for name, text in [
    ("box", '"float xradius" 0.5 "float yradius" 0.5'),
    ("triangle", '"float xradius" 2 "float yradius" 1'),
    ("gaussian", '"float xradius" 1.5 "float yradius" 1.5 "float sigma" 0.5'),
    ("mitchell", '"float xradius" 2 "float yradius" 2 "float B" 0.4 "float C" 0.3'),
    ("sinc", '"float xradius" 3 "float yradius" 3 "float tau" 3'),
]:
    row("filters", name, WORLD, settings=f'PixelFilter "{name}" {text}\n')

# Transforms and structure
for name, text in [
    ("Translate, Scale, Rotate", "Translate 0.2 0 0.6\nRotate 30 0 1 1\nScale 1 0.5 0.7\n"),
    ("Transform", "Transform [1 0 0 0  0 0.8 0 0  0 0 1.2 0  0.3 0.1 0.6 1]\n"),
    ("ConcatTransform", "Translate 0 0 0.6\nConcatTransform [0.8 0.2 0 0  -0.2 0.8 0 0  0 0 1 0  0 0 0 1]\n"),
    ("CoordinateSystem, CoordSysTransform", 'Translate 0 0 0.6\nCoordinateSystem "up"\nIdentity\nCoordSysTransform "up"\n'),
]:
    row("transforms", name, GREY + text + 'Shape "sphere" "float radius" 0.6\n')
row("structure", "Attribute", 'Attribute "shape" "float radius" 0.6\nMaterial "diffuse" "rgb reflectance" [0.6 0.6 0.6]\nTranslate 0 0 0.6\nShape "sphere"\n')
row("structure", "NamedMaterial", f'MakeNamedMaterial "m" "string type" "diffuse" "rgb reflectance" [0.6 0.6 0.6]\nNamedMaterial "m"\n{BALL}')
row("structure", "ColorSpace", f'ColorSpace "rec2020"\nMaterial "diffuse" "rgb reflectance" [0.5 0.3 0.2]\n{BALL}')

import more_rows  # noqa: E402, F401
