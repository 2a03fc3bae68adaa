//! Focus of a real lens: the place of its film.

use glam::DAffine3;

use super::{Changes, FocusOn, PrepareError};
use crate::film::Frame;
use petzval_base::io::Location;
use petzval_base::rays::{NO_INDEX, RayBatch};
use petzval_lens::{Camera, FilmPlane, FocusError, LensModel, Pose, Prescription, RealLens};
use petzval_scene::{Scene, TraversalStack};

/// Place of the film as a scene file gives it.
#[derive(Clone, Copy, Debug)]
pub(super) enum FilmPlacement {
    /// The distance from the film to the plane in focus (m).
    FocusedAt(f64),
    /// The distance from the rear vertex to the film (mm).
    Distance(f64),
}

/// Puts the film behind a lens.
pub(super) struct FilmPlacer<'a> {
    pub prescription: &'a Prescription,
    pub film_pose: Pose,
    /// The size of the film (mm).
    pub film_size: [f64; 2],
    /// The diagonal of the film that the scene file gives (mm).
    pub diagonal: f64,
    /// The length of a millimetre in units of the camera.
    pub unit: f64,
    /// Whether the origin of the camera is the film. Otherwise it is the front vertex.
    pub origin_at_film: bool,
    pub imaging_ratio: f64,
    pub depth: [f64; 2],
    pub changes: &'a Changes,
    pub view: &'a View<'a>,
    /// The place of the camera in the scene file.
    pub camera_at: Location,
}

impl FilmPlacer<'_> {
    /// Returns the lens with its film where the changes ask for it, or else where the scene file says.
    ///
    /// # Errors
    /// Returns an error if the lens cannot focus there or the film would stand inside the lens.
    pub fn focus(&self, placement: FilmPlacement) -> Result<RealLens, PrepareError> {
        let unchanged = || match placement {
            FilmPlacement::FocusedAt(metres) => self.focused_at(metres),
            FilmPlacement::Distance(film) => self.lens_at(self.prescription, film),
        };
        match self.changes.focus {
            None => unchanged(),
            Some(FocusOn::Distance(metres)) => self.focused_at(metres),
            Some(FocusOn::Pixel(pixel)) => {
                let mut lens = unchanged()?;
                // The view changes a little with the focus, so the second step looks from the film
                // of the first.
                for _ in 0..2 {
                    let camera = Camera {
                        model: LensModel::Real(Box::new(lens)),
                        film: self.film_size,
                        world_from_camera: self.view.world_from_camera,
                        imaging_ratio: self.imaging_ratio,
                        depth: self.depth,
                    };
                    let depth = self.view.depth(&camera, pixel)?;
                    lens = self.focused_at(depth * 1e-3 / self.unit)?;
                }
                Ok(lens)
            }
        }
    }

    /// Returns the lens focused on a plane at a distance from the film (m): by the groups that its
    /// file moves, otherwise by the film.
    fn focused_at(&self, metres: f64) -> Result<RealLens, PrepareError> {
        let Self { prescription, diagonal, .. } = *self;
        let (focus, model) = (metres * 1e3, self.changes.focus_model);
        let refused = |error: FocusError| self.error(error.to_string());
        let (moved, film_distance) =
            prescription.focused(focus, model, diagonal).map_err(refused)?;
        self.lens_at(&moved, film_distance)
    }

    fn lens_at(
        &self,
        prescription: &Prescription,
        film_distance: f64,
    ) -> Result<RealLens, PrepareError> {
        let Self { film_pose, film_size: size, diagonal, unit, .. } = *self;
        let rim = prescription.rear_reach();
        let corner = |x: f64, y: f64| film_pose.film_point([x * size[0], y * size[1]])[2];
        let ahead = corner(0.5, 0.5).abs().max(corner(0.5, -0.5).abs());
        let nearest = film_distance - ahead;
        if nearest <= rim {
            let tilted = if ahead > 0.0 { " where it is nearest" } else { "" };
            return Err(self.error(format!(
                "the film, {nearest:.4} mm behind the rear vertex{tilted}, would stand inside the \
                 lens, which reaches {rim:.4} mm behind it; focus nearer"
            )));
        }
        let front = match self.origin_at_film {
            true => prescription.film_position(film_distance) * unit,
            false => 0.0,
        };
        let View { frame, filter_reach, .. } = self.view;
        let beyond = [0, 1].map(|i| filter_reach[i] * size[i] / f64::from(frame.resolution[i]));
        let radius = diagonal / 2.0 + beyond[0].hypot(beyond[1]);
        let half = [0, 1].map(|i| size[i] / 2.0 + beyond[i]);
        let film = FilmPlane { distance: film_distance, pose: film_pose, radius, half };
        Ok(RealLens::with_film(prescription.clone(), &film, self.changes.aim, unit, front))
    }

    fn error(&self, problem: String) -> PrepareError {
        PrepareError::Camera { at: self.camera_at.clone(), problem }
    }
}

/// The scene as the camera sees it.
#[derive(Clone, Copy)]
pub(super) struct View<'a> {
    pub scene: &'a Scene,
    /// The time, as a share of the motion.
    pub time: f32,
    pub world_from_camera: DAffine3,
    pub frame: &'a Frame,
    /// How far samples lie beyond the edge of the picture (pixels).
    pub filter_reach: [f64; 2],
}

impl View<'_> {
    /// Returns the depth, before the film plane and in units of the camera, of the surface that a
    /// pixel sees through the middle of the pupil; infinity if it sees none. The default pixel is the
    /// middle of the picture.
    ///
    /// # Errors
    /// Returns an error if the pixel is outside the picture or vignetted.
    pub fn depth(&self, camera: &Camera, pixel: Option<[u32; 2]>) -> Result<f64, PrepareError> {
        let resolution = self.frame.resolution;
        let pixel = pixel.unwrap_or(resolution.map(|n| n / 2));
        let [x, y] = pixel;
        if (0..2).any(|i| pixel[i] >= resolution[i]) {
            return Err(PrepareError::Request(format!(
                "'focus' on the pixel {x},{y}: the picture has {} x {} pixels, counted from 0",
                resolution[0], resolution[1]
            )));
        }
        let mut rays = RayBatch::default();
        camera.central_ray(pixel, resolution, &mut rays);
        if rays.len == 0 {
            return Err(PrepareError::Request(format!(
                "'focus' on the pixel {x},{y}: no light comes through the middle of the lens to this pixel"
            )));
        }
        let ray = rays.ray(0);
        let hit = self.scene.closest_at::<f32>(&ray, self.time, &mut TraversalStack::default());
        let point = [0, 1, 2]
            .map(|i| f64::from(ray.origin[i]) + f64::from(hit.t) * f64::from(ray.direction[i]));
        let depth = self.world_from_camera.inverse().transform_point3(point.into()).z;
        let depth = depth + camera.film_depth();
        Ok(if hit.shape == NO_INDEX || depth <= 0.0 { f64::INFINITY } else { depth })
    }
}
