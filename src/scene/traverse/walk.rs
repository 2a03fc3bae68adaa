//! The way of one ray through a tree.

use super::boxes::boxes;
use super::nearest::{Nearest, cutouts, packet};
use super::ray::Prepared;
use crate::lanes::Real;
use crate::scene::tree::{Child, Code, Node, Tree};

/// The children that a worker's rays still have to visit.
#[derive(Clone, Debug, Default)]
pub struct TraversalStack(Vec<u64>);

impl TraversalStack {
    /// Room for this many children.
    #[inline(always)]
    pub(in crate::scene) fn room(&mut self, pending: usize) -> &mut [u64] {
        if self.0.len() < pending {
            self.0.resize(pending, 0);
        }
        &mut self.0
    }
}

/// What a tree leaves to its scene.
pub(in crate::scene) trait Beyond {
    /// Meets a child that is neither a node nor triangles; answers whether the hit is a nearer
    /// one now. `pending` is what is left of the stack.
    fn meet<R: Real<Scalar = f32>, const ANY: bool>(
        &self,
        child: Child,
        ray: &Prepared,
        nearest: &mut Nearest,
        pending: &mut [u64],
    ) -> bool;

    /// Whether a triangle with holes is solid where a ray meets it: which shape, which triangle,
    /// and the weights of its second and third corner.
    fn solid(&self, ray: &Prepared, name: [u32; 2], weights: [f32; 2]) -> bool;
}

/// Walks a tree, from a child of it on. With `ANY` it stops at the first hit. Answers whether the
/// nearest hit is a new one.
#[inline(always)]
pub(in crate::scene) fn walk<R: Real<Scalar = f32>, const ANY: bool>(
    tree: &Tree,
    beyond: &impl Beyond,
    from: Code,
    ray: &Prepared,
    nearest: &mut Nearest,
    pending: &mut [u64],
) -> bool {
    let mut found = false;
    let mut top = 0;
    let mut code = from;
    loop {
        let entered = match code.node() {
            Some(i) => enter::<R, ANY>(&tree.nodes[i], ray, nearest.t, pending, &mut top),
            None => {
                let met = match code.child() {
                    Child::Triangles(i) => packet::<R, ANY>(tree, i, ray, nearest),
                    Child::Cutouts(i) => cutouts::<R>(tree, i, beyond, ray, nearest),
                    child => beyond.meet::<R, ANY>(child, ray, nearest, &mut pending[top..]),
                };
                found |= met;
                if ANY && met {
                    return true;
                }
                None
            }
        };
        code = match entered {
            Some(code) => code,
            None => {
                // Keys are in the order of their distances.
                let farthest = u64::from(nearest.t.to_bits()) << 32 | u64::from(u32::MAX);
                loop {
                    if top == 0 {
                        return found;
                    }
                    top -= 1;
                    let key = pending[top];
                    if key <= farthest {
                        break Code::from_key(key);
                    }
                }
            }
        };
    }
}

/// The child of a node to go on with, if the ray meets any; the others wait, the nearest on top.
#[inline(always)]
fn enter<R: Real<Scalar = f32>, const ANY: bool>(
    node: &Node,
    ray: &Prepared,
    t_max: f32,
    pending: &mut [u64],
    top: &mut usize,
) -> Option<Code> {
    let mut enters = [0.0; 8];
    let mut mask = boxes::<R>(node, ray, t_max, &mut enters);
    if mask == 0 {
        return None;
    }
    let mut next = || {
        let i = mask.trailing_zeros() as usize & 7;
        mask &= mask - 1;
        (node.children[i].key(enters[i]), mask != 0)
    };
    let (mut nearest, mut more) = next();
    let bottom = *top;
    while more {
        let key;
        (key, more) = next();
        wait::<ANY>(key.max(nearest), bottom, pending, top);
        nearest = key.min(nearest);
    }
    Some(Code::from_key(nearest))
}

/// Puts a child on the stack; the farthest of a node stays at the bottom, unless any will do.
#[inline(always)]
pub(super) fn wait<const ANY: bool>(key: u64, bottom: usize, pending: &mut [u64], top: &mut usize) {
    let mut place = *top;
    if !ANY {
        // By insertion; few children are ever hit.
        while place > bottom && pending[place - 1] < key {
            pending[place] = pending[place - 1];
            place -= 1;
        }
    }
    pending[place] = key;
    *top += 1;
}
