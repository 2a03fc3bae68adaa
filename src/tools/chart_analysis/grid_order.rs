//! Columns and rows of dots in a grid.

use std::collections::{HashMap, VecDeque};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_8};

use glam::DVec2;

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
            cells.entry(Self::key(dot.at.into(), cell)).or_default().push(i);
        }
        Self { dots, cell, cells }
    }

    fn key(at: DVec2, cell: f64) -> [i64; 2] {
        (at / cell).floor().as_i64vec2().to_array()
    }

    /// Returns the nearest dot, if it is in the same cell or one beside it.
    fn nearest(&self, place: DVec2) -> Option<usize> {
        let [x, y] = Self::key(place, self.cell);
        let cells = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| [x + dx, y + dy]));
        let dots = cells.filter_map(|key| self.cells.get(&key)).flatten().copied();
        nearest(self.dots, dots, place)
    }
}

/// Returns dots with their column and row from the dot nearest to the middle of the picture, from neighbour to
/// neighbour. Dots that belong to no grid about it are left out.
pub(super) fn order(dots: &[Dot], size: [usize; 2]) -> Vec<([i32; 2], Dot)> {
    let middle = (DVec2::from(size.map(|n| n as f64)) - 1.0) / 2.0;
    let Some(first) = nearest(dots, 0..dots.len(), middle) else { return Vec::new() };
    let Some(steps) = first_steps(dots, middle) else { return Vec::new() };
    let at = |i: usize| DVec2::from(dots[i].at);
    let map = DotMap::new(dots, steps[0].length().min(steps[1].length()));
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
            let expected = at(i) + f64::from(sign) * steps[axis];
            let Some(j) = map.nearest(expected) else { continue };
            if taken[j] || at(j).distance(expected) > TOLERANCE * steps[axis].length() {
                continue;
            }
            taken[j] = true;
            found.insert(next, j);
            // Distortion changes the steps slowly.
            let mut steps = steps;
            steps[axis] = f64::from(sign) * (at(j) - at(i));
            open.push_back((next, j, steps));
        }
    }
    found.into_iter().map(|(index, i)| (index, dots[i])).collect()
}

/// Returns the steps to the next column and to the next row that most dots about the middle have.
fn first_steps(dots: &[Dot], middle: DVec2) -> Option<[DVec2; 2]> {
    let mut voters: Vec<DVec2> = dots.iter().map(|dot| dot.at.into()).collect();
    voters.sort_by(|a, b| a.distance(middle).total_cmp(&b.distance(middle)));
    voters.truncate(VOTERS);
    let ways =
        |from: DVec2| voters.iter().map(move |to| *to - from).filter(|way| *way != DVec2::ZERO);
    let shortest = |ways: &mut dyn Iterator<Item = DVec2>| {
        ways.min_by(|a, b| a.length().total_cmp(&b.length()))
    };
    // The direction of the grid, which is the same for all four neighbours of a dot.
    let to_nearest = voters.iter().filter_map(|from| shortest(&mut ways(*from)));
    let sum: DVec2 = to_nearest.map(|way| DVec2::from_angle(4.0 * way.to_angle())).sum();
    let turn = sum.to_angle() / 4.0;
    // The step of most dots in each direction: the median of the distances to the next one there.
    let step = |direction: f64| {
        let ahead = DVec2::from_angle(direction);
        let is_ahead = |way: &DVec2| way.dot(ahead) > FRAC_PI_8.cos() * way.length();
        let mut steps: Vec<DVec2> =
            voters.iter().filter_map(|from| shortest(&mut ways(*from).filter(is_ahead))).collect();
        steps.sort_by(|a, b| a.length().total_cmp(&b.length()));
        steps.get(steps.len() / 2).copied()
    };
    Some([step(turn)?, step(turn + FRAC_PI_2)?])
}

fn nearest(dots: &[Dot], of: impl IntoIterator<Item = usize>, place: DVec2) -> Option<usize> {
    let distance = |i: &usize| place.distance(dots[*i].at.into());
    of.into_iter().min_by(|a, b| distance(a).total_cmp(&distance(b)))
}
