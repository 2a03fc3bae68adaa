//! Losses of light by surface against brute force, in the library, the table and the picture.

use std::path::Path;
use std::process::{Command, Output, Stdio};

use crate::support::{LENSES, folder, lens, oracle, root, row};
use petzval_lens::{LightBudget, Normalization, Prescription, Row, Rows, Vignetting};
use petzval_lens_formats::read;

/// Number of rays that gives shares to about 0.1 %.
const RAYS: u32 = 1 << 16;

fn shares(budget: &LightBudget) -> f64 {
    budget.pass + budget.rows.iter().map(|row| row.share()).sum::<f64>()
}

/// Returns every lens of the repository with its film distance and half the film diagonal, mm.
fn all() -> Vec<(Prescription, f64, f64)> {
    let mut all: Vec<_> = LENSES.iter().map(|(name, film)| (lens(name), *film, 21.635)).collect();
    for (name, film, half) in
        [("triplet", 42.436, 21.635), ("anamorphic", 42.436, 21.635), ("phone", 0.568, 3.5)]
    {
        let file = root().join("lenses").join(format!("{name}.toml"));
        all.push((read(&file).unwrap(), film, half));
    }
    all
}

/// Traces a grid in the plane of the rear vertex from a film point by the oracle. Returns the
/// irradiance, the share of the light into the rear element that passes, and the share that each row
/// blocks.
fn light_by_grid(lens: &Prescription, film: f64, r: f64) -> (f64, f64, Vec<f64>) {
    let (grid, reach) = (1600, lens.rear().diameter);
    let cell = 2.0 * reach / f64::from(grid);
    let (mut passed, mut lost) = (0.0, vec![0.0; lens.rows.len()]);
    for j in 0..grid / 2 {
        let v = (f64::from(j) + 0.5) * cell;
        for i in 0..grid {
            let u = -reach + (f64::from(i) + 0.5) * cell;
            let d = [u - r, v, film];
            let d2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
            let light = 2.0 * film * film / (d2 * d2);
            match oracle::trace_spheres(lens, film, [r, 0.0, 0.0], d) {
                Ok(_) => passed += light,
                Err(row) => lost[row] += light,
            }
        }
    }
    // Rays outside the rim of the rear element do not count.
    lost.pop();
    let all = passed + lost.iter().sum::<f64>();
    (passed * cell * cell, passed / all, lost.into_iter().map(|row| row / all).collect())
}

#[test]
fn shares_add_up_to_one_in_every_zone() {
    for (lens, film, half) in all() {
        let vignetting = Vignetting::new(&lens, film, 1 << 13);
        for zone in 0..=10 {
            let height = half * f64::from(zone) / 10.0;
            for of in [Normalization::Stop, Normalization::Rear] {
                for point in [[height, 0.0], [height * 0.6, height * -0.8]] {
                    let Some(budget) = vignetting.budget(point, of) else { continue };
                    let sum = shares(&budget);
                    assert!((sum - 1.0).abs() < 1e-6, "{} at {point:?}: {sum}", lens.name);
                    let stop = budget.rows[lens.stop()].share();
                    assert!(
                        of == Normalization::Rear || stop == 0.0,
                        "{}: {stop} at the stop",
                        lens.name
                    );
                }
            }
        }
    }
}

#[test]
fn light_and_losses_agree_with_brute_force() {
    for (name, film) in [LENSES[0], LENSES[3]] {
        let lens = lens(name);
        let vignetting = Vignetting::new(&lens, film, RAYS);
        let irradiance = |r: f64, of| vignetting.budget([r, 0.0], of).unwrap().irradiance;
        let centre = light_by_grid(&lens, film, 0.0).0;
        for r in [6.0, 13.0, 20.0] {
            let (truth, passes, lost) = light_by_grid(&lens, film, r);
            for of in [Normalization::Stop, Normalization::Rear] {
                let relative = irradiance(r, of) / irradiance(0.0, of);
                println!("{name} at {r}, {of:?}: {relative:.5} against {:.5}", truth / centre);
                // Relative to the illumination on the axis.
                assert!((relative - truth / centre).abs() < 0.002, "{name} at {r}");
                assert!((relative / (truth / centre) - 1.0).abs() < 0.005, "{name} at {r}");
            }
            let budget = vignetting.budget([r, 0.0], Normalization::Rear).unwrap();
            assert!((budget.pass - passes).abs() < 0.002, "{name} at {r}");
            for (row, truth) in lost.iter().enumerate() {
                let ours = budget.rows[row].share();
                assert!((ours - truth).abs() < 0.002, "{name} at {r}, row {row}: {ours}, {truth}");
            }
        }
    }
}

#[test]
fn losses_at_rims_agree_with_brute_force() {
    let (name, film) = LENSES[0];
    let lens = lens(name);
    let stop = lens.stop();
    // The oracle traces the stop and the rows behind it, with open rims.
    let mut open = lens.clone();
    open.rows = Rows::new(lens.rows[stop..].to_vec()).expect("one stop");
    for row in &mut open.rows[1..] {
        row.diameter = (2.0 * row.radius.abs()).min(80.0);
    }
    for r in [0.0, 10.0, 20.0] {
        let (grid, reach) = (1600, 30.0);
        let (mut all, mut passed, mut lost) = (0.0, 0.0, vec![0.0; lens.rows.len()]);
        for j in 0..grid / 2 {
            for i in 0..grid {
                let place = |i: i32| reach * (2.0 * (f64::from(i) + 0.5) / f64::from(grid) - 1.0);
                let d = [place(i) - r, place(j), film];
                if oracle::trace_spheres(&open, film, [r, 0.0, 0.0], d).is_err() {
                    continue;
                }
                let d2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
                let light = 1.0 / (d2 * d2);
                all += light;
                match oracle::trace_spheres(&lens, film, [r, 0.0, 0.0], d) {
                    Ok(_) => passed += light,
                    Err(row) => lost[row] += light,
                }
            }
        }
        let budget =
            Vignetting::new(&lens, film, RAYS).budget([r, 0.0], Normalization::Stop).unwrap();
        println!("{name} at {r}: passes {} against {}", budget.pass, passed / all);
        assert!((budget.pass - passed / all).abs() < 0.002, "{name} at {r}");
        for (row, lost) in lost.iter().enumerate() {
            let (ours, truth) = (budget.rows[row].share(), lost / all);
            assert!((ours - truth).abs() < 0.002, "{name} at {r}, row {row}: {ours}, {truth}");
        }
    }
}

#[test]
fn a_narrow_front_rim_takes_all_the_lost_light() {
    let (name, film) = LENSES[2];
    let mut narrow = lens(name);
    let budget = |lens: &Prescription| {
        Vignetting::new(lens, film, RAYS).budget([5.0, 0.0], Normalization::Stop)
    };
    assert_eq!(budget(&narrow).unwrap().pass, 1.0);
    narrow.rows[0].diameter = 33.0;
    let budget = budget(&narrow).unwrap();
    // The entrance pupil is 46 mm wide.
    assert!(budget.rows[0].rim > 0.4, "{budget:?}");
    assert!((budget.pass + budget.rows[0].rim - 1.0).abs() < 1e-9, "{budget:?}");
}

#[test]
fn total_internal_reflection_is_counted_apart_from_rims() {
    // A hemisphere in front of the stop: it totally reflects rays farther from the axis than 2/3 of
    // its radius, and its rim lies beyond them all.
    let rows = vec![
        crate::support::row(6.0, 6.0, 1.5, 11.9),
        crate::support::row(f64::INFINITY, 0.1, 1.0, 11.9),
        crate::support::row(0.0, 0.0, 1.0, 10.0),
    ];
    let mut ball = Prescription::new("half a ball", rows).expect("one stop");
    let budget = |lens: &Prescription| {
        Vignetting::new(lens, 5000.0, RAYS).budget([0.0, 0.0], Normalization::Stop).unwrap()
    };
    let reflected = budget(&ball);
    assert_eq!(reflected.rows[0].rim, 0.0, "{reflected:?}");
    assert!((reflected.rows[0].refraction - (1.0 - 16.0 / 25.0)).abs() < 0.005, "{reflected:?}");
    // A narrower rim blocks light that passed; the rest is totally reflected anyway.
    ball.rows[0].diameter = 6.0;
    let rim = budget(&ball);
    assert!((rim.rows[0].rim - (16.0 - 9.0) / 25.0).abs() < 0.005, "{rim:?}");
    assert!((rim.pass - 9.0 / 25.0).abs() < 0.005, "{rim:?}");
}

#[test]
fn a_shaped_stop_takes_light_without_vignetting() {
    let (name, film) = LENSES[2];
    let mut lens = lens(name);
    // A small stop, so that aberrations of the pupil do not matter.
    lens.stop_down(4.0);
    let stop = lens.stop();
    let round = Vignetting::new(&lens, film, RAYS).budget([5.0, 0.0], Normalization::Stop).unwrap();
    lens.rows[stop].iris = petzval_lens::Iris::Blades { count: 6, rotation: 10.0, curvature: 0.0 };
    let hexagon =
        Vignetting::new(&lens, film, RAYS).budget([5.0, 0.0], Normalization::Stop).unwrap();
    assert_eq!(hexagon.pass, 1.0);
    // Area of a hexagon in a circle.
    let ratio = hexagon.irradiance / round.irradiance;
    assert!((ratio - 1.5 * 3f64.sqrt() / std::f64::consts::PI).abs() < 0.002, "{ratio}");
}

#[test]
fn the_image_circle_and_the_field_angle_agree_with_brute_force_and_first_order_optics() {
    let vignetting = Vignetting::new(&lens("fisheye.10mm"), 23.192, RAYS);
    let end = vignetting.light_radius(21.635).unwrap();
    let lit = |r: f64| light_by_grid(&lens("fisheye.10mm"), 23.192, r).0 > 0.0;
    assert!(lit(end - 0.05) && !lit(end + 0.05), "{end}");
    assert_eq!(Vignetting::new(&lens("telephoto.250mm"), 123.7, RAYS).light_radius(21.0), None);

    let lens = lens("telephoto.250mm");
    let paraxial = petzval_lens::Paraxial::new(&lens);
    let vignetting = Vignetting::new(&lens, paraxial.back_focal_distance, RAYS);
    // With focus at infinity the image height is the focal length times the tangent.
    let angle = vignetting.field_angle(0.5).unwrap().to_radians();
    assert!((angle.tan() * paraxial.focal_length / 0.5 - 1.0).abs() < 1e-3, "{angle}");
}

fn petzval(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_petzval"));
    command.args(arguments).current_dir(root()).stdin(Stdio::null()).output().unwrap()
}

fn refuses(arguments: &[&str], expected: &str) {
    let output = petzval(arguments);
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {stderr}");
    assert!(stderr.contains(expected), "{arguments:?}\n  found    {stderr}\n  expected {expected}");
    assert!(output.stdout.is_empty() && !stderr.contains("panicked"), "{arguments:?}: {stderr}");
}

fn table(arguments: &[&str]) -> String {
    let output = petzval(&[&["lens"], arguments, &["--vignetting"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn the_table_has_a_line_for_each_zone_and_fits_a_terminal() {
    let text = table(&["lenses/dgauss.50mm.dat"]);
    let lines: Vec<&str> = text.lines().collect();
    let head = lines.iter().position(|line| line.contains("cos^4  pass")).expect("names");
    let cells = |line: &str| line.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
    let names = cells(lines[head]);
    assert_eq!(names[..5], ["height", "field", "light", "cos^4", "pass"]);
    assert_eq!(names[5..], ["1", "2", "3", "4", "5", "10", "11", "other"]);
    assert_eq!(cells(lines[head + 1])[..4], ["mm", "deg", "%", "%"]);
    let zones = &lines[head + 2..];
    assert_eq!(zones.len(), 11, "{text}");
    for (i, line) in zones.iter().enumerate() {
        assert_eq!(line.len(), lines[head].len(), "numbers stand under their names: {line}");
        let numbers: Vec<f64> = cells(line).iter().map(|cell| cell.parse().unwrap()).collect();
        assert!((numbers[0] - 2.1635 * i as f64).abs() < 0.006);
        // Each number is rounded to a tenth of a percent.
        let sum: f64 = numbers[4..].iter().sum();
        assert!((sum - 100.0).abs() < 0.5, "{line}");
    }
    assert_eq!(cells(zones[0])[..4], ["0.00", "0.0", "100.0", "100.0"]);
    for (name, _) in LENSES {
        let text = table(&[&format!("lenses/{name}.dat")]);
        assert!(text.lines().all(|line| line.len() <= 80), "{text}");
    }
    assert!(table(&["lenses/fisheye.10mm.dat"]).contains("the light ends here"));
    assert!(table(&["lenses/anamorphic.toml"]).contains("along its x axis"));
    // At a small stop no other surface blocks light.
    let closed = table(&["lenses/triplet.toml", "--stop", "1", "--film-diagonal", "20"]);
    assert!(closed.contains("film of 20 mm diagonal") && !closed.contains("other\n"), "{closed}");
}

/// Returns a lens of so many surfaces, a stop in their middle: weak lenses and plates by turns.
fn many_surfaces(count: usize) -> Vec<Row> {
    let pairs = count / 2;
    let thickness = 50.0 / count as f64;
    let radius = 30.0 * 0.5168 * pairs as f64;
    let glass = |pair: usize| {
        let bend = if pair.is_multiple_of(2) { radius } else { f64::INFINITY };
        [(bend, 1.5168), (f64::INFINITY, 1.0)].map(|(radius, index)| Row {
            radius,
            index,
            thickness,
            diameter: 30.0,
            ..Row::default()
        })
    };
    let stop = Row { stop: true, thickness, diameter: 20.0, ..Row::default() };
    let (front, rear) = (0..pairs / 2, pairs / 2..pairs);
    front.flat_map(glass).chain([stop]).chain(rear.flat_map(glass)).collect()
}

#[test]
fn light_budgets_do_not_depend_on_threads_and_fewer_rays_err_as_stated() {
    let lens = Prescription::new("many", many_surfaces(60)).expect("one stop");
    let film = petzval_lens::RealRayFocus::new(&lens).film_distance(f64::INFINITY).unwrap();
    let budgets = |threads: usize, rays: u32| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let vignetting = Vignetting::new(&lens, film, rays);
        pool.install(|| {
            [0.0, 12.0, 20.0].map(|x| vignetting.budget([x, 0.0], Normalization::Stop).unwrap())
        })
    };
    let few = budgets(1, 1 << 14);
    assert_eq!(few, budgets(3, 1 << 14), "the same bits on one thread and on three");
    assert!(few[2].pass < 0.97, "rims take light: {}", few[2].pass);
    for (few, many) in few.iter().zip(budgets(2, 1 << 18)) {
        assert!((few.pass - many.pass).abs() < 0.003, "{} and {}", few.pass, many.pass);
        assert!((few.irradiance / many.irradiance - 1.0).abs() < 0.003);
    }
}

#[test]
#[ignore = "measures time; .ci/long runs it"]
fn the_time_for_very_many_surfaces_is_linear() {
    let seconds = |count: usize| {
        let lens = Prescription::new("many", many_surfaces(count)).expect("one stop");
        let times = (0..5).map(|_| {
            let start = std::time::Instant::now();
            assert!(petzval_lens::Paraxial::new(&lens).focal_length > 0.0);
            start.elapsed().as_secs_f64()
        });
        times.fold(f64::INFINITY, f64::min)
    };
    // Quadratic steps make it 64 times; the larger lens does not fit the cache.
    let ratio = seconds(64_000) / seconds(8_000);
    assert!(ratio < 32.0, "8 times the surfaces take {ratio:.1} times the time");
}

#[test]
fn a_lens_of_very_many_surfaces_is_measured_with_fewer_rays() {
    let folder = folder();
    let rows = many_surfaces(3000);
    let line = |row: &Row| {
        let radius = match (row.stop, row.radius.is_finite()) {
            (true, _) => 0.0,
            (false, true) => row.radius,
            (false, false) => 1e12,
        };
        format!("{radius} {} {} {}\n", row.thickness, row.index, row.diameter)
    };
    let file =
        crate::support::write(&folder, "many.dat", rows.iter().map(line).collect::<String>());
    let drawing = folder.path().join("many.svg");
    let (file, drawing) = (file.to_str().unwrap(), drawing.to_str().unwrap());
    // A minute and more with a quarter of a million rays for each height on one thread.
    let text = table(&[file]);
    assert!(text.contains("The lens has 3001 surfaces: 32768 rays for each height"), "{text}");
    assert!(petzval(&["lens", file, "--draw", drawing]).status.success());
}

#[test]
fn layers_read_back_and_add_up_to_one() {
    let folder = folder();
    let render = |name: &str, more: &[&str]| {
        let path = folder.path().join(name);
        let mut arguments = vec!["render", "scenes/dgauss.pbrt", "--resolution", "40x30"];
        arguments.extend(["--spp", "1", "-o", path.to_str().unwrap(), "--aov", "vignetting"]);
        arguments.extend(more);
        let output = petzval(&arguments);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        path
    };
    let whole = channels(&render("whole.exr", &[]));
    let names: Vec<&str> = whole.iter().map(|(name, _)| name.as_str()).collect();
    assert!(names.contains(&"vignetting.pass") && names.contains(&"vignetting.surface11"));
    assert!(!names.contains(&"vignetting.surface06"), "the stop has a channel: {names:?}");
    sums(&whole);
    let middle = whole.iter().find(|(name, _)| name == "vignetting.pass").unwrap().1[15 * 40 + 20];
    assert!((middle - 0.98).abs() < 0.02, "{middle}");

    let part = channels(&render("part.exr", &["--crop", "4,6,20,21", "--half"]));
    for ((name, whole), (other, part)) in whole.iter().zip(&part) {
        assert_eq!(name, other);
        let cut = (6..21).flat_map(|y| (4..20).map(move |x| whole[y * 40 + x]));
        assert!(!name.starts_with("vig") || cut.eq(part.iter().copied()), "{name}");
    }
    // A lens that is not round uses another code path.
    sums(&channels(&render("wide.exr", &["--lens", "lenses/anamorphic.toml"])));
    // Readers of plain pictures still find the colours.
    assert!(petzval_image::Picture::read(&folder.path().join("whole.exr")).is_ok());
}

fn sums(channels: &[(String, Vec<f32>)]) {
    let layer: Vec<_> = channels.iter().filter(|(name, _)| name.starts_with("vig")).collect();
    for i in 0..layer[0].1.len() {
        let sum: f32 = layer.iter().map(|(_, values)| values[i]).sum();
        assert!((sum - 1.0).abs() < 1e-5, "pixel {i}: {sum}");
    }
}

fn channels(path: &Path) -> Vec<(String, Vec<f32>)> {
    use exr::prelude::*;
    let image = read_all_flat_layers_from_file(path).unwrap();
    assert_eq!(image.layer_data.len(), 1, "one part");
    let list = &image.layer_data[0].channel_data.list;
    list.iter()
        .map(|channel| (channel.name.to_string(), channel.sample_data.values_as_f32().collect()))
        .collect()
}

#[test]
fn wrong_arguments_end_with_exit_code_2() {
    let folder = folder();
    let png = folder.path().join("a.png");
    let out = folder.path().join("a.exr");
    let (png, out) = (png.to_str().unwrap(), out.to_str().unwrap());
    let scene = "scenes/dgauss.pbrt";
    refuses(&["render", scene, "-o", png, "--aov", "vignetting"], "only EXR holds layers");
    refuses(&["render", scene, "-o", out, "--aov", "depht"], "invalid value 'depht'");
    let pinhole = "Camera \"perspective\"\nWorldBegin\nLightSource \"infinite\"";
    let pinhole = crate::support::write(&folder, "pinhole.pbrt", pinhole);
    let pinhole = pinhole.to_str().unwrap();
    refuses(&["render", pinhole, "-o", out, "--aov", "vignetting"], "this camera has no lens");
    let lens = "lenses/dgauss.50mm.dat";
    refuses(&["lens", lens, "--film-diagonal", "30"], "--vignetting");
    refuses(&["lens", lens, "--vignetting", "--film-diagonal", "-3"], "expected a length");
    refuses(&["lens", lens, "--vignetting", "--focus", "10mm"], "the nearest it can is");
    let hollow = "name = 'hollow'\n[[surface]]\nstop = true\ndiameter = 5\nthickness = 1\n\
                  [[surface]]\nradius = 20\ndiameter = 10\nthickness = 3\nindex = 1.5\nabbe = 60\n\
                  [[surface]]\nradius = 30\ndiameter = 10\n";
    let hollow = crate::support::write(&folder, "hollow.toml", hollow);
    let hollow = hollow.to_str().unwrap();
    refuses(&["lens", hollow, "--vignetting", "--film-distance", "0.1"], "inside the lens");
    assert!(!Path::new(png).exists() && !Path::new(out).exists());
}

#[test]
fn the_field_angle_is_known_where_marginal_rays_are_blocked() {
    // A ball with a stop in its middle, as wide as the light there. Rays through the centre are not
    // refracted.
    let ball = |stop: f64| {
        let rows =
            vec![row(6.0, 6.0, 1.5, 11.9), row(0.0, 6.0, 1.5, stop), row(-6.0, 0.0, 1.0, 11.9)];
        Prescription::new("ball", rows).expect("one stop")
    };
    for stop in [2.0, 6.0, 9.0, 11.5] {
        let vignetting = Vignetting::new(&ball(stop), 3.0, 1 << 12);
        for x in [0.0, 0.3, 1.0, 2.0, 3.0] {
            let light =
                vignetting.budget([x, 0.0], Normalization::Stop).map_or(0.0, |budget| budget.pass);
            assert!(light > 0.2, "stop {stop}, height {x}: {light} passes");
            let expected = (x / 9.0).atan().to_degrees();
            let angle = vignetting.field_angle(x).expect("light passes the middle of the stop");
            assert!((angle - expected).abs() < 1e-6, "{stop}, {x}: {angle}, not {expected}");
        }
    }
}
