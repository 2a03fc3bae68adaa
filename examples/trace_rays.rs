//! Traces rays from the axis of the film through a lens and prints where they leave it.
//!
//!     cargo run --release --example trace_rays -- [LENS]
//!     cargo run --release --example trace_rays -- lenses/fisheye.10mm.dat
//!
//! The film stands where the lens is focused at infinity, so the rays that pass leave the lens
//! almost parallel to the axis. Their angles are the spherical aberration of the lens.

use std::error::Error;
use std::path::Path;

use petzval_lens::{LensRay, RealRayFocus, Side};

/// Rays from the axis to the rim of the rear element.
const RAYS: u32 = 12;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).unwrap_or_else(|| "lenses/dgauss.50mm.dat".to_owned());
    let lens = petzval_lens_formats::read(Path::new(&path))?;
    let film = RealRayFocus::new(&lens).film_distance(f64::INFINITY)?;
    println!("{path}: {} surfaces, film {film:.4} mm behind the rear vertex", lens.rows.len());
    println!("{:>12} {:>12} {:>12}", "rear y [mm]", "front y [mm]", "angle [mrad]");

    // Rays start in the plane of the film. Positions are relative to the vertex of the surface that
    // the ray crosses next or has crossed last; +z is the direction of travel, here to the scene.
    let surfaces = petzval_lens::sequence::<f64>(&lens, Side::Film(film));
    for i in 0..RAYS {
        let height = 0.5 * lens.rear().diameter * f64::from(i) / f64::from(RAYS);
        let length = height.hypot(film);
        // The length of a direction is the refractive index of the medium.
        let direction = [0.0, height, film].map(|v| v / length * lens.rear().index);
        match petzval_lens::trace_one(LensRay::new([0.0; 3], direction), &surfaces) {
            Ok(ray) => {
                // Back from the last surface to the plane of its vertex.
                let y = ray.p[1] - ray.p[2] * ray.t[1] / ray.t[2];
                println!("{height:>12.4} {y:>12.4} {:>12.4}", 1e3 * ray.t[1].atan2(ray.t[2]));
            }
            Err(end) => {
                println!("{height:>12.4} ends at surface {}: {:?}", end.row + 1, end.reason)
            }
        }
    }
    Ok(())
}
