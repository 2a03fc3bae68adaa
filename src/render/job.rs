//! Description of one picture: everything that decides its pixels.

use std::ops::Range;
use std::sync::Arc;
use std::time::Duration;

use crate::aov;
use crate::aov::{Aov, HALVES, LayerRequest, MotionVectors};
use crate::diffraction::Diffraction;
use crate::film::{
    ExtraChannels, Frame, LightSplit, Response, SpectralSplit, TILE, Tile, TileSampler,
};
use crate::light_tracing::Strategy;
use crate::light_tracing::caustics::Caustics;
use crate::light_tracing::ghosts::Ghosts;
use crate::light_tracing::lamp_images::{LampImageWeights, LampImages};
use crate::light_tracing::light_paths::LightPathInput;
use crate::plan::Plan;
use crate::sensor::Sensor;
use crate::shade::{PathVertex, PixelFootprint, ShadeInputs};
use crate::timing::Timing;
use petzval_base::io::FileLog;
use petzval_base::rays::{HitBatch, RayBatch, SampleBatch};
use petzval_image::{DisplayExposure, EncodingOptions, ImageLayer, RawFormat};
use petzval_lens::Camera;
use petzval_scene::{PathLimits, Scene, SpectralScene};
use petzval_spectrum::Primaries;
use petzval_spectrum::{BANDS, BucketShares, ColourSpace, LightBand};

/// Everything that decides the pixels of a picture.
#[derive(Clone, Debug)]
pub struct Job {
    /// The scene.
    pub scene: Scene,
    /// The same scene by wavelength, if paths carry spectra.
    pub spectral: Option<Arc<SpectralScene>>,
    /// The camera.
    pub camera: Camera,
    /// The effects that are simulated, and the reasons.
    pub plan: Plan,
    /// The pixels of the picture and the part of them that is rendered.
    pub frame: Frame,
    /// The filter and the colour response of the film.
    pub response: Response,
    /// The colour space of the picture's file, if it can hold one. Calculations are in sRGB.
    pub colour_space: ColourSpace,
    /// Whether the scene file asks for 16-bit floats.
    pub half: bool,
    /// The sample numbers that every pixel takes. With another stop criterion, their count is the
    /// upper limit of the mean number of samples per pixel.
    pub samples: Range<u32>,
    /// The stop criteria besides the number of samples.
    pub stop_criteria: StopCriteria,
    /// The seed of all random numbers.
    pub seed: u32,
    /// The limits of path length. With a depth of 1, only direct light is seen; with 0, only
    /// surfaces that emit light.
    pub path_limits: PathLimits,
    /// The layers to compute besides the colours.
    pub layers: Vec<Aov>,
    /// Whether layers of positions and normals are in camera space instead of world space.
    pub camera_layers: bool,
    /// The spectral bands that light is split into, with the film's response to each.
    pub bands: [LightBand; BANDS],
    /// The point spreads of the whole picture, if the plan traced them.
    pub diffraction: Option<Arc<Diffraction>>,
    /// The ghosts of the lens, if they are simulated.
    pub ghosts: Option<Ghosts>,
    /// The lamps that light paths start from, if light paths find their images.
    pub lamp_images: Option<LampImages>,
    /// The surfaces on which light paths start, if light paths find caustics.
    pub caustics: Option<Caustics>,
    /// The sensor that reads the finished picture out. Without one, the film is ideal.
    pub sensor: Option<Sensor>,
    /// The times of the samples, if anything depends on them.
    pub timing: Option<Timing>,
    /// The motion of all points across the picture, if a layer needs it.
    pub motion_vectors: Option<Arc<MotionVectors>>,
    /// The files that the scene and the lens were read from.
    pub files: FileLog,
}

impl Job {
    /// Replaces the camera, and the motion of points across its picture.
    pub fn set_camera(&mut self, camera: Camera) {
        if let Some(vectors) = &mut self.motion_vectors {
            *vectors = Arc::new(vectors.seen_by(&camera, self.frame.resolution));
        }
        self.camera = camera;
    }

    /// Returns the point spreads of the part of the picture that is rendered.
    pub(crate) fn point_spreads(&self) -> Arc<Diffraction> {
        let known = self.diffraction.as_ref();
        let known = known.filter(|spreads| spreads.is_of(&self.camera, &self.frame));
        let traced = || Arc::new(Diffraction::new(&self.camera, &self.frame, &self.bands));
        known.cloned().unwrap_or_else(traced)
    }

    /// Returns the options of the picture's file that the scene asks for, with an exposure of
    /// formats for display.
    pub fn encoding(&self, exposure: DisplayExposure) -> EncodingOptions {
        let space = self.colour_space;
        let space = (space != ColourSpace::Srgb).then(|| space.primaries());
        let (half, grey, raw) = (self.half, self.has_mosaic(), self.raw_format());
        EncodingOptions { half, exposure, space, grey, raw, ..EncodingOptions::default() }
    }

    /// Returns whether the picture is the mosaic of a sensor, with one reading for each pixel, which all
    /// channels repeat.
    pub fn has_mosaic(&self) -> bool {
        self.sensor.is_some_and(|sensor| sensor.bayer.is_some())
    }

    /// Returns the description of the mosaic for raw files.
    pub fn raw_format(&self) -> Option<RawFormat> {
        self.raw_format_of(self.sensor.as_ref()?)
    }

    /// Returns the description for raw files of the mosaic of another sensor behind the same camera.
    pub fn raw_format_of(&self, sensor: &Sensor) -> Option<RawFormat> {
        // Photosites without filters, as behind a passband, are not those of the camera.
        let camera = self.response.camera.as_ref().filter(|_| sensor.filters.is_some());
        Some(sensor.raw_format(sensor.bayer?, camera))
    }

    /// Returns the shares of light in the buckets of a spectral film; `None` for other films.
    pub fn buckets(&self) -> Option<&Arc<BucketShares>> {
        self.response.buckets.as_ref()
    }

    /// Returns the channels that the film has beside its colours.
    pub fn extra_channels(&self) -> ExtraChannels {
        ExtraChannels { buckets: self.response.buckets.clone(), left_half: self.records_halves() }
    }

    /// Returns whether the light of both halves of the exit pupil is recorded.
    pub fn records_halves(&self) -> bool {
        self.layers.contains(&Aov::DualPixel)
    }

    /// Returns the footprint of a pixel of this picture.
    pub fn pixel_footprint(&self) -> PixelFootprint {
        PixelFootprint::new(&self.camera, self.frame.resolution)
    }

    /// Returns the tiles of the picture. Those of a picture by wavelength are larger, so that waves of one
    /// set are full: with 64 samples a pixel, waves of small tiles take 15 % longer.
    pub fn tiles(&self) -> Vec<Tile> {
        self.frame.tiles(if self.spectral.is_some() { 2 * TILE } else { TILE })
    }

    /// Returns the sampler of a tile. It leaves out pixels that no light reaches.
    pub fn sampler(&self, tile: &Tile, samples: Range<u32>) -> TileSampler {
        let margin = self.response.filter.margin();
        TileSampler::new(tile, samples, self.light_split(), |low, high| {
            let low = [0, 1].map(|i| f64::from(low[i]) - margin[i]);
            let high = [0, 1].map(|i| f64::from(high[i]) + margin[i]);
            self.camera.sees_light(low, high, self.frame.resolution)
        })
    }

    /// Returns how the light of the picture is divided among waves.
    fn light_split(&self) -> LightSplit {
        let spectra = match &self.spectral {
            None => SpectralSplit::Rgb,
            Some(scene) if scene.disperses() => SpectralSplit::Heroes,
            Some(_) => SpectralSplit::Sets,
        };
        LightSplit { bands: self.camera.bands(), spectra }
    }

    /// Converts layers to the frame and the colour space that the scene asks for.
    pub fn convert_layers(&self, layers: &mut [ImageLayer]) {
        if self.camera_layers {
            aov::to_camera(layers, &self.camera.world_from_camera.inverse());
        }
        if self.colour_space != ColourSpace::Srgb {
            let space = self.colour_space.primaries();
            // White reflects all light; light keeps its X, Y and Z, as that of the picture does.
            if let Some(matrix) = Primaries::SRGB.adapted_to(&space) {
                aov::convert_colours(layers, &[Aov::Albedo.name()], &matrix);
            }
            if let (false, Some(matrix)) = (self.has_mosaic(), Primaries::SRGB.to(&space)) {
                aov::convert_colours(layers, &HALVES, &matrix);
            }
        }
    }

    /// Returns the layers of this picture and the parts that they depend on.
    pub fn layer_request(&self) -> LayerRequest<'_> {
        LayerRequest {
            layers: &self.layers,
            scene: &self.scene,
            camera: &self.camera,
            frame: &self.frame,
            timing: self.timing.as_ref(),
            motion_vectors: self.motion_vectors.as_ref(),
        }
    }

    /// Returns the parts of this job that the weights of camera paths depend on, if light paths find
    /// images of lamps too.
    pub fn lamp_image_weights(&self) -> Option<LampImageWeights<'_>> {
        let Self { camera, frame, timing, .. } = self;
        let lamp_images = self.lamp_images.as_ref()?;
        Some(LampImageWeights::new(lamp_images, camera, frame, timing.as_ref()))
    }

    /// Returns the scene that the camera paths of some samples meet.
    pub fn scene_of(&self, samples: &SampleBatch) -> &Scene {
        self.spectral
            .as_ref()
            .map_or(&self.scene, |spectral| spectral.at(samples.set, samples.hero))
    }

    /// Returns the inputs of shading for camera paths, with the weights of
    /// [`Self::lamp_image_weights`].
    pub(crate) fn shade_inputs<'a>(
        &'a self,
        vertex: PathVertex,
        samples: &SampleBatch,
        (rays, hits): (&'a RayBatch, &'a HitBatch),
        weights: Option<&'a LampImageWeights<'_>>,
    ) -> ShadeInputs<'a> {
        ShadeInputs {
            scene: self.scene_of(samples),
            vertex,
            rays,
            hits,
            lamp_weights: weights.map(|weights| weights as _),
            caustics: self.caustics.is_some(),
            hides_sky: self.hides_sky(),
        }
    }

    /// Returns whether the light of a sky that the camera sees directly is left out, because the
    /// picture has an opacity and gets another background.
    pub fn hides_sky(&self) -> bool {
        self.layers.contains(&Aov::Alpha)
    }

    /// Returns the strategies whose light paths add light to the picture.
    pub fn light_strategies(&self) -> Vec<Strategy<'_>> {
        let lamp_images = self.lamp_images.as_ref().map(Strategy::LampImages);
        let caustics = self.caustics.as_ref().map(Strategy::Caustics);
        let ghosts = self.ghosts.as_ref().map(Strategy::Ghosts);
        [lamp_images, caustics, ghosts].into_iter().flatten().collect()
    }

    /// Returns the parts of this job that light paths depend on.
    pub fn light_path_input(&self) -> LightPathInput<'_> {
        LightPathInput {
            scene: &self.scene,
            spectral: self.spectral.as_deref(),
            split: self.light_split(),
            camera: &self.camera,
            frame: &self.frame,
            response: &self.response,
            timing: self.timing.as_ref(),
            path_limits: self.path_limits,
            halves: self.records_halves(),
            hides_sky: self.hides_sky(),
            seed: self.seed,
            stop: None,
        }
    }
}

/// Criteria that end a render before it has taken all samples. The first that is met ends it.
///
/// The number of samples of the job is then the upper limit of the mean number of samples per pixel,
/// over the pixels that light reaches.
///
/// A picture that ends by noise or by its number of samples is the same on every machine. A picture
/// that ends by time is not reproducible.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StopCriteria {
    /// The noise of the picture at which the render ends.
    ///
    /// The error of a pixel is the standard error of its luminance, divided by the sum of that
    /// luminance and a tenth of the picture's mean luminance; the second term keeps dark pixels from
    /// dominating. The noise of the picture is the root mean square of this error over all pixels.
    pub noise: Option<f64>,
    /// The duration of the render, without its preparation and the development of the picture. Every
    /// pixel takes some samples, however short it is.
    pub time: Option<Duration>,
}

impl StopCriteria {
    /// The smallest number of samples per pixel of such a render: one for each of the four quarters
    /// that the noise is estimated from.
    pub const MIN_SAMPLES: u32 = 4;
    /// The upper limit of samples per pixel if none is given.
    pub const DEFAULT_MAX_SAMPLES: u32 = 1 << 20;

    /// Returns whether the number of samples alone ends the render, so that all pixels take the same
    /// number.
    pub fn count_only(&self) -> bool {
        *self == Self::default()
    }
}
