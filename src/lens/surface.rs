//! Surfaces made ready for tracing in one direction.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};

use super::asphere::Asphere;
use super::coating::{Coat, Coating};
use super::glass::D_LINE;
use super::ideal::Ideal;
use super::iris::Iris;
use super::opening::Shape;
use super::polynomial::Polynomial;
use super::prescription::{Axis, Prescription, Row};
use super::turn::Turn;
use crate::lanes::Real;

/// Which kernel takes a ray to a surface and through it.
#[derive(Clone, Debug)]
pub enum Kind<T> {
    /// A plane that only clips.
    Stop,
    /// A sphere or a plane.
    Sphere,
    /// A conic of revolution, with 1 + k.
    Conic(T),
    /// A circular cylinder.
    Cylinder(Axis),
    /// A conic of revolution and a polynomial.
    Asphere(Arc<Asphere<T>>),
    /// A plane where rays change as first-order optics has it.
    Ideal(Arc<Ideal<T>>),
    /// All surfaces up to here, as polynomials.
    Polynomial(Arc<Polynomial<T>>),
    /// The shape of the opening in the plane of the stop crossed before.
    Iris(Arc<Shape<T>>),
    /// An opaque disk on the surface crossed before, with the square of half its diameter.
    Obstruction(T),
    /// No surface: from the frame of what was crossed before to that of what comes next, where they
    /// do not stand square to each other.
    Turn(Arc<Turn<T>>),
}

/// One surface as a ray meets it: +z is the direction of travel, lengths in mm.
#[derive(Clone, Debug)]
pub struct Surface<T> {
    /// The row of the prescription that it comes from.
    pub row: usize,
    /// Which kernel applies.
    pub kind: Kind<T>,
    /// Met from so far that the ray goes to the plane of the vertex first: G may change sign on
    /// the way (a ball lens), and its square would dwarf the normal component.
    pub far: bool,
    /// Whether its rim is that of the aperture stop.
    pub stop: bool,
    /// Distance from the vertex crossed before to this one.
    pub advance: T,
    /// Curvature at the vertex, positive where the centre lies ahead.
    pub curvature: T,
    /// Square of the index on the side where rays come from.
    pub n2: T,
    /// n'^2 - n^2, what refraction adds to the square of the normal component.
    pub n2_step: T,
    /// Square of half the clear diameter.
    pub aperture2: T,
    /// Square of the normal component before refraction at which the ray is totally reflected or
    /// tangent.
    pub limit: T,
    /// How near to the limit this precision cannot be trusted.
    pub doubt: T,
    /// Whether rays turn back. Then `n2_step` is not that of the media but any that shows the
    /// kernel's normal, and what follows is met in the other direction.
    pub mirror: bool,
    /// What it lets through of the light.
    pub coat: Coat<T>,
}

/// From which side rays come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum From {
    /// From a film at this distance, mm, behind the rear vertex: rays go out to the scene.
    Film(f64),
    /// From a plane at this distance, mm, before the front vertex: rays go to the film.
    Scene(f64),
}

/// The surfaces of a lens in the order in which rays from that side meet them. A row of the
/// prescription that blocks in several ways makes several. Rays start in the plane that [`From`]
/// names, and come out relative to the last vertex of the square lens.
pub fn sequence<R: Real>(lens: &Prescription, from: From) -> Vec<Surface<R::Scalar>> {
    sequence_at::<R>(lens, from, D_LINE)
}

/// The same with coatings as they are for light of a wavelength, nm. The indices are the lens's.
pub(super) fn sequence_at<R: Real>(
    lens: &Prescription,
    from: From,
    nm: f64,
) -> Vec<Surface<R::Scalar>> {
    let count = lens.rows.len();
    let mut path = Path::<R>::new(lens, nm);
    for place in 0..count {
        match from {
            From::Film(distance) => {
                path.go(count - 1 - place, (place == 0).then_some(distance), false, false);
            }
            From::Scene(distance) => path.go(place, (place == 0).then_some(distance), true, false),
        }
    }
    path.end(matches!(from, From::Scene(_)))
}

/// The surfaces that light of a wavelength, nm, meets on its way from the scene to the film if the
/// second of two rows mirrors it back to the first, and that one to the film again. Rays start at
/// the front vertex.
pub fn ghost_sequence<R: Real>(
    lens: &Prescription,
    [first, second]: [usize; 2],
    nm: f64,
) -> Vec<Surface<R::Scalar>> {
    let mut path = Path::<R>::new(lens, nm);
    for row in 0..second {
        path.go(row, (row == 0).then_some(0.0), true, false);
    }
    path.go(second, (second == 0).then_some(0.0), true, true);
    for row in (first + 1..second).rev() {
        path.go(row, None, false, false);
    }
    path.go(first, None, false, true);
    for row in first + 1..lens.rows.len() {
        path.go(row, None, true, false);
    }
    path.end(true)
}

/// The way of light from row to row.
struct Path<'a, R: Real> {
    lens: &'a Prescription,
    nm: f64,
    /// Half the diameter of the row met before, and its sag there as the ray travels.
    height: f64,
    sag: f64,
    /// That row.
    crossed: Option<usize>,
    /// How the rows stand; empty where all are square.
    placed: Vec<DAffine3>,
    surfaces: Vec<Surface<R::Scalar>>,
}

impl<'a, R: Real> Path<'a, R> {
    fn new(lens: &'a Prescription, nm: f64) -> Self {
        let placed = if lens.is_askew() { lens.placements() } else { Vec::new() };
        let surfaces = Vec::with_capacity(lens.rows.len());
        Self { lens, nm, height: 0.0, sag: 0.0, crossed: None, placed, surfaces }
    }

    /// Adds a row, met on the way to the film or from it, at its thickness or another distance
    /// from the one before.
    fn go(&mut self, row: usize, distance: Option<f64>, to_film: bool, mirror: bool) {
        let Self { lens, nm, .. } = *self;
        let rows = &lens.rows;
        let between = if to_film { row.wrapping_sub(1) } else { row };
        let advance = distance.unwrap_or_else(|| rows[between].thickness);
        let [before, behind] = lens.indices(row);
        let (sign, n, n_after) =
            if to_film { (1.0, before, behind) } else { (-1.0, behind, before) };
        let half = rows[row].diameter / 2.0;
        let sag = rows[row].sag(half);
        let spread = match self.crossed {
            Some(_) => [self.height, self.sag],
            None => [advance.abs() + half, 0.0],
        };
        let first = self.crossed.is_none();
        let mut side = Side { row, advance, sign, n, n_after, spread, first, mirror, nm };
        let start = distance.map_or(0.0, |distance| match to_film {
            true => -distance,
            false => lens.length() + distance,
        });
        if let Some(mut motion) = self.motion(Some(row), start, to_film) {
            // What is left of the way goes along the axis of the surface, as ever.
            side.advance = -motion.translation.z;
            motion.translation.z = 0.0;
            self.turn(row, &motion);
        }
        (self.height, self.sag, self.crossed) = (half, sign * sag, Some(row));
        push::<R>(&rows[row], &side, &mut self.surfaces);
    }

    /// The surfaces, for rays that come out to the film or to the scene.
    fn end(mut self, to_film: bool) -> Vec<Surface<R::Scalar>> {
        if let Some(motion) = self.motion(None, 0.0, to_film) {
            self.turn(self.crossed.unwrap_or(0), &motion);
        }
        self.surfaces
    }

    /// From the frame of the row met before to that of the next, +z along the way, unless they stand
    /// square to each other. Before the first row stands a plane at this place from the front vertex,
    /// behind the last the frame of the last vertex of the square lens.
    fn motion(&self, next: Option<usize>, start: f64, to_film: bool) -> Option<DAffine3> {
        if self.placed.is_empty() || self.lens.aligned(self.crossed, next) {
            return None;
        }
        let at = |z: f64| DAffine3::from_translation(DVec3::new(0.0, 0.0, z));
        let from = self.crossed.map_or(at(start), |row| self.placed[row]);
        let end = if to_film { self.lens.length() } else { 0.0 };
        let to = next.map_or(at(end), |row| self.placed[row]);
        let sign = if to_film { 1.0 } else { -1.0 };
        let flip = DAffine3::from_mat3(DMat3::from_diagonal(DVec3::new(1.0, 1.0, sign)));
        Some(flip * to.inverse() * from * flip)
    }

    /// Adds a turn on the way to a row, or behind it.
    fn turn(&mut self, row: usize, motion: &DAffine3) {
        let zero = R::scalar(0.0);
        self.surfaces.push(Surface {
            row,
            kind: Kind::Turn(Arc::new(Turn::new::<R>(motion))),
            far: false,
            stop: false,
            advance: zero,
            curvature: zero,
            n2: zero,
            n2_step: zero,
            aperture2: zero,
            limit: zero,
            doubt: zero,
            mirror: false,
            coat: Coat::new::<R>(Coating::default(), [1.0; 2], self.nm),
        });
    }
}

impl Prescription {
    /// How many turns between frames a ray takes on its way through.
    pub fn turns(&self) -> usize {
        let surfaces = sequence::<f64>(self, From::Scene(1.0));
        surfaces.iter().filter(|surface| matches!(surface.kind, Kind::Turn(_))).count()
    }
}

/// How rays come to a surface.
struct Side {
    row: usize,
    advance: f64,
    /// -1 where they come from the film.
    sign: f64,
    n: f64,
    n_after: f64,
    /// How far from the axis they start, and how far ahead of the vertex crossed before at most.
    spread: [f64; 2],
    /// Whether no row comes before it: rays start anywhere, and are aimed at all of its rim.
    first: bool,
    mirror: bool,
    /// Wavelength for the coating.
    nm: f64,
}

/// How far off, rad, the direction behind a surface may be by the bound below. The bound is
/// pessimistic: a ball lens next to total reflection, at this limit, is off by 4 urad.
const DIRECTION: f64 = 2e-6;

/// From this slope of its rim on, 52 degrees, the first surface is grazed by rays of a film. What
/// rounding does to them there is magnified where they come near total reflection later.
const STEEP: f64 = 1.3;
/// So much less may their directions be off.
const MAGNIFIED: f64 = 3.0;

/// From this share of the radius on a surface is met from afar. The step costs a division.
const FAR: f64 = 0.5;

fn push<R: Real>(row: &Row, side: &Side, surfaces: &mut Vec<Surface<R::Scalar>>) {
    let &Side { row: place, advance, sign, n, n_after, spread, first, mirror, nm } = side;
    let curvature = sign * row.curvature();
    let n2_step = if mirror { 3.0 * n * n } else { n_after * n_after - n * n };
    let plain_stop = row.stop && row.curvature() == 0.0 && row.asphere.is_empty() && n2_step == 0.0;
    // The centre of a conic stands nearer to its vertex than a sphere's by this.
    let bulge = if row.asphere.is_empty() { (1.0 + row.conic).abs().max(1.0) } else { 1.0 };
    let far = bulge * (curvature * advance).abs() > FAR;
    // How far from the vertex rays are when they meet the formula.
    let half = row.diameter / 2.0;
    let from = match far {
        true => half + 2.0 * row.sag(half).abs(),
        false => {
            let [height, sag] = spread;
            let start = advance.abs().max((advance - sag).abs()).hypot(height);
            if first { start.max(half.hypot(row.sag(half))) } else { start }
        }
    };
    // The square of the normal component is a difference of G^2 and A F, of this size; an error
    // of it becomes one of its root behind the surface.
    let size = n * n * (1.0 + bulge * curvature.abs() * from).powi(2);
    let steep = first && row.slope(half).abs() > STEEP;
    let direction = if steep { DIRECTION / MAGNIFIED } else { DIRECTION };
    let doubt = (2.0 * R::EPSILON * size / (2.0 * direction)).powi(2);
    let surface = Surface {
        row: place,
        kind: match row {
            Row { ideal: Some(planes), .. } => {
                Kind::Ideal(Arc::new(Ideal::new::<R>(*planes, sign > 0.0, [n, n_after])))
            }
            _ if plain_stop => Kind::Stop,
            Row { axis: Some(axis), .. } => Kind::Cylinder(*axis),
            _ if !row.asphere.is_empty() => Kind::Asphere(Arc::new(Asphere::new::<R>(row, sign))),
            _ if row.conic != 0.0 && curvature != 0.0 => Kind::Conic(R::scalar(1.0 + row.conic)),
            _ => Kind::Sphere,
        },
        far,
        stop: row.stop,
        advance: R::scalar(advance),
        curvature: R::scalar(curvature),
        n2: R::scalar(n * n),
        n2_step: R::scalar(n2_step),
        aperture2: R::scalar((row.diameter / 2.0 * row.iris.reach()).powi(2)),
        limit: R::scalar((-n2_step).max(0.0)),
        doubt: R::scalar(doubt),
        mirror,
        coat: Coat::new::<R>(row.coating.unwrap_or_default(), [n, n_after], nm),
    };
    let beside = |kind: Kind<R::Scalar>| Surface {
        kind,
        advance: R::scalar(0.0),
        mirror: false,
        ..surface.clone()
    };
    let iris = (row.iris != Iris::Round)
        .then(|| beside(Kind::Iris(Arc::new(Shape::new::<R>(&row.iris, row.diameter)))));
    let disk = (row.obstruction > 0.0)
        .then(|| beside(Kind::Obstruction(R::scalar(row.obstruction * row.obstruction / 4.0))));
    surfaces.push(surface);
    surfaces.extend(iris);
    surfaces.extend(disk);
}
