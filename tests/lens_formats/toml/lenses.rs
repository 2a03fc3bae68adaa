//! Lenses in TOML of the repository against their sources.

use petzval_lens::{Paraxial, TransverseAxis};
use petzval_lens_formats::read;

use crate::support::root;

#[test]
fn the_example_lenses_have_the_focal_lengths_they_state() {
    for (name, f_number) in [("phone", Some(3.5)), ("triplet", Some(5.0)), ("anamorphic", None)] {
        let lens = read(&root().join(format!("lenses/{name}.toml"))).unwrap();
        let paraxial = Paraxial::new(&lens);
        let stated = lens.stated_focal_length.unwrap();
        // The triplet was designed at 550 nm, where its focal length is 50.00 mm; at the d line it is 50.02.
        assert!((paraxial.focal_length / stated - 1.0).abs() < 5e-4, "{name}");
        assert_eq!(lens.stated_f_number, f_number);
        if let Some(f_number) = f_number {
            assert!((paraxial.f_number() - f_number).abs() < 0.01, "{name}");
        }
        assert!(lens.source.is_some());
    }
}

#[test]
fn the_triplet_has_its_focal_length_at_the_wavelength_of_its_design() {
    let lens = read(&root().join("lenses/triplet.toml")).unwrap();
    let green = Paraxial::new(&lens.at_wavelength(550.0).unwrap()).focal_length;
    assert!((green - 50.0).abs() < 5e-3, "{green}");
}

#[test]
fn the_phone_lens_has_the_sags_of_its_source() {
    let lens = read(&root().join("lenses/phone.toml")).unwrap();
    let paraxial = Paraxial::new(&lens);
    assert!((paraxial.focal_length - 5.555).abs() < 5e-4);
    assert!((paraxial.back_focal_distance - 0.5678).abs() < 5e-5);
    // Heights and sags of rays in the gallery of ray-optics, to their last digit.
    let traced = [
        (1, 1.0, 0.26119),
        (2, 0.84711, -0.0050525),
        (3, 1.00282, -0.32485),
        (4, 1.26980, -0.29095),
        (5, 1.39140, 0.022842),
        (6, 1.59925, 0.10915),
        (7, 1.70567, 0.25384),
        (8, 1.98752, 0.35893),
    ];
    for (i, height, sag) in traced {
        let ours = lens.rows[i].sag(height);
        assert!((ours - sag).abs() < 1e-5, "surface {i}: {ours} for {sag}");
    }
}

#[test]
fn the_anamorphic_lens_focuses_both_planes_at_one_film_distance() {
    let lens = read(&root().join("lenses/anamorphic.toml")).unwrap();
    let [x, y] =
        [TransverseAxis::X, TransverseAxis::Y].map(|plane| Paraxial::in_plane(&lens, plane));
    assert!((y.focal_length / x.focal_length - 4.0 / 3.0).abs() < 1e-3);
    // A thousandth of a millimetre is far below the depth of focus.
    assert!((x.back_focal_distance - y.back_focal_distance).abs() < 1e-3);
}
