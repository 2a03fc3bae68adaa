//! Leaf tests of a packet of rays in step: eight rays with one triangle or quadric.
//!
//! The arithmetic is that of the tests of single rays, so the result for a ray does not depend on
//! the test that its packet takes.

use super::nearest::is_nearer;
use super::ray_packet::RayPacket;
use super::triangles::{Corners, are_ahead, test_edges};
use crate::bvh::{Bvh, PlacedQuadric, TrianglePacket};
use petzval_base::lanes::{Real, widen};

impl RayPacket {
    /// Intersects the rays in `mask` with each triangle of a packet. Returns the rays that found a
    /// nearer hit, as a bit mask, or `None` if the rays are too few: one ray tests eight triangles
    /// at once.
    #[inline(always)]
    pub(super) fn intersect_triangles<R: Real<Scalar = f32>, const ANY: bool>(
        &mut self,
        bvh: &Bvh,
        number: u32,
        mask: u32,
    ) -> Option<u32> {
        let packet = &bvh.packets[number as usize];
        let count = packet.len::<R>();
        if count > mask.count_ones() {
            return None;
        }
        let t_max = self.t;
        let mut found = 0;
        for triangle in 0..count as usize {
            for lane in (0..8).step_by(R::LANES) {
                let all = (1 << R::LANES) - 1;
                let active = if ANY { mask & !found } else { mask } >> lane & all;
                let corners = self.relative_corners::<R>(packet, triangle & 7, lane);
                let shear = self.load_columns::<R>(&self.shear, lane);
                let t_max = R::load(&t_max[lane..]);
                let test = test_edges(&corners, shear, t_max);
                let hits = R::bits(test.mask) & active;
                if hits == 0 {
                    continue;
                }
                let t = test.t / test.sum;
                let mut hits = hits & R::bits(are_ahead(&corners, shear, t, test.mask));
                if ANY {
                    // The quotient may round to the end of the ray, where nothing blocks it.
                    found |= (hits & R::bits(t.lt(t_max))) << lane;
                    continue;
                }
                let (mut ts, mut weights) = ([0.0; 8], [[0.0; 8]; 2]);
                t.store(&mut ts);
                (test.edge[0] / test.sum).store(&mut weights[0]);
                (test.edge[1] / test.sum).store(&mut weights[1]);
                while hits != 0 {
                    let i = hits.trailing_zeros() as usize & 7;
                    hits &= hits - 1;
                    let ray = (lane + i) & 7;
                    let (best, slot) = (&mut self.nearest[ray], number * 8 + triangle as u32);
                    if is_nearer(bvh, ts[i], slot, best) {
                        (best.t, best.triangle_slot) = (ts[i], slot);
                        best.weights = [weights[0][i], weights[1][i]];
                        self.t[ray] = ts[i];
                        found |= 1 << ray;
                    }
                }
            }
        }
        Some(found)
    }

    /// Intersects the rays in `mask` with a quadric. Returns the rays that found a nearer hit, as a
    /// bit mask, or `None` if the quadric needs an alpha test.
    #[inline(never)]
    pub(super) fn intersect_quadric<R: Real<Scalar = f32>>(
        &mut self,
        quadric: &PlacedQuadric,
        mask: u32,
    ) -> Option<u32> {
        if quadric.alpha_tested {
            return None;
        }
        let mut found = 0;
        for lane in (0..8).step_by(R::LANES) {
            let mut active = mask >> lane & ((1 << R::LANES) - 1);
            if active == 0 {
                continue;
            }
            let zero = R::Double::constant(0.0);
            let (mut origin, mut direction) = ([zero; 3], [zero; 3]);
            for axis in 0..3 {
                origin[axis] = widen(R::load(&self.origin[axis][lane..]));
                direction[axis] = widen(R::load(&self.direction[axis][lane..]));
            }
            let mut distances = [0.0; 8];
            let t_max = widen(R::load(&self.t[lane..]));
            quadric.surface.intersect(origin, direction, t_max).store(&mut distances);
            while active != 0 {
                let i = active.trailing_zeros() as usize & 7;
                active &= active - 1;
                let (ray, t) = ((lane + i) & 7, distances[i] as f32);
                if t > 0.0 && t < self.t[ray] {
                    self.nearest[ray].replace(&quadric.hit(t));
                    self.t[ray] = t;
                    found |= 1 << ray;
                }
            }
        }
        Some(found)
    }

    #[inline(always)]
    pub(super) fn load_columns<R: Real<Scalar = f32>>(
        &self,
        columns: &[[f32; 8]; 3],
        lane: usize,
    ) -> [R; 3] {
        let [x, y, z] = columns;
        [R::load(&x[lane..]), R::load(&y[lane..]), R::load(&z[lane..])]
    }

    /// Returns the corners of a triangle relative to the rays from a lane on.
    #[inline(always)]
    fn relative_corners<R: Real<Scalar = f32>>(
        &self,
        packet: &TrianglePacket,
        triangle: usize,
        lane: usize,
    ) -> Corners<R> {
        let origin = self.load_columns::<R>(&self.origin, lane);
        let largest = R::load(&self.largest[lane..]);
        let (is_x, is_y) = (largest.equals(R::constant(0.0)), largest.equals(R::constant(1.0)));
        let pick = |x: R, y: R, z: R| R::select(is_x, x, R::select(is_y, y, z));
        let mut corners = [[R::constant(0.0); 3]; 3];
        for corner in 0..3 {
            let at = |axis: usize| R::splat(packet.corners[corner][axis][triangle]) - origin[axis];
            let [x, y, z] = [at(0), at(1), at(2)];
            corners[corner] = [pick(y, z, x), pick(z, x, y), pick(x, y, z)];
        }
        corners
    }
}

impl TrianglePacket {
    /// Returns the number of its triangles, which come before the missing ones.
    #[inline(always)]
    fn len<R: Real<Scalar = f32>>(&self) -> u32 {
        let mut present = 0;
        for lane in (0..8).step_by(R::LANES) {
            let x = R::load(&self.corners[0][0][lane..]);
            present |= R::bits(x.equals(x)) << lane;
        }
        present.trailing_ones()
    }
}
