//! Preparer: prepares pictures with their plan beside the engine, which goes on with drafts.

use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::Scope;
use std::time::Duration;

use petzval_render::prepare::{Changes, PrepareError, Prepared, prepare};
use petzval_scene_formats::pbrt::Description;

/// The settings of a generation.
type Order = (u64, Changes);
/// The picture of a generation.
type Delivery = (u64, Result<Box<Prepared>, PrepareError>);

/// The thread that prepares, as the engine sees it. It ends with this.
pub(super) struct Preparer {
    orders: Sender<Order>,
    results: Receiver<Delivery>,
}

impl Preparer {
    /// Starts the thread.
    pub fn start<'scope>(scope: &'scope Scope<'scope, '_>, description: Description) -> Self {
        let (orders, received) = channel::<Order>();
        let (sent, results) = channel();
        scope.spawn(move || {
            while let Ok(mut order) = received.recv() {
                // Only the last settings are still of interest.
                while let Ok(newer) = received.try_recv() {
                    order = newer;
                }
                let (generation, changes) = order;
                let prepared = prepare(description.clone(), &changes).map(Box::new);
                if sent.send((generation, prepared)).is_err() {
                    return;
                }
            }
        });
        Self { orders, results }
    }

    /// Orders the picture of a generation.
    pub fn order(&self, generation: u64, changes: Changes) {
        // The thread ends only with this, or if it has panicked; then there is no result.
        let _ = self.orders.send((generation, changes));
    }

    /// Waits a time at most for the picture of a generation, and drops those of earlier ones.
    pub fn result(&self, generation: u64, most: Duration) -> PrepareStatus {
        loop {
            match self.results.recv_timeout(most) {
                Ok((of, result)) if of == generation => return PrepareStatus::Ready(result),
                Ok(_) => {}
                Err(RecvTimeoutError::Timeout) => return PrepareStatus::Working,
                Err(RecvTimeoutError::Disconnected) => return PrepareStatus::Ended,
            }
        }
    }
}

/// Whether a picture is prepared.
pub(super) enum PrepareStatus {
    Ready(Result<Box<Prepared>, PrepareError>),
    Working,
    /// The thread has ended by a panic.
    Ended,
}
