//! Harnesses of the stages, shared by `petzval bench` and the benchmarks in `benches/`.

pub mod hills;
pub mod launch;
pub mod lens_wave;
pub mod textbook;
