//! The session's thread: makes the calls that wait and renders between them.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::{Duration, Instant};

use serde_json::json;
use turner::schema::Limits;
use turner_web::{Event, Session};

use crate::call_queue::{Call, Patience};
use crate::hub::Hub;

/// A step that is shorter did nothing: the camera moves, and the picture of its last place is there.
const NOTHING: Duration = Duration::from_micros(500);

/// How long the next move is then waited for.
const REST: Duration = Duration::from_millis(4);

/// Works until the hub is closed. After a fault another session begins, in which nothing is open.
pub(crate) fn run(mut session: Session, hub: &Hub, threads: usize, limits: &Limits) {
    loop {
        hub.set_stop(session.stopper());
        let Err(panic) = catch_unwind(AssertUnwindSafe(|| work(&mut session, hub))) else { return };
        let message = message(&*panic);
        let fault = json!({ "event": "fault", "detail": { "message": message } });
        hub.fault(fault.to_string().into());
        session = Session::new(threads, limits.clone());
    }
}

fn work(session: &mut Session, hub: &Hub) {
    // An opened scene is told at once.
    let mut patience = Patience::None;
    while let Some(jobs) = hub.calls.take(patience) {
        for job in jobs {
            make(session, job);
        }
        tell(session, hub);
        let begun = Instant::now();
        let more = session.step();
        tell(session, hub);
        patience = match more {
            false => Patience::Endless,
            true if begun.elapsed() < NOTHING => Patience::At(REST),
            true => Patience::None,
        };
    }
}

fn make(session: &mut Session, job: Call) {
    let Call { name, args, files, room: _room, answer } = job;
    answer.give(session.call(&name, &args, files).map_err(|error| error.json()));
}

fn tell(session: &mut Session, hub: &Hub) {
    let text =
        |name: &str, detail| -> Arc<str> { json!({ "event": name, "detail": detail }).to_string().into() };
    for event in session.events() {
        match event {
            Event::Frame(detail, picture) => hub.picture(detail.to_string(), &picture),
            Event::Status(detail) => hub.status(text("status", detail)),
            Event::Document(detail) => hub.document(text("document", detail)),
        }
    }
}

/// The message of a panic.
fn message(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("unknown").to_owned()
}
