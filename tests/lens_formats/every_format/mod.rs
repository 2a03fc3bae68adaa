//! Lens files of other programs: one small lens in every format, and what each format says besides.

mod bench;
mod diameters;
mod errors;
mod rayoptics;
mod tables;

use crate::support::{folder, write};
use petzval_base::io::ReadContext;
use petzval_lens::{LensError, Paraxial, Prescription};
use petzval_lens_formats::{read, read_with};

/// Two lenses around a stop.
const TABLE: &str = "40 6 1.6 20\n-60 2 1 20\n0 3 0 10\n-30 2 1.7 16\n-80 40 1 16\n";

const BENCH: &str = "[descriptive data]\ntitle\tTwo lenses\n[constants]\n[variable distances]\n\
    d0\tInfinity\nBf\t40\n[lens data]\n1\t40\t6\t1.6\t20\t60\n2\t-60\t2\t\t20\n3AS\tAS\t3\t\t10\n\
    4\t-30\t2\t1.7\t16\t30\n5\t-80\tBf\t\t16\n";

const FX: &str = "[Metadata]\nName: Two lenses\n[Surfaces]\n\
    Radius Thickness IOR Housing-Radius Abbe-No Material Geometry\n\
    40 6 1.6 10 60 UNKNOWN SPHERICAL\n-60 2 1 10 0 AIR SPHERICAL\n0 3 0 5 AIR PLANAR\n\
    -30 2 1.7 8 30 UNKNOWN SPHERICAL\n-80 40 1 8 0 AIR SPHERICAL\n";

const ISET: &str = r#"{"name": "Two lenses", "surfaces": [
    {"radius": 40, "thickness": 6, "ior": 1.6, "semi_aperture": 10},
    {"radius": -60, "thickness": 2, "ior": 1, "semi_aperture": 10},
    {"radius": 0, "thickness": 3, "ior": 0, "semi_aperture": 5},
    {"radius": -30, "thickness": 2, "ior": 1.7, "semi_aperture": 8},
    {"radius": -80, "thickness": 40, "ior": 1, "semi_aperture": 8}]}"#;

const DEEPLENS: &str = r#"{"info": "Two lenses", "foclen": 77.5, "surfaces": [
    {"type": "Spheric", "roc": 40, "d_next": 6, "mat2": "1.6/60", "r": 10},
    {"type": "Spheric", "c": -0.016666666666666666, "d_next": 2, "mat2": "air", "r": 10},
    {"type": "Aperture", "d_next": 3, "r": 5},
    {"type": "Spheric", "roc": -30, "d_next": 2, "mat2": "1.7/30", "r": 8},
    {"type": "Aspheric", "roc": -80, "k": 0, "ai": [0, 0], "d_next": 40, "mat2": "air", "r": 8}]}"#;

const GEOPTER: &str = r#"{"Title": "Two lenses", "Assembly": {"Stop": 3,
    "0": {"Curvature": 0, "Material": "AIR", "Thickness": 1e10, "Type": "SPH"},
    "1": {"Curvature": 0.025, "Material": "1.6:60", "Thickness": 6, "Type": "SPH", "Aperture": 10},
    "2": {"Curvature": -0.016666666666666666, "Material": "AIR", "Thickness": 2, "Type": "SPH",
          "Aperture": {"Radius": 10}},
    "3": {"Curvature": 0, "Material": "AIR", "Thickness": 3, "Type": "SPH", "Aperture": 5},
    "4": {"Curvature": -0.03333333333333333, "Material": "1.7:30", "Thickness": 2, "Type": "SPH",
          "Aperture": 8},
    "5": {"Curvature": -0.0125, "Material": "AIR", "Thickness": 40, "Type": "SPH", "Aperture": 8},
    "6": {"Curvature": 0, "Material": "AIR", "Thickness": 0, "Type": "SPH"}}}"#;

const CSV: &str = "radius;thickness;material;index;v-no;sa\n40;6;X1;1.6;60;10\n-60;2;air;;;10\n\
    ;3;air;;;5\n-30;2;X2;1.7;30;8\n-80;40;air;;;8\n";

const DIFF_OPTICS: &str = "Two lenses\ntype distance roc diameter material\nO 0 0 0 AIR\n\
    S 0 40 20 1.6/60\nS 6 -60 20 AIR\nA 2 0 10 OCCLUDER\nS 3 -30 16 1.7/30\nS 2 -80 16 AIR\n\
    I 40 0 20 AIR\n";

const LENTIL: &str = r#"{"0001": {"year": 1950, "company": "one", "product-name": "pair",
  "optical-elements-patent": [
    {"radius": 40, "thickness": 6, "ior": 1.6, "abbe": 60, "material": "abbe", "housing-radius": 10,
     "lens-geometry": "spherical", "aspherical-equation": null},
    {"radius": -60, "thickness": 2, "ior": null, "material": "air", "housing-radius": 10},
    {"radius": 99999, "thickness": 3, "ior": null, "material": "iris", "housing-radius": 5},
    {"radius": -30, "thickness": 2, "ior": 1.7, "abbe": 30, "material": "x", "housing-radius": 8},
    {"radius": -80, "thickness": 40, "ior": null, "material": "air", "housing-radius": 8}]},
  "0002": {"company": "two", "product-name": "other", "optical-elements-patent": []}}"#;

/// The same lens in optiland's words.
fn optiland() -> String {
    let mut z = 0.0;
    let rows = [(40.0, 6.0, 1.6, 10), (-60.0, 2.0, 1.0, 10), (f64::INFINITY, 3.0, 1.0, 5)];
    let rows = rows.into_iter().chain([(-30.0, 2.0, 1.7, 8), (-80.0, 40.0, 1.0, 8)]);
    let surface = |z: f64, radius: f64, index: f64, semi: i32| {
        let number = |value: f64| match value.is_infinite() {
            true => if value > 0.0 { "Infinity" } else { "-Infinity" }.to_owned(),
            false => value.to_string(),
        };
        format!(
            "{{\"type\": \"Surface\", \"is_stop\": {}, \"aperture\": {{\"r_max\": {semi}}}, \
             \"geometry\": {{\"type\": \"StandardGeometry\", \"radius\": {}, \"cs\": {{\"z\": {}}}}}, \
             \"material_post\": {{\"type\": \"IdealMaterial\", \"index\": {index}}}}}",
            semi == 5,
            number(radius),
            number(z),
        )
    };
    let mut surfaces = vec![surface(f64::NEG_INFINITY, f64::INFINITY, 1.0, 0)];
    for (radius, thickness, index, semi) in rows {
        surfaces.push(surface(z, radius, index, semi));
        z += thickness;
    }
    surfaces.push(surface(z, f64::INFINITY, 1.0, 0));
    format!("{{\"surface_group\": {{\"surfaces\": [\n{}]}}}}", surfaces.join(",\n"))
}

/// Reads a text as the content of a file of this name.
fn parsed(name: &str, text: &str) -> Result<Prescription, LensError> {
    let folder = folder();
    read(&write(&folder, name, text))
}

/// Reads a text as the content of a file, with leave to approximate.
fn approximated(name: &str, text: &str) -> Result<Prescription, LensError> {
    let folder = folder();
    read_with(&write(&folder, name, text), &ReadContext::default().approximating(true))
}

#[test]
fn one_lens_is_the_same_in_every_format() {
    let expected = parsed("a.dat", TABLE).expect("a table");
    let focal_length = Paraxial::new(&expected).focal_length;
    let (optiland, rayoptics) = (optiland(), rayoptics::two_lenses());
    for (name, text) in [
        ("bench.txt", BENCH),
        ("a.fx", FX),
        ("iset.json", ISET),
        ("deeplens.json", DEEPLENS),
        ("geopter.json", GEOPTER),
        ("optiland.json", &optiland),
        ("rayoptics.roa", &rayoptics),
        ("a.csv", CSV),
        ("diff_optics.txt", DIFF_OPTICS),
        // The name decides nothing.
        ("renamed.dat", BENCH),
        ("renamed.txt", ISET),
    ] {
        let lens = parsed(name, text).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!((lens.rows.len(), lens.stop()), (5, 2), "{name}");
        for (row, expected) in lens.rows.iter().zip(&expected.rows) {
            let curvature = (row.curvature() - expected.curvature()).abs();
            assert!(curvature < 1e-15, "{name}: {} and {}", row.radius, expected.radius);
            assert_eq!((row.index, row.diameter), (expected.index, expected.diameter), "{name}");
        }
        let found = Paraxial::new(&lens);
        assert!((found.focal_length - focal_length).abs() < 1e-9, "{name}: {found:?}");
        assert_eq!(lens.design.film_distance, Some(40.0), "{name}");
        assert_eq!(lens.design.notes, Vec::<String>::new(), "{name}");
    }
}

#[test]
fn a_file_of_many_lenses_lists_them_and_opens_the_chosen_one() {
    let folder = folder();
    let path = write(&folder, "many.json", LENTIL);
    let error = read(&path).unwrap_err().to_string();
    for part in
        ["many.json:1:1: a file of 2 lenses", "many.json#KEY", "#0001  1950 one pair", "#0002"]
    {
        assert!(error.contains(part), "{error}");
    }
    let chosen = |entry: &str| read(&folder.path().join(format!("many.json#{entry}")));
    let expected = Paraxial::new(&parsed("a.dat", TABLE).expect("a table")).focal_length;
    for entry in ["0001", "1950 One Pair"] {
        let lens = chosen(entry).expect(entry);
        assert!((Paraxial::new(&lens).focal_length - expected).abs() < 1e-9);
    }
    let error = chosen("0003").unwrap_err().to_string();
    assert!(error.contains("no lens \"0003\" among 2"), "{error}");
    let single = write(&folder, "one.json", ISET);
    let error = read(&single.with_file_name("one.json#1")).unwrap_err().to_string();
    assert!(error.contains("the file holds one lens"), "{error}");
}
