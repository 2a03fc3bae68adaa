//! Tilted and decentred surfaces, by 3 x 3 matrices.

use petzval_lens::{Pose, Prescription};

use super::{V, dot};

/// A matrix, by rows.
pub type M = [V; 3];

fn product(a: M, b: M) -> M {
    let entry = |i: usize, j: usize| a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j];
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| entry(i, j)))
}

pub fn multiply(m: M, v: V) -> V {
    m.map(|row| dot(row, v))
}

pub fn transpose(m: M) -> M {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| m[j][i]))
}

/// Returns the rotation of a pose in lens space, with z towards the film: about x, then about the new y.
pub fn rotation(pose: &Pose) -> M {
    let [(sx, cx), (sy, cy)] = pose.tilt.map(|degrees| degrees.to_radians().sin_cos());
    let about_x = [[1.0, 0.0, 0.0], [0.0, cx, -sx], [0.0, sx, cx]];
    let about_y = [[cy, 0.0, sy], [0.0, 1.0, 0.0], [-sy, 0.0, cy]];
    product(about_x, about_y)
}

/// Tilt and decentre of a surface: its axes, and its vertex relative to the nominal one. z runs towards
/// the film.
pub(super) struct Placement {
    axes: M,
    vertex: V,
}

impl Placement {
    pub(super) fn of(lens: &Prescription, row: usize) -> Self {
        let height = |row: usize| lens.rows[..row].iter().map(|row| row.thickness).sum::<f64>();
        let pose = &lens.rows[row].pose;
        let (mut axes, mut vertex) = (rotation(pose), [pose.decentre[0], pose.decentre[1], 0.0]);
        for body in &lens.tilt_decenters {
            if row < body.rows[0] || row > body.rows[1] {
                continue;
            }
            // From the pivot to the vertex.
            let ahead = height(row) - height(body.rows[0]);
            let turn = rotation(&body.pose);
            axes = product(turn, axes);
            let [x, y, z] = multiply(turn, [vertex[0], vertex[1], vertex[2] + ahead]);
            let [dx, dy] = body.pose.decentre;
            vertex = [x + dx, y + dy, z - ahead];
        }
        Self { axes, vertex }
    }

    /// Transforms a ray into the frame of the surface. z runs to the scene, before and after.
    pub(super) fn enter(&self, p: V, d: V) -> [V; 2] {
        let from = [p[0] - self.vertex[0], p[1] - self.vertex[1], -p[2] - self.vertex[2]];
        let inverse = transpose(self.axes);
        let (p, d) = (multiply(inverse, from), multiply(inverse, [d[0], d[1], -d[2]]));
        [[p[0], p[1], -p[2]], [d[0], d[1], -d[2]]]
    }

    /// Transforms a ray back from the frame of the surface.
    pub(super) fn leave(&self, p: V, d: V) -> [V; 2] {
        let p = multiply(self.axes, [p[0], p[1], -p[2]]);
        let d = multiply(self.axes, [d[0], d[1], -d[2]]);
        let [x, y, z] = self.vertex;
        [[p[0] + x, p[1] + y, -p[2] - z], [d[0], d[1], -d[2]]]
    }
}
