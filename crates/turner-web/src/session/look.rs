//! What is shown of the scene, and camera moves.

use serde_json::{Value as Json, json};
use turner::camera::CameraDesc;
use turner::integrator::IntegratorDesc;
use turner::math::DVec3;
use turner_live::engine::Display;
use turner_live::{camera, pick};

use super::calls::Args;
use super::{CallError, Reply, Session};

/// Most pixels of a side of a canvas.
const MAX_SIZE: u32 = 1 << 14;

fn done() -> Reply {
    Json::Object(Default::default()).into()
}

pub(super) fn view(session: &mut Session, args: &Json) -> Result<Reply, CallError> {
    let given = Args(args);
    let side = |key| Ok::<_, CallError>(given.optional_index(key)?.map(|n| n.clamp(1, MAX_SIZE)));
    let size = [side("width")?.unwrap_or(session.size[0]), side("height")?.unwrap_or(session.size[1])];
    let paused = given.flag("paused")?.unwrap_or(session.paused);
    let mut look = session.look.clone();
    // Null is the scene's own integrator; a missing key changes nothing.
    match args.get("integrator") {
        None => {}
        Some(Json::Null) => look.integrator = None,
        Some(_) => {
            let name = given.text("integrator")?;
            look.integrator = Some(IntegratorDesc::of_type(name).ok_or_else(|| {
                let names: Vec<&str> = IntegratorDesc::DOC.entries.iter().map(|e| e.name).collect();
                let help = turner::schema::error::suggestion(name, &names);
                CallError { help, ..CallError::new(format!("there is no integrator \"{name}\"")) }
            })?);
        }
    }
    look.display = match given.optional_text("display")? {
        None => look.display,
        Some("picture") => Display::Picture,
        Some("false-color") => Display::FalseColor,
        Some("noise") => Display::Noise,
        Some(other) => {
            let message = format!("there is no display \"{other}\"; expected picture, false-color or noise");
            return Err(CallError::new(message));
        }
    };
    (session.size, session.paused, session.look) = (size, paused, look);
    session.order();
    Ok(done())
}

/// The integrators, for a menu.
pub(super) fn integrators() -> Reply {
    let items: Vec<Json> = IntegratorDesc::DOC
        .entries
        .iter()
        .map(|entry| json!({ "name": entry.name, "doc": super::parts::paragraph(entry.doc) }))
        .collect();
    json!({ "items": items }).into()
}

/// Changes the camera. Moves that follow one another are one step of the history.
fn moved(session: &mut Session, label: &str, change: impl FnOnce(&mut CameraDesc)) -> Result<(), CallError> {
    let own = session.document.desc().camera.clone();
    let shown = || session.stepper.frame().map(|frame| frame.stand.prepared.view.camera_desc.clone().into());
    let Some(mut camera) = own.or_else(shown) else { return Err(CallError::new("there is no camera yet")) };
    change(&mut camera.value);
    // A move that ends in no camera, such as one onto its own look-at point, is left out.
    if camera.value.prepare(1.0).is_err() {
        return Ok(());
    }
    session.document.edit(label, Some("camera"), |desc| {
        desc.camera = Some(camera);
        Ok(())
    })?;
    session.order();
    Ok(())
}

pub(super) fn gesture(session: &mut Session, args: &Json) -> Result<Reply, CallError> {
    let given = Args(args);
    let axis = |key| Ok::<_, CallError>(given.optional_number(key)?.unwrap_or(0.0));
    let (x, y, z) = (axis("x")?, axis("y")?, axis("z")?);
    if ![x, y, z].iter().all(|v| v.is_finite()) {
        return Err(CallError::new("the numbers of a gesture must be finite"));
    }
    let aspect = session.document.desc().film.aspect();
    session.moving = true;
    match given.text("kind")? {
        "orbit" => moved(session, "Orbit", |c| camera::orbit(c, -x, -y)),
        "look" => moved(session, "Look around", |c| camera::look(c, x, y)),
        "pan" => moved(session, "Pan", |c| camera::pan(c, x, y, aspect)),
        "dolly" => moved(session, "Dolly", |c| camera::dolly(c, x)),
        "fly" => moved(session, "Fly", |c| camera::fly(c, DVec3::new(x, y, z) * camera::distance(c))),
        other => Err(CallError::new(format!(
            "there is no gesture \"{other}\"; expected orbit, look, pan, dolly or fly"
        ))),
    }?;
    Ok(done())
}

pub(super) fn gesture_end(session: &mut Session) -> Result<Reply, CallError> {
    session.document.end_gesture();
    session.moving = false;
    session.order();
    Ok(done())
}

pub(super) fn frame(session: &mut Session, args: &Json) -> Result<Reply, CallError> {
    let object = Args(args).optional_index("object")?;
    let stand = session.frame()?.stand.clone();
    let own = object.and_then(|object| pick::object_bounds(&stand, object as usize));
    let Some(bounds) = own.or_else(|| pick::scene_bounds(&stand)) else {
        return Err(CallError::new("the scene has nothing to frame: all of it is unbounded"));
    };
    let aspect = stand.desc.film.aspect();
    session.document.end_gesture();
    moved(session, "Frame", |c| camera::frame(c, &bounds, aspect))?;
    gesture_end(session)
}

pub(super) fn focus(session: &mut Session, args: &Json) -> Result<Reply, CallError> {
    let given = Args(args);
    let at = [given.number("x")?, given.number("y")?];
    let stand = session.frame()?.stand.clone();
    let Some(picked) = pick::pick(&stand, at) else {
        return Err(CallError::new("there is nothing to focus on: the ray leaves the scene"));
    };
    session.document.end_gesture();
    moved(session, "Focus", |c| camera::focus(c, picked.point))?;
    gesture_end(session)
}
