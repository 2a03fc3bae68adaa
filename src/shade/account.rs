//! What shading did with the only ray of a wave.

use super::kind::Kind;
use super::vertices::vector;
use super::{ShadeColumns, Vertex};
use crate::rays::{HitBatch, NONE, RayBatch};
use crate::scene::Scene;

/// What became of a path at a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fate {
    /// It goes on.
    GoesOn,
    /// It met nothing.
    Escapes,
    /// It has met as many surfaces as it may; this one only shines.
    Deepest,
    /// Nothing is left of it.
    Absorbed,
    /// Its light came by the shadow ray, and no other ray is needed.
    Complete,
    /// Russian roulette ended it, where it had this chance to go on.
    Roulette {
        /// The chance, less than 1.
        chance: f32,
    },
}

/// A light that a surface looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Looked {
    /// Which of the scene's lights.
    pub light: Option<u32>,
    /// Density of the choice, by solid angle; infinite where no other ray can run into the light.
    pub density: f32,
    /// Radiance that arrives if nothing is in its way, over the probability density of the choice.
    pub radiance: [f32; 3],
}

/// What shading did with a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Account {
    /// The kind of surface that it is shaded as; empty where it is not.
    pub kind: &'static str,
    /// Its material, after the dice of mixtures have been thrown.
    pub material: Option<u32>,
    /// The normal for shading, world space.
    pub normal: Option<[f32; 3]>,
    /// The light that it looked at.
    pub looked: Option<Looked>,
    /// What became of the path.
    pub fate: Fate,
}

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Self::Diffuse => "diffuse",
            Self::DiffuseTransmission => "diffusetransmission",
            Self::Conductor => "conductor",
            Self::Dielectric => "dielectric",
            Self::ThinDielectric => "thindielectric",
            Self::CoatedDiffuse => "coateddiffuse",
            Self::CoatedConductor => "coatedconductor",
            Self::Interface => "interface",
        }
    }
}

impl ShadeColumns {
    /// What [`super::shade`] has just done with the first ray of a wave, which has no other.
    pub fn account(
        &self,
        scene: &Scene,
        vertex: &Vertex,
        rays: &RayBatch,
        hits: &HitBatch,
    ) -> Account {
        let mut account =
            Account { kind: "", material: None, normal: None, looked: None, fate: Fate::Deepest };
        if hits[0].shape == NONE {
            return Account { fate: Fate::Escapes, ..account };
        }
        if vertex.ends(rays.density[0]) {
            return account;
        }
        let Self { dice, vertices } = self;
        let (kind, material) = vertices.kinds[0];
        (account.kind, account.material) = (kind.name(), Some(material));
        let Some(at) = vertices.places().next() else {
            return Account { fate: Fate::GoesOn, ..account };
        };
        account.normal = Some(vector(&vertices.normal, at));
        let radiance = vector(&vertices.light, at);
        account.looked = (radiance != [0.0; 3]).then(|| Looked {
            light: scene.chosen_light(vertices.points[at].position, dice.at(0).choice),
            density: vertices.light_density[at],
            radiance,
        });
        let left = vector(&vertices.next_throughput, at);
        account.fate = match vertices.chance(vertex, at) {
            _ if left.iter().all(|&t| t <= 0.0) && kind == Kind::Diffuse && vertex.alone(scene) => {
                Fate::Complete
            }
            _ if left.iter().all(|&t| t <= 0.0) => Fate::Absorbed,
            Some(chance) if vertices.roulette[at] >= chance => Fate::Roulette { chance },
            _ => Fate::GoesOn,
        };
        account
    }
}
