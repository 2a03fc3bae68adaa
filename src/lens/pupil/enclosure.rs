//! Widening of fans until their interpolations enclose the light of the film points between them.
//!
//! Fans enclose the light of the film points where it was traced. At many film points between them
//! the light is sought on copies of the outline of the interpolated fan, at growing scales: light
//! that a fan misses crosses the outline, because the light of a film point is connected. The
//! triangles on whose side light was found are widened, in all fans around the film point.

use rayon::prelude::*;

use super::fan::{Fan, TRIANGLES};
use super::outline::{OutlineFinder, PupilBox};
use super::table::FilmPosition;

/// A film point between tabulated ones.
pub(super) struct Between<const N: usize> {
    pub film: FilmPosition,
    /// Unit direction of the u axis of its fan in the frame of the lens.
    pub turn: [f64; 2],
    /// The fans around it, and their interpolation weights.
    pub around: [(usize, f32); N],
}

/// Least excess of the area of a copy of the outline over that of the fan.
const LEAST_EXCESS: f64 = 1.0 / 1024.0;
/// Copies of the outline. The excess of each is twice that of the one before.
const COPIES: usize = 13;
/// Copies on which light is sought first.
const FIRST_COPIES: [usize; 5] = [0, 3, 6, 9, 12];
/// Scales of the outline at which light is sought inside the fan.
const INSIDE: [f64; 2] = [0.5, 0.9];
/// Range around a fan without light in which it is sought, in sizes of the fan on each side.
const APART: f64 = 3.0;
/// Rows and columns of that search.
const SEARCH: usize = 33;
/// Points on the side of a triangle in each of these searches.
const POINTS: usize = 4;
/// Widenings of the fans around a film point, at most.
const ROUNDS: usize = 4;

/// Returns the scale of a copy of the outline.
fn scale(copy: usize) -> f64 {
    (1.0 + LEAST_EXCESS * (copy as f64).exp2()).sqrt()
}

/// Widens fans until they enclose the light of the film points between them.
pub(super) fn enclose_light<const N: usize>(
    fans: &mut [Fan],
    mut between: Vec<Between<N>>,
    finder: &OutlineFinder,
) {
    for _ in 0..ROUNDS {
        let mut by = vec![[1.0f64; TRIANGLES]; fans.len()];
        let missed = |finder: &mut OutlineFinder, place: Between<N>| {
            let missed = missed_light(fans, &place, finder);
            (!missed.is_empty()).then_some((place, missed))
        };
        let searched = between.into_par_iter().map_init(|| finder.clone(), missed);
        let found: Vec<_> = searched.flatten().collect();
        for (place, missed) in &found {
            for &(triangle, scale) in missed {
                for (k, _) in place.around.iter().filter(|(_, weight)| *weight > 0.0) {
                    for corner in [triangle, (triangle + 1) % TRIANGLES] {
                        by[*k][corner] = by[*k][corner].max(scale);
                    }
                }
            }
        }
        between = found.into_iter().map(|(place, _)| place).collect();
        for (fan, by) in fans.iter_mut().zip(&by) {
            *fan = fan.widened(by);
        }
    }
}

/// Returns the triangles of the fan of a film point outside whose side there is light, and the
/// scales at which they enclose it.
fn missed_light<const N: usize>(
    fans: &[Fan],
    place: &Between<N>,
    finder: &mut OutlineFinder,
) -> Vec<(usize, f64)> {
    let fan = Fan::mix(&place.around.map(|(k, weight)| (&fans[k], weight)));
    if !fan.is_open() {
        return Vec::new();
    }
    finder.turn = place.turn;
    let scales: Vec<f64> = INSIDE.into_iter().chain(FIRST_COPIES.map(scale)).collect();
    let per_copy = TRIANGLES * POINTS;
    let lit = finder.lit(place.film, scales.len() * per_copy, |i| {
        let turn = (i % POINTS) as f64 / POINTS as f64;
        fan.outside(i / POINTS % TRIANGLES, turn, scales[i / per_copy])
    });
    if lit.iter().all(|lit| !lit) {
        return light_apart(&fan, place.film, finder);
    }
    let beyond = |k: &usize| {
        (INSIDE.len()..scales.len())
            .any(|copy| (0..POINTS).any(|i| lit[copy * per_copy + POINTS * k + i]))
    };
    let mut missed = Vec::new();
    for triangle in (0..TRIANGLES).filter(beyond) {
        let points = 2 * POINTS;
        let lit = finder.lit(place.film, COPIES * points, |i| {
            fan.outside(triangle, (i % points) as f64 / points as f64, scale(i / points))
        });
        if let Some(last) = lit.iter().rposition(|lit| *lit) {
            missed.push((triangle, scale(last / points + 1)));
        }
    }
    missed
}

/// Returns the same for light that the fan and the copies of its outline do not meet: it is sought
/// all around.
fn light_apart(fan: &Fan, film: FilmPosition, finder: &mut OutlineFinder) -> Vec<(usize, f64)> {
    let corners = fan.corners.map(|[u, v]| [fan.centre[0] + u, fan.centre[1] + v].map(f64::from));
    let around = PupilBox::around(&corners);
    let around = around.grown(around.size().map(|size| APART * size));
    let (corner, size) = (around.corner(), around.size());
    let place = |i: usize| {
        let share = [i % SEARCH, i / SEARCH].map(|k| k as f64 / (SEARCH - 1) as f64);
        [0, 1].map(|axis| corner[axis] + share[axis] * size[axis])
    };
    let lit = finder.lit(film, SEARCH * SEARCH, place);
    let found = (0..SEARCH * SEARCH).filter(|&i| lit[i]);
    found.filter_map(|i| fan.triangle_towards(place(i))).collect()
}
