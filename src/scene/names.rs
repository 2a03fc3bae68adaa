//! Names of the parts of a scene, as its file gives them.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::Arc;

use super::{PlacedShape, Scene};
use petzval_base::rays::NO_INDEX;

/// Names of shapes, objects and materials. Of equal names of objects and shapes outside objects, or of shapes in
/// objects, the second becomes `name.001`. Parts without a name are called by their index.
#[derive(Clone, Debug, Default)]
pub struct SceneNames {
    shapes: BTreeMap<u32, Arc<str>>,
    objects: BTreeMap<u32, Arc<str>>,
    /// Names of the assets of shapes, where the file gives them.
    assets: BTreeMap<u32, Arc<str>>,
    /// Several materials may share a name: the variants of one in the file do.
    materials: BTreeMap<u32, Arc<str>>,
    /// Names of objects and of shapes outside them, of shapes in objects, and of other assets.
    taken: [UniqueNames; 3],
}

impl SceneNames {
    /// Returns the name of a shape.
    pub fn shape(&self, index: u32) -> Cow<'_, str> {
        name_or_index(&self.shapes, "shape", index)
    }

    /// Returns the name of an object.
    pub fn object(&self, index: u32) -> Cow<'_, str> {
        name_or_index(&self.objects, "object", index)
    }

    /// Returns the name of a material.
    pub fn material(&self, index: u32) -> Cow<'_, str> {
        name_or_index(&self.materials, "material", index)
    }

    /// Names a shape outside objects, or in one.
    pub(super) fn set_shape(&mut self, index: u32, name: &str, in_object: bool) {
        let name = self.taken[usize::from(in_object)].unique(name);
        self.shapes.insert(index, name);
    }

    pub(super) fn set_object(&mut self, index: u32, name: &str) {
        let name = self.taken[0].unique(name);
        self.objects.insert(index, name);
    }

    /// Returns a name for an asset that no other one has from here.
    pub(super) fn unique(&mut self, name: &str) -> Arc<str> {
        self.taken[2].unique(name)
    }

    pub(super) fn set_asset(&mut self, shape: u32, name: &str) {
        self.assets.insert(shape, name.into());
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

    /// Returns the name of the asset that a shape belongs to, which all its copies share: that of the file, its object, or the
    /// shape itself outside objects.
    pub fn asset_name(&self, placed: PlacedShape) -> Cow<'_, str> {
        match (self.given_asset_name(placed), placed.instance) {
            (Some(name), _) => Cow::Borrowed(name),
            (None, NO_INDEX) => self.names.shape(placed.shape),
            (None, instance) => self.names.object(self.object_of(instance)),
        }
    }

    /// Returns the same as [`Self::asset_name`] if the scene file gives the name.
    pub fn given_asset_name(&self, placed: PlacedShape) -> Option<&str> {
        let SceneNames { shapes, objects, assets, .. } = &*self.names;
        let name = assets.get(&placed.shape).or_else(|| match placed.instance {
            NO_INDEX => shapes.get(&placed.shape),
            instance => objects.get(&self.object_of(instance)),
        });
        name.map(|name| &**name)
    }
}

fn name_or_index<'a>(names: &'a BTreeMap<u32, Arc<str>>, kind: &str, index: u32) -> Cow<'a, str> {
    match names.get(&index) {
        Some(name) => Cow::Borrowed(name),
        None => Cow::Owned(format!("{kind} {index}")),
    }
}

/// Names of which no two are equal, with the number of times that each was asked for.
#[derive(Clone, Debug, Default)]
struct UniqueNames(BTreeMap<Arc<str>, u32>);

impl UniqueNames {
    /// Returns a name that no other part has: the one asked for, or that with a number.
    fn unique(&mut self, name: &str) -> Arc<str> {
        let mut unique: Arc<str> = name.into();
        while self.0.contains_key(&unique) {
            let uses = self.0.entry(name.into()).or_insert(0);
            unique = format!("{name}.{uses:03}").into();
            *uses += 1;
        }
        self.0.insert(unique.clone(), 1);
        unique
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_names_get_numbers_that_no_other_part_has() {
        let mut names = SceneNames::default();
        let given = ["leaf", "leaf.001", "leaf", "leaf", "leaf.001"];
        for (index, name) in (0..).zip(given) {
            names.set_shape(index, name, false);
        }
        names.set_object(0, "leaf");
        names.set_shape(6, "leaf", true);
        let found: Vec<_> = (0..7).map(|index| names.shape(index).into_owned()).collect();
        let expected =
            ["leaf", "leaf.001", "leaf.002", "leaf.003", "leaf.001.001", "shape 5", "leaf"];
        assert_eq!(found, expected);
        assert_eq!(names.object(0), "leaf.004");
    }

    #[test]
    fn materials_may_share_a_name() {
        let mut names = SceneNames::default();
        names.set_material(0, "oak");
        names.set_material(1, "oak");
        assert_eq!([0, 1, 2].map(|i| names.material(i).into_owned()), ["oak", "oak", "material 2"]);
    }
}
