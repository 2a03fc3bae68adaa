//! Materials of pbrt-v4: names, defaults and errors.

use crate::support::world::{
    colour, error, read_world, read_world_with_warnings, roughness_and_remap,
};
use petzval_render::shade::bsdf::conductor_reflectance;
use petzval_scene::{HairColour, Material, MaterialModel, Metal, Texture};

/// Returns the material of a ball.
fn material(world: &str) -> Material {
    let scene = read_world(&format!("{world} Shape \"sphere\"")).scene;
    scene.materials[scene.shapes[0].material as usize].clone()
}

fn scatters(world: &str) -> MaterialModel {
    material(world).model
}

#[test]
fn materials_have_the_defaults_of_pbrt() {
    for name in ["", "none", "interface"] {
        assert!(matches!(scatters(&format!("Material \"{name}\"")), MaterialModel::Interface));
    }
    let MaterialModel::Diffuse { reflectance } = scatters("") else { panic!() };
    assert_eq!(colour(&reflectance), [0.5; 3]);
    let MaterialModel::Diffuse { reflectance } = scatters("Material \"diffuse\"") else { panic!() };
    assert_eq!(colour(&reflectance), [0.5; 3]);

    let MaterialModel::CoatedDiffuse { reflectance, coat } = scatters("Material \"coateddiffuse\"")
    else {
        panic!()
    };
    assert_eq!((colour(&reflectance), coat.eta), ([0.5; 3], 1.5));
    assert_eq!(roughness_and_remap(&coat.roughness), ([0.0; 2], true));
    assert_eq!((colour(&coat.thickness)[0], colour(&coat.albedo)), (0.01, [0.0; 3]));
    assert_eq!((colour(&coat.g)[0], coat.max_depth, coat.samples), (0.0, 10, 1));

    let MaterialModel::Dielectric { eta, roughness, .. } = scatters("Material \"dielectric\"")
    else {
        panic!()
    };
    assert_eq!((eta, roughness_and_remap(&roughness)), (1.5, ([0.0; 2], true)));
    let MaterialModel::ThinDielectric { eta, tint, .. } = scatters("Material \"thindielectric\"")
    else {
        panic!()
    };
    assert_eq!((eta, colour(&tint)), ([1.5; 3], [1.0; 3]));

    let MaterialModel::DiffuseTransmission { reflectance, transmittance, scale } =
        scatters("Material \"diffusetransmission\"")
    else {
        panic!()
    };
    assert_eq!((colour(&reflectance), colour(&transmittance), scale), ([0.25; 3], [0.25; 3], 1.0));

    let MaterialModel::Conductor { metal: copper, roughness } = scatters("Material \"conductor\"")
    else {
        panic!()
    };
    let Metal::Index { eta, k, .. } = copper else { panic!() };
    assert!(colour(&eta)[0] < 0.3 && colour(&eta)[2] > 1.0 && colour(&k)[0] > 3.0);
    assert_eq!(roughness_and_remap(&roughness), ([0.0; 2], true));
    let MaterialModel::CoatedConductor { metal, roughness, coat } =
        scatters("Material \"coatedconductor\"")
    else {
        panic!()
    };
    let Metal::Index { eta: base, .. } = metal else { panic!() };
    assert_eq!(
        (colour(&base), coat.eta, roughness_and_remap(&roughness)),
        (colour(&eta), 1.5, ([0.0; 2], true))
    );
}

#[test]
fn materials_read_their_parameters() {
    let MaterialModel::CoatedDiffuse { reflectance, coat } = scatters(
        "Texture \"t\" \"float\" \"constant\" \"float value\" 0.25\n\
         Material \"coateddiffuse\" \"rgb reflectance\" [0.1 0.2 0.3] \"float roughness\" 0.3 \
         \"texture vroughness\" \"t\" \"bool remaproughness\" false \"float thickness\" 0.5 \
         \"float eta\" 1.3 \"rgb albedo\" [0.4 0.5 0.6] \"float g\" -0.7 \"integer maxdepth\" 20 \
         \"integer nsamples\" 4",
    ) else {
        panic!()
    };
    assert_eq!((colour(&reflectance), coat.eta), ([0.1, 0.2, 0.3], 1.3));
    assert_eq!(roughness_and_remap(&coat.roughness), ([0.3, 0.25], false));
    assert_eq!((colour(&coat.thickness)[0], colour(&coat.albedo)), (0.5, [0.4, 0.5, 0.6]));
    assert_eq!((colour(&coat.g)[0], coat.max_depth, coat.samples), (-0.7, 20, 4));

    let MaterialModel::CoatedConductor { metal, roughness, coat } = scatters(
        "Material \"coatedconductor\" \"float interface.roughness\" 0.1 \"float interface.eta\" 1.7 \
         \"rgb conductor.eta\" [1 2 3] \"rgb conductor.k\" [4 5 6] \
         \"float conductor.uroughness\" 0.2 \"float conductor.roughness\" 0.3",
    ) else {
        panic!()
    };
    let Metal::Index { eta, k, .. } = metal else { panic!() };
    assert_eq!((colour(&eta), colour(&k)), ([1.0, 2.0, 3.0], [4.0, 5.0, 6.0]));
    assert_eq!(
        (roughness_and_remap(&roughness).0, roughness_and_remap(&coat.roughness).0),
        ([0.2, 0.3], [0.1, 0.1])
    );
    assert_eq!(coat.eta, 1.7);

    let reflects = "Material \"conductor\" \"rgb reflectance\" [0.9 0.8 0.7]";
    let MaterialModel::Conductor { metal: Metal::Reflectance(found), .. } = scatters(reflects)
    else {
        panic!()
    };
    assert_eq!(colour(&found), [0.9, 0.8, 0.7]);

    let gold =
        "Material \"conductor\" \"spectrum eta\" \"metal-Au-eta\" \"spectrum k\" \"metal-Au-k\"";
    let MaterialModel::Conductor { metal: Metal::Index { eta, k, tint }, .. } = scatters(gold)
    else {
        panic!()
    };
    let at_normal = [0, 1, 2]
        .map(|c| colour(&tint)[c] * conductor_reflectance(1.0, colour(&eta)[c], colour(&k)[c]));
    for (found, expected) in at_normal.into_iter().zip([1.022, 0.782, 0.344]) {
        assert!((found - expected).abs() < 0.006, "{at_normal:?}");
    }

    // RGB takes a spectrum by its value at the d line.
    for (eta, expected, disperses) in [
        ("\"float eta\" 1.33", 1.33, false),
        ("\"spectrum eta\" \"glass-BK7\"", 1.5168, true),
        ("\"spectrum eta\" [400 1.6 775.12 1.4]", 1.5, true),
        ("\"spectrum eta\" [360 1.5 830 1.5]", 1.5, false),
    ] {
        let read =
            read_world_with_warnings(&format!("Material \"dielectric\" {eta} Shape \"sphere\""));
        assert!(read.warnings.is_empty(), "{:#?}", read.warnings);
        assert_eq!(read.scene.disperses(), disperses, "{eta}");
        let material = &read.scene.materials[read.scene.shapes[0].material as usize];
        let MaterialModel::Dielectric { eta, .. } = material.model else { panic!() };
        assert!((eta - expected).abs() < 1e-4, "{eta} instead of {expected}");
    }

    let mix = "MakeNamedMaterial \"a\" \"string type\" \"dielectric\" \
               MakeNamedMaterial \"b\" \"string type\" \"diffuse\" \"rgb reflectance\" [1 1 1] \
               Material \"mix\" \"string materials\" [\"a\" \"b\"] \"float amount\" 0.3 Shape \"sphere\"";
    let scene = read_world(mix).scene;
    let of = |index: u32| &scene.materials[index as usize].model;
    let MaterialModel::Mix { materials: [a, b], amount } = of(scene.shapes[0].material) else {
        panic!()
    };
    assert_eq!(colour(amount)[0], 0.3);
    assert!(
        matches!(of(*a), MaterialModel::Dielectric { .. })
            && matches!(of(*b), MaterialModel::Diffuse { .. })
    );

    let bent = material(
        "Texture \"t\" \"float\" \"constant\" \"float value\" 0.25\n\
         Material \"diffuse\" \"texture displacement\" \"t\"",
    );
    assert_eq!(bent.bump.map(|bump| colour(&bump)[0]), Some(0.25));
}

#[test]
fn a_named_material_may_be_defined_after_its_use() {
    let scene = read_world(
        "NamedMaterial \"late\" Shape \"sphere\"\n\
         MakeNamedMaterial \"late\" \"string type\" \"thindielectric\" Shape \"disk\"",
    )
    .scene;
    assert_eq!(scene.shapes[0].material, scene.shapes[1].material);
    let late = &scene.materials[scene.shapes[0].material as usize].model;
    assert!(matches!(late, MaterialModel::ThinDielectric { .. }));
}

#[test]
fn old_materials_are_converted_as_in_pbrt_and_others_warn() {
    for (world, kind) in [
        ("\"mirror\" \"rgb Kr\" [1 1 1]", "Conductor"),
        ("\"glass\" \"float index\" 1.6 \"rgb Kr\" [1 1 1]", "Dielectric"),
        ("\"metal\" \"float roughness\" 0.1", "Conductor"),
        ("\"plastic\" \"rgb Ks\" [1 1 1]", "CoatedDiffuse"),
        ("\"substrate\" \"float uroughness\" 0.2", "CoatedDiffuse"),
        ("\"uber\" \"rgb Kt\" [0 0 0]", "CoatedDiffuse"),
        ("\"translucent\" \"rgb reflect\" [1 1 1]", "DiffuseTransmission"),
        ("\"shinymetal\" \"float roughness\" 0.2", "Conductor"),
        ("\"kdsubsurface\" \"rgb Kd\" [0.1 0.2 0.3]", "Subsurface"),
        ("\"subsurface\" \"rgb reflectance\" [0.1 0.2 0.3]", "Subsurface"),
    ] {
        let description = read_world_with_warnings(&format!("Material {world} Shape \"sphere\""));
        let scene = &description.scene;
        let found = format!("{:?}", scene.materials[scene.shapes[0].material as usize].model);
        assert!(found.starts_with(&format!("{kind} {{")), "{world}: {found}");
        let message = usize::from(kind == "Diffuse");
        assert_eq!(description.warnings.len(), message, "{world}: {:#?}", description.warnings);
    }
}

#[test]
fn the_first_colour_of_a_hair_counts() {
    let colour = |given: &str| {
        let scene = read_world(&format!("Material \"hair\" {given} Shape \"sphere\"")).scene;
        let material = &scene.materials[scene.shapes[0].material as usize];
        let MaterialModel::Hair(fibre) = &material.model else { panic!("{material:?}") };
        assert!(material.bump.is_none() && material.needs_derivatives());
        format!("{:?}", fibre.colour)
    };
    let number = |value: f32| format!("Constant([{value:?}, {value:?}, {value:?}])");
    let melanin = |e: f32, p: f32| {
        let [e, p] = [e, p].map(|value| Texture::Constant([value; 3]));
        format!("{:?}", HairColour::melanin(e, p))
    };
    assert_eq!(colour(""), melanin(1.3, 0.0));
    assert_eq!(colour("\"float displacement\" 0.1"), melanin(1.3, 0.0));
    assert_eq!(colour("\"float pheomelanin\" 2"), melanin(0.0, 2.0));
    let both = "\"float eumelanin\" 0.5 \"float pheomelanin\" 2";
    assert_eq!(colour(both), melanin(0.5, 2.0));
    let white = format!("{both} \"rgb color\" [1 1 1]");
    assert_eq!(colour(&white), format!("Reflectance({})", number(1.0)));
    let dark = format!("{white} \"rgb sigma_a\" [3 3 3]");
    assert_eq!(colour(&dark), format!("Absorption({})", number(3.0)));
}

#[test]
fn errors_in_materials_name_their_position() {
    for (world, expected) in [
        (
            "Material \"difuse\"",
            "test.pbrt:3:1: unknown Material \"difuse\"; did you mean \"diffuse\"?",
        ),
        (
            "Material \"dielectric\" \"float etta\" 2",
            "test.pbrt:3:23: unknown parameter \"etta\" of Material \"dielectric\"; did you mean \"eta\"?",
        ),
        ("Material \"dielectric\" \"float eta\" 0", "test.pbrt:3:23: \"eta\" is 0"),
        (
            "Material \"dielectric\" \"spectrum eta\" \"glass-BK8\"",
            "test.pbrt:3:23: no spectrum \"glass-BK8\"; did you mean \"glass-BK7\"?",
        ),
        (
            "Material \"conductor\" \"rgb reflectance\" [1 1 1] \"rgb k\" [1 1 1]",
            "test.pbrt:3:22: a metal with reflectance and with eta or k",
        ),
        ("Material \"mix\"", "test.pbrt:3:1: a mix without \"string materials\""),
        (
            "Material \"mix\" \"string materials\" [\"a\" \"b\"]",
            "test.pbrt:3:16: no material named \"a\"",
        ),
        (
            "NamedMaterial \"a\" MakeNamedMaterial \"a\" \"string type\" \"mix\" \
             \"string materials\" [\"a\" \"a\"]",
            "test.pbrt:3:61: no material named \"a\"; define the materials of a mix before it",
        ),
        ("Material \"coateddiffuse\" \"integer maxdepth\" 0", "test.pbrt:3:26: \"maxdepth\" is 0"),
        ("Shape \"sphere\"\nNamedMaterial \"gold\"", "test.pbrt:4:1: no material named \"gold\""),
    ] {
        let message = error(world);
        assert!(
            message.starts_with(expected),
            "{world}\n  found    {message}\n  expected {expected}"
        );
    }
}
