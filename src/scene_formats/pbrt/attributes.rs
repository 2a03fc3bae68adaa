//! The Attribute directive: defaults of parameters of the directives that follow.

use std::sync::Arc;

use super::SceneError;
use super::params::Params;
use super::reader::SceneReader;
use petzval_base::io::hint;

/// The groups of directives for which Attribute sets defaults.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Target {
    Shape,
    Light,
    Material,
    Medium,
    Texture,
}

impl Target {
    pub(super) const ALL: [Self; 5] =
        [Self::Shape, Self::Light, Self::Material, Self::Medium, Self::Texture];

    fn name(self) -> &'static str {
        match self {
            Self::Shape => "shape",
            Self::Light => "light",
            Self::Material => "material",
            Self::Medium => "medium",
            Self::Texture => "texture",
        }
    }
}

impl SceneReader {
    pub(super) fn attribute(&mut self) -> Result<(), SceneError> {
        let name = self.string()?;
        let params = self.params()?;
        let Some(target) = Target::ALL.into_iter().find(|target| target.name() == name) else {
            let names = Target::ALL.map(Target::name);
            let hint = hint(&name, names);
            let expected = format!("expected one of {}", names.join(", "));
            return self.refuse(format!("attributes of \"{name}\"{hint}"), &expected);
        };
        let defaults = Arc::make_mut(&mut self.state.attributes[target as usize]);
        defaults.retain(|param| params.find(&param.name).is_none());
        defaults.extend(params.all);
        Ok(())
    }

    /// Adds the defaults of a target to the parameters of a directive: those that are `read` by its
    /// kind and not given.
    pub(super) fn add_defaults(
        &self,
        target: Target,
        read: impl Fn(&str) -> bool,
        params: &mut Params,
    ) {
        // The last parameter of a name counts.
        for param in self.state.attributes[target as usize].iter().rev() {
            if params.find(&param.name).is_none() && read(&param.name) {
                params.all.push(param.clone());
            }
        }
    }
}
