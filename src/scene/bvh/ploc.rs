//! Parallel locally-ordered clustering of boxes (Meister & Bittner 2018), for the trees of the
//! `obvhs` crate.
//!
//! It returns the trees of that crate's own builder. That builder merges two boxes only if each is the
//! nearest of the other, and boxes that are equal, or one inside the other, all prefer the same
//! neighbour: it then merges one pair in a pass over all, and takes a time that grows with the square of
//! their number. Here the work is limited. Passes beyond the limit that merge few pairs merge
//! neighbours along the curve instead.

use glam::DVec3;
use obvhs::aabb::Aabb;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::bvh2::{Bvh2, DEFAULT_MAX_STACK_DEPTH};
use obvhs::ploc::morton::morton_encode_u64_unorm;
use rayon::prelude::*;

/// Number of neighbours on each side that are tried.
const SEARCH_DISTANCE: usize = 14;
/// Number of passes that try only the next neighbours, while there are most boxes.
const SHORT_PASSES: usize = 3;
/// Largest sum of the numbers of boxes of all passes, for each primitive and besides. Scenes take 2 to 5
/// for each primitive.
const WORK_PER_PRIMITIVE: usize = 16;
const MIN_WORK: usize = 1 << 20;
/// A pass beyond that work must merge one pair among so many boxes.
const FEWEST_PAIRS: usize = 8;
/// Boxes that one task searches.
const CHUNK: usize = 1024;

/// A tree, and whether its boxes exceeded the work.
pub(super) struct Clustering {
    pub tree: Bvh2,
    pub degenerate: bool,
}

/// Builds the tree of boxes; there must be one or more, without NaN.
pub(super) fn cluster(boxes: &[Aabb]) -> Clustering {
    let count = boxes.len();
    let mut tree = Bvh2::zeroed(count);
    tree.primitive_indices = (0..count as u32).collect();
    let mut nodes = sorted(boxes);
    let mut next = Vec::with_capacity(count);
    // Children are stored in pairs from the end of the list, so that they follow their parents.
    let mut free = tree.nodes.len();
    let (mut pass, mut work, mut degenerate) = (0, 0usize, false);
    let most = MIN_WORK.saturating_add(WORK_PER_PRIMITIVE.saturating_mul(count));
    let mut partners = vec![0i8; count];
    while nodes.len() > 1 {
        let partners = &mut partners[..nodes.len()];
        find_partners(&nodes, pass < SHORT_PASSES, partners);
        work = work.saturating_add(nodes.len());
        if work > most && mutual_pairs(partners) * FEWEST_PAIRS < nodes.len() {
            degenerate = true;
            pair_neighbours(partners);
        }
        next.clear();
        for (i, node) in nodes.iter().enumerate() {
            let partner = i.wrapping_add_signed(isize::from(partners[i]));
            if !is_mutual(partners, i) {
                next.push(*node);
            } else if partner < i {
                let (left, right) = (*node, nodes[partner]);
                free -= 2;
                tree.nodes[free] = left;
                tree.nodes[free + 1] = right;
                next.push(Bvh2Node::new(left.aabb().union(right.aabb()), 0, free as u32));
            }
        }
        std::mem::swap(&mut nodes, &mut next);
        pass += 1;
    }
    tree.nodes[0] = nodes[0];
    tree.max_depth = DEFAULT_MAX_STACK_DEPTH.max(pass + 1);
    tree.children_are_ordered_after_parents = true;
    Clustering { tree, degenerate }
}

/// Returns leaves along a Morton curve through the centres of the boxes.
fn sorted(boxes: &[Aabb]) -> Vec<Bvh2Node> {
    let mut total = Aabb::empty();
    for one in boxes {
        total.extend(one.min);
        total.extend(one.max);
    }
    let scale = 1.0 / total.diagonal().as_dvec3();
    let offset = -total.min.as_dvec3() * scale;
    let code = |one: &Aabb| {
        let place: DVec3 = one.center().as_dvec3() * scale + offset;
        morton_encode_u64_unorm(place)
    };
    let mut codes: Vec<[u64; 2]> =
        boxes.par_iter().enumerate().map(|(i, one)| [code(one), i as u64]).collect();
    codes.par_sort_unstable_by_key(|[code, _]| *code);
    codes.par_iter().map(|[_, i]| Bvh2Node::new(boxes[*i as usize], 1, *i as u32)).collect()
}

fn union_area(a: &Bvh2Node, b: &Bvh2Node) -> f32 {
    a.aabb().union(b.aabb()).half_area()
}

/// Writes the distance in the list from each node to the one that it should be merged with.
fn find_partners(nodes: &[Bvh2Node], short: bool, partners: &mut [i8]) {
    let find = |(chunk, partners): (usize, &mut [i8])| match short {
        true => next_partners(nodes, chunk * CHUNK, partners),
        false => near_partners(nodes, chunk * CHUNK, partners),
    };
    // Tasks are not worth their start if there are few.
    match nodes.len() < 4 * CHUNK {
        true => partners.chunks_mut(CHUNK).enumerate().for_each(find),
        false => partners.par_chunks_mut(CHUNK).enumerate().for_each(find),
    }
}

/// Finds the better of the two next nodes.
fn next_partners(nodes: &[Bvh2Node], first: usize, partners: &mut [i8]) {
    let mut before = match first {
        0 => f32::INFINITY,
        _ => union_area(&nodes[first - 1], &nodes[first]),
    };
    for (i, partner) in (first..).zip(partners) {
        let Some(next) = nodes.get(i + 1) else {
            *partner = -1;
            return;
        };
        let after = union_area(&nodes[i], next);
        *partner = if before < after { -1 } else { 1 };
        before = after;
    }
}

/// Finds the best of the near nodes; of equal ones, the last.
fn near_partners(nodes: &[Bvh2Node], first: usize, partners: &mut [i8]) {
    // The areas of the last pairs, by the lower index modulo the distance and by the difference.
    let mut areas = [[0.0f32; SEARCH_DISTANCE]; SEARCH_DISTANCE];
    for (i, partner) in (first..).zip(partners) {
        let (mut best, mut least) = (0, f32::INFINITY);
        for other in i.saturating_sub(SEARCH_DISTANCE)..i {
            let area = match other < first {
                true => union_area(&nodes[i], &nodes[other]),
                false => areas[other % SEARCH_DISTANCE][i - other - 1],
            };
            if area <= least {
                (best, least) = (-((i - other) as i8), area);
            }
        }
        let end = (i + SEARCH_DISTANCE + 1).min(nodes.len());
        for other in i + 1..end {
            let area = union_area(&nodes[i], &nodes[other]);
            areas[i % SEARCH_DISTANCE][other - i - 1] = area;
            if area <= least {
                (best, least) = ((other - i) as i8, area);
            }
        }
        *partner = best;
    }
}

/// Returns whether a node and its partner prefer each other.
fn is_mutual(partners: &[i8], i: usize) -> bool {
    let partner = i.wrapping_add_signed(isize::from(partners[i]));
    partner != i && partner.wrapping_add_signed(isize::from(partners[partner])) == i
}

fn mutual_pairs(partners: &[i8]) -> usize {
    (0..partners.len()).filter(|&i| is_mutual(partners, i)).count() / 2
}

/// Makes partners of nodes 0 and 1, 2 and 3, and so on. The last of an odd number waits.
fn pair_neighbours(partners: &mut [i8]) {
    for pair in partners.chunks_mut(2) {
        match pair {
            [left, right] => (*left, *right) = (1, -1),
            rest => rest.fill(0),
        }
    }
}
