//! Layers of a picture: their values, which vignetting does not bias.

use crate::support::{folder, root, write};
use petzval_image::{ImageLayer, Picture, Raster};
use petzval_lens::LensModel;
use petzval_render::aov::Aov;
use petzval_render::aov::CircleOfConfusion;
use petzval_render::job::Job;
use petzval_render::plan::EffectSelection;
use petzval_render::prepare::{Changes, prepare};
use petzval_render::{RenderOptions, render};
use petzval_scene_formats::pbrt;

const SIZE: usize = 48;

/// Renders a scene given as text. Returns its layers, its picture and its job.
fn layered(text: &str, wanted: &[Aov]) -> (Vec<ImageLayer>, Picture, Job) {
    let folder = folder();
    let description = pbrt::read(&write(&folder, "scene.pbrt", text)).expect("a scene of a test");
    let changes = Changes { layers: wanted.to_vec(), ..Changes::default() };
    let job = prepare(description, &changes).expect("a job").job;
    let exposed =
        render(&job, RenderOptions { threads: 1, ..RenderOptions::default() }).expect("a picture");
    (exposed.layers(&job), exposed.film.picture(job.samples.end), job)
}

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
    let job = prepare(description, &changes).expect("a job").job;
    let exposed =
        render(&job, RenderOptions { threads: 1, ..RenderOptions::default() }).expect("a picture");
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
        let job = prepare(description, &changes).expect("a job").job;
        let exposed = render(&job, RenderOptions { threads: 1, ..RenderOptions::default() })
            .expect("a picture");
        let coc = exposed.layers(&job);
        let picture = exposed.film.picture(4096);
        let lit: Vec<usize> =
            (0..picture.pixels.len()).filter(|&i| picture.pixels[i][0] > 0.0).collect();
        let (values, coverage) = (channel(&coc[0], "um"), channel(&coc[1], "coverage"));
        // Paths that miss the ball have the circle of infinity.
        let confusion = CircleOfConfusion::new(&job.camera).expect("a lens");
        let sky = confusion.diameter(f64::INFINITY, [0.0; 2]);
        let (mut circles, mut seen) = (0.0, 0.0);
        for &i in &lit {
            let [value, share] = [values[i], coverage[i]].map(f64::from);
            circles += value - (1.0 - share) * sky;
            seen += share;
        }
        let estimate = circles / seen;
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
    let job = prepare(description, &changes).expect("a job").job;
    let exposed = render(&job, RenderOptions::default()).expect("a picture");
    let LensModel::Real(lens) = &job.camera.model else { panic!("a real lens") };
    let focal = lens.paraxial.focal_length;
    let expected = 1e3 * focal * lens.paraxial.entrance_pupil.diameter / (2000.0 - focal);
    for &um in channel(&exposed.layers(&job)[0], "um") {
        // The distance is measured from the film, not from the principal plane: a few percent.
        assert!((f64::from(um) / expected - 1.0).abs() < 0.08, "{um} um, not {expected}");
    }
}

/// Returns a scene of one pixel, focused at 2 m through the lens, with this world.
fn one_pixel(world: &str) -> String {
    format!(
        "Film \"rgb\" \"integer xresolution\" 1 \"integer yresolution\" 1 \"float diagonal\" 4
         PixelFilter \"box\" Sampler \"sobol\" \"integer pixelsamples\" 4096
         Integrator \"volpath\" \"integer maxdepth\" 1
         Camera \"realistic\" \"string lensfile\" \"{}\" \"float aperturediameter\" 5
         \"float focusdistance\" 2\nWorldBegin LightSource \"infinite\"\n{world}",
        root().join("lenses/dgauss.50mm.dat").display()
    )
}

#[test]
fn the_circle_of_confusion_of_a_mixed_pixel_is_the_mean_of_its_paths() {
    let circle = |world: &str| {
        let (layers, _, _) = layered(&one_pixel(world), &[Aov::Coc, Aov::Depth]);
        (channel(&layers[0], "um")[0], channel(&layers[1], "coverage")[0])
    };
    let (sky, none) = circle("");
    let (near, all) = circle(&wall(0.0, 9.0, 1.0));
    let (mixed, half) = circle(&wall(9.0, 9.0, 1.0));
    assert_eq!([none, all], [0.0, 1.0]);
    assert!((half - 0.5).abs() < 0.02 && (sky / near - 1.0).abs() > 0.05, "{half} {sky} {near}");
    let expected = half * near + (1.0 - half) * sky;
    assert!((mixed / expected - 1.0).abs() < 1e-3, "{mixed} um, not {expected} um");
}

#[test]
fn the_circle_of_confusion_of_fog_is_that_of_where_it_scatters() {
    // A ball of fog from 3 m to 9 m, of an optical depth of 12 through its centre.
    let world = "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\"
        \"rgb sigma_s\" [2 2 2] \"rgb sigma_a\" [0 0 0]
        Translate 0 0 6 MediumInterface \"fog\" \"\" Material \"interface\"
        Shape \"sphere\" \"float radius\" 3";
    let (layers, _, job) = layered(&one_pixel(world), &[Aov::Coc]);
    let um = f64::from(channel(&layers[0], "um")[0]);
    let confusion = CircleOfConfusion::new(&job.camera).expect("a lens");
    let [near, far, sky] =
        [3.0, 5.0, f64::INFINITY].map(|depth| confusion.diameter(depth, [0.0; 2]));
    assert!(near < um && um < far, "{um} um, not between {near} and {far} ({sky} for the sky)");
}

const DISC: &str = "LightSource \"infinite\" \"rgb L\" [0.5 0.7 0.9]
    Material \"diffuse\" \"rgb reflectance\" [0.6 0.4 0.2]
    AttributeBegin Translate 0 0 2 Shape \"disk\" \"float radius\" 0.5 AttributeEnd\n";

/// Returns a scene through a pinhole with this world. The film sees 40 degrees of the height.
fn through_pinhole(samples: u32, world: &str) -> String {
    format!(
        "Film \"rgb\" \"integer xresolution\" {SIZE} \"integer yresolution\" {SIZE}
         PixelFilter \"box\" Sampler \"sobol\" \"integer pixelsamples\" {samples}
         Integrator \"volpath\" \"integer maxdepth\" 3
         Camera \"perspective\" \"float fov\" 40\nWorldBegin\n{world}"
    )
}

#[test]
fn the_mean_opacity_is_the_area_of_a_disc() {
    let (layers, picture, _) = layered(&through_pinhole(64, DISC), &[Aov::Alpha]);
    let alpha = channel(&layers[0], "A");
    let side = 2.0 * 2.0 * 20f64.to_radians().tan();
    let expected = std::f64::consts::PI * 0.25 / (side * side);
    let mean = alpha.iter().map(|&a| f64::from(a)).sum::<f64>() / alpha.len() as f64;
    assert!((mean / expected - 1.0).abs() < 2e-3, "{mean}, not {expected}");
    assert_eq!([alpha[0], alpha[SIZE * SIZE / 2 + SIZE / 2]], [0.0, 1.0]);
    let edges = alpha.iter().filter(|&&a| a > 0.0 && a < 1.0).count();
    assert!(edges > SIZE && edges < 4 * SIZE, "{edges} pixels at the edge");
    // The sky lights the disc, and is not seen beside it.
    assert_eq!(picture.pixels[0], [0.0; 3]);
    assert!(picture.pixels[SIZE * SIZE / 2 + SIZE / 2].iter().all(|&v| v > 0.1));
}

#[test]
fn a_picture_over_its_own_sky_is_the_picture_without_an_opacity() {
    let fog = "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" \"rgb sigma_s\" [1 1 1]
        \"rgb sigma_a\" [0.5 0.5 0.5] Translate 0.3 0 2 MediumInterface \"fog\" \"\"
        Material \"interface\" Shape \"sphere\" \"float radius\" 0.6";
    let scene = through_pinhole(16, &format!("{DISC}{fog}"));
    let (layers, premultiplied, _) = layered(&scene, &[Aov::Alpha]);
    let (_, whole, _) = layered(&scene, &[]);
    let alpha = channel(&layers[0], "A");
    let thin = alpha.iter().filter(|&&a| a > 0.2 && a < 0.9).count();
    assert!(thin > SIZE, "{thin} pixels of fog alone");
    for (i, &alpha) in alpha.iter().enumerate() {
        for (c, sky) in [0.5, 0.7, 0.9].into_iter().enumerate() {
            let over = premultiplied.pixels[i][c] + (1.0 - alpha) * sky;
            let expected = whole.pixels[i][c];
            assert!((over - expected).abs() < 2e-3, "pixel {i}: {over}, not {expected}");
        }
    }
}

#[test]
fn the_opacity_is_premultiplied_in_exr_and_straight_in_png() {
    let opacity = vec![("A".to_owned(), vec![1.0, 0.5, 0.0])];
    let layer = ImageLayer::new(petzval_image::ALPHA_LAYER, opacity);
    let picture = Picture { size: [3, 1], pixels: vec![[0.5; 3], [0.25; 3], [0.1; 3]] };
    let folder = folder();
    let write = |name: &str| {
        let path = folder.path().join(name);
        let window = petzval_image::PictureWindow { origin: [0; 2], frame: [3, 1] };
        let to = petzval_base::io::Outputs::without_inputs().claim(&path).expect("an output");
        let layers = std::slice::from_ref(&layer);
        let written =
            picture.write_with_layers(layers, &to, window, Default::default(), &Vec::new());
        written.map(|()| path).map_err(|error| error.to_string())
    };
    let read = |name: &str| {
        let path = write(name).expect("a file");
        let context = petzval_base::io::ReadContext::default();
        Raster::read(&path, Default::default(), &context).expect("a raster")
    };
    let exr = read("a.exr");
    let petzval_image::ImageSamples::Floats(floats) = exr.samples else { panic!("floats") };
    assert_eq!(exr.channels, 4);
    assert_eq!(floats, [0.5, 0.5, 0.5, 1.0, 0.25, 0.25, 0.25, 0.5, 0.1, 0.1, 0.1, 0.0]);
    let path = write("a.png").expect("a file");
    let file = std::io::BufReader::new(std::fs::File::open(&path).expect("the file"));
    let mut reader = png::Decoder::new(file).read_info().expect("a PNG");
    let mut codes = vec![0; 12];
    reader.next_frame(&mut codes).expect("pixels");
    assert_eq!(codes, [188, 188, 188, 255, 188, 188, 188, 128, 0, 0, 0, 0]);
    let refused = write("a.jpg").expect_err("no opacity in JPEG");
    assert!(refused.contains("PNG and TIFF the layer alpha"), "{refused}");
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

#[test]
fn mattes_name_what_a_pixel_sees_with_its_share() {
    // A copy of an object out of focus covers the left, a wall behind it the right.
    let world = "MakeNamedMaterial \"red\" \"string type\" \"diffuse\" NamedMaterial \"red\"\n"
        .to_owned()
        + "ObjectBegin \"board\"\n"
        + &wall(-0.3, 0.3, 1.0)
        + "ObjectEnd ObjectInstance \"board\"\nMaterial \"diffuse\"\n"
        + &wall(8.9, 9.0, 3.0);
    let layers = layers("3", 256, 0, &world, &[Aov::Cryptomatte, Aov::Depth]);
    let depth = layers.last().expect("the layer of depths");
    let names: Vec<&str> = layers.iter().map(|layer| layer.name.as_str()).collect();
    assert_eq!(names[0], "CryptoObject00");
    assert_eq!(names.len(), 10, "{names:?}");
    let text = |layer: &ImageLayer, end: &str| {
        let note = layer.notes.iter().find(|(name, _)| name.ends_with(end)).expect("an attribute");
        note.1.to_string()
    };
    for (first, expected) in [
        (0, &["board#0/shape 0", "shape 1"][..]),
        (3, &["material 2", "red"]),
        (6, &["board", "shape 1"]),
    ] {
        let [one, more @ ..] = &layers[first..first + 3] else { unreachable!() };
        assert_eq!(format!("{}00", text(one, "/name")), one.name);
        let manifest: serde_json::Value =
            serde_json::from_str(&text(one, "/manifest")).expect("a manifest");
        let manifest = manifest.as_object().expect("names");
        let found: Vec<&str> = manifest.keys().map(String::as_str).collect();
        assert_eq!(found, expected);
        let mut blurred = 0;
        for pixel in 0..SIZE * SIZE {
            let [a, b] = ["R", "B"].map(|name| channel(one, name)[pixel].to_bits());
            let [p, q] = ["G", "A"].map(|name| channel(one, name)[pixel]);
            assert!(p >= q && (a != b || a == 0), "{p} {q}");
            blurred += u32::from(q > 0.01);
            let covered = channel(depth, "coverage")[pixel];
            assert!((p + q - covered).abs() < 1e-5, "{p} + {q}, not {covered}");
            let known = |id: u32| manifest.values().any(|known| known == &format!("{id:08x}"));
            assert!((p == 0.0 || known(a)) && (q == 0.0 || known(b)), "{a:08x} {b:08x}");
        }
        assert!(blurred > 50, "{}: {blurred} pixels see both", one.name);
        let channels = more.iter().flat_map(|layer| &layer.channels);
        assert!(channels.into_iter().all(|(_, values)| values.iter().all(|&v| v == 0.0)));
    }
}
