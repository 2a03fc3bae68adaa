//! Shading context: the textures and the perturbed shading normals at points of a material, lane by
//! lane.

use std::cell::OnceCell;

use glam::{Vec2, Vec3};

use super::bsdf::SurfaceTextures;
use super::footprint::PixelFootprint;
use super::neighbour_ray::{NeighbourRay, SpecularBounce};
use petzval_base::lanes::Real;
use petzval_base::lanes::vector::{
    cross, dot, normalize, orthonormal_pair, scale, scale_add, select, splat, sub,
};
use petzval_base::rays::RayDifferential;
use petzval_scene::{
    ImageMap, Material, SurfaceDerivativesPacket, SurfacePacket, Texture, TexturePoint,
};

/// Points of surfaces of one material that rays hit, one per lane.
pub(super) struct ShadingContext<R: Real = f32> {
    pub(super) points: SurfacePacket<R>,
    pub(super) patch: SurfaceDerivativesPacket<R>,
    /// Direction of the shading frame, of any length: along u, or that of the mesh.
    pub(super) tangent: [R; 3],
    /// Lanes whose meshes bump maps displace along the vertex normals or tangents.
    pub(super) smooth: R::Mask,
    /// Colours of the vertices of meshes, if the material needs them.
    pub(super) vertex_colour: Option<[R; 4]>,
    /// Rays of the neighbouring samples.
    pub(super) neighbours: [NeighbourRay<R>; 2],
    /// Whether textures need the change of the position to the neighbouring samples.
    solid: bool,
    /// Computed on first use.
    texture_point: OnceCell<TexturePoint<R>>,
}

/// Step in texture coordinates for the slope of a height map, if the pixel's footprint gives none;
/// the value is pbrt-v4's.
const DEFAULT_STEP: f32 = 0.0005;

impl<R: Real<Scalar = f32>> ShadingContext<R> {
    /// The context of points as seen by the camera itself, in a scene with or without solid
    /// textures.
    #[inline(always)]
    pub(super) fn new(
        points: SurfacePacket<R>,
        patch: SurfaceDerivativesPacket<R>,
        smooth: R::Mask,
        footprint: &PixelFootprint,
        solid: bool,
    ) -> Self {
        let neighbours = footprint.neighbour_rays(points.position);
        let tangent = patch.dp[0];
        Self {
            points,
            patch,
            tangent,
            smooth,
            vertex_colour: None,
            neighbours,
            solid,
            texture_point: OnceCell::new(),
        }
    }

    /// A context for materials that do not vary over surfaces.
    pub(super) fn anywhere() -> Self {
        let (zero, none) = (R::splat(0.0), [R::splat(0.0); 3]);
        Self {
            points: SurfacePacket {
                position: none,
                error: none,
                normal: none,
                shading_normal: none,
            },
            patch: SurfaceDerivativesPacket { uv: [zero; 2], dp: [none; 2], dn: [none; 2] },
            tangent: none,
            smooth: zero.lt(zero),
            vertex_colour: None,
            neighbours: [NeighbourRay::NONE.splat(), NeighbourRay::NONE.splat()],
            solid: false,
            texture_point: OnceCell::new(),
        }
    }

    fn texture_point(&self) -> &TexturePoint<R> {
        self.texture_point.get_or_init(|| {
            let uv_steps = self.texture_steps();
            let [[a, b], [c, d]] = uv_steps;
            let none = [[R::splat(0.0); 3]; 2];
            TexturePoint {
                uv: self.patch.uv,
                position: self.points.position,
                normal: self.points.normal,
                footprint: a.abs().max(b.abs()).max(c.abs()).max(d.abs()),
                uv_steps,
                position_steps: if self.solid { self.position_steps() } else { none },
                vertex_colour: self.vertex_colour,
            }
        })
    }

    /// Returns the change of the texture coordinates (u, v) to each of the neighbouring samples.
    #[inline(always)]
    fn texture_steps(&self) -> [[R; 2]; 2] {
        let [one, other] = &self.neighbours;
        let (normal, dp) = (self.points.normal, &self.patch.dp);
        [one.texture_step(normal, dp), other.texture_step(normal, dp)]
    }

    /// Returns the change of the position to each of the neighbouring samples.
    #[inline(never)]
    fn position_steps(&self) -> [[R; 3]; 2] {
        let [one, other] = &self.neighbours;
        let normal = self.points.normal;
        [one.tangent_plane_offset(normal), other.tangent_plane_offset(normal)]
    }

    /// Returns the unit shading normal, perturbed by the material's normal map or bump map, and the
    /// tangent along u.
    #[inline(never)]
    pub(super) fn perturbed_normal(&self, material: &Material) -> [[R; 3]; 2] {
        let (normal, patch) = (self.points.shading_normal, &self.patch);
        if let Some(map) = &material.normal_map {
            // The map is relative to the frame whose x axis is along the tangent.
            let [x, y, z] = mapped_normal(map, patch.uv);
            let along = scale_add(normal, -dot(normal, self.tangent), self.tangent);
            let (tangent, _) = normalize(along);
            let across = cross(normal, tangent);
            let tilted = scale_add(tangent, x, scale_add(across, y, scale(normal, z)));
            return [self.face_outward(tilted), self.tangent];
        }
        let Some(bump) = &material.bump else { return [normal, self.tangent] };
        let (at, steps) = (self.texture_point(), self.texture_steps());
        let tangents = self.displacement_tangents();
        let height = bump.scalar(at);
        let zero = R::splat(0.0);
        let mut displaced = [[zero; 3]; 2];
        for axis in 0..2 {
            let wide = R::splat(0.5) * (steps[0][axis].abs() + steps[1][axis].abs());
            let step = R::select(zero.lt(wide), wide, R::splat(DEFAULT_STEP));
            let mut moved = *at;
            moved.uv[axis] = moved.uv[axis] + step;
            moved.position = scale_add(tangents[axis], step, moved.position);
            let slope = (bump.scalar(&moved) - height) / step;
            let tilted = scale_add(normal, slope, tangents[axis]);
            displaced[axis] = scale_add(patch.dn[axis], height, tilted);
        }
        [self.face_outward(cross(displaced[0], displaced[1])), displaced[0]]
    }

    /// Makes a normal a unit vector on the side of the geometric normal. A normal without a length
    /// becomes the shading normal.
    #[inline(always)]
    fn face_outward(&self, normal: [R; 3]) -> [R; 3] {
        let (unit, some) = normalize(normal);
        let normal = select(some, unit, self.points.shading_normal);
        let inward = dot(normal, self.points.normal).lt(R::splat(0.0));
        select(inward, sub([R::splat(0.0); 3], normal), normal)
    }

    /// Returns the tangents that a bump map displaces, as pbrt-v4 does. They are the derivatives of
    /// the position by u and v, except on meshes with vertex normals. There both are orthogonal to
    /// the shading normal: the first is as close to u, or to the mesh's own tangent, as possible,
    /// and the second has the same length.
    #[inline(always)]
    fn displacement_tangents(&self) -> [[R; 3]; 2] {
        let (normal, patch) = (self.points.shading_normal, &self.patch);
        let across = cross(normal, self.tangent);
        let some = R::splat(0.0).lt(dot(across, across));
        let [x, y] = orthonormal_pair(normal);
        let (along, across) = (select(some, cross(across, normal), x), select(some, across, y));
        [select(self.smooth, along, patch.dp[0]), select(self.smooth, across, patch.dp[1])]
    }
}

impl<R: Real<Scalar = f32>> SurfaceTextures<R> for ShadingContext<R> {
    fn colour(&self, texture: &Texture) -> [R; 3] {
        match texture {
            Texture::Constant(colour) => splat(*colour),
            _ => texture.colour(self.texture_point()),
        }
    }

    fn number(&self, texture: &Texture) -> R {
        match texture {
            Texture::Constant([value, ..]) => R::splat(*value),
            _ => texture.scalar(self.texture_point()),
        }
    }

    fn uv(&self) -> [R; 2] {
        self.patch.uv
    }
}

impl ShadingContext {
    /// Returns the differential of the ray that leaves a smooth surface at this point. `along` is
    /// the direction of the ray that arrives.
    pub(super) fn differential_after_bounce(
        &self,
        along: Vec3,
        bounce: &SpecularBounce,
    ) -> RayDifferential {
        let mut next = RayDifferential::UNKNOWN;
        for (axis, neighbour) in self.neighbours.iter().enumerate() {
            let [origin, direction] =
                neighbour.after_bounce(along, &self.points, &self.patch, bounce);
            if !(origin.is_finite() && direction.is_finite()) {
                return RayDifferential::UNKNOWN;
            }
            (next.origin[axis], next.direction[axis]) = (origin.into(), direction.into());
        }
        next
    }
}

/// Returns the vectors 2 c - 1 of the colours c of a normal map.
fn mapped_normal<R: Real<Scalar = f32>>(map: &ImageMap, uv: [R; 2]) -> [R; 3] {
    let (mut us, mut vs, mut normals) = ([0.0; 8], [0.0; 8], [[0.0; 8]; 3]);
    uv[0].store(&mut us);
    uv[1].store(&mut vs);
    for lane in 0..R::LANES {
        let colour = map.colour(Vec2::new(us[lane], vs[lane]));
        for axis in 0..3 {
            normals[axis][lane] = 2.0 * colour[axis] - 1.0;
        }
    }
    [R::load(&normals[0]), R::load(&normals[1]), R::load(&normals[2])]
}
