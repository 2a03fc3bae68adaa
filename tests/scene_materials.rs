//! Materials in the language of pbrt-v4: names, defaults, mistakes.

mod support;

use petzval::scene::{Material, Metal, Scatters};
use petzval::shade::bsdf::conductor_reflectance;
use support::world::{colour, error, loudly, quietly, rough};

/// The material of a ball.
fn material(world: &str) -> Material {
    let scene = quietly(&format!("{world} Shape \"sphere\"")).scene;
    scene.materials[scene.shapes[0].material as usize].clone()
}

fn scatters(world: &str) -> Scatters {
    material(world).scatters
}

#[test]
fn materials_have_the_defaults_of_pbrt() {
    for name in ["", "none", "interface"] {
        assert!(matches!(scatters(&format!("Material \"{name}\"")), Scatters::Interface));
    }
    let Scatters::Diffuse { reflectance } = scatters("") else { panic!() };
    assert_eq!(colour(&reflectance), [0.5; 3]);
    let Scatters::Diffuse { reflectance } = scatters("Material \"diffuse\"") else { panic!() };
    assert_eq!(colour(&reflectance), [0.5; 3]);

    let Scatters::CoatedDiffuse { reflectance, coat } = scatters("Material \"coateddiffuse\"")
    else {
        panic!()
    };
    assert_eq!((colour(&reflectance), coat.eta), ([0.5; 3], 1.5));
    assert_eq!(rough(&coat.roughness), ([0.0; 2], true));
    assert_eq!((colour(&coat.thickness)[0], colour(&coat.albedo)), (0.01, [0.0; 3]));
    assert_eq!((colour(&coat.g)[0], coat.max_depth, coat.samples), (0.0, 10, 1));

    let Scatters::Dielectric { eta, roughness } = scatters("Material \"dielectric\"") else {
        panic!()
    };
    assert_eq!((eta, rough(&roughness)), (1.5, ([0.0; 2], true)));
    let Scatters::ThinDielectric { eta } = scatters("Material \"thindielectric\"") else {
        panic!()
    };
    assert_eq!(eta, 1.5);

    let Scatters::DiffuseTransmission { reflectance, transmittance, scale } =
        scatters("Material \"diffusetransmission\"")
    else {
        panic!()
    };
    assert_eq!((colour(&reflectance), colour(&transmittance), scale), ([0.25; 3], [0.25; 3], 1.0));

    let Scatters::Conductor { metal: copper, roughness } = scatters("Material \"conductor\"")
    else {
        panic!()
    };
    let Metal::Index { eta, k, .. } = copper else { panic!() };
    assert!(colour(&eta)[0] < 0.3 && colour(&eta)[2] > 1.0 && colour(&k)[0] > 3.0);
    assert_eq!(rough(&roughness), ([0.0; 2], true));
    let Scatters::CoatedConductor { metal, roughness, coat } =
        scatters("Material \"coatedconductor\"")
    else {
        panic!()
    };
    let Metal::Index { eta: base, .. } = metal else { panic!() };
    assert_eq!((colour(&base), coat.eta, rough(&roughness)), (colour(&eta), 1.5, ([0.0; 2], true)));
}

#[test]
fn materials_read_what_they_are_given() {
    let Scatters::CoatedDiffuse { reflectance, coat } = scatters(
        "Texture \"t\" \"float\" \"constant\" \"float value\" 0.25\n\
         Material \"coateddiffuse\" \"rgb reflectance\" [0.1 0.2 0.3] \"float roughness\" 0.3 \
         \"texture vroughness\" \"t\" \"bool remaproughness\" false \"float thickness\" 0.5 \
         \"float eta\" 1.3 \"rgb albedo\" [0.4 0.5 0.6] \"float g\" -0.7 \"integer maxdepth\" 20 \
         \"integer nsamples\" 4",
    ) else {
        panic!()
    };
    assert_eq!((colour(&reflectance), coat.eta), ([0.1, 0.2, 0.3], 1.3));
    assert_eq!(rough(&coat.roughness), ([0.3, 0.25], false));
    assert_eq!((colour(&coat.thickness)[0], colour(&coat.albedo)), (0.5, [0.4, 0.5, 0.6]));
    assert_eq!((colour(&coat.g)[0], coat.max_depth, coat.samples), (-0.7, 20, 4));

    let Scatters::CoatedConductor { metal, roughness, coat } = scatters(
        "Material \"coatedconductor\" \"float interface.roughness\" 0.1 \"float interface.eta\" 1.7 \
         \"rgb conductor.eta\" [1 2 3] \"rgb conductor.k\" [4 5 6] \
         \"float conductor.uroughness\" 0.2 \"float conductor.roughness\" 0.3",
    ) else {
        panic!()
    };
    let Metal::Index { eta, k, .. } = metal else { panic!() };
    assert_eq!((colour(&eta), colour(&k)), ([1.0, 2.0, 3.0], [4.0, 5.0, 6.0]));
    assert_eq!((rough(&roughness).0, rough(&coat.roughness).0), ([0.2, 0.3], [0.1, 0.1]));
    assert_eq!(coat.eta, 1.7);

    let reflects = "Material \"conductor\" \"rgb reflectance\" [0.9 0.8 0.7]";
    let Scatters::Conductor { metal: Metal::Reflectance(found), .. } = scatters(reflects) else {
        panic!()
    };
    assert_eq!(colour(&found), [0.9, 0.8, 0.7]);

    let gold =
        "Material \"conductor\" \"spectrum eta\" \"metal-Au-eta\" \"spectrum k\" \"metal-Au-k\"";
    let Scatters::Conductor { metal: Metal::Index { eta, k, tint }, .. } = scatters(gold) else {
        panic!()
    };
    let at_normal =
        [0, 1, 2].map(|c| tint[c] * conductor_reflectance(1.0, colour(&eta)[c], colour(&k)[c]));
    for (found, expected) in at_normal.into_iter().zip([1.022, 0.782, 0.344]) {
        assert!((found - expected).abs() < 0.006, "{at_normal:?}");
    }

    // Of a spectrum the d line is used, which is said.
    for (eta, expected, warnings) in [
        ("\"float eta\" 1.33", 1.33, 0),
        ("\"spectrum eta\" \"glass-BK7\"", 1.5168, 1),
        ("\"spectrum eta\" [400 1.6 775.12 1.4]", 1.5, 1),
    ] {
        let read = loudly(&format!("Material \"dielectric\" {eta} Shape \"sphere\""));
        assert_eq!(read.warnings.len(), warnings, "{:#?}", read.warnings);
        let material = &read.scene.materials[read.scene.shapes[0].material as usize];
        let Scatters::Dielectric { eta, .. } = material.scatters else { panic!() };
        assert!((eta - expected).abs() < 1e-4, "{eta} instead of {expected}");
    }

    let mix = "MakeNamedMaterial \"a\" \"string type\" \"dielectric\" \
               MakeNamedMaterial \"b\" \"string type\" \"diffuse\" \"rgb reflectance\" [1 1 1] \
               Material \"mix\" \"string materials\" [\"a\" \"b\"] \"float amount\" 0.3 Shape \"sphere\"";
    let scene = quietly(mix).scene;
    let of = |index: u32| &scene.materials[index as usize].scatters;
    let Scatters::Mix { materials: [a, b], amount } = of(scene.shapes[0].material) else {
        panic!()
    };
    assert_eq!(colour(amount)[0], 0.3);
    assert!(
        matches!(of(*a), Scatters::Dielectric { .. }) && matches!(of(*b), Scatters::Diffuse { .. })
    );

    let bent = material(
        "Texture \"t\" \"float\" \"constant\" \"float value\" 0.25\n\
         Material \"diffuse\" \"texture displacement\" \"t\"",
    );
    assert_eq!(bent.bump.map(|bump| colour(&bump)[0]), Some(0.25));
}

#[test]
fn a_named_material_may_be_made_after_it_is_used() {
    let scene = quietly(
        "NamedMaterial \"late\" Shape \"sphere\"\n\
         MakeNamedMaterial \"late\" \"string type\" \"thindielectric\" Shape \"disk\"",
    )
    .scene;
    assert_eq!(scene.shapes[0].material, scene.shapes[1].material);
    let late = &scene.materials[scene.shapes[0].material as usize].scatters;
    assert!(matches!(late, Scatters::ThinDielectric { .. }));
}

#[test]
fn old_kinds_become_those_that_pbrt_makes_of_them_and_others_say_what_they_become() {
    for (world, kind) in [
        ("\"mirror\" \"rgb Kr\" [1 1 1]", "Conductor"),
        ("\"glass\" \"float index\" 1.6 \"rgb Kr\" [1 1 1]", "Dielectric"),
        ("\"metal\" \"float roughness\" 0.1", "Conductor"),
        ("\"plastic\" \"rgb Ks\" [1 1 1]", "CoatedDiffuse"),
        ("\"substrate\" \"float uroughness\" 0.2", "CoatedDiffuse"),
        ("\"uber\" \"rgb Kt\" [0 0 0]", "CoatedDiffuse"),
        ("\"translucent\" \"rgb reflect\" [1 1 1]", "DiffuseTransmission"),
        ("\"shinymetal\" \"float roughness\" 0.2", "Conductor"),
        ("\"hair\" \"float beta_m\" 0.2", "Diffuse"),
        ("\"subsurface\" \"rgb reflectance\" [0.1 0.2 0.3]", "Diffuse"),
    ] {
        let description = loudly(&format!("Material {world} Shape \"sphere\""));
        let scene = &description.scene;
        let found = format!("{:?}", scene.materials[scene.shapes[0].material as usize].scatters);
        assert!(found.starts_with(&format!("{kind} {{")), "{world}: {found}");
        let said = usize::from(kind == "Diffuse");
        assert_eq!(description.warnings.len(), said, "{world}: {:#?}", description.warnings);
    }
}

#[test]
fn mistakes_in_materials_are_named() {
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
            "test.pbrt:3:61: no material named \"a\"; a mix needs them made before",
        ),
        ("Material \"coateddiffuse\" \"integer maxdepth\" 0", "test.pbrt:3:26: \"maxdepth\" is 0"),
        ("Shape \"sphere\"\nNamedMaterial \"gold\"", "test.pbrt:4:1: no material named \"gold\""),
    ] {
        let said = error(world);
        assert!(said.starts_with(expected), "{world}\n  said     {said}\n  expected {expected}");
    }
}
