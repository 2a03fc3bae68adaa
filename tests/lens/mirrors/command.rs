//! The command with lenses that have mirrors.

use super::*;

pub(super) fn command(arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_petzval"))
        .current_dir(root())
        .args(arguments)
        .output()
        .expect("the command starts");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    assert!(output.status.success(), "{arguments:?}: {}", text(&output.stderr));
    text(&output.stdout) + &text(&output.stderr)
}

#[test]
fn the_command_describes_draws_and_traces_lenses_with_mirrors() {
    let folder = folder();
    let svg = folder.path().join("lens.svg");
    let svg = svg.to_str().expect("a name");
    for (text, focal, film) in [(CASSEGRAIN, 1600.0, "8"), (FOLDED, 0.0, "20")] {
        let file = write(&folder, "lens.toml", text);
        let file = file.to_str().expect("a name");
        let lens = petzval_lens_formats::read(&root().join(file)).expect("a lens");
        let f = Paraxial::new(&lens).focal_length;
        assert!(focal == 0.0 || (f - focal).abs() < 1e-6, "{f}");
        let report = command(&["lens", file, "--focus", "inf", "--draw", svg]);
        assert!(report.contains(&format!("{f:.4} mm")), "{report}");
        let drawing = std::fs::read_to_string(svg).expect("a drawing");
        assert!(drawing.contains("class=\"mirror\"") && drawing.contains("class=\"film\""));
        assert!(drawing.contains("class=\"field\""), "no rays");
        let table = command(&["lens", file, "--vignetting", "--film-diagonal", film]);
        assert!(!table.contains(" - "), "{table}");
    }
}

#[test]
fn traced_rays_of_the_command_equal_those_of_the_library() {
    let folder = folder();
    for (text, lens) in [(CASSEGRAIN, cassegrain()), (FOLDED, folded())] {
        let file = write(&folder, "lens.toml", text);
        let film = Paraxial::new(&lens).back_focal_distance;
        let surfaces = sequence::<f64>(&lens, Side::Film(film));
        let travel = lens.travel_before(lens.rows.len());
        let axis = lens.film_axis();
        let (mut csv, mut expected) = (String::new(), Vec::new());
        for [p, d] in aimed(&lens, film, 4.0, 300) {
            let length = d.iter().map(|v| v * v).sum::<f64>().sqrt();
            expected.push(trace_one::<f64>(LensRay::new(p, d.map(|v| v / length)), &surfaces));
            let p = axis.transform_point3(DVec3::new(p[0], p[1], travel * film));
            let d = axis.transform_vector3(DVec3::new(d[0], d[1], -travel * d[2]));
            csv += &format!("{:e},{:e},{:e},{:e},{:e},{:e}\n", p.x, p.y, p.z, d.x, d.y, d.z);
        }
        let rays = write(&folder, "rays.csv", csv);
        let [file, rays] = [&file, &rays].map(|path| path.to_str().expect("a name").to_owned());
        let lines = command(&["lens", "trace", &file, "--rays", &rays, "--precision", "f64"]);
        let mut passed = 0;
        for (line, expected) in lines.lines().zip(&expected) {
            let Ok(ray) = expected else {
                assert!(line.starts_with("blocked"), "{line}");
                continue;
            };
            passed += 1;
            let s = -ray.p[2] / ray.t[2];
            let ours: Vec<f64> = line.split(',').map(|v| v.parse().expect(line)).collect();
            for (k, at) in [ray.p[0] + s * ray.t[0], ray.p[1] + s * ray.t[1]].iter().enumerate() {
                assert!((ours[k] - at).abs() < 1e-8, "{line} for {at}");
            }
            assert!((ours[5] + ray.t[2]).abs() < 1e-10, "{line}");
        }
        assert!(passed > 30, "{passed}");
    }
}
