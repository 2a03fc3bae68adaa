//! `petzval lens report`: files, JSON and errors.

use serde_json::Value;

use crate::support::{folder, petzval, root, write};

fn lens(name: &str) -> String {
    root().join("lenses").join(name).display().to_string()
}

const FEW: [&str; 4] = ["--field-count", "5", "--pupil-grid", "16"];

fn report(lens: &str, rest: &[&str]) -> (i32, String, String) {
    let folder = folder();
    let mut arguments = vec!["lens", "report", lens];
    arguments.extend(FEW);
    arguments.extend(rest);
    petzval(folder.path(), &arguments)
}

#[test]
fn every_lens_gives_every_analysis() {
    for entry in std::fs::read_dir(root().join("lenses")).expect("lenses") {
        let path = entry.expect("an entry").path().display().to_string();
        let (code, out, err) = report(&path, &["--json", "all"]);
        assert_eq!(code, 0, "{path}: {err}");
        let all: Value = serde_json::from_str(&out).expect("JSON");
        let sections = all.as_array().expect("sections");
        assert_eq!(sections.len(), 20, "{path}");
        for section in sections {
            nulls_have_a_reason(section, &path);
            for table in section["tables"].as_array().expect("tables") {
                let columns = table["columns"].as_array().expect("columns").len();
                let rows = table["rows"].as_array().expect("rows");
                assert!(!rows.is_empty(), "{path}: {} {}", section["analysis"], table["name"]);
                assert!(rows.iter().all(|row| row.as_array().is_some_and(|r| r.len() == columns)));
            }
        }
    }
}

/// Checks that a sentence names every figure and column that lacks numbers.
fn nulls_have_a_reason(section: &Value, lens: &str) {
    let missing = section["missing"].as_array().expect("sentences");
    let mut lacking = Vec::new();
    for (name, figure) in section["figures"].as_object().expect("figures") {
        lacking.extend(figure["value"].is_null().then(|| name.clone()));
    }
    for table in section["tables"].as_array().expect("tables") {
        let columns = table["columns"].as_array().expect("columns");
        for row in table["rows"].as_array().expect("rows") {
            let cells = columns.iter().zip(row.as_array().expect("cells"));
            lacking.extend(
                cells
                    .filter(|(_, cell)| cell.is_null())
                    .map(|(c, _)| c.as_str().expect("a name").to_owned()),
            );
        }
    }
    for name in lacking {
        let said =
            missing.iter().any(|text| text.as_str().is_some_and(|text| text.contains(&name)));
        assert!(
            said,
            "{lens}: {}: {name} is null without a reason: {missing:?}",
            section["analysis"]
        );
    }
}

/// A singlet behind a rim that only light near the axis passes.
const TUNNEL: &str = "\
0 40 0 4
60 3 1.5168 20
-60 5 1 20
1e9 0 1 6
";

#[test]
fn a_dark_field_is_named_with_its_reason() {
    let folder = folder();
    write(&folder, "tunnel.dat", TUNNEL);
    let lens = folder.path().join("tunnel.dat").display().to_string();
    let (code, out, err) = report(&lens, &["--image-height", "20", "--json", "mtf"]);
    assert_eq!(code, 0, "{err}");
    let section: Value = serde_json::from_str(&out).expect("JSON");
    nulls_have_a_reason(&section, "a tunnel");
    let text = section["missing"].to_string();
    assert!(text.contains("no light of field 20 mm passes the lens"), "{text}");
    // The page says it too, but not that a plane has no radius.
    let folder = folder_of_report(&lens, &["--image-height", "20"]);
    let page = std::fs::read_to_string(folder.path().join("out/index.html")).expect("a page");
    assert!(page.contains("no light of field 20 mm passes the lens"));
    assert!(!page.contains("a plane has no finite radius"));
}

#[test]
fn fields_without_a_chief_ray_are_named() {
    let lens = root().join("lenses/dgauss.50mm.dat").display().to_string();
    let (code, out, err) = report(&lens, &["--image-height", "60", "--json", "mtf"]);
    assert_eq!(code, 0, "{err}");
    let section: Value = serde_json::from_str(&out).expect("JSON");
    let text = section["missing"].to_string();
    // The even field of 45 mm is none of those that are shown one by one.
    let expected = "there are no numbers: fields 42 mm, 45 mm, 51 mm, 60 mm.";
    assert!(text.contains(expected), "{text}");
    // Every point of a curve is there, and those without a number are named.
    for analysis in ["field-curvature", "distortion", "lateral-colour"] {
        let (code, out, err) = report(&lens, &["--image-height", "60", "--json", analysis]);
        assert_eq!(code, 0, "{err}");
        let section: Value = serde_json::from_str(&out).expect("JSON");
        let text = section["missing"].to_string();
        assert!(text.contains("there are no numbers: fields 37.2 mm, 38.4 mm, 39.6 mm"), "{text}");
        let rows = section["tables"][0]["rows"].as_array().expect("rows");
        assert_eq!(rows.len(), 51, "{analysis}");
    }
}

fn folder_of_report(lens: &str, rest: &[&str]) -> tempfile::TempDir {
    let folder = folder();
    let mut arguments = vec!["lens", "report", lens, "-o", "out"];
    arguments.extend(FEW);
    arguments.extend(rest);
    let (code, _, err) = petzval(folder.path(), &arguments);
    assert_eq!(code, 0, "{err}");
    folder
}

#[test]
fn a_window_has_no_image_of_a_distant_object() {
    let folder = folder();
    write(&folder, "window.dat", "1e9 5 1.5168 20\n1e9 5 1 20\n0 0 0 10\n");
    let lens = folder.path().join("window.dat").display().to_string();
    let (code, _, err) = report(&lens, &["--json", "all", "--film-distance", "50"]);
    assert_eq!(code, 2, "{err}");
    assert!(err.contains("window.dat") && err.contains("--focus"), "{err}");
}

#[test]
fn a_report_is_a_page_with_its_files() {
    let folder = folder();
    let lens = lens("triplet.toml");
    let mut arguments = vec!["lens", "report", &lens, "-o", "cooke"];
    arguments.extend(FEW);
    let (code, out, err) = petzval(folder.path(), &arguments);
    assert_eq!(code, 0, "{err}");
    assert!(out.contains("index.html"), "{out}");
    let file = |name: &str| {
        let path = folder.path().join("cooke").join(name);
        std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{name}: {error}"))
    };
    let page = file("index.html");
    let body = page.strip_prefix("<!DOCTYPE html>\n").expect("a document type");
    roxmltree::Document::parse(body).expect("well-formed XML");
    assert!(!page.contains("http://") || page.contains("xmlns"), "no address outside");
    assert!(!page.contains("<script") && !page.contains("src=\"http"));
    for section in ["seidel", "spot", "mtf-focus", "wavefront", "ghosts"] {
        assert!(page.contains(&format!("id=\"{section}\"")), "{section}");
    }
    let table = file("spot-size.csv");
    assert!(table.starts_with("field_mm,wavelength_nm,rms_radius_um,"), "{table}");
    assert!(file("mtf-diffraction.svg").starts_with("<svg"));
    let all: Value = serde_json::from_str(&file("report.json")).expect("JSON");
    assert_eq!(all.as_array().map(Vec::len), Some(20));
}

/// Writes the report of a lens of the repository, and returns its folder and page.
fn page_of(name: &str) -> (tempfile::TempDir, String) {
    let folder = folder_of_report(&lens(name), &[]);
    let page = std::fs::read_to_string(folder.path().join("out/index.html")).expect("a page");
    (folder, page)
}

#[test]
fn the_page_describes_the_surfaces_as_a_designer_reads_them() {
    let (_folder, page) = page_of("phone.toml");
    let prescription = page.split_once("id=\"prescription\"").expect("a section").1;
    let prescription = prescription.split_once("<h2").expect("another section").0;
    for expected in
        ["<td>1 stop</td>", "conic 1.153", "a4 0.02426", "<td>76.60</td>", "semi-diameter (mm)"]
    {
        assert!(prescription.contains(expected), "{expected} in {prescription}");
    }
    let (folder, page) = page_of("triplet.toml");
    for expected in ["SK16", "<td>sum</td>", "S I (mm)", "RMS radius (µm)", "f-number"] {
        assert!(page.contains(expected), "{expected}");
    }
    assert!(!page.contains("rms radius um") && !page.contains("<th>s1 mm"), "names of columns");
    let file = |name: &str| {
        let path = folder.path().join("out").join(name);
        std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{name}: {error}"))
    };
    assert!(file("prescription.csv").contains("SK16"));
    assert!(file("seidel-sums.svg").contains(">sum<"));
    let csv = file("first-order-fields.csv");
    assert!(csv.starts_with("field_mm,field_angle_deg,image_height_mm\n0,0,0\n"), "{csv}");
}

#[test]
fn spots_share_a_scale_and_state_their_sizes() {
    let (folder, page) = page_of("dgauss.50mm.dat");
    let entries = std::fs::read_dir(folder.path().join("out")).expect("files");
    let names = entries.map(|entry| entry.expect("an entry").path());
    let spots = names.filter(|path| {
        let name = path.file_name().expect("a name").to_string_lossy();
        name.starts_with("spot-") && name.ends_with(".svg")
    });
    // The labels of the axes, which are numbers.
    let mut scales = Vec::new();
    for path in spots {
        let svg = std::fs::read_to_string(&path).expect("a drawing");
        let drawing = roxmltree::Document::parse(&svg).expect("XML");
        let words: Vec<&str> = drawing.descendants().filter_map(|node| node.text()).collect();
        assert!(words.iter().any(|w| w.starts_with("RMS ") && w.contains("GEO ")), "{words:?}");
        let labels = words.iter().filter(|word| word.parse::<f64>().is_ok());
        scales.push(labels.map(|word| (*word).to_owned()).collect::<Vec<String>>());
    }
    assert_eq!(scales.len(), 5);
    assert!(scales.windows(2).all(|pair| pair[0] == pair[1]), "{scales:?}");
    // A bar of colours for every wavefront and every point image, and a scale bar for the latter.
    assert_eq!(page.matches("<linearGradient").count(), 10);
    let psf = page.split_once("id=\"psf\"").expect("a section").1;
    assert!(psf.contains("10⁻⁴ of the peak") && psf.contains(" µm</text>"));
    assert!(page.contains("Grid, distortion times"), "an exaggerated grid");
}

#[test]
fn the_page_hides_nothing_prints_and_says_where_it_comes_from() {
    let (_folder, page) = page_of("triplet.toml");
    assert!(!page.contains("overflow") && !page.contains("max-height"));
    assert!(page.contains("@media print"));
    let foot = page.split_once("<footer>").expect("a foot").1;
    assert!(foot.contains(&format!("petzval {}, 20", env!("CARGO_PKG_VERSION"))), "{foot}");
    assert!(foot.contains(" UTC") && foot.contains("petzval lens report "), "{foot}");
}

#[test]
fn lengths_are_rounded_to_the_digits_that_files_state() {
    let folder = folder();
    let zmx = "VERS 140124 258 36214\nMODE SEQ\nUNIT MM X W X CM MR CPMM\nENPD 10\nFTYP 0 0 2 1 0 0 0\nXFLN 0 0\nYFLN 0 7\n\
               WAVM 1 5.875618E-1 1\nPWAV 1\nSURF 0\n  CURV 0\n  DISZ INFINITY\nSURF 1\n  STOP\n  \
               CURV 0.02\n  DISZ 4\n  GLAS N-BK7 0 0 1.5168 64.17\n  DIAM 6\nSURF 2\n  CURV -0.02\n  \
               DISZ 46\n  DIAM 6\nSURF 3\n  CURV 0\n  DISZ 0\n  DIAM 5\n";
    let file = write(&folder, "lens.zmx", zmx);
    let file = file.to_str().expect("a name");
    let long_numbers = |text: &str| {
        let long = |word: &str| word.contains("00000") || word.contains("99999");
        let words = text.split(|c: char| !c.is_ascii_digit());
        words.filter(|word| long(word)).map(str::to_owned).collect::<Vec<String>>()
    };
    let (code, out, err) = report(file, &["--json", "first-order"]);
    assert_eq!(code, 0, "{err}");
    assert!(out.contains("587.5618") && !out.contains("587.56180"), "{out}");
    let (code, out, err) = petzval(folder.path(), &["lens", file, "--json"]);
    assert_eq!(code, 0, "{err}");
    assert!(out.contains("\"wavelength\": 587.5618,"), "{out}");
    assert!(
        out.contains("\"glass\": \"N-BK7\"") && long_numbers(&out).is_empty(),
        "{:?}",
        long_numbers(&out)
    );
    let (code, _, err) = petzval(folder.path(), &["lens", "convert", file, "-o", "back.zmx"]);
    assert_eq!(code, 0, "{err}");
    let back = std::fs::read_to_string(folder.path().join("back.zmx")).expect("a lens");
    assert!(back.contains("WAVM 1 0.5875618 1"), "{back}");
    let (code, out, err) = petzval(folder.path(), &["lens", file]);
    assert_eq!(code, 0, "{err}");
    assert!(out.contains("0, 7 deg  field angle") && out.contains("N-BK7, stop"), "{out}");
}

#[test]
fn the_table_of_a_lens_names_glasses_shapes_and_the_stop() {
    let table = |name: &str| {
        let (code, out, err) = petzval(root(), &["lens", &lens(name)]);
        assert_eq!(code, 0, "{err}");
        out
    };
    let triplet = table("triplet.toml");
    assert!(triplet.contains("SK16") && triplet.contains("Abbe"), "{triplet}");
    let row = triplet.lines().find(|line| line.trim_start().starts_with("4 ")).expect("a surface");
    assert!(row.ends_with("stop"), "{row}");
    let phone = table("phone.toml");
    assert!(phone.contains("surface 2: conic 1.153") && phone.contains("a10 -0.004265"), "{phone}");
    let row = phone.lines().find(|line| line.trim_start().starts_with("1 ")).expect("a surface");
    assert!(row.contains("stop"), "{row}");
    assert!(phone.lines().all(|line| line.len() <= 100), "{phone}");
}

#[test]
fn one_analysis_prints_alone() {
    let (code, out, _) = report(&lens("triplet.toml"), &["--json", "first-order"]);
    assert_eq!(code, 0);
    let section: Value = serde_json::from_str(&out).expect("JSON");
    let figure = |name: &str| section["figures"][name]["value"].as_f64().expect("a figure");
    // Zemax's sample, as optiland 0.6 computes it.
    assert!((figure("effective_focal_length") - 50.0).abs() < 0.05);
    assert!((figure("f_number") - 5.0).abs() < 0.05);
}

#[test]
fn wrong_arguments_say_what_to_do() {
    let (code, _, err) = report(&lens("triplet.toml"), &["--json", "mtv"]);
    assert_eq!(code, 2);
    assert!(err.contains("expected all or one of prescription"), "{err}");
    let (code, _, err) = report(&lens("triplet.toml"), &[]);
    assert_eq!(code, 2);
    assert!(err.contains("--output"), "{err}");
    let (code, _, err) = report("none.dat", &["--json", "all"]);
    assert_eq!(code, 2);
    assert!(err.contains("none.dat"), "{err}");
    let (code, _, err) = report(&lens("triplet.toml"), &["--json", "mtf", "--focus", "10mm"]);
    assert_eq!(code, 2);
    assert!(err.contains("triplet.toml") && err.contains("nearest"), "{err}");
}

#[test]
fn a_folder_that_cannot_be_made_is_an_error() {
    let folder = folder();
    write(&folder, "taken", "a file");
    let lens = lens("triplet.toml");
    let mut arguments = vec!["lens", "report", &lens, "-o", "taken"];
    arguments.extend(FEW);
    let (code, _, err) = petzval(folder.path(), &arguments);
    assert_eq!(code, 2);
    assert!(err.contains("cannot create the folder taken"), "{err}");
}
