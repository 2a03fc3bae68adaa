//! Glossy lobes of a wave's vertices: what the selection of lights knows of their BSDFs.

use super::ShadeInputs;
use super::bsdf::{Gloss, Microfacets};
use super::vertices::Vertices;
use petzval_base::lanes::Real;
use petzval_base::lanes::vector::dot;
use petzval_base::rays::SortedColumn;
use petzval_scene::{LobeColumns, VectorColumns, load_vector};

/// Largest weight of a lobe, so that lights outside it are selected as well.
const LARGEST_SHARE: f32 = 0.98;
/// Smallest squared width alpha of a lobe.
const NARROWEST2: f32 = 1e-6;

/// The lobes of vertices, by which lights are selected.
#[derive(Clone, Debug, Default)]
pub(super) struct VertexLobes {
    /// Whether the scene has more than one light to select.
    are_set: bool,
    alpha2: SortedColumn<f32>,
    share: SortedColumn<f32>,
}

impl VertexLobes {
    /// Returns the lobes if they are set, given the vectors to where vertices reflect light.
    pub(super) fn columns<'a>(&'a self, wo: &'a VectorColumns) -> Option<LobeColumns<'a>> {
        let Self { are_set, alpha2, share } = self;
        are_set.then_some(LobeColumns { wo, alpha2, share })
    }
}

impl Vertices {
    /// Sets the lobes of all vertices if lights are selected by them.
    pub(super) fn load_lobes<R: Real<Scalar = f32>>(&mut self, inputs: &ShadeInputs) {
        self.lobes.are_set = inputs.scene.lights.choose_by_reception();
        if !self.lobes.are_set {
            return;
        }
        for (range, kind) in self.shaded_ranges() {
            let stage = kind.stage::<R>();
            for at in range.step_by(R::LANES) {
                let wo = load_vector::<R>(&self.wo, at);
                let cos = dot(wo, load_vector(&self.facing, at)).max(R::splat(0.0));
                let gloss = stage.gloss(&self.parameters, at, cos);
                let (alpha2, share) = match gloss {
                    Some(gloss) => gloss.lobe(cos),
                    None => (R::splat(1.0), R::splat(0.0)),
                };
                alpha2.store(&mut self.lobes.alpha2[at..]);
                share.store(&mut self.lobes.share[at..]);
            }
        }
    }
}

impl<R: Real<Scalar = f32>> Gloss<R> {
    /// Returns the squared width and the weight of the lobe.
    fn lobe(&self, cos: R) -> (R, R) {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let [along, across] = self.alpha;
        let alpha2 = (along * across).max(R::splat(NARROWEST2)).min(one);
        // The wide part reflects a cos / pi of albedo a; microfacets F D G / (4 cos), with Smith's G
        // of the direction to the viewer (Heitz 2014).
        let stretched = (alpha2 + (one - alpha2) * cos * cos).sqrt();
        let glossy = self.glossy / (R::splat(2.0) * (cos + stretched));
        let share = (glossy / (glossy + self.wide)).min(R::splat(LARGEST_SHARE));
        // Sampled lights are not seen in smooth surfaces.
        (alpha2, R::select(Microfacets::new(self.alpha).smooth, zero, share))
    }
}
