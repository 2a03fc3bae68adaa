//! Small scenes with motion, and pictures of them.

use petzval_image::Picture;
use petzval_render::Backend;
use petzval_render::job::Job;
use petzval_render::prepare::{Changes, prepare};
use petzval_scene_formats::pbrt;

use crate::support::{folder, picture, write};

/// Width and height of the pictures, pixels. A pixel is 1/16 wide in the plane z = 1.
pub const SIZE: [usize; 2] = [64, 16];

/// Returns the text of a scene: a pinhole camera that looks along +z into a sky of radiance 1.
pub fn text(options: &str, camera: &str, samples: u32, world: &str) -> String {
    let [width, height] = SIZE;
    format!(
        "Film \"rgb\" \"integer xresolution\" {width} \"integer yresolution\" {height}\n\
         PixelFilter \"box\" Sampler \"zsobol\" \"integer pixelsamples\" {samples}\n\
         Integrator \"path\" \"integer maxdepth\" 3\n\
         {options}\n\
         Camera \"perspective\" \"float fov\" 53.13010235415598 {camera}\n\
         WorldBegin LightSource \"infinite\" \"rgb L\" [1 1 1]\n\
         {world}"
    )
}

/// Returns a black curtain in the plane z = 1 on the left of its edge, which moves along x between two
/// positions.
pub fn curtain(from: f64, to: f64) -> String {
    moving(
        [from, to],
        "Material \"diffuse\" \"rgb reflectance\" [0 0 0]\n\
         Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3]\n\
         \"point3 P\" [-99 -9 1  0 -9 1  0 9 1  -99 9 1]",
    )
}

/// Returns an object that moves along x between two positions.
pub fn moving([from, to]: [f64; 2], what: &str) -> String {
    format!(
        "AttributeBegin ActiveTransform StartTime Translate {from} 0 0\n\
         ActiveTransform EndTime Translate {to} 0 0 ActiveTransform All\n{what} AttributeEnd\n"
    )
}

pub fn job(text: &str, changes: &Changes) -> Job {
    let folder = folder();
    let description = pbrt::read(&write(&folder, "motion.pbrt", text)).expect("a scene");
    assert!(description.warnings.is_empty(), "{:#?}", description.warnings);
    prepare(description, changes).expect("a job").job
}

pub fn taken(job: &Job) -> Picture {
    picture(job, Backend::Simd, 1)
}

/// Returns the green channel of a row.
pub fn row(picture: &Picture, y: usize) -> Vec<f64> {
    let width = picture.size[0];
    picture.pixels[y * width..][..width].iter().map(|p| f64::from(p[1])).collect()
}

/// Returns the mean of all rows.
pub fn profile(picture: &Picture) -> Vec<f64> {
    let height = picture.size[1];
    let mut sum = vec![0.0; picture.size[0]];
    for y in 0..height {
        for (sum, value) in sum.iter_mut().zip(row(picture, y)) {
            *sum += value / height as f64;
        }
    }
    sum
}

/// Returns the position of an edge, pixels from the left; the left of it is dark.
pub fn edge(row: &[f64]) -> f64 {
    row.len() as f64 - row.iter().sum::<f64>()
}
