//! Where the picture of a camera shows the plane in focus.

use petzval_optics::Calibration;

/// Least height of a picture with edges (pixels): squares and their regions take a seventh of it.
pub(super) const MIN_SIDE: u32 = 400;

/// Why a chart cannot be drawn.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ChartError {
    /// Infinity is in focus.
    #[error("a chart stands in the plane in focus; expected a finite 'focus', such as 2m")]
    Infinite,
    /// The camera sees more than a plane can show, or its film is dark there.
    #[error(
        "no flat chart fills the picture: pixel {x:.0},{y:.0} shows a ray {angle:.0} degrees from the axis, or none; \
         expected rays of at most 75 degrees: choose a smaller 'film-size'"
    )]
    Unreachable {
        /// Column.
        x: f64,
        /// Row.
        y: f64,
        /// Angle to the axis (degrees).
        angle: f64,
    },
    /// The picture has too few pixels.
    #[error(
        "a chart of edges needs pictures of at least {MIN_SIDE} x {MIN_SIDE} pixels; found {width} x {height}"
    )]
    Small {
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
        let ray = self.calibration.scene_ray(pixel);
        let angle = ray.map_or(f64::NAN, |ray| ray.angle().to_degrees());
        match ray.filter(|_| angle <= 75.0) {
            Some(ray) => {
                let along = (self.distance() - ray.point.z) / ray.direction.z;
                let at = ray.point + along * ray.direction;
                Ok([at.x, -at.y])
            }
            None => Err(ChartError::Unreachable { x: pixel[0], y: pixel[1], angle }),
        }
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
