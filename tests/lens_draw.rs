//! The drawing of a lens, read back.

mod support;

use std::path::Path;
use std::process::Command;

use petzval::lens::{Axis, Focus, Prescription, Row, draw};
use roxmltree::{Document, Node};
use support::{LENSES, folder, lens, oracle, root, row};

/// Half the diagonal of the 35 mm format, mm.
const RADIUS: f64 = 21.635;

/// Coordinates have two decimals.
const ROUNDING: f64 = 0.011;

fn drawn(lens: &Prescription) -> String {
    draw(lens, Some(Focus::of(lens).film(f64::INFINITY).unwrap()), RADIUS)
}

fn all() -> impl Iterator<Item = (&'static str, Prescription)> {
    LENSES.iter().map(|&(name, _)| (name, lens(name)))
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

fn class<'a>(document: &'a Document, class: &'a str) -> impl Iterator<Item = Node<'a, 'a>> + 'a {
    document.descendants().filter(move |node| node.attribute("class") == Some(class))
}

fn attribute(node: Node, name: &str) -> f64 {
    node.attribute(name).expect(name).parse().expect("a number")
}

/// The points of a path, px.
fn points(path: Node) -> Vec<[f64; 2]> {
    let d = path.attribute("d").expect("a path").replace(['M', 'L', 'Z'], " ");
    let numbers: Vec<f64> = d.split_whitespace().map(|n| n.parse().expect("a number")).collect();
    numbers.chunks(2).map(|pair| [pair[0], pair[1]]).collect()
}

fn paths<'a>(node: Node<'a, 'a>) -> impl Iterator<Item = Node<'a, 'a>> {
    node.descendants().filter(|node| node.has_tag_name("path"))
}

/// Left, top, right and bottom of words, px, in a typeface of common width.
fn letters(text: Node) -> [f64; 4] {
    let (x, y, size) = (attribute(text, "x"), attribute(text, "y"), attribute(text, "font-size"));
    let wide = text.text().unwrap_or_default().chars().count() as f64 * 0.6 * size;
    [x, y - 0.8 * size, x + wide, y + 0.25 * size]
}

/// The file is well formed, everything lies inside it and no words lie on anything.
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
fn every_piece_of_glass_is_drawn_once() {
    for ((name, lens), pieces) in all().zip([6, 6, 4, 7]) {
        let svg = drawn(&lens);
        check(name, &svg);
        let document = Document::parse(&svg).unwrap();
        let glass = class(&document, "glass").next().expect("glass");
        assert_eq!(paths(glass).count(), pieces, "{name}");
        assert_eq!(class(&document, "stop").count(), 2, "{name}");
    }
}

#[test]
fn a_stop_inside_glass_does_not_cut_it() {
    let lens = Prescription {
        rows: vec![row(60.0, 6.0, 1.5, 24.0), row(0.0, 6.0, 1.5, 8.0), row(-60.0, 0.0, 1.0, 24.0)],
        ..Prescription::default()
    };
    let svg = drawn(&lens);
    let document = Document::parse(&svg).unwrap();
    assert_eq!(paths(class(&document, "glass").next().unwrap()).count(), 1);
}

#[test]
fn the_rays_of_each_field_end_at_one_point_of_the_film() {
    for (name, lens) in all() {
        let svg = drawn(&lens);
        let document = Document::parse(&svg).unwrap();
        let film = points(class(&document, "film").next().expect("a film"));
        let [x, bottom] = film[0];
        let half = (bottom - film[1][1]) / 2.0;
        let axis = film[1][1] + half;
        let mut colours = Vec::new();
        for (field, share) in class(&document, "field").zip([0.0, 0.7, 1.0]) {
            colours.push(field.attribute("stroke").unwrap());
            assert!(paths(field).count() >= 3, "{name}: a chief ray and two rims");
            for ray in paths(field) {
                let &[end_x, end_y] = points(ray).last().unwrap();
                let off = (end_x - x).abs().max((end_y - (axis - share * half)).abs());
                assert!(off <= 2.0 * ROUNDING, "{name}: a ray ends {off} px beside {share}");
            }
        }
        colours.dedup();
        assert_eq!(colours.len(), 3, "{name}");
    }
}

/// The scale bar tells px from mm, the oracle tells whether the rays that are drawn are rays.
#[test]
fn the_oracle_agrees_with_the_rays_and_with_their_rims() {
    for (name, lens) in all() {
        let svg = drawn(&lens);
        let document = Document::parse(&svg).unwrap();
        let bar = points(class(&document, "scale").next().unwrap());
        let words = document.descendants().filter(|node| node.has_tag_name("text"));
        let mut label =
            words.filter_map(|text| text.text()?.strip_suffix(" mm")?.parse::<f64>().ok());
        let mm = label.next_back().expect("a length") / (bar[3][0] - bar[2][0]);
        let film = points(class(&document, "film").next().unwrap());
        let (film_x, axis) = (film[0][0], (film[0][1] + film[1][1]) / 2.0);
        let distance = Focus::of(&lens).film(f64::INFINITY).unwrap();
        let place = |[x, y]: [f64; 2]| [0.0, (axis - y) * mm, (film_x - x) * mm];
        let mut seen = 0;
        for field in class(&document, "field") {
            for (i, ray) in paths(field).enumerate() {
                let points = points(ray);
                let n = points.len();
                let (start, towards) = (place(points[n - 1]), place(points[n - 2]));
                let run = [0.0, towards[1] - start[1], towards[2] - start[2]];
                // The first ray is the chief, the next two are rims: a nudge inwards passes,
                // outwards ends. A hundredth of a pixel is far less than the nudge.
                let chief = paths(field).next().unwrap();
                let chief = place(self::points(chief)[n - 2]);
                let nudged = |share: f64| [0.0, run[1] + share * (towards[1] - chief[1]), run[2]];
                if i == 0 || i > 2 || (towards[1] - chief[1]).abs() < 0.5 {
                    continue;
                }
                seen += 1;
                let inner = oracle::trace(&lens, distance, start, nudged(-0.02));
                let outer = oracle::trace(&lens, distance, start, nudged(0.02));
                assert!(inner.is_ok(), "{name}: ray {i} does not pass: {inner:?}");
                assert!(outer.is_err(), "{name}: ray {i} is no rim");
                let [exit, direction] =
                    oracle::trace(&lens, distance, start, nudged(-0.004)).unwrap();
                let [first, second] = [place(points[0]), place(points[1])];
                let slope = (first[1] - second[1]).atan2(first[2] - second[2]);
                let off = (slope - direction[1].atan2(direction[2])).abs();
                assert!(off < 0.01, "{name}: ray {i} leaves {off} rad aside");
                assert!((exit[1] - second[1]).abs() < 0.1, "{name}: ray {i} leaves elsewhere");
            }
        }
        assert!(seen >= 4, "{name}: {seen} rims");
    }
}

#[test]
fn a_chief_ray_crosses_the_axis_in_the_stop() {
    for (name, lens) in all() {
        let svg = drawn(&lens);
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

/// A meniscus before the fisheye takes its field past 90 degrees.
fn beyond_90_degrees() -> Prescription {
    let mut lens = lens("fisheye.10mm");
    lens.rows.splice(0..0, [row(44.0, 2.0, 1.8, 64.0), row(18.0, 14.0, 1.0, 35.4)]);
    lens
}

#[test]
fn rays_from_far_aside_stay_beside_the_lens() {
    let mut lenses: Vec<_> = all().collect();
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

#[test]
fn size_changes_nothing_but_the_words() {
    let one = lens("dgauss.50mm");
    let film = Focus::of(&one).film(f64::INFINITY).unwrap();
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
        // The film of the 35 mm format, far too large or far too small for the lens.
        check("scaled", &drawn(&scaled(&one, factor)));
    }
}

#[test]
fn a_lens_without_an_image_is_drawn_without_film() {
    let lens = Prescription {
        rows: vec![row(-30.0, 2.0, 1.5, 20.0), row(40.0, 3.0, 1.0, 20.0), row(0.0, 0.0, 1.0, 8.0)],
        ..Prescription::default()
    };
    let svg = draw(&lens, None, RADIUS);
    check("diverging", &svg);
    assert!(svg.contains("forms no real image"), "{svg}");
    let document = Document::parse(&svg).unwrap();
    assert_eq!(class(&document, "film").count() + class(&document, "field").count(), 0);
    // Something near is in focus, or nothing: rays there are.
    let document_with = draw(&lens, Some(30.0), RADIUS);
    check("diverging", &document_with);
    assert_eq!(class(&Document::parse(&document_with).unwrap(), "field").count(), 3);
}

#[test]
fn the_same_lens_gives_the_same_bytes() {
    for (_, lens) in all() {
        let svg = drawn(&lens);
        assert_eq!(svg, drawn(&lens));
        assert!(svg.len() < 20_000, "{} bytes", svg.len());
    }
}

#[test]
fn names_are_words_and_nothing_else() {
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
fn no_prescription_makes_it_panic() {
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
                Row { axis: Some(Axis::X), obstruction: value, ..usual.clone() },
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
fn the_command_draws() {
    let folder = folder();
    let path = folder.path().join("a.svg");
    let out = path.to_str().unwrap();
    let words = |more: &[&str]| {
        let arguments = [&["lens", "lenses/dgauss.50mm.dat", "--draw", out], more].concat();
        let (code, said, error) = petzval(&arguments);
        assert_eq!(code, Some(0), "{error}");
        assert!(said.contains("focal length"), "{said}");
        let svg = std::fs::read_to_string(&path).unwrap();
        check("command", &svg);
        svg
    };
    let usual = words(&[]);
    assert!(usual.contains("f = 50.4 mm, f/2.0, focused at infinity"), "{usual}");
    assert_eq!(usual, drawn(&lens("dgauss.50mm")));
    assert!(usual.contains("21.6 mm"), "{usual}");
    assert!(words(&["--film-diagonal", "20"]).contains("10.0 mm"));
    assert!(words(&["--focus", "500"]).contains("focused at 500.0 mm from the film"));
    assert!(words(&["--film-distance", "36.77"]).contains("focused at 4.01 m from the film"));
    assert!(words(&["--stop", "4"]).contains("f/8.7"));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "no temporary files");
}

#[test]
fn the_command_refuses_what_it_cannot_write() {
    let refuses = |arguments: &[&str], expected: &str| {
        let arguments = [&["lens", "lenses/dgauss.50mm.dat"], arguments].concat();
        let (code, said, error) = petzval(&arguments);
        assert_eq!(code, Some(2), "{arguments:?}: {error}");
        assert!(error.contains(expected), "{arguments:?}: {error}");
        assert!(said.is_empty() && !error.contains("panicked"), "{arguments:?}: {said}{error}");
    };
    let folder = folder();
    let svg = folder.path().join("a.svg");
    let svg = svg.to_str().unwrap();
    refuses(&["--draw", "a.png"], "--draw a.png: drawings are SVG; name the file a.svg");
    refuses(&["--draw", "a"], "name the file a.svg");
    refuses(&["--draw", ""], "a value is required");
    refuses(&["--draw", "no/such/a.svg"], "cannot write no/such/a.svg: ");
    refuses(&["--draw", svg, "--focus", "10"], "the lens cannot focus at 10.0000 mm");
    refuses(&["--draw", svg, "--film-diagonal", "0"], "a length above 0");
    refuses(&["--film-diagonal", "9"], "--draw");
    assert!(!Path::new(svg).exists());
}
