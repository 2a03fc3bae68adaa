//! `petzval bench --json`: the names, values and units of its measurements. No test limits a speed.

use crate::support::{petzval, root};
use serde_json::Value;

#[test]
fn the_suite_is_a_list_of_names_values_and_units() {
    let (code, stdout, stderr) = petzval(root(), &["bench", "--json"]);
    assert_eq!(code, 0, "{stderr}");
    let suite: Value = serde_json::from_str(&stdout).expect("JSON");
    let suite = suite.as_array().expect("a list");
    let of = |name: &str| {
        let measure = suite.iter().find(|measure| measure["name"] == name).expect(name);
        assert!(measure["unit"].is_string(), "{measure}");
        measure["value"].as_f64().expect("a number")
    };
    for name in [
        "lens.trace.dgauss.f32x8",
        "lens.trace.dgauss.f32",
        "lens.trace.dgauss.f64",
        "lens.trace.dgauss.textbook",
        "lens.valid.dgauss",
        "lens.model.dgauss.pinhole",
        "lens.model.dgauss.polynomial",
        "lens.model.dgauss.double",
        "scene.closest.camera",
        "scene.closest.diffuse",
        "scene.any.shadow",
        "render.dgauss.real",
        "render.dgauss.thin",
        "render.dgauss.pinhole",
        "render.wide.real.lens.ns",
        "effect.ghosts.ns",
        "ratio.simd_scalar",
        "ratio.real_thin",
        "ratio.f64_f32",
    ] {
        assert!(of(name) > 0.0, "{name}");
    }
    // These differences may be smaller than the noise of the machine.
    assert!(of("effect.dispersion.ns").is_finite() && of("effect.fresnel.ns").is_finite());
    for lens in ["dgauss", "fisheye", "telephoto", "wide"] {
        for stop in ["", ".stop8"] {
            let share = of(&format!("pupil.survival.{lens}{stop}"));
            assert!((0.97..1.0).contains(&share), "{lens}{stop}: {share}");
        }
    }
}
