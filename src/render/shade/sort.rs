//! Counting sort of a wave's hits by the kind of their material, then by material.

use std::ops::Range;

use super::ShadeInputs;
use super::bsdf::{BsdfKind, KIND_COUNT};
use super::hit_material::resolve_mixture;
use super::vertices::Vertices;
use petzval_base::lanes::Real;
use petzval_base::rays::{Hit, NO_INDEX};
use petzval_scene::SurfaceInputs;

/// Vertices of one material.
#[derive(Clone, Debug)]
pub(super) struct MaterialRun {
    pub(super) kind: BsdfKind,
    /// Whether the material needs texture coordinates and surface derivatives.
    pub(super) derivatives: bool,
    /// Index of the material.
    pub(super) material: u32,
    /// Range in the columns.
    pub(super) range: Range<usize>,
}

impl Vertices {
    /// Determines the material of every hit, and sorts the hits by it. Paths that end and rays that
    /// miss get no vertex.
    pub(super) fn sort(&mut self, inputs: &ShadeInputs) {
        let ShadeInputs { scene, vertex, rays, hits, .. } = inputs;
        self.kinds.clear();
        self.runs.clear();
        self.counts.resize(scene.materials.len() + scene.media.len(), 0);
        for i in 0..rays.len {
            let hit = &hits[i];
            if hit.shape == NO_INDEX || vertex.ends_path(rays.flags[i]) {
                self.kinds.push((BsdfKind::Interface, NO_INDEX));
                continue;
            }
            let (material, kind) = match hit.shape {
                // Media follow the materials.
                Hit::IN_MEDIUM => match hit.primitive {
                    NO_INDEX => (NO_INDEX, BsdfKind::Interface),
                    medium => (scene.materials.len() as u32 + medium, BsdfKind::Medium),
                },
                _ if scene.leaves_subsurface(hit, rays.medium[i]) => {
                    let medium = scene.materials.len() as u32 + rays.medium[i];
                    (medium, BsdfKind::SubsurfaceExit)
                }
                shape => {
                    let material = scene.shapes[shape as usize].material;
                    let (ray, context) = (|| rays.ray(i), || inputs.single_context(i));
                    resolve_mixture(scene, material, ray, context)
                }
            };
            self.kinds.push((kind, material));
            if material == NO_INDEX {
                continue;
            }
            let count = &mut self.counts[material as usize];
            *count += 1;
            if *count == 1 {
                let derivatives = (material as usize) < scene.materials.len()
                    && scene.needs_derivatives(material);
                self.runs.push(MaterialRun { kind, derivatives, material, range: 0..0 });
            }
        }
        self.place_runs();
        self.order.clear();
        self.order.resize(self.end(), 0);
        for (i, &(_, material)) in self.kinds.iter().enumerate() {
            if material != NO_INDEX {
                let next = &mut self.counts[material as usize];
                self.order[*next as usize] = i as u32;
                *next += 1;
            }
        }
        for run in &self.runs {
            self.counts[run.material as usize] = 0;
        }
    }

    /// Assigns ranges to the runs, of which [`Self::counts`] holds the lengths. Every kind begins
    /// at a whole packet. Leaves the first entry of every run in the counts.
    fn place_runs(&mut self) {
        self.runs.sort_unstable_by_key(|run| (run.kind as u8, run.derivatives, run.material));
        let mut end = 0;
        let mut runs = self.runs.iter_mut().peekable();
        for kind in BsdfKind::ALL {
            let start = end;
            while let Some(run) = runs.next_if(|run| run.kind == kind) {
                let count = &mut self.counts[run.material as usize];
                run.range = end..end + *count as usize;
                (*count, end) = (end as u32, run.range.end);
            }
            self.ranges[kind as usize] = start..end;
            end = end.next_multiple_of(8);
        }
    }

    /// Loads the surface points of all vertices.
    pub(super) fn load_surfaces<R: Real<Scalar = f32>>(&mut self, inputs: &ShadeInputs) {
        let ShadeInputs { scene, rays, hits, .. } = *inputs;
        let mut runs = self.runs.iter().peekable();
        while let Some(MaterialRun { kind, derivatives, range, .. }) = runs.next() {
            // Successive runs of a kind that need the same.
            let mut end = range.end;
            while let Some(more) =
                runs.next_if(|more| (more.kind, more.derivatives) == (*kind, *derivatives))
            {
                end = more.range.end;
            }
            let order = &self.order[range.start..end];
            if *kind == BsdfKind::Medium {
                self.surfaces.load_collisions(rays, hits, order, range.start);
                continue;
            }
            let inputs = SurfaceInputs { rays, hits, order, derivatives: *derivatives };
            scene.load_surfaces::<R>(&inputs, range.start, &mut self.surfaces);
        }
    }
}

const _: () = assert!(KIND_COUNT <= petzval_base::rays::MAX_GROUPS, "a group for every kind");
