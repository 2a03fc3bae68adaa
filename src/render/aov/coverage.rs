//! Shares of a pixel that each shape covers.

use std::collections::BTreeMap;
use std::io;

use petzval_base::io::codec::{ChecksumReader, ChecksumWriter, invalid_data};
use petzval_base::rays::NO_INDEX;
use petzval_scene::{PlacedShape, Scene};

/// Typical number of shapes that a pixel sees, for estimates of memory.
const TYPICAL_SHAPES: usize = 4;

/// Numbers of shapes and instances of a scene.
#[derive(Clone, Copy, Debug)]
pub(super) struct SceneParts {
    pub shapes: usize,
    pub instances: usize,
}

impl SceneParts {
    pub fn of(scene: &Scene) -> Self {
        let moving = scene.animated_instances().len();
        let instances = scene.resting_instance_count() as usize + moving;
        Self { shapes: scene.shapes.len(), instances }
    }
}

/// Weights of the light paths of a pixel that meet each shape, in the order of shapes.
#[derive(Clone, Debug, Default)]
pub(super) struct Coverage(Vec<(PlacedShape, f64)>);

impl Coverage {
    /// The memory of a typical pixel (bytes).
    pub const TYPICAL_BYTES: u64 =
        (size_of::<Self>() + TYPICAL_SHAPES * size_of::<(PlacedShape, f64)>()) as u64;

    /// Adds the weight of a path that meets a shape.
    pub fn add(&mut self, shape: PlacedShape, weight: f64) {
        if self.0.last().is_none_or(|(last, _)| *last < shape) {
            self.0.push((shape, weight));
            return;
        }
        match self.0.binary_search_by_key(&shape, |(known, _)| *known) {
            Ok(found) => self.0[found].1 += weight,
            Err(place) => self.0.insert(place, (shape, weight)),
        }
    }

    /// Adds the weights of later paths.
    pub fn add_all(&mut self, other: &Self) {
        other.0.iter().for_each(|&(shape, weight)| self.add(shape, weight));
    }

    /// Returns the sum of the weights of all shapes that share an identifier, by identifier.
    pub fn by_id(&self, mut id: impl FnMut(PlacedShape) -> u32) -> BTreeMap<u32, f64> {
        let mut sums = BTreeMap::new();
        for &(shape, weight) in &self.0 {
            *sums.entry(id(shape)).or_insert(0.0) += weight;
        }
        sums
    }

    pub fn save(&self, to: &mut ChecksumWriter) -> io::Result<()> {
        to.u32(self.0.len() as u32)?;
        self.0.iter().try_for_each(|(PlacedShape { shape, instance }, weight)| {
            to.u32(*shape)?;
            to.u32(*instance)?;
            to.numbers(&[*weight])
        })
    }

    /// Adds the saved weights of later paths. Shapes are in ascending order, so that there are no more than in the scene.
    pub fn receive(&mut self, from: &mut ChecksumReader, parts: SceneParts) -> io::Result<()> {
        let mut last = None;
        for _ in 0..from.u32()? {
            let shape = from.below(parts.shapes, "shape of a pixel")? as u32;
            let instance = match from.u32()? {
                NO_INDEX => NO_INDEX,
                instance if (instance as usize) < parts.instances => instance,
                instance => return Err(invalid_data(format!("instance {instance} of a pixel"))),
            };
            let placed = PlacedShape { shape, instance };
            if last.is_some_and(|last| last >= placed) {
                return Err(invalid_data("shapes of a pixel out of order"));
            }
            last = Some(placed);
            let mut weight = 0.0;
            from.add_number(&mut weight)?;
            self.add(placed, weight);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_of_a_shape_add_up_in_any_order_of_shapes() {
        let at = |shape, instance| PlacedShape { shape, instance };
        let (mut one, mut other) = (Coverage::default(), Coverage::default());
        one.add(at(7, 2), 0.5);
        one.add(at(3, 9), 1.0);
        other.add(at(7, 2), 0.25);
        other.add(at(7, 1), 2.0);
        one.add_all(&other);
        assert_eq!(one.0, [(at(3, 9), 1.0), (at(7, 1), 2.0), (at(7, 2), 0.75)]);
        let by_shape = one.by_id(|placed| placed.shape);
        assert_eq!(by_shape.into_iter().collect::<Vec<_>>(), [(3, 1.0), (7, 2.75)]);
    }
}
