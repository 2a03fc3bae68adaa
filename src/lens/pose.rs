//! Parts that do not stand square on the axis: elements as they were built, film as a view camera
//! holds it.
//!
//! Lens space has x to the right and y up as seen from behind the camera, and z towards the film:
//! right-handed. First-order optics, focus and f-number are always those of the lens with all its
//! parts square.

use std::fmt;

use glam::{DAffine3, DMat3, DVec3};

use super::prescription::Prescription;

/// How a part stands off its place: it is turned about its vertex, and moved across the axis.
///
/// The turn is right-handed, about x first and then about the part's own y (Zemax calls that order
/// 0, "decenter, then tilt"). A point p of the square part comes to
/// `decentre + Rx(tilt[0]) Ry(tilt[1]) p`, relative to the vertex: a positive first angle takes the
/// top towards the film, a positive second one the right edge towards the scene.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// Of the vertex along x and y, mm.
    pub decentre: [f64; 2],
    /// About x and about the part's own y, degrees.
    pub tilt: [f64; 2],
}

/// The greatest tilt of anything, degrees.
pub const MOST_TILT: f64 = 45.0;

/// The farthest that anything is decentred or shifted, mm.
pub const MOST_DECENTRE: f64 = 1000.0;

impl Pose {
    /// As the designer drew it.
    pub const SQUARE: Self = Self { decentre: [0.0; 2], tilt: [0.0; 2] };

    /// How a film stands that is shifted by so many mm and tilted by so many degrees. The shift is
    /// told in the picture as seen: to the right and up, it brings into the picture more of what is
    /// there. On the film the picture is upside down, so the film goes the other way.
    pub fn of_film(shift: [f64; 2], tilt: [f64; 2]) -> Self {
        Self { decentre: shift.map(|mm| 0.0 - mm), tilt }
    }

    /// The shift of a film in this pose, in the picture as seen, mm.
    pub fn film_shift(&self) -> [f64; 2] {
        self.decentre.map(|mm| 0.0 - mm)
    }

    /// Whether the part stands where it should.
    pub fn is_square(&self) -> bool {
        *self == Self::SQUARE
    }

    /// Whether the part stands level.
    pub fn is_level(&self) -> bool {
        self.tilt == [0.0; 2]
    }

    /// Where points of the square part come to, relative to its vertex, mm.
    pub fn motion(&self) -> DAffine3 {
        let [x, y] = self.tilt.map(f64::to_radians);
        let turn = DMat3::from_rotation_x(x) * DMat3::from_rotation_y(y);
        let [x, y] = self.decentre;
        DAffine3::from_mat3_translation(turn, DVec3::new(x, y, 0.0))
    }

    /// Where a point of a film in this pose stands, mm, from its place on the film itself: x, y, and
    /// z towards the scene, from where the plane of the square film meets the axis.
    pub fn film_point(&self, [x, y]: [f64; 2]) -> [f64; 3] {
        let point = self.motion().transform_point3(DVec3::new(x, y, 0.0));
        [point.x, point.y, -point.z]
    }

    /// The normal of a film in this pose, in the same frame, towards the scene.
    pub fn film_normal(&self) -> [f64; 3] {
        let back = self.motion().matrix3.z_axis;
        [-back.x, -back.y, back.z]
    }
}

impl fmt::Display for Pose {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { decentre: [x, y], tilt: [ax, ay] } = self;
        write!(f, "decentred by {x}, {y} mm, tilted by {ax}, {ay} degrees")
    }
}

/// A film behind a lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilmPlane {
    /// Rear vertex to the middle of the film along the axis, mm.
    pub distance: f64,
    /// How it stands, turned about its own middle.
    pub pose: Pose,
    /// Half the diagonal of what is exposed, mm.
    pub radius: f64,
    /// Half the width and the height of that, mm.
    pub half: [f64; 2],
}

impl FilmPlane {
    /// A square film of any shape inside a circle.
    pub fn square(distance: f64, radius: f64) -> Self {
        Self { distance, pose: Pose::SQUARE, radius, half: [radius; 2] }
    }
}

/// Neighbouring surfaces that are moved as one rigid body, about where the vertex of the first
/// should stand: an element, a group, the whole lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Askew {
    /// First and last row, from 0 at the scene side.
    pub rows: [usize; 2],
    /// How it stands.
    pub pose: Pose,
}

impl Askew {
    fn holds(&self, row: usize) -> bool {
        (self.rows[0]..=self.rows[1]).contains(&row)
    }
}

impl Prescription {
    /// Whether any part does not stand square.
    pub fn is_askew(&self) -> bool {
        let bodies = self.askew.iter().any(|body| !body.pose.is_square());
        bodies || self.rows.iter().any(|row| !row.pose.is_square())
    }

    /// The lens with all its parts square.
    pub fn centred(&self) -> Self {
        let mut lens = self.clone();
        lens.centre();
        lens
    }

    /// Sets all parts square.
    pub fn centre(&mut self) {
        self.askew.clear();
        self.rows.iter_mut().for_each(|row| row.pose = Pose::SQUARE);
    }

    /// How far the rear surface reaches behind the vertex of the square lens, mm.
    pub fn rear_reach(&self) -> f64 {
        let (rear, last) = (self.rear(), self.rows.len() - 1);
        let half = rear.diameter / 2.0;
        if !self.is_askew() {
            return rear.sag_at(half, 0.0).max(rear.sag_at(0.0, half)).max(0.0);
        }
        let placed = self.placements()[last];
        let behind = |point: [f64; 3]| placed.transform_point3(point.into()).z - self.length();
        let rim = (0..64).map(|step| {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(step) / 64.0).sin_cos();
            let [x, y] = [half * cos, half * sin];
            behind([x, y, rear.sag_at(x, y)])
        });
        rim.fold(behind([0.0; 3]), f64::max)
    }

    /// Where the vertices of the square lens stand behind that of the front surface, mm.
    pub fn vertices(&self) -> Vec<f64> {
        let place = |place: &mut f64, thickness: f64| {
            let here = *place;
            *place += thickness;
            Some(here)
        };
        self.rows.iter().map(|row| row.thickness).scan(0.0, place).collect()
    }

    /// For each row, where points of its surface come to, from its own frame (the vertex at the
    /// origin, the axis along z) to that of the front vertex of the square lens, mm.
    ///
    /// A surface is posed first, then the bodies that hold it in the order of
    /// [`Prescription::askew`]: an element in a group stands before the group.
    pub fn placements(&self) -> Vec<DAffine3> {
        let vertices = self.vertices();
        let at = |row: usize| DAffine3::from_translation(DVec3::new(0.0, 0.0, vertices[row]));
        let placed = |row: usize| {
            let own = at(row) * self.rows[row].pose.motion();
            let bodies = self.askew.iter().filter(|body| body.holds(row));
            bodies.fold(own, |placed, body| {
                let pivot = at(body.rows[0]);
                pivot * body.pose.motion() * pivot.inverse() * placed
            })
        };
        (0..self.rows.len()).map(placed).collect()
    }

    /// Whether two rows stand to each other as in the square lens. No row is whatever is no part
    /// of the lens: film and scene.
    pub(super) fn aligned(&self, one: Option<usize>, other: Option<usize>) -> bool {
        let level = |row: Option<usize>| row.is_none_or(|row| self.rows[row].pose.is_square());
        let holds = |body: &Askew, row: Option<usize>| row.is_some_and(|row| body.holds(row));
        let apart = |body: &Askew| !body.pose.is_square() && holds(body, one) != holds(body, other);
        level(one) && level(other) && !self.askew.iter().any(apart)
    }
}
