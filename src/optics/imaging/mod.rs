//! Image quality of a lens by real rays: from an object point, through the vignetted pupil, to the
//! film.

pub(crate) mod aberration_fan;
mod aim;
pub(crate) mod axial;
pub(crate) mod chief;
pub(crate) mod conditions;
pub(crate) mod field_curve;
pub(crate) mod frozen_imaging;
mod frozen_pupil;
pub(crate) mod ghost_focus;
mod hexapolar_cell;
pub(crate) mod image_quality;
pub(crate) mod lens_at_wavelength;
pub(crate) mod point_image;
mod polynomial_map;
pub(crate) mod pupil_grid;
mod pupil_search;
pub(crate) mod reference_sphere;
pub(crate) mod seidel;
pub(crate) mod spot;
pub(crate) mod transfer;
mod vector;
pub(crate) mod zernike;
