//! Pool of work columns that are lent to tasks.

use std::sync::{Mutex, PoisonError};

/// Columns that tasks on several threads share, made when they are first needed.
///
/// A task owns its columns while it runs, and holds no lock. If it should ever wait for other tasks of
/// the thread pool, the thread may begin another one, which gets other columns: neither a deadlock nor
/// columns with the rays of two tasks are possible.
#[derive(Debug)]
pub struct ColumnPool<T> {
    idle: Mutex<Vec<Box<T>>>,
}

impl<T> Default for ColumnPool<T> {
    fn default() -> Self {
        Self { idle: Mutex::default() }
    }
}

impl<T> ColumnPool<T> {
    /// Lends columns to a task, those of an earlier task if any are idle. They are lost if the task
    /// panics.
    pub fn lend<O>(&self, make: impl FnOnce() -> Box<T>, task: impl FnOnce(&mut T) -> O) -> O {
        let lock = || self.idle.lock().unwrap_or_else(PoisonError::into_inner);
        let idle = lock().pop();
        let mut columns = idle.unwrap_or_else(make);
        let result = task(&mut columns);
        lock().push(columns);
        result
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_task_inside_a_task_gets_columns_of_its_own() {
        let pool = ColumnPool::<u8>::default();
        let lend =
            |task: &dyn Fn(&mut u8) -> u8| pool.lend(|| Box::new(0), |columns| task(columns));
        let inner = lend(&|outer| {
            *outer = 1;
            lend(&|inner| std::mem::replace(inner, 2))
        });
        assert_eq!(inner, 0);
        // Both are idle again, and serve the next tasks.
        let next = lend(&|outer| 4 * *outer + lend(&|inner| *inner));
        assert!([6, 9].contains(&next), "{next}");
    }
}
