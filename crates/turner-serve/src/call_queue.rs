//! Calls that wait for the session. Those of the owner come first; those of viewers one between two steps, so that many
//! viewers do not stop the picture.

use std::collections::VecDeque;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use serde_json::Value as Json;
use turner_web::Files;

use crate::hub::Reservation;
use crate::outbox::Answer;

/// A call.
pub(crate) struct Call {
    pub(crate) name: String,
    pub(crate) args: Json,
    pub(crate) files: Files,
    /// The room that the files take.
    pub(crate) room: Option<Reservation>,
    pub(crate) answer: Answer,
}

/// See the module.
#[derive(Default)]
pub(crate) struct CallQueue {
    waiting: Mutex<Waiting>,
    came: Condvar,
}

#[derive(Default)]
struct Waiting {
    owner: VecDeque<Call>,
    viewers: VecDeque<Call>,
    is_closed: bool,
}

impl Waiting {
    fn is_empty(&self) -> bool {
        self.owner.is_empty() && self.viewers.is_empty()
    }
}

/// How long the session waits for a call.
#[derive(Clone, Copy)]
pub(crate) enum Patience {
    None,
    At(Duration),
    Endless,
}

impl CallQueue {
    fn lock(&self) -> MutexGuard<'_, Waiting> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Leaves a call. After the end it is dropped, which answers it.
    pub(crate) fn put(&self, job: Call, is_owner: bool) {
        let mut waiting = self.lock();
        if waiting.is_closed {
            // The answer is given without the lock.
            drop(waiting);
            return;
        }
        if is_owner {
            waiting.owner.push_back(job)
        } else {
            waiting.viewers.push_back(job)
        }
        self.came.notify_one();
    }

    /// The calls to make now; `None` after the end.
    pub(crate) fn take(&self, patience: Patience) -> Option<Vec<Call>> {
        let mut waiting = self.lock();
        let idle = |waiting: &mut Waiting| waiting.is_empty() && !waiting.is_closed;
        match patience {
            Patience::None => {}
            Patience::At(time) => {
                let held = self.came.wait_timeout_while(waiting, time, idle);
                waiting = held.unwrap_or_else(PoisonError::into_inner).0;
            }
            Patience::Endless => {
                waiting = self.came.wait_while(waiting, idle).unwrap_or_else(PoisonError::into_inner);
            }
        }
        if waiting.is_closed {
            return None;
        }
        let mut jobs: Vec<Call> = waiting.owner.drain(..).collect();
        jobs.extend(waiting.viewers.pop_front());
        Some(jobs)
    }

    pub(crate) fn close(&self) {
        let mut waiting = self.lock();
        waiting.is_closed = true;
        let jobs = (std::mem::take(&mut waiting.owner), std::mem::take(&mut waiting.viewers));
        self.came.notify_all();
        drop(waiting);
        drop(jobs);
    }
}
