//! What waits to be sent to one viewer. Slow viewers get the newest of everything: a message of a kind replaces the one
//! that was not sent. Answers are not replaced; their number is limited by the calls that may wait.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use serde_json::{Value as Json, json};
use tokio::sync::{Notify, OwnedSemaphorePermit};
use turner_web::Reply;

use crate::tiles::Shown;

/// Bytes per second below which pictures are packed: sending less then gains more time than packing takes.
const SLOW: f64 = 25e6;

/// Smallest message that measures a connection, bytes.
const MEASURED: usize = 32 << 10;

/// What is sent next.
pub(crate) enum Outgoing {
    Text(Arc<str>),
    /// An answer with bytes: the answer without them, and the bytes.
    Bytes(String, Vec<u8>),
    Picture(Arc<Shown>),
    /// The connection ends: code and reason.
    Close(u16, &'static str),
}

/// See the module.
#[derive(Default)]
pub(crate) struct Outbox {
    state: Mutex<State>,
    pub(crate) came: Notify,
}

#[derive(Default)]
struct State {
    answers: VecDeque<(Outgoing, Option<OwnedSemaphorePermit>)>,
    fault: Option<Arc<str>>,
    document: Option<Arc<str>>,
    status: Option<Arc<str>>,
    picture: Option<Arc<Shown>>,
    close: Option<(u16, &'static str)>,
    /// The picture that the viewer has not acknowledged: its number, its bytes, and when it was sent.
    unseen: Option<(u32, usize, Instant)>,
    /// Bytes per second, once known.
    speed: Option<f64>,
}

impl Outbox {
    fn change(&self, change: impl FnOnce(&mut State)) {
        change(&mut self.lock());
        self.came.notify_one();
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn fault(&self, text: &Arc<str>) {
        self.change(|state| state.fault = Some(Arc::clone(text)));
    }

    pub(crate) fn document(&self, text: &Arc<str>) {
        self.change(|state| state.document = Some(Arc::clone(text)));
    }

    pub(crate) fn status(&self, text: &Arc<str>) {
        self.change(|state| state.status = Some(Arc::clone(text)));
    }

    pub(crate) fn picture(&self, shown: &Arc<Shown>) {
        self.change(|state| state.picture = Some(Arc::clone(shown)));
    }

    /// A message that is sent after what waits now.
    pub(crate) fn text(&self, text: Arc<str>) {
        self.change(|state| state.answers.push_back((Outgoing::Text(text), None)));
    }

    /// Ends the connection.
    pub(crate) fn close(&self, code: u16, reason: &'static str) {
        self.change(|state| state.close = Some((code, reason)));
    }

    /// Takes what is sent next. The permit ends once the answer is sent.
    pub(crate) fn take(&self) -> Option<(Outgoing, Option<OwnedSemaphorePermit>)> {
        let mut state = self.lock();
        if let Some((code, reason)) = state.close {
            return Some((Outgoing::Close(code, reason), None));
        }
        if let Some(answer) = state.answers.pop_front() {
            return Some(answer);
        }
        let State { fault, document, status, .. } = &mut *state;
        if let Some(text) = fault.take().or_else(|| document.take()).or_else(|| status.take()) {
            return Some((Outgoing::Text(text), None));
        }
        if state.unseen.is_some() {
            return None;
        }
        state.picture.take().map(|shown| (Outgoing::Picture(shown), None))
    }

    /// Notes that a picture is about to be sent.
    pub(crate) fn sending(&self, number: u32, bytes: usize) {
        self.lock().unseen = Some((number, bytes, Instant::now()));
    }

    /// The viewer has a picture.
    pub(crate) fn seen(&self, number: u32) {
        self.change(|state| {
            let Some((_, bytes, since)) = state.unseen.take_if(|(sent, _, _)| *sent == number) else {
                return;
            };
            if bytes >= MEASURED {
                let now = bytes as f64 / since.elapsed().as_secs_f64().max(1e-6);
                state.speed = Some(state.speed.map_or(now, |last| 0.7 * last + 0.3 * now));
            }
        });
    }

    /// Whether pictures are packed for this viewer.
    pub(crate) fn is_slow(&self) -> bool {
        self.lock().speed.is_some_and(|speed| speed < SLOW)
    }
}

/// The answer to a call, which is given even if the call is never made.
pub(crate) struct Answer {
    id: u64,
    outbox: Arc<Outbox>,
    permit: Option<OwnedSemaphorePermit>,
    is_given: bool,
}

impl Answer {
    pub(crate) fn new(id: u64, outbox: Arc<Outbox>, permit: Option<OwnedSemaphorePermit>) -> Answer {
        Answer { id, outbox, permit, is_given: false }
    }

    pub(crate) fn give(mut self, result: Result<Reply, Json>) {
        self.send(result);
    }

    fn send(&mut self, result: Result<Reply, Json>) {
        self.is_given = true;
        let outgoing = match result {
            Ok(Reply { json, bytes }) if bytes.is_empty() => {
                Outgoing::Text(json!({ "id": self.id, "ok": json }).to_string().into())
            }
            Ok(Reply { json, bytes }) => {
                Outgoing::Bytes(json!({ "id": self.id, "ok": json }).to_string(), bytes)
            }
            Err(error) => Outgoing::Text(json!({ "id": self.id, "error": error }).to_string().into()),
        };
        let permit = self.permit.take();
        self.outbox.change(|state| state.answers.push_back((outgoing, permit)));
    }
}

impl Drop for Answer {
    fn drop(&mut self) {
        if !self.is_given {
            self.send(Err(json!({ "message": "the renderer stopped" })));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(number: u32) -> Arc<Shown> {
        let pixels = vec![[0; 4]];
        Arc::new(Shown { number, width: 1, height: 1, detail: String::new(), pixels, has_alpha: false })
    }

    fn kind(outbox: &Outbox) -> Option<String> {
        outbox.take().map(|(outgoing, _)| match outgoing {
            Outgoing::Text(text) => text.to_string(),
            Outgoing::Picture(shown) => shown.number.to_string(),
            Outgoing::Bytes(..) | Outgoing::Close(..) => "other".to_owned(),
        })
    }

    #[test]
    fn a_slow_viewer_gets_the_newest() {
        let outbox = Outbox::default();
        for number in 1..4 {
            outbox.status(&format!("status {number}").into());
            outbox.picture(&shown(number));
        }
        assert_eq!(kind(&outbox).as_deref(), Some("status 3"));
        assert_eq!(kind(&outbox).as_deref(), Some("3"));
        outbox.sending(3, MEASURED);
        outbox.picture(&shown(4));
        outbox.picture(&shown(5));
        assert_eq!(kind(&outbox), None, "the last one was not acknowledged");
        outbox.seen(2);
        assert_eq!(kind(&outbox), None, "another one was acknowledged");
        outbox.seen(3);
        assert_eq!(kind(&outbox).as_deref(), Some("5"));
        assert!(outbox.lock().speed.is_some());
    }

    #[test]
    fn a_call_that_is_not_made_has_an_answer() {
        let outbox = Arc::new(Outbox::default());
        drop(Answer::new(7, Arc::clone(&outbox), None));
        assert!(kind(&outbox).unwrap().contains("\"id\":7"));
    }
}
