//! Surface stage: the surface points of a wave's hits, in columns.

use glam::Vec3;

use super::geometry::{
    SurfaceDerivatives, SurfaceDerivativesPacket, SurfacePacket, SurfacePoint, TriangleLanes,
};
use super::transform::to_f64;
use super::{Geometry, InstancePose, Quadric, Scene, object_point};
use petzval_base::lanes::vector::{add, splat, transform};
use petzval_base::lanes::{LaneIndices, Real, widen};
use petzval_base::rays::{Hit, HitBatch, NO_INDEX, RayBatch, SortedColumn};

/// A vector for every entry.
pub type VectorColumns = [SortedColumn<f32>; 3];

/// Surface points in columns, world space.
#[derive(Clone, Debug, Default)]
pub struct SurfaceColumns {
    position: VectorColumns,
    error: VectorColumns,
    normal: VectorColumns,
    shading_normal: VectorColumns,
    uv: [SortedColumn<f32>; 2],
    dp: [VectorColumns; 2],
    dn: [VectorColumns; 2],
    /// 1 on meshes with vertex normals that are not patches, otherwise 0; see
    /// [`super::Mesh::is_smooth`].
    smooth: SortedColumn<f32>,
}

/// Loads the packet of a vector that begins at an entry.
#[inline(always)]
pub fn load_vector<R: Real<Scalar = f32>>(columns: &VectorColumns, at: usize) -> [R; 3] {
    [R::load(&columns[0][at..]), R::load(&columns[1][at..]), R::load(&columns[2][at..])]
}

/// Stores the packet of a vector that begins at an entry.
#[inline(always)]
pub fn store_vector<R: Real<Scalar = f32>>(columns: &mut VectorColumns, at: usize, from: [R; 3]) {
    for axis in 0..3 {
        from[axis].store(&mut columns[axis][at..]);
    }
}

impl SurfaceColumns {
    /// Returns the points of the packet that begins at an entry.
    #[inline(always)]
    pub fn points<R: Real<Scalar = f32>>(&self, at: usize) -> SurfacePacket<R> {
        SurfacePacket {
            position: load_vector(&self.position, at),
            error: load_vector(&self.error, at),
            normal: load_vector(&self.normal, at),
            shading_normal: load_vector(&self.shading_normal, at),
        }
    }

    /// Returns the points of entries that are anywhere in the columns.
    #[inline(always)]
    pub fn gather<R: Real<Scalar = f32>>(&self, entries: &LaneIndices) -> SurfacePacket<R> {
        SurfacePacket {
            position: entries.load_vector(&self.position),
            error: entries.load_vector(&self.error),
            normal: entries.load_vector(&self.normal),
            shading_normal: entries.load_vector(&self.shading_normal),
        }
    }

    /// Returns the positions of entries that are anywhere in the columns.
    #[inline(always)]
    pub fn gather_positions<R: Real<Scalar = f32>>(&self, entries: &LaneIndices) -> [R; 3] {
        entries.load_vector(&self.position)
    }

    /// Returns the unit shading normals of the packet that begins at an entry.
    #[inline(always)]
    pub fn shading_normals<R: Real<Scalar = f32>>(&self, at: usize) -> [R; 3] {
        load_vector(&self.shading_normal, at)
    }

    /// Returns the unit shading normal of an entry.
    pub fn shading_normal(&self, at: usize) -> [f32; 3] {
        load_vector(&self.shading_normal, at)
    }

    /// Returns the derivatives of the packet that begins at an entry.
    #[inline(always)]
    pub fn derivatives<R: Real<Scalar = f32>>(&self, at: usize) -> SurfaceDerivativesPacket<R> {
        SurfaceDerivativesPacket {
            uv: [R::load(&self.uv[0][at..]), R::load(&self.uv[1][at..])],
            dp: [load_vector(&self.dp[0], at), load_vector(&self.dp[1], at)],
            dn: [load_vector(&self.dn[0], at), load_vector(&self.dn[1], at)],
        }
    }

    /// Returns the lanes of the packet that begins at an entry whose meshes are smooth.
    #[inline(always)]
    pub fn smooth<R: Real<Scalar = f32>>(&self, at: usize) -> R::Mask {
        R::splat(0.0).lt(R::load(&self.smooth[at..]))
    }

    /// Loads the points where rays scatter in media, from the entry `first` on. They have no normal;
    /// the direction to where the ray came from takes its place.
    pub fn load_collisions(
        &mut self,
        rays: &RayBatch,
        hits: &HitBatch,
        order: &[u32],
        first: usize,
    ) {
        for (at, &ray) in (first..).zip(order) {
            let i = ray as usize;
            let (ray, t) = (rays.ray(i), hits[i].t);
            let mut point = SurfacePacket::<f32> {
                position: ray.origin,
                error: [0.0; 3],
                normal: ray.direction.map(|axis| -axis),
                shading_normal: ray.direction.map(|axis| -axis),
            };
            for axis in 0..3 {
                point.position[axis] += t * ray.direction[axis];
            }
            self.set_points(at, &point);
        }
    }

    #[inline(always)]
    fn set_points<R: Real<Scalar = f32>>(&mut self, at: usize, points: &SurfacePacket<R>) {
        store_vector(&mut self.position, at, points.position);
        store_vector(&mut self.error, at, points.error);
        store_vector(&mut self.normal, at, points.normal);
        store_vector(&mut self.shading_normal, at, points.shading_normal);
    }

    #[inline(always)]
    fn set_derivatives<R: Real<Scalar = f32>>(
        &mut self,
        at: usize,
        derivatives: &SurfaceDerivativesPacket<R>,
    ) {
        for axis in 0..2 {
            derivatives.uv[axis].store(&mut self.uv[axis][at..]);
            store_vector(&mut self.dp[axis], at, derivatives.dp[axis]);
            store_vector(&mut self.dn[axis], at, derivatives.dn[axis]);
        }
    }
}

/// Entries to load: each is a ray of a wave, and its hit.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceInputs<'a> {
    /// The rays of the wave.
    pub rays: &'a RayBatch,
    /// Their hits.
    pub hits: &'a HitBatch,
    /// Index of the ray of every entry.
    pub order: &'a [u32],
    /// Whether texture coordinates and derivatives are needed.
    pub derivatives: bool,
}

/// Lanes of a packet that triangles do not fill alone.
#[derive(Default)]
struct Exceptions {
    /// Patches, curves and quadrics.
    others: u32,
    instances: u32,
}

impl Scene {
    /// Loads the surface points of hits into the columns, from the entry `first` on: a stage.
    pub fn load_surfaces<R: Real<Scalar = f32>>(
        &self,
        inputs: &SurfaceInputs,
        first: usize,
        columns: &mut SurfaceColumns,
    ) {
        let mut triangles = TriangleLanes::default();
        for (packet, order) in inputs.order.chunks(R::LANES).enumerate() {
            let at = first + packet * R::LANES;
            let (mut u, mut v, mut smooth) = ([0.0; 8], [0.0; 8], [0.0; 8]);
            let mut exceptions = Exceptions::default();
            let mut meshes = [None; 8];
            for (lane, &ray) in order.iter().enumerate() {
                let hit = &inputs.hits[ray as usize];
                (u[lane], v[lane]) = (hit.u, hit.v);
                exceptions.instances |= u32::from(hit.instance != NO_INDEX) << lane;
                match &self.shapes[hit.shape as usize].geometry {
                    Geometry::Mesh(mesh) => {
                        smooth[lane] = f32::from(mesh.is_smooth());
                        meshes[lane] = Some((mesh, hit.primitive));
                    }
                    Geometry::Patches(_) | Geometry::Curves(_) | Geometry::Quadric(_) => {
                        exceptions.others |= 1 << lane;
                    }
                }
            }
            triangles.gather(&meshes, inputs.derivatives);
            if exceptions.others.count_ones() as usize != order.len() {
                let (u, v, triangles) = (R::load(&u), R::load(&v), triangles.load::<R>());
                columns.set_points(at, &triangles.point(u, v));
                if inputs.derivatives {
                    columns.set_derivatives(at, &triangles.derivatives(u, v));
                }
            }
            columns.smooth[at..at + order.len()].copy_from_slice(&smooth[..order.len()]);
            if !inputs.derivatives && self.load_quadrics::<R>(inputs, at, order, columns) {
                continue;
            }
            self.load_exceptions(inputs, at, order, &exceptions, columns);
        }
    }

    /// Loads a packet whose lanes all hit the same quadric, of the same instance. Returns whether
    /// they do.
    #[inline(always)]
    fn load_quadrics<R: Real<Scalar = f32>>(
        &self,
        inputs: &SurfaceInputs,
        at: usize,
        order: &[u32],
        columns: &mut SurfaceColumns,
    ) -> bool {
        let first = &inputs.hits[order[0] as usize];
        let Geometry::Quadric(quadric) = &self.shapes[first.shape as usize].geometry else {
            return false;
        };
        let same = |hit: &Hit| {
            (hit.shape, hit.instance, hit.time.to_bits())
                == (first.shape, first.instance, first.time.to_bits())
        };
        if !order.iter().all(|&ray| same(&inputs.hits[ray as usize])) {
            return false;
        }
        let pose = (first.instance != NO_INDEX).then(|| self.pose(first.instance, first.time));
        let points = quadric_points::<R>(inputs, order, quadric, &pose);
        columns.set_points(at, &points);
        true
    }

    /// Loads patches, curves and quadrics, and moves instances to world space.
    #[inline(always)]
    fn load_exceptions(
        &self,
        inputs: &SurfaceInputs,
        at: usize,
        order: &[u32],
        exceptions: &Exceptions,
        columns: &mut SurfaceColumns,
    ) {
        let mut lanes = exceptions.others | exceptions.instances;
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize;
            lanes &= lanes - 1;
            let (ray, entry) = (order[lane] as usize, at + lane);
            let hit = &inputs.hits[ray];
            let pose = (hit.instance != NO_INDEX).then(|| self.pose(hit.instance, hit.time));
            let geometry = &self.shapes[hit.shape as usize].geometry;
            if let (Geometry::Quadric(quadric), false) = (geometry, inputs.derivatives) {
                let order = &order[lane..lane + 1];
                columns.set_points(entry, &quadric_points::<f32>(inputs, order, quadric, &pose));
                continue;
            }
            let mut point = SurfacePoint::from(columns.points::<f32>(entry));
            let mut derivatives = SurfaceDerivatives::default();
            if inputs.derivatives {
                derivatives = columns.derivatives::<f32>(entry).into();
            }
            if exceptions.others >> lane & 1 == 1 {
                let near = || object_point(&inputs.rays.ray(ray), hit, &pose);
                point = geometry.point(hit, near);
                if inputs.derivatives {
                    derivatives = geometry.derivatives(hit, near);
                }
            }
            if let Some(pose) = &pose {
                if inputs.derivatives {
                    derivatives = pose.place_derivatives(&derivatives, point.shading_normal);
                }
                point = pose.place_point(&point);
            }
            columns.set_points::<f32>(entry, &point.into());
            if inputs.derivatives {
                columns.set_derivatives::<f32>(entry, &derivatives.into());
            }
        }
    }
}

/// Returns the surface points of rays that hit a quadric, world space.
#[inline(always)]
fn quadric_points<R: Real<Scalar = f32>>(
    inputs: &SurfaceInputs,
    order: &[u32],
    quadric: &Quadric,
    pose: &Option<InstancePose>,
) -> SurfacePacket<R> {
    let (mut origin, mut direction, mut t) = ([[0.0; 8]; 3], [[0.0; 8]; 3], [0.0; 8]);
    for (lane, &ray) in order.iter().enumerate() {
        let i = ray as usize;
        for axis in 0..3 {
            origin[axis][lane] = inputs.rays.origin[axis][i];
            direction[axis][lane] = inputs.rays.direction[axis][i];
        }
        t[lane] = inputs.hits[i].t;
    }
    let t = widen(R::load(&t));
    let mut near = [R::Double::splat(0.0); 3];
    for axis in 0..3 {
        let along = widen(R::load(&direction[axis])) * t;
        near[axis] = widen(R::load(&origin[axis])) + along;
    }
    let Some(InstancePose { world_from_object, object_from_world }) = pose else {
        return quadric.points(near);
    };
    let matrix = to_f64(object_from_world);
    let columns = matrix.matrix3.to_cols_array_2d().map(splat);
    let near = add(transform(&columns, near), splat(matrix.translation.to_array()));
    quadric.points::<R>(near).transform(world_from_object, object_from_world)
}

impl InstancePose {
    /// Returns the area in world space of a unit area in object space with this unit normal.
    pub fn area_scale(&self, normal: Vec3) -> f32 {
        let inverse_transpose = self.object_from_world.matrix3.transpose();
        (self.world_from_object.matrix3.determinant() * (inverse_transpose * normal).length()).abs()
    }

    /// Transforms a surface point from object space to world space.
    pub fn place_point(&self, point: &SurfacePoint) -> SurfacePoint {
        let Self { world_from_object, object_from_world } = self;
        SurfacePacket::from(*point).transform(world_from_object, object_from_world).into()
    }

    /// Transforms surface derivatives from object space to world space. `normal` is the unit
    /// shading normal in object space.
    pub(super) fn place_derivatives(
        &self,
        patch: &SurfaceDerivatives,
        normal: Vec3,
    ) -> SurfaceDerivatives {
        patch.transform(&self.world_from_object, &self.object_from_world, normal)
    }
}
