//! Lens files of optical-design programs: one lens in three formats, what is refused, and damage.

use crate::support::{folder, petzval, write};
use petzval_base::io::ReadContext;
use petzval_lens::{LensError, LensRay, Paraxial, Prescription, Side, Zoom, sequence, trace_one};
use petzval_lens_formats::{LensOptions, read, read_with};

const ZMX: &str = include_str!("../fuzz/corpus/lens/singlet.zmx");
const SEQ: &str = include_str!("../fuzz/corpus/lens/singlet.seq");
const OSLO: &str = include_str!("../fuzz/corpus/lens/singlet.len");

fn parsed(name: &str, text: impl AsRef<[u8]>) -> Result<Prescription, LensError> {
    let folder = folder();
    read(&write(&folder, name, text))
}

fn approximated(name: &str, text: &str) -> Prescription {
    let folder = folder();
    let context = ReadContext::default().approximating(true);
    read_with(&write(&folder, name, text), &context).expect("an approximation")
}

fn focal_length(lens: &Prescription) -> f64 {
    Paraxial::new(lens).focal_length
}

/// Focal length of a lens of radii 50 and -50 mm, thickness 5 mm and index 1.5, by the lensmaker's
/// equation.
fn lensmaker() -> f64 {
    let (r1, r2, d, n) = (50.0, -50.0, 5.0, 1.5);
    1.0 / ((n - 1.0) * (1.0 / r1 - 1.0 / r2 + (n - 1.0) * d / (n * r1 * r2)))
}

#[test]
fn one_lens_in_three_formats_has_the_focal_length_of_the_lensmaker() {
    for (name, text) in [("a.zmx", ZMX), ("a.seq", SEQ), ("a.len", OSLO)] {
        let lens = parsed(name, text).expect(name);
        assert!((focal_length(&lens) - lensmaker()).abs() < 1e-9, "{name}");
        assert_eq!((lens.name.as_str(), lens.rows.len(), lens.stop()), ("singlet", 2, 0), "{name}");
        assert_eq!(lens.design.film_distance, Some(49.0), "{name}");
        assert_eq!(lens.design.object_distance, Some(f64::INFINITY), "{name}");
    }
}

#[test]
fn content_decides_and_units_scale_everything() {
    assert!((focal_length(&parsed("a.dat", ZMX).expect("by content")) - lensmaker()).abs() < 1e-9);
    for (name, text, unit) in [
        ("a.zmx", ZMX.replace("UNIT MM", "UNIT IN"), 25.4),
        ("a.seq", SEQ.replace("DIM M", "DIM C"), 10.0),
        ("a.len", OSLO.replace("UNI 1.0", "UNI 25.4"), 25.4),
    ] {
        let lens = parsed(name, text).expect(name);
        assert!((focal_length(&lens) - unit * lensmaker()).abs() < 1e-9 * unit, "{name}");
    }
}

#[test]
fn terms_that_are_not_simulated_are_named_and_noted_if_allowed() {
    let cases = [
        ("a.zmx", ZMX.replace("EVENASPH", "GRINSUR3"), ":15:8: surface 1 of the type GRINSUR3"),
        ("a.seq", SEQ.replace("  STO\n", "  STO\n  YTO\n"), ":16:3: the command YTO"),
        ("a.len", OSLO.replace("AST", "AST\nCVX 0.1"), ":15:5: the command CVX"),
    ];
    for (name, text, expected) in cases {
        let error = parsed(name, &text).expect_err(name).to_string();
        assert!(error.contains(expected) && error.contains("'approximate'"), "{error}");
        let notes = approximated(name, &text).design.notes;
        assert!(notes.iter().any(|note| note.contains("not simulated")), "{name}: {notes:?}");
    }
    let grating = ZMX.replace("EVENASPH", "DGRATING");
    assert!(parsed("a.zmx", grating).is_ok(), "a grating without lines");
}

#[test]
fn malformed_and_damaged_files_are_errors() {
    let wide: Vec<u8> = ZMX.encode_utf16().flat_map(u16::to_le_bytes).collect();
    assert!(parsed("a.zmx", &wide).is_ok());
    let error = |name: &str, text: &str| parsed(name, text).expect_err(name).to_string();
    assert!(error("a.zmx", &ZMX.replace("CURV 0.02", "CURV x")).contains(":16:8: \"x\""));
    assert!(error("a.zmx", &ZMX.replace("MODE SEQ", "MODE NSC")).contains("MODE SEQ"));
    assert!(error("a.zmx", &ZMX.replace("DISZ 5\n", "DISZ 1e300\n")).contains("thickness"));
    for (name, text) in [("a.zmx", ZMX), ("a.seq", SEQ), ("a.len", OSLO)] {
        for end in 0..text.len() {
            let _ = parsed(name, &text[..end]);
        }
    }
    for end in (0..wide.len()).step_by(7) {
        let _ = parsed("a.zmx", &wide[..end]);
    }
    for (name, head, part) in [
        ("a.zmx", "MODE SEQ\n", "SURF 1\n"),
        ("a.seq", "RDM\n", "S 0 0\n"),
        ("a.len", "LEN NEW \"\" 1 1\n", "NXT\n"),
    ] {
        let many = head.to_owned() + &part.repeat(100_000);
        assert!(error(name, &many).contains("more than 1000 surfaces"), "{name}");
    }
}

/// Reads a singlet whose surface 1 has these lines in place of its own.
fn with_front(lines: &str) -> Prescription {
    let (before, rest) = ZMX.split_once("SURF 1\n").expect("surface 1");
    let (_, behind) = rest.split_once("SURF 2\n").expect("surface 2");
    parsed("a.zmx", format!("{before}SURF 1\n{lines}SURF 2\n{behind}")).expect("a lens")
}

#[test]
fn germanium_has_its_index_in_the_far_infrared_and_none_in_visible_light() {
    let infrared = ZMX
        .replace("WAVM 1 0.5875618 1", "WAVM 1 10.0 1")
        .replace("GLAS ___BLANK 1 0 1.5 60 0", "GLAS GERMANIUM 0 0 1.5 40 0");
    let lens = parsed("a.zmx", &infrared).expect("an infrared lens");
    // Index at 10 um: Icenogle, Platt and Wolfe 1976, Appl. Opt. 15, 2348: 4.0043 at 20 degrees.
    assert!((lens.rows[0].index - 4.004).abs() < 2e-3, "{}", lens.rows[0].index);
    assert_eq!(lens.design.primary_wavelength(), 10_000.0);
    let visible = infrared.replace("WAVM 1 10.0 1", "WAVM 1 0.55 1");
    let error = parsed("a.zmx", &visible).expect_err("opaque").to_string();
    assert!(error.contains("not at 550 nm") && error.contains("'wavelengths'"), "{error}");
    let lens = approximated("a.zmx", &visible);
    assert!(lens.design.notes.iter().any(|note| note.contains("nearest end")));
    let folder = folder();
    let path = write(&folder, "a.zmx", &visible);
    let chosen = LensOptions { wavelengths: vec![8e3, 10e3, 12e3], ..LensOptions::default() };
    let lens = chosen.read(&path, &ReadContext::default()).expect("at 10 um");
    assert!((lens.rows[0].index - 4.004).abs() < 2e-3);
}

#[test]
fn an_extended_asphere_counts_its_terms_in_units_of_its_radius() {
    let lens = with_front(
        "  STOP\n  TYPE XASPHERE\n  CURV 0.02\n  XDAT 1 2 0 0\n  XDAT 2 10 0 0\n  XDAT 3 0.5 0 0\n  \
         XDAT 4 -0.25 0 0\n  XDAT 5 9 0 0\n  DISZ 5\n  GLAS ___BLANK 1 0 1.5 60 0\n  DIAM 8 1\n",
    );
    let expected = [(2, 0.5 / 100.0), (4, -0.25 / 1e4)];
    assert_eq!(lens.rows[0].asphere.len(), 2, "the third term is not counted");
    for ((power, a), (expected_power, b)) in lens.rows[0].asphere.iter().zip(expected) {
        assert!(*power == expected_power && (a - b).abs() < 1e-18);
    }
}

#[test]
fn biconics_and_toroids_have_their_radius_along_x() {
    for kind in ["BICONICX", "TOROIDAL"] {
        let lens = with_front(&format!(
            "  STOP\n  TYPE {kind}\n  CURV 0.02\n  PARM 1 25\n  DISZ 5\n  \
             GLAS ___BLANK 1 0 1.5 60 0\n  DIAM 8 1\n"
        ));
        let [x, y] = lens.rows[0].curvatures();
        assert!((x - 0.04).abs() < 1e-15 && (y - 0.02).abs() < 1e-15, "{kind}: {x} {y}");
    }
}

/// Traces the ray along the axis of the scene to the rear vertex: position and direction there.
fn axial_ray(lens: &Prescription) -> ([f64; 3], [f64; 3]) {
    let surfaces = sequence::<f64>(lens, Side::Scene(10.0));
    let start = LensRay::<f64>::new([0.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
    let end = trace_one::<f64>(start, &surfaces).expect("passes");
    (end.p, end.t)
}

#[test]
fn a_coordinate_break_moves_all_that_follows() {
    let broken = |parameters: &str, after: &str| {
        let (before, rest) = ZMX.split_once("SURF 1\n").expect("surface 1");
        parsed(
            "a.zmx",
            format!("{before}SURF 1\n  TYPE COORDBRK\n{parameters}  DISZ 0\n{after}SURF 9\n{rest}"),
        )
        .expect("a lens")
    };
    // The lens stands 1 mm higher: the ray meets it below its axis and is bent upwards.
    let (p, t) = axial_ray(&broken("  PARM 2 1\n", ""));
    assert!(p[1] < -0.9 && p[1] > -1.0 && t[1] > 0.01, "{p:?} {t:?}");
    let (p, t) = axial_ray(&broken("  PARM 1 1\n", ""));
    assert!(p[0] < -0.9 && t[0] > 0.01, "{p:?} {t:?}");
    // A lens tilted about x by a positive angle: right-handed, +y turns towards +z. In its axes the
    // ray then goes towards +y.
    let (_, t) = axial_ray(&broken("  PARM 3 2\n", ""));
    assert!(t[1] > 0.0, "{t:?}");
    // A fold by a mirror between two breaks of 45 degrees is no change on the axis.
    let fold = broken(
        "  PARM 3 45\n",
        "SURF 7\n  TYPE STANDARD\n  DISZ 0\n  GLAS MIRROR 0 0\n  DIAM 20 1\nSURF 8\n  TYPE COORDBRK\n  \
         PARM 3 45\n  DISZ -30\n",
    );
    // Behind a mirror the media and spaces of the file are negative.
    assert_eq!(fold.rows[0].thickness, -30.0);
    assert!(fold.rows[0].mirror && fold.is_misaligned());
}

#[test]
fn a_cover_glass_that_touches_the_film_holds_the_film() {
    let (before, _) = ZMX.split_once("SURF 3\n").expect("surface 3");
    let text = format!(
        "{}SURF 3\n  TYPE STANDARD\n  DISZ 1\n  GLAS ___BLANK 1 0 1.5 60 0\n  DIAM 8 1\nSURF 4\n  \
         TYPE STANDARD\n  DISZ 0\n  DIAM 8 1\nSURF 5\n  TYPE STANDARD\n  DISZ 0\n",
        before.replace("DISZ 49", "DISZ 48")
    );
    let lens = parsed("a.zmx", text).expect("a lens");
    assert_eq!((lens.rows.len(), lens.rear().index), (3, 1.5));
    assert_eq!(lens.design.film_distance, Some(1.0));
    assert!(lens.design.notes.iter().any(|note| note.contains("touches the film")));
    // The image distance in air is 1 mm / 1.5 longer than to the cover.
    let behind = Paraxial::new(&lens).back_focal_distance / 1.5 + 48.0;
    let bare = Paraxial::new(&parsed("b.zmx", ZMX).expect("a lens")).back_focal_distance;
    assert!((behind - bare).abs() < 1e-9, "{behind} {bare}");
}

#[test]
fn an_ignored_surface_is_left_out_with_its_space() {
    let ignored =
        "SURF 1\n  TYPE STANDARD\n  IGNR 1\n  CURV 0.1\n  DISZ 7\n  GLAS ___BLANK 1 0 1.7 30 0\n";
    let text = ZMX.replacen("SURF 1\n", &format!("{ignored}SURF 2\n"), 1);
    let lens = parsed("a.zmx", &text).expect("a lens");
    assert_eq!(lens.rows.len(), 2);
    assert!((focal_length(&lens) - lensmaker()).abs() < 1e-9);
    assert_eq!(lens.design.notes, ["surface 1 is ignored, as the file says"]);
    let kept = parsed("a.zmx", text.replace("IGNR 1", "IGNR 0")).expect("a lens");
    assert_eq!(kept.rows.len(), 3);
}

#[test]
fn special_surfaces_and_zoomed_glasses_of_code_v_are_refused_by_name() {
    for (line, part) in [
        ("SPS ODD", "the command SPS ODD of a surface is not simulated"),
        ("GLA NBK7_SCHOTT NSF6_SCHOTT", "a zoomed glass is not simulated"),
    ] {
        let at = SEQ.find("\nSI ").expect("an image");
        let text = format!("{}\n{line}{}", &SEQ[..at], &SEQ[at..]);
        let error = parsed("a.seq", &text).expect_err(line).to_string();
        assert!(error.contains(part), "{error}");
    }
}

#[test]
fn surfaces_without_rdm_state_curvatures_unless_these_are_impossible() {
    let text = "tit 'meniscus'\ndim m\nso 0. 1.0e+10\ns 0. 2.0\nsto\ns -0.19 0.3 517642\n\
                s -0.38 9.6\nsi 0 0\nepd 1.0\nwl 587.6\nyan 0 10\n";
    let lens = parsed("a.seq", text).expect("a lens");
    let radii = |lens: &Prescription| lens.rows.iter().map(|row| row.radius).collect::<Vec<_>>();
    assert_eq!(radii(&lens)[1..], [-1.0 / 0.19, -1.0 / 0.38]);
    let stated =
        parsed("a.seq", format!("RDM\n{}", text.replace("-0.19", "-5").replace("-0.38", "-3")));
    assert_eq!(radii(&stated.expect("a lens"))[1..], [-5.0, -3.0]);
    assert!(lens.design.notes.iter().all(|note| !note.contains("RDM")));
    // Hand-written files leave RDM out and mean radii: a beam of 10 mm passes no radius of 0.05 mm.
    let text = "EPD 10\nWL 587.6\nSO 0 inf\nS 22 4 620603\nSTO\nS -435 40\nSI 0 0\n";
    let lens = parsed("a.seq", text).expect("a lens");
    assert_eq!(radii(&lens), [22.0, -435.0]);
    assert!(lens.design.notes.iter().any(|note| note.contains("no RDM")));
    // What follows the line of the surface counts.
    let lens = parsed("a.seq", text.replace("STO\n", "STO\nRDY 25\n")).expect("a lens");
    assert_eq!(lens.rows[0].radius, 25.0);
    assert_eq!(
        radii(&parsed("a.seq", text.replace("S -435", "RDM;S -inf")).expect("a plane"))[1],
        f64::INFINITY
    );
}

const ZOOM: &str = "MNUM 2 1\nTHIC 2 1 10 0 0 0 1 1 1 0 0\nTHIC 2 2 49 0 0 0 1 1 1 0 0\n\
                    CRVT 2 1 -0.01 0 0 0\nCRVT 2 2 -0.02 0 0 0\nAPER 0 1 8 0 0\nAPER 0 2 10 0 0\n";

#[test]
fn the_operands_of_the_current_configuration_hold() {
    let both = |current: &str| {
        let text = format!("{ZMX}{}", ZOOM.replace("MNUM 2 1", &format!("MNUM 2 {current}")));
        parsed("a.zmx", text).expect("a lens")
    };
    let [first, second] = [both("1"), both("2")];
    assert_eq!((first.rows[1].radius, second.rows[1].radius), (-100.0, -50.0));
    assert_eq!((first.design.film_distance, second.design.film_distance), (Some(10.0), Some(49.0)));
    let pupil = |lens: &Prescription| Paraxial::new(lens).entrance_pupil.diameter / 2.0;
    assert!((pupil(&first) - 4.0).abs() < 1e-9 && (pupil(&second) - 5.0).abs() < 1e-9);
    for (lens, name) in [(&first, "1"), (&second, "2")] {
        let note = format!("configuration {name} of 2");
        assert!(lens.design.notes.iter().any(|text| text.contains(&note)), "{name}");
        assert_eq!(lens.design.configurations.len(), 2);
        let zoomed = |state: &str| lens.at_zoom(&Zoom::State(state.into())).expect("a state").0;
        assert_eq!([zoomed("1").rows[1].radius, zoomed("2").rows[1].radius], [-100.0, -50.0]);
    }
}

#[test]
fn a_tilted_image_tilts_the_film() {
    let tilted = |image: &str| {
        let (lens, _) = ZMX.split_once("SURF 3\n").expect("an image");
        parsed("a.zmx", format!("{lens}SURF 3\n{image}")).expect("a lens")
    };
    let film = |lens: &Prescription| lens.film_axis().matrix3.z_axis;
    let by_break = tilted("  TYPE COORDBRK\n  PARM 3 20\n  DISZ 0\nSURF 4\n  DISZ 0\n");
    let tangent = 20f64.to_radians().tan();
    let by_type = tilted(&format!("  TYPE TILTSURF\n  PARM 1 0\n  PARM 2 {tangent}\n  DISZ 0\n"));
    assert!(film(&by_break).abs_diff_eq(film(&by_type), 1e-12));
    assert!((film(&by_type).z - 20f64.to_radians().cos()).abs() < 1e-12);
    assert!(film(&tilted("  TYPE TILTSURF\n  DISZ 0\n")).z == 1.0);
    for lens in [by_break, by_type] {
        assert!(lens.to_string().contains("film: decentred by"), "{lens}");
    }
    let surface = with_front(
        "  STOP\n  TYPE TILTSURF\n  PARM 1 0.1\n  DISZ 5\n  GLAS ___BLANK 1 0 1.5 60 0\n  DIAM 8 1\n",
    );
    assert!((surface.rows[0].pose.tilt[1] + 0.1f64.atan().to_degrees()).abs() < 1e-12);
}

#[test]
fn infinity_is_a_radius_a_distance_and_an_outer_rim() {
    let annulus =
        with_front("  STOP\n  DISZ 5\n  GLAS ___BLANK 1 0 1.5 60 0\n  DIAM 8 1\n  CLAP 3 INF 0\n");
    assert_eq!((annulus.rows[0].obstruction, annulus.rows[0].diameter), (6.0, 10.0));
    assert!(parsed("a.zmx", ZMX.replace("DISZ INFINITY", "DISZ inf")).is_ok());
    let bench = "[descriptive data]\ntitle\tx\n[variable distances]\nFocal Length\t50\nd0\tInfinity\n\
                 Bf\t47\n[lens data]\n1\t50\t4\t1.5168\t20\t64.2\n2\t-Infinity\t1\t\t20\n3\tAS\tBf\t\t15\n";
    assert!(parsed("a.txt", bench).expect("a lens").rows[1].radius.is_infinite());
    let table = "50 6 1.5168 24\ninf 4 1 24\n0 6 0 12\n-45 5 1.62 20\n-60 0 1 20\n";
    let lens = parsed("a.dat", table).expect("a lens");
    assert!(lens.rows[1].radius.is_infinite() && lens.stop() == 2);
    assert!(parsed("a.dat", table.replace("4 1 24", "inf 1 24")).is_err());
    // Index 0 behind a second plane is air.
    let filter = parsed("a.dat", "50 6 1.5 24\n-50 4 1 24\n0 6 1 12\n0 1 1.5 20\n0 9 0 20\n");
    assert_eq!(filter.expect("a lens").rows.last().map(|row| row.index), Some(1.0));
}

#[test]
fn media_may_be_thinner_than_air_and_model_glasses_of_negative_index_reflect() {
    let gas = parsed(
        "a.zmx",
        ZMX.replace("  CURV -0.02\n", "  CURV -0.02\n  GLAS ___BLANK 1 0 0.999712 0\n"),
    );
    assert_eq!(gas.expect("a lens").rows[1].index, 0.999712);
    let mirror =
        with_front("  STOP\n  CURV -0.005\n  DISZ -100\n  GLAS ___BLANK 1 0 -1 0\n  DIAM 20 1\n");
    assert!(mirror.rows[0].mirror);
    assert!(parsed("a.zmx", ZMX.replace("0 1.5 60", "0 0.5 60")).is_err());
    let waves =
        ZMX.replace("WAVM 1 0.5875618 1", "WAVM 1 3000 1").replace("0 1.5 60 0", "0 1.5 0 0");
    assert_eq!(parsed("a.zmx", waves).expect("a lens").design.primary_wavelength(), 3e6);
    let json = "{\"name\":\"x\",\"type\":\"multi element lens\",\"surfaces\":[\
        {\"radius\":50,\"thickness\":4,\"ior\":1.5168,\"semi_aperture\":10,\"conic_constant\":[]},\
        {\"radius\":-50,\"thickness\":1,\"ior\":1,\"semi_aperture\":10,\"conic_constant\":[]},\
        {\"radius\":0,\"thickness\":40,\"ior\":0,\"semi_aperture\":6,\"conic_constant\":[]}]}";
    assert_eq!(parsed("a.json", json).expect("a lens").rows[0].conic, 0.0);
}

const TABLE: &str = "# radius thickness material [nd Vd] housing radius\n22.0 3.2 abbe 1.6204 60.3 8.0\n\
    -430.0 6.0 air 8.0\n-22.2 1.0/2.0/3.0 abbe 1.6200 36.4 5.0\n20.3 1.0 air 5.0\n\
    100000 4.0 iris 4.6\n79.0 3.0 abbe 1.6204 60.3 7.5 #!aspheric=0,1e-6,0,0,0\n-18.4 42.0 air 7.5\n";

#[test]
fn tables_of_polynomial_optics_are_read() {
    let lens = parsed("own.fx", TABLE).expect("a lens");
    let paraxial = Paraxial::new(&lens);
    assert!((paraxial.focal_length - 49.4458).abs() < 1e-4, "{}", paraxial.focal_length);
    assert!((paraxial.back_focal_distance - 42.1956).abs() < 1e-4);
    assert_eq!((lens.stop(), lens.rows[4].diameter), (4, 9.2));
    assert_eq!(lens.rows[5].asphere, [(4, 1e-6)]);
    let long = lens.at_zoom(&Zoom::State("long".into())).expect("a zoom").0;
    assert_eq!((lens.rows[2].thickness, long.rows[2].thickness), (1.0, 3.0));
    let double = parsed("own.fx", format!("#!scale 2\n{TABLE}")).expect("a lens");
    assert!((Paraxial::new(&double).focal_length - 2.0 * paraxial.focal_length).abs() < 1e-9);
    let cylinder = parsed("own.fx", TABLE.replace("8.0\n-430.0 6.0 air", "8.0\n-430.0 6.0 cx_air"));
    assert!(cylinder.expect("a lens").rows[1].axis.is_some());
    for (bad, part) in [
        (TABLE.replace("22.0 3.2 abbe", "22.0 abbe"), ":2:"),
        (TABLE.replace("air 5.0", "air"), ":5:1: 3 columns"),
        (TABLE.replace("=0,1e-6,0,0,0", "=0,1e-6"), "aspheric coefficients"),
        (TABLE.replace("1.6204 60.3 8.0", "0.5 60.3 8.0"), "index 0.5"),
        (TABLE.replace("1.0/2.0/3.0", "1/2/3/4"), "4 thicknesses"),
    ] {
        let error = parsed("own.fx", &bad).expect_err(part).to_string();
        assert!(error.contains(part), "{part}: {error}");
    }
}

#[test]
fn a_name_of_several_makers_is_a_warning_that_names_them() {
    let named =
        |glass: &str| ZMX.replace("___BLANK 1 0 1.5 60 0", &format!("{glass} 0 0 1.5 40 0"));
    let warned = |lens: &Prescription| {
        lens.design.notes.iter().any(|note| note.contains("CDGM F2") && note.contains("Schott F2"))
    };
    assert!(warned(&parsed("a.zmx", named("F2")).expect("a lens")));
    let preferred = named("F2").replace("ENPD 10", "GCAT SCHOTT CDGM\nENPD 10");
    assert!(!warned(&parsed("a.zmx", preferred).expect("a lens")));
    for (glass, expected) in [("F2", true), ("Schott F2", false)] {
        let toml = format!(
            "[[surface]]\nradius = 50\nthickness = 5\ndiameter = 10\nglass = \"{glass}\"\n\
             [[surface]]\nradius = 0\ndiameter = 10\nstop = true\n"
        );
        assert_eq!(warned(&parsed("a.toml", toml).expect("a lens")), expected, "{glass}");
    }
    for plastic in ["OKP4", "COC", "TOPAS", "APL5014", "EP5000", "SP1516"] {
        assert!(parsed("a.zmx", named(plastic)).is_ok(), "{plastic}");
    }
}

#[test]
fn an_index_that_is_taken_as_rounded_is_noted() {
    let table = "radius;thickness;material;index;v-no;sa\n50;5;BK7;1.517;64.2;10\n-50;2;air;;;10\n;40;air;;;8\n";
    let lens = parsed("a.csv", table).expect("a lens");
    assert!(
        lens.design.notes.iter().any(|note| note.contains("1.517") && note.contains("1.51680"))
    );
}

#[test]
fn a_faulty_glass_is_an_error_only_where_it_is_used() {
    let good = "CD 1.03961212 0.00600069867 0.231792344 0.0200179144 1.01046945 103.560653\n";
    let catalogue = format!(
        "NM GOODGLASS 2 517642 1.5168 64.17 0 1\n{good}LD 0.3 2.5\nNM BADGLASS 2 517642 1.5168 64.17\n\
         {good}LD 0.365 0.000\nNM UNKNOWN 99\n{good}LD 0.3 2.5\n"
    );
    let folder = folder();
    let agf = write(&folder, "own.agf", catalogue);
    let context = ReadContext::default().with_catalogues([agf]);
    let named =
        |glass: &str| ZMX.replace("___BLANK 1 0 1.5 60 0", &format!("{glass} 0 0 1.5 40 0"));
    let with = |glass: &str| read_with(&write(&folder, "a.zmx", named(glass)), &context);
    assert!((with("GOODGLASS").expect("a lens").rows[0].index - 1.5168).abs() < 1e-4);
    let error = with("BADGLASS").expect_err("a range without length").to_string();
    assert!(
        error.contains("\"BADGLASS\" cannot be used") && error.contains("own.agf:6"),
        "{error}"
    );
    let error = with("UNKNOWN").expect_err("no formula").to_string();
    assert!(error.contains("formula \"99\""), "{error}");
}

#[test]
fn names_reach_the_terminal_without_escape_sequences_and_hidden_characters() {
    let folder = folder();
    let toml = "name = \"a\\u001b[31mred\\u202Edlog\"\n[[surface]]\nradius = 50\nthickness = 5\ndiameter = 10\n\
                index = 1.5\n[[surface]]\nradius = 0\ndiameter = 10\nstop = true\n";
    write(&folder, "a.toml", toml);
    write(&folder, "bad.zmx", "MODE SEQ\nUNIT \u{1b}[2J\u{202e}MM\n");
    for (file, code) in [("a.toml", 0), ("bad.zmx", 2)] {
        let (exit, stdout, stderr) = petzval(folder.path(), &["lens", file]);
        assert_eq!(exit, code, "{stderr}");
        let hidden = |c: char| (c.is_control() && c != '\n') || c == '\u{202e}';
        assert!(!stdout.contains(hidden) && !stderr.contains(hidden), "{stdout:?} {stderr:?}");
        assert_eq!(stdout.contains("a\\u001B[31mred\\u202Edlog"), code == 0, "{stdout}");
    }
}

/// An object inside a medium is read as standing in air at a window: the image is where first-order
/// optics of the file's own medium puts it.
#[test]
fn an_object_inside_a_medium_touches_a_window() {
    let (n, distance, fields) = (1.333, 200.0, "object stands in a medium of index 1.3330");
    let water = format!("GLAS ___BLANK 1 0 {n} 0 0");
    let near = ZMX.replacen("DISZ INFINITY", &format!("DISZ {distance}\n  {water}"), 1);
    let lens = parsed("water.zmx", &near).expect("an object in water");
    assert!(lens.design.notes.iter().any(|note| note.contains(fields)), "{:?}", lens.design.notes);
    // n' / s' = n / s + power, at both surfaces of the lens of radii 50 and -50 mm.
    let first = (-n / distance + (1.5 - n) / 50.0) / 1.5;
    let second = 1.5 / (1.0 / first - 5.0) + (1.0 - 1.5) / -50.0;
    let expected = 1.0 / second;
    let found = Paraxial::new(&lens).image_distance(lens.design.object_distance.expect("near"));
    assert!((found / expected - 1.0).abs() < 1e-5, "{found}, not {expected}");
    let in_air = parsed("air.zmx", near.replace(&water, "")).expect("an object in air");
    let in_air = Paraxial::new(&in_air).image_distance(distance);
    assert!((found - in_air).abs() > 1.0, "water moves the image: {found} and {in_air}");

    // A real ray from the object point on the axis obeys the law of refraction at the first surface.
    let start = lens.design.object_distance.expect("near");
    let surfaces = sequence::<f64>(&lens, Side::Scene(start));
    let slope = 1e-4;
    let air = n * slope;
    let ray = LensRay::new([0.0; 3], [air, 0.0, (1.0f64 - air * air).sqrt()]);
    let ray = trace_one::<f64>(ray, &surfaces).expect("passes");
    let crossing = ray.p[2] - ray.p[0] * ray.t[2] / ray.t[0];
    assert!((crossing / expected - 1.0).abs() < 1e-4, "{crossing}, not {expected}");
}

#[test]
fn field_angles_in_a_medium_become_those_in_air() {
    let water = "GLAS ___BLANK 1 0 1.333 0 0";
    let far = ZMX.replacen("DISZ INFINITY", &format!("DISZ INFINITY\n  {water}"), 1);
    let far = far.replacen("SURF 0", "FTYP 0 0 3 1\nXFLN 0 0 0\nYFLN 0 10 60\nSURF 0", 1);
    let lens = parsed("water.zmx", &far).expect("an object in water");
    let fields = lens.design.fields.expect("fields").points;
    assert_eq!(fields.len(), 2, "60 degrees are reflected totally: {fields:?}");
    let expected = (1.333 * 10f64.to_radians().sin()).asin().to_degrees();
    assert!((fields[1][1] - expected).abs() < 1e-9, "{fields:?}");
    let seq = SEQ.replacen("SO 0.0 0.1e14", "SO 0.0 0.1e14 N-BK7", 1);
    assert_ne!(seq, SEQ);
    let lens = parsed("a.seq", seq).expect("an object in glass");
    assert!(lens.design.notes.iter().any(|note| note.contains("medium of index 1.51")));
}
