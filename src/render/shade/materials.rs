//! Shading frames and BSDF parameters of a wave's vertices, material by material.

use std::ops::Range;

use glam::Vec3;

use super::bsdf::{BsdfKind, Columns, MediumScattering, SubsurfaceExit};
use super::kind_stage::facing;
use super::neighbour_ray::{NeighbourRay, SpecularBounce};
use super::shading_context::ShadingContext;
use super::sort::MaterialRun;
use super::vertices::Vertices;
use super::{PixelFootprint, ShadeInputs};
use petzval_base::lanes::Real;
use petzval_base::lanes::vector::{select, splat};
use petzval_base::rays::{Hit, PathFlags, Ray, RayBatch, RayDifferential};
use petzval_scene::{DiffuseBoundary, Material, Medium, Scene, load_vector, store_vector};

impl ShadingContext {
    /// The context of one hit, as seen by the camera itself.
    pub(super) fn of_hit(
        scene: &Scene,
        footprint: &PixelFootprint,
        ray: &Ray,
        hit: &Hit,
    ) -> ShadingContext {
        let (shape, point) = scene.surface(ray, hit);
        let patch = scene.surface_derivatives(ray, hit);
        let smooth = shape.geometry.is_smooth();
        let solid = scene.has_solid_texture();
        let mut context = Self::new(point.into(), patch.into(), smooth, footprint, solid);
        context.vertex_colour = shape.geometry.vertex_colour(hit);
        context
    }
}

impl ShadeInputs<'_> {
    /// Returns the context of the i-th ray's hit.
    pub(super) fn single_context(&self, i: usize) -> ShadingContext {
        let Self { scene, vertex, rays, hits, .. } = self;
        let mut context = ShadingContext::of_hit(scene, &vertex.footprint, &rays.ray(i), &hits[i]);
        if let Some(known) = self.known_neighbours(i) {
            context.neighbours = known;
        }
        context
    }

    /// Returns the rays of the neighbouring samples of the i-th ray if its differential is known.
    fn known_neighbours(&self, i: usize) -> Option<[NeighbourRay; 2]> {
        let Self { scene, vertex, rays, hits, .. } = self;
        if vertex.depth == 0 || !scene.is_textured() {
            return None;
        }
        NeighbourRay::transferred(&rays.ray(i), hits[i].t, &rays.differential[i])
    }

    /// Returns the differential of the i-th ray after a smooth surface.
    pub(super) fn differential_after_bounce(
        &self,
        i: usize,
        bounce: &SpecularBounce,
    ) -> RayDifferential {
        let unknown = self.rays.differential[i] == RayDifferential::UNKNOWN;
        if self.vertex.depth > 0 && unknown {
            return RayDifferential::UNKNOWN;
        }
        let along = Vec3::from(self.rays.ray(i).direction);
        self.single_context(i).differential_after_bounce(along, bounce)
    }
}

impl Vertices {
    /// Loads what the vertices take over from their rays.
    pub(super) fn load_paths(&mut self, inputs: &ShadeInputs) {
        let RayBatch { direction, throughput, slot, .. } = inputs.rays;
        for at in self.indices() {
            let i = self.order[at] as usize;
            self.slot[at] = slot[i];
            self.flags[at] = inputs.flags(i) & PathFlags::INHERITED;
            self.roulette_scale[at] = inputs.roulette_scale(i);
            for axis in 0..3 {
                self.wo[axis][at] = -direction[axis][i];
                self.throughput[axis][at] = throughput[axis][i];
            }
        }
    }

    /// Sets the shading frames and the BSDF parameters of all vertices.
    pub(super) fn load_materials<R: Real<Scalar = f32>>(&mut self, inputs: &ShadeInputs) {
        let runs = std::mem::take(&mut self.runs);
        for run in runs.iter().filter(|run| run.kind != BsdfKind::Interface) {
            self.load_material::<R>(inputs, run);
        }
        self.runs = runs;
    }

    /// Makes smooth surfaces rougher on paths that have scattered before.
    pub(super) fn regularize(&mut self) {
        for (range, kind) in self.shaded_ranges() {
            let stage = kind.stage::<f32>();
            for at in range {
                if self.flags[at].contains(PathFlags::SCATTERED) {
                    stage.regularize(&mut self.parameters, at);
                }
            }
        }
    }

    /// Sets the shading frames and the parameters of a material.
    fn load_material<R: Real<Scalar = f32>>(&mut self, inputs: &ShadeInputs, run: &MaterialRun) {
        let scene = inputs.scene;
        if matches!(run.kind, BsdfKind::Medium | BsdfKind::SubsurfaceExit) {
            let medium = &scene.media[run.material as usize - scene.materials.len()];
            return self.load_medium::<R>(run, medium);
        }
        let material = &scene.materials[run.material as usize];
        if let Some(channel) = material.only_channel {
            self.end_wavelengths(run.range.clone(), channel);
        }
        if run.derivatives {
            return self.load_textured::<R>(inputs, run, material);
        }
        let (stage, zero) = (run.kind.stage::<R>(), [R::splat(0.0); 3]);
        let one_sided = stage.is_one_sided();
        for at in run.range.clone().step_by(R::LANES) {
            let normal = self.surfaces.shading_normals::<R>(at);
            let facing = facing(one_sided, normal, load_vector(&self.wo, at));
            store_vector(&mut self.normal, at, normal);
            store_vector(&mut self.facing, at, facing);
            // A tangent of 0 leaves the direction of the frame open.
            store_vector(&mut self.tangent, at, zero);
        }
        stage.fill(&material.model, &mut self.parameters, run.range.clone());
    }

    /// Ends all wavelengths of the paths at some vertices but one, which stands for all three.
    #[inline(never)]
    fn end_wavelengths(&mut self, range: Range<usize>, hero: usize) {
        for at in range {
            if self.flags[at].contains(PathFlags::ONE_WAVELENGTH) {
                continue;
            }
            self.flags[at] = self.flags[at] | PathFlags::ONE_WAVELENGTH;
            for (channel, throughput) in self.throughput.iter_mut().enumerate() {
                throughput[at] *= if channel == hero { 3.0 } else { 0.0 };
            }
        }
    }

    /// Sets the shading frames and the parameters of collisions in a medium, to which light comes
    /// from all sides, or of its boundary, to which it comes from the outside.
    fn load_medium<R: Real<Scalar = f32>>(&mut self, run: &MaterialRun, medium: &Medium) {
        let zero = [R::splat(0.0); 3];
        for at in run.range.clone().step_by(R::LANES) {
            let normal = self.surfaces.shading_normals::<R>(at);
            store_vector(&mut self.normal, at, normal);
            let facing = if medium.boundary.is_some() { normal } else { zero };
            store_vector(&mut self.facing, at, facing);
            store_vector(&mut self.tangent, at, zero);
        }
        let (parameters, range) = (&mut self.parameters, run.range.clone());
        match medium.boundary {
            Some(DiffuseBoundary { eta, entering, .. }) => {
                let exit = SubsurfaceExit { eta: R::splat(eta), entering: R::splat(entering) };
                exit.fill_in(&mut parameters[..], range);
            }
            None => MediumScattering { g: R::splat(medium.g) }.fill_in(&mut parameters[..], range),
        }
    }

    /// Sets the shading frames and the parameters of a material that varies over surfaces.
    #[inline(never)]
    fn load_textured<R: Real<Scalar = f32>>(
        &mut self,
        inputs: &ShadeInputs,
        run: &MaterialRun,
        material: &Material,
    ) {
        let perturbed = material.needs_shading_tangent();
        let own_tangents = perturbed && inputs.scene.has_tangents();
        let vertex_colours = inputs.scene.has_vertex_colours(run.material);
        let stage = run.kind.stage::<R>();
        let one_sided = stage.is_one_sided();
        for at in run.range.clone().step_by(R::LANES) {
            let lanes = R::LANES.min(run.range.end - at);
            let mut context = self.context::<R>(inputs, at, lanes);
            if own_tangents {
                for lane in 0..lanes {
                    let hit = &inputs.hits[self.order[at + lane] as usize];
                    if let Some(tangent) = inputs.scene.tangent(hit) {
                        context.set_tangent(lane, tangent);
                    }
                }
            }
            if vertex_colours {
                context.vertex_colour = Some(self.vertex_colours(inputs, at, lanes));
            }
            let [normal, tangent] = match perturbed {
                true => context.perturbed_normal(material),
                false => [context.points.shading_normal, [R::splat(0.0); 3]],
            };
            let facing = facing(one_sided, normal, load_vector(&self.wo, at));
            store_vector(&mut self.normal, at, normal);
            store_vector(&mut self.facing, at, facing);
            store_vector(&mut self.tangent, at, tangent);
            stage.store(&material.model, &context, &mut self.parameters, at);
        }
    }

    /// Returns the colours of the meshes' vertices at a packet of hits.
    fn vertex_colours<R: Real<Scalar = f32>>(
        &self,
        inputs: &ShadeInputs,
        at: usize,
        lanes: usize,
    ) -> [R; 4] {
        let mut colours = [[1.0; 8]; 4];
        for lane in 0..lanes {
            let hit = &inputs.hits[self.order[at + lane] as usize];
            let geometry = &inputs.scene.shapes[hit.shape as usize].geometry;
            if let Some(colour) = geometry.vertex_colour(hit) {
                (0..4).for_each(|channel| colours[channel][lane] = colour[channel]);
            }
        }
        colours.map(|channel| R::load(&channel))
    }

    /// Returns the context of a packet of vertices of one material.
    #[inline(always)]
    fn context<R: Real<Scalar = f32>>(
        &self,
        inputs: &ShadeInputs,
        at: usize,
        lanes: usize,
    ) -> ShadingContext<R> {
        let surfaces = &self.surfaces;
        let (points, smooth) = (surfaces.points(at), surfaces.smooth::<R>(at));
        let patch = surfaces.derivatives(at);
        let (footprint, solid) = (&inputs.vertex.footprint, inputs.scene.has_solid_texture());
        let mut context = ShadingContext::new(points, patch, smooth, footprint, solid);
        if inputs.vertex.depth > 0 {
            for lane in 0..lanes {
                if let Some(known) = inputs.known_neighbours(self.order[at + lane] as usize) {
                    context.set_neighbours(lane, &known);
                }
            }
        }
        context
    }
}

impl<R: Real<Scalar = f32>> ShadingContext<R> {
    /// Sets the direction of the shading frame in a lane to that of its mesh.
    fn set_tangent(&mut self, lane: usize, tangent: Vec3) {
        let mask = Self::only(lane);
        self.tangent = select(mask, splat(tangent.to_array()), self.tangent);
        self.smooth = self.smooth | mask;
    }

    /// Returns the mask of one lane.
    fn only(lane: usize) -> R::Mask {
        let mut mask = [0.0; 8];
        mask[lane] = 1.0;
        R::splat(0.0).lt(R::load(&mask))
    }

    /// Replaces the rays of the neighbouring samples in a lane.
    fn set_neighbours(&mut self, lane: usize, known: &[NeighbourRay; 2]) {
        let mask = Self::only(lane);
        for (ray, known) in self.neighbours.iter_mut().zip(known) {
            *ray = ray.or(mask, &known.splat());
        }
    }
}
