//! Sag of surfaces, and their intersection with rays by bisection.

use petzval_lens::{Row, TransverseAxis};

use super::{V, along, dot};

/// Sag of a surface, with z towards the scene.
pub(super) struct Sag {
    curvature: f64,
    /// 1 + conic constant.
    k1: f64,
    terms: Vec<(i32, f64)>,
    axis: Option<TransverseAxis>,
    pub(super) half: f64,
    /// Lowest and highest sag inside the clear diameter, mm.
    range: [f64; 2],
    /// Steepest slope inside the clear diameter.
    steepest: f64,
}

impl Sag {
    pub(super) fn of(row: &Row) -> Self {
        let terms = row.asphere.iter().map(|&(power, a)| (power as i32, -a)).collect();
        let mut sag = Self {
            curvature: if row.radius.is_infinite() { 0.0 } else { -1.0 / row.radius },
            k1: if row.axis.is_some() { 1.0 } else { 1.0 + row.conic },
            terms,
            axis: row.axis,
            half: row.diameter / 2.0,
            range: [0.0; 2],
            steepest: 0.0,
        };
        if sag.is_asphere() {
            const SAMPLES: u32 = 4096;
            let mut last = 0.0;
            for i in 1..=SAMPLES {
                let h = sag.half * f64::from(i) / f64::from(SAMPLES);
                let z = sag.sag([h, 0.0]);
                let [low, high] = sag.range;
                sag.range = [low.min(z), high.max(z)];
                let slope = (z - last).abs() / sag.half * f64::from(SAMPLES);
                sag.steepest = sag.steepest.max(1.02 * slope);
                last = z;
            }
        }
        sag
    }

    /// Returns the distance from the equator, mm, at which a ray that misses the hemisphere meets the
    /// sphere, or infinity for other surfaces and rays.
    pub(super) fn distance_from_equator(&self, p: V, d: V) -> f64 {
        if self.k1 != 1.0 || self.curvature == 0.0 || self.axis.is_some() || self.is_asphere() {
            return f64::INFINITY;
        }
        let radius = 1.0 / self.curvature;
        let o = [p[0], p[1], p[2] - radius];
        let b = dot(o, d);
        let root = (b * b - dot(o, o) + radius * radius).max(0.0).sqrt();
        let height = |t: f64| (p[0] + t * d[0]).hypot(p[1] + t * d[1]);
        [-b - root, -b + root]
            .map(|t| (height(t) - radius.abs()).abs())
            .into_iter()
            .fold(f64::INFINITY, f64::min)
    }

    fn is_asphere(&self) -> bool {
        !self.terms.is_empty() && self.axis.is_none()
    }

    /// Returns the square of the distance from the axis, or from the plane of a cylinder's axis, and
    /// the square root in the formula of the conic.
    fn height2_and_root(&self, [x, y]: [f64; 2]) -> (f64, f64) {
        let h2 = match self.axis {
            None => x * x + y * y,
            Some(TransverseAxis::X) => y * y,
            Some(TransverseAxis::Y) => x * x,
        };
        let inner = 1.0 - self.k1 * self.curvature * self.curvature * h2;
        (h2, inner.max(0.0).sqrt())
    }

    fn sag(&self, at: [f64; 2]) -> f64 {
        let (h2, root) = self.height2_and_root(at);
        let terms: f64 = self.terms.iter().map(|&(power, a)| a * h2.sqrt().powi(power)).sum();
        self.curvature * h2 / (1.0 + root) + terms
    }

    /// Returns the normal towards the scene, of any length.
    pub(super) fn normal(&self, [x, y]: [f64; 2]) -> V {
        let (h2, root) = self.height2_and_root([x, y]);
        let h = h2.sqrt();
        let terms = self.terms.iter().map(|&(power, a)| f64::from(power) * a * h.powi(power - 2));
        let across = self.curvature + root * terms.sum::<f64>();
        match self.axis {
            None => [-across * x, -across * y, root],
            Some(TransverseAxis::X) => [0.0, -across * y, root],
            Some(TransverseAxis::Y) => [-across * x, 0.0, root],
        }
    }

    /// Returns the height of a point above the surface. An asphere continues level beyond its clear
    /// diameter.
    fn height_above(&self, p: V) -> f64 {
        let [mut x, mut y] = [p[0], p[1]];
        let h = x.hypot(y);
        if self.is_asphere() && h > self.half {
            [x, y] = [x * self.half / h, y * self.half / h];
        }
        p[2] - self.sag([x, y])
    }

    /// Returns the point at which a ray crosses the surface upwards, by bisection.
    pub(super) fn intersect(&self, p: V, d: V) -> Option<V> {
        let bracket =
            if self.is_asphere() { self.bracket_asphere(p, d) } else { self.bracket_quadric(p, d) };
        let [mut under, mut over] = bracket?;
        loop {
            let middle = 0.5 * (under + over);
            if middle <= under.min(over) || middle >= under.max(over) {
                return Some(along(p, over, d));
            }
            match self.height_above(along(p, middle, d)) >= 0.0 {
                true => over = middle,
                false => under = middle,
            }
        }
    }

    /// Brackets the crossing of a quadric. The height above one sheet of it has one extremum along a
    /// ray, so the ray crosses the sheet upwards at most once.
    fn bracket_quadric(&self, p: V, d: V) -> Option<[f64; 2]> {
        let far = 1e6 * (dot(p, p).sqrt() + self.half);
        let [mut low, mut high] = [-far, far];
        // A sheet with an edge is defined only inside it.
        if self.k1 > 0.0 && self.curvature != 0.0 {
            let (kx, ky) = match self.axis {
                None => (1.0, 1.0),
                Some(TransverseAxis::X) => (0.0, 1.0),
                Some(TransverseAxis::Y) => (1.0, 0.0),
            };
            let edge = 1.0 / (self.k1.sqrt() * self.curvature.abs());
            let a = kx * d[0] * d[0] + ky * d[1] * d[1];
            let b = kx * p[0] * d[0] + ky * p[1] * d[1];
            let h = (kx * p[0] * p[0] + ky * p[1] * p[1]).sqrt();
            if a > 0.0 {
                let disc = b * b - a * (h - edge) * (h + edge);
                if disc < 0.0 {
                    return None;
                }
                low = low.max((-b - disc.sqrt()) / a);
                high = high.min((-b + disc.sqrt()) / a);
            } else if h > edge {
                return None;
            }
        }
        let rises = |s: f64| {
            let [x, y, _] = along(p, s, d);
            dot(self.normal([x, y]), d) > 0.0
        };
        let (mut turn, mut other) = (low, high);
        let domed = self.curvature < 0.0;
        for _ in 0..200 {
            let middle = 0.5 * (turn + other);
            if middle <= turn || middle >= other {
                break;
            }
            if rises(middle) != domed { turn = middle } else { other = middle }
        }
        let [under, over] = if domed { [other, high] } else { [low, turn] };
        let above = |s: f64| self.height_above(along(p, s, d)) >= 0.0;
        (!above(under) && above(over)).then_some([under, over])
    }

    /// Brackets the first crossing of an asphere, by steps that the steepest slope limits.
    fn bracket_asphere(&self, p: V, d: V) -> Option<[f64; 2]> {
        let [low, high] = self.range;
        let margin = 1e-9 * self.half;
        let mut s = (low - margin - p[2]) / d[2];
        let end = (high + 2.0 * margin - p[2]) / d[2];
        let least = (end - s) / 1e5;
        let quickest = d[2] + d[0].hypot(d[1]) * self.steepest;
        while s < end {
            let before = s;
            let under = -self.height_above(along(p, s, d));
            s += (under / quickest).max(least);
            if self.height_above(along(p, s, d)) >= 0.0 {
                return Some([before, s]);
            }
        }
        None
    }
}
