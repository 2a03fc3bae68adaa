//! Trait of the parameters of a kind of BSDF, and the macro that makes kinds of their list.

use super::coat::CoatWalks;
use super::{Bsdf, Columns, Gloss, SurfaceTextures};
use petzval_base::lanes::Real;
use petzval_scene::MaterialModel;

/// Parameters of the BSDF of path vertices of one kind, lane by lane.
pub(in crate::shade) trait VertexParameters<R: Real<Scalar = f32>>:
    Columns<R>
{
    /// The BSDF.
    type Bsdf: Bsdf<R>;

    /// Name of the material, as in pbrt-v4 if that has it.
    const NAME: &'static str;

    /// Whether light counts only on the side of `wo`.
    const ONE_SIDED: bool;

    /// Whether the BSDF scatters so widely, but for narrow microfacets, that light paths can light
    /// the surface by caustics.
    const CATCHES_CAUSTICS: bool = false;

    /// Whether the last light of a path needs no multiple importance sampling.
    const DIFFUSE: bool = false;

    /// Whether evaluations are random walks.
    const WALKS: bool = false;

    /// Returns the parameters of a material at points of its surface; `None` for a model of another
    /// kind. The textures vary only for materials for which
    /// [`petzval_scene::Scene::needs_derivatives`] holds.
    fn of(model: &MaterialModel, textures: &impl SurfaceTextures<R>) -> Option<Self>;

    /// Returns the approximate share of light that a material reflects or transmits, by colour
    /// channel; `None` for a model of another kind.
    fn albedo(model: &MaterialModel, textures: &impl SurfaceTextures<R>) -> Option<[R; 3]>;

    /// Builds the BSDF. Only coats use the walks.
    fn bsdf(self, walks: CoatWalks<R>) -> Self::Bsdf;

    /// Calls a function with the width alpha of all microfacets.
    #[inline(always)]
    fn for_each_width(&mut self, _change: impl FnMut(&mut R)) {}

    /// Returns the lanes that are known to reflect no light of sampled directions, as a mirror.
    #[inline(always)]
    fn unlit(&self) -> R::Mask {
        R::splat(1.0).lt(R::splat(0.0))
    }

    /// Returns how the surface reflects, seen at an angle of this cosine; `None` if it scatters
    /// widely, or on both sides.
    #[inline(always)]
    fn gloss(&self, _cos: R) -> Option<Gloss<R>> {
        None
    }
}

/// A computation for the parameters of any kind.
pub(in crate::shade) trait ParametersVisitor<R: Real<Scalar = f32>> {
    /// Result of the computation.
    type Output;

    /// Computes.
    fn visit<P: VertexParameters<R> + Sync + 'static>(self) -> Self::Output;
}

/// Defines [`super::BsdfKind`] from the list of kinds, in the order in which vertices are sorted:
/// `Kind: Parameters = pattern of its materials`.
macro_rules! bsdf_kinds {
    ($($kind:ident $(: $parameters:ident)? $(= $models:pat)?,)+) => {
        /// Kind of a vertex's BSDF. Vertices of one kind are shaded together.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[repr(u8)]
        pub(in crate::shade) enum BsdfKind {
            $($kind),+
        }

        /// Number of kinds.
        pub(in crate::shade) const KIND_COUNT: usize = [$(BsdfKind::$kind),+].len();

        /// Largest number of columns of a kind's parameters.
        pub(in crate::shade) const PARAMETER_COUNT: usize = {
            let counts = [$($(<$parameters<f32> as Columns<f32>>::COUNT,)?)+];
            let (mut largest, mut i) = (0, 0);
            while i < counts.len() {
                largest = if counts[i] > largest { counts[i] } else { largest };
                i += 1;
            }
            largest
        };

        impl BsdfKind {
            /// All kinds, in the order of their discriminants.
            pub(in crate::shade) const ALL: [Self; KIND_COUNT] = [$(Self::$kind),+];

            /// Returns the kind of a material model, or `None` for a mixture.
            #[inline(always)]
            pub(in crate::shade) fn of(model: &MaterialModel) -> Option<Self> {
                match model {
                    $($($models => Some(Self::$kind),)?)+
                    MaterialModel::Mix { .. } => None,
                }
            }

            /// Computes for the parameters of the kind; `None` for a kind without any.
            pub(in crate::shade) fn visit<R, V>(self, visitor: V) -> Option<V::Output>
            where
                R: Real<Scalar = f32>,
                V: ParametersVisitor<R>,
            {
                match self {
                    $(Self::$kind => bsdf_kinds!(@visit visitor, R $(, $parameters)?),)+
                }
            }
        }
    };
    (@visit $visitor:ident, $R:ident, $parameters:ident) => {
        Some($visitor.visit::<$parameters<$R>>())
    };
    (@visit $visitor:ident, $R:ident) => {
        None
    };
}
pub(super) use bsdf_kinds;
