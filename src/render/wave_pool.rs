//! Waves that are lent to work items.

use std::sync::Mutex;

use super::wave::Wave;
use super::workers::lock;
use crate::job::Job;

/// The waves of a render, made when they are first needed.
///
/// An item owns its wave while it renders, and holds no lock. If a stage should ever wait for other
/// tasks of the thread pool, the thread may begin another item, which gets another wave: neither a
/// deadlock nor a wave with the rays of two items is possible.
#[derive(Default)]
pub(super) struct WavePool {
    idle: Mutex<Vec<Box<Wave>>>,
}

impl WavePool {
    /// Lends a wave to a task. A wave is lost if the task panics.
    pub fn lend<T>(&self, job: &Job, task: impl FnOnce(&mut Wave) -> T) -> T {
        let idle = lock(&self.idle).pop();
        let mut wave = idle.unwrap_or_else(|| Wave::new(job));
        let result = task(&mut wave);
        lock(&self.idle).push(wave);
        result
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prepare::{Changes, prepare};
    use crate::scene::pbrt;

    #[test]
    fn a_task_inside_a_task_gets_a_wave_of_its_own() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("sky.pbrt");
        std::fs::write(&path, "Camera \"perspective\" WorldBegin LightSource \"infinite\"")
            .expect("a scene");
        let description = pbrt::read(&path).expect("a scene");
        let (job, ..) = prepare(description, &Changes::default()).expect("a job");
        let pool = WavePool::default();
        let address = |wave: &mut Wave| std::ptr::from_ref(wave) as usize;
        let [outer, inner] =
            pool.lend(&job, |wave| [address(wave), pool.lend(&job, |wave| address(wave))]);
        assert_ne!(outer, inner);
        // Both are idle again, and serve the next tasks.
        let next = pool.lend(&job, |wave| address(wave));
        assert!(next == outer || next == inner);
    }
}
