//! Light sampling stage: a light and a point of it for every vertex of a wave.

use glam::Vec2;

use super::area_sampling::EmitterPoints;
use super::choose::{ChosenLights, Descents};
use super::reception::{GlossyLobe, LobeColumns, Reception};
use super::sampler::EmitterClass;
use super::visible_cap::SpherePacket;
use super::{AreaLight, Light, SkySampling};
use crate::geometry::{DiskPacket, TriangleLanes};
use crate::{Geometry, Scene, SurfaceColumns, SurfacePacket, VectorColumns};
use petzval_base::lanes::vector::{normalize, select};
use petzval_base::lanes::{LaneIndices, Real};
use petzval_base::rays::SortedColumn;

/// Vertices for which lights are sampled.
#[derive(Clone, Copy, Debug)]
pub struct LightInputs<'a> {
    /// Surface points, world space.
    pub surfaces: &'a SurfaceColumns,
    /// Unit normals on the side from which light counts; 0 if it counts from both sides.
    pub facing: &'a VectorColumns,
    /// Lobes of glossy surfaces, which make lights in them more probable. `None` if lights are selected
    /// as if all surfaces scattered widely.
    pub lobes: Option<LobeColumns<'a>>,
    /// Numbers in [0, 1) that select a light.
    pub choice: &'a [SortedColumn<f32>; 2],
    /// Numbers in [0, 1) that select a point of it.
    pub u: &'a [SortedColumn<f32>; 2],
    /// Entries of the columns to sample for.
    pub entries: &'a [u32],
}

/// Sampled lights in columns, world space.
#[derive(Clone, Debug, Default)]
pub struct LightSamples {
    /// Unit vector to the sampled point; any unit vector if there is no sample.
    pub wi: VectorColumns,
    /// Radiance over the density of the sample; 0 if there is none.
    pub radiance: VectorColumns,
    /// Density of the sample, by solid angle (1/sr); infinite if no other ray can hit the light.
    pub density: SortedColumn<f32>,
    /// Direction of the shadow ray.
    pub shadow: VectorColumns,
    /// End of the shadow ray, in lengths of its direction.
    pub shadow_end: SortedColumn<f32>,
}

/// Work columns of the stage.
#[derive(Clone, Debug, Default)]
pub struct LightColumns {
    pub(super) descents: Descents,
    pub(super) chosen: ChosenLights,
}

/// Emission of the emitters of a packet.
#[derive(Default)]
struct EmissionLanes {
    radiance: [[f32; 8]; 3],
    two_sided: [f32; 8],
}

impl LightInputs<'_> {
    /// Returns how the surfaces of a packet receive light.
    #[inline(always)]
    pub(super) fn reception<R: Real<Scalar = f32>>(&self, lanes: &LaneIndices) -> Reception<R> {
        let lobe = self.lobes.and_then(|LobeColumns { wo, alpha2, share }| {
            GlossyLobe::new(lanes.load_vector(wo), lanes.load(&alpha2[..]), lanes.load(&share[..]))
        });
        Reception { facing: lanes.load_vector(self.facing), lobe }
    }
}

impl LightSamples {
    /// Sets an entry without a sample. `normal` is any unit vector.
    pub fn clear(&mut self, at: usize, normal: [f32; 3]) {
        for axis in 0..3 {
            self.wi[axis][at] = normal[axis];
            self.radiance[axis][at] = 0.0;
        }
        self.density[at] = 1.0;
    }
}

impl Scene {
    /// Samples a light for every entry: a stage. The directions of skies that are darker than their
    /// mean are not sampled, see [`SkySampling::Compensated`].
    pub fn sample_lights<R: Real<Scalar = f32>>(
        &self,
        inputs: &LightInputs,
        columns: &mut LightColumns,
        samples: &mut LightSamples,
    ) {
        self.lights.choose_all::<R>(inputs, columns);
        let chosen = &columns.chosen;
        let group = |class: EmitterClass| chosen.groups[class as usize].chunks(R::LANES);
        let mut triangles = TriangleLanes::default();
        for entries in group(EmitterClass::Triangle) {
            let lanes = LaneIndices::new::<R>(entries);
            self.sample_areas(inputs, &lanes, chosen, samples, |from, u| {
                let mut meshes = [None; 8];
                for (lane, &at) in entries.iter().enumerate() {
                    let light = self.area_light(chosen, at);
                    if let Geometry::Mesh(mesh) = &self.shapes[light.shape as usize].geometry {
                        meshes[lane] = Some((mesh, chosen.primitive[at as usize]));
                    }
                }
                triangles.gather(&meshes, false);
                EmitterPoints::<R>::on_triangle(&triangles.load(), from.position, u).0
            });
        }
        for entries in group(EmitterClass::Disk) {
            let lanes = LaneIndices::new::<R>(entries);
            self.sample_areas(inputs, &lanes, chosen, samples, |_, u| {
                EmitterPoints::<R>::on_disk(&self.load_disks(chosen, entries), u)
            });
        }
        for entries in group(EmitterClass::Sphere) {
            let lanes = LaneIndices::new::<R>(entries);
            self.sample_areas(inputs, &lanes, chosen, samples, |from, u| {
                let spheres = self.load_spheres(chosen, entries);
                EmitterPoints::<R>::on_sphere(&spheres, from.position, u)
            });
        }
        for &at in &chosen.groups[EmitterClass::General as usize] {
            self.sample_one(inputs, at as usize, chosen, samples);
        }
        for &at in &chosen.none {
            samples.clear(at as usize, inputs.surfaces.shading_normal(at as usize));
        }
    }

    /// Samples area lights for a packet of entries, given how to sample points of their emitters.
    #[inline(always)]
    fn sample_areas<R: Real<Scalar = f32>>(
        &self,
        inputs: &LightInputs,
        lanes: &LaneIndices,
        chosen: &ChosenLights,
        samples: &mut LightSamples,
        points: impl FnOnce(&SurfacePacket<R>, [R; 2]) -> EmitterPoints<R>,
    ) {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let from: SurfacePacket<R> = inputs.surfaces.gather(lanes);
        let u = [lanes.load(&inputs.u[0][..]), lanes.load(&inputs.u[1][..])];
        let points = points(&from, u);
        let mut emission = EmissionLanes::default();
        for (lane, &at) in lanes.indices().iter().enumerate() {
            let light = self.area_light(chosen, at);
            let radiance = light.radiance(chosen.primitive[at as usize], Vec2::ZERO);
            for channel in 0..3 {
                emission.radiance[channel][lane] = radiance[channel];
            }
            emission.two_sided[lane] = f32::from(u8::from(light.emission.two_sided));
        }
        let two_sided = zero.lt(R::load(&emission.two_sided));
        let sample = points.connect(&from, two_sided);
        let density = sample.density * lanes.load::<R>(&chosen.probability[..]);
        let (wi, some) = normalize(sample.direction);
        let usable = sample.usable & some & zero.lt(density);
        let inverse = R::select(usable, one / density, zero);
        let mut radiance = [zero; 3];
        for channel in 0..3 {
            radiance[channel] = R::load(&emission.radiance[channel]) * inverse;
        }
        lanes.store_vector(select(usable, wi, from.shading_normal), &mut samples.wi);
        lanes.store_vector(radiance, &mut samples.radiance);
        lanes.store(R::select(usable, density, one), &mut samples.density[..]);
        lanes.store_vector(sample.direction, &mut samples.shadow);
        lanes.store(one, &mut samples.shadow_end[..]);
        let mut missing = lanes.lanes() & !R::bits(points.valid);
        while missing != 0 {
            let lane = missing.trailing_zeros() as usize;
            missing &= missing - 1;
            self.sample_one(inputs, lanes.indices()[lane] as usize, chosen, samples);
        }
    }

    /// Samples the selected light of one entry.
    #[inline(never)]
    fn sample_one(
        &self,
        inputs: &LightInputs,
        at: usize,
        chosen: &ChosenLights,
        samples: &mut LightSamples,
    ) {
        let point = inputs.surfaces.points::<f32>(at);
        let u = [inputs.u[0][at], inputs.u[1][at]];
        let compensated = SkySampling::Compensated;
        let sample = self.sample_choice(chosen.choice(at), &point.into(), u, compensated);
        let Some(sample) = sample.filter(|sample| sample.density > 0.0) else {
            return samples.clear(at, point.shading_normal);
        };
        let wi = sample.direction.normalize_or_zero();
        for axis in 0..3 {
            samples.wi[axis][at] = wi[axis];
            samples.radiance[axis][at] = sample.radiance[axis] / sample.density;
            samples.shadow[axis][at] = sample.direction[axis];
        }
        // No other ray can hit a singular light, so its own sample has the weight 1.
        samples.density[at] = if sample.singular { f32::INFINITY } else { sample.density };
        samples.shadow_end[at] = sample.t_max;
    }

    /// Returns the area light that an entry selected.
    #[inline(always)]
    fn area_light(&self, chosen: &ChosenLights, at: u32) -> &AreaLight {
        match &self.lights.all[chosen.light[at as usize] as usize] {
            Light::Area(light) => light,
            _ => unreachable!("classes of emitters are those of area lights"),
        }
    }

    /// Returns the disks that entries selected.
    #[inline(always)]
    fn load_disks<R: Real<Scalar = f32>>(
        &self,
        chosen: &ChosenLights,
        entries: &[u32],
    ) -> DiskPacket<R> {
        let mut lanes = [[0.0; 8]; 13];
        for (lane, &at) in entries.iter().enumerate() {
            let Some(disk) = &self.area_light(chosen, at).disk else { continue };
            let DiskPacket { centre, radii, normal, density } = disk;
            let numbers = centre.iter().chain(radii.as_flattened()).chain(normal).chain([density]);
            for (column, &number) in lanes.iter_mut().zip(numbers) {
                column[lane] = number;
            }
        }
        let vector = |first: usize| {
            [R::load(&lanes[first]), R::load(&lanes[first + 1]), R::load(&lanes[first + 2])]
        };
        DiskPacket {
            centre: vector(0),
            radii: [vector(3), vector(6)],
            normal: vector(9),
            density: R::load(&lanes[12]),
        }
    }

    /// Returns the spheres that entries selected.
    #[inline(always)]
    fn load_spheres<R: Real<Scalar = f32>>(
        &self,
        chosen: &ChosenLights,
        entries: &[u32],
    ) -> SpherePacket<R> {
        let mut lanes = [[0.0; 8]; 5];
        for (lane, &at) in entries.iter().enumerate() {
            let Some(sphere) = &self.area_light(chosen, at).sphere else { continue };
            let SpherePacket { centre, radius, side } = sphere;
            for (column, &number) in lanes.iter_mut().zip(centre.iter().chain([radius, side])) {
                column[lane] = number;
            }
        }
        let [x, y, z, radius, side] = &lanes;
        SpherePacket {
            centre: [R::load(x), R::load(y), R::load(z)],
            radius: R::load(radius),
            side: R::load(side),
        }
    }
}
