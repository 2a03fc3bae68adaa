//! Columns and rows of dots in a grid.

use std::collections::{HashMap, VecDeque};

use super::dots::Dot;

/// Largest distance of a dot from where the dots beside it tell it to be, relative to the step.
const TOLERANCE: f64 = 0.3;

/// Returns dots with their column and row from the dot nearest to the middle of the picture, from neighbour to
/// neighbour. Dots that belong to no grid about it are left out.
pub(super) fn order(dots: &[Dot], size: [usize; 2]) -> Vec<([i32; 2], Dot)> {
    let middle = size.map(|n| (n as f64 - 1.0) / 2.0);
    let Some(first) = nearest(dots, middle) else { return Vec::new() };
    let start = dots[first].at;
    // The nearest dot to the right and the nearest one below, each within 45 degrees.
    let step = |axis: usize| {
        let beside = dots.iter().filter_map(|dot| {
            let way = [dot.at[0] - start[0], dot.at[1] - start[1]];
            (way[axis] > 0.0 && way[1 - axis].abs() < way[axis]).then_some(way)
        });
        beside.min_by(|a, b| length(*a).total_cmp(&length(*b)))
    };
    let (Some(right), Some(down)) = (step(0), step(1)) else { return Vec::new() };
    let mut found: HashMap<[i32; 2], usize> = HashMap::from([([0, 0], first)]);
    let mut taken = vec![false; dots.len()];
    taken[first] = true;
    let mut open = VecDeque::from([([0, 0], first, [right, down])]);
    while let Some((index, i, steps)) = open.pop_front() {
        for (axis, sign) in [(0, 1), (0, -1), (1, 1), (1, -1)] {
            let mut next = index;
            next[axis] += sign;
            if found.contains_key(&next) {
                continue;
            }
            let way = steps[axis].map(|step| step * f64::from(sign));
            let expected = [dots[i].at[0] + way[0], dots[i].at[1] + way[1]];
            let Some(j) = nearest(dots, expected) else { continue };
            let off = [dots[j].at[0] - expected[0], dots[j].at[1] - expected[1]];
            if taken[j] || length(off) > TOLERANCE * length(way) {
                continue;
            }
            taken[j] = true;
            found.insert(next, j);
            // Distortion changes the steps slowly.
            let mut steps = steps;
            steps[axis] = [0, 1].map(|k| f64::from(sign) * (dots[j].at[k] - dots[i].at[k]));
            open.push_back((next, j, steps));
        }
    }
    found.into_iter().map(|(index, i)| (index, dots[i])).collect()
}

fn nearest(dots: &[Dot], place: [f64; 2]) -> Option<usize> {
    let distance = |i: &usize| length([dots[*i].at[0] - place[0], dots[*i].at[1] - place[1]]);
    (0..dots.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)))
}

fn length([x, y]: [f64; 2]) -> f64 {
    x.hypot(y)
}
