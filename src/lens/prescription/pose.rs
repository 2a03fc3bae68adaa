//! Tilt and decentre of surfaces, groups and film.
//!
//! Lens space is right-handed: x to the right and y up as seen from behind the camera, z towards
//! the film. First-order optics, focus and f-number are always those of the centred lens.

use std::fmt;

use glam::{DAffine3, DMat3, DVec3};

use super::Prescription;

/// Tilt about the vertex and decentre of a part.
///
/// Rotations are right-handed, about x first and then about the tilted y (order 0 of Zemax,
/// "decenter, then tilt"). A point p of the aligned part, relative to its vertex, comes to
/// `decentre + Rx(tilt[0]) Ry(tilt[1]) p`. A positive first angle moves the top towards the film, a
/// positive second one the right edge towards the scene.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// Decentre of the vertex along x and y (mm).
    pub decentre: [f64; 2],
    /// Tilt about x and about the tilted y (degrees).
    pub tilt: [f64; 2],
}

/// Largest tilt that input may state (degrees).
pub const MAX_TILT: f64 = 45.0;

/// Largest decentre or shift that input may state (mm).
pub const MAX_DECENTRE: f64 = 1000.0;

impl Pose {
    /// Neither tilted nor decentred.
    pub const ALIGNED: Self = Self { decentre: [0.0; 2], tilt: [0.0; 2] };

    /// Returns the pose of a film by its shift (mm) and tilt (degrees). The shift is stated in the
    /// upright picture: a shift to the right and up shows more of the scene there. The image on the
    /// film is upside down, so the film moves the other way.
    pub fn of_film(shift: [f64; 2], tilt: [f64; 2]) -> Self {
        Self { decentre: shift.map(|mm| 0.0 - mm), tilt }
    }

    /// Returns the shift of a film in this pose, in the upright picture (mm).
    pub fn film_shift(&self) -> [f64; 2] {
        self.decentre.map(|mm| 0.0 - mm)
    }

    /// Returns whether the part is neither tilted nor decentred.
    pub fn is_aligned(&self) -> bool {
        *self == Self::ALIGNED
    }

    /// Returns whether the part is not tilted; it may be decentred.
    pub fn is_untilted(&self) -> bool {
        self.tilt == [0.0; 2]
    }

    /// Returns the transform of points of the aligned part, relative to its vertex (mm).
    pub fn transform(&self) -> DAffine3 {
        let [x, y] = self.tilt.map(f64::to_radians);
        let rotation = DMat3::from_rotation_x(x) * DMat3::from_rotation_y(y);
        let [x, y] = self.decentre;
        DAffine3::from_mat3_translation(rotation, DVec3::new(x, y, 0.0))
    }

    /// Converts film coordinates (mm) of a film in this pose to x, y and z (mm), z towards the
    /// scene, relative to the point where the plane of the aligned film meets the axis.
    pub fn film_point(&self, [x, y]: [f64; 2]) -> [f64; 3] {
        let point = self.transform().transform_point3(DVec3::new(x, y, 0.0));
        [point.x, point.y, -point.z]
    }

    /// Returns the unit normal of a film in this pose, towards the scene, in the frame of
    /// [`Self::film_point`].
    pub fn film_normal(&self) -> [f64; 3] {
        let back = self.transform().matrix3.z_axis;
        [-back.x, -back.y, back.z]
    }
}

impl fmt::Display for Pose {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { decentre: [x, y], tilt: [ax, ay] } = self;
        write!(f, "decentred by {x}, {y} mm, tilted by {ax}, {ay} degrees")
    }
}

/// Place and size of the film behind a lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilmPlane {
    /// Distance from the rear vertex to the centre of the film along the axis (mm).
    pub distance: f64,
    /// Tilt about its centre, and decentre.
    pub pose: Pose,
    /// Half the diagonal of the exposed area (mm).
    pub radius: f64,
    /// Half the width and half the height of that area (mm).
    pub half: [f64; 2],
}

impl FilmPlane {
    /// Returns an aligned film of unknown shape inside a circle of this radius (mm).
    pub fn aligned(distance: f64, radius: f64) -> Self {
        Self { distance, pose: Pose::ALIGNED, radius, half: [radius; 2] }
    }
}

/// Tilt and decentre of consecutive surfaces as one rigid body, about the aligned vertex of the
/// first: an element, a group or the whole lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TiltDecenter {
    /// First and last row, from 0 at the scene side.
    pub rows: [usize; 2],
    /// Tilt and decentre of the body.
    pub pose: Pose,
}

impl TiltDecenter {
    fn contains(&self, row: usize) -> bool {
        (self.rows[0]..=self.rows[1]).contains(&row)
    }
}

/// End of the way through a lens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outside {
    /// Before the first row.
    Scene,
    /// Behind the last row.
    Film,
}

/// Change of the axis before a row: a fold, or a lens that goes on tilted or decentred.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoordinateBreak {
    /// First row that follows the new axis; the number of rows for a break before the film.
    pub row: usize,
    /// Position and directions of the new axes in the old ones (mm), both with their origin where
    /// the vertex of that row is without the break.
    pub transform: DAffine3,
}

impl CoordinateBreak {
    /// Returns the tilt of the new axis about x and about the tilted y (degrees), as in [`Pose`].
    pub fn tilt(&self) -> [f64; 2] {
        let axis = self.transform.matrix3.z_axis;
        [(-axis.y).atan2(axis.z), axis.x.clamp(-1.0, 1.0).asin()]
            .map(|angle| 0.0 + angle.to_degrees())
    }
}

impl Prescription {
    /// Returns whether any surface or group is tilted or decentred, or any axis broken.
    pub fn is_misaligned(&self) -> bool {
        if !self.breaks.is_empty() {
            return true;
        }
        let bodies = self.tilt_decenters.iter().any(|body| !body.pose.is_aligned());
        bodies || self.rows.iter().any(|row| !row.pose.is_aligned())
    }

    /// Returns the centred lens.
    pub fn centred(&self) -> Self {
        let mut lens = self.clone();
        lens.centre();
        lens
    }

    /// Removes all tilts and decentres.
    pub fn centre(&mut self) {
        self.tilt_decenters.clear();
        self.breaks.clear();
        self.rows.iter_mut().for_each(|row| row.pose = Pose::ALIGNED);
    }

    /// Returns how far the rear surface extends behind the rear vertex of the centred lens (mm).
    pub fn rear_reach(&self) -> f64 {
        let (rear, last) = (self.rear(), self.rows.len() - 1);
        let half = rear.diameter / 2.0;
        let opening = rear.opening_ellipse();
        if !self.is_misaligned() && opening.is_none() {
            let travel = self.travel_before(self.rows.len());
            let [along_x, along_y] = [rear.sag_at(half, 0.0), rear.sag_at(0.0, half)];
            return (travel * along_x).max(travel * along_y).max(0.0);
        }
        let placed = self.film_axis().inverse() * self.surface_transforms()[last];
        let travel = self.travel_before(self.rows.len());
        let behind = |point: [f64; 3]| travel * placed.transform_point3(point.into()).z;
        let rim = (0..64).map(|step| {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(step) / 64.0).sin_cos();
            let [centre, half] = opening.unwrap_or([[0.0; 2], [half; 2]]);
            let [x, y] = [centre[0] + half[0] * cos, centre[1] + half[1] * sin];
            behind([x, y, rear.sag_at(x, y)])
        });
        let [x, y] = opening.map_or([0.0; 2], |[centre, _]| centre);
        rim.fold(behind([x, y, rear.sag_at(x, y)]), f64::max)
    }

    /// Returns the distances of the vertices of the centred lens from the front vertex (mm).
    pub fn vertex_positions(&self) -> Vec<f64> {
        let vertex = |next: &mut f64, thickness: f64| {
            let here = *next;
            *next += thickness;
            Some(here)
        };
        self.rows.iter().map(|row| row.thickness).scan(0.0, vertex).collect()
    }

    /// Returns for each row the transform from the frame of its surface (origin at the vertex, z
    /// along the axis) to the frame of the front vertex of the centred lens (mm).
    ///
    /// The pose of the surface applies first, then those of the bodies that contain it, in the
    /// order of [`Prescription::tilt_decenters`].
    pub fn surface_transforms(&self) -> Vec<DAffine3> {
        let vertices = self.vertex_positions();
        let at = |row: usize| DAffine3::from_translation(DVec3::new(0.0, 0.0, vertices[row]));
        let placed = |row: usize| {
            let own = at(row) * self.rows[row].pose.transform();
            let bodies = self.tilt_decenters.iter().filter(|body| body.contains(row));
            let placed = bodies.fold(own, |placed, body| {
                let pivot = at(body.rows[0]);
                pivot * body.pose.transform() * pivot.inverse() * placed
            });
            self.broken_axis(row, &vertices) * placed
        };
        (0..self.rows.len()).map(placed).collect()
    }

    /// Returns the effect of all breaks up to a row on a point of the unbroken lens.
    fn broken_axis(&self, row: usize, vertices: &[f64]) -> DAffine3 {
        let along = |z: f64| DAffine3::from_translation(DVec3::new(0.0, 0.0, z));
        self.breaks.iter().filter(|axis| axis.row <= row).fold(DAffine3::IDENTITY, |all, axis| {
            let vertex = vertices
                .get(axis.row)
                .copied()
                .unwrap_or_else(|| self.film_position(self.design.film_distance.unwrap_or(0.0)));
            all * along(vertex) * axis.transform * along(-vertex)
        })
    }

    /// Returns the transform from the axis on which the film stands (origin where the rear vertex
    /// is in the unbroken lens) to the frame of the front vertex (mm).
    pub fn film_axis(&self) -> DAffine3 {
        let rear = DAffine3::from_translation(DVec3::new(0.0, 0.0, self.length()));
        self.broken_axis(self.rows.len(), &self.vertex_positions()) * rear
    }

    /// Returns whether two rows have the same relative position as in the centred lens. `None`
    /// stands for the place outside.
    pub(crate) fn aligned(
        &self,
        one: Option<usize>,
        other: Option<usize>,
        outside: Outside,
    ) -> bool {
        let place = |row: Option<usize>| match (row, outside) {
            (Some(row), _) => row + 1,
            (None, Outside::Scene) => 0,
            (None, Outside::Film) => self.rows.len() + 1,
        };
        let (low, high) = (place(one).min(place(other)), place(one).max(place(other)));
        if self.breaks.iter().any(|axis| (low + 1..=high).contains(&(axis.row + 1))) {
            return false;
        }
        let level = |row: Option<usize>| row.is_none_or(|row| self.rows[row].pose.is_aligned());
        let contains =
            |body: &TiltDecenter, row: Option<usize>| row.is_some_and(|row| body.contains(row));
        let separates = |body: &TiltDecenter| {
            !body.pose.is_aligned() && contains(body, one) != contains(body, other)
        };
        level(one) && level(other) && !self.tilt_decenters.iter().any(separates)
    }
}
