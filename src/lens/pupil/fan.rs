//! Fan of triangles: a region of the pupil that is sampled uniformly.

/// Triangles of a fan.
pub const TRIANGLES: usize = 32;

/// Triangles around a centre, in the plane of the rear vertex; mm. All triangles are sampled with
/// equal probability, uniformly over their area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fan {
    /// Their common corner.
    pub centre: [f32; 2],
    /// The other corners, relative to the centre and counter-clockwise; the last equals the first.
    pub corners: [[f32; 2]; TRIANGLES + 1],
}

/// One triangle of a fan: the centre and two corners relative to it.
pub(crate) struct Triangle {
    pub centre: [f32; 2],
    pub corners: [[f32; 2]; 2],
}

impl Triangle {
    /// Returns twice its area, mm^2.
    #[inline(always)]
    pub fn area2(&self) -> f32 {
        let [[ax, ay], [bx, by]] = self.corners;
        ax * by - ay * bx
    }
}

impl Fan {
    /// The fan of a dark film point.
    pub const EMPTY: Self = Self { centre: [0.0; 2], corners: [[0.0; 2]; TRIANGLES + 1] };

    /// Returns a fan of triangles of equal area that encloses an outline. The outline goes around
    /// the centre counter-clockwise and is relative to it.
    pub fn around(centre: [f64; 2], outline: &[[f64; 2]]) -> Self {
        let count = outline.len();
        let next = |i: usize| outline[(i + 1) % count];
        // Clockwise parts (of an outline with gaps, or that only one direction hits) add no area.
        let swept: Vec<f64> = (0..count).map(|i| cross(outline[i], next(i)).max(0.0)).collect();
        let total: f64 = swept.iter().sum();
        if total <= 0.0 {
            return Self::EMPTY;
        }
        let mut corners = [[0.0; 2]; TRIANGLES];
        let (mut i, mut before) = (0, 0.0);
        for (k, corner) in corners.iter_mut().enumerate() {
            let wanted = total * k as f64 / TRIANGLES as f64;
            while i + 1 < count && before + swept[i] < wanted {
                before += swept[i];
                i += 1;
            }
            let t = if swept[i] > 0.0 { ((wanted - before) / swept[i]).min(1.0) } else { 0.0 };
            *corner = [0, 1].map(|axis| outline[i][axis] + t * (next(i)[axis] - outline[i][axis]));
        }
        // A chord cuts off the bulge of the outline: move both of its ends out until it does not.
        let mut out = [1.0f64; TRIANGLES];
        for &point in outline {
            let over =
                |k: usize| distance_over_chord(corners[k], corners[(k + 1) % TRIANGLES], point);
            if let Some((k, by)) = (0..TRIANGLES).find_map(|k| Some((k, over(k)?))) {
                for end in [k, (k + 1) % TRIANGLES] {
                    out[end] = out[end].max(by);
                }
            }
        }
        let scaled = |k: usize| corners[k % TRIANGLES].map(|v| (v * out[k % TRIANGLES]) as f32);
        Self { centre: centre.map(|v| v as f32), corners: std::array::from_fn(scaled) }
    }

    /// Returns whether it has an area.
    pub fn is_open(&self) -> bool {
        self.corners[0] != [0.0; 2]
    }

    /// Returns its area, mm^2.
    pub fn area(&self) -> f32 {
        (0..TRIANGLES).map(|k| self.triangle(k).area2() / 2.0).sum()
    }

    /// Returns the weighted sum of fans.
    #[inline(always)]
    pub fn mix(fans: &[(&Self, f32)]) -> Self {
        let mut sum = Self::EMPTY;
        for (fan, weight) in fans {
            for (to, from) in sum.centre.iter_mut().zip(fan.centre) {
                *to += weight * from;
            }
            let corners = sum.corners.as_flattened_mut().iter_mut();
            for (to, from) in corners.zip(fan.corners.as_flattened()) {
                *to += weight * from;
            }
        }
        sum
    }

    /// Returns the fan scaled about its centre.
    pub fn scaled(&self, by: f32) -> Self {
        Self { centre: self.centre, corners: self.corners.map(|corner| corner.map(|v| v * by)) }
    }

    /// Returns the fan in a frame turned back by an angle: its u axis has this direction there.
    pub(super) fn turned(&self, cos: f32, sin: f32) -> Self {
        let turned = |[u, v]: [f32; 2]| [cos * u - sin * v, sin * u + cos * v];
        Self { centre: turned(self.centre), corners: self.corners.map(turned) }
    }

    /// Returns the fan with each corner moved away from the centre by a factor.
    pub(super) fn widened(&self, by: &[f64; TRIANGLES]) -> Self {
        let moved = |k: usize| self.corners[k].map(|v| (f64::from(v) * by[k % TRIANGLES]) as f32);
        Self { centre: self.centre, corners: std::array::from_fn(moved) }
    }

    /// Returns a point of a scaled copy of the outer side of a triangle. `turn` is 0 at its first
    /// corner and 1 at the second; equal steps are about equal angles at the centre.
    pub(super) fn outside(&self, triangle: usize, turn: f64, scale: f64) -> [f64; 2] {
        let [a, b] = [triangle, triangle + 1].map(|k| self.corners[k].map(f64::from));
        let length = |[u, v]: [f64; 2]| (u * u + v * v).sqrt();
        let [from, to] = [(1.0 - turn) * length(b), turn * length(a)];
        let along = if from + to > 0.0 { to / (from + to) } else { 0.0 };
        [0, 1].map(|i| f64::from(self.centre[i]) + scale * (a[i] + along * (b[i] - a[i])))
    }

    #[inline(always)]
    pub(crate) fn triangle(&self, k: usize) -> Triangle {
        Triangle { centre: self.centre, corners: [self.corners[k], self.corners[k + 1]] }
    }

    /// Returns the scale at which the fan just encloses a point; at most 1 for a point inside.
    pub fn scale_to_enclose(&self, point: [f64; 2]) -> f64 {
        self.triangle_towards(point).map_or(0.0, |(_, scale)| scale)
    }

    /// Returns the triangle in whose sector a point lies, and the scale at which it just encloses
    /// the point.
    pub(super) fn triangle_towards(&self, point: [f64; 2]) -> Option<(usize, f64)> {
        let local = [0, 1].map(|axis| point[axis] - f64::from(self.centre[axis]));
        let corner = |k: usize| self.corners[k].map(f64::from);
        (0..TRIANGLES)
            .find_map(|k| Some((k, distance_over_chord(corner(k), corner(k + 1), local)?)))
    }

    /// Returns the density of its samples at a point, mm^-2; 0 outside.
    pub fn density(&self, point: [f32; 2]) -> f32 {
        let inside = self.sector(point).filter(|(scale, _)| *scale <= 1.0);
        inside.map_or(0.0, |(_, area)| 1.0 / (TRIANGLES as f32 * area))
    }

    /// Returns the triangle in whose sector a point lies: the scale at which it just reaches the
    /// point, and its area, mm^2. In a fan that overlaps itself it is the triangle that needs the
    /// least scale, or the first that contains the point.
    pub(super) fn sector(&self, [x, y]: [f32; 2]) -> Option<(f32, f32)> {
        let (x, y) = (x - self.centre[0], y - self.centre[1]);
        // Twice the areas of the triangles that the point forms with the centre and a corner. This loop
        // vectorizes, and few triangles pass the test in the next.
        let mut crosses = [0.0; TRIANGLES + 1];
        for (cross, [cx, cy]) in crosses.iter_mut().zip(self.corners) {
            *cross = cx * y - cy * x;
        }
        let mut nearest: Option<(f32, f32)> = None;
        for k in 0..TRIANGLES {
            let (a, b) = (-crosses[k + 1], crosses[k]);
            if a < 0.0 || b < 0.0 {
                continue;
            }
            let area2 = self.triangle(k).area2();
            if area2 > 0.0 {
                let found = ((a + b) / area2, area2 / 2.0);
                if a + b <= area2 {
                    return Some(found);
                }
                nearest = nearest.filter(|(scale, _)| *scale <= found.0).or(Some(found));
            }
        }
        nearest
    }
}

fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

/// Returns, for a point in the sector between two corners, its distance from the centre relative to
/// that of the chord in the same direction.
fn distance_over_chord(a: [f64; 2], b: [f64; 2], point: [f64; 2]) -> Option<f64> {
    let area2 = cross(a, b);
    let (from_b, from_a) = (cross(point, b), cross(a, point));
    (area2 > 0.0 && from_a >= 0.0 && from_b >= 0.0).then(|| (from_a + from_b) / area2)
}
