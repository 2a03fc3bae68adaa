//! Random descent through the light tree, lane by lane.

use petzval_base::lanes::Real;

/// Largest number below 1.
const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;

/// State of a descent from the root.
#[derive(Clone, Copy, Debug)]
pub(in crate::light) struct Descent<R> {
    /// Numbers in [0, 1) that select children. The levels take turns, because a selection leaves a
    /// number with fewer random bits.
    pub(in crate::light) u: [R; 2],
    /// Probability of the children selected so far.
    pub(in crate::light) probability: R,
}

/// Selection of a child.
pub(in crate::light) struct Step<R: Real> {
    /// Index of the selected child.
    pub(in crate::light) child: R,
    /// Lanes in which a child was selected; in the others none can contribute.
    pub(in crate::light) some: R::Mask,
}

impl<R: Real<Scalar = f32>> Descent<R> {
    /// Starts at the root.
    #[inline(always)]
    pub(in crate::light) fn new(u: [R; 2]) -> Self {
        Self { u, probability: R::splat(1.0) }
    }

    /// Selects one of the first `count` children in proportion to their importance.
    #[inline(always)]
    pub(in crate::light) fn step(
        &mut self,
        count: usize,
        importance: impl Fn(usize) -> R,
    ) -> Step<R> {
        let zero = R::splat(0.0);
        let mut importances = [zero; 8];
        let mut sum = zero;
        for i in 0..count {
            importances[i] = importance(i);
            sum = sum + importances[i];
        }
        let [u, other] = self.u;
        let mut rest = u * sum;
        let (mut child, mut chosen, mut offset) = (zero, zero, zero);
        let mut open = sum.equals(sum);
        for i in 0..count {
            let one = importances[i];
            // The last child of nonzero importance takes what rounding leaves over.
            let candidate = open & zero.lt(one);
            child = R::select(candidate, R::splat(i as f32), child);
            chosen = R::select(candidate, one, chosen);
            offset = R::select(candidate, rest, offset);
            open = open & !(candidate & rest.lt(one));
            rest = rest - one;
        }
        let some = zero.lt(sum) & sum.lt(R::splat(f32::INFINITY));
        self.u = [other, (offset / chosen).max(zero).min(R::splat(BELOW_ONE))];
        self.probability = self.probability * (chosen / sum);
        Step { child, some }
    }
}
