//! Columns and rows of dots in a grid.

use std::collections::{HashMap, VecDeque};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_8};

use super::dots::Dot;

/// Largest distance of a dot from where the dots beside it tell it to be, relative to the step.
const TOLERANCE: f64 = 0.3;
/// Dots about the middle of the picture whose neighbours give the first steps.
const VOTERS: usize = 60;

/// Dots by their place.
struct DotMap<'a> {
    dots: &'a [Dot],
    cell: f64,
    cells: HashMap<[i64; 2], Vec<usize>>,
}

impl<'a> DotMap<'a> {
    fn new(dots: &'a [Dot], cell: f64) -> Self {
        let mut cells: HashMap<[i64; 2], Vec<usize>> = HashMap::new();
        for (i, dot) in dots.iter().enumerate() {
            cells.entry(Self::key(dot.at, cell)).or_default().push(i);
        }
        Self { dots, cell, cells }
    }

    fn key(at: [f64; 2], cell: f64) -> [i64; 2] {
        at.map(|at| (at / cell).floor() as i64)
    }

    /// Returns the nearest dot, if it is in the same cell or one beside it.
    fn nearest(&self, place: [f64; 2]) -> Option<usize> {
        let [x, y] = Self::key(place, self.cell);
        let cells = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| [x + dx, y + dy]));
        let dots = cells.filter_map(|key| self.cells.get(&key)).flatten().copied();
        nearest(self.dots, dots, place)
    }
}

/// Returns dots with their column and row from the dot nearest to the middle of the picture, from neighbour to
/// neighbour. Dots that belong to no grid about it are left out.
pub(super) fn order(dots: &[Dot], size: [usize; 2]) -> Vec<([i32; 2], Dot)> {
    let middle = size.map(|n| (n as f64 - 1.0) / 2.0);
    let Some(first) = nearest(dots, 0..dots.len(), middle) else { return Vec::new() };
    let Some(steps) = first_steps(dots, middle) else { return Vec::new() };
    let map = DotMap::new(dots, length(steps[0]).min(length(steps[1])));
    let mut found: HashMap<[i32; 2], usize> = HashMap::from([([0, 0], first)]);
    let mut taken = vec![false; dots.len()];
    taken[first] = true;
    let mut open = VecDeque::from([([0, 0], first, steps)]);
    while let Some((index, i, steps)) = open.pop_front() {
        for (axis, sign) in [(0, 1), (0, -1), (1, 1), (1, -1)] {
            let mut next = index;
            next[axis] += sign;
            if found.contains_key(&next) {
                continue;
            }
            let way = steps[axis].map(|step| step * f64::from(sign));
            let expected = [dots[i].at[0] + way[0], dots[i].at[1] + way[1]];
            let Some(j) = map.nearest(expected) else { continue };
            let off = between(expected, dots[j].at);
            if taken[j] || length(off) > TOLERANCE * length(way) {
                continue;
            }
            taken[j] = true;
            found.insert(next, j);
            // Distortion changes the steps slowly.
            let mut steps = steps;
            steps[axis] = between(dots[i].at, dots[j].at).map(|step| f64::from(sign) * step);
            open.push_back((next, j, steps));
        }
    }
    found.into_iter().map(|(index, i)| (index, dots[i])).collect()
}

/// Returns the steps to the next column and to the next row that most dots about the middle have.
fn first_steps(dots: &[Dot], middle: [f64; 2]) -> Option<[[f64; 2]; 2]> {
    let mut voters: Vec<&Dot> = dots.iter().collect();
    voters.sort_by(|a, b| length(between(middle, a.at)).total_cmp(&length(between(middle, b.at))));
    voters.truncate(VOTERS);
    let ways = |dot: &Dot| {
        let from = dot.at;
        voters.iter().map(move |other| between(from, other.at)).filter(|way| length(*way) > 0.0)
    };
    let shortest = |ways: &mut dyn Iterator<Item = [f64; 2]>| {
        ways.min_by(|a, b| length(*a).total_cmp(&length(*b)))
    };
    // The direction of the grid, which is the same for all four neighbours of a dot.
    let [mut sin, mut cos] = [0.0; 2];
    for dot in &voters {
        let Some([x, y]) = shortest(&mut ways(dot)) else { continue };
        let (s, c) = (4.0 * y.atan2(x)).sin_cos();
        (sin, cos) = (sin + s, cos + c);
    }
    let turn = sin.atan2(cos) / 4.0;
    // The step of most dots in each direction: the median of the distances to the next one there.
    let step = |direction: f64| {
        let (sin, cos) = direction.sin_cos();
        let is_ahead = |[x, y]: &[f64; 2]| (x * cos + y * sin) > FRAC_PI_8.cos() * x.hypot(*y);
        let mut steps: Vec<[f64; 2]> =
            voters.iter().filter_map(|dot| shortest(&mut ways(dot).filter(is_ahead))).collect();
        steps.sort_by(|a, b| length(*a).total_cmp(&length(*b)));
        steps.get(steps.len() / 2).copied()
    };
    Some([step(turn)?, step(turn + FRAC_PI_2)?])
}

fn nearest(dots: &[Dot], of: impl IntoIterator<Item = usize>, place: [f64; 2]) -> Option<usize> {
    let distance = |i: &usize| length(between(dots[*i].at, place));
    of.into_iter().min_by(|a, b| distance(a).total_cmp(&distance(b)))
}

fn between(from: [f64; 2], to: [f64; 2]) -> [f64; 2] {
    [to[0] - from[0], to[1] - from[1]]
}

fn length([x, y]: [f64; 2]) -> f64 {
    x.hypot(y)
}
