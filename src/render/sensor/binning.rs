//! Binning: pixels of several photosites.

use super::{Components, Crosstalk, FixedPattern, HotPixels};

/// Photosites that make a pixel: a square of them with filters of one colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Binning {
    /// Photosites along a side of the square.
    pub side: u32,
    /// Quantity whose sum is read.
    pub sum: BinningSum,
}

/// Quantity that binning sums.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BinningSum {
    /// The charge of the photosites, which is read once.
    Charge,
    /// Their readings, each with noise of its own.
    #[default]
    Codes,
}

impl Binning {
    /// One photosite for each pixel.
    pub const NONE: Self = Self { side: 1, sum: BinningSum::Codes };

    /// Largest number of photosites along a side.
    pub(super) const MOST: u32 = 16;

    /// Returns the number of photosites of a pixel.
    pub(super) fn count(self) -> f64 {
        f64::from(self.side * self.side)
    }

    /// Returns the read noise of a pixel (electrons), of which a photosite has this. Rows and columns of a pixel are
    /// independent.
    pub(super) fn read_noise(self, of_photosite: Components) -> Components {
        match self.sum {
            BinningSum::Charge => of_photosite,
            BinningSum::Codes => self.dark_signal(of_photosite),
        }
    }

    /// Returns the deviations of the sum of all photosites (electrons).
    fn dark_signal(self, of_photosite: Components) -> Components {
        let side = f64::from(self.side);
        let Components { pixel, row, column } = of_photosite;
        // A row adds `side` times the same, and as many rows are independent.
        Components {
            pixel: side * pixel,
            row: side.powf(1.5) * row,
            column: side.powf(1.5) * column,
        }
    }

    /// Returns the fixed pattern of pixels, of which photosites have this.
    pub(super) fn pattern(self, of_photosite: FixedPattern) -> FixedPattern {
        if self.side == 1 {
            // Not rounded.
            return of_photosite;
        }
        let side = f64::from(self.side);
        let Components { pixel, row, column } = of_photosite.response;
        FixedPattern {
            dark_signal: self.dark_signal(of_photosite.dark_signal),
            response: Components {
                pixel: pixel / side,
                row: row / side.sqrt(),
                column: column / side.sqrt(),
            },
            hot: self.hot_pixels(of_photosite.hot),
            ..of_photosite
        }
    }

    /// Returns the hot pixels. One with several hot photosites has their mean current, so that the total stays.
    fn hot_pixels(self, HotPixels { share, dark_current }: HotPixels) -> HotPixels {
        let any = 1.0 - (1.0 - share).powf(self.count());
        let photosites = if any > 0.0 { self.count() * share / any } else { 1.0 };
        HotPixels { share: any, dark_current: dark_current * photosites }
    }

    /// Returns the crosstalk of pixels, of which photosites have this: only those at the edges of a pixel lose
    /// charge to others.
    pub(super) fn crosstalk(self, of_photosite: Crosstalk) -> Crosstalk {
        Crosstalk(of_photosite.0.map(|share| share / f64::from(self.side)))
    }
}
