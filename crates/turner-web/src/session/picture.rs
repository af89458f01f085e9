//! A picture in steps, beside the document: `picture_begin`, `picture_step` until it is done, `picture_take` and
//! `picture_aovs`, `picture_end`.

use std::time::Duration;

use serde_json::{Value as Json, json};

use super::calls::{Args, Files};
use super::{CallError, Reply, Session};
use crate::layers;
use crate::picture::{PictureJob, encoded, request};

/// Longest time of a step, seconds.
const MAX_STEP: f64 = 10.0;

fn job(session: &mut Session) -> Result<&mut PictureJob, CallError> {
    session.job.as_mut().ok_or_else(|| CallError {
        help: Some("call picture_begin first".to_owned()),
        ..CallError::new("no picture is being rendered")
    })
}

/// Reads and prepares the scene `main` among the files.
pub(super) fn begin(session: &mut Session, args: &Json, files: Files) -> Result<Reply, CallError> {
    // The memory of the last picture is free for this one.
    session.job = None;
    let wanted = request(session.limits.clone(), session.threads, args, &files)?;
    let job = session.job.insert(PictureJob::begin(files, &wanted)?);
    let [width, height] = job.size();
    let samples = job.renderer.samples_per_pixel();
    Ok(json!({ "width": width, "height": height, "samples": samples, "warnings": job.warnings }).into())
}

/// Renders for about `seconds`.
pub(super) fn step(session: &mut Session, args: &Json) -> Result<Reply, CallError> {
    let seconds = Args(args).optional_number("seconds")?.unwrap_or(0.05);
    // Not `clamp`, which keeps NaN.
    let time = Duration::try_from_secs_f64(seconds.min(MAX_STEP)).unwrap_or_default();
    let Session { job: Some(job), stepper, .. } = session else {
        return self::job(session).map(|_| Reply::default());
    };
    let done = job.step(time, stepper.stop())?;
    Ok(json!({ "done": done, "progress": job.progress() }).into())
}

/// The picture so far in a `format`.
pub(super) fn take(session: &mut Session, args: &Json) -> Result<Reply, CallError> {
    let format = Args(args).optional_text("format")?.unwrap_or("rgba");
    let job = job(session)?;
    let picture = job.picture();
    let bytes = encoded(&picture, format, job.threads)?;
    Ok(Reply {
        json: json!({ "width": picture.width, "height": picture.height, "non_finite": picture.missing }),
        bytes,
    })
}

/// Its AOVs.
pub(super) fn aovs(session: &mut Session) -> Result<Reply, CallError> {
    job(session).map(|job| layers::reply(job))
}

/// Frees its memory.
pub(super) fn end(session: &mut Session) -> Reply {
    session.job = None;
    Json::Object(Default::default()).into()
}
