//! `petzval lens --draw`: the SVG drawing of a lens, read back.

use std::path::Path;
use std::process::Command;

use crate::support::{LENSES, folder, lens, oracle, root};
use petzval_lens::{Prescription, RealRayFocus};
use roxmltree::{Document, Node};

/// Rounding of coordinates to two decimals, px.
const ROUNDING: f64 = 0.011;

/// Returns the drawing of a course lens, focused at infinity, with film of the 35 mm format.
fn drawn(name: &str) -> String {
    let (folder, lens) = (folder(), format!("lenses/{name}.dat"));
    let path = folder.path().join("a.svg");
    let (code, _, stderr) = petzval(&["lens", &lens, "--draw", path.to_str().unwrap()]);
    assert_eq!(code, Some(0), "{stderr}");
    std::fs::read_to_string(path).unwrap()
}

fn all() -> impl Iterator<Item = (&'static str, Prescription)> {
    LENSES.iter().map(|&(name, _)| (name, lens(name)))
}

fn class<'a>(document: &'a Document, class: &'a str) -> impl Iterator<Item = Node<'a, 'a>> + 'a {
    document.descendants().filter(move |node| node.attribute("class") == Some(class))
}

fn attribute(node: Node, name: &str) -> f64 {
    node.attribute(name).expect(name).parse().expect("a number")
}

/// Returns the points of a path, px.
fn points(path: Node) -> Vec<[f64; 2]> {
    let d = path.attribute("d").expect("a path").replace(['M', 'L', 'Z'], " ");
    let numbers: Vec<f64> = d.split_whitespace().map(|n| n.parse().expect("a number")).collect();
    numbers.chunks(2).map(|pair| [pair[0], pair[1]]).collect()
}

fn paths<'a>(node: Node<'a, 'a>) -> impl Iterator<Item = Node<'a, 'a>> {
    node.descendants().filter(|node| node.has_tag_name("path"))
}

/// Returns the left, top, right and bottom of a text, px, in a typeface of usual width.
fn text_box(text: Node) -> [f64; 4] {
    let (x, y, size) = (attribute(text, "x"), attribute(text, "y"), attribute(text, "font-size"));
    let wide = text.text().unwrap_or_default().chars().count() as f64 * 0.6 * size;
    [x, y - 0.8 * size, x + wide, y + 0.25 * size]
}

/// Checks that the file is well formed, holds all its points, and has no text on lines or other text.
fn check(name: &str, svg: &str) {
    let document = Document::parse(svg).unwrap_or_else(|error| panic!("{name}: {error}"));
    let view: Vec<f64> = document
        .root_element()
        .attribute("viewBox")
        .unwrap()
        .split(' ')
        .map(|n| n.parse().unwrap())
        .collect();
    let inside = |x: f64, y: f64| (0.0..=view[2]).contains(&x) && (0.0..=view[3]).contains(&y);
    let lines: Vec<[f64; 2]> = paths(document.root_element()).flat_map(points).collect();
    let boxes: Vec<_> =
        document.descendants().filter(|node| node.has_tag_name("text")).map(text_box).collect();
    for &[x, y] in &lines {
        assert!(inside(x, y), "{name}: {x} {y} is outside {view:?}");
    }
    for (i, &[left, top, right, bottom]) in boxes.iter().enumerate() {
        assert!(inside(left, top) && inside(right, bottom), "{name}: text {i} is outside");
        let on = |&&[x, y]: &&[f64; 2]| left < x && x < right && top < y && y < bottom;
        assert_eq!(lines.iter().find(on), None, "{name}: text {i} lies on a line");
        for other in &boxes[..i] {
            let apart =
                other[2] <= left || right <= other[0] || other[3] <= top || bottom <= other[1];
            assert!(apart, "{name}: text {i} lies on other text");
        }
    }
    assert!(!svg.contains("NaN") && !svg.contains("inf "), "{name}: a number is not finite");
}

#[test]
fn each_element_is_drawn_once() {
    for ((name, _), pieces) in LENSES.into_iter().zip([6, 6, 4, 7]) {
        let svg = drawn(name);
        check(name, &svg);
        let document = Document::parse(&svg).unwrap();
        let glass = class(&document, "glass").next().expect("glass");
        assert_eq!(paths(glass).count(), pieces, "{name}");
        assert_eq!(class(&document, "stop").count(), 2, "{name}");
    }
}

#[test]
fn the_rays_of_each_field_end_at_one_point_of_the_film() {
    for (name, _) in LENSES {
        let svg = drawn(name);
        let document = Document::parse(&svg).unwrap();
        let film = points(class(&document, "film").next().expect("a film"));
        let [x, bottom] = film[0];
        let half = (bottom - film[1][1]) / 2.0;
        let axis = film[1][1] + half;
        let mut colours = Vec::new();
        for (field, share) in class(&document, "field").zip([0.0, 0.7, 1.0]) {
            colours.push(field.attribute("stroke").unwrap());
            assert!(paths(field).count() >= 3, "{name}: fewer than three rays");
            for ray in paths(field) {
                let &[end_x, end_y] = points(ray).last().unwrap();
                let off = (end_x - x).abs().max((end_y - (axis - share * half)).abs());
                assert!(off <= 2.0 * ROUNDING, "{name}: a ray ends {off} px from {share}");
            }
        }
        colours.dedup();
        assert_eq!(colours.len(), 3, "{name}");
    }
}

/// Converts px to mm by the scale bar and traces the drawn rays by the oracle.
#[test]
fn drawn_chief_and_marginal_rays_agree_with_the_oracle() {
    for (name, lens) in all() {
        let svg = drawn(name);
        let document = Document::parse(&svg).unwrap();
        let bar = points(class(&document, "scale").next().unwrap());
        let texts = document.descendants().filter(|node| node.has_tag_name("text"));
        let mut label =
            texts.filter_map(|text| text.text()?.strip_suffix(" mm")?.parse::<f64>().ok());
        let mm = label.next_back().expect("a length") / (bar[3][0] - bar[2][0]);
        let film = points(class(&document, "film").next().unwrap());
        let (film_x, axis) = (film[0][0], (film[0][1] + film[1][1]) / 2.0);
        let distance = RealRayFocus::new(&lens).film_distance(f64::INFINITY).unwrap();
        let place = |[x, y]: [f64; 2]| [0.0, (axis - y) * mm, (film_x - x) * mm];
        let mut seen = 0;
        for field in class(&document, "field") {
            for (i, ray) in paths(field).enumerate() {
                let points = points(ray);
                let n = points.len();
                let (start, towards) = (place(points[n - 1]), place(points[n - 2]));
                let run = [0.0, towards[1] - start[1], towards[2] - start[2]];
                // The first ray is the chief ray, the next two are marginal: moved inwards they
                // pass, moved outwards they are blocked. The shift is far more than a rounding.
                let chief = paths(field).next().unwrap();
                let chief = place(self::points(chief)[n - 2]);
                let nudged = |share: f64| [0.0, run[1] + share * (towards[1] - chief[1]), run[2]];
                if i == 0 || i > 2 || (towards[1] - chief[1]).abs() < 0.5 {
                    continue;
                }
                seen += 1;
                let inner = oracle::trace_spheres(&lens, distance, start, nudged(-0.02));
                let outer = oracle::trace_spheres(&lens, distance, start, nudged(0.02));
                assert!(inner.is_ok(), "{name}: ray {i} does not pass: {inner:?}");
                assert!(outer.is_err(), "{name}: ray {i} is not marginal");
                let [exit, direction] =
                    oracle::trace_spheres(&lens, distance, start, nudged(-0.004)).unwrap();
                let [first, second] = [place(points[0]), place(points[1])];
                let slope = (first[1] - second[1]).atan2(first[2] - second[2]);
                let off = (slope - direction[1].atan2(direction[2])).abs();
                assert!(off < 0.01, "{name}: ray {i} leaves {off} rad off");
                assert!((exit[1] - second[1]).abs() < 0.1, "{name}: ray {i} leaves elsewhere");
            }
        }
        assert!(seen >= 4, "{name}: {seen} marginal rays");
    }
}

#[test]
fn a_chief_ray_crosses_the_axis_in_the_stop() {
    for (name, _) in LENSES {
        let svg = drawn(name);
        let document = Document::parse(&svg).unwrap();
        let [x, _] = points(class(&document, "stop").next().unwrap())[0];
        let axis = points(class(&document, "axis").next().unwrap())[0][1];
        for field in class(&document, "field") {
            let chief = points(paths(field).next().unwrap());
            let crossing = chief.iter().find(|p| (p[0] - x).abs() <= ROUNDING).expect("the stop");
            assert!((crossing[1] - axis).abs() <= 2.0 * ROUNDING, "{name}");
        }
    }
}

#[test]
fn a_drawing_is_reproducible_and_small() {
    for (name, _) in LENSES {
        let svg = drawn(name);
        assert_eq!(svg, drawn(name));
        assert!(svg.len() < 20_000, "{} bytes", svg.len());
    }
}

fn petzval(arguments: &[&str]) -> (Option<i32>, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_petzval"))
        .args(arguments)
        .current_dir(root())
        .output()
        .expect("the command starts");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code(), text(&output.stdout), text(&output.stderr))
}

#[test]
fn the_command_writes_a_drawing_with_its_settings() {
    let folder = folder();
    let path = folder.path().join("a.svg");
    let out = path.to_str().unwrap();
    let drawing_with = |more: &[&str]| {
        let arguments = [&["lens", "lenses/dgauss.50mm.dat", "--draw", out], more].concat();
        let (code, stdout, stderr) = petzval(&arguments);
        assert_eq!(code, Some(0), "{stderr}");
        assert!(stdout.contains("focal length"), "{stdout}");
        let svg = std::fs::read_to_string(&path).unwrap();
        check("command", &svg);
        svg
    };
    let usual = drawing_with(&[]);
    assert!(usual.contains("f = 50.4 mm, f/2.0, focused at infinity"), "{usual}");
    assert!(usual.contains("21.6 mm"), "{usual}");
    assert!(drawing_with(&["--film-diagonal", "20"]).contains("10.0 mm"));
    assert!(drawing_with(&["--focus", "500mm"]).contains("focused at 500.0 mm from the film"));
    assert!(
        drawing_with(&["--film-distance", "36.77"]).contains("focused at 4.01 m from the film")
    );
    assert!(drawing_with(&["--stop", "4"]).contains("f/8.7"));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "no temporary files");
}

#[test]
fn the_command_refuses_outputs_that_it_cannot_write() {
    let refuses = |arguments: &[&str], expected: &str| {
        let arguments = [&["lens", "lenses/dgauss.50mm.dat"], arguments].concat();
        let (code, stdout, stderr) = petzval(&arguments);
        assert_eq!(code, Some(2), "{arguments:?}: {stderr}");
        assert!(stderr.contains(expected), "{arguments:?}: {stderr}");
        assert!(
            stdout.is_empty() && !stderr.contains("panicked"),
            "{arguments:?}: {stdout}{stderr}"
        );
    };
    let folder = folder();
    let svg = folder.path().join("a.svg");
    let svg = svg.to_str().unwrap();
    refuses(&["--draw", "a.png"], "--draw a.png: drawings are SVG; name the file a.svg");
    refuses(&["--draw", "a"], "name the file a.svg");
    refuses(&["--draw", ""], "a value is required");
    refuses(&["--draw", "no/such/a.svg"], "cannot write no/such/a.svg: ");
    refuses(&["--draw", svg, "--focus", "0.01"], "the lens cannot focus at 10.0000 mm");
    refuses(&["--draw", svg, "--film-diagonal", "0"], "a length above 0");
    refuses(&["--film-diagonal", "9"], "--draw");
    assert!(!Path::new(svg).exists());
}
