//! Orthographic and spherical cameras: their rays against independent formulas, parameters and errors.

use crate::support::{folder, mean, picture, root, write};
use glam::DVec3;
use petzval::prepare;
use petzval::{Aov, Changes, Job};
use petzval_base::rays::{Ray, RayBatch, SampleBatch};
use petzval_base::stats::LensStats;
use petzval_lens::{LensColumns, LensModel};
use petzval_render::Backend;
use petzval_render::prepare::{Viewpoint, prepare_draft};
use petzval_scene_formats::pbrt;
use petzval_scene_formats::pbrt::{CameraSpec, IrisSpec, RealisticSpec};

const RESOLUTION: [u32; 2] = [60, 40];

fn read(camera: &str) -> Result<pbrt::Description, String> {
    let folder = folder();
    let text = format!(
        "Film \"rgb\" \"integer xresolution\" {} \"integer yresolution\" {} \"float iso\" 200\n\
         {camera}\nWorldBegin\nShape \"sphere\"",
        RESOLUTION[0], RESOLUTION[1]
    );
    let path = write(&folder, "test.pbrt", text);
    pbrt::read(&path).map_err(|error| error.to_string())
}

fn job(camera: &str) -> Job {
    let description = read(camera).expect("a scene");
    assert!(description.warnings.is_empty(), "{:#?}", description.warnings);
    prepare(description, &Changes::default()).expect("a job").job
}

/// Returns the ray of the middle of a pixel.
fn ray(job: &Job, pixel: [u32; 2]) -> Ray {
    let mut rays = RayBatch::default();
    job.camera.central_ray(pixel, RESOLUTION, &mut rays);
    assert_eq!(rays.len, 1);
    rays.ray(0)
}

fn pixels() -> impl Iterator<Item = [u32; 2]> {
    (0..RESOLUTION[1]).step_by(3).flat_map(|y| (0..RESOLUTION[0]).step_by(4).map(move |x| [x, y]))
}

/// Returns the place of the middle of a pixel, as shares of the width from the left and of the height
/// from the top.
fn place(pixel: [u32; 2]) -> [f64; 2] {
    [0, 1].map(|i| (f64::from(pixel[i]) + 0.5) / f64::from(RESOLUTION[i]))
}

fn assert_ray(found: &Ray, origin: DVec3, direction: DVec3, what: &str) {
    let [start, towards] = [found.origin, found.direction].map(|v| DVec3::from(v.map(f64::from)));
    assert!(start.distance(origin) < 2e-6, "{what}: from {start}, not {origin}");
    assert!(towards.distance(direction) < 2e-6, "{what}: towards {towards}, not {direction}");
}

#[test]
fn orthographic_rays_are_parallel_and_fill_the_window() {
    let window = "Camera \"orthographic\" \"float screenwindow\" [-3 2 -1 4]";
    for (camera, [x0, x1, y0, y1]) in [
        ("Camera \"orthographic\"", [-1.5, 1.5, -1.0, 1.0]),
        ("Camera \"orthographic\" \"float frameaspectratio\" 0.5", [-1.0, 1.0, -2.0, 2.0]),
        (window, [-3.0, 2.0, -1.0, 4.0]),
    ] {
        let job = job(camera);
        assert!(matches!(job.camera.model, LensModel::Orthographic(_)));
        for pixel in pixels() {
            let [u, v] = place(pixel);
            let origin = DVec3::new(x0 + u * (x1 - x0), y1 + v * (y0 - y1), 0.0);
            assert_ray(&ray(&job, pixel), origin, DVec3::Z, camera);
        }
    }
}

#[test]
fn orthographic_rays_of_a_lens_leave_the_origin_as_in_pbrt() {
    let camera = "Camera \"orthographic\" \"float lensradius\" 0.25 \"float focaldistance\" 8";
    let job = job(camera);
    let mut samples = SampleBatch { len: 64, ..SampleBatch::default() };
    for i in 0..64 {
        (samples.pupil[0][i], samples.pupil[1][i]) =
            ((i % 8) as f32 / 8.0 + 0.01, (i / 8) as f32 / 8.0);
        samples.film[0][i] = (0.25 * job.camera.film[0]) as f32;
    }
    let mut rays = RayBatch::default();
    let (mut columns, mut stats) = (LensColumns::default(), LensStats::default());
    job.camera.generate_rays::<f32>(&samples, &mut columns, &mut rays, &mut stats);
    let mut farthest = 0f64;
    for i in 0..64 {
        let Ray { origin, direction, .. } = rays.ray(i);
        let [from, along] = [origin, direction].map(|v| DVec3::from(v.map(f64::from)));
        farthest = farthest.max(from.truncate().length());
        // All meet in the plane in focus, in which the window is. A quarter of the width to the left
        // on the film is a quarter to the left in the picture's mirror image.
        let meets = from + along * (8.0 / along.z);
        assert!(meets.distance(DVec3::new(-0.75, 0.0, 8.0)) < 1e-5, "{meets}");
    }
    assert!((0.2..0.250_001).contains(&farthest), "{farthest}");
}

#[test]
fn equirectangular_pixels_are_longitudes_and_latitudes() {
    let mapped = "Camera \"spherical\" \"string mapping\" \"equirectangular\"";
    for camera in [mapped, "Camera \"environment\""] {
        let job = job(camera);
        for pixel in pixels() {
            let [u, v] = place(pixel);
            let (longitude, latitude) =
                ((u - 0.25) * std::f64::consts::TAU, (0.5 - v) * std::f64::consts::PI);
            // Longitude 0 is +z; to the right of it is -x.
            let direction = DVec3::new(
                -longitude.sin() * latitude.cos(),
                latitude.sin(),
                longitude.cos() * latitude.cos(),
            );
            assert_ray(&ray(&job, pixel), DVec3::ZERO, direction, camera);
        }
    }
}

/// The directions are printed by pbrt-v4.
#[test]
fn equal_area_pixels_are_pbrts() {
    let job = job("Translate 0 0 3 Camera \"spherical\"");
    for (pixel, direction) in [
        ([0, 0], [-0.047_651_0, -0.998_263_9, -0.034_620_5]),
        ([29, 19], [-0.034_620_5, 0.998_263_9, -0.047_651_0]),
        ([30, 20], [0.034_620_5, 0.998_263_9, 0.047_651_0]),
        ([59, 0], [0.047_651_0, -0.998_263_9, -0.034_620_5]),
        ([10, 30], [-0.744_886_3, -0.319_374_9, 0.585_785_1]),
        ([45, 25], [0.793_012_7, 0.373_264_0, 0.481_461_2]),
        ([30, 39], [0.026_393_2, 0.016_597_2, 0.999_513_9]),
        ([7, 19], [-0.915_611_0, 0.399_375_1, -0.046_434_5]),
        ([52, 33], [0.576_295_2, -0.669_374_9, 0.468_850_9]),
    ] {
        let direction = DVec3::from(direction);
        assert_ray(&ray(&job, pixel), DVec3::new(0.0, 0.0, -3.0), direction, "spherical");
    }
}

#[test]
fn exposure_is_time_times_iso_over_100() {
    let shutter = "\"float shutteropen\" 0.25 \"float shutterclose\" 0.75";
    for kind in ["perspective", "orthographic", "spherical", "environment"] {
        let job = job(&format!("Camera \"{kind}\" {shutter}"));
        assert_eq!(job.camera.imaging_ratio, 1.0, "{kind}");
    }
}

#[test]
fn a_camera_without_a_lens_file_refuses_what_needs_one() {
    for kind in ["orthographic", "spherical"] {
        let description = || read(&format!("Camera \"{kind}\"")).expect("a scene");
        let message = |changes: Changes| {
            prepare(description(), &changes).map(|_| ()).expect_err(kind).to_string()
        };
        let focused = Changes { f_number: Some(4.0), ..Changes::default() };
        assert!(message(focused).contains("this camera has no lens file"));
        let layer = Changes { layers: vec![Aov::Coc], ..Changes::default() };
        assert!(message(layer).contains("'aov' coc: this camera has no lens file"));
        let layers = vec![Aov::Depth, Aov::Normal];
        let plain = Changes { layers, ..Changes::default() };
        assert!(prepare(description(), &plain).is_ok());
    }
}

#[test]
fn wrong_parameters_are_errors_at_their_position() {
    for (camera, expected) in [
        (
            "Camera \"spherical\" \"string mapping\" \"cube\"",
            "test.pbrt:2:20: the mapping \"cube\"; expected equalarea or equirectangular",
        ),
        ("Camera \"orthographic\" \"float fov\" 40", "unknown parameter \"fov\" of Camera"),
        ("Camera \"orthographic\" \"float screenwindow\" [1 -1 0 1]", "ascending"),
        ("Camera \"orthographic\" \"float lensradius\" -1", "a lens radius of -1"),
        ("Camera \"environment\" \"string mapping\" \"equalarea\"", "unknown parameter"),
    ] {
        let message = read(camera).map(|_| ()).expect_err(camera);
        assert!(message.contains(expected), "{camera}: {message}");
    }
    // pbrt-v4 reads these without a use.
    assert!(read("Camera \"spherical\" \"float screenwindow\" [0 1 0 1]").is_ok());
}

#[test]
fn a_viewpoint_places_the_camera_of_every_scene() {
    for scene in ["dgauss.pbrt", "zenith.pbrt"] {
        let description = pbrt::read(&root().join("scenes").join(scene)).expect("a scene");
        let own = prepare(description.clone(), &Changes::default()).expect("a job").job.camera;
        let there = "3,4,5,3,14,5,1,0,0".parse::<Viewpoint>().expect("a viewpoint");
        let changes = Changes { viewpoint: Some(there), ..Changes::default() };
        let moved = prepare(description, &changes).expect("a job").job.camera.world_from_camera;
        assert_eq!(moved.translation.to_array(), [3.0, 4.0, 5.0], "{scene}");
        let scale = own.world_from_camera.matrix3.determinant();
        assert!((moved.matrix3.determinant() / scale - 1.0).abs() < 1e-9, "{scene}");
        assert!(moved.matrix3.z_axis.normalize().y > 1.0 - 1e-12, "{scene}");
        assert!(moved.matrix3.y_axis.normalize().x > 1.0 - 1e-12, "{scene}");
    }
}

#[test]
fn a_draft_shows_the_light_of_the_picture() {
    let description = pbrt::read(&root().join("scenes/dgauss.pbrt")).expect("a scene");
    let changes = Changes {
        resolution: Some([48, 48]),
        samples: Some(64),
        f_number: Some(4.0),
        ..Changes::default()
    };
    let mut with_blades = description.clone();
    let CameraSpec::Realistic(RealisticSpec::V4 { iris, .. }) = &mut with_blades.camera else {
        panic!("a lens file")
    };
    *iris = Some(IrisSpec { path: "pentagon".into(), name: "pentagon".into() });
    for (description, blades) in [(description, false), (with_blades, true)] {
        let job = prepare(description.clone(), &changes).expect("a job").job;
        let first = prepare_draft(description.clone(), &changes, None).expect("a draft").job;
        let draft = prepare_draft(description, &changes, Some(&job.plan)).expect("a draft").job;
        let jobs = [&job, &draft, &first];
        let [whole, draft, first] = jobs.map(|job| mean(&picture(job, Backend::Simd, 1))[1]);
        // All have 64 samples: 1 % is far above their noise, and a stop is 100 %.
        assert!((draft / whole - 1.0).abs() < 0.01, "{draft} instead of {whole}");
        assert!((first / whole - 1.0).abs() < 0.01, "{first} instead of {whole}");
        // A draft samples all of the circle about the blades, and so every point of it less.
        let density = |job: &Job| match &job.camera.model {
            LensModel::Real(lens) => lens.sampling_density([0.0; 2], [0.0, 0.0, 1.0]),
            _ => panic!("a lens file"),
        };
        let [whole, draft, _] = jobs.map(density);
        let expected = if blades { 0.3..0.9 } else { 0.999..1.001 };
        assert!(expected.contains(&(draft / whole)), "{draft} and {whole}");
    }
}
