//! Texel addressing beyond the edges of an image, and interpolation between texels.

use glam::Vec2;

/// Wrap mode: the continuation of an image beyond its edges.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// Repeats the image.
    #[default]
    Repeat,
    /// Repeats the outermost pixels.
    Clamp,
    /// Black.
    Black,
    /// Continues with the neighbours on the sphere in the equal-area mapping (Clarberg 2008).
    OctahedralSphere,
}

impl Wrap {
    /// Returns the texel inside the image that replaces one that may be outside, or `None` for
    /// black.
    pub fn resolve(self, at: [i64; 2], size: [i64; 2]) -> Option<[i64; 2]> {
        let each = |f: fn(i64, i64) -> i64| [f(at[0], size[0]), f(at[1], size[1])];
        match self {
            Self::Repeat => Some(each(|i, n| i.rem_euclid(n))),
            Self::Clamp => Some(each(|i, n| i.clamp(0, n - 1))),
            Self::Black => {
                let inside = (0..2).all(|axis| (0..size[axis]).contains(&at[axis]));
                inside.then_some(at)
            }
            Self::OctahedralSphere => {
                let [mut x, mut y] = at;
                let [width, height] = size;
                // Across an edge, the square continues with itself turned about the edge's
                // midpoint.
                if x < 0 || x >= width {
                    x = if x < 0 { x.saturating_neg() } else { 2 * width - 1 - x.min(2 * width) };
                    y = height - 1 - y.clamp(-height, 2 * height);
                }
                if y < 0 || y >= height {
                    y = if y < 0 { y.saturating_neg() } else { 2 * height - 1 - y.min(2 * height) };
                    x = width - 1 - x;
                }
                Some([x.clamp(0, width - 1), y.clamp(0, height - 1)])
            }
        }
    }
}

/// Converts image coordinates, 0 to 1, to texel coordinates, which are integers at the centres of
/// texels. Whole repeats are removed first, so that distant repeats keep their precision.
pub(super) fn texel_coordinates(st: Vec2, size: [usize; 2], wrap: Wrap) -> [f32; 2] {
    let fold = |x: f32| if wrap == Wrap::Repeat { x - x.floor() } else { x };
    [fold(st.x) * size[0] as f32 - 0.5, fold(st.y) * size[1] as f32 - 0.5]
}

/// Interpolates bilinearly between the four texels around a point, in texel coordinates.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texels_outside_follow_the_wrap_mode() {
        let size = [4, 3];
        let outside = [[-1, 1], [4, 1], [1, -2], [9, 7]];
        let resolved = |wrap: Wrap| outside.map(|at| wrap.resolve(at, size));
        assert_eq!(resolved(Wrap::Repeat), [[3, 1], [0, 1], [1, 1], [1, 1]].map(Some));
        assert_eq!(resolved(Wrap::Clamp), [[0, 1], [3, 1], [1, 0], [3, 2]].map(Some));
        assert_eq!(resolved(Wrap::Black), [None; 4]);
        for wrap in [Wrap::Repeat, Wrap::Clamp, Wrap::Black, Wrap::OctahedralSphere] {
            assert_eq!(wrap.resolve([2, 1], size), Some([2, 1]));
        }
    }

    #[test]
    fn the_octahedral_map_continues_across_its_edges() {
        let resolve = |at| Wrap::OctahedralSphere.resolve(at, [8, 8]);
        // The right edge continues with itself upside down, the top edge with itself back to front.
        assert_eq!(resolve([8, 1]), Some([7, 6]));
        assert_eq!(resolve([2, 8]), Some([5, 7]));
        assert_eq!(resolve([-1, 0]), Some([1, 7]));
        for far in [i64::MIN, -100, 100, i64::MAX] {
            for at in [[far, 3], [3, far], [far, far]] {
                let [x, y] = resolve(at).unwrap();
                assert!((0..8).contains(&x) && (0..8).contains(&y), "{at:?}");
            }
        }
    }
}
