//! Surfaces prepared for tracing in one direction.

use std::sync::Arc;

use super::asphere::Asphere;
use super::biradial::Biradial;
use super::frame_transform::FrameTransform;
use super::ideal::Ideal;
use super::polynomial::Polynomial;
use super::stop::{ApertureShape, ClipShape};
use crate::prescription::coating::{Coating, CoatingModel};
use crate::prescription::iris::Iris;
use crate::prescription::{Row, TransverseAxis};
use petzval_base::lanes::Real;

/// Kernel that takes a ray to a surface and through it.
#[derive(Clone, Debug)]
pub enum SurfaceKind<T> {
    /// A plane that only clips.
    Stop,
    /// A sphere or a plane.
    Sphere,
    /// A conic of revolution, with 1 + k.
    Conic(T),
    /// A circular cylinder that is straight along this axis.
    Cylinder(TransverseAxis),
    /// A conic of revolution plus a polynomial.
    Asphere(Arc<Asphere<T>>),
    /// A biconic or a toroid, plus a polynomial.
    Biradial(Arc<Biradial<T>>),
    /// A plane at which rays change by first-order optics.
    Ideal(Arc<Ideal<T>>),
    /// All surfaces since the previous entry, as polynomials.
    Polynomial(Arc<Polynomial<T>>),
    /// Shape of the opening, in the plane of the stop crossed before.
    Iris(Arc<ApertureShape<T>>),
    /// An opaque disk on the surface crossed before, with the square of its radius [mm^2].
    Obstruction(T),
    /// A rectangle or ellipse on the surface crossed before.
    Clip(Arc<ClipShape<T>>),
    /// No surface, but the change from the frame of the surface crossed before to that of the next,
    /// if they are tilted or decentred to each other.
    FrameTransform(Arc<FrameTransform<T>>),
}

/// One surface in the frame of a ray: +z is the direction of travel, lengths are in mm.
#[derive(Clone, Debug)]
pub struct Surface<T> {
    /// Row of the prescription, from 0 at the scene side.
    pub row: usize,
    /// Kernel.
    pub kind: SurfaceKind<T>,
    /// Whether rays go to the plane of the vertex first, because they come from so far that G may
    /// change sign on the way (a ball lens) and its square would dwarf the normal component.
    pub far: bool,
    /// Whether rays may come from behind the plane of the vertex: the front surface of a lens that
    /// may see beyond 90 degrees, met from the scene.
    pub entrance: bool,
    /// Whether the rim is that of the aperture stop.
    pub stop: bool,
    /// Distance from the vertex crossed before to this one.
    pub advance: T,
    /// Curvature at the vertex, positive if the centre lies ahead.
    pub curvature: T,
    /// n^2, with n the index on the side that rays come from.
    pub n2: T,
    /// n'^2 - n^2: the increase of xi^2 by refraction.
    pub n2_step: T,
    /// Square of the semi-diameter.
    pub aperture2: T,
    /// xi^2 before refraction at which a ray is totally reflected or tangent.
    pub limit: T,
    /// Distance of xi^2 from the limit within which this precision cannot be trusted.
    pub uncertainty: T,
    /// Whether the surface reflects. Then `n2_step` is not that of the media but one that reveals
    /// the normal of the kernel, and the following surfaces are met in the other direction.
    pub mirror: bool,
    /// Absorption coefficient of the medium before the surface (1/mm); none if it absorbs nothing.
    pub absorption: Option<T>,
    /// Transmittance and reflectance.
    pub coating: CoatingModel<T>,
}

/// Makes surfaces that block no ray, however far from their vertices it meets them.
pub fn open_surfaces(surfaces: &mut Vec<Surface<f64>>) {
    surfaces.retain(|surface| {
        use SurfaceKind::{Clip, Iris, Obstruction};
        !matches!(surface.kind, Iris(_) | Obstruction(_) | Clip(_))
    });
    surfaces.iter_mut().for_each(|surface| surface.aperture2 = f64::MAX);
}

/// The way in which rays come to a row.
pub(super) struct Approach {
    pub row: usize,
    pub advance: f64,
    /// 1 for rays that go to the film, -1 for rays that come from it.
    pub sign: f64,
    /// Index before the surface.
    pub n: f64,
    /// Index behind the surface.
    pub n_after: f64,
    /// Greatest height of the rays where they start, and their greatest z there, relative to the
    /// vertex crossed before.
    pub spread: [f64; 2],
    /// Whether this is the first row: rays start anywhere and are aimed at all of its rim.
    pub first: bool,
    pub mirror: bool,
    /// Absorption coefficient of the medium before the surface (1/mm).
    pub absorption: f64,
    /// Wavelength for the coating (nm).
    pub nm: f64,
}

/// Permitted error of the direction behind a surface by the bound below (rad). The bound is
/// pessimistic: a ball lens next to total reflection, at this limit, is off by 4 urad.
const MAX_DIRECTION_ERROR: f64 = 2e-6;

/// Slope of the rim (52 degrees) beyond which rays from the film may graze the first surface. Their
/// rounding errors there are magnified if they come near total reflection later.
const STEEP_SLOPE: f64 = 1.3;
/// Factor by which the permitted error is smaller for such a surface.
const GRAZING_MAGNIFICATION: f64 = 3.0;

/// Ratio of the distance to the radius beyond which a surface is met from afar. The additional step
/// costs a division.
const FAR: f64 = 0.5;

/// Appends a row to a sequence: its surface, then its iris, its obstruction and its apertures, if any.
pub(super) fn push<R: Real>(
    row: &Row,
    approach: &Approach,
    surfaces: &mut Vec<Surface<R::Scalar>>,
) {
    let &Approach { row: index, advance, sign, n, n_after, spread, first, mirror, absorption, nm } =
        approach;
    let curvature = sign * row.curvature();
    let n2_step = if mirror { 3.0 * n * n } else { n_after * n_after - n * n };
    let plain_stop = row.stop && row.is_plane() && n2_step == 0.0;
    // The centre of a conic is nearer to its vertex than that of a sphere by this factor.
    let quadric = row.asphere.is_empty() && row.across.is_none();
    let bulge = if quadric { (1.0 + row.conic).abs().max(1.0) } else { 1.0 };
    let bend = row.across.map_or(0.0, |across| across.curvature().abs()).max(curvature.abs());
    let far = bulge * (bend * advance).abs() > FAR;
    // Distance from the vertex at which rays enter the formula.
    let half = row.diameter / 2.0;
    let from = match far {
        true => half + 2.0 * row.sag(half).abs(),
        false => {
            let [height, sag] = spread;
            let start = advance.abs().max((advance - sag).abs()).hypot(height);
            if first { start.max(half.hypot(row.sag(half))) } else { start }
        }
    };
    // xi^2 is a difference of G^2 and A F, which have this size; the error of xi^2 becomes one of
    // its root behind the surface.
    let size = n * n * (1.0 + bulge * bend * from).powi(2);
    let steep = first && row.slope(half).abs() > STEEP_SLOPE;
    let direction =
        if steep { MAX_DIRECTION_ERROR / GRAZING_MAGNIFICATION } else { MAX_DIRECTION_ERROR };
    let uncertainty = (2.0 * R::EPSILON * size / (2.0 * direction)).powi(2);
    let surface = Surface {
        row: index,
        kind: match row {
            Row { ideal: Some(planes), .. } => {
                SurfaceKind::Ideal(Arc::new(Ideal::new::<R>(*planes, sign > 0.0, [n, n_after])))
            }
            _ if plain_stop => SurfaceKind::Stop,
            Row { across: Some(across), .. } => {
                SurfaceKind::Biradial(Arc::new(Biradial::new::<R>(row, *across, sign)))
            }
            Row { axis: Some(axis), .. } => SurfaceKind::Cylinder(*axis),
            _ if !row.asphere.is_empty() => {
                SurfaceKind::Asphere(Arc::new(Asphere::new::<R>(row, sign)))
            }
            _ if row.conic != 0.0 && curvature != 0.0 => {
                SurfaceKind::Conic(R::from_f64(1.0 + row.conic))
            }
            _ => SurfaceKind::Sphere,
        },
        far,
        entrance: first && sign > 0.0 && curvature > 0.0 && !far && !mirror,
        stop: row.stop,
        advance: R::from_f64(advance),
        curvature: R::from_f64(curvature),
        n2: R::from_f64(n * n),
        n2_step: R::from_f64(n2_step),
        aperture2: R::from_f64((row.diameter / 2.0 * row.iris.reach()).powi(2)),
        limit: R::from_f64((-n2_step).max(0.0)),
        uncertainty: R::from_f64(uncertainty),
        mirror,
        absorption: (absorption > 0.0).then(|| R::from_f64(absorption)),
        coating: CoatingModel::new::<R>(
            row.coating.as_ref().unwrap_or(&Coating::Bare),
            [n, n_after],
            nm,
        ),
    };
    let at_same_place = |kind: SurfaceKind<R::Scalar>| Surface {
        kind,
        advance: R::from_f64(0.0),
        mirror: false,
        absorption: None,
        ..surface.clone()
    };
    let iris = (row.iris != Iris::Round).then(|| {
        let shape = ApertureShape::new::<R>(&row.iris, row.diameter);
        at_same_place(SurfaceKind::Iris(Arc::new(shape)))
    });
    let obstruction = (row.obstruction > 0.0).then(|| {
        let radius2 = row.obstruction * row.obstruction / 4.0;
        at_same_place(SurfaceKind::Obstruction(R::from_f64(radius2)))
    });
    let apertures: Vec<_> = row
        .apertures
        .iter()
        .map(|aperture| at_same_place(SurfaceKind::Clip(Arc::new(ClipShape::new::<R>(aperture)))))
        .collect();
    surfaces.push(surface);
    surfaces.extend(iris);
    surfaces.extend(obstruction);
    surfaces.extend(apertures);
}
