//! Walk of light paths through the scene, and their connections to the lens.

use glam::{DVec3, Vec3};

use super::Caustics;
use super::start::PathStart;
use crate::advance::{PathColumns, VertexStages};
use crate::light_tracing::entry::EntryPoint;
use crate::light_tracing::light_paths::{
    CameraPose, CameraPoses, LightPath, LightPathInput, LightPaths,
};
use crate::shade::{PathVertex, PixelFootprint, ShadeInputs, shade_light_paths};
use petzval_base::lanes::Real;
use petzval_base::rays::{PathFlags, SampleBatch, WAVE_SIZE};
use petzval_base::sampler::{Dimension, sample_2d};
use petzval_lens::{LensModel, RealLens};
use petzval_scene::{PathLimits, Surroundings};

/// Depth of the first vertex of a path, on a caster.
const CASTER: u32 = 1;

/// Connection of a path to the lens.
#[derive(Clone, Copy, Debug, Default)]
struct Connection {
    /// Entry point in the plane of the front vertex (mm).
    at: [f64; 2],
    /// Unit vector from there to the surface, in the frame of the camera.
    towards: DVec3,
    /// Factor from the contribution of the surface to the flux that enters (mm^2 sr per world
    /// units^2 sr).
    factor: f64,
}

/// Columns of one worker.
#[derive(Default)]
pub(crate) struct CausticColumns {
    samples: Box<SampleBatch>,
    paths: PathColumns,
    connections: ConnectionColumns,
}

/// Columns of the connections of paths to the lens.
#[derive(Default)]
struct ConnectionColumns {
    /// Start of each path, by slot.
    starts: Vec<PathStart>,
    /// Connection of each path at its present surface, by slot.
    connections: Vec<Connection>,
    /// Paths that are connected.
    paths: Box<LightPaths>,
    /// Factor of refraction on the throughput of each path, by slot.
    eta2: Vec<f32>,
    /// Slot of each path that is connected.
    slots: Vec<u32>,
}

/// Light paths that were connected to the lens.
pub(super) struct Connected<'a> {
    pub paths: &'a mut LightPaths,
    /// Slot of each path.
    pub slots: &'a [u32],
    /// Starts, by slot.
    pub starts: &'a [PathStart],
}

impl Caustics {
    /// Walks a wave of paths. `found` gets the paths of each surface that were connected to the lens.
    pub(super) fn walk<R: Real<Scalar = f32>>(
        &self,
        input: &LightPathInput<'_>,
        columns: &mut CausticColumns,
        wave: [u32; 2],
        found: &mut dyn FnMut(Connected),
    ) {
        let LensModel::Real(lens) = &input.camera.model else { return };
        let CausticColumns { samples, paths, connections: columns } = columns;
        self.start(input, samples, &mut paths.rays, &mut columns.starts, wave);
        columns.eta2.resize(WAVE_SIZE, 1.0);
        let mut stages = CausticPaths { caustics: self, input, lens, columns, found };
        let footprint = PixelFootprint::new(input.camera, input.frame.resolution);
        let max_depth = input.path_limits.max_depth;
        // Depth 0 is that of camera rays.
        let limits = PathLimits { max_depth: max_depth + 1, ..input.path_limits };
        for depth in CASTER..=max_depth {
            if paths.rays.len == 0 {
                break;
            }
            let vertex = PathVertex { depth, limits, footprint };
            paths.advance::<R>(input.scene, samples, vertex, &mut stages);
        }
    }

    /// Samples the connection of a surface to the lens. Returns it with the vector to the entry
    /// point in the world.
    fn connection(
        &self,
        pose: &CameraPose,
        lens: &RealLens,
        position: Vec3,
        u: [f32; 2],
    ) -> Option<(Connection, Vec3)> {
        let place = pose.camera_from_world.transform_point3(position.as_dvec3());
        // Right, up and before the front vertex (mm).
        let from = (place - DVec3::Z * lens.front_depth) / lens.units_per_mm;
        if from.z <= 0.0 {
            return None;
        }
        let EntryPoint { at, density } = self.entry.sample(from, u);
        let way = from - DVec3::new(at[0], at[1], 0.0);
        let towards = way.try_normalize()?;
        let to_lens = pose.front_point(lens, at) - position;
        let distance2 = f64::from(to_lens.length_squared());
        let factor = towards.z / (distance2 * density);
        factor.is_finite().then_some((Connection { at, towards, factor }, to_lens))
    }
}

/// The stages of the paths of caustics.
struct CausticPaths<'a> {
    caustics: &'a Caustics,
    input: &'a LightPathInput<'a>,
    lens: &'a RealLens,
    columns: &'a mut ConnectionColumns,
    found: &'a mut dyn FnMut(Connected),
}

impl<R: Real<Scalar = f32>> VertexStages<R> for CausticPaths<'_> {
    fn arrive(&mut self, surroundings: &Surroundings, paths: &mut PathColumns) {
        let ConnectionColumns { starts, eta2, .. } = &mut *self.columns;
        if surroundings.depth == CASTER {
            self.caustics.keep_unoccluded(starts, paths);
        }
        for i in 0..paths.rays.len {
            eta2[paths.rays.slot[i] as usize] = paths.rays.roulette_scale[i];
        }
    }

    /// Shades the surfaces that the rays hit. The first only reflects or refracts.
    fn shade(&mut self, vertex: PathVertex, samples: &SampleBatch, paths: &mut PathColumns) {
        let PathColumns { rays, hits, shade, shadows, next, .. } = paths;
        let Self { caustics, input, lens, .. } = *self;
        let connections = &mut self.columns.connections;
        connections.clear();
        connections.resize(WAVE_SIZE, Connection::default());
        let inputs = ShadeInputs {
            scene: input.scene,
            vertex,
            rays,
            hits,
            lamp_weights: None,
            caustics: false,
            hides_sky: false,
        };
        let poses = CameraPoses::new(input.camera, input.timing);
        let mut target = |slot: u32, position: Vec3| -> Option<Vec3> {
            if vertex.depth == CASTER {
                return None;
            }
            let at = slot as usize;
            let u = sample_2d(samples.key[at], samples.sample[at], Dimension::Light(vertex.depth));
            let (connection, towards_lens) =
                caustics.connection(&poses.at(samples.time[at]), lens, position, u)?;
            connections[at] = connection;
            Some(towards_lens)
        };
        shade_light_paths::<R>(&inputs, samples, shade, &mut target, (shadows, next));
        if vertex.depth == CASTER {
            next.retain(|next, i| next.flags[i].contains(PathFlags::SPECULAR));
        }
    }

    /// Starts the connections at the lens. Their shadow rays are traced for paths that arrive on the
    /// film.
    fn connect(&mut self, surroundings: &Surroundings, paths: &mut PathColumns) {
        let (samples, shadows) = (surroundings.samples, &paths.shadows);
        let ConnectionColumns { starts, connections, paths, eta2, slots } = &mut *self.columns;
        if shadows.len == 0 {
            return;
        }
        paths.clear();
        slots.clear();
        for i in 0..shadows.len {
            let slot = shadows.slot[i] as usize;
            let Connection { at, towards, factor } = connections[slot];
            let factor = factor * starts[slot].flux * f64::from(eta2[slot]);
            let path = LightPath {
                start: self.caustics.front.start(at, towards),
                towards,
                shadow: shadows.ray(i),
                time: starts[slot].time,
                sample: [samples.key[slot], samples.sample[slot]],
            };
            let flux = shadows.throughput(i).map(|c| (f64::from(c) * factor) as f32);
            paths.push(&path, flux, [0.0; 2]);
            slots.push(slot as u32);
        }
        (self.found)(Connected { paths, slots, starts });
    }
}
