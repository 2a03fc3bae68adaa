//! The oracle: a lens traced from the film by the textbook, in f64.
//!
//! Written apart from the program, so that the same mistake cannot sit on both sides. [`trace`]
//! knows spheres only, by their centres and the quadratic formula, and is fast. [`follow`]
//! knows every surface: it asks only how high a point lies over the surface, and looks for the
//! place where that changes its sign; and it knows surfaces that stand askew, by 3 x 3 matrices. Both
//! refract in vector form (Heckbert, in Glassner 1989,
//! "An Introduction to Ray Tracing", p. 291). z runs from the film (z = 0) to the scene.

use petzval::lens::{Axis, Blocked, Iris, Pose, Prescription, Row, Why};

use super::Random;

pub type V = [f64; 3];

pub fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn unit(d: V) -> V {
    let length = dot(d, d).sqrt();
    d.map(|v| v / length)
}

fn along(a: V, t: f64, d: V) -> V {
    [a[0] + t * d[0], a[1] + t * d[1], a[2] + t * d[2]]
}

/// The exit point relative to the front vertex and the unit direction, or the row (from 0)
/// at which the ray ends; for a lens of spheres.
pub fn trace(lens: &Prescription, film: f64, start: V, towards: V) -> Result<[V; 2], usize> {
    trace_seeing(lens, film, start, towards, |_, _| {})
}

/// The same, and `see` is told the row and the cosine of incidence at every surface.
pub fn trace_seeing(
    lens: &Prescription,
    film: f64,
    start: V,
    towards: V,
    mut see: impl FnMut(usize, f64),
) -> Result<[V; 2], usize> {
    let mut p = start;
    let mut d = unit(towards);
    let mut vertex = film;
    for (i, row) in lens.rows.iter().enumerate().rev() {
        let half = row.diameter / 2.0;
        if row.radius.is_infinite() {
            let t = (vertex - p[2]) / d[2];
            if t <= 0.0 {
                return Err(i);
            }
            p = along(p, t, d);
            if p[0] * p[0] + p[1] * p[1] > half * half {
                return Err(i);
            }
            see(i, d[2]);
            d = refract(d, [0.0, 0.0, -1.0], row.index, lens.index_before(i)).ok_or(i)?;
        } else {
            // The centre lies towards the film where the radius is positive.
            let centre = [0.0, 0.0, vertex - row.radius];
            let o = [p[0] - centre[0], p[1] - centre[1], p[2] - centre[2]];
            let b = dot(o, d);
            let disc = b * b - dot(o, o) + row.radius * row.radius;
            if disc < 0.0 {
                return Err(i);
            }
            // The sheet at the vertex: the far one where the centre is on this side.
            let t = if row.radius > 0.0 { -b + disc.sqrt() } else { -b - disc.sqrt() };
            p = along(p, t, d);
            let n = [p[0] / row.radius, p[1] / row.radius, (p[2] - centre[2]) / row.radius];
            let past_equator = n[2] <= 0.0;
            if p[0] * p[0] + p[1] * p[1] > half * half || past_equator {
                return Err(i);
            }
            let n = n.map(|v| -v);
            see(i, -dot(d, n));
            d = refract(d, n, row.index, lens.index_before(i)).ok_or(i)?;
        }
        if i > 0 {
            vertex += lens.rows[i - 1].thickness;
        }
    }
    Ok([[p[0], p[1], p[2] - vertex], d])
}

/// Heckbert's refraction; the normal points against the ray.
fn refract(d: V, n: V, n1: f64, n2: f64) -> Option<V> {
    let ratio = n1 / n2;
    let c1 = -dot(d, n);
    let c2 = 1.0 - ratio * ratio * (1.0 - c1 * c1);
    if c2 < 0.0 {
        return None;
    }
    let k = ratio * c1 - c2.sqrt();
    Some([ratio * d[0] + k * n[0], ratio * d[1] + k * n[1], ratio * d[2] + k * n[2]])
}

/// A ray that came out.
#[derive(Clone, Copy, Debug)]
pub struct Exit {
    /// Relative to the front vertex, mm.
    pub p: V,
    /// Of unit length.
    pub d: V,
    /// What is left of a weight of 1.
    pub weight: f64,
}

/// What becomes of a ray, and how nearly something else would have.
#[derive(Clone, Copy, Debug)]
pub struct Fate {
    pub end: Result<Exit, Blocked>,
    /// Distance to the nearest edge of what clips, on the ray's way, mm.
    pub rim: f64,
    /// The smallest cosine of incidence and of refraction on its way: 0 at tangency and at
    /// total reflection.
    pub cosine: f64,
}

/// A surface as rays from the film meet it: the height z of its sheet over its vertex.
struct Sheet {
    curvature: f64,
    /// 1 + k.
    k1: f64,
    terms: Vec<(i32, f64)>,
    axis: Option<Axis>,
    half: f64,
    /// Lowest and highest inside the clear diameter, and the steepest slope there.
    range: [f64; 2],
    steepest: f64,
}

impl Sheet {
    fn of(row: &Row) -> Self {
        let terms = row.asphere.iter().map(|&(power, a)| (power as i32, -a)).collect();
        let mut sheet = Self {
            curvature: if row.radius.is_infinite() { 0.0 } else { -1.0 / row.radius },
            k1: if row.axis.is_some() { 1.0 } else { 1.0 + row.conic },
            terms,
            axis: row.axis,
            half: row.diameter / 2.0,
            range: [0.0; 2],
            steepest: 0.0,
        };
        if sheet.is_asphere() {
            const SAMPLES: u32 = 4096;
            let mut last = 0.0;
            for i in 1..=SAMPLES {
                let h = sheet.half * f64::from(i) / f64::from(SAMPLES);
                let z = sheet.height([h, 0.0]);
                let [low, high] = sheet.range;
                sheet.range = [low.min(z), high.max(z)];
                let slope = (z - last).abs() / sheet.half * f64::from(SAMPLES);
                sheet.steepest = sheet.steepest.max(1.02 * slope);
                last = z;
            }
        }
        sheet
    }

    /// For a ray that misses a sphere's sheet: how near to the equator, mm, it comes to the sphere
    /// beyond it.
    fn past_edge(&self, p: V, d: V) -> f64 {
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

    /// The square of the height at which it is as high as its axis says, and the root of the conic.
    fn bent(&self, [x, y]: [f64; 2]) -> (f64, f64) {
        let h2 = match self.axis {
            None => x * x + y * y,
            Some(Axis::X) => y * y,
            Some(Axis::Y) => x * x,
        };
        let inner = 1.0 - self.k1 * self.curvature * self.curvature * h2;
        (h2, inner.max(0.0).sqrt())
    }

    fn height(&self, at: [f64; 2]) -> f64 {
        let (h2, root) = self.bent(at);
        let terms: f64 = self.terms.iter().map(|&(power, a)| a * h2.sqrt().powi(power)).sum();
        self.curvature * h2 / (1.0 + root) + terms
    }

    /// The normal to the scene, of any length.
    fn normal(&self, [x, y]: [f64; 2]) -> V {
        let (h2, root) = self.bent([x, y]);
        let h = h2.sqrt();
        let terms = self.terms.iter().map(|&(power, a)| f64::from(power) * a * h.powi(power - 2));
        let across = self.curvature + root * terms.sum::<f64>();
        match self.axis {
            None => [-across * x, -across * y, root],
            Some(Axis::X) => [0.0, -across * y, root],
            Some(Axis::Y) => [-across * x, 0.0, root],
        }
    }

    /// How high a point lies over the surface, which goes on level beyond its clear diameter
    /// where it is an asphere.
    fn over(&self, p: V) -> f64 {
        let [mut x, mut y] = [p[0], p[1]];
        let h = x.hypot(y);
        if self.is_asphere() && h > self.half {
            [x, y] = [x * self.half / h, y * self.half / h];
        }
        p[2] - self.height([x, y])
    }

    /// Where a ray comes up through the surface.
    fn meet(&self, p: V, d: V) -> Option<V> {
        let bracket = if self.is_asphere() { self.first(p, d) } else { self.only(p, d) };
        let [mut under, mut over] = bracket?;
        loop {
            let middle = 0.5 * (under + over);
            if middle <= under.min(over) || middle >= under.max(over) {
                return Some(along(p, over, d));
            }
            match self.over(along(p, middle, d)) >= 0.0 {
                true => over = middle,
                false => under = middle,
            }
        }
    }

    /// The height over a quadric's sheet rises and then falls along a ray, or falls and then
    /// rises: it comes up through the sheet once at most.
    fn only(&self, p: V, d: V) -> Option<[f64; 2]> {
        let far = 1e6 * (dot(p, p).sqrt() + self.half);
        let [mut low, mut high] = [-far, far];
        // Where the sheet has an edge, the ray must be inside it.
        if self.k1 > 0.0 && self.curvature != 0.0 {
            let (kx, ky) = match self.axis {
                None => (1.0, 1.0),
                Some(Axis::X) => (0.0, 1.0),
                Some(Axis::Y) => (1.0, 0.0),
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
        let above = |s: f64| self.over(along(p, s, d)) >= 0.0;
        (!above(under) && above(over)).then_some([under, over])
    }

    /// The first crossing: the ray goes on by no more than it takes to come near.
    fn first(&self, p: V, d: V) -> Option<[f64; 2]> {
        let [low, high] = self.range;
        let margin = 1e-9 * self.half;
        let mut s = (low - margin - p[2]) / d[2];
        let end = (high + 2.0 * margin - p[2]) / d[2];
        let least = (end - s) / 1e5;
        let quickest = d[2] + d[0].hypot(d[1]) * self.steepest;
        while s < end {
            let before = s;
            let under = -self.over(along(p, s, d));
            s += (under / quickest).max(least);
            if self.over(along(p, s, d)) >= 0.0 {
                return Some([before, s]);
            }
        }
        None
    }
}

/// How far inside the opening of an iris a point lies, mm (negative outside), and what share
/// of the light passes there.
fn opening(iris: &Iris, half: f64, [x, y]: [f64; 2]) -> (f64, f64) {
    match iris {
        Iris::Round => (f64::INFINITY, 1.0),
        Iris::Blades { count, rotation, curvature } => {
            let corner = |i: u32| {
                let angle = rotation.to_radians()
                    + std::f64::consts::TAU * f64::from(i) / f64::from(*count);
                [half * angle.cos(), half * angle.sin()]
            };
            let inside = (0..*count).map(|i| {
                let ([ax, ay], [bx, by]) = (corner(i), corner(i + 1));
                let chord = (bx - ax).hypot(by - ay);
                // To the left of the chord is inside.
                let left = [-(by - ay) / chord, (bx - ax) / chord];
                if *curvature == 0.0 {
                    return left[0] * (x - ax) + left[1] * (y - ay);
                }
                let radius = half / curvature;
                let back = (radius * radius - chord * chord / 4.0).max(0.0).sqrt();
                let centre = [(ax + bx) / 2.0 + back * left[0], (ay + by) / 2.0 + back * left[1]];
                radius - (x - centre[0]).hypot(y - centre[1])
            });
            let inside = inside.fold(f64::INFINITY, f64::min);
            (inside, f64::from(u8::from(inside >= 0.0)))
        }
        Iris::Mask(mask) => {
            let cell = 2.0 * half / mask.size as f64;
            let [column, row] = [(x + half) / cell, (half - y) / cell];
            let edge = |v: f64| (v - v.round()).abs() * cell;
            let rim = edge(column).min(edge(row));
            let within = 0.0..mask.size as f64;
            if !within.contains(&column) || !within.contains(&row) {
                return (-rim, 0.0);
            }
            let t = mask.transmission[row as usize * mask.size + column as usize];
            (rim, f64::from(t))
        }
    }
}

pub type M = [V; 3];

fn product(a: M, b: M) -> M {
    let entry = |i: usize, j: usize| a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j];
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| entry(i, j)))
}

pub fn times(m: M, v: V) -> V {
    m.map(|row| dot(row, v))
}

pub fn transposed(m: M) -> M {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| m[j][i]))
}

/// The turn of a pose, in lens space with z towards the film: about x, then about the new y.
pub fn turned(pose: &Pose) -> M {
    let [(sx, cx), (sy, cy)] = pose.tilt.map(|degrees| degrees.to_radians().sin_cos());
    let about_x = [[1.0, 0.0, 0.0], [0.0, cx, -sx], [0.0, sx, cx]];
    let about_y = [[cy, 0.0, sy], [0.0, 1.0, 0.0], [-sy, 0.0, cy]];
    product(about_x, about_y)
}

/// How a surface stands: its axes, and its vertex from where that should be; z towards the film.
struct Stand {
    axes: M,
    vertex: V,
}

impl Stand {
    fn of(lens: &Prescription, row: usize) -> Self {
        let height = |row: usize| lens.rows[..row].iter().map(|row| row.thickness).sum::<f64>();
        let pose = &lens.rows[row].pose;
        let (mut axes, mut vertex) = (turned(pose), [pose.decentre[0], pose.decentre[1], 0.0]);
        for body in &lens.askew {
            if row < body.rows[0] || row > body.rows[1] {
                continue;
            }
            // From the pivot to the vertex.
            let ahead = height(row) - height(body.rows[0]);
            let turn = turned(&body.pose);
            axes = product(turn, axes);
            let [x, y, z] = times(turn, [vertex[0], vertex[1], vertex[2] + ahead]);
            let [dx, dy] = body.pose.decentre;
            vertex = [x + dx, y + dy, z - ahead];
        }
        Self { axes, vertex }
    }

    /// Into the frame of the surface; here as everywhere in the oracle z runs to the scene.
    fn enter(&self, p: V, d: V) -> [V; 2] {
        let from = [p[0] - self.vertex[0], p[1] - self.vertex[1], -p[2] - self.vertex[2]];
        let inverse = transposed(self.axes);
        let (p, d) = (times(inverse, from), times(inverse, [d[0], d[1], -d[2]]));
        [[p[0], p[1], -p[2]], [d[0], d[1], -d[2]]]
    }

    fn leave(&self, p: V, d: V) -> [V; 2] {
        let p = times(self.axes, [p[0], p[1], -p[2]]);
        let d = times(self.axes, [d[0], d[1], -d[2]]);
        let [x, y, z] = self.vertex;
        [[p[0] + x, p[1] + y, -p[2] - z], [d[0], d[1], -d[2]]]
    }
}

/// A lens that the oracle has looked at.
pub struct Oracle<'a> {
    lens: &'a Prescription,
    sheets: Vec<Sheet>,
    stands: Vec<Stand>,
}

impl<'a> Oracle<'a> {
    pub fn new(lens: &'a Prescription) -> Self {
        let sheets = lens.rows.iter().map(Sheet::of).collect();
        let stands = (0..lens.rows.len()).map(|row| Stand::of(lens, row)).collect();
        Self { lens, sheets, stands }
    }

    /// What becomes of a ray from the film, which stands at `film` mm behind the rear vertex.
    pub fn follow(&self, film: f64, start: V, towards: V) -> Fate {
        self.shaken(film, start, towards, |v| v)
    }

    /// The same with every number of the ray off by up to `size`, relative, after every surface:
    /// what roundings of that size can do to this ray.
    pub fn rounded(&self, film: f64, start: V, towards: V, size: f64, random: &mut Random) -> Fate {
        self.shaken(film, start, towards, |v| v * (1.0 + size * random.between(-1.0, 1.0)))
    }

    fn shaken(&self, film: f64, start: V, towards: V, mut shake: impl FnMut(f64) -> f64) -> Fate {
        let mut p = start;
        let mut d = unit(towards);
        let mut advance = film;
        let (mut rim, mut cosine, mut weight) = (f64::INFINITY, 1.0f64, 1.0);
        for (i, row) in self.lens.rows.iter().enumerate().rev() {
            let (sheet, stand) = (&self.sheets[i], &self.stands[i]);
            let mut step = || -> Result<(), Why> {
                p[2] -= advance;
                [p, d] = stand.enter(p, d);
                p = p.map(&mut shake);
                if d[2] <= 0.0 {
                    return Err(Why::Miss);
                }
                let Some(met) = sheet.meet(p, d) else {
                    // A miss may be a matter of rounding too: past the very edge of a sphere.
                    rim = rim.min(sheet.past_edge(p, d));
                    return Err(Why::Miss);
                };
                p = met;
                let h = p[0].hypot(p[1]);
                rim = rim.min((h - sheet.half).abs());
                let clip = if row.stop { Why::Stop } else { Why::Clip };
                if h > sheet.half {
                    return Err(clip);
                }
                let n = unit(sheet.normal([p[0], p[1]])).map(|v| -v);
                cosine = cosine.min(-dot(n, d));
                let before = self.lens.index_before(i);
                let bent = refract(d, n, row.index, before);
                let past = 1.0 - (row.index / before).powi(2) * (1.0 - dot(n, d).powi(2));
                cosine = cosine.min(past.abs().sqrt());
                d = unit(bent.ok_or(Why::Tir)?.map(&mut shake));
                let (inside, share) = opening(&row.iris, sheet.half, [p[0], p[1]]);
                rim = rim.min(inside.abs());
                weight *= share;
                if share == 0.0 {
                    return Err(clip);
                }
                if row.obstruction > 0.0 {
                    rim = rim.min((h - row.obstruction / 2.0).abs());
                    if h < row.obstruction / 2.0 {
                        return Err(clip);
                    }
                }
                [p, d] = stand.leave(p, d);
                Ok(())
            };
            if let Err(why) = step() {
                return Fate { end: Err(Blocked { row: i, why }), rim, cosine };
            }
            advance = if i > 0 { self.lens.rows[i - 1].thickness } else { 0.0 };
        }
        Fate { end: Ok(Exit { p, d, weight }), rim, cosine }
    }
}
