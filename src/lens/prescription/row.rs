//! One row of a lens table: a surface and the medium behind it.

use super::coating::Coating;
use super::iris::Iris;
use super::pose::Pose;
use crate::lens::analysis::paraxial::RayTransferMatrix;
use crate::spectrum::glass::Glass;

/// An axis across the optical axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TransverseAxis {
    /// To the right as seen from behind the camera.
    X,
    /// Up.
    Y,
}

/// One row of a lens table: a surface and the medium behind it.
///
/// The surface has the sag z = c h^2 / (1 + sqrt(1 - (1 + k) c^2 h^2)) + sum of a_p h^p, with h the
/// distance from the axis, c the curvature, k the conic constant and z towards the film.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Radius of curvature at the vertex (mm), positive if the centre lies on the film side;
    /// infinite for a plane.
    pub radius: f64,
    /// Conic constant k: 0 for a sphere, -1 for a paraboloid.
    pub conic: f64,
    /// Powers p from 2 to 20, each at most once, and their coefficients a_p [mm^(1 - p)].
    pub asphere: Vec<(u32, f64)>,
    /// Axis along which a cylinder is straight; none for a surface of revolution.
    pub axis: Option<TransverseAxis>,
    /// Distance to the next vertex (mm); unused in the last row.
    pub thickness: f64,
    /// Refractive index of the medium on the film side of the surface, at the d line.
    pub index: f64,
    /// Dispersion of that medium.
    pub glass: Glass,
    /// Clear diameter (mm).
    pub diameter: f64,
    /// Diameter of an opaque disk around the axis (mm); 0 for none.
    pub obstruction: f64,
    /// Whether this is the aperture stop.
    pub stop: bool,
    /// Shape of the opening, inside the clear diameter.
    pub iris: Iris,
    /// Coating, if the file states one; otherwise the surface is bare.
    pub coating: Option<Coating>,
    /// Tilt and decentre of this surface alone.
    pub pose: Pose,
    /// Ray-transfer matrices along x and y of an ideal lens that replaces the surface, for light on
    /// its way to the film, from the plane of the vertex to itself. The shape is then ignored.
    pub ideal: Option<[RayTransferMatrix; 2]>,
}

impl Default for Row {
    /// Returns a plane of diameter 0 in air.
    fn default() -> Self {
        Self {
            radius: f64::INFINITY,
            conic: 0.0,
            asphere: Vec::new(),
            axis: None,
            thickness: 0.0,
            index: 1.0,
            glass: Glass::Constant,
            diameter: 0.0,
            obstruction: 0.0,
            stop: false,
            iris: Iris::Round,
            coating: None,
            pose: Pose::ALIGNED,
            ideal: None,
        }
    }
}

impl Row {
    /// Returns the curvature at the vertex (1/mm); 0 for a plane.
    pub fn curvature(&self) -> f64 {
        self.radius.recip()
    }

    /// Returns the curvatures at the vertex along x and y (1/mm), with the contribution of the
    /// square term of an asphere.
    pub fn curvatures(&self) -> [f64; 2] {
        let square: f64 = self.asphere.iter().filter(|(p, _)| *p == 2).map(|(_, a)| 2.0 * a).sum();
        let c = self.curvature() + square;
        match self.axis {
            None => [c, c],
            Some(TransverseAxis::X) => [0.0, c],
            Some(TransverseAxis::Y) => [c, 0.0],
        }
    }

    /// Returns whether the surface is rotationally symmetric.
    pub fn is_round(&self) -> bool {
        let even = self.ideal.is_none_or(|[x, y]| x == y);
        self.axis.is_none() && self.iris == Iris::Round && even
    }

    /// Returns the sag (mm) at a height `h` (mm); for a cylinder the height along its curved
    /// direction. Beyond the edge of a conic the sag is that of its edge.
    pub fn sag(&self, h: f64) -> f64 {
        let c = self.curvature();
        let root = (1.0 - (1.0 + self.conic) * c * c * h * h).max(0.0).sqrt();
        let terms: f64 = self.asphere.iter().map(|&(p, a)| a * h.powi(p as i32)).sum();
        c * h * h / (1.0 + root) + terms
    }

    /// Returns the derivative of the sag at height `h`; infinite at the edge of a conic and beyond.
    pub fn slope(&self, h: f64) -> f64 {
        let c = self.curvature();
        let root = (1.0 - (1.0 + self.conic) * c * c * h * h).max(0.0).sqrt();
        let term = |&(p, a): &(u32, f64)| f64::from(p) * a * h.powi(p as i32 - 1);
        c * h / root + self.asphere.iter().map(term).sum::<f64>()
    }

    /// Returns the sag (mm) at a point (mm).
    pub fn sag_at(&self, x: f64, y: f64) -> f64 {
        match self.axis {
            None => self.sag(x.hypot(y)),
            Some(TransverseAxis::X) => self.sag(y),
            Some(TransverseAxis::Y) => self.sag(x),
        }
    }

    /// Returns the derivatives of [`Self::sag_at`] with respect to x and y.
    pub fn gradient(&self, x: f64, y: f64) -> [f64; 2] {
        let h = x.hypot(y);
        match self.axis {
            None if h > 0.0 => [x, y].map(|v| self.slope(h) * v / h),
            None => [0.0; 2],
            Some(TransverseAxis::X) => [0.0, self.slope(y)],
            Some(TransverseAxis::Y) => [self.slope(x), 0.0],
        }
    }
}
