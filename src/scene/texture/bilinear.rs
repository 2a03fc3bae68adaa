//! Between the texels of an image.

use glam::Vec2;

use super::Wrap;

/// A point in texels, whole numbers in their middles. Whole turns are taken off before, so that far
/// repeats stay sharp.
pub(super) fn place(st: Vec2, size: [usize; 2], wrap: Wrap) -> [f32; 2] {
    let fold = |x: f32| if wrap == Wrap::Repeat { x - x.floor() } else { x };
    [fold(st.x) * size[0] as f32 - 0.5, fold(st.y) * size[1] as f32 - 0.5]
}

/// The mean of the four texels around a point in texels, by nearness.
#[inline(always)]
pub(super) fn bilinear<const N: usize>(
    [x, y]: [f32; 2],
    texel: impl Fn(i64, i64) -> [f32; N],
) -> [f32; N] {
    let (x0, y0) = (x.floor(), y.floor());
    let (fx, fy) = (x - x0, y - y0);
    let (x0, y0) = (x0 as i64, y0 as i64);
    let (x1, y1) = (x0.saturating_add(1), y0.saturating_add(1));
    let corners = [
        (texel(x0, y0), (1.0 - fx) * (1.0 - fy)),
        (texel(x1, y0), fx * (1.0 - fy)),
        (texel(x0, y1), (1.0 - fx) * fy),
        (texel(x1, y1), fx * fy),
    ];
    std::array::from_fn(|i| corners.iter().map(|(c, w)| c[i] * w).sum())
}
