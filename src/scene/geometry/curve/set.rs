//! Storage of curves: their segments, each stored once.

use glam::{DAffine3, DVec3, Vec3};

use super::tessellate::{CurveSegment, tessellate_curve};
use super::{piece, slerp};
use crate::geometry::Mesh;

/// Shape of the cross-section of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CurveKind {
    /// A strip that faces every ray.
    Flat,
    /// A strip that faces every ray, with the normals of a tube.
    Cylinder,
    /// A strip that is perpendicular to given normals.
    Ribbon,
}

/// One cubic segment of a curve in storage.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct CubicPoints {
    /// Bezier control points.
    pub control: [[f32; 3]; 4],
    /// Widths at its ends.
    pub width: [f32; 2],
}

/// Segments of curves of one kind, in the space of the object that they belong to.
#[derive(Clone, Debug, PartialEq)]
pub struct CurveSet {
    kind: CurveKind,
    /// Whether the normals are reversed, by ReverseOrientation or a mirroring transform.
    flipped: bool,
    segments: Vec<CubicPoints>,
    /// Unit normals at the ends of each segment of ribbons; otherwise empty.
    normals: Vec<[[f32; 3]; 2]>,
    /// Number of pieces up to the end of each segment; see [`super::CurvePiece`].
    piece_ends: Vec<u32>,
    /// Segment of every [`PIECE_STEP`]-th piece; empty before [`CurveSet::finish`]. A search
    /// among all of `piece_ends` misses the cache at each step.
    piece_marks: Vec<u32>,
}

/// Number of pieces between two marks.
const PIECE_STEP: u32 = 64;

impl CurveSet {
    /// Returns an empty set.
    pub fn new(kind: CurveKind, flipped: bool) -> Self {
        let (segments, normals) = (Vec::new(), Vec::new());
        let (piece_ends, piece_marks) = (Vec::new(), Vec::new());
        Self { kind, flipped, segments, normals, piece_ends, piece_marks }
    }

    /// Adds a segment after it was transformed by a similarity that mirrors nothing. Normals of
    /// segments that are not ribbons count as none. Returns whether all of its numbers are finite;
    /// if not, nothing is added.
    pub fn push(&mut self, segment: &CurveSegment, transform: &DAffine3) -> bool {
        let scale = transform.matrix3.determinant().abs().cbrt();
        let control = segment.control.map(|p| transform.transform_point3(p).as_vec3().to_array());
        let width = segment.width.map(|w| (w * scale) as f32);
        let normals = segment.normals.unwrap_or_default();
        let normals = normals.map(|n| (transform.matrix3 * n / scale).as_vec3().to_array());
        let numbers = control.iter().chain(&normals).flatten().chain(&width);
        if !numbers.fold(0.0, |sum, v| sum + v * 0.0).eq(&0.0) {
            return false;
        }
        self.piece_marks.clear();
        self.segments.push(CubicPoints { control, width });
        if self.kind == CurveKind::Ribbon {
            self.normals.push(normals);
        }
        let pieces = piece::count(self.segments[self.segments.len() - 1]);
        self.piece_ends.push(self.piece_count() + pieces);
        true
    }

    /// Moves the segments of another set to the end of this one. Returns the other set if its
    /// normals differ in kind or side.
    pub fn append(&mut self, other: Self) -> Result<(), Self> {
        let first = self.piece_count();
        let fits = first.checked_add(other.piece_count()).is_some();
        if !fits || (self.kind, self.flipped) != (other.kind, other.flipped) {
            return Err(other);
        }
        self.piece_marks.clear();
        self.segments.extend(other.segments);
        self.normals.extend(other.normals);
        self.piece_ends.extend(other.piece_ends.iter().map(|end| first + end));
        Ok(())
    }

    /// Marks the pieces, so that they are found fast, and returns unused memory to the allocator.
    pub fn finish(&mut self) {
        self.piece_marks = Vec::with_capacity(self.piece_count().div_ceil(PIECE_STEP) as usize);
        for (segment, &end) in (0..).zip(&self.piece_ends) {
            while (self.piece_marks.len() as u64 * u64::from(PIECE_STEP)) < u64::from(end) {
                self.piece_marks.push(segment);
            }
        }
        self.segments.shrink_to_fit();
        self.normals.shrink_to_fit();
        self.piece_ends.shrink_to_fit();
    }

    /// Returns the kind of all curves.
    #[inline(always)]
    pub fn kind(&self) -> CurveKind {
        self.kind
    }

    /// Returns whether the normals are reversed.
    #[inline(always)]
    pub fn is_flipped(&self) -> bool {
        self.flipped
    }

    /// Returns the segments.
    pub fn segments(&self) -> &[CubicPoints] {
        &self.segments
    }

    /// Returns the number of pieces of all segments.
    #[inline(always)]
    pub fn piece_count(&self) -> u32 {
        self.piece_ends.last().copied().unwrap_or(0)
    }

    /// Returns the segment of a piece, the piece's number in it, and the number of its pieces.
    pub(super) fn locate(&self, piece: u32) -> [u32; 3] {
        let mark = (piece / PIECE_STEP) as usize;
        let first = self.piece_marks.get(mark).map_or(0, |&segment| segment as usize);
        // A segment has one piece or more.
        let last =
            self.piece_marks.get(mark + 1).map_or(self.piece_ends.len(), |&next| next as usize + 1);
        let segment = first + self.piece_ends[first..last].partition_point(|&end| end <= piece);
        let start = if segment == 0 { 0 } else { self.piece_ends[segment - 1] };
        [segment as u32, piece - start, self.piece_ends[segment] - start]
    }

    /// Returns the memory of the segments (bytes).
    pub fn bytes(&self) -> u64 {
        let Self { segments, normals, piece_ends, piece_marks, .. } = self;
        let columns = [size_of_val(&segments[..]), size_of_val(&normals[..])];
        let pieces = size_of_val(&piece_ends[..]) + size_of_val(&piece_marks[..]);
        (columns.iter().sum::<usize>() + pieces) as u64
    }

    /// Returns the normal of a ribbon at `u`; its length is close to 1. Returns `None` for other
    /// kinds.
    #[inline(always)]
    pub(super) fn ribbon_normal(&self, segment: u32, u: f64) -> Option<DVec3> {
        let [from, to] = self.normals.get(segment as usize)?.map(|n| Vec3::from(n).as_dvec3());
        Some(if from == to { from } else { slerp(from, to, u) })
    }

    /// Returns the curves as a mesh, which can emit light.
    pub fn tessellate(&self) -> Mesh {
        let double = |p: [f32; 3]| Vec3::from(p).as_dvec3();
        let segments = self.segments.iter().enumerate().map(|(i, points)| CurveSegment {
            control: points.control.map(double),
            width: points.width.map(f64::from),
            normals: self.normals.get(i).map(|n| n.map(double)),
        });
        let mut mesh = tessellate_curve(&segments.collect::<Vec<_>>());
        mesh.transform(&DAffine3::IDENTITY, self.flipped);
        mesh
    }
}
