//! Rays against the tree: the nearest hit, or any hit.
//!
//! One ray meets eight boxes or eight triangles at a time. Boxes are tested with the slack of
//! Ize (2013, "Robust BVH ray traversal") and triangles watertight with the edge functions of
//! Woop, Benthin & Wald (2013, "Watertight ray/triangle intersection"): two triangles that
//! share an edge compute the same number for it, so no ray slips between them.

use glam::{Affine3A, DVec3, Vec3};

use super::Scene;
use super::point::gamma;
use super::tree::{Child, Code, Node, Packet, Tree};
use crate::lanes::Real;
use crate::rays::{Hit, HitBatch, NONE, Ray, RayBatch};

/// A ray made ready for boxes and triangles.
struct Prepared {
    origin: [f32; 3],
    direction: [f32; 3],
    inverse: [f32; 3],
    /// 1 where the ray goes down an axis: the index of its near sides.
    backward: [usize; 3],
    /// The axes in the order in which the last is the one the ray goes along most.
    axes: [usize; 3],
    /// Shear and scale that turn the ray into +z.
    shear: [f32; 3],
}

impl Prepared {
    fn new(origin: [f32; 3], direction: [f32; 3]) -> Self {
        let magnitude = direction.map(f32::abs);
        let z = if magnitude[0] > magnitude[1] {
            if magnitude[0] > magnitude[2] { 0 } else { 2 }
        } else if magnitude[1] > magnitude[2] {
            1
        } else {
            2
        };
        let axes = [(z + 1) % 3, (z + 2) % 3, z];
        let along = direction[z];
        // A slab parallel to the ray is neither entered nor left: its distances are huge, and
        // 0 for a ray in its very plane, but never NaN.
        let inverse = direction.map(|d| (1.0 / d).clamp(-f32::MAX, f32::MAX));
        Self {
            origin,
            direction,
            inverse,
            backward: inverse.map(|d| usize::from(d.is_sign_negative())),
            axes,
            shear: [direction[axes[0]] / along, direction[axes[1]] / along, 1.0 / along],
        }
    }
}

/// What is left to visit: a child and where the ray enters its box.
#[derive(Clone, Copy, Debug)]
struct Visit {
    child: Code,
    enters: f32,
}

/// The nodes that a worker's rays still have to visit.
#[derive(Clone, Debug, Default)]
pub struct TraversalStack(Vec<Visit>);

impl Scene {
    /// The nearest hit of every ray: a stage.
    pub fn intersect<R: Real<Scalar = f32>>(
        &self,
        rays: &RayBatch,
        hits: &mut HitBatch,
        stack: &mut TraversalStack,
    ) {
        for i in 0..rays.len {
            hits[i] = self.closest::<R>(&rays.ray(i), stack);
        }
    }

    /// The nearest hit of one ray.
    pub fn closest<R: Real<Scalar = f32>>(&self, ray: &Ray, stack: &mut TraversalStack) -> Hit {
        let mut hit = Hit { t: ray.t_max, ..Hit::MISS };
        let prepared = Prepared::new(ray.origin, ray.direction);
        self.walk::<R, false>(&self.world, &prepared, NONE, &mut hit, stack);
        hit
    }

    /// Whether anything is in the way of one ray.
    pub fn occluded<R: Real<Scalar = f32>>(&self, ray: &Ray, stack: &mut TraversalStack) -> bool {
        let mut hit = Hit { t: ray.t_max, ..Hit::MISS };
        let prepared = Prepared::new(ray.origin, ray.direction);
        self.walk::<R, true>(&self.world, &prepared, NONE, &mut hit, stack)
    }

    /// Walks a tree. With `ANY` it stops at the first hit; answers whether there was one.
    fn walk<R: Real<Scalar = f32>, const ANY: bool>(
        &self,
        tree: &Tree,
        ray: &Prepared,
        instance: u32,
        hit: &mut Hit,
        stack: &mut TraversalStack,
    ) -> bool {
        if tree.nodes.is_empty() {
            return false;
        }
        let mut found = false;
        let base = stack.0.len();
        let mut node = Some(&tree.nodes[0]);
        loop {
            if let Some(node) = node.take() {
                enter::<R, ANY>(node, ray, hit.t, stack);
            }
            if stack.0.len() == base {
                return found;
            }
            let Some(Visit { child, enters }) = stack.0.pop() else { return found };
            if enters > hit.t {
                continue;
            }
            let met = match child.child() {
                Child::Node(i) => {
                    node = Some(&tree.nodes[i as usize]);
                    false
                }
                Child::Triangles(i) => packet::<R>(&tree.packets[i as usize], ray, instance, hit),
                Child::Quadric(shape) => self.quadric(shape, ray, instance, hit),
                Child::Instance(i) => {
                    let entered = &self.instances[i as usize];
                    let inner = inside(ray, &entered.object_from_world);
                    let tree = &self.objects[entered.object as usize];
                    self.walk::<R, ANY>(tree, &inner, i, hit, stack)
                }
            };
            found |= met;
            if ANY && found {
                stack.0.truncate(base);
                return true;
            }
        }
    }

    fn quadric(&self, shape: u32, ray: &Prepared, instance: u32, hit: &mut Hit) -> bool {
        let Some(quadric) = self.shapes[shape as usize].quadric() else { return false };
        let double = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
        let t = quadric.intersect(double(ray.origin), double(ray.direction), f64::from(hit.t));
        let Some(t) = t.map(|t| t as f32).filter(|&t| t > 0.0 && t < hit.t) else { return false };
        *hit = Hit { t, u: 0.0, v: 0.0, shape, primitive: 0, instance };
        true
    }
}

/// A ray in the space of an instanced object; distances along it stay what they are.
fn inside(ray: &Prepared, object_from_world: &Affine3A) -> Prepared {
    let origin = object_from_world.transform_point3(Vec3::from(ray.origin));
    let direction = object_from_world.transform_vector3(Vec3::from(ray.direction));
    Prepared::new(origin.to_array(), direction.to_array())
}

/// Puts the children that the ray meets on the stack, the nearest on top.
#[inline(always)]
fn enter<R: Real<Scalar = f32>, const ANY: bool>(
    node: &Node,
    ray: &Prepared,
    t_max: f32,
    stack: &mut TraversalStack,
) {
    let mut near = [0.0f32; 8];
    let mut mask = 0;
    for lane in (0..8).step_by(R::LANES) {
        let side = |which: usize, axis: usize| {
            let plane = R::load(&node.bounds[which][axis][lane..]);
            (plane - R::splat(ray.origin[axis])) * R::splat(ray.inverse[axis])
        };
        let [bx, by, bz] = ray.backward;
        let zero = R::constant(0.0);
        let enters = side(bx, 0).max(side(by, 1)).max(side(bz, 2).max(zero));
        let leaves = side(1 - bx, 0).min(side(1 - by, 1)).min(side(1 - bz, 2).min(R::splat(t_max)));
        // Two roundings on either side (Ize 2013).
        let slack = R::constant(1.000_000_5);
        mask |= R::bits(enters.le(leaves * slack)) << lane;
        enters.store(&mut near[lane..]);
    }
    let bottom = stack.0.len();
    while mask != 0 {
        let i = mask.trailing_zeros() as usize;
        mask &= mask - 1;
        let visit = Visit { child: node.children[i], enters: near[i] };
        stack.0.push(visit);
        if !ANY {
            // Insertion keeps the farthest at the bottom; few children are ever hit.
            let visits = &mut stack.0[bottom..];
            let mut place = visits.len() - 1;
            while place > 0 && visits[place - 1].enters < visit.enters {
                visits[place] = visits[place - 1];
                place -= 1;
            }
            visits[place] = visit;
        }
    }
}

/// One ray against eight triangles. Answers whether one is nearer than the hit so far.
#[inline(always)]
fn packet<R: Real<Scalar = f32>>(
    packet: &Packet,
    ray: &Prepared,
    instance: u32,
    hit: &mut Hit,
) -> bool {
    let [kx, ky, kz] = ray.axes;
    let mut distances = [0.0f32; 8];
    let mut weights = [[0.0f32; 8]; 2];
    let mut mask = 0;
    for lane in (0..8).step_by(R::LANES) {
        let corner = |i: usize| {
            let relative = |axis: usize| {
                R::load(&packet.corners[i][axis][lane..]) - R::splat(ray.origin[axis])
            };
            let along = relative(kz);
            [
                relative(kx) - R::splat(ray.shear[0]) * along,
                relative(ky) - R::splat(ray.shear[1]) * along,
                R::splat(ray.shear[2]) * along,
            ]
        };
        let [[ax, ay, az], [bx, by, bz], [cx, cy, cz]] = [corner(0), corner(1), corner(2)];
        // Never fused: the edge shared by two triangles must give the same number, up to its
        // sign, from both. Products round monotonically, so a sign is never wrong; at worst a
        // number is 0, and 0 counts as inside on both sides.
        let edge = [cx * by - cy * bx, ax * cy - ay * cx, bx * ay - by * ax];
        let zero = R::constant(0.0);
        let [u, v, w] = edge;
        let above = zero.le(u) & zero.le(v) & zero.le(w);
        let below = u.le(zero) & v.le(zero) & w.le(zero);
        let det = u + v + w;
        let t = (u * az + v * bz + w * cz) / det;
        // 0 / 0, a ray in the plane of its triangle, is NaN and fails both comparisons.
        let inside = (above | below) & zero.lt(t) & t.lt(R::splat(hit.t));
        if R::bits(inside) == 0 {
            continue;
        }
        let least = t_error([ax, bx, cx], [ay, by, cy], [az, bz, cz], edge, det);
        mask |= R::bits(inside & least.lt(t)) << lane;
        t.store(&mut distances[lane..]);
        (v / det).store(&mut weights[0][lane..]);
        (w / det).store(&mut weights[1][lane..]);
    }
    let any = mask != 0;
    while mask != 0 {
        let i = mask.trailing_zeros() as usize;
        mask &= mask - 1;
        if distances[i] < hit.t {
            *hit = Hit {
                t: distances[i],
                u: weights[0][i],
                v: weights[1][i],
                shape: packet.shape[i],
                primitive: packet.triangle[i],
                instance,
            };
        }
    }
    any
}

/// A bound on the absolute error of t: what is nearer than that may be the surface that the ray
/// leaves (Pharr, Jakob & Humphreys, "Physically Based Rendering", 6.8.7).
#[inline(always)]
fn t_error<R: Real<Scalar = f32>>(x: [R; 3], y: [R; 3], z: [R; 3], edge: [R; 3], det: R) -> R {
    let largest = |[a, b, c]: [R; 3]| a.abs().max(b.abs()).max(c.abs());
    let bound = |n: u32| R::splat(gamma(n));
    let (x, y, z, edge) = (largest(x), largest(y), largest(z), largest(edge));
    let (dx, dy, dz) = (bound(5) * (x + z), bound(5) * (y + z), bound(3) * z);
    let d_edge = R::splat(2.0) * (bound(2) * x * y + dy * x + dx * y);
    R::splat(3.0) * (bound(3) * edge * z + d_edge * z + dz * edge) / det.abs()
}
