//! What the page is told without asking.

use std::sync::Arc;

use serde_json::{Value as Json, json};
use turner::Picture;
use turner::color::ColorScale;
use turner::film::Denoise;
use turner_live::engine::{Frame, Stage};

use super::Session;

/// Something new.
#[derive(Clone, Debug)]
pub enum Event {
    /// A picture: what it is, and its display values as RGBA.
    Frame(Json, Arc<Picture>),
    /// What the engine does.
    Status(Json),
    /// The scene, its history and its text.
    Document(Json),
}

/// What the page was told last.
#[derive(Default)]
pub(crate) struct Sent {
    frame: Option<Arc<Frame>>,
    status: Json,
    /// The revision of the document, and whether it moved.
    document: Option<(u64, bool)>,
}

impl Sent {
    /// Everything is new.
    pub(crate) fn forget(&mut self) {
        *self = Sent::default();
    }
}

/// Bytes of files up to which the text is a part of the event. The text of a scene with larger files takes longer than a
/// page may wait: see the call `text`.
const QUICK: usize = 4 << 20;

/// See [`Session::events`].
pub(super) fn new(session: &mut Session) -> Vec<Event> {
    let mut out = Vec::new();
    if !session.is_open {
        return out;
    }
    let revision = session.document.revision();
    let sent = session.sent.document;
    // While the camera moves, only its end is told.
    if !session.moving && sent.is_none_or(|(last, moved)| last != revision || moved) {
        session.sent.document = Some((revision, false));
        out.push(Event::Document(document(session)));
    } else if session.moving
        && let Some((_, moved)) = &mut session.sent.document
    {
        *moved = true;
    }
    let status = session.stepper.status();
    if let Some(frame) = session.stepper.frame()
        && !session.sent.frame.as_ref().is_some_and(|last| Arc::ptr_eq(last, &frame))
    {
        out.push(Event::Frame(of_frame(session, &frame), Arc::clone(&frame.picture)));
        session.sent.frame = Some(frame);
    }
    let error = status
        .error
        .as_ref()
        .map(|e| json!({ "message": e.message, "help": e.help, "is_fault": e.is_fault }));
    let status = json!({
        "doing": status.doing,
        "samples": status.samples.0,
        "total": status.samples.1,
        "seconds": (status.seconds * 10.0).round() / 10.0,
        "left": status.left.map(|left| (left * 10.0).round() / 10.0),
        "settled": status.settled,
        "paused": session.paused,
        "error": error,
    });
    if status != session.sent.status {
        session.sent.status = status.clone();
        out.push(Event::Status(status));
    }
    out
}

fn of_frame(session: &Session, frame: &Frame) -> Json {
    let status = session.stepper.status();
    let (stage, denoised) = match frame.stage {
        Stage::Preview => ("preview", false),
        Stage::Film { denoised, .. } => ("film", denoised),
        Stage::Settled => ("settled", frame.stand.desc.film.denoise != Denoise::Off),
    };
    json!({
        "width": frame.picture.width,
        "height": frame.picture.height,
        "stage": stage,
        "samples": status.samples.0,
        "total": status.samples.1,
        "seconds": status.seconds,
        "left": status.left,
        "noise": frame.noise,
        "denoised": denoised,
        "scale": frame.scale.as_ref().map(scale),
        "after_ms": frame.after_ms,
    })
}

/// A colour scale with its colours, from low to high.
fn scale(scale: &ColorScale) -> Json {
    let css = |i: u8| {
        let byte = |v: f32| (v.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
        let [r, g, b] = turner::color::heat(f32::from(i) / 16.0).to_array().map(byte);
        format!("#{r:02x}{g:02x}{b:02x}")
    };
    let ends = [scale.marks.first(), scale.marks.last()].map(|mark| mark.map(|&(_, value)| value));
    json!({
        "low": ends[0],
        "high": ends[1],
        "unit": scale.unit,
        "marks": scale.marks,
        "colors": (0..=16).map(css).collect::<Vec<_>>(),
    })
}

fn document(session: &Session) -> Json {
    let document = &session.document;
    let desc = document.desc();
    let (undo, redo) = document.steps();
    let warnings: Vec<Json> = document
        .warnings()
        .iter()
        .take(500)
        .map(|warning| {
            let at = warning.span.and_then(|span| document.sources().locate(span));
            json!({
                "kind": warning.kind.word(),
                "message": warning.message,
                "file": at.as_ref().map(|at| at.file),
                "line": at.as_ref().map(|at| at.line),
            })
        })
        .collect();
    let is_quick = document.bytes_in_memory().is_some_and(|bytes| bytes <= QUICK);
    json!({
        "revision": document.revision(),
        "name": document.name(),
        "changed": document.is_changed(),
        "text": if is_quick { document.text().ok() } else { None },
        "text_is_asked": !is_quick,
        "text_name": document.text_name(),
        "film": { "width": desc.film.width, "height": desc.film.height, "samples": desc.film.samples },
        "integrator": desc.integrator.type_name(),
        "undo": undo.last(),
        "redo": redo.first(),
        "warnings": warnings,
        "objects": desc.objects.len(),
        "triangles": desc.meshes.iter().map(|mesh| mesh.data.triangles.len()).sum::<usize>(),
    })
}
