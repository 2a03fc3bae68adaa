//! Naive participating media: collisions as they occur in one colour channel.

use std::f64::consts::PI;

use glam::DVec3;

use super::material::Colour;
use crate::support::Random;

/// A medium. Its coefficients are those at density 1.
#[derive(Clone, Debug)]
pub struct Matter {
    pub absorbs: Colour,
    pub scatters: Colour,
    pub emits: Colour,
    pub g: f64,
    /// Densities; 1 everywhere if there are none.
    pub voxels: Option<Cube>,
}

/// A cube of voxels.
#[derive(Clone, Debug)]
pub struct Cube {
    /// Densities by z, y and x.
    pub voxels: Vec<Vec<Vec<f64>>>,
    /// Lowest corner.
    pub corner: DVec3,
    pub side: f64,
}

impl Matter {
    /// A medium that is the same everywhere and emits nothing.
    pub fn uniform(absorbs: Colour, scatters: Colour, g: f64) -> Self {
        Self { absorbs, scatters, emits: [0.0; 3], g, voxels: None }
    }

    fn extinction(&self, channel: usize) -> f64 {
        self.absorbs[channel] + self.scatters[channel]
    }

    /// Returns whether light of all channels collides at the same points.
    pub fn is_grey(&self) -> bool {
        (0..3).all(|channel| (self.extinction(channel) - self.extinction(0)).abs() < 1e-12)
    }

    /// Returns the shares of light that a collision absorbs and scatters.
    pub fn shares(&self) -> [Colour; 2] {
        let of = |part: &Colour| [0, 1, 2].map(|c| part[c] / self.extinction(c));
        [of(&self.absorbs), of(&self.scatters)]
    }

    /// Returns the density at a point, between the centres of voxels; outside there is nothing.
    pub fn density(&self, at: DVec3) -> f64 {
        let Some(Cube { voxels, corner, side }) = &self.voxels else { return 1.0 };
        let n = voxels.len() as i32;
        let unit = (at - *corner) / *side;
        if unit.min_element() < 0.0 || unit.max_element() > 1.0 {
            return 0.0;
        }
        let place = unit * f64::from(n) - 0.5;
        let low = place.floor();
        let mut sum = 0.0;
        for corner in 0..8 {
            let offset = DVec3::new(
                f64::from(corner & 1),
                f64::from(corner >> 1 & 1),
                f64::from(corner >> 2),
            );
            let voxel = low + offset;
            let weight = DVec3::ONE - (place - voxel).abs();
            let [x, y, z] = voxel.to_array().map(|v| v as i32);
            if [x, y, z].iter().all(|v| (0..n).contains(v)) {
                let value = voxels[z as usize][y as usize][x as usize];
                sum += value * weight.x * weight.y * weight.z;
            }
        }
        sum
    }

    /// Returns the largest density.
    fn largest(&self) -> f64 {
        let Some(Cube { voxels, .. }) = &self.voxels else { return 1.0 };
        voxels.iter().flatten().flatten().copied().fold(0.0, f64::max)
    }

    /// Returns the distance of the first collision before `end`.
    pub fn collide(
        &self,
        from: DVec3,
        along: DVec3,
        end: f64,
        channel: usize,
        random: &mut Random,
    ) -> Option<f64> {
        let (extinction, largest) = (self.extinction(channel), self.largest());
        let mut t = 0.0;
        loop {
            t += -(1.0 - random.next()).ln() / (extinction * largest);
            if t.is_nan() || t >= end || t > 1e3 {
                return None;
            }
            if random.next() * largest < self.density(from + along * t) {
                return Some(t);
            }
        }
    }

    /// Returns the phase function of Henyey & Greenstein for the cosine between the directions of
    /// travel before and after scattering.
    pub fn phase(&self, cos: f64) -> f64 {
        let g = self.g;
        (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * cos).powf(1.5))
    }

    /// Returns the directives that make it, under a name.
    pub fn text(&self, name: usize) -> String {
        let list = |numbers: &[f64]| format!("{numbers:?}").replace(',', " ");
        let (absorbs, scatters) = (list(&self.absorbs), list(&self.scatters));
        let shared =
            format!(r#""rgb sigma_a" {absorbs} "rgb sigma_s" {scatters} "float g" {}"#, self.g);
        let emits = match self.emits {
            [0.0, 0.0, 0.0] => String::new(),
            emits => format!(r#""rgb Le" {}"#, list(&emits)),
        };
        let Some(Cube { voxels, corner, side }) = &self.voxels else {
            return format!(
                "MakeNamedMedium \"{name}\" \"string type\" \"homogeneous\" {shared} {emits}\n"
            );
        };
        let n = voxels.len();
        let values: Vec<f64> = voxels.iter().flatten().flatten().copied().collect();
        let values = list(&values);
        let [x, y, z] = corner.to_array();
        let corner = format!("Translate {x} {y} {z} Scale {side} {side} {side}");
        format!(
            "TransformBegin {corner}\nMakeNamedMedium \"{name}\" \"string type\" \"uniformgrid\"
             \"integer nx\" {n} \"integer ny\" {n} \"integer nz\" {n} \"float density\" {values}
             {shared} {emits}\nTransformEnd\n"
        )
    }
}
