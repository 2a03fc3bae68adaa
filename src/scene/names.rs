//! Names of the parts of a scene, as its file gives them.

use std::borrow::Cow;
use std::collections::HashMap;

use super::{PlacedShape, Scene};
use petzval_base::rays::NO_INDEX;

/// Names of shapes, objects and materials. Those of shapes and objects are unique: of equal names, the second
/// becomes `name.001`. Parts without a name are called by their index.
#[derive(Clone, Debug, Default)]
pub struct SceneNames {
    shapes: UniqueNames,
    objects: UniqueNames,
    /// Several materials may share a name: the variants of one in the file do.
    materials: HashMap<u32, Box<str>>,
}

impl SceneNames {
    /// Returns the name of a shape.
    pub fn shape(&self, index: u32) -> Cow<'_, str> {
        name_or_index(&self.shapes.by_index, "shape", index)
    }

    /// Returns the name of an object.
    pub fn object(&self, index: u32) -> Cow<'_, str> {
        name_or_index(&self.objects.by_index, "object", index)
    }

    /// Returns the name of a material.
    pub fn material(&self, index: u32) -> Cow<'_, str> {
        name_or_index(&self.materials, "material", index)
    }

    /// Returns the name that the scene file gives to a shape.
    pub fn given_to_shape(&self, index: u32) -> Option<&str> {
        self.shapes.by_index.get(&index).map(|name| &**name)
    }

    /// Returns the name that the scene file gives to an object.
    pub fn given_to_object(&self, index: u32) -> Option<&str> {
        self.objects.by_index.get(&index).map(|name| &**name)
    }

    pub(super) fn set_shape(&mut self, index: u32, name: &str) {
        self.shapes.set(index, name);
    }

    pub(super) fn set_object(&mut self, index: u32, name: &str) {
        self.objects.set(index, name);
    }

    pub(super) fn set_material(&mut self, index: u32, name: &str) {
        self.materials.insert(index, name.into());
    }
}

impl Scene {
    /// Returns the name of a shape in its place: that of the shape or, of a copy in an instance,
    /// `object#instance/shape`.
    pub fn placed_name(&self, placed: PlacedShape) -> String {
        let shape = self.names.shape(placed.shape);
        match placed.instance {
            NO_INDEX => shape.into_owned(),
            instance => format!("{}#{instance}/{shape}", self.asset_name(placed)),
        }
    }

    /// Returns the name of the asset that a shape belongs to: its object, which all instances share, or the shape
    /// itself outside objects.
    pub fn asset_name(&self, placed: PlacedShape) -> Cow<'_, str> {
        match placed.instance {
            NO_INDEX => self.names.shape(placed.shape),
            instance => self.names.object(self.object_of(instance)),
        }
    }
}

impl Scene {
    /// Returns the name that the scene file gives to the asset of a shape, as [`Self::asset_name`].
    pub fn given_asset_name(&self, placed: PlacedShape) -> Option<&str> {
        match placed.instance {
            NO_INDEX => self.names.given_to_shape(placed.shape),
            instance => self.names.given_to_object(self.object_of(instance)),
        }
    }
}

fn name_or_index<'a>(names: &'a HashMap<u32, Box<str>>, kind: &str, index: u32) -> Cow<'a, str> {
    match names.get(&index) {
        Some(name) => Cow::Borrowed(name),
        None => Cow::Owned(format!("{kind} {index}")),
    }
}

/// Names by index, of which no two are equal.
#[derive(Clone, Debug, Default)]
struct UniqueNames {
    by_index: HashMap<u32, Box<str>>,
    /// The number of times that each name was given or made.
    uses: HashMap<Box<str>, u32>,
}

impl UniqueNames {
    fn set(&mut self, index: u32, name: &str) {
        let mut unique = name.to_owned();
        while let Some(uses) = self.uses.get_mut(&unique[..]) {
            *uses += 1;
            let number = *uses - 1;
            unique = format!("{name}.{number:03}");
            if !self.uses.contains_key(&unique[..]) {
                break;
            }
            // Another part was given the name that this one would have: the next number is tried.
            unique = name.to_owned();
        }
        self.uses.insert(unique.clone().into(), 1);
        self.by_index.insert(index, unique.into());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_names_get_numbers_that_no_other_part_has() {
        let mut names = SceneNames::default();
        for (index, name) in
            ["leaf", "leaf.001", "leaf", "leaf", "leaf.001"].into_iter().enumerate()
        {
            names.set_shape(index as u32, name);
        }
        let found: Vec<_> = (0..6).map(|index| names.shape(index).into_owned()).collect();
        assert_eq!(found, ["leaf", "leaf.001", "leaf.002", "leaf.003", "leaf.001.001", "shape 5"]);
    }

    #[test]
    fn materials_may_share_a_name() {
        let mut names = SceneNames::default();
        names.set_material(0, "oak");
        names.set_material(1, "oak");
        assert_eq!([0, 1, 2].map(|i| names.material(i).into_owned()), ["oak", "oak", "material 2"]);
    }
}
