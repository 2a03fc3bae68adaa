//! Sums of features by pixel: of a tile and of a whole picture.

use std::io;

use super::coverage::{Coverage, SceneParts};
use super::features::TileFeatures;
use super::{Aov, LayerRequest, cryptomatte};
use crate::film::{Frame, Tile, clamp_to_f32};
use petzval_base::io::codec::{ChecksumReader, ChecksumWriter};
use petzval_image::{ALPHA_LAYER, ImageLayer};
use petzval_scene::Scene;

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
    /// Sum of the weights of paths whose motion is known, and of their motion (pixels): of those that meet a surface or
    /// a medium, and of those that leave the scene.
    pub motion: [[f64; 3]; 2],
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

    /// Adds the motion across the picture (pixels) of what a path meets.
    pub fn add_motion(&mut self, weight: f64, [x, y]: [f64; 2], leaves: bool) {
        if x.is_finite() && y.is_finite() {
            let sums = &mut self.motion[usize::from(leaves)];
            *sums = [sums[0] + weight, sums[1] + weight * x, sums[2] + weight * y];
        }
    }

    /// Adds the sums of later paths.
    fn add(&mut self, other: &Self) {
        self.taken = self.taken.saturating_add(other.taken);
        self.passed = self.passed.saturating_add(other.passed);
        self.weight = [0, 1].map(|i| self.weight[i] + other.weight[i]);
        self.depth += other.depth;
        self.coc = [0, 1].map(|i| self.coc[i] + other.coc[i]);
        let sums = self.motion.as_flattened_mut().iter_mut().zip(other.motion.as_flattened());
        sums.for_each(|(sum, more)| *sum += more);
        self.beyond = [0, 1].map(|i| self.beyond[i] + other.beyond[i]);
        for axis in 0..3 {
            self.position[axis] += other.position[axis];
            self.normal[axis] += other.normal[axis];
            self.albedo[axis] += other.albedo[axis];
        }
        self.ids = self.ids.or(other.ids);
    }

    /// Returns all sums in the order in which they are saved.
    fn numbers(&mut self) -> [&mut [f64]; 8] {
        let Self { weight, depth, coc, motion, beyond, position, normal, albedo, .. } = self;
        let one = std::slice::from_mut;
        [weight, one(depth), coc, motion.as_flattened_mut(), beyond, position, normal, albedo]
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
pub(crate) struct FeatureSums {
    pub(super) pixels: Vec<PixelFeatures>,
    /// The coverage of each pixel; empty if no requested layer needs it.
    pub(super) coverage: Vec<Coverage>,
    parts: SceneParts,
}

impl FeatureSums {
    /// Returns empty sums for a number of pixels.
    pub(super) fn new(request: &LayerRequest<'_>, pixels: usize) -> Self {
        let covered = if request.layers.contains(&Aov::Cryptomatte) { pixels } else { 0 };
        Self {
            pixels: vec![PixelFeatures::default(); pixels],
            coverage: vec![Coverage::default(); covered],
            parts: SceneParts::of(request.scene),
        }
    }

    pub(crate) fn save(&self, to: &mut ChecksumWriter) -> io::Result<()> {
        self.pixels.iter().try_for_each(|sum| sum.save(to))?;
        self.coverage.iter().try_for_each(|coverage| coverage.save(to))
    }

    /// Adds the saved sums of later paths of the same tile.
    pub(crate) fn receive(&mut self, from: &mut ChecksumReader) -> io::Result<()> {
        self.pixels.iter_mut().try_for_each(|sum| sum.receive(from))?;
        let parts = self.parts;
        self.coverage.iter_mut().try_for_each(|coverage| coverage.receive(from, parts))
    }

    /// Adds the sums of later paths of the same tile.
    pub(super) fn add(&mut self, other: &Self) {
        for (sum, other) in self.pixels.iter_mut().zip(&other.pixels) {
            sum.add(other);
        }
        for (sum, other) in self.coverage.iter_mut().zip(&other.coverage) {
            sum.add_all(other);
        }
    }
}

/// Feature sums of a whole picture.
#[derive(Clone, Debug)]
pub struct FeatureFilm {
    frame: Frame,
    sums: FeatureSums,
}

impl FeatureFilm {
    /// Returns the size of a pixel (bytes): 0 if no requested layer needs features.
    pub fn bytes(request: &LayerRequest<'_>) -> u64 {
        let features =
            if TileFeatures::are_needed(request) { size_of::<PixelFeatures>() as u64 } else { 0 };
        let is_matted = request.layers.contains(&Aov::Cryptomatte);
        features + if is_matted { Coverage::TYPICAL_BYTES } else { 0 }
    }

    /// Returns an empty film; `None` if no requested layer needs one.
    pub fn new(request: &LayerRequest<'_>) -> Option<Self> {
        TileFeatures::are_needed(request).then(|| {
            let [width, height] = request.frame.size().map(|n| n as usize);
            Self { frame: *request.frame, sums: FeatureSums::new(request, width * height) }
        })
    }

    /// Returns the sums of a tile.
    pub(crate) fn tile(&self, tile: &Tile) -> FeatureSums {
        let FeatureSums { pixels, coverage, parts } = &self.sums;
        let coverage = match coverage.is_empty() {
            true => Vec::new(),
            false => tile.cut(&self.frame, coverage),
        };
        FeatureSums { pixels: tile.cut(&self.frame, pixels), coverage, parts: *parts }
    }

    /// Replaces the sums of a tile.
    pub(crate) fn put(&mut self, tile: &Tile, sums: &FeatureSums) {
        tile.paste(&self.frame, &sums.pixels, &mut self.sums.pixels);
        if !sums.coverage.is_empty() {
            tile.paste(&self.frame, &sums.coverage, &mut self.sums.coverage);
        }
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
            self.sums.pixels.iter().map(|sum| clamp_to_f32(value(sum))).collect()
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
            Aov::Motion => {
                // Edges before the sky keep the motion of the surface.
                let displacement = |axis: usize| {
                    all(&|PixelFeatures { motion: [surfaces, sky], .. }| {
                        let sums = if surfaces[0] > 0.0 { surfaces } else { sky };
                        mean(sums[1 + axis], sums[0])
                    })
                };
                ("motion", vec![one("X", displacement(0)), one("Y", displacement(1))])
            }
            Aov::Alpha => (ALPHA_LAYER, vec![one("A", all(&PixelFeatures::alpha))]),
            Aov::Variance | Aov::Vignetting | Aov::DualPixel | Aov::Cryptomatte => return None,
        };
        Some(ImageLayer::new(name, channels))
    }

    /// Returns the layers of Cryptomatte.
    pub(super) fn mattes(&self, scene: &Scene) -> Vec<ImageLayer> {
        let weights = || self.sums.pixels.iter().map(|sum| sum.weight[0]);
        cryptomatte::layers(scene, || self.sums.coverage.iter().zip(weights()))
    }
}
