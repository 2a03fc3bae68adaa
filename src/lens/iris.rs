//! The shape of the opening of a stop.

use std::sync::Arc;

use crate::lanes::Real;

/// What the opening of a stop looks like, inside its clear diameter.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Iris {
    /// A circle: the clear diameter itself.
    #[default]
    Round,
    /// The opening that blades leave; its corners touch the clear diameter.
    Blades {
        /// How many, from 3.
        count: u32,
        /// Angle of the first corner from +x towards +y, degrees.
        rotation: f64,
        /// Curvature of the blades' edges in units of the round opening's: 0 straight, 1 a circle.
        curvature: f64,
    },
    /// Transmission over the square around the clear diameter.
    Mask(Mask),
}

/// A square grid of transmissions from 0 to 1 over the square around an opening.
#[derive(Clone, Debug, PartialEq)]
pub struct Mask {
    /// What it is: a name of pbrt's or of a file.
    pub name: String,
    /// Rows and columns.
    pub size: usize,
    /// Row by row, the first at the top (+y), seen from the film.
    pub transmission: Arc<[f32]>,
}

/// An iris of a given width, ready for a kernel; mm.
#[derive(Clone, Debug)]
pub struct Shape<T> {
    edges: Edges<T>,
    mask: Option<(Mask, f64)>,
}

/// The arcs that bound an opening: inside, `curvature h^2 + normal . p <= reach` for all.
#[derive(Clone, Debug)]
struct Edges<T> {
    normals: Vec<[T; 2]>,
    curvature: T,
    reach: T,
}

impl<T: Copy> Shape<T> {
    /// The opening of an iris of this clear diameter.
    pub fn new<R: Real<Scalar = T>>(iris: &Iris, diameter: f64) -> Self {
        let corner = diameter / 2.0;
        let open = Edges { normals: Vec::new(), curvature: R::scalar(0.0), reach: R::scalar(0.0) };
        match iris {
            Iris::Round => Self { edges: open, mask: None },
            Iris::Mask(mask) => Self { edges: open, mask: Some((mask.clone(), corner)) },
            &Iris::Blades { count, rotation, curvature } => {
                let half_angle = std::f64::consts::PI / f64::from(count);
                let bend = curvature / corner;
                // The arc bulges over its chord; a is where its middle is.
                let half_chord = corner * half_angle.sin();
                let chord = corner * half_angle.cos();
                let bulge = bend * half_chord * half_chord
                    / (1.0 + (1.0 - (bend * half_chord).powi(2)).max(0.0).sqrt());
                let a = chord + bulge;
                let normals = (0..count).map(|i| {
                    let angle = rotation.to_radians() + half_angle * f64::from(2 * i + 1);
                    let scale = 2.0 * (1.0 - bend * a);
                    [angle.cos(), angle.sin()].map(|n| R::scalar(n * scale))
                });
                let edges = Edges {
                    normals: normals.collect(),
                    curvature: R::scalar(bend),
                    reach: R::scalar(2.0 * a - bend * a * a),
                };
                Self { edges, mask: None }
            }
        }
    }

    /// Share of the light that passes at a point of the stop, mm from the axis.
    #[inline(always)]
    pub fn transmission<R: Real<Scalar = T>>(&self, x: R, y: R) -> R {
        if let Some((mask, corner)) = &self.mask {
            return x.zip(y, |x, y| R::scalar(mask.at(R::to_f64(x), R::to_f64(y), *corner)));
        }
        let (zero, one) = (R::constant(0.0), R::constant(1.0));
        let mut furthest = zero;
        for &[nx, ny] in &self.edges.normals {
            furthest = furthest.max(x.mul_add(R::splat(nx), y * R::splat(ny)));
        }
        let h2 = x.mul_add(x, y * y);
        let reached = R::splat(self.edges.curvature).mul_add(h2, furthest);
        R::select(reached.le(R::splat(self.edges.reach)), one, zero)
    }
}

impl Mask {
    /// The transmission at a point, for an opening of this half width; 0 beyond.
    fn at(&self, x: f64, y: f64, half: f64) -> f64 {
        let place = |v: f64| {
            let place = (v / half + 1.0) / 2.0 * self.size as f64;
            (place >= 0.0 && place < self.size as f64).then_some(place as usize)
        };
        match (place(x), place(-y)) {
            (Some(column), Some(row)) => f64::from(self.transmission[row * self.size + column]),
            _ => 0.0,
        }
    }
}
