//! Glasses by number: six-digit codes, fictitious glasses, and index with Abbe number.

use super::shelf::{Shelf, is_of};
use super::{Glass, GlassMatch};

/// Largest differences from a code within which a glass is the one that the code means: nd and Vd are
/// rounded to 0.001 and 0.1, and makers round in different ways.
const SAME: [f64; 2] = [1.1e-3, 0.11];

/// Returns the glass of a number; see [`super::GlassLibrary::by_code`].
pub(super) fn by_code(shelf: &Shelf, code: &str) -> Option<GlassMatch> {
    let code = code.trim().trim_matches(['\'', '"']);
    let (number, maker) = match code.find(|c: char| c.is_ascii_alphabetic()) {
        Some(at) => (code[..at].trim_end_matches(['.', '_', ' ', ':', '(']), Some(&code[at..])),
        None => (code, None),
    };
    let (nd, vd, rounded) = figures(number)?;
    if !(1.2..4.5).contains(&nd) || !(5.0..200.0).contains(&vd) {
        return None;
    }
    let model = |substitution| GlassMatch {
        glass: Glass::model(nd, vd, 0.0),
        substitution,
        ambiguity: None,
    };
    let Some(maker) = maker.map(|maker| maker.trim_end_matches(')')) else {
        return Some(model(None));
    };
    // In units of the rounding.
    let distance = |nd_is: f64, vd_is: f64| {
        let [off_nd, off_vd] = [(nd_is - nd).abs() / SAME[0], (vd_is - vd).abs() / SAME[1]];
        off_nd.max(off_vd)
    };
    let of_maker =
        shelf.glasses().iter().filter(|glass| !glass.maker.is_empty() && is_of(glass, maker));
    let near = of_maker.filter_map(|glass| {
        let [nd, vd] = glass.published?;
        Some((distance(nd, vd), glass))
    });
    let nearest = near.min_by(|(a, _), (b, _)| a.total_cmp(b));
    let Some((_, glass)) = nearest.filter(|(distance, _)| !rounded || *distance <= 1.0) else {
        let shown = code.to_owned();
        return Some(model(Some(format!(
            "no glass of {maker} has the code {shown}: a model glass of nd {nd} and Vd {vd} stands in"
        ))));
    };
    Some(GlassMatch { glass: Glass::Catalogue(glass.clone()), substitution: None, ambiguity: None })
}

/// Returns nd and Vd of a number, and whether they are rounded to three digits.
fn figures(number: &str) -> Option<(f64, f64, bool)> {
    let pair = |nd: &str, vd: &str| Some((nd.trim().parse().ok()?, vd.trim().parse().ok()?));
    // Index and Abbe number: "1.5168:64.17", "1.5168/64.17", "1.5168, 64.17".
    if let Some((nd, vd)) = number.split_once([':', '/', ',', ' ']) {
        let (nd, vd): (f64, f64) = pair(nd, vd)?;
        return Some((nd, vd, false));
    }
    let is_number = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    let (left, right) = match number.split_once('.') {
        // "517642"
        None if number.len() == 6 && number.is_ascii() => number.split_at(3),
        None => return None,
        Some(parts) => parts,
    };
    if !is_number(left) || !is_number(right) {
        return None;
    }
    // Schott's ninefold code "517642.251": the last digits are the density.
    if left.len() == 6 && right.len() == 3 {
        let (nd, vd) = left.split_at(3);
        return figures(&format!("{nd}.{vd}"));
    }
    // CODE V: nd - 1 and Vd without their points, "517.642" and "516800.641700".
    if left.len() < 3 || right.len() < 3 {
        return None;
    }
    let (fraction, vd): (f64, f64) = pair(&format!("0.{left}"), right)?;
    let vd = vd / 10f64.powi(right.len() as i32 - 2);
    Some((1.0 + fraction, vd, left.len() == 3))
}

#[cfg(test)]
mod tests {
    use super::super::{D_LINE, GlassLibrary};

    #[test]
    fn a_code_with_a_maker_is_a_glass_of_that_maker() {
        for (code, expected) in [
            ("517642.SCHOTT", "Schott N-BK7"),
            ("517642_schott", "Schott N-BK7"),
            ("516641.OHARA", "Ohara"),
            ("517642.CDGM", "CDGM"),
            ("805254.251SCHOTT", "Schott"),
        ] {
            let found = GlassLibrary::built_in().by_code(code).expect(code);
            assert!(found.glass.to_string().starts_with(expected), "{code}: {}", found.glass);
            assert_eq!(found.substitution, None);
        }
        let found = GlassLibrary::built_in().by_code("999111.SCHOTT").expect("a model");
        assert!(found.substitution.is_some_and(|text| text.contains("999111")));
    }

    #[test]
    fn a_code_without_a_maker_is_a_model_of_its_figures() {
        for (code, nd, vd) in [
            ("517642", 1.517, 64.2),
            ("620.603", 1.62, 60.3),
            ("569.631", 1.569, 63.1),
            ("516800.641700", 1.5168, 64.17),
            ("517642.251", 1.517, 64.2),
            ("1.5168:64.17", 1.5168, 64.17),
            ("1.545000:56.000000", 1.545, 56.0),
            ("1.72916/54.7", 1.72916, 54.7),
        ] {
            let glass = GlassLibrary::built_in().by_code(code).expect(code).glass;
            assert!((glass.index(0.0, D_LINE).unwrap() - nd).abs() < 1e-12, "{code}");
            let spread = glass.index(0.0, super::super::F_LINE).unwrap()
                - glass.index(0.0, super::super::C_LINE).unwrap();
            assert!(((nd - 1.0) / spread - vd).abs() < 1e-9, "{code}");
        }
        for code in [
            "", ".", "1.5", "51764", "5176421", "abc", "517642é", "é17642", "1.5:", "0:0", "a:b",
            "1e9:5",
        ] {
            assert_eq!(GlassLibrary::built_in().by_code(code), None, "{code}");
        }
    }
}
