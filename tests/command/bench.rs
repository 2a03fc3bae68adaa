//! `petzval bench --json`: the names, values and units of its measurements. No test limits a speed.

use crate::support::{petzval, root};
use serde_json::Value;

#[test]
#[ignore = "takes ten seconds of both cores; .ci/run runs it"]
fn the_suite_is_a_list_of_finite_values_with_units() {
    let (code, stdout, stderr) = petzval(root(), &["bench", "--json"]);
    assert_eq!(code, 0, "{stderr}");
    let suite: Value = serde_json::from_str(&stdout).expect("JSON");
    let suite = suite.as_array().expect("a list");
    let of = |name: &str| {
        let measure = suite.iter().find(|measure| measure["name"] == name).expect(name);
        measure["value"].as_f64().expect("a number")
    };
    for measure in suite {
        assert!(measure["unit"].is_string(), "{measure}");
        assert!(measure["value"].as_f64().is_some_and(f64::is_finite), "{measure}");
    }
    assert!(of("lens.trace.dgauss.f32x8") > 0.0 && of("ratio.simd_scalar") > 0.0);
    for lens in ["dgauss", "fisheye", "telephoto", "wide"] {
        for stop in ["", ".stop8"] {
            let share = of(&format!("pupil.survival.{lens}{stop}"));
            assert!((0.97..1.0).contains(&share), "{lens}{stop}: {share}");
        }
    }
}
