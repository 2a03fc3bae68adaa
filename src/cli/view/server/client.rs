//! Client: what the two threads of a WebSocket know of each other.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use tungstenite::Message;

/// Largest number of answers that wait for a client. Beyond it the connection is closed: the client
/// sends messages and does not read.
const MAX_WAITING: usize = 16;

/// A client of the view.
#[derive(Default)]
pub(super) struct Client {
    /// Whether it has asked for the next frame.
    pub asked: AtomicBool,
    /// Whether its connection ends.
    pub closed: AtomicBool,
    answers: Mutex<VecDeque<Message>>,
}

impl Client {
    /// Adds an answer for the client.
    pub fn answer(&self, message: Message) {
        let mut answers = self.answers.lock().unwrap_or_else(PoisonError::into_inner);
        answers.push_back(message);
        if answers.len() > MAX_WAITING {
            self.closed.store(true, Ordering::Relaxed);
        }
    }

    /// Returns the next answer.
    pub fn next_answer(&self) -> Option<Message> {
        self.answers.lock().unwrap_or_else(PoisonError::into_inner).pop_front()
    }
}
