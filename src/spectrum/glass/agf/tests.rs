use super::super::{D_LINE, GlassLibrary};
use super::*;

/// Two glasses of our own figures: a crown by Sellmeier and a plastic by Conrady.
const SMALL: &str = "CC a small catalogue\nNM CROWN-1 2 500600 1.500000 60.0 0 1 0\nGC our own\n\
    ED 7.1 8.3 2.51 -0.0009 0\nCD 1.2245 0.0105 0 0 0 0 0 0 0 0\nTD 0 0 0 0 0 0 20\nLD 0.35 2.0\n\
    IT 0.4 0.99 10\nNM PLASTIC-1 5 0\nCD 1.48 0.006 0.0006\nLD 4.0E-001 1.0\n";

fn parsed(text: &str) -> Result<Vec<CatalogueGlass>, GlassError> {
    parse(Path::new("folder/small.agf"), text.as_bytes())
}

#[test]
fn a_catalogue_gives_names_figures_ranges_and_formulas() {
    let [crown, plastic] = &parsed(SMALL).unwrap()[..] else { panic!() };
    assert_eq!((&*crown.name, &*crown.maker), ("CROWN-1", "small"));
    assert_eq!((crown.published, crown.range), (Some([1.5, 60.0]), [350.0, 2000.0]));
    let square: f64 = 0.5 * 0.5;
    let expected = (1.0 + 1.2245 * square / (square - 0.0105)).sqrt();
    assert!((crown.index(500.0) - expected).abs() < 1e-15);
    assert_eq!((plastic.published, plastic.range), (None, [400.0, 1000.0]));
    let expected = 1.48 + 0.006 / 0.5 + 0.0006 / 0.5f64.powf(3.5);
    assert!((plastic.index(500.0) - expected).abs() < 1e-15);
}

#[test]
fn all_thirteen_formulas_have_their_definitions() {
    let l: f64 = 0.6;
    let s = l * l;
    let c = [1.5, 0.01, 0.02, 0.003, 0.004, 0.005, 0.006, 0.007, 0.008, 0.009];
    let d = 1.0 / (s - 0.028);
    let pair = |i: usize| c[i] * s / (s - c[i + 1]);
    let squares = [
        (1, c[0] + c[1] * s + c[2] / s + c[3] / s.powi(2) + c[4] / s.powi(3) + c[5] / s.powi(4)),
        (2, 1.0 + pair(0) + pair(2) + pair(4)),
        (4, 1.0 + c[0] + c[1] * s / (s - c[2] * c[2]) + c[3] / (s - c[4] * c[4])),
        (6, 1.0 + pair(0) + pair(2) + pair(4) + pair(6)),
        (7, c[0] + c[1] / (s - c[2]) - c[3] * s),
        (8, c[0] + c[1] * s / (s - c[2]) - c[3] * s),
        (9, c[0] + c[1] * s / (s - c[2]) + c[3] * s / (s - c[4])),
        (
            10,
            c[0] + c[1] * s
                + c[2] / s
                + c[3] / s.powi(2)
                + c[4] / s.powi(3)
                + c[5] / s.powi(4)
                + c[6] / s.powi(5)
                + c[7] / s.powi(6),
        ),
        (11, 1.0 + pair(0) + pair(2) + pair(4) + pair(6) + pair(8)),
        (
            12,
            c[0] + c[1] * s
                + c[2] / s
                + c[3] / s.powi(2)
                + c[4] / s.powi(3)
                + c[5] / s.powi(4)
                + c[6] * s.powi(2)
                + c[7] * s.powi(3),
        ),
        (
            13,
            c[0] + c[1] * s
                + c[2] * s.powi(2)
                + c[3] / s
                + c[4] / s.powi(2)
                + c[5] / s.powi(3)
                + c[6] / s.powi(4)
                + c[7] / s.powi(5)
                + c[8] / s.powi(6),
        ),
    ];
    let herzberger = c[0] + c[1] * d + c[2] * d * d + c[3] * s + c[4] * s * s + c[5] * s.powi(3);
    let conrady = c[0] + c[1] / l + c[2] / l.powf(3.5);
    let indices = squares.map(|(number, square): (u32, f64)| (number, square.sqrt()));
    for (number, expected) in indices.into_iter().chain([(3, herzberger), (5, conrady)]) {
        let found = formula::formula(number, &c).index(l * 1000.0);
        assert!((found - expected).abs() < 1e-13, "formula {number}: {found}, not {expected}");
    }
}

#[test]
fn coefficients_may_go_on_in_further_lines() {
    let broken = SMALL.replace("CD 1.2245 0.0105 0 0", "CD 1.2245\n0.0105 0\n 0");
    assert!(broken != SMALL && parsed(&broken).unwrap() == parsed(SMALL).unwrap());
}

#[test]
fn a_catalogue_is_read_in_every_encoding() {
    let text = SMALL.replace("our own", "notre propre mélange");
    let expected = parsed(&text).unwrap();
    let wide = |mark: bool, to: fn(u16) -> [u8; 2]| -> Vec<u8> {
        let marked = if mark { format!("\u{feff}{text}") } else { text.clone() };
        marked.encode_utf16().flat_map(to).collect()
    };
    let latin: Vec<u8> = text.chars().map(|c| c as u8).collect();
    for bytes in [
        format!("\u{feff}{text}").into_bytes(),
        text.replace('\n', "\r\n").into_bytes(),
        latin,
        wide(true, u16::to_le_bytes),
        wide(true, u16::to_be_bytes),
        wide(false, u16::to_le_bytes),
        wide(false, u16::to_be_bytes),
    ] {
        assert_eq!(parse(Path::new("small.agf"), &bytes).unwrap(), expected);
    }
}

#[test]
fn a_fault_is_named_with_its_line() {
    for (text, expected) in [
        ("", "small.agf:1: no glass in the file; expected an AGF catalogue with NM lines"),
        ("NM\n", "small.agf:1: NM without a name"),
        ("CC\nNM A 14\n", "small.agf:2: formula \"14\" of A; expected 1 to 13"),
        ("NM A x\n", "formula \"x\""),
        ("NM A 2\nCD 1 two\n", "small.agf:2: CD has \"two\"; expected finite numbers"),
        ("NM A 2\nCD 1 nan\n", "CD has \"nan\""),
        ("NM A 2\nCD 1\n", "small.agf:1: the glass A has no LD line"),
        ("NM A 2\nLD 1 2\nNM B 2\n", "small.agf:1: the glass A has no CD line"),
        ("NM A 2\nLD 2 1\n", "small.agf:2: LD from 2000 to 1000 nm"),
    ] {
        let message = parsed(text).unwrap_err().to_string();
        assert!(message.contains(expected), "{text:?}: {message}");
    }
}

#[test]
fn glasses_of_a_users_catalogue_come_before_the_built_in_ones() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("Mine.AGF");
    std::fs::write(&file, SMALL.replace("CROWN-1", "N-BK7")).unwrap();
    std::fs::write(folder.path().join("notes.txt"), "no glass").unwrap();
    for path in [&file, folder.path()] {
        let context = ReadContext::default().with_catalogues([path.into()]);
        let library = GlassLibrary::for_context(&context).unwrap();
        let of = |name: &str| library.find(name, &[]).unwrap().glass;
        assert_eq!(of("NBK7").to_string(), "Mine N-BK7");
        assert_eq!(of("plastic1_MINE").to_string(), "Mine PLASTIC-1");
        assert_eq!(of("Schott N-BK7").to_string(), "Schott N-BK7");
        assert!((of("PLASTIC-1").index(0.0, D_LINE).unwrap() - 1.49).abs() < 0.01);
        assert!(of("PLASTIC-1").index(0.0, 1100.0).is_err());
        assert_eq!(context.files().iter().count(), 1);
    }
    let empty = tempfile::tempdir().unwrap();
    let context = ReadContext::default().with_catalogues([empty.path().into()]);
    let message = GlassLibrary::for_context(&context).unwrap_err().to_string();
    assert!(message.contains("the folder has no .agf file"), "{message}");
}
