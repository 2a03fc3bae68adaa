//! Conditions of an analysis: object, film, wavelengths and field.

use super::lens_at_wavelength::LensAtWavelength;
use petzval_lens::Prescription;
use petzval_lens::RealRayFocus;
use petzval_lens::Vignetting;
use petzval_lens::{FieldKind, SpectralLine};
use petzval_lens::{FocusError, Paraxial};
use petzval_spectrum::IndexRangeError;

/// Wavelengths for a lens whose file states none: the lines g, F, e, d, C, of equal weight (nm).
const VISIBLE: [f64; 5] = [435.8343, 486.1327, 546.074, 587.5618, 656.2725];
/// Line d among them.
const VISIBLE_PRIMARY: usize = 3;

/// Rays for the end of the light.
const LIGHT_RAYS: u32 = 1 << 12;
/// Largest field relative to the end of the light.
const LIT: f64 = 0.95;

/// F-number from which a lens counts as afocal: its focal length is rounding.
const AFOCAL: f64 = 1e7;

/// Conditions under which a lens is analysed.
#[derive(Clone, Debug, PartialEq)]
pub struct ImagingConditions {
    /// Distance from the object to the front vertex (mm), infinite for a distant object.
    pub object_distance: f64,
    /// Distance from the rear vertex to the film along the way of the light (mm).
    pub film_distance: f64,
    /// Wavelengths and their weights.
    pub wavelengths: Vec<SpectralLine>,
    /// Index of the primary wavelength.
    pub primary: usize,
    /// Meaning of the field coordinates.
    pub field_kind: FieldKind,
    /// Largest field, along y: degrees, or mm of object or image height.
    pub largest_field: f64,
    /// Field points of the lens file, as distances from the axis in the order of the file; empty
    /// if it states none.
    pub stated_fields: Vec<f64>,
    /// Whether the lens file states fields from which no light reaches the film, so that others are
    /// used.
    pub fields_replaced: bool,
}

/// Choices of the user; what is not chosen comes from the lens file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ConditionChoices {
    /// Distance from the film to the object (mm), infinite for a distant object.
    pub focus: Option<f64>,
    /// Distance from the rear vertex to the film (mm).
    pub film_distance: Option<f64>,
    /// Largest image height (mm).
    pub image_height: Option<f64>,
}

/// Why a lens cannot be analysed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ConditionsError {
    /// The film has no position.
    #[error("{source}\nthe lens file gives no film position either; give it with 'film_distance'")]
    Focus {
        /// Why the lens cannot be focused.
        source: FocusError,
    },
    /// A glass has no data at a wavelength.
    #[error("{0}")]
    Index(#[from] IndexRangeError),
    /// A distant object has no image.
    #[error(
        "the lens has no power at {nm} nm: light of a distant object leaves it parallel and has no \
         image; give an object distance with 'distance'"
    )]
    Afocal {
        /// The primary wavelength.
        nm: f64,
    },
    /// An ideal row stands for a lens group.
    #[error(
        "row {row} is an ideal lens, which has no aberrations; an analysis needs real surfaces"
    )]
    Ideal {
        /// The row, from 1.
        row: usize,
    },
}

impl ImagingConditions {
    /// Half the diagonal of a 36 x 24 mm film, the largest image height for a file without fields
    /// whose light reaches so far (mm).
    pub const FULL_FRAME: f64 = 21.633_307_652_783_937;

    /// Collects the conditions of a lens: choices, then the statements of its file, then a distant
    /// object on the film where real rays are sharpest.
    ///
    /// # Errors
    /// Returns an error if no film position is known, if the lens has ideal rows, if it has no power
    /// and the object is distant, or if a glass has no data at the primary wavelength.
    pub fn new(lens: &Prescription, choices: ConditionChoices) -> Result<Self, ConditionsError> {
        if let Some(row) = lens.rows.iter().position(|row| row.ideal.is_some()) {
            return Err(ConditionsError::Ideal { row: row + 1 });
        }
        let design = &lens.design;
        let focus_error = |source| ConditionsError::Focus { source };
        let focus = RealRayFocus::new(lens);
        let sharpest = |distance: f64| focus.film_distance(distance).map_err(focus_error);
        let stated_object = design.object_distance.filter(|distance| *distance > 0.0);
        let (film_distance, object_distance) = match (choices.film_distance, choices.focus) {
            (Some(film), None) => (film, stated_object.unwrap_or(f64::INFINITY)),
            (film, Some(asked)) => {
                let film = film.map_or_else(|| sharpest(asked), Ok)?;
                (film, asked - lens.film_position(film))
            }
            (None, None) => {
                let object = stated_object.unwrap_or(f64::INFINITY);
                let film = match design.film_distance.filter(|film| *film > 0.0) {
                    Some(film) => film,
                    None => focus.image_distance(object).map_or_else(|| sharpest(object), Ok)?,
                };
                (film, object)
            }
        };
        let (wavelengths, primary) = Self::wavelengths(lens);
        let nm = wavelengths[primary].nm;
        let paraxial = Paraxial::new(&lens.at_wavelength(nm)?);
        if object_distance.is_infinite() && paraxial.f_number() > AFOCAL {
            return Err(ConditionsError::Afocal { nm });
        }
        let mut conditions = Self {
            object_distance,
            film_distance,
            wavelengths,
            primary,
            field_kind: FieldKind::ImageHeight,
            largest_field: Self::FULL_FRAME,
            stated_fields: Vec::new(),
            fields_replaced: false,
        };
        conditions.choose_field(lens, choices.image_height);
        Ok(conditions)
    }

    /// Returns the wavelengths of a lens: those of its file, otherwise five across the visible
    /// range, or one if no medium disperses.
    fn wavelengths(lens: &Prescription) -> (Vec<SpectralLine>, usize) {
        let design = &lens.design;
        let line = |nm: f64| SpectralLine { nm, weight: 1.0 };
        if !design.wavelengths.is_empty() {
            return (design.wavelengths.clone(), design.primary);
        }
        let visible: Vec<SpectralLine> = VISIBLE.map(line).to_vec();
        let covered = lens.check_wavelengths([VISIBLE[0], VISIBLE[4]]).is_ok();
        match covered && !lens.is_monochromatic() {
            true => (visible, VISIBLE_PRIMARY),
            false => (vec![line(design.primary_wavelength())], 0),
        }
    }

    fn choose_field(&mut self, lens: &Prescription, image_height: Option<f64>) {
        if let Some(height) = image_height {
            self.largest_field = height;
            return;
        }
        let light = Vignetting::new(lens, self.film_distance, LIGHT_RAYS);
        if self.take_stated_fields(lens, &light) {
            return;
        }
        self.fields_replaced = lens.design.fields.is_some();
        // A lens for a smaller film is dark beyond it.
        if let Some(end) = light.light_radius(Self::FULL_FRAME).filter(|end| *end > 0.0) {
            self.largest_field = LIT * end;
        }
    }

    /// Takes the fields of the lens file, if it states any and light of all of them reaches the
    /// film: those of a zoom lens may be of another state.
    fn take_stated_fields(&mut self, lens: &Prescription, light: &Vignetting) -> bool {
        let Some(fields) = &lens.design.fields else { return false };
        let radii: Vec<f64> = fields.points.iter().map(|[x, y]| x.hypot(*y)).collect();
        let largest = radii.iter().copied().fold(0.0, f64::max);
        let near = self.object_distance.is_finite();
        if largest == 0.0 || (!near && fields.kind == FieldKind::ObjectHeight) {
            return false;
        }
        let stated = Self {
            field_kind: fields.kind,
            largest_field: largest,
            stated_fields: radii,
            ..self.clone()
        };
        let chief = LensAtWavelength::new(lens, &stated, stated.primary)
            .ok()
            .and_then(|lens| lens.chief_of_field(&stated, [0.0, largest]));
        let lit = chief.is_some_and(|chief| light.is_lit(chief.film));
        if lit {
            *self = stated;
        }
        lit
    }

    /// Returns the primary wavelength.
    pub fn primary_line(&self) -> SpectralLine {
        self.wavelengths[self.primary]
    }

    /// Returns the wavelengths with the smallest and the largest wavelength (indices).
    pub fn spectral_ends(&self) -> [usize; 2] {
        let by_nm =
            |a: &usize, b: &usize| self.wavelengths[*a].nm.total_cmp(&self.wavelengths[*b].nm);
        let all = || 0..self.wavelengths.len();
        [all().min_by(by_nm).unwrap_or(0), all().max_by(by_nm).unwrap_or(0)]
    }

    /// Returns first-order data at every wavelength.
    ///
    /// # Errors
    /// Returns an error if a glass has no data at a wavelength.
    pub fn first_order(&self, lens: &Prescription) -> Result<Vec<Paraxial>, IndexRangeError> {
        self.wavelengths
            .iter()
            .map(|line| Ok(Paraxial::new(&lens.at_wavelength(line.nm)?)))
            .collect()
    }
}
