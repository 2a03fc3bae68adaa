//! Clear diameters and f-numbers: those that a file states, and those that its rays need.

use crate::support::{folder, petzval, root, write};

/// The patent of the phone's lens states the clear diameters of its aspheres. A file without them gets
/// nearly the same ones by real rays; first-order optics aims beyond where the polynomials hold.
#[test]
fn diameters_that_a_file_leaves_out_are_those_that_its_rays_need() {
    let folder = folder();
    let phone = root().join("lenses/phone.toml");
    let arguments = ["lens", "convert", phone.to_str().expect("a path"), "-o", "phone.zmx"];
    let (code, _, stderr) = petzval(folder.path(), &arguments);
    assert_eq!(code, 0, "{stderr}");
    let text = std::fs::read_to_string(folder.path().join("phone.zmx")).expect("a file");
    let without = |line: &&str| !["DIAM", "CLAP", "FLOA"].iter().any(|key| line.contains(key));
    let bare = |aperture: f64| {
        let lines: Vec<String> = (text.lines().filter(without))
            .map(|line| match line.split(' ').next() {
                Some("ENPD") => format!("ENPD {aperture}"),
                Some("FTYP") => "FTYP 0 0 3 1 0 0 0".to_owned(),
                Some("XFLN") => "XFLN 0 0 0".to_owned(),
                Some("YFLN") => "YFLN 0 22 32".to_owned(),
                _ => line.to_owned(),
            })
            .collect();
        petzval_lens_formats::read(&write(&folder, "bare.zmx", lines.join("\n"))).expect("a lens")
    };
    let stated = petzval_lens_formats::read(&phone).expect("a lens");
    let found = bare(1.5872);
    for (i, (row, stated)) in found.rows.iter().zip(&stated.rows).enumerate().skip(1).take(8) {
        let ratio = row.diameter / stated.diameter;
        assert!((0.88..1.08).contains(&ratio), "surface {}: {} mm", i + 1, row.diameter);
    }
    // The same lens at f/2.3, where the aspheres leave their range: the stop alone limits the light.
    let fast = bare(2.4);
    let f_number = petzval_lens::RealRayFocus::new(&fast).f_number().expect("an image");
    assert!(f_number < 2.4, "f/{f_number}");
}

#[test]
fn a_marginal_ray_far_from_the_stated_f_number_is_a_warning() {
    let with = |stated: f64| {
        let folder = folder();
        let text = format!(
            "f_number = {stated}\n[[surface]]\nradius = 50\nthickness = 4\ndiameter = 12.5\nindex = 1.5
             stop = true\n[[surface]]\nradius = -50\ndiameter = 20\n"
        );
        petzval_lens_formats::read(&write(&folder, "lens.toml", text)).expect("a lens").design.notes
    };
    // 50.7 mm over 12.5 mm.
    assert_eq!(with(4.0), Vec::<String>::new());
    let notes = with(3.0);
    assert!(notes.len() == 1 && notes[0].contains("states f/3.00"), "{notes:?}");
}
