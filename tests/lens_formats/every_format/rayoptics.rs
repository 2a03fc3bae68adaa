//! Models of rayoptics (`.roa`): profiles in place and in a table, media, specifications.

use super::{approximated, parsed};
use petzval_lens::{FieldKind, Paraxial};

/// An object of a class with its members, as rayoptics stores it.
fn object(class: &str, members: &str) -> String {
    format!(
        "{{\"__instance_type__\": [\"rayoptics\", \"{class}\"], \"attributes\": {{{members}}}}}"
    )
}

fn interface(mode: &str, semi: f64, profile: &str) -> String {
    let members = format!(
        "\"interact_mode\": \"{mode}\", \"decenter\": null, \"max_aperture\": {semi}, \
         \"clear_apertures\": [], {profile}"
    );
    object("Surface", &members)
}

fn spherical(curvature: f64) -> String {
    format!("\"profile\": {}", object("Spherical", &format!("\"cv\": {curvature:?}")))
}

fn gap(thickness: &str, medium: &str) -> String {
    object("Gap", &format!("\"thi\": {thickness}, \"medium\": {medium}"))
}

/// A model of these interfaces and gaps, with more members of the model.
fn model(interfaces: &[String], gaps: &[String], stop: &str, more: &str) -> String {
    let sequence = object(
        "SequentialModel",
        &format!(
            "\"ifcs\": [{}], \"gaps\": [\n{}], \"stop_surface\": {stop}, \"z_dir\": [1, 1]",
            interfaces.join(",\n"),
            gaps.join(",\n")
        ),
    );
    let members = format!("\"ro_version\": \"0.9.0\", \"seq_model\": {sequence}{more}");
    format!("{{\"optical_model\": {}}}", object("OpticalModel", &members))
}

/// A lens of one element between object and image.
fn singlet(front: &str, glass: &str, more: &str) -> String {
    let surfaces = [
        interface("dummy", 1.0, &spherical(0.0)),
        interface("transmit", 8.0, front),
        interface("transmit", 8.0, &spherical(-0.02)),
        interface("dummy", 1.0, &spherical(0.0)),
    ];
    let air = object("Air", "");
    let gaps = [gap("10000000000.0", &air), gap("5.0", glass), gap("49.0", &air)];
    model(&surfaces, &gaps, "1", more)
}

fn constant(index: f64) -> String {
    object("ModelGlass", &format!("\"label\": \"\", \"n\": {index:?}, \"v\": 60.0"))
}

/// The lens of all formats.
pub fn two_lenses() -> String {
    let rows = [
        (1.0 / 40.0, 6.0, 1.6, 10.0),
        (-1.0 / 60.0, 2.0, 1.0, 10.0),
        (0.0, 3.0, 1.0, 5.0),
        (-1.0 / 30.0, 2.0, 1.7, 8.0),
        (-1.0 / 80.0, 40.0, 1.0, 8.0),
    ];
    let dummy = || interface("dummy", 1.0, &spherical(0.0));
    let mut surfaces = vec![dummy()];
    let mut gaps = vec![gap("Infinity", &object("Air", ""))];
    for (curvature, thickness, index, semi) in rows {
        surfaces.push(interface("transmit", semi, &spherical(curvature)));
        let medium = match index == 1.0 {
            true => object("Air", ""),
            false => object("Medium", &format!("\"label\": \"\", \"n\": {index:?}")),
        };
        gaps.push(gap(&format!("{thickness:?}"), &medium));
    }
    surfaces.push(dummy());
    model(&surfaces, &gaps, "3", "")
}

#[test]
fn profiles_stand_in_the_interface_or_in_a_table() {
    let profile = object(
        "EvenPolynomial",
        "\"cv\": 0.02, \"cc\": -1.0, \"coefs\": {\"__ndarray__\": [0.0, 1e-05, -2e-08], \
         \"dtype\": \"float64\"}",
    );
    let here = parsed("a.roa", &singlet(&format!("\"profile\": {profile}"), &constant(1.5), ""));
    let table = format!(", \"profile_dict\": {{\"7\": {profile}}}");
    let there = parsed("a.roa", &singlet("\"profile_id\": \"7\"", &constant(1.5), &table));
    let (here, there) = (here.expect("in place"), there.expect("in a table"));
    assert_eq!(here.rows, there.rows);
    let row = &here.rows[0];
    assert_eq!((row.radius, row.conic), (50.0, -1.0));
    assert_eq!(row.asphere, [(4, 1e-5), (6, -2e-8)]);
    let radial =
        object("RadialPolynomial", "\"cv\": 0.02, \"ec\": 0.5, \"coefs\": [0.0, 0.0, 3e-6]");
    let radial = singlet(&format!("\"profile\": {radial}"), &constant(1.5), "");
    let row = &parsed("a.roa", &radial).expect("a radial polynomial").rows[0];
    assert_eq!((row.conic, &row.asphere[..]), (-0.5, &[(3, 3e-6)][..]));
    let missing = parsed("a.roa", &singlet("\"profile_id\": \"8\"", &constant(1.5), &table));
    assert!(missing.expect_err("no such profile").to_string().contains("without a profile"));
}

#[test]
fn glasses_units_fields_and_apertures_are_read() {
    let glass = object("SchottGlass", "\"gname\": \"N-BK7\", \"coefs\": [1.0]");
    let spec = |more: &str| {
        format!(
            ", \"system_spec\": {}, \"optical_spec\": {}",
            object("SystemSpec", "\"title\": \"mine\", \"_dimensions\": \"in\""),
            object("OpticalSpecs", more)
        )
    };
    let light = object(
        "WvlSpec",
        "\"wavelengths\": [486.1, 587.6, 656.3], \"spectral_wts\": [1, 2, 1], \"reference_wvl\": 1",
    );
    let fields = object(
        "FieldSpec",
        &format!(
            "\"key\": [\"field\", \"image\", \"height\"], \"value\": 2.0, \"is_relative\": true, \
             \"fields\": [{}, {}]",
            object("Field", "\"x\": 0, \"y\": 0.0"),
            object("Field", "\"x\": 0, \"y\": 0.5")
        ),
    );
    let pupil = object("PupilSpec", "\"_key\": [\"aperture\", \"image\", \"f/#\"], \"value\": 8.0");
    let more = spec(&format!(
        "\"spectral_region\": {light}, \"field_of_view\": {fields}, \"pupil\": {pupil}"
    ));
    let lens = parsed("a.roa", &singlet(&spherical(0.02), &glass, &more)).expect("a lens");
    assert_eq!((lens.name.as_str(), lens.rows[0].thickness), ("mine", 5.0 * 25.4));
    assert!((lens.rows[0].index - 1.5168).abs() < 1e-4, "{}", lens.rows[0].index);
    assert_eq!(lens.rows[0].glass.name(), Some("N-BK7"));
    assert!((Paraxial::new(&lens).f_number() - 8.0).abs() < 1e-9);
    assert_eq!(lens.stated_f_number, Some(8.0));
    let fields = lens.design.fields.as_ref().expect("fields");
    assert_eq!((fields.kind, fields.points[1]), (FieldKind::ImageHeight, [0.0, 25.4]));
    assert_eq!((lens.design.primary, lens.design.wavelengths.len()), (1, 3));
}

#[test]
fn mirrors_thin_lenses_and_terms_that_are_not_simulated() {
    let air = object("Air", "");
    let mirror = [
        interface("dummy", 1.0, &spherical(0.0)),
        interface("reflect", 10.0, &spherical(-0.005)),
        interface("dummy", 1.0, &spherical(0.0)),
    ];
    let gaps = [gap("1e10", &air), gap("-100.0", &air)];
    let lens = parsed("a.roa", &model(&mirror, &gaps, "1", "")).expect("a mirror");
    assert!(lens.rows[0].mirror && (Paraxial::new(&lens).focal_length.abs() - 100.0).abs() < 1e-9);
    let thin = object("ThinLens", "\"_power\": 0.02, \"max_aperture\": 5.0");
    let thin = [mirror[0].clone(), thin, mirror[2].clone()];
    let gaps = [gap("1e10", &air), gap("50.0", &air)];
    let lens = parsed("a.roa", &model(&thin, &gaps, "1", "")).expect("a thin lens");
    assert!((Paraxial::new(&lens).focal_length - 50.0).abs() < 1e-9);

    let phase = format!(
        "{}, \"phase_element\": {}",
        spherical(0.02),
        object("DiffractiveElement", "\"order\": 1")
    );
    let decentred =
        spherical(0.02).replacen("\"profile\"", "\"decenter\": {\"dtype\": 1}, \"profile\"", 1);
    let decentred = singlet(&decentred, &constant(1.5), "").replace("\"decenter\": null, ", "");
    for (text, expected) in [
        (singlet(&phase, &constant(1.5), ""), "a DiffractiveElement on a surface"),
        (decentred, "a tilted or decentred surface"),
    ] {
        let error = parsed("a.roa", &text).expect_err(expected).to_string();
        assert!(error.contains(expected) && error.contains("'approximate'"), "{error}");
        assert!(approximated("a.roa", &text).is_ok(), "{expected}");
    }
    for (text, expected) in [
        (singlet(&spherical(0.02), &object("X", "\"gname\": \"NONE1\""), ""), "an unknown glass"),
        (model(&mirror[..1], &[], "1", ""), "expected object, surfaces and image"),
        (model(&mirror, &gaps[..1], "1", ""), "expected a gap behind each interface"),
        ("{\"optical_model\": 3}".to_owned(), "no \"seq_model\""),
    ] {
        let error = parsed("a.roa", &text).expect_err(expected).to_string();
        assert!(error.contains(expected), "{error}");
    }
}
