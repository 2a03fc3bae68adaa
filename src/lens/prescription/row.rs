//! One row of a lens table: a surface and the medium behind it.

use super::coating::Coating;
use super::iris::Iris;
use super::pose::Pose;
use super::surface_aperture::SurfaceAperture;
use crate::focus::paraxial::RayTransferMatrix;
use petzval_spectrum::Glass;

/// An axis across the optical axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TransverseAxis {
    /// To the right as seen from behind the camera.
    X,
    /// Up.
    Y,
}

/// Section along x of a surface that differs from that along y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CrossSection {
    /// A biconic: z = (cx x^2 + cy y^2) / (1 + sqrt(1 - (1 + kx) cx^2 x^2 - (1 + ky) cy^2 y^2)),
    /// plus the asphere's polynomial in the distance from the axis (Zemax, surface type Biconic).
    Biconic {
        /// Radius of curvature along x (mm), infinite for none.
        radius: f64,
        /// Conic constant along x.
        conic: f64,
    },
    /// A toroid: the section along y, a conic plus the polynomial in |y|, rotated about an axis
    /// parallel to y (Zemax, surface type Toroidal).
    Toroid {
        /// Distance of that axis behind the vertex (mm), infinite for a cylinder.
        radius: f64,
    },
}

impl CrossSection {
    /// Returns the curvature along x at the vertex (1/mm).
    pub fn curvature(&self) -> f64 {
        let (Self::Biconic { radius, .. } | Self::Toroid { radius }) = self;
        radius.recip()
    }

    /// Returns the conic constant along x.
    pub fn conic(&self) -> f64 {
        match self {
            Self::Biconic { conic, .. } => *conic,
            Self::Toroid { .. } => 0.0,
        }
    }
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
    /// Powers p from 2 to 30, each at most once, and their coefficients a_p [mm^(1 - p)].
    pub asphere: Vec<(u32, f64)>,
    /// Section along x, if it differs from that along y: radius, conic constant and asphere are
    /// then those along y. Not together with `axis`.
    pub across: Option<CrossSection>,
    /// Axis along which a cylinder is straight; none for a surface of revolution.
    pub axis: Option<TransverseAxis>,
    /// Distance to the next vertex along +z (mm); unused in the last row.
    pub thickness: f64,
    /// Refractive index of the medium on the film side of the surface, at the d line.
    pub index: f64,
    /// Dispersion of that medium.
    pub glass: Glass,
    /// Clear diameter (mm).
    pub diameter: f64,
    /// Diameter of an opaque disk around the axis (mm); 0 for none.
    pub obstruction: f64,
    /// Rectangular, elliptical and decentred apertures and obscurations. Light passes all of them
    /// and the clear diameter.
    pub apertures: Vec<SurfaceAperture>,
    /// Whether this is the aperture stop.
    pub stop: bool,
    /// Shape of the opening, inside the clear diameter.
    pub iris: Iris,
    /// Whether the surface reflects; the media before and behind it are then the same, and the
    /// thicknesses of the rows behind it are negative up to the next mirror.
    pub mirror: bool,
    /// Coating, if the file states one; otherwise the surface is bare.
    pub coating: Option<Coating>,
    /// Tilt and decentre of this surface alone.
    pub pose: Pose,
    /// Ray-transfer matrices along x and y of an ideal lens that replaces the surface, for light on
    /// its way to the film, from the plane of the vertex to itself. The shape is then ignored.
    pub ideal: Option<[RayTransferMatrix; 2]>,
}

/// Most coefficients in a line of text.
const TERMS_A_LINE: usize = 4;

/// Formats a number with seven significant digits, without trailing zeros.
pub(crate) fn significant(value: f64) -> String {
    if value.is_infinite() {
        return "infinite".to_owned();
    }
    match value.abs() {
        size if size == 0.0 || (1e-3..1e6).contains(&size) => {
            let places = 6 - size.max(1e-3).log10().floor() as i32;
            let text = format!("{value:.*}", places.clamp(0, 9) as usize);
            match text.contains('.') {
                true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
                false => text,
            }
        }
        _ => {
            let text = format!("{value:.6e}");
            let (digits, power) = text.split_once('e').unwrap_or((&text, "0"));
            let digits = digits.trim_end_matches('0').trim_end_matches('.');
            format!("{digits}e{power}")
        }
    }
}

impl Default for Row {
    /// Returns a plane of diameter 0 in air.
    fn default() -> Self {
        Self {
            radius: f64::INFINITY,
            conic: 0.0,
            asphere: Vec::new(),
            across: None,
            axis: None,
            thickness: 0.0,
            index: 1.0,
            glass: Glass::Constant,
            diameter: 0.0,
            obstruction: 0.0,
            apertures: Vec::new(),
            stop: false,
            iris: Iris::Round,
            mirror: false,
            coating: None,
            pose: Pose::ALIGNED,
            ideal: None,
        }
    }
}

impl Row {
    /// Describes what the radius does not say about the shape: conic constants, coefficients of an
    /// asphere [mm^(1 - p)] and the section along x; no lines for a sphere.
    pub fn shape_lines(&self) -> Vec<String> {
        let mut lines = Vec::new();
        let conic = |k: f64| (k != 0.0).then(|| format!("conic {}", significant(k)));
        if let Some(across) = &self.across {
            let radius = significant(across.curvature().recip());
            lines.push(format!("radius {radius} along x; all other figures are along y"));
        }
        if let Some(axis) = self.axis {
            let name = if axis == TransverseAxis::X { "x" } else { "y" };
            lines.push(format!("a cylinder, straight along {name}"));
        }
        lines.extend(conic(self.conic));
        let terms = |(power, value): &(u32, f64)| format!("a{power} {}", significant(*value));
        let terms: Vec<String> = self.asphere.iter().map(terms).collect();
        lines.extend(terms.chunks(TERMS_A_LINE).map(|terms| terms.join(", ")));
        lines
    }

    /// Returns the curvature at the vertex (1/mm); 0 for a plane.
    pub fn curvature(&self) -> f64 {
        self.radius.recip()
    }

    /// Returns the curvatures at the vertex along x and y (1/mm), with the contribution of the
    /// square term of an asphere.
    pub fn curvatures(&self) -> [f64; 2] {
        let square: f64 = self.asphere.iter().filter(|(p, _)| *p == 2).map(|(_, a)| 2.0 * a).sum();
        let c = self.curvature() + square;
        match (self.axis, self.across) {
            (_, Some(CrossSection::Toroid { radius })) => [radius.recip(), c],
            (_, Some(CrossSection::Biconic { radius, .. })) => [radius.recip() + square, c],
            (None, None) => [c, c],
            (Some(TransverseAxis::X), None) => [0.0, c],
            (Some(TransverseAxis::Y), None) => [c, 0.0],
        }
    }

    /// Returns whether the surface is a plane.
    pub fn is_plane(&self) -> bool {
        let level = self.across.is_none_or(|across| across.curvature() == 0.0);
        self.radius.is_infinite() && self.asphere.is_empty() && level
    }

    /// Returns whether the surface is rotationally symmetric.
    pub fn is_round(&self) -> bool {
        let even = self.ideal.is_none_or(|[x, y]| x == y);
        self.axis.is_none() && self.across.is_none() && self.opening_is_round() && even
    }

    /// Returns whether the shape of the opening is rotationally symmetric.
    fn opening_is_round(&self) -> bool {
        self.iris == Iris::Round && self.apertures.is_empty()
    }

    /// Returns whether all of the clear diameter is open: no iris, obstruction or other aperture.
    pub fn is_unobstructed(&self) -> bool {
        self.opening_is_round() && self.obstruction == 0.0
    }

    /// Returns centre and half-widths (mm) of an ellipse around the open part of a surface, if an
    /// aperture bounds it.
    pub(crate) fn opening_ellipse(&self) -> Option<[[f64; 2]; 2]> {
        let aperture = self.apertures.iter().find(|aperture| !aperture.obscures)?;
        Some([aperture.centre, aperture.ellipse_around()])
    }

    /// Returns whether any of its apertures is the opaque arm of a spider.
    pub(crate) fn has_arms(&self) -> bool {
        self.apertures.iter().any(|aperture| aperture.is_arm(self.diameter / 2.0))
    }

    /// Removes the arms of spiders.
    pub(crate) fn remove_arms(&mut self) {
        let semi_diameter = self.diameter / 2.0;
        self.apertures.retain(|aperture| !aperture.is_arm(semi_diameter));
    }

    /// Opens all of the clear diameter.
    pub fn open_all(&mut self) {
        (self.iris, self.obstruction) = (Iris::Round, 0.0);
        self.apertures.clear();
    }

    /// Returns whether the surface differs along x and y.
    pub fn is_anamorphic(&self) -> bool {
        self.axis.is_some() || self.across.is_some()
    }

    /// Returns the diameter at which the surface is vertical (mm); infinite if it never is. Terms of
    /// an asphere are left out.
    pub fn edge(&self) -> f64 {
        let reach = |steep: f64| if steep > 0.0 { 2.0 / steep.sqrt() } else { f64::INFINITY };
        let along_y = reach((1.0 + self.conic) * self.curvature().powi(2));
        let along_x = self.across.map_or(f64::INFINITY, |across| {
            reach((1.0 + across.conic()) * across.curvature().powi(2))
        });
        along_y.min(along_x)
    }

    /// Returns the sag (mm) at a height `h` (mm): for a cylinder the height along its curved
    /// direction, for other surfaces that differ along x and y that of the two with the larger sag.
    /// Beyond the edge of a conic the sag is that of its edge.
    pub fn sag(&self, h: f64) -> f64 {
        let (along_x, along_y) = (self.sag_along_x(h), self.profile(h));
        if along_x.abs() > along_y.abs() { along_x } else { along_y }
    }

    /// Returns the derivative of the sag at height `h`, where it is largest around the axis;
    /// infinite at the edge of a conic and beyond.
    pub fn slope(&self, h: f64) -> f64 {
        let along_y = self.profile_slope(h);
        let along_x = if self.across.is_some() { self.gradient(h, 0.0)[0] } else { 0.0 };
        if along_x.abs() > along_y.abs() { along_x } else { along_y }
    }

    /// Returns the sag along x of a surface with a section of its own there, otherwise 0.
    fn sag_along_x(&self, h: f64) -> f64 {
        if self.across.is_some() { self.sag_at(h, 0.0) } else { 0.0 }
    }

    /// Returns the sag of the section along y.
    fn profile(&self, h: f64) -> f64 {
        let c = self.curvature();
        let root = (1.0 - (1.0 + self.conic) * c * c * h * h).max(0.0).sqrt();
        c * h * h / (1.0 + root) + self.polynomial(h)
    }

    /// Returns the derivative of the section along y.
    fn profile_slope(&self, h: f64) -> f64 {
        let c = self.curvature();
        let root = (1.0 - (1.0 + self.conic) * c * c * h * h).max(0.0).sqrt();
        c * h / root + self.polynomial_slope(h)
    }

    fn polynomial(&self, h: f64) -> f64 {
        self.asphere.iter().map(|&(p, a)| a * h.powi(p as i32)).sum()
    }

    fn polynomial_slope(&self, h: f64) -> f64 {
        let term = |&(p, a): &(u32, f64)| f64::from(p) * a * h.powi(p as i32 - 1);
        self.asphere.iter().map(term).sum()
    }

    /// Returns the sag (mm) at a point (mm).
    pub fn sag_at(&self, x: f64, y: f64) -> f64 {
        match (self.axis, self.across) {
            (_, Some(CrossSection::Biconic { radius, conic })) => {
                let [cx, cy] = [radius.recip(), self.curvature()];
                let across =
                    (1.0 + conic) * (cx * x).powi(2) + (1.0 + self.conic) * (cy * y).powi(2);
                let root = (1.0 - across).max(0.0).sqrt();
                (cx * x * x + cy * y * y) / (1.0 + root) + self.polynomial(x.hypot(y))
            }
            (_, Some(CrossSection::Toroid { radius })) => {
                let (c, curve) = (radius.recip(), self.profile(y.abs()));
                let arm = 1.0 - c * curve;
                let root = (arm * arm - (c * x).powi(2)).max(0.0).sqrt();
                // At x = 0 the sag is that of the curve, even at its centre of rotation.
                if x == 0.0 { curve } else { curve + c * x * x / (arm + root) }
            }
            (None, None) => self.profile(x.hypot(y)),
            (Some(TransverseAxis::X), None) => self.profile(y),
            (Some(TransverseAxis::Y), None) => self.profile(x),
        }
    }

    /// Returns the derivatives of [`Self::sag_at`] with respect to x and y.
    pub fn gradient(&self, x: f64, y: f64) -> [f64; 2] {
        let h = x.hypot(y);
        match (self.axis, self.across) {
            (_, Some(CrossSection::Biconic { radius, conic })) => {
                let [cx, cy] = [radius.recip(), self.curvature()];
                let [ex, ey] = [(1.0 + conic) * cx, (1.0 + self.conic) * cy];
                let root = (1.0 - ex * cx * x * x - ey * cy * y * y).max(0.0).sqrt();
                let base = (cx * x * x + cy * y * y) / (1.0 + root);
                let terms = if h > 0.0 { self.polynomial_slope(h) / h } else { 0.0 };
                let along = |v: f64, c: f64, e: f64| {
                    v * (c * (2.0 + base * e / root) / (1.0 + root) + terms)
                };
                [along(x, cx, ex), along(y, cy, ey)]
            }
            (_, Some(CrossSection::Toroid { radius })) => {
                let (c, curve) = (radius.recip(), self.profile(y.abs()));
                let arm = 1.0 - c * curve;
                let root = (arm * arm - (c * x).powi(2)).max(0.0).sqrt();
                [c * x / root, y.signum() * arm * self.profile_slope(y.abs()) / root]
            }
            (None, None) if h > 0.0 => [x, y].map(|v| self.profile_slope(h) * v / h),
            (None, None) => [0.0; 2],
            (Some(TransverseAxis::X), None) => [0.0, self.profile_slope(y)],
            (Some(TransverseAxis::Y), None) => [self.profile_slope(x), 0.0],
        }
    }
}
