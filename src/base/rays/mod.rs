//! Batches of rays, samples and hits that flow between the stages.
//!
//! A *wave* is up to [`WAVE_SIZE`] rays in structure-of-arrays columns, owned by one worker and
//! small enough to stay in its caches. Columns are aligned to a cache line: unaligned columns make
//! the lens stage 40 % slower.

mod column;
mod column_pool;
mod hit;
mod path_flags;
mod ray;
mod samples;

pub use column::{Column, MAX_GROUPS, SortedColumn, WAVE_SIZE, packet_count};
pub use column_pool::ColumnPool;
pub use hit::{Hit, HitBatch, NO_INDEX};
pub use path_flags::PathFlags;
pub use ray::{Ray, RayBatch, RayDifferential, SpawnedRays};
pub use samples::{LensBatch, ReprojectionBatch, SampleBatch};
