//! Stacks of films: `[[coating]]`.

use std::path::Path;

use petzval_lens::{Coating, CoatingLayer, LayerStack, Prescription};
use petzval_lens_formats::write_lens;
use petzval_spectrum::{Glass, find_glass};

use super::{by_line, parsed};

/// A lens of one glass with these definitions and this coating on both faces.
fn coated(definitions: &str, name: &str) -> String {
    format!(
        "{definitions}\n[[surface]]\nradius = 30\nthickness = 3\ndiameter = 8\nindex = 1.52\n\
         coating = \"{name}\"\n[[surface]]\nradius = -30\ndiameter = 8\ncoating = \"{name}\"\n\
         [[surface]]\ndiameter = 5\nstop = true\n"
    )
}

const DEFINITION: &str = "[[coating]]\nname = \"Front \\\"A\\\"\"\nlayers = [\n\
                          { glass = \"MGF2\", thickness = 99.6 },\n\
                          { index = 2.05, abbe = 30, thickness = 134 },\n\
                          { index = [[400, 1.8], [700, 1.75]], thickness = 1e-2 },\n]\n";

fn stack(lens: &Prescription, row: usize) -> &LayerStack {
    match &lens.rows[row].coating {
        Some(Coating::Stack(stack)) => stack,
        other => panic!("{other:?}"),
    }
}

#[test]
fn films_are_read_from_air_to_glass() {
    let lens = parsed(&coated(DEFINITION, "front \\\"a\\\"")).expect("a lens");
    let mgf2 = Glass::Catalogue(find_glass("MGF2").expect("a known crystal"));
    let table = Glass::Table([[400.0, 1.8], [700.0, 1.75]].into());
    let layers = [
        CoatingLayer { index: mgf2.nd(), glass: mgf2, thickness: 99.6 },
        CoatingLayer { index: 2.05, glass: Glass::Abbe { nd: 2.05, vd: 30.0 }, thickness: 134.0 },
        CoatingLayer { index: table.nd(), glass: table, thickness: 0.01 },
    ];
    for row in [0, 1] {
        assert_eq!(*stack(&lens, row).layers, layers);
        assert_eq!(&*stack(&lens, row).name, "Front \"A\"");
    }
}

#[test]
fn a_written_stack_is_read_again() {
    let lens = parsed(&coated(DEFINITION, "Front \\\"A\\\"")).expect("a lens");
    let text = write_lens(Path::new("a.toml"), &lens).expect("TOML holds every lens").text;
    assert_eq!(text.matches("[[coating]]").count(), 1, "{text}");
    let again = parsed(&text).unwrap_or_else(|error| panic!("{error}\n{text}"));
    assert_eq!(again.rows, lens.rows, "{text}");
}

#[test]
fn a_stack_that_cannot_be_is_refused_with_its_line() {
    let many = format!("name = 'x'\nlayers = [{}]", "{ index = 2, thickness = 9 },".repeat(101));
    let layer = |keys: &str| format!("name = 'x'\nlayers = [\n{{ {keys} }}]");
    let cases: [(String, &str); 17] = [
        ("layers = []".into(), "1: a coating without a name"),
        ("name = '  '\nlayers = []".into(), "2: a coating without a name"),
        ("name = 'Mgf2'".into(), "2: a coating with the name \"Mgf2\"; expected another name"),
        ("name = 'x'".into(), "1: a coating without layers; expected layers = [{ glass"),
        ("name = 'x'\nlayers = []".into(), "3: a coating without layers"),
        ("name = 'x'\nlayers = 3".into(), "3: layers is not a list"),
        ("name = 'x'\nlayers = [3]".into(), "3: an entry of layers without keys"),
        ("name = 'x'\nlayer = []".into(), "3: unknown key \"layer\"; did you mean \"layers\"?"),
        (many, "3: 101 layers of a coating; expected 100 at most"),
        (layer("thickness = 9"), "4: a layer without a material; expected glass or index"),
        (layer("index = 2"), "4: a layer without thickness; expected a thickness in nm"),
        (layer("index = 2, thickness = 0"), "4: thickness is 0; expected a thickness in nm"),
        (layer("index = 2, thickness = 2e4"), ""),
        (layer("index = 2, thickness = 2.1e4"), "4: thickness is 21000; expected"),
        (layer("index = 1.2, thickness = 9"), "4: a layer of index 1.2; expected 1.34 or more"),
        (layer("index = 2, nm = 9"), "4: unknown key \"nm\""),
        (layer("glass = 'MGF3', thickness = 9"), "4: no glass \"MGF3\""),
    ];
    for (keys, expected) in cases {
        let text = coated(&format!("[[coating]]\n{keys}"), "x");
        match parsed(&text) {
            Ok(_) => assert_eq!(expected, "", "{keys}"),
            Err(error) => {
                let error = error.to_string();
                let expected = format!("test.toml:{expected}");
                assert!(
                    by_line(&error).starts_with(&expected) && expected != "test.toml:",
                    "{keys:?}\n  found    {error}\n  expected {expected}"
                );
            }
        }
    }
    let twice = coated(&format!("{DEFINITION}{DEFINITION}"), "x");
    let error = parsed(&twice).unwrap_err().to_string();
    assert!(by_line(&error).starts_with("test.toml:9: a second coating"), "{error}");
}

#[test]
fn an_unknown_coating_names_those_of_the_file() {
    let error = parsed(&coated(DEFINITION, "frnt \\\"a\\\"")).unwrap_err().to_string();
    assert!(error.contains("did you mean \"Front \"A\"\"?"), "{error}");
    assert!(error.contains("mgf2, broadband, perfect, Front \"A\", or the name of"), "{error}");
    let cemented = coated(DEFINITION, "none").replace(
        "diameter = 8\ncoating = \"none\"\n[[surface]]\ndiameter = 5",
        "thickness = 2\nindex = 1.7\ndiameter = 8\ncoating = \"front \\\"a\\\"\"\n\
         [[surface]]\ndiameter = 8\n[[surface]]\ndiameter = 5",
    );
    let error = parsed(&cemented).unwrap_err().to_string();
    assert!(error.contains("Front \"A\" between indices 1.52 and 1.7; leave it out"), "{error}");
}
