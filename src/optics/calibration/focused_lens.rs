//! A lens in focus on a film.

use super::CalibrationSetup;
use super::pixel_grid::PixelGrid;
use super::ray_field::FieldRay;
use petzval_lens::{FocusError, FocusModel, Pose, Prescription};

/// A lens in focus on the film of a camera, with the stop and the groups as they are for the picture.
#[derive(Clone, Debug)]
pub struct FocusedLens {
    /// The lens.
    pub lens: Prescription,
    film_distance: f64,
    pixels: PixelGrid,
}

/// Why a lens cannot be focused on a film.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FocusedLensError {
    /// No place of the film or the groups is in focus.
    #[error(transparent)]
    Focus(#[from] FocusError),
    /// The film would stand inside the lens.
    #[error(
        "the film, {film:.4} mm behind the rear vertex, would stand inside the lens, which reaches {rim:.4} mm behind it; \
         focus nearer"
    )]
    Inside {
        /// Distance of the film behind the rear vertex (mm).
        film: f64,
        /// How far the lens reaches behind it (mm).
        rim: f64,
    },
}

impl FocusedLens {
    /// Focuses a lens at a distance from the film (mm). The picture uses the largest part of the film (mm) that has
    /// the aspect of its pixels.
    ///
    /// # Errors
    /// Returns an error if nothing is in focus, or if the film would stand inside the lens.
    pub fn new(
        lens: &Prescription,
        focus: f64,
        film: [f64; 2],
        resolution: [u32; 2],
    ) -> Result<Self, FocusedLensError> {
        let film = PixelGrid::used_part(resolution, film);
        let pixels = PixelGrid::new(resolution, film[0]);
        let diagonal = film[0].hypot(film[1]);
        let (lens, film_distance) = lens.focused(focus, FocusModel::Sharpest, diagonal)?;
        let rim = lens.rear_reach();
        match film_distance > rim {
            true => Ok(Self { lens, film_distance, pixels }),
            false => Err(FocusedLensError::Inside { film: film_distance, rim }),
        }
    }

    /// Returns the camera, whose pixels are seen by the centroids of their bundles.
    pub fn setup(&self) -> CalibrationSetup<'_> {
        CalibrationSetup {
            lens: &self.lens,
            film_distance: self.film_distance,
            film_pose: Pose::ALIGNED,
            pixels: self.pixels,
            ray: FieldRay::Centroid,
        }
    }
}
