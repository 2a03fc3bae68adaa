//! Tests of drawings of modified lenses; tests/optics/draw.rs tests those of lens files.

use std::path::Path;

use petzval_lens::{Pose, Prescription, RealRayFocus, Row, Rows, TiltDecenter, TransverseAxis};
use petzval_lens_formats::read;
use roxmltree::{Document, Node};

use super::draw;

/// Half the diagonal of the 35 mm format (mm).
const RADIUS: f64 = 21.635;

/// Coordinates have two decimals.
const ROUNDING: f64 = 0.011;

/// A lens of the repository.
fn lens(name: &str) -> Prescription {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../lenses");
    read(&folder.join(format!("{name}.dat"))).expect("a lens of the repository")
}

/// A row of a prescription; radius 0 makes it the stop.
fn row(radius: f64, thickness: f64, index: f64, diameter: f64) -> Row {
    let stop = radius == 0.0;
    let radius = if stop { f64::INFINITY } else { radius };
    Row { radius, thickness, index, diameter, stop, ..Row::default() }
}

/// The drawing with the film where infinity is in focus.
fn drawn(lens: &Prescription) -> String {
    draw(lens, Some(RealRayFocus::new(lens).film_distance(f64::INFINITY).unwrap()), RADIUS)
}

fn scaled(lens: &Prescription, factor: f64) -> Prescription {
    let mut lens = lens.clone();
    for row in &mut lens.rows {
        row.radius *= factor;
        row.thickness *= factor;
        row.diameter *= factor;
    }
    lens
}

/// The fisheye with a meniscus in front, which widens its field beyond 90 degrees.
fn beyond_90_degrees() -> Prescription {
    let mut lens = lens("fisheye.10mm");
    let front = [row(44.0, 2.0, 1.8, 64.0), row(18.0, 14.0, 1.0, 35.4)];
    lens.rows = Rows::new([&front, &lens.rows[..]].concat()).expect("one stop");
    lens
}

fn class<'a>(document: &'a Document, class: &'a str) -> impl Iterator<Item = Node<'a, 'a>> + 'a {
    document.descendants().filter(move |node| node.attribute("class") == Some(class))
}

fn attribute(node: Node, name: &str) -> f64 {
    node.attribute(name).expect(name).parse().expect("a number")
}

/// Returns the points of a path [px].
fn points(path: Node) -> Vec<[f64; 2]> {
    let d = path.attribute("d").expect("a path").replace(['M', 'L', 'Z'], " ");
    let numbers: Vec<f64> = d.split_whitespace().map(|n| n.parse().expect("a number")).collect();
    numbers.chunks(2).map(|pair| [pair[0], pair[1]]).collect()
}

fn paths<'a>(node: Node<'a, 'a>) -> impl Iterator<Item = Node<'a, 'a>> {
    node.descendants().filter(|node| node.has_tag_name("path"))
}

/// Returns left, top, right and bottom of text in a typeface of common width [px].
fn letters(text: Node) -> [f64; 4] {
    let (x, y, size) = (attribute(text, "x"), attribute(text, "y"), attribute(text, "font-size"));
    let wide = text.text().unwrap_or_default().chars().count() as f64 * 0.6 * size;
    [x, y - 0.8 * size, x + wide, y + 0.25 * size]
}

/// Asserts that the file is well formed, that everything lies inside it, and that no text overlaps.
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
    let words: Vec<_> =
        document.descendants().filter(|node| node.has_tag_name("text")).map(letters).collect();
    for &[x, y] in &lines {
        assert!(inside(x, y), "{name}: {x} {y} is outside {view:?}");
    }
    for (i, &[left, top, right, bottom]) in words.iter().enumerate() {
        assert!(inside(left, top) && inside(right, bottom), "{name}: words {i} are outside");
        let on = |&&[x, y]: &&[f64; 2]| left < x && x < right && top < y && y < bottom;
        assert_eq!(lines.iter().find(on), None, "{name}: words {i} lie on a line");
        for other in &words[..i] {
            let apart =
                other[2] <= left || right <= other[0] || other[3] <= top || bottom <= other[1];
            assert!(apart, "{name}: words {i} lie on other words");
        }
    }
    assert!(!svg.contains("NaN") && !svg.contains("inf "), "{name}: no number");
}

#[test]
fn a_stop_inside_glass_does_not_cut_it() {
    let rows = vec![row(60.0, 6.0, 1.5, 24.0), row(0.0, 6.0, 1.5, 8.0), row(-60.0, 0.0, 1.0, 24.0)];
    let lens = Prescription::new("", rows).expect("one stop");
    let svg = drawn(&lens);
    let document = Document::parse(&svg).unwrap();
    assert_eq!(paths(class(&document, "glass").next().unwrap()).count(), 1);
}

#[test]
fn a_decentred_lens_is_drawn_higher() {
    let height = |y: f64| {
        let stop = row(0.0, 5.0, 1.0, 8.0);
        let pose = Pose { decentre: [0.0, y], ..Pose::ALIGNED };
        let rows = vec![stop, row(60.0, 6.0, 1.5, 24.0), row(-60.0, 0.0, 1.0, 24.0)];
        let mut lens = Prescription::new("", rows).expect("one stop");
        lens.tilt_decenters = vec![TiltDecenter { rows: [1, 2], pose }];
        let svg = drawn(&lens);
        let document = Document::parse(&svg).unwrap();
        let outline = points(paths(class(&document, "glass").next().unwrap()).next().unwrap());
        let axis = points(paths(class(&document, "axis").next().unwrap()).next().unwrap())[0][1];
        // y of SVG points down.
        axis - outline.iter().map(|p| p[1]).sum::<f64>() / outline.len() as f64
    };
    assert!(height(2.0) > 2.0 && height(-2.0) < -2.0, "{} {}", height(2.0), height(-2.0));
}

#[test]
fn scale_changes_only_the_text() {
    let one = lens("dgauss.50mm");
    let film = RealRayFocus::new(&one).film_distance(f64::INFINITY).unwrap();
    let numbers = |svg: &str| -> Vec<[f64; 2]> {
        let document = Document::parse(svg).unwrap();
        paths(class(&document, "glass").next().unwrap())
            .chain(class(&document, "field").flat_map(paths))
            .flat_map(points)
            .collect()
    };
    let usual = numbers(&draw(&one, Some(film), RADIUS));
    for (factor, words) in [(1e-3, "f = 50.4 \u{b5}m, f/2.0"), (1e3, "f = 50.4 m, f/2.0")] {
        let svg = draw(&scaled(&one, factor), Some(film * factor), RADIUS * factor);
        check("scaled", &svg);
        assert!(svg.contains(words), "{svg}");
        let other = numbers(&svg);
        assert_eq!(usual.len(), other.len());
        for (a, b) in usual.iter().zip(&other) {
            assert!((a[0] - b[0]).abs() <= 2.0 * ROUNDING && (a[1] - b[1]).abs() <= 2.0 * ROUNDING);
        }
        // The film of the 35 mm format is far too large or far too small for the lens.
        check("scaled", &drawn(&scaled(&one, factor)));
    }
}

#[test]
fn a_lens_without_an_image_is_drawn_without_film() {
    let rows = vec![row(-30.0, 2.0, 1.5, 20.0), row(40.0, 3.0, 1.0, 20.0), row(0.0, 0.0, 1.0, 8.0)];
    let lens = Prescription::new("", rows).expect("one stop");
    let svg = draw(&lens, None, RADIUS);
    check("diverging", &svg);
    assert!(svg.contains("forms no real image"), "{svg}");
    let document = Document::parse(&svg).unwrap();
    assert_eq!(class(&document, "film").count() + class(&document, "field").count(), 0);
    // With a film, there are rays even if no object is in focus.
    let document_with = draw(&lens, Some(30.0), RADIUS);
    check("diverging", &document_with);
    assert_eq!(class(&Document::parse(&document_with).unwrap(), "field").count(), 3);
}

#[test]
fn names_are_escaped() {
    let mut lens = lens("dgauss.50mm");
    for name in [
        "</text><script>alert(1)</script>",
        "a & b < c > d \" e ' f ]]> &amp; <!--",
        "nul \0 escape \u{1b}[31m tab \t line \n turned \u{202e} none \u{ffff}",
        "",
    ] {
        lens.name = name.to_owned();
        let svg = drawn(&lens);
        check(name, &svg);
        let document = Document::parse(&svg).unwrap();
        assert!(!document.descendants().any(|node| node.has_tag_name("script")));
    }
    for letter in ["W", "\u{955c}"] {
        lens.name = letter.repeat(5000);
        check(letter, &drawn(&lens));
    }
}

#[test]
fn no_prescription_makes_the_drawing_panic() {
    let nasty = [0.0, -1.0, 1e-300, 1e300, 1e9, f64::INFINITY, f64::NAN];
    let mut lens = lens("telephoto.250mm");
    let film = 123.7439;
    for value in nasty {
        for i in [0, 3, 6] {
            let usual = lens.rows[i].clone();
            for row in [
                Row { radius: value, ..usual.clone() },
                Row { thickness: value, ..usual.clone() },
                Row { diameter: value, ..usual.clone() },
                Row { index: value, ..usual.clone() },
                Row { conic: value, asphere: vec![(4, value)], ..usual.clone() },
                Row { axis: Some(TransverseAxis::X), obstruction: value, ..usual.clone() },
            ] {
                lens.rows[i] = row;
                for (film, radius) in [(Some(film), RADIUS), (None, RADIUS)] {
                    let svg = draw(&lens, film, radius);
                    Document::parse(&svg).expect("well formed");
                    assert!(!svg.contains("NaN "), "{svg}");
                }
            }
            lens.rows[i] = usual;
        }
        for (film, radius) in [(value, RADIUS), (film, value), (value, value)] {
            Document::parse(&draw(&lens, Some(film), radius)).expect("well formed");
        }
    }
}

#[test]
fn oblique_rays_stay_within_the_drawing() {
    let names = ["dgauss.50mm", "fisheye.10mm", "telephoto.250mm", "wide.22mm"];
    let mut lenses = names.map(|name| (name, lens(name))).to_vec();
    lenses.push(("beyond 90 degrees", beyond_90_degrees()));
    for (name, lens) in lenses {
        let svg = drawn(&lens);
        check(name, &svg);
        let document = Document::parse(&svg).unwrap();
        let axis = points(class(&document, "axis").next().unwrap())[0][1];
        let height = |nodes: &str| {
            let points = class(&document, nodes).flat_map(paths).flat_map(points);
            points.fold(0.0, |height: f64, point| height.max((point[1] - axis).abs()))
        };
        let lens = height("glass").max(height("film")).max(height("stop"));
        assert!(height("field") <= 1.36 * lens, "{name}: {} over {lens}", height("field"));
    }
    let svg = drawn(&beyond_90_degrees());
    let degrees: Vec<f64> =
        svg.split('\u{b0}').filter_map(|words| words.rsplit(' ').next()?.parse().ok()).collect();
    assert!(degrees.last().is_some_and(|&d| d > 90.0), "{degrees:?}");
}
