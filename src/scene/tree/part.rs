//! What a tree is built of, without a copy of it.

use glam::Vec3;

use crate::scene::mesh::Mesh;

/// A thing of the scene that goes into a tree.
#[derive(Clone, Copy, Debug)]
pub(in crate::scene) enum Part<'a> {
    /// The triangles of a mesh.
    Mesh {
        /// Its index among the scene's shapes.
        shape: u32,
        /// Its triangles.
        mesh: &'a Mesh,
        /// Whether it has holes that only its alpha knows.
        cutout: bool,
    },
    /// Another shape of the scene, in its box.
    Quadric(u32, [Vec3; 2]),
    /// An instance of the scene, in its box.
    Instance(u32, [Vec3; 2]),
}

/// All things of a tree, and the numbers of their items: a mesh has one for each triangle.
#[derive(Debug, Default)]
pub(in crate::scene) struct Parts<'a> {
    parts: Vec<Part<'a>>,
    /// The number behind the last item of each part.
    ends: Vec<usize>,
}

impl<'a> Parts<'a> {
    /// Adds one.
    pub(in crate::scene) fn push(&mut self, part: Part<'a>) {
        let items = match part {
            Part::Mesh { mesh, .. } => mesh.triangles.len(),
            _ => 1,
        };
        self.ends.push(self.len() + items);
        self.parts.push(part);
    }

    /// How many items there are.
    pub(super) fn len(&self) -> usize {
        self.ends.last().copied().unwrap_or(0)
    }

    /// The part that an item belongs to, and its number there.
    pub(super) fn find(&self, item: usize) -> (&Part<'a>, u32) {
        let i = self.ends.partition_point(|&end| end <= item);
        let start = if i == 0 { 0 } else { self.ends[i - 1] };
        (&self.parts[i], (item - start) as u32)
    }

    /// Whether an item is a triangle.
    pub(super) fn is_triangle(&self, item: usize) -> bool {
        matches!(self.find(item).0, Part::Mesh { .. })
    }

    /// Every item that a ray can hit, with its box: those at places that are no numbers cannot.
    pub(super) fn boxes(&self) -> impl Iterator<Item = (u32, [Vec3; 2])> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        let all = self.parts.iter().zip(starts).flat_map(|(part, start)| {
            let (mesh, lone) = match *part {
                Part::Mesh { mesh, .. } => (Some(mesh), None),
                Part::Quadric(_, bounds) | Part::Instance(_, bounds) => (None, Some(bounds)),
            };
            let triangles = mesh.into_iter().flat_map(|mesh| {
                (0..mesh.triangles.len() as u32).map(|triangle| {
                    let [a, b, c] = mesh.corners(triangle);
                    // A sum is a number only where all of its terms are.
                    if (a + b + c).is_finite() {
                        [a.min(b).min(c), a.max(b).max(c)]
                    } else {
                        [Vec3::NAN; 2]
                    }
                })
            });
            (start as u32..).zip(lone.into_iter().chain(triangles))
        });
        all.filter(|(_, [low, high])| low.is_finite() && high.is_finite())
    }
}
