//! Limits of the errors of a lens, and grades of them.

/// Limit of the errors of a radius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RadiusLimit {
    /// Share of the radius (percent); planes are exact.
    Percent(f64),
    /// Fringe spacings over the clear diameter (ISO 10110-5): half a wavelength of sag each, at
    /// [`FRINGE_WAVELENGTH`].
    Fringes(f64),
}

/// Wavelength of the fringes of ISO 10110-5, line e (nm).
pub const FRINGE_WAVELENGTH: f64 = 546.074;

/// Largest errors of the quantities of a lens, to either side; 0 for none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToleranceLimits {
    /// Radii of curvature.
    pub radius: RadiusLimit,
    /// Thicknesses of elements and of the gaps between them (mm).
    pub thickness: f64,
    /// Refractive indices.
    pub index: f64,
    /// Abbe numbers (percent).
    pub abbe: f64,
    /// Tilts of elements about x and about y (arc minutes).
    pub tilt: f64,
    /// Decentres of elements along x and along y (mm).
    pub decentre: f64,
    /// Tilts of surfaces against the first of their element, about x and about y: wedges (arc
    /// minutes).
    pub wedge: f64,
}

/// A grade of manufacture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ToleranceGrade {
    /// No errors.
    None,
    /// The usual work of a workshop without special requirements.
    Commercial,
    /// Common for photographic and scientific lenses.
    Precision,
    /// About the best that is made in series.
    High,
}

impl ToleranceGrade {
    /// All grades, with their names.
    pub const NAMES: [(&str, Self); 4] = [
        ("none", Self::None),
        ("commercial", Self::Commercial),
        ("precision", Self::Precision),
        ("high", Self::High),
    ];

    /// Returns the limits of the grade.
    ///
    /// Radii, thicknesses, indices and Abbe numbers are typical of the columns commercial, precision
    /// and high precision of makers' charts, such as that of Optimax Systems, and were not checked
    /// against its present edition. High precision glass is often melt-controlled, without a number:
    /// ours is 2e-4 in nd and 0.2 % in vd. The wedge is a difference of edge thickness of 0.05, 0.01
    /// and 0.002 mm over a diameter of 25 mm. Tilt and decentre belong to the mount, of which the chart
    /// says nothing: these are values of our own for loose, fitted and aligned seats.
    pub fn limits(self) -> ToleranceLimits {
        let (percent, thickness, index, abbe, tilt, decentre, wedge) = match self {
            Self::None => (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
            Self::Commercial => (0.2, 0.15, 1e-3, 0.8, 3.0, 0.05, 6.9),
            Self::Precision => (0.1, 0.05, 5e-4, 0.5, 1.0, 0.02, 1.4),
            Self::High => (0.05, 0.01, 2e-4, 0.2, 0.5, 0.005, 0.28),
        };
        let radius = RadiusLimit::Percent(percent);
        ToleranceLimits { radius, thickness, index, abbe, tilt, decentre, wedge }
    }
}
