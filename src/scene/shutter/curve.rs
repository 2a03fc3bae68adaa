//! Transmission curve of a shutter.

/// The transmission of a shutter over the exposure, piecewise linear. Time runs from 0, when the
/// shutter begins to open, to 1, when it has closed. The mean is what photographers call the
/// efficiency of a shutter.
#[derive(Clone, Debug, PartialEq)]
pub struct ShutterCurve {
    /// The pieces that transmit light.
    pieces: Vec<Piece>,
    mean: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Piece {
    /// Time at which it begins.
    start: f64,
    width: f64,
    /// Transmission at its beginning and at its end.
    transmission: [f64; 2],
    /// Integral of the transmission over all earlier pieces.
    before: f64,
}

impl ShutterCurve {
    /// Returns the curve of a shutter that transmits everything.
    pub fn ideal() -> Self {
        let piece = Piece { start: 0.0, width: 1.0, transmission: [1.0; 2], before: 0.0 };
        Self { pieces: vec![piece], mean: 1.0 }
    }

    /// Returns the curve through points of time and transmission, in the order of time, the first
    /// at time 0 and the last at 1.
    ///
    /// # Errors
    /// Returns an error if a transmission lies outside 0 to 1, or if no light comes through.
    pub fn from_points(points: &[[f64; 2]]) -> Result<Self, String> {
        if let Some([_, wrong]) = points.iter().find(|[_, share]| !(0.0..=1.0).contains(share)) {
            return Err(format!("the shutter lets {wrong} of the light through; expected 0 to 1"));
        }
        let mut curve = Self { pieces: Vec::new(), mean: 0.0 };
        for pair in points.windows(2) {
            let &[[start, first], [end, last]] = pair else { continue };
            let (width, light) = (end - start, (end - start) * (first + last) / 2.0);
            if light > 0.0 {
                let before = curve.mean;
                curve.pieces.push(Piece { start, width, transmission: [first, last], before });
                curve.mean += light;
            }
        }
        match curve.mean > 0.0 {
            true => Ok(curve),
            false => Err("the shutter lets no light through; expected a value above 0".to_owned()),
        }
    }

    /// Returns the efficiency: the mean transmission.
    pub fn efficiency(&self) -> f64 {
        self.mean
    }

    /// Returns whether the shutter transmits everything.
    pub fn is_ideal(&self) -> bool {
        self.pieces.iter().all(|piece| piece.transmission == [1.0; 2]) && self.pieces.len() == 1
    }

    /// Returns the transmission at a time.
    pub fn transmission(&self, time: f64) -> f64 {
        let inside = |piece: &&Piece| (piece.start..=piece.start + piece.width).contains(&time);
        self.pieces.iter().find(inside).map_or(0.0, |piece| {
            let [first, last] = piece.transmission;
            first + (last - first) * (time - piece.start) / piece.width
        })
    }

    /// Returns the time before which a fraction `u` of all transmitted light has passed. Times
    /// sampled with a uniform `u` have equal weights.
    #[inline(always)]
    pub fn sample_time(&self, u: f64) -> f64 {
        let light = u * self.mean;
        let next = self.pieces.partition_point(|piece| piece.before <= light);
        let piece = &self.pieces[next.saturating_sub(1)];
        let [first, last] = piece.transmission;
        // first s + (last - first) s^2 / 2 = area, solved so that nothing cancels.
        let area = (light - piece.before) / piece.width;
        let root = (first * first + 2.0 * (last - first) * area).max(0.0).sqrt();
        let inside = if area > 0.0 { 2.0 * area / (first + root) } else { 0.0 };
        piece.start + piece.width * inside.min(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shutter::Curtain;

    fn curves() -> Vec<ShutterCurve> {
        let ramps = Curtain::Ramps { opening: 0.3, closing: 0.5 };
        let triangle = Curtain::Ramps { opening: 1.0, closing: 1.0 };
        let table = Curtain::Table(vec![0.0, 0.2, 1.0, 0.0, 0.0, 0.7, 0.7]);
        vec![
            ShutterCurve::ideal(),
            ramps.curve(1.0).unwrap(),
            triangle.curve(2.0).unwrap(),
            table.curve(0.1).unwrap(),
            Curtain::Ramps { opening: 0.0, closing: 0.25 }.curve(1.0).unwrap(),
        ]
    }

    #[test]
    fn the_efficiency_is_the_area_under_the_curve() {
        let means: Vec<f64> = curves().iter().map(ShutterCurve::efficiency).collect();
        // The table: halves of neighbours' sums, over six steps.
        let table = (0.1 + 0.6 + 0.5 + 0.0 + 0.35 + 0.7) / 6.0;
        for (mean, expected) in means.iter().zip([1.0, 0.6, 0.5, table, 0.875]) {
            assert!((mean - expected).abs() < 1e-15, "{means:?}");
        }
    }

    #[test]
    fn sample_times_are_distributed_by_the_transmission() {
        const STEPS: usize = 240_000;
        for curve in curves() {
            // The light up to each step, by the midpoint rule.
            let mut light = vec![0.0; STEPS + 1];
            for i in 0..STEPS {
                light[i + 1] =
                    light[i] + curve.transmission((i as f64 + 0.5) / STEPS as f64) / STEPS as f64;
            }
            let mut last = 0.0;
            for i in 0..=1000 {
                let u = f64::from(i) / 1000.0;
                let time = curve.sample_time(u);
                assert!((last..=1.0).contains(&time), "{time} after {last}");
                let before = light[(time * STEPS as f64).round() as usize];
                assert!(
                    (before - u * curve.efficiency()).abs() < 1e-5,
                    "{before} at {time}: {curve:?}"
                );
                last = time;
            }
        }
    }

    #[test]
    fn invalid_curves_are_refused() {
        let of = |table: &[f64]| Curtain::Table(table.to_vec()).curve(1.0).map(|_| ()).unwrap_err();
        assert!(of(&[0.0, 1.5]).contains("lets 1.5 of the light through; expected 0 to 1"));
        assert!(of(&[0.0, f64::NAN]).contains("NaN"));
        assert!(of(&[0.0, 0.0]).contains("no light") && of(&[]).contains("no light"));
        let slow = Curtain::Ramps { opening: 0.01, closing: 0.02 }.curve(0.02).unwrap_err();
        assert!(slow.contains("opens in 0.01 s") && slow.contains("expected 0.02 s together"));
    }
}
