//! Layers of a picture: their values, which vignetting does not bias.

mod support;

use petzval::aov::Aov;
use petzval::io::image::ImageLayer;
use petzval::lens::LensModel;
use petzval::plan::EffectSelection;
use petzval::prepare::{Changes, prepare};
use petzval::render::{RenderOptions, render};
use petzval::scene::pbrt;
use support::{folder, root, write};

const SIZE: usize = 48;

/// Renders layers of a world, in metres, with a camera at the origin that looks along +z.
fn layers(camera: &str, samples: u32, seed: u32, world: &str, wanted: &[Aov]) -> Vec<ImageLayer> {
    let lens = root().join("lenses/dgauss.50mm.dat");
    let camera = match camera {
        "pinhole" => "Camera \"perspective\" \"float fov\" 40".to_owned(),
        focus => format!(
            "Camera \"realistic\" \"string lensfile\" \"{}\" \"float aperturediameter\" 17.1
             \"float focusdistance\" {focus}",
            lens.display()
        ),
    };
    let text = format!(
        "Film \"rgb\" \"integer xresolution\" {SIZE} \"integer yresolution\" {SIZE}
         \"float diagonal\" 50 PixelFilter \"box\" Integrator \"path\" \"integer maxdepth\" 1
         {camera}\nWorldBegin\n{world}"
    );
    let folder = folder();
    let description = pbrt::read(&write(&folder, "scene.pbrt", text)).expect("a scene of a test");
    let changes = Changes {
        samples: Some(samples),
        seed: Some(seed),
        layers: wanted.to_vec(),
        ..Changes::default()
    };
    let (job, _, _) = prepare(description, &changes).expect("a job");
    let exposed =
        render(&job, RenderOptions { threads: 2, ..RenderOptions::default() }).expect("a picture");
    exposed.layers(&job)
}

fn channel<'a>(layer: &'a ImageLayer, name: &str) -> &'a [f32] {
    let found = layer.channels.iter().find(|(channel, _)| channel == name);
    &found.unwrap_or_else(|| panic!("no {name} in {}", layer.name)).1
}

/// Returns a wall that faces the camera, with its centre at `x` and a width of 2 `half`.
fn wall(x: f64, half: f64, z: f64) -> String {
    let (low, high) = (x - half, x + half);
    format!(
        "Shape \"trianglemesh\" \"integer indices\" [0 1 2 2 3 0]
         \"point3 P\" [{low} -9 {z}  {high} -9 {z}  {high} 9 {z}  {low} 9 {z}]\n"
    )
}

#[test]
fn layers_of_a_wall_are_equal_in_the_centre_and_in_the_vignetted_corner() {
    let world = "LightSource \"infinite\" Material \"diffuse\" \"rgb reflectance\" [0.2 0.4 0.6]\n"
        .to_owned()
        + &wall(0.0, 9.0, 2.5);
    let wanted = [Aov::Depth, Aov::Position, Aov::Normal, Aov::Albedo, Aov::Samples];
    let layers = layers("1.5", 64, 0, &world, &wanted);
    let [depth, position, normal, albedo, samples] = &layers[..] else { panic!() };
    let taken = channel(samples, "taken");
    let passed = channel(samples, "passed");
    let corner = passed[0] / passed[SIZE * SIZE / 2 + SIZE / 2];
    assert!(taken.iter().all(|&n| n == 64.0) && passed[0] > 0.0, "{corner}");
    for pixel in 0..SIZE * SIZE {
        let near = |found: f32, expected: f32, within: f32| {
            assert!((found - expected).abs() < within, "pixel {pixel}: {found}, not {expected}");
        };
        near(channel(depth, "Z")[pixel], 2.5, 1e-4);
        near(channel(depth, "coverage")[pixel], 1.0, 1e-6);
        near(channel(position, "Z")[pixel], 2.5, 1e-4);
        near(channel(normal, "Z")[pixel], -1.0, 1e-6);
        for (name, expected) in [("R", 0.2), ("G", 0.4), ("B", 0.6)] {
            near(channel(albedo, name)[pixel], expected, 1e-5);
        }
    }
}

#[test]
fn coverage_is_the_share_of_a_pixel_that_is_hit() {
    // A wall on the right half only: coverage is its share of a pixel.
    let wanted = [Aov::Depth];
    let layers = layers("pinhole", 4096, 0, &wall(9.0, 9.0, 2.0), &wanted);
    let coverage = channel(&layers[0], "coverage");
    let row = &coverage[SIZE * SIZE / 2..][..SIZE];
    assert!(row[..SIZE / 2].iter().all(|&c| c == 0.0), "{row:?}");
    assert!(row[SIZE / 2..].iter().all(|&c| c == 1.0), "{row:?}");
    // Depth is the mean over hits only.
    let depth = channel(&layers[0], "Z");
    assert!((depth[SIZE * SIZE / 2 + SIZE - 1] - 2.0).abs() < 1e-5);
    assert_eq!(depth[SIZE * SIZE / 2], 0.0);
}

#[test]
fn ids_of_shapes_instances_and_materials_follow_the_file() {
    let world = "Shape \"sphere\" \"float radius\" 0.001 \"float zmax\" -0.0009\n".to_owned()
        + "MakeNamedMaterial \"red\" \"string type\" \"diffuse\" NamedMaterial \"red\"\n"
        + &wall(9.0, 9.0, 2.0)
        + "ObjectBegin \"o\"\n"
        + &wall(-4.5, 4.5, 2.0)
        + "ObjectEnd ObjectInstance \"o\"\n";
    let layers = layers("pinhole", 4, 0, &world, &[Aov::Object, Aov::Material]);
    let row = |layer: &ImageLayer, name: &str| {
        let row = &channel(layer, name)[3 * SIZE..][..SIZE];
        [row[0], row[SIZE - 1]]
    };
    assert_eq!(row(&layers[0], "shape"), [2.0, 1.0]);
    assert_eq!(row(&layers[0], "instance"), [0.0, -1.0]);
    assert_eq!(row(&layers[1], "id"), [1.0, 1.0]);
    let nothing = self::layers("pinhole", 4, 0, "", &[Aov::Object, Aov::Material]);
    assert!(channel(&nothing[0], "shape").iter().all(|&id| id == -1.0));
    assert!(channel(&nothing[1], "id").iter().all(|&id| id == -1.0));
}

#[test]
fn the_circle_of_confusion_equals_the_blur_of_a_point() {
    // The picture of a small defocused ball of light on the axis is a disc. At f/7 it has its paraxial
    // size; wide open aberrations change it by 15 %.
    let pitch = 20e3 / 2f64.sqrt() / 400.0;
    for (focus, distance) in [(1.0, 3.0), (3.0, 1.0), (2.0, 0.6)] {
        let ball = format!(
            "AreaLightSource \"diffuse\" \"rgb L\" [1e6 1e6 1e6]
             Translate 0 0 {distance} Shape \"sphere\" \"float radius\" {}",
            2e-4 * distance
        );
        let text = format!(
            "Film \"rgb\" \"integer xresolution\" 400 \"integer yresolution\" 400
             \"integer pixelbounds\" [180 220 180 220] \"float diagonal\" 20
             PixelFilter \"box\" Sampler \"sobol\" \"integer pixelsamples\" 4096
             Integrator \"path\" \"integer maxdepth\" 0
             Camera \"realistic\" \"string lensfile\" \"{}\" \"float aperturediameter\" 5
             \"float focusdistance\" {focus}\nWorldBegin\n{ball}",
            root().join("lenses/dgauss.50mm.dat").display()
        );
        let folder = folder();
        let description = pbrt::read(&write(&folder, "scene.pbrt", text)).expect("a scene");
        let effects = EffectSelection::None;
        let layers = vec![Aov::Coc, Aov::Depth];
        let changes = Changes { layers, effects, ..Changes::default() };
        let (job, _, _) = prepare(description, &changes).expect("a job");
        let exposed = render(&job, RenderOptions { threads: 2, ..RenderOptions::default() })
            .expect("a picture");
        let coc = exposed.layers(&job);
        let picture = exposed.film.picture(4096);
        let lit: Vec<usize> =
            (0..picture.pixels.len()).filter(|&i| picture.pixels[i][0] > 0.0).collect();
        let (values, coverage) = (channel(&coc[0], "um"), channel(&coc[1], "coverage"));
        // Light paths light pixels whose camera rays miss the ball: those have the circle of infinity.
        let hit = lit.iter().filter(|&&i| coverage[i] > 0.0);
        let seen: Vec<f64> = hit.map(|&i| f64::from(values[i])).collect();
        let estimate = seen.iter().sum::<f64>() / seen.len() as f64;
        // The second moment of a uniform disc of diameter d is d^2 / 8, and that of a square pixel of
        // side p is p^2 / 6.
        let (mut sum, mut moments) = (0.0, [0.0; 3]);
        for i in lit {
            let value = f64::from(picture.pixels[i][0]);
            let [x, y] = [i % 40, i / 40].map(|p| p as f64 * pitch);
            sum += value;
            moments = [
                moments[0] + value * x,
                moments[1] + value * y,
                moments[2] + value * (x * x + y * y),
            ];
        }
        let [x, y, square] = moments.map(|moment| moment / sum);
        let measured = (8.0 * (square - x * x - y * y - pitch * pitch / 6.0)).sqrt();
        println!(
            "focus {focus} m, ball at {distance} m: {estimate:.1} um in the layer, {measured:.1} um measured"
        );
        assert!(
            (estimate / measured - 1.0).abs() < 0.04,
            "{estimate} um in the layer, {measured} um measured"
        );
    }
}

/// The sky is blurred by the circle of infinity: f^2 / (N (s - f)) for a thin lens.
#[test]
fn the_circle_of_confusion_of_the_sky_is_that_of_infinity() {
    let text = format!(
        "Film \"rgb\" \"integer xresolution\" 12 \"integer yresolution\" 8 \"float diagonal\" 4
         Camera \"realistic\" \"string lensfile\" \"{}\" \"float aperturediameter\" 5
         \"float focusdistance\" 2\nWorldBegin LightSource \"infinite\"",
        root().join("lenses/dgauss.50mm.dat").display()
    );
    let folder = folder();
    let description = pbrt::read(&write(&folder, "scene.pbrt", text)).expect("a scene");
    let effects = EffectSelection::None;
    let changes = Changes { layers: vec![Aov::Coc], effects, ..Changes::default() };
    let (job, _, _) = prepare(description, &changes).expect("a job");
    let exposed = render(&job, RenderOptions::default()).expect("a picture");
    let LensModel::Real(lens) = &job.camera.model else { panic!("a real lens") };
    let focal = lens.paraxial.focal_length;
    let expected = 1e3 * focal * lens.paraxial.entrance_pupil.diameter / (2000.0 - focal);
    for &um in channel(&exposed.layers(&job)[0], "um") {
        // The distance is measured from the film, not from the principal plane: a few percent.
        assert!((f64::from(um) / expected - 1.0).abs() < 0.08, "{um} um, not {expected}");
    }
}

#[test]
fn the_variance_layer_is_that_of_the_mean() {
    // Strips in front of a sky: a sample is 0 or not. The layer divides the variance of a sample by the
    // number of samples, so 16 times as many samples give a 16th.
    let strips: String = (0..60).map(|i| wall(-6.0 + 0.2 * f64::from(i), 0.05, 4.0)).collect();
    let world = "LightSource \"infinite\" Material \"diffuse\" \"rgb reflectance\" [0 0 0]\n"
        .to_owned()
        + &strips;
    let estimate = |samples| -> f64 {
        let layers = layers("3.9", samples, 1, &world, &[Aov::Variance]);
        channel(&layers[0], "G").iter().map(|&v| f64::from(v)).sum()
    };
    let (few, many) = (estimate(16), estimate(256));
    assert!((few / many / 16.0 - 1.0).abs() < 0.1, "{few} and {many}");
    // A sky alone has no variance through a pinhole.
    let empty = layers("pinhole", 16, 0, "LightSource \"infinite\"", &[Aov::Variance]);
    assert!(channel(&empty[0], "R").iter().all(|&v| v == 0.0));
}
