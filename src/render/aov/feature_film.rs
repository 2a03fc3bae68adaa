//! Sums of features by pixel: of a tile and of a whole picture.

use std::io;

use super::features::TileFeatures;
use super::{Aov, LayerRequest};
use crate::film::{Frame, Tile, clamp_to_f32};
use petzval_base::io::codec::{ChecksumReader, ChecksumWriter};
use petzval_image::{ALPHA_LAYER, ImageLayer};

/// Feature sums of one pixel.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PixelFeatures {
    pub taken: u32,
    pub passed: u32,
    /// Sum of the weights of all paths, and of those that meet a surface.
    pub weight: [f64; 2],
    pub depth: f64,
    /// Sum of the weights of all paths whose circle of confusion is finite, and of these circles.
    pub coc: [f64; 2],
    /// Sum of the weights of all paths as they leave the lens, and of those that leave the scene.
    pub beyond: [f64; 2],
    pub position: [f64; 3],
    pub normal: [f64; 3],
    pub albedo: [f64; 3],
    /// Indices plus one of the shape, instance and material that the first path meets.
    pub ids: Option<[u32; 3]>,
}

impl PixelFeatures {
    /// Adds the circle of confusion (um) of a path. Points in the plane of the pupil have none.
    pub fn add_circle(&mut self, weight: f64, diameter: f64) {
        if diameter.is_finite() {
            self.coc = [self.coc[0] + weight, self.coc[1] + weight * diameter];
        }
    }

    /// Adds the sums of later paths.
    fn add(&mut self, other: &Self) {
        self.taken = self.taken.saturating_add(other.taken);
        self.passed = self.passed.saturating_add(other.passed);
        self.weight = [0, 1].map(|i| self.weight[i] + other.weight[i]);
        self.depth += other.depth;
        self.coc = [0, 1].map(|i| self.coc[i] + other.coc[i]);
        self.beyond = [0, 1].map(|i| self.beyond[i] + other.beyond[i]);
        for axis in 0..3 {
            self.position[axis] += other.position[axis];
            self.normal[axis] += other.normal[axis];
            self.albedo[axis] += other.albedo[axis];
        }
        self.ids = self.ids.or(other.ids);
    }

    /// Returns all sums in the order in which they are saved.
    fn numbers(&mut self) -> [&mut [f64]; 7] {
        let Self { weight, depth, coc, beyond, position, normal, albedo, .. } = self;
        let one = std::slice::from_mut;
        [weight, one(depth), coc, beyond, position, normal, albedo]
    }

    /// Returns the share of the background that is covered.
    fn alpha(&self) -> f64 {
        let [launched, beyond] = self.beyond;
        // The barrel of the lens covers what no path reaches. Random weights of media may exceed 1.
        if launched > 0.0 { (1.0 - beyond / launched).clamp(0.0, 1.0) } else { 1.0 }
    }

    fn save(&self, to: &mut ChecksumWriter) -> io::Result<()> {
        to.u32(self.taken)?;
        to.u32(self.passed)?;
        { *self }.numbers().iter().try_for_each(|numbers| to.numbers(numbers))?;
        to.u32(u32::from(self.ids.is_some()))?;
        self.ids.iter().flatten().try_for_each(|&id| to.u32(id))
    }

    /// Adds the saved sums of later paths.
    fn receive(&mut self, from: &mut ChecksumReader) -> io::Result<()> {
        let (taken, passed) = (from.u32()?, from.u32()?);
        self.add(&Self { taken, passed, ..Self::default() });
        self.numbers().iter_mut().try_for_each(|numbers| from.add_numbers(numbers))?;
        if from.below(2, "flag of the first hit")? == 1 {
            let ids = [from.u32()?, from.u32()?, from.u32()?];
            self.ids.get_or_insert(ids);
        }
        Ok(())
    }
}

/// Feature sums of the pixels of a tile.
#[derive(Clone, Debug)]
pub(crate) struct FeatureSums(pub(super) Vec<PixelFeatures>);

impl FeatureSums {
    pub(crate) fn save(&self, to: &mut ChecksumWriter) -> io::Result<()> {
        self.0.iter().try_for_each(|sum| sum.save(to))
    }

    /// Adds the saved sums of later paths of the same tile.
    pub(crate) fn receive(&mut self, from: &mut ChecksumReader) -> io::Result<()> {
        self.0.iter_mut().try_for_each(|sum| sum.receive(from))
    }

    /// Adds the sums of later paths of the same tile.
    pub(super) fn add(&mut self, other: &Self) {
        for (sum, other) in self.0.iter_mut().zip(&other.0) {
            sum.add(other);
        }
    }
}

/// Feature sums of a whole picture.
#[derive(Clone, Debug)]
pub struct FeatureFilm {
    frame: Frame,
    sums: Vec<PixelFeatures>,
}

impl FeatureFilm {
    /// Returns the size of a pixel (bytes): 0 if no requested layer needs features.
    pub fn bytes(request: &LayerRequest<'_>) -> u64 {
        if TileFeatures::are_needed(request) { size_of::<PixelFeatures>() as u64 } else { 0 }
    }

    /// Returns an empty film; `None` if no requested layer needs one.
    pub fn new(request: &LayerRequest<'_>) -> Option<Self> {
        TileFeatures::are_needed(request).then(|| {
            let [width, height] = request.frame.size().map(|n| n as usize);
            Self { frame: *request.frame, sums: vec![PixelFeatures::default(); width * height] }
        })
    }

    /// Returns the sums of a tile.
    pub(crate) fn tile(&self, tile: &Tile) -> FeatureSums {
        FeatureSums(tile.cut(&self.frame, &self.sums))
    }

    /// Replaces the sums of a tile.
    pub(crate) fn put(&mut self, tile: &Tile, sums: &FeatureSums) {
        tile.paste(&self.frame, &sums.0, &mut self.sums);
    }

    /// Adds the features of later paths of a tile.
    pub fn add(&mut self, tile: &Tile, more: &TileFeatures) {
        let mut sums = self.tile(tile);
        sums.add(&more.sums);
        self.put(tile, &sums);
    }

    /// Returns a layer of first-surface features; `None` for other layers.
    pub(super) fn layer(&self, aov: Aov) -> Option<ImageLayer> {
        let all = |value: &dyn Fn(&PixelFeatures) -> f64| -> Vec<f32> {
            self.sums.iter().map(|sum| clamp_to_f32(value(sum))).collect()
        };
        let mean = |total: f64, weight: f64| if weight > 0.0 { total / weight } else { 0.0 };
        let id = |place: usize| {
            move |sum: &PixelFeatures| f64::from(sum.ids.map_or(0, |ids| ids[place])) - 1.0
        };
        let vector = |names: [&str; 3], of: fn(&PixelFeatures) -> &[f64; 3]| {
            let channel = |axis: usize| all(&|sum| mean(of(sum)[axis], sum.weight[1]));
            (0..3).map(|axis| (names[axis].to_owned(), channel(axis))).collect()
        };
        let one = |name: &str, values: Vec<f32>| (name.to_owned(), values);
        let (name, channels) = match aov {
            Aov::Depth => (
                "depth",
                vec![
                    one("Z", all(&|sum| mean(sum.depth, sum.weight[1]))),
                    one("coverage", all(&|sum| mean(sum.weight[1], sum.weight[0]))),
                ],
            ),
            Aov::Position => ("position", vector(["X", "Y", "Z"], |sum| &sum.position)),
            Aov::Normal => ("normal", vector(["X", "Y", "Z"], |sum| &sum.normal)),
            Aov::Albedo => ("albedo", vector(["R", "G", "B"], |sum| &sum.albedo)),
            Aov::Object => {
                ("object", vec![one("shape", all(&id(0))), one("instance", all(&id(1)))])
            }
            Aov::Material => ("material", vec![one("id", all(&id(2)))]),
            Aov::Samples => (
                "samples",
                vec![
                    one("taken", all(&|sum| f64::from(sum.taken))),
                    one("passed", all(&|sum| f64::from(sum.passed))),
                ],
            ),
            Aov::Coc => ("coc", vec![one("um", all(&|sum| mean(sum.coc[1], sum.coc[0])))]),
            Aov::Alpha => (ALPHA_LAYER, vec![one("A", all(&PixelFeatures::alpha))]),
            Aov::Variance | Aov::Vignetting | Aov::DualPixel => return None,
        };
        Some(ImageLayer { name: name.to_owned(), channels })
    }
}
