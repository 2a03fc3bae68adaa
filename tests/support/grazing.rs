//! Lenses with a hemisphere as the rear surface, and rays that graze it.

use petzval_lens::{Prescription, Row};

use super::oracle::{V, dot, unit};
use super::probe::lens_of_rows;
use super::{Random, row};

/// A lens whose rear surface is a hemisphere, convex or concave to the film. Its stop blocks no ray.
pub struct Hemisphere {
    /// Rows of the stop, the front surface and the hemisphere.
    pub lens: Prescription,
    /// 1 if the hemisphere is convex to the film, -1 if it is concave.
    bulge: f64,
    radius: f64,
    /// Semi-diameter divided by the radius.
    aperture: f64,
}

impl Hemisphere {
    pub fn random(random: &mut Random) -> Self {
        let bulge = if random.next() < 0.5 { 1.0 } else { -1.0 };
        let radius = 10f64.powf(random.between(-0.3, 2.0));
        let aperture = if random.next() < 0.5 { 1.0 } else { random.between(0.9, 1.0) };
        let thickness = radius * if bulge > 0.0 { random.between(1.0, 1.6) } else { 0.3 };
        let front = if random.next() < 0.5 { f64::INFINITY } else { 3.0 * radius };
        let stop = Row { stop: true, ..row(f64::INFINITY, 0.0, 1.0, 40.0 * radius) };
        let lens = lens_of_rows(vec![
            stop,
            row(front, thickness, random.between(1.4, 2.1), 2.6 * radius),
            row(-bulge * radius, 0.0, 1.0, 2.0 * aperture * radius),
        ]);
        Self { lens, bulge, radius, aperture }
    }

    pub fn is_concave(&self) -> bool {
        self.bulge < 0.0
    }

    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Returns a point of the hemisphere, relative to the rear vertex with z towards the scene, and the
    /// direction of a ray that meets it there at a cosine of incidence from 0.025 to 0.63.
    pub fn ray(&self, random: &mut Random) -> [V; 2] {
        loop {
            let (sine, phi) = (random.next().sqrt() * self.aperture, random.between(0.0, 6.3));
            let cosine = (1.0 - sine * sine).sqrt();
            let outwards = [sine * phi.cos(), sine * phi.sin(), -self.bulge * cosine];
            let z = self.bulge * self.radius * (1.0 - cosine);
            let point = [self.radius * outwards[0], self.radius * outwards[1], z];
            // The normal points against the ray.
            let normal = outwards.map(|v| self.bulge * v);
            let any = unit([0; 3].map(|_| random.between(-1.0, 1.0)));
            let across = dot(any, normal);
            let tangent = unit([0, 1, 2].map(|i| any[i] - across * normal[i]));
            let incidence = 10f64.powf(random.between(-1.6, -0.2));
            let along = (1.0 - incidence * incidence).sqrt();
            let towards = [0, 1, 2].map(|i| along * tangent[i] - incidence * normal[i]);
            if towards[2] > 0.05 {
                return [point, towards];
            }
        }
    }
}
