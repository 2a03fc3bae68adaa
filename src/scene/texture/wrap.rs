//! What lies beyond the edge of an image.

/// What lies beyond the edge of an image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// The image again.
    #[default]
    Repeat,
    /// Its outermost pixels.
    Clamp,
    /// Nothing.
    Black,
    /// The neighbours on the sphere that is folded into the square (Clarberg 2008).
    OctahedralSphere,
}

impl Wrap {
    /// The texel that stands in for one that may be outside, or `None` for black.
    pub fn place(self, at: [i64; 2], size: [i64; 2]) -> Option<[i64; 2]> {
        let pair = |place: fn(i64, i64) -> i64| [place(at[0], size[0]), place(at[1], size[1])];
        match self {
            Self::Repeat => Some(pair(|i, n| i.rem_euclid(n))),
            Self::Clamp => Some(pair(|i, n| i.clamp(0, n - 1))),
            Self::Black => {
                let inside = (0..2).all(|axis| (0..size[axis]).contains(&at[axis]));
                inside.then_some(at)
            }
            Self::OctahedralSphere => {
                let [mut x, mut y] = at;
                let [width, height] = size;
                // Across an edge, the square goes on with itself turned about the edge's middle.
                if x < 0 || x >= width {
                    x = if x < 0 { x.saturating_neg() } else { 2 * width - 1 - x.min(2 * width) };
                    y = height - 1 - y.clamp(-height, 2 * height);
                }
                if y < 0 || y >= height {
                    y = if y < 0 { -y } else { 2 * height - 1 - y.min(2 * height) };
                    x = width - 1 - x;
                }
                Some([x.clamp(0, width - 1), y.clamp(0, height - 1)])
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texels_outside_are_where_the_mode_says() {
        let size = [4, 3];
        let outside = [[-1, 1], [4, 1], [1, -2], [9, 7]];
        let of = |wrap: Wrap| outside.map(|at| wrap.place(at, size));
        assert_eq!(of(Wrap::Repeat), [[3, 1], [0, 1], [1, 1], [1, 1]].map(Some));
        assert_eq!(of(Wrap::Clamp), [[0, 1], [3, 1], [1, 0], [3, 2]].map(Some));
        assert_eq!(of(Wrap::Black), [None; 4]);
        for wrap in [Wrap::Repeat, Wrap::Clamp, Wrap::Black, Wrap::OctahedralSphere] {
            assert_eq!(wrap.place([2, 1], size), Some([2, 1]));
        }
    }

    #[test]
    fn a_folded_sphere_goes_on_across_its_edges() {
        let place = |at| Wrap::OctahedralSphere.place(at, [8, 8]);
        // The right edge is folded onto itself upside down, the top edge back to front.
        assert_eq!(place([8, 1]), Some([7, 6]));
        assert_eq!(place([2, 8]), Some([5, 7]));
        assert_eq!(place([-1, 0]), Some([1, 7]));
        for far in [i64::MIN, -100, 100, i64::MAX] {
            for at in [[far, 3], [3, far], [far, far]] {
                let [x, y] = place(at).unwrap();
                assert!((0..8).contains(&x) && (0..8).contains(&y), "{at:?}");
            }
        }
    }
}
