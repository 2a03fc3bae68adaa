//! What the first surfaces on the paths of a pixel are like.
//!
//! Every path counts as much as the light that the lens lets through for it, so that vignetting
//! does not skew the means.

use std::io;

use glam::{Affine3A, Vec3};

use super::Aov;
use crate::checkpoint::{Reader, Writer};
use crate::film::{Frame, Tile, single};
use crate::image::Layer;
use crate::lens::{Camera, Model};
use crate::motion::Motion;
use crate::rays::{HitBatch, NONE, RayBatch, SampleBatch};
use crate::render::Job;
use crate::scene::Scene;
use crate::shade::{Beam, albedo};

/// Sums of one pixel.
#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    taken: u32,
    passed: u32,
    /// Of all paths, and of those that meet a surface.
    weight: [f64; 2],
    depth: f64,
    coc: f64,
    position: [f64; 3],
    normal: [f64; 3],
    albedo: [f64; 3],
    /// Shape, instance and material that the first path meets, plus one.
    ids: Option<[u32; 3]>,
}

impl Sum {
    /// Adds the paths of another sum, which come later.
    fn add(&mut self, other: &Self) {
        self.taken = self.taken.saturating_add(other.taken);
        self.passed = self.passed.saturating_add(other.passed);
        self.weight = [0, 1].map(|i| self.weight[i] + other.weight[i]);
        self.depth += other.depth;
        self.coc += other.coc;
        for axis in 0..3 {
            self.position[axis] += other.position[axis];
            self.normal[axis] += other.normal[axis];
            self.albedo[axis] += other.albedo[axis];
        }
        self.ids = self.ids.or(other.ids);
    }

    /// All that is a sum, in the order in which it is saved.
    fn numbers(&mut self) -> [&mut [f64]; 6] {
        let Self { weight, depth, coc, position, normal, albedo, .. } = self;
        let one = std::slice::from_mut;
        [weight, one(depth), one(coc), position, normal, albedo]
    }

    fn save(&self, to: &mut Writer) -> io::Result<()> {
        to.u32(self.taken)?;
        to.u32(self.passed)?;
        { *self }.numbers().iter().try_for_each(|numbers| to.numbers(numbers))?;
        to.u32(u32::from(self.ids.is_some()))?;
        self.ids.iter().flatten().try_for_each(|&id| to.u32(id))
    }

    /// Adds what was saved, which comes later.
    fn receive(&mut self, from: &mut Reader) -> io::Result<()> {
        let (taken, passed) = (from.u32()?, from.u32()?);
        self.add(&Self { taken, passed, ..Self::default() });
        self.numbers().iter_mut().try_for_each(|numbers| from.add_numbers(numbers))?;
        if from.below(2, "things met first")? == 1 {
            let ids = [from.u32()?, from.u32()?, from.u32()?];
            self.ids.get_or_insert(ids);
        }
        Ok(())
    }
}

/// Sums of the pixels of a tile.
#[derive(Clone, Debug)]
pub(crate) struct FeatureSums(Vec<Sum>);

impl FeatureSums {
    pub(crate) fn save(&self, to: &mut Writer) -> io::Result<()> {
        self.0.iter().try_for_each(|sum| sum.save(to))
    }

    /// Adds what was saved of later paths of the same tile.
    pub(crate) fn receive(&mut self, from: &mut Reader) -> io::Result<()> {
        self.0.iter_mut().try_for_each(|sum| sum.receive(from))
    }

    /// Adds those of later paths of the same tile.
    fn add(&mut self, other: &Self) {
        for (sum, other) in self.0.iter_mut().zip(&other.0) {
            sum.add(other);
        }
    }
}

/// What the paths of a tile met.
#[derive(Clone, Debug)]
pub struct Features {
    sums: FeatureSums,
    camera_from_world: Affine3A,
    ride: Option<Motion>,
    blur: Option<Blur>,
    beam: Beam,
}

/// The circle of confusion to first order, in the camera's units of depth.
#[derive(Clone, Copy, Debug)]
struct Blur {
    /// Depth of the front vertex, and millimetres in a unit.
    front: f64,
    per_unit: f64,
    /// Of a ray from the axis at distance s before the front vertex: y on the film is
    /// (at + s per) times its slope.
    at: f64,
    per: f64,
    /// What both change by for film that stands a mm farther back.
    behind: [f64; 2],
    /// How far back the film stands, mm, for each mm along it.
    tilt: [f64; 2],
    /// The entrance pupil: its distance behind the front vertex and its diameter.
    pupil: [f64; 2],
}

impl Blur {
    fn of(camera: &Camera) -> Option<Self> {
        let Model::Real(lens) = &camera.model else { return None };
        let (paraxial, whole) = (&lens.paraxial, &lens.paraxial.whole);
        let reduced = lens.film_distance / paraxial.film_index;
        let back = |own: [f64; 2]| -lens.film_pose.film_point(own)[2];
        Some(Self {
            front: lens.front,
            per_unit: 1.0 / lens.unit,
            at: whole.b + reduced * whole.d,
            per: whole.a + reduced * whole.c,
            behind: [whole.d, whole.c].map(|of| of / paraxial.film_index),
            tilt: [back([1.0, 0.0]), back([0.0, 1.0])],
            pupil: [paraxial.entrance_pupil.position, paraxial.entrance_pupil.diameter],
        })
    }

    /// The diameter, um, for a point at a depth that a film point (mm) sees.
    fn at(&self, depth: f64, film: [f64; 2]) -> f64 {
        let distance = (depth - self.front) * self.per_unit;
        let [position, diameter] = self.pupil;
        // The ray through the rim of the pupil.
        let slope = diameter / 2.0 / (distance + position);
        let back = self.tilt[0] * film[0] + self.tilt[1] * film[1];
        let [at, per] = self.behind.map(|of| of * back);
        (2e3 * slope * (self.at + at + distance * (self.per + per))).abs()
    }
}

impl Features {
    /// Whether a layer of the job needs them.
    pub fn asked(job: &Job) -> bool {
        job.layers.iter().any(|aov| !matches!(aov, Aov::Vignetting | Aov::Variance))
    }

    /// Of a tile that no path has come to; `None` where nobody asks.
    pub fn new(job: &Job, tile: &Tile) -> Option<Self> {
        Self::asked(job).then(|| Self {
            sums: FeatureSums(vec![Sum::default(); (tile.size[0] * tile.size[1]) as usize]),
            camera_from_world: rounded(&job.camera.world_from_camera.inverse()),
            ride: job.timing.as_ref().and_then(|timing| timing.ride.clone()),
            blur: Blur::of(&job.camera),
            beam: job.beam(),
        })
    }

    pub(crate) fn save(&self, to: &mut Writer) -> io::Result<()> {
        self.sums.save(to)
    }

    /// Adds what was saved of later paths of the same tile.
    pub(crate) fn receive(&mut self, from: &mut Reader) -> io::Result<()> {
        self.sums.receive(from)
    }

    /// Adds what later paths of the same tile met.
    pub fn add(&mut self, other: &Self) {
        self.sums.add(&other.sums);
    }

    /// Adds the first hits of a wave: a stage.
    pub fn record(
        &mut self,
        scene: &Scene,
        rays: &RayBatch,
        hits: &HitBatch,
        samples: &SampleBatch,
    ) {
        for i in 0..samples.len {
            self.sums.0[samples.pixel[i] as usize].taken += 1;
        }
        for i in 0..rays.len {
            let slot = rays.slot[i] as usize;
            let sum = &mut self.sums.0[samples.pixel[slot] as usize];
            let (ray, hit) = (rays.ray(i), hits[i]);
            let weight = rays.carried(i).into_iter().map(f64::from).sum::<f64>() / 3.0;
            sum.passed += 1;
            if !weight.is_finite() {
                continue;
            }
            sum.weight[0] += weight;
            if hit.shape == NONE {
                sum.ids.get_or_insert([0; 3]);
                continue;
            }
            let (shape, point) = scene.surface(&ray, &hit);
            sum.ids.get_or_insert([
                hit.shape + 1,
                hit.instance.wrapping_add(1),
                shape.material + 1,
            ]);
            let position = seen_at_rest(self.ride.as_ref(), point.position, samples.time[slot]);
            let depth = f64::from(self.camera_from_world.transform_point3(position).z);
            let toward = -Vec3::from(ray.direction);
            let normal = point.shading * point.shading.dot(toward).signum();
            let colour = albedo(scene, &self.beam, ray, hit, point);
            let film = [0, 1].map(|axis| f64::from(samples.film[axis][slot]));
            let coc = self.blur.as_ref().map_or(0.0, |blur| blur.at(depth, film));
            let vectors = [point.position.to_array(), normal.to_array(), colour];
            let all = vectors.as_flattened().iter().copied().map(f64::from);
            // What is no number would be all that is left of the sums.
            if !all.chain([depth, coc]).all(f64::is_finite) {
                continue;
            }
            sum.weight[1] += weight;
            sum.depth += weight * depth;
            sum.coc += weight * coc;
            for axis in 0..3 {
                sum.position[axis] += weight * f64::from(point.position[axis]);
                sum.normal[axis] += weight * f64::from(normal[axis]);
                sum.albedo[axis] += weight * f64::from(colour[axis]);
            }
        }
    }
}

/// Where a camera at rest would see a point that one that moves sees at a time.
fn seen_at_rest(ride: Option<&Motion>, position: Vec3, time: f32) -> Vec3 {
    ride.map_or(position, |ride| {
        ride.at(f64::from(time)).inverse().transform_point3(position.as_dvec3()).as_vec3()
    })
}

fn rounded(matrix: &glam::DAffine3) -> Affine3A {
    Affine3A::from_cols_array(&matrix.to_cols_array().map(|v| v as f32))
}

/// What the paths of a picture met.
#[derive(Clone, Debug)]
pub struct FeatureFilm {
    frame: Frame,
    sums: Vec<Sum>,
}

impl FeatureFilm {
    /// Bytes of a pixel: none where no layer of the job needs a film.
    pub fn bytes(job: &Job) -> u64 {
        if Features::asked(job) { size_of::<Sum>() as u64 } else { 0 }
    }

    /// A film that no path has come to, if a layer of the job needs one.
    pub fn new(job: &Job) -> Option<Self> {
        Features::asked(job).then(|| {
            let [width, height] = job.frame.size().map(|n| n as usize);
            Self { frame: job.frame, sums: vec![Sum::default(); width * height] }
        })
    }

    /// What the paths of a tile met.
    pub(crate) fn tile(&self, tile: &Tile) -> FeatureSums {
        FeatureSums(tile.cut(&self.frame, &self.sums))
    }

    /// Takes over the pixels of a tile.
    pub(crate) fn put(&mut self, tile: &Tile, sums: &FeatureSums) {
        tile.paste(&self.frame, &sums.0, &mut self.sums);
    }

    /// Adds what later paths of a tile met.
    pub fn add(&mut self, tile: &Tile, more: &Features) {
        let mut sums = self.tile(tile);
        sums.add(&more.sums);
        self.put(tile, &sums);
    }

    /// One of the layers of first surfaces.
    pub(super) fn layer(&self, aov: Aov) -> Option<Layer> {
        let all = |value: &dyn Fn(&Sum) -> f64| -> Vec<f32> {
            self.sums.iter().map(|sum| single(value(sum))).collect()
        };
        let mean = |total: f64, weight: f64| if weight > 0.0 { total / weight } else { 0.0 };
        let id =
            |place: usize| move |sum: &Sum| f64::from(sum.ids.map_or(0, |ids| ids[place])) - 1.0;
        let vector = |names: [&str; 3], of: fn(&Sum) -> &[f64; 3]| {
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
            Aov::Coc => ("coc", vec![one("um", all(&|sum| mean(sum.coc, sum.weight[1])))]),
            Aov::Variance | Aov::Vignetting => return None,
        };
        Some(Layer { name: name.to_owned(), channels })
    }
}
