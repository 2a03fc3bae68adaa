//! Work of the shading stage on the vertices of one kind.

use std::marker::PhantomData;
use std::ops::Range;

use super::bsdf::{
    BsdfKind, Gloss, Measured, Microfacets, PARAMETER_COUNT, ParametersVisitor, VertexParameters,
    clamp_to_unit,
};
use super::evaluate::Evaluation;
use super::shading_context::ShadingContext;
use super::vertices::Vertices;
use petzval_base::lanes::Real;
use petzval_base::lanes::vector::{dot, negate, select, splat};
use petzval_base::rays::SortedColumn;
use petzval_scene::MaterialModel;

/// Parameters of the BSDFs of all vertices of a wave, which a kind divides into its own columns.
pub(super) type ParameterColumns = [SortedColumn<f32>; PARAMETER_COUNT];

/// Smallest width alpha of microfacets at which a surface is lit by caustics from light paths.
const NARROWEST: f32 = 0.1;

/// Work on the vertices of one kind, for a number of lanes. The defaults are those of vertices that
/// do not scatter.
pub(super) trait KindStage<R: Real<Scalar = f32>>: Sync {
    /// Returns the name of the material, as in pbrt-v4 if that has it.
    fn name(&self) -> &'static str;

    /// Returns whether light counts only on the side of `wo`.
    fn is_one_sided(&self) -> bool {
        false
    }

    /// Sets the parameters of a range to those of a material that does not vary over surfaces. The
    /// last packet may end behind the range.
    fn fill(&self, _: &MaterialModel, _: &mut ParameterColumns, _: Range<usize>) {}

    /// Sets the parameters of the packet that begins at an entry.
    fn store(
        &self,
        _: &MaterialModel,
        _: &ShadingContext<R>,
        _: &mut ParameterColumns,
        _at: usize,
    ) {
    }

    /// Returns the approximate share of light that a material reflects or transmits.
    fn albedo(&self, _: &MaterialModel, _: &ShadingContext<R>) -> [R; 3] {
        splat([1.0; 3])
    }

    /// Returns the lanes that reflect no light of sampled directions.
    fn unlit(&self, _: &ParameterColumns, _at: usize) -> R::Mask {
        R::splat(1.0).lt(R::splat(0.0))
    }

    /// Returns how a packet reflects, seen at an angle of this cosine; `None` if it scatters widely,
    /// or on both sides.
    fn gloss(&self, _: &ParameterColumns, _at: usize, _cos: R) -> Option<Gloss<R>> {
        None
    }

    /// Makes the smooth surfaces of a packet rougher, as pbrt-v4 does: a width alpha below 0.3 is
    /// doubled, to 0.1 at least and 0.3 at most.
    fn regularize(&self, _: &mut ParameterColumns, _at: usize) {}

    /// Returns the lanes that light paths light by caustics: those that scatter so widely that a
    /// path to the lens is no rare event. Camera paths leave such light to them.
    fn receives_caustics(&self, _: &ParameterColumns, _at: usize) -> R::Mask {
        R::splat(1.0).lt(R::splat(0.0))
    }

    /// Evaluates a range of vertices towards their lights, and samples the next directions.
    fn evaluate(&self, _: &mut Vertices, _: Range<usize>, _: &Evaluation) {}
}

/// Work on vertices with parameters.
struct ParametersStage<P>(PhantomData<P>);

impl<R: Real<Scalar = f32>, P: VertexParameters<R> + Sync> KindStage<R> for ParametersStage<P> {
    fn name(&self) -> &'static str {
        P::NAME
    }

    fn is_one_sided(&self) -> bool {
        P::ONE_SIDED
    }

    fn fill(&self, model: &MaterialModel, columns: &mut ParameterColumns, range: Range<usize>) {
        if let Some(parameters) = P::of(model, &ShadingContext::<R>::anywhere()) {
            parameters.fill_in(columns, range);
        }
    }

    fn store(
        &self,
        model: &MaterialModel,
        context: &ShadingContext<R>,
        columns: &mut ParameterColumns,
        at: usize,
    ) {
        if let Some(parameters) = P::of(model, context) {
            parameters.store_in(columns, at);
        }
    }

    fn albedo(&self, model: &MaterialModel, context: &ShadingContext<R>) -> [R; 3] {
        P::albedo(model, context).unwrap_or_else(|| splat([1.0; 3]))
    }

    fn unlit(&self, columns: &ParameterColumns, at: usize) -> R::Mask {
        P::from_columns(columns, at).unlit()
    }

    fn gloss(&self, columns: &ParameterColumns, at: usize, cos: R) -> Option<Gloss<R>> {
        P::from_columns(columns, at).gloss(cos)
    }

    fn regularize(&self, columns: &mut ParameterColumns, at: usize) {
        let mut parameters = P::from_columns(columns, at);
        let [narrowest, widest] = [R::splat(0.1), R::splat(0.3)];
        parameters.for_each_width(|alpha| {
            let wider = (R::splat(2.0) * *alpha).max(narrowest).min(widest);
            *alpha = R::select(alpha.lt(widest), wider, *alpha);
        });
        parameters.store_in(columns, at);
    }

    fn receives_caustics(&self, columns: &ParameterColumns, at: usize) -> R::Mask {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let mut receives = if P::CATCHES_CAUSTICS { zero.lt(one) } else { one.lt(zero) };
        P::from_columns(columns, at).for_each_width(|alpha| {
            // A perfectly smooth interface is no part of what sampled directions see.
            let smooth = Microfacets::new([*alpha; 2]).smooth;
            receives = receives & (R::splat(NARROWEST).le(*alpha) | smooth);
        });
        receives
    }

    fn evaluate(&self, vertices: &mut Vertices, range: Range<usize>, inputs: &Evaluation) {
        vertices.evaluate_packets::<R, P>(range, inputs);
    }
}

/// Work on measured surfaces.
struct MeasuredStage;

impl<R: Real<Scalar = f32>> KindStage<R> for MeasuredStage {
    fn name(&self) -> &'static str {
        "measured"
    }

    fn is_one_sided(&self) -> bool {
        true
    }

    fn albedo(&self, model: &MaterialModel, _: &ShadingContext<R>) -> [R; 3] {
        let MaterialModel::Measured(surface) = model else { return splat([1.0; 3]) };
        clamp_to_unit(splat(Measured { surface, uplift: None }.albedo()))
    }

    fn evaluate(&self, vertices: &mut Vertices, _: Range<usize>, inputs: &Evaluation) {
        vertices.evaluate_measured(inputs);
    }
}

/// Work on surfaces that do not scatter: none.
struct InterfaceStage;

impl<R: Real<Scalar = f32>> KindStage<R> for InterfaceStage {
    fn name(&self) -> &'static str {
        "interface"
    }
}

/// Finds the work on vertices with parameters.
struct StageOf;

impl<R: Real<Scalar = f32>> ParametersVisitor<R> for StageOf {
    type Output = &'static dyn KindStage<R>;

    fn visit<P: VertexParameters<R> + Sync + 'static>(self) -> Self::Output {
        &ParametersStage::<P>(PhantomData)
    }
}

impl BsdfKind {
    /// Returns the work on vertices of the kind.
    pub(super) fn stage<R: Real<Scalar = f32>>(self) -> &'static dyn KindStage<R> {
        let without_parameters: &'static dyn KindStage<R> = match self {
            Self::Measured => &MeasuredStage,
            _ => &InterfaceStage,
        };
        self.visit::<R, _>(StageOf).unwrap_or(without_parameters)
    }
}

/// Returns the unit normal on the side from which light counts, that of `wo`; 0 if light counts from
/// both sides.
#[inline(always)]
pub(super) fn facing<R: Real<Scalar = f32>>(
    is_one_sided: bool,
    normal: [R; 3],
    wo: [R; 3],
) -> [R; 3] {
    if !is_one_sided {
        return [R::splat(0.0); 3];
    }
    let back = dot(normal, wo).lt(R::splat(0.0));
    select(back, negate(normal), normal)
}
