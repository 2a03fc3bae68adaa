//! The plane in focus of a camera and its place in the picture.

use petzval_optics::Calibration;

/// Least shorter side of a picture with edges (pixels): squares and their regions take a seventh of it.
pub(super) const MIN_EDGES: u32 = 400;
/// Least shorter side of a picture with dots (pixels), which are 10 pixels apart then.
pub(super) const MIN_GRID: u32 = 120;

/// Least shorter side of a picture with leaves (pixels), which take half of it.
pub(super) const MIN_LEAVES: u32 = 200;

/// Least shorter side of a picture with a star (pixels), whose lowest frequency is a ninth of a cycle a pixel then.
pub(super) const MIN_STAR: u32 = 240;

/// Why a chart cannot be drawn.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ChartError {
    /// Infinity is in focus.
    #[error("a chart stands in the plane in focus; expected a finite 'focus', such as 2m")]
    Infinite,
    /// No light reaches a part of the film.
    #[error(
        "no chart fills the picture: no light reaches pixel {x:.0},{y:.0}; choose a smaller 'film-size'"
    )]
    Dark {
        /// Column.
        x: f64,
        /// Row.
        y: f64,
    },
    /// The camera sees more than a plane can show.
    #[error(
        "no flat chart fills the picture: pixel {x:.0},{y:.0} shows a ray {angle:.0} degrees from the axis; expected at \
         most 75 degrees: choose a smaller 'film-size'"
    )]
    Oblique {
        /// Column.
        x: f64,
        /// Row.
        y: f64,
        /// Angle to the axis (degrees).
        angle: f64,
    },
    /// The picture has too few pixels.
    #[error(
        "this chart needs pictures of at least {least} x {least} pixels; found {width} x {height}"
    )]
    Small {
        /// Least width and height (pixels).
        least: u32,
        /// Width (pixels).
        width: u32,
        /// Height (pixels).
        height: u32,
    },
}

/// The plane in focus of a camera, as its picture shows it.
#[derive(Clone, Copy, Debug)]
pub struct ChartView<'a> {
    calibration: &'a Calibration,
}

impl<'a> ChartView<'a> {
    /// Returns the view of a camera.
    ///
    /// # Errors
    /// Returns an error if infinity is in focus.
    pub fn new(calibration: &'a Calibration) -> Result<Self, ChartError> {
        match calibration.focus.is_finite() {
            true => Ok(Self { calibration }),
            false => Err(ChartError::Infinite),
        }
    }

    /// Returns width and height of the picture (pixels).
    pub(super) fn resolution(&self) -> [u32; 2] {
        self.calibration.pixels.resolution
    }

    /// Checks that the picture is large enough (pixels).
    pub(super) fn check_size(&self, least: u32) -> Result<(), ChartError> {
        let [width, height] = self.resolution();
        match width.min(height) >= least {
            true => Ok(()),
            false => Err(ChartError::Small { least, width, height }),
        }
    }

    /// Returns the diagonal of the film (mm).
    pub(super) fn film_diagonal(&self) -> f64 {
        2.0 * self.calibration.pixels.half_diagonal()
    }

    /// Returns the distance of the chart from the film plane (mm).
    pub(super) fn distance(&self) -> f64 {
        self.calibration.focus
    }

    /// Returns the point of the chart (mm from the axis, x to the right and y up) that a point of the picture shows
    /// (pixels, the centre of the first at 0).
    ///
    /// # Errors
    /// Returns an error if it shows none.
    pub fn chart_point(&self, pixel: [f64; 2]) -> Result<[f64; 2], ChartError> {
        let [x, y] = pixel.map(|at| at.max(0.0));
        let ray = self.calibration.scene_ray(pixel).ok_or(ChartError::Dark { x, y })?;
        let angle = ray.angle().to_degrees();
        if angle > 75.0 {
            return Err(ChartError::Oblique { x, y, angle });
        }
        let along = (self.distance() - ray.point.z) / ray.direction.z;
        let at = ray.point + along * ray.direction;
        Ok([at.x, -at.y])
    }

    /// Returns the points of the chart that the corners of a rectangle of the picture show: lower left, lower right,
    /// upper right, upper left. `low` and `high` are its upper left and its lower right (pixels).
    ///
    /// # Errors
    /// As [`Self::chart_point`].
    pub(super) fn corners(&self, [low, high]: [[f64; 2]; 2]) -> Result<[[f64; 2]; 4], ChartError> {
        let ([left, top], [right, bottom]) = (low, high);
        Ok([
            self.chart_point([left, bottom])?,
            self.chart_point([right, bottom])?,
            self.chart_point([right, top])?,
            self.chart_point([left, top])?,
        ])
    }

    /// Returns the middle of the picture (pixels).
    pub(super) fn middle(&self) -> [f64; 2] {
        self.calibration.pixels.centre()
    }

    /// Returns the width of a pixel on the chart, about the middle of the picture (mm).
    ///
    /// # Errors
    /// As [`Self::chart_point`].
    pub(super) fn pixel_width(&self) -> Result<f64, ChartError> {
        let [x, y] = self.middle();
        let [left, right] = [self.chart_point([x - 1.0, y])?, self.chart_point([x + 1.0, y])?];
        Ok((right[0] - left[0]).abs() / 2.0)
    }

    /// Returns the magnification: lengths on the film relative to those on the chart.
    ///
    /// # Errors
    /// As [`Self::chart_point`].
    pub(super) fn magnification(&self) -> Result<f64, ChartError> {
        Ok(self.calibration.pixels.pitch / self.pixel_width()?)
    }

    /// Returns the largest distances of the picture's border from the axis on the chart (mm), to the side and up.
    ///
    /// # Errors
    /// As [`Self::chart_point`].
    pub(super) fn reach(&self) -> Result<[f64; 2], ChartError> {
        let last = self.resolution().map(|n| f64::from(n) - 0.5);
        let mut reach = [0.0_f64; 2];
        for i in 0..=8 {
            let share = f64::from(i) / 8.0;
            let [x, y] = last.map(|last| -0.5 + share * (last + 0.5));
            for pixel in [[x, -0.5], [x, last[1]], [-0.5, y], [last[0], y]] {
                let at = self.chart_point(pixel)?;
                reach = [0, 1].map(|i| reach[i].max(at[i].abs()));
            }
        }
        Ok(reach)
    }
}
