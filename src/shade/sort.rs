//! Sorting of a wave's hits by the kind of their material, and the light that they emit.

use glam::Vec3;

use super::ShadeInputs;
use super::bsdf_kind::{BsdfKind, KIND_COUNT, resolve_mixture};
use super::bsdf_parameters::{bsdf_parameters, coated_conductor, coated_diffuse};
use super::footprint::SpecularBounce;
use super::mis::power_heuristic;
use super::shading_context::ShadingContext;
use super::spawn::max_component;
use super::vertices::{Vertices, set};
use crate::rays::{Column, NO_INDEX, Ray, RayBatch, RayDifferential};
use crate::scene::{Material, SurfacePoint};

impl ShadeInputs<'_> {
    /// Returns the context of the i-th ray's hit, which lies at `point`.
    pub(super) fn context(&self, i: usize, point: SurfacePoint) -> ShadingContext<'_> {
        let Self { scene, vertex, rays, hits } = self;
        let context = ShadingContext::new(scene, &vertex.footprint, rays.ray(i), hits[i], point);
        match vertex.depth > 0 && scene.is_textured() {
            true => context.with_differential(rays.differential[i]),
            false => context,
        }
    }

    /// Returns the differential of the i-th ray after a smooth surface that it hits at `point`.
    pub(super) fn differential_after_bounce(
        &self,
        i: usize,
        point: SurfacePoint,
        bounce: &SpecularBounce,
    ) -> RayDifferential {
        let unknown = self.rays.differential[i] == RayDifferential::UNKNOWN;
        match self.vertex.depth > 0 && unknown {
            true => RayDifferential::UNKNOWN,
            false => self.context(i, point).differential_after_bounce(bounce),
        }
    }

    /// Adds light that the i-th ray found without a shadow ray to its sample. Sampling of lights
    /// would have found it with the density `light_pdf`.
    #[inline(always)]
    fn add_emission(
        &self,
        i: usize,
        light: [f32; 3],
        light_pdf: f32,
        radiance: &mut [Column<f32>; 3],
    ) {
        let rays = self.rays;
        // Only the lens can choose the direction of a camera ray.
        let pdf = if self.vertex.depth == 0 { f32::INFINITY } else { rays.pdf[i] };
        let (weight, slot) = (power_heuristic(pdf, light_pdf), rays.slot[i] as usize);
        let throughput = rays.throughput(i);
        for channel in 0..3 {
            radiance[channel][slot] += throughput[channel] * light[channel] * weight;
        }
    }

    /// Returns the i-th ray's scale of the throughput for Russian roulette.
    fn roulette_scale(&self, i: usize) -> f32 {
        match self.vertex.depth {
            0 => 1.0 / max_component(self.rays.throughput(i)).max(f32::MIN_POSITIVE),
            _ => self.rays.roulette_scale[i],
        }
    }

    /// Continues the i-th ray straight on through a surface that does not scatter.
    fn pass_through(&self, i: usize, point: SurfacePoint, next: &mut RayBatch) {
        let (rays, ray) = (self.rays, self.rays.ray(i));
        let direction = Vec3::from(ray.direction);
        let origin = point.offset_origin(direction).to_array();
        let ray = Ray { origin, direction: ray.direction, t_max: f32::INFINITY };
        next.push(ray, rays.throughput(i), rays.slot[i]);
        let last = next.len - 1;
        (next.pdf[last], next.roulette_scale[last]) = (f32::INFINITY, self.roulette_scale(i));
        if self.scene.is_textured() {
            let straight = SpecularBounce { normal: point.normal, next: direction, eta2: 1.0 };
            next.differential[last] = self.differential_after_bounce(i, point, &straight);
        }
    }
}

impl Vertices {
    /// Determines the kind of every hit, and the range of each kind in the columns.
    pub(super) fn sort(&mut self, inputs: &ShadeInputs) {
        let ShadeInputs { scene, vertex, rays, hits } = inputs;
        self.kinds.clear();
        let mut counts = [0; KIND_COUNT + 1];
        for i in 0..rays.len {
            let hit = hits[i];
            if hit.shape == NO_INDEX || vertex.ends_path(rays.pdf[i]) {
                self.kinds.push((BsdfKind::Interface, NO_INDEX));
                continue;
            }
            let material = scene.shapes[hit.shape as usize].material;
            let (material, kind) = resolve_mixture(scene, material, || {
                inputs.context(i, scene.surface(&rays.ray(i), &hit).1)
            });
            self.kinds.push((kind, material));
            counts[kind as usize] += 1;
        }
        let mut start = 0;
        for (range, count) in self.ranges.iter_mut().zip(counts) {
            *range = start..start + count;
            start = range.end.next_multiple_of(8);
        }
        let len = start.max(self.points.len());
        self.ray.resize(len, 0);
        self.slot.resize(len, 0);
        self.points.resize(len, Default::default());
        self.shadow.resize(len, Default::default());
        self.roulette.resize(len, 0.0);
        self.seeds.resize(len, 0);
    }

    /// Fills the columns with the vertices of paths that go on, adds emitted light to `radiance`,
    /// and passes rays through surfaces that do not scatter on to `next`.
    pub(super) fn load(
        &mut self,
        inputs: &ShadeInputs,
        radiance: &mut [Column<f32>; 3],
        next: &mut RayBatch,
    ) {
        let ShadeInputs { scene, vertex, rays, hits } = inputs;
        let mut ends = self.ranges.clone().map(|range| range.start);
        self.coated_diffuse.clear();
        self.coated_conductor.clear();
        for i in 0..rays.len {
            let ray = rays.ray(i);
            let direction = Vec3::from(ray.direction);
            let origin = Vec3::from(ray.origin);
            if hits[i].shape == NO_INDEX {
                for &sky in &scene.lights.skies {
                    let light = scene.sky_radiance(sky, direction);
                    let pdf = scene.sky_density(sky, direction);
                    inputs.add_emission(i, light, pdf, radiance);
                }
                continue;
            }
            let (shape, point) = scene.surface(&ray, &hits[i]);
            if shape.light != NO_INDEX {
                let light = scene.emitted_radiance(&ray, &hits[i], point.normal, -direction);
                if light != [0.0; 3] {
                    let pdf = scene.area_light_density(origin, &hits[i], &point, direction);
                    inputs.add_emission(i, light, pdf, radiance);
                }
            }
            if vertex.ends_path(rays.pdf[i]) {
                continue;
            }
            let (kind, material) = self.kinds[i];
            if kind == BsdfKind::Interface {
                inputs.pass_through(i, point, next);
                continue;
            }
            let at = ends[kind as usize];
            ends[kind as usize] += 1;
            self.load_surface(
                at,
                kind,
                &scene.materials[material as usize],
                inputs.context(i, point),
            );
            self.ray[at] = i as u32;
            self.slot[at] = rays.slot[i];
            self.points[at] = point;
            self.roulette_scale[at] = inputs.roulette_scale(i);
            set(&mut self.wo, at, (-direction).to_array());
            set(&mut self.throughput, at, rays.throughput(i));
        }
    }

    /// Sets the shading frame and the BSDF of a vertex.
    fn load_surface(
        &mut self,
        at: usize,
        kind: BsdfKind,
        material: &Material,
        context: ShadingContext,
    ) {
        let perturbed = material.bump.is_some() || material.normal_map.is_some();
        let (normal, tangent) = match perturbed || material.is_anisotropic() {
            true => context.perturbed_normal(material),
            false => (
                context.point.shading_normal,
                context.point.shading_normal.any_orthonormal_vector(),
            ),
        };
        set(&mut self.normal, at, normal.to_array());
        set(&mut self.tangent, at, tangent.to_array());
        match kind {
            BsdfKind::CoatedDiffuse => {
                self.coated_diffuse.extend(coated_diffuse(material, &context));
            }
            BsdfKind::CoatedConductor => {
                self.coated_conductor.extend(coated_conductor(material, &context));
            }
            _ => {
                let parameters = bsdf_parameters(material, &context);
                for (column, parameter) in self.parameters.iter_mut().zip(parameters) {
                    column[at] = parameter;
                }
            }
        }
    }
}
