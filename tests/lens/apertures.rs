//! Rectangular, elliptical and decentred apertures: areas, lanes, illumination, files.

use std::f64::consts::PI;
use std::path::Path;

use crate::support::sampling::irradiance_and_share;
use crate::support::{Random, folder, row, write};
use glam::DAffine3;
use petzval_base::io::ReadContext;
use petzval_base::lanes::{Real, f32x8};
use petzval_base::sampler::pixel_key;
use petzval_lens::{
    ApertureForm, Camera, Iris, LensModel, LensRay, Normalization, Prescription, PupilSampling,
    RealLens, Row, Side, SurfaceAperture, Vignetting, sequence, trace_one,
};
use petzval_lens_formats::{parse_toml, read, read_with, write_lens};

const SEQ: &str = include_str!("../fuzz/corpus/lens/singlet.seq");
const ZMX: &str = include_str!("../fuzz/corpus/lens/singlet.zmx");

fn shape(form: ApertureForm, half_widths: [f64; 2], centre: [f64; 2]) -> SurfaceAperture {
    SurfaceAperture { form, half_widths, centre, rotation: 0.0, obscures: false }
}

fn rectangle(half_widths: [f64; 2], centre: [f64; 2]) -> SurfaceAperture {
    shape(ApertureForm::Rectangle, half_widths, centre)
}

fn ellipse(half_widths: [f64; 2], centre: [f64; 2]) -> SurfaceAperture {
    shape(ApertureForm::Ellipse, half_widths, centre)
}

/// Returns a stop of diameter 2 before a clear plane.
fn stop_with(apertures: &[SurfaceAperture]) -> Prescription {
    let stop = Row { apertures: apertures.to_vec(), ..row(0.0, 1.0, 1.0, 2.0) };
    Prescription::new("aperture", vec![stop, row(f64::INFINITY, 0.0, 1.0, 4.0)]).expect("one stop")
}

fn passes(lens: &Prescription, from: Side, [x, y]: [f64; 2]) -> bool {
    let ray = LensRay::new([x, y, 0.0], [0.0, 0.0, 1.0]);
    trace_one::<f64>(ray, &sequence::<f64>(lens, from)).is_ok()
}

/// Returns the transmitted area of a stop of diameter 2, by a jittered grid.
fn area(lens: &Prescription) -> f64 {
    const CELLS: usize = 400;
    let mut random = Random::new(8);
    let surfaces = sequence::<f32>(lens, Side::Film(1.0));
    let mut place = |cell: usize| 2.0 * (cell as f64 + random.next()) / CELLS as f64 - 1.0;
    let points = (0..CELLS * CELLS).map(|i| [place(i % CELLS), place(i / CELLS)]);
    let open = points.filter(|&[x, y]| {
        let ray = LensRay::new([x as f32, y as f32, 0.0], [0.0, 0.0, 1.0]);
        trace_one::<f32>(ray, &surfaces).is_ok()
    });
    4.0 * open.count() as f64 / (CELLS * CELLS) as f64
}

#[test]
fn shapes_transmit_the_area_of_their_formula() {
    // Two circles of radius 1 whose centres are 1 apart overlap in a lens of this area.
    let overlap = 2.0 * PI / 3.0 - 3f64.sqrt() / 2.0;
    let cases: [(&str, Vec<SurfaceAperture>, f64); 8] = [
        ("rectangle", vec![rectangle([0.7, 0.3], [0.1, -0.2])], 4.0 * 0.7 * 0.3),
        ("ellipse", vec![ellipse([0.3, 0.6], [0.0, 0.2])], PI * 0.3 * 0.6),
        ("small decentred circle", vec![SurfaceAperture::circle(0.4, [0.0, 0.5])], PI * 0.16),
        ("decentred circle over the rim", vec![SurfaceAperture::circle(1.0, [-1.0, 0.0])], overlap),
        ("obscuring rectangle", vec![rectangle([0.2, 0.5], [0.3, 0.0]).obscuring()], PI - 0.4),
        ("obscuring ellipse", vec![ellipse([0.2, 0.5], [0.3, 0.0]).obscuring()], 0.9 * PI),
        (
            "both",
            vec![rectangle([0.6, 0.6], [0.0; 2]), ellipse([0.5, 0.2], [0.0; 2]).obscuring()],
            1.44 - 0.1 * PI,
        ),
        (
            "nothing in common",
            vec![rectangle([0.2; 2], [0.5, 0.0]), ellipse([0.2; 2], [-0.5, 0.0])],
            0.0,
        ),
    ];
    for (name, apertures, expected) in cases {
        let found = area(&stop_with(&apertures));
        assert!((found - expected).abs() < 1.5e-3, "{name}: {found}, expected {expected}");
    }
}

#[test]
fn the_t_stop_contains_the_shape_of_the_stop() {
    let cases = [
        ("rectangle", vec![rectangle([0.7, 0.3], [0.1, -0.2])], Iris::Round, 0.84 / PI),
        ("square", Vec::new(), Iris::Blades { count: 4, rotation: 0.0, curvature: 0.0 }, 2.0 / PI),
        ("circle", Vec::new(), Iris::Round, 1.0),
    ];
    for (name, apertures, iris, expected) in cases {
        let mut lens = stop_with(&apertures);
        lens.rows[0].iris = iris;
        let lens = RealLens::new(lens, 200.0, 1.0, PupilSampling::Pupil, 1.0, 0.0);
        let share = lens.unobstructed_share([0.0; 2]).expect("light");
        assert!((share - expected).abs() < 4e-3, "{name}: {share}, expected {expected}");
    }
}

#[test]
fn both_directions_see_the_same_side_of_a_decentred_aperture() {
    let lens = stop_with(&[rectangle([0.2, 0.1], [0.5, -0.3])]);
    for from in [Side::Film(1.0), Side::Scene(1.0)] {
        assert!(passes(&lens, from, [0.69, -0.39]) && passes(&lens, from, [0.31, -0.21]));
        for point in [[-0.5, -0.3], [0.5, 0.3], [0.71, -0.3], [0.5, -0.41], [0.0, 0.0]] {
            assert!(!passes(&lens, from, point), "{point:?}");
        }
    }
}

#[test]
fn a_mirror_clips_at_its_aperture() {
    let part = SurfaceAperture::circle(5.0, [0.0, -20.0]);
    let mirror = Row {
        mirror: true,
        stop: true,
        apertures: vec![part],
        ..row(-200.0, 0.0, 1.0, 2.0 * part.reach())
    };
    let lens = Prescription::new("off axis", vec![mirror]).expect("one stop");
    for (y, open) in [(-20.0, true), (-24.9, true), (-25.1, false), (20.0, false), (0.0, false)] {
        assert_eq!(passes(&lens, Side::Scene(50.0), [0.0, y]), open, "{y}");
    }
}

#[test]
fn eight_lanes_clip_as_one_does() {
    let mut random = Random::new(3);
    for form in [ApertureForm::Rectangle, ApertureForm::Ellipse] {
        for obscures in [false, true] {
            let one = SurfaceAperture { obscures, ..shape(form, [0.37, 0.61], [0.21, -0.13]) };
            let lens = stop_with(&[one]);
            let [single, packet] = [
                sequence::<f32>(&lens, Side::Film(1.0)),
                sequence::<f32x8>(&lens, Side::Film(1.0)),
            ];
            let mut seen = [0; 2];
            for i in 0..4000 {
                // Every other ray hits an edge to within rounding.
                let [x, y] = match i % 4 {
                    0 => [0.21 + 0.37, random.between(-0.8, 0.5)],
                    2 => [random.between(-0.2, 0.6), -0.13 - 0.61],
                    _ => [0, 1].map(|_| random.between(-1.0, 1.0)),
                };
                let (x, y) = (x as f32, y as f32);
                let alone = trace_one::<f32>(LensRay::new([x, y, 0.0], [0.0, 0.0, 1.0]), &single);
                let lanes = [x, y, 0.0].map(f32x8::splat);
                let ray = LensRay::new(lanes, [0.0, 0.0, 1.0].map(f32x8::splat));
                let eight = trace_one::<f32x8>(ray, &packet);
                assert_eq!(alone.as_ref().err(), eight.as_ref().err(), "{form:?} at {x}, {y}");
                seen[usize::from(alone.is_ok())] += 1;
                let (Ok(alone), Ok(eight)) = (alone, eight) else { continue };
                let mut lane = [0.0; 8];
                for (alone, eight) in
                    alone.p.into_iter().chain(alone.t).zip(eight.p.into_iter().chain(eight.t))
                {
                    eight.store(&mut lane);
                    assert_eq!(alone.to_bits(), lane[0].to_bits());
                }
            }
            assert!(seen.iter().all(|&count| count > 100), "{seen:?}");
        }
    }
}

/// Returns a singlet with a stop behind it, and its film distance.
fn singlet(stop: Row) -> (Prescription, f64) {
    let glass = |radius: f64, thickness: f64, index: f64| row(radius, thickness, index, 30.0);
    let rows = vec![glass(50.0, 5.0, 1.5), glass(-50.0, 3.0, 1.0), stop, row(1e9, 0.0, 1.0, 40.0)];
    (Prescription::new("singlet", rows).expect("one stop"), 46.0)
}

#[test]
fn illumination_through_a_rectangular_stop_is_that_of_its_area() {
    let round = row(0.0, 2.0, 1.0, 10.0);
    let shaped = |apertures: Vec<SurfaceAperture>| Row { apertures, ..round.clone() };
    let (open, film) = singlet(round.clone());
    let irradiance = |lens: &Prescription| {
        let vignetting = Vignetting::new(lens, film, 1 << 16);
        vignetting.budget([0.0; 2], Normalization::Stop).expect("light").irradiance
    };
    let all = irradiance(&open);
    for (name, apertures, expected) in [
        ("centred", rectangle([3.0, 2.0], [0.0; 2]), 24.0 / (25.0 * PI)),
        ("decentred", rectangle([1.0, 2.0], [2.5, 0.5]), 8.0 / (25.0 * PI)),
        ("obscured", rectangle([1.0, 2.0], [2.5, 0.5]).obscuring(), 1.0 - 8.0 / (25.0 * PI)),
    ] {
        let found = irradiance(&singlet(shaped(vec![apertures])).0) / all;
        // Off the axis of the stop rays are longer: cos^4 differs by less than a percent.
        assert!((found - expected).abs() < 0.01 * expected, "{name}: {found}, expected {expected}");
    }
}

#[test]
fn the_camera_finds_all_of_a_shaped_pupil() {
    // On the stop, and on the rear plane.
    for (place, aperture) in [
        (2, rectangle([4.0, 1.0], [0.0; 2])),
        (2, rectangle([1.0, 0.8], [2.5, -2.5])),
        (2, ellipse([1.0, 3.0], [-2.0, 0.0])),
        (2, SurfaceAperture::circle(3.0, [0.0; 2]).obscuring()),
        (3, rectangle([2.0, 1.5], [2.0, -2.0])),
        (3, ellipse([1.5, 2.0], [-2.0, 0.0])),
    ] {
        let (mut lens, film) = singlet(row(0.0, 2.0, 1.0, 10.0));
        lens.rows[3].diameter = 14.0;
        lens.rows[place].apertures = vec![aperture];
        let exposure = |sampling: PupilSampling, at: [f64; 2]| {
            let lens = RealLens::new(lens.clone(), film, 20.0, sampling, 1.0, 0.0);
            let camera = Camera {
                model: LensModel::Real(Box::new(lens)),
                film: [28.0; 2],
                world_from_camera: DAffine3::IDENTITY,
                imaging_ratio: 1.0,
                depth: [0.0, f64::INFINITY],
            };
            irradiance_and_share(&camera, at, 400, pixel_key(7, 7, 7))
        };
        for at in [[0.0, 0.0], [9.0, 4.0], [-3.0, -10.0]] {
            let (truth, _) = exposure(PupilSampling::RearDisk, at);
            let (found, share) = exposure(PupilSampling::Pupil, at);
            // 8000 rays or more of the disk pass: an error of 1 % at most.
            assert!((found / truth - 1.0).abs() < 0.02, "{aperture:?} {at:?}: {found} {truth}");
            assert!(share > 0.4, "{aperture:?} {at:?}: only {share} of the rays leave the lens");
        }
    }
}

#[test]
fn toml_holds_apertures_with_every_digit() {
    let third = 1.0 / 3.0;
    let lens = stop_with(&[
        rectangle([third, 1e-3], [-third, 1e5]),
        SurfaceAperture::circle(third, [0.0; 2]).obscuring(),
    ]);
    let path = Path::new("a.toml");
    let text = write_lens(path, &lens).expect("text").text;
    assert_eq!(parse_toml(path, &text).expect("a lens"), lens, "{text}");
    assert!(write_lens(Path::new("a.dat"), &lens).is_err());
    let error = |value: &str| {
        let text = format!("[[surface]]\nstop = true\ndiameter = 2\napertures = [{value}]\n");
        parse_toml(path, &text).expect_err(value).to_string()
    };
    for (value, expected) in [
        ("{}", "4:14: an aperture without a shape; expected shape = \"rectangle\""),
        ("{ shape = \"hexagon\" }", "4:24: shape is \"hexagon\"; expected"),
        ("{ shape = \"ellipse\" }", "4:14: an aperture without half_widths; expected"),
        ("{ shape = \"ellipse\", half_widths = [1, 0] }", "a half-width of 0 mm; expected"),
        (
            "{ shape = \"ellipse\", half_widths = [1, 1], center = [0, 0] }",
            "unknown key \"center\"",
        ),
        ("3", "an entry of apertures without keys; expected apertures = "),
    ] {
        let error = error(value);
        assert!(error.contains(expected), "{value}: {error}");
    }
}

fn parsed(name: &str, text: &str) -> Prescription {
    let folder = folder();
    read(&write(&folder, name, text)).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

#[test]
fn zemax_apertures_are_read_and_written() {
    let cases = [
        ("SQAP 3 4 0", rectangle([3.0, 4.0], [0.0; 2])),
        ("SQOB 3 4 0", rectangle([3.0, 4.0], [0.0; 2]).obscuring()),
        ("ELAP 3 4 0", ellipse([3.0, 4.0], [0.0; 2])),
        ("ELOB 3 4 0\n  OBDC 1 -2", ellipse([3.0, 4.0], [1.0, -2.0]).obscuring()),
        ("SQAP 3 4 0\n  OBDC 1 -2", rectangle([3.0, 4.0], [1.0, -2.0])),
        ("CLAP 0 4 0\n  OBDC 0 3", SurfaceAperture::circle(4.0, [0.0, 3.0])),
        ("OBSC 0 2 0\n  OBDC 0 3", SurfaceAperture::circle(2.0, [0.0, 3.0]).obscuring()),
    ];
    for (lines, expected) in cases {
        // Surface 2 has no stop, so that its diameter is that of its aperture.
        let (front, behind) = ZMX.split_once("SURF 2\n").expect("surface 2");
        let lens = parsed("a.zmx", &format!("{front}SURF 2\n  {lines}\n{behind}"));
        assert_eq!(lens.rows[1].apertures, [expected], "{lines}");
        let diameter = if expected.obscures { 16.0 } else { 2.0 * expected.reach() };
        assert_eq!(lens.rows[1].diameter, diameter, "{lines}");
        let written = write_lens(Path::new("b.zmx"), &lens).expect("a file");
        assert_eq!(written.notes, Vec::<String>::new(), "{lines}");
        assert_eq!(parsed("b.zmx", &written.text).rows[1], lens.rows[1], "{lines}");
    }
    let inches =
        ZMX.replace("UNIT MM", "UNIT IN").replace("  DIAM", "  SQAP 1 2 0\n  OBDC 3 0\n  DIAM");
    let found = &parsed("a.zmx", &inches).rows[1].apertures;
    assert_eq!(found[..], [rectangle([25.4, 50.8], [3.0 * 25.4, 0.0])]);
    let mut two = parsed("a.zmx", ZMX);
    two.rows[1].apertures = vec![rectangle([1.0; 2], [0.0; 2]), ellipse([1.0; 2], [1.0, 0.0])];
    let notes = write_lens(Path::new("b.zmx"), &two).expect("a file").notes;
    assert!(notes.iter().any(|note| note.contains("more than one aperture")), "{notes:?}");
    for (lines, expected) in [("SQAP 3 0 0", "half-width of 0"), ("SPID 3 90 0", "1 to 64 arms")] {
        let folder = folder();
        let file = write(&folder, "a.zmx", ZMX.replace("  STOP", &format!("  STOP\n  {lines}")));
        let error = read(&file).expect_err(lines).to_string();
        assert!(error.contains(expected), "{error}");
    }
}

#[test]
fn code_v_apertures_are_read() {
    for (commands, expected) in [
        ("REX 3; REY 4", vec![rectangle([3.0, 4.0], [0.0; 2])]),
        ("REX 3; REY 4; ADX 1; ADY -2", vec![rectangle([3.0, 4.0], [1.0, -2.0])]),
        ("ELX 3; ELY 4", vec![ellipse([3.0, 4.0], [0.0; 2])]),
        ("CIR 3; ADY 2", vec![SurfaceAperture::circle(3.0, [0.0, 2.0])]),
        ("CIR 3", vec![]),
        ("REX OBS 1; REY OBS 2; ADY OBS 3", vec![rectangle([1.0, 2.0], [0.0, 3.0]).obscuring()]),
        ("CIR OBS 1; ADX OBS 3", vec![SurfaceAperture::circle(1.0, [3.0, 0.0]).obscuring()]),
        ("REX EDG 1; REY EDG 2; ADY EDG 3; CIR 3", vec![]),
    ] {
        let (front, behind) = SEQ.split_once("S -50.0 49.0\n").expect("surface 2");
        let behind = behind.replacen("  CIR 8.0\n", &format!("  {commands}\n"), 1);
        let lens = parsed("a.seq", &format!("{front}S -50.0 49.0\n{behind}"));
        assert_eq!(lens.rows[1].apertures, expected, "{commands}");
        let open = expected.iter().find(|aperture| !aperture.obscures);
        if let Some(open) = open {
            assert_eq!(lens.rows[1].diameter, 2.0 * open.reach(), "{commands}");
        }
        assert_eq!((lens.rows[1].iris.clone(), lens.rows[1].obstruction), (Iris::Round, 0.0));
    }
    let disk = parsed("a.seq", &SEQ.replacen("  CIR 8.0", "  CIR 8.0\n  CIR OBS 2", 1));
    assert_eq!((disk.rows[0].obstruction, disk.rows[0].apertures.len()), (4.0, 0));
    for command in ["REX 3", "REX 3; REY 4; ARO 30"] {
        let folder = folder();
        let text = SEQ.replacen("  CIR 8.0", &format!("  CIR 8.0\n  {command}"), 1);
        let file = write(&folder, "a.seq", text);
        let error = read(&file).expect_err(command).to_string();
        assert!(error.contains("surface 1") && error.contains("'approximate'"), "{error}");
        assert!(read_with(&file, &ReadContext::default().approximating(true)).is_ok());
    }
}

/// Share of the light of a stop of 20 mm that the arms of a spider block: a file of a stop and a lens.
fn blocked_by_spider(line: &str) -> (f64, Prescription) {
    let text = ZMX.replace("  STOP", &format!("  STOP\n  {line}"));
    let with = parsed("spider.zmx", &text);
    let mut without = with.clone();
    for row in &mut without.rows {
        row.apertures.clear();
    }
    let film = 60.0;
    let light = |lens: &Prescription| {
        let vignetting = Vignetting::new(lens, film, 1 << 16);
        vignetting.budget([0.0; 2], petzval_lens::Normalization::Rear).expect("light").irradiance
    };
    (1.0 - light(&with) / light(&without), with)
}

#[test]
fn the_arms_of_a_spider_take_their_area_from_the_light() {
    for (line, arms, width) in
        [("SPID 0.5 4", 4.0, 0.5), ("SPID 1 3 0", 3.0, 1.0), ("SPID 2 1", 1.0, 2.0)]
    {
        let (share, lens) = blocked_by_spider(line);
        let radius = lens.rows[lens.stop()].diameter / 2.0;
        // Arms from the vertex to the rim, without their overlap in the middle: a few widths squared.
        let area = std::f64::consts::PI * radius * radius;
        let (most, least) = (arms * width * radius / area, arms * width * (radius - width) / area);
        assert!(share < most * 1.02 && share > least * 0.98, "{line}: {share}, {least} to {most}");
        // The pupil is sampled as that of the open lens, so that no light beside an arm is missed.
        let film = petzval_lens::RealRayFocus::new(&lens).film_distance(f64::INFINITY).unwrap();
        let real = RealLens::new(lens.clone(), film, 1.0, PupilSampling::Pupil, 1.0, 0.0);
        let left = real.unobstructed_share([0.0; 2]).expect("light");
        assert!((1.0 - left - share).abs() < 0.015, "{line}: {left}, and {share} is blocked");
        // Focus and f-number are those of the lens without arms, which lie along x and y.
        let mut open = lens.clone();
        open.rows.iter_mut().for_each(|row| row.apertures.clear());
        let f_number = |lens: &Prescription| petzval_lens::RealRayFocus::new(lens).f_number();
        assert!(f_number(&lens).is_some() && f_number(&lens) == f_number(&open), "{line}");
    }
}

#[test]
fn rotated_apertures_agree_with_their_definition_and_survive_toml() {
    let arm = SurfaceAperture::arm(2.0, 10.0, 30.0);
    let (sin, cos) = 30f64.to_radians().sin_cos();
    let at = |along: f64, across: f64| {
        arm.transmits(along * cos - across * sin, along * sin + across * cos)
    };
    assert!(!at(1.0, 0.9) && !at(9.9, -0.9) && at(1.0, 1.1) && at(10.1, 0.0) && at(-0.1, 0.0));
    let lens = stop_with(&[arm]);
    let text = write_lens(Path::new("a.toml"), &lens).expect("a file").text;
    assert!(text.contains("rotation = 30.0"), "{text}");
    assert_eq!(parse_toml("a.toml".as_ref(), &text).expect("a lens").rows[0].apertures, [arm]);
}

#[test]
fn a_user_defined_aperture_is_a_warning_that_says_what_it_costs() {
    for keyword in ["UDAD", "USAP", "USOB"] {
        let text = ZMX.replace("  STOP", &format!("  STOP\n  {keyword} 0 0 0"));
        let notes = parsed("user.zmx", &text).design.notes;
        let said = notes.iter().any(|note| note.contains(keyword) && note.contains("block passes"));
        assert!(said, "{notes:?}");
    }
}
