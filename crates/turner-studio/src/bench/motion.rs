//! From input to picture: camera moves, edits, opening a model.

use std::time::{Duration, Instant};

use turner::schema::value::{Data, Value};
use turner_live::camera;
use turner_live::document::{Document, Opening};
use turner_live::engine::Frame;

use super::scenes::{self, Scene};
use super::session::Session;
use super::table::{Row, Table};

/// Camera moves.
const MOVES: u32 = 60;
/// Repetitions of an edit, and of a first move.
const EDITS: u32 = 12;
/// Time of a fluent movement.
const FLUENT: Duration = Duration::from_secs(3);

/// Milliseconds from an input to its picture.
const INPUT: f64 = 80.0;
/// Milliseconds from an edit to its picture.
const EDIT: f64 = 100.0;
/// Milliseconds from the choice of a model of a million triangles to its picture.
const OPEN: f64 = 2000.0;

/// The time between frames while moving: with global illumination 12 frames/s at 1280 x 720 and 25 at 640 x 360; for
/// classic ray tracing 30 at 1280 x 720.
fn fluent(physical: bool, size: [u32; 2]) -> Option<f64> {
    match (physical, size) {
        (true, [1280, 720]) => Some(1e3 / 12.0),
        (true, [640, 360]) => Some(1e3 / 25.0),
        (false, [1280, 720]) => Some(1e3 / 30.0),
        _ => None,
    }
}

/// Turns the camera about what it looks at.
pub(super) fn orbit(document: &mut Document, shown: Option<&Frame>, by: f64) -> Result<(), String> {
    let own = document.desc().camera.clone();
    let of_frame = || shown.map(|frame| frame.stand.prepared.view.camera_desc.clone().into());
    let mut camera = own.or_else(of_frame).ok_or("the scene has no camera")?;
    camera::orbit(&mut camera.value, by, 0.2 * by);
    let moved = document.edit("Camera", Some("camera"), |desc| {
        desc.camera = Some(camera);
        Ok(())
    });
    moved.map_err(|e| e.message)
}

/// The part of the window's pixels that a frame has, as a note.
fn detail(frames: &[f64]) -> String {
    let mean = frames.iter().sum::<f64>() / frames.len().max(1) as f64;
    format!("frames have {:.0} % of the width", 100.0 * mean)
}

/// Measures a scene at a size.
pub(super) fn measure(scene: &Scene, size: [u32; 2], table: &mut Table) -> Result<(), String> {
    let mut session = Session::new(scene.open(size)?, size);
    let physical = session.document.desc().integrator.capabilities().physical;
    let begun = Instant::now();
    session.first(session.order(false), begun)?;
    let mut add = |what: &str, values: Vec<f64>, target: Option<f64>, note: String| {
        table.add(&Row { scene: &scene.name, size: Some(size), what, unit: "ms", values, target, note });
    };
    let (values, widths) = moves(&mut session, size)?;
    add("input to picture", values, Some(INPUT), detail(&widths));
    add("first input while the film renders", first_moves(&mut session)?, Some(INPUT), String::new());
    let (values, widths) = fluently(&mut session, size)?;
    let rate = 1e3 * values.len() as f64 / values.iter().sum::<f64>().max(1e-9);
    let note = format!("{rate:.1} frames/s, {}", detail(&widths));
    add("between frames while moving", values, fluent(physical, size), note);
    for (what, edit) in EDITABLE {
        match edits(&mut session, *edit)? {
            Some(values) => add(what, values, Some(EDIT), String::new()),
            None => eprintln!("{}: nothing to measure for \"{what}\"", scene.name),
        }
    }
    if scene.has_many()
        && let Some(values) = edits(&mut session, move_object)?
    {
        add("one object of 10,000 moved", values, Some(EDIT), String::new());
    }
    Ok(())
}

/// Moves one after another, each when the picture of the last one is there. Also the widths of the frames.
fn moves(session: &mut Session, size: [u32; 2]) -> Result<(Vec<f64>, Vec<f64>), String> {
    let (mut values, mut widths) = (Vec::new(), Vec::new());
    for i in 0..MOVES {
        let shown = session.shown();
        let started = Instant::now();
        orbit(&mut session.document, shown.as_deref(), if i % 20 < 10 { 0.02 } else { -0.02 })?;
        let (ms, frame) = session.first(session.order(true), started)?;
        values.push(ms);
        widths.push(f64::from(frame.picture.width) / f64::from(size[0]));
    }
    Ok((values, widths))
}

/// Moves that interrupt the film.
fn first_moves(session: &mut Session) -> Result<Vec<f64>, String> {
    let mut values = Vec::new();
    for _ in 0..EDITS {
        session.order(false);
        session.rest(Duration::from_millis(1100));
        let shown = session.shown();
        let started = Instant::now();
        orbit(&mut session.document, shown.as_deref(), 0.02)?;
        values.push(session.first(session.order(true), started)?.0);
    }
    Ok(values)
}

/// Milliseconds between frames while each frame is followed by the next order at once. The first frames, in which the
/// engine finds its pace, are left out.
fn fluently(session: &mut Session, size: [u32; 2]) -> Result<(Vec<f64>, Vec<f64>), String> {
    let (mut values, mut widths) = (Vec::new(), Vec::new());
    let start = Instant::now();
    let mut last = Instant::now();
    let mut count = 0;
    while start.elapsed() < FLUENT {
        let shown = session.shown();
        orbit(&mut session.document, shown.as_deref(), 0.01)?;
        let (_, frame) = session.first(session.order(true), last)?;
        count += 1;
        if count > 5 {
            values.push(last.elapsed().as_secs_f64() * 1e3);
            widths.push(f64::from(frame.picture.width) / f64::from(size[0]));
        }
        last = Instant::now();
    }
    Ok((values, widths))
}

/// An edit; its number makes it another one than the last. Returns whether the scene has such a value.
type Edit = fn(&mut Document, u32) -> bool;

const EDITABLE: &[(&str, Edit)] = &[
    ("material edit to picture", material),
    ("light edit to picture", light),
    ("environment edit to picture", environment),
];

/// The times of an edit; `None` if the scene has no such value.
fn edits(session: &mut Session, edit: Edit) -> Result<Option<Vec<f64>>, String> {
    let mut values = Vec::new();
    for i in 0..EDITS {
        session.order(false);
        session.rest(Duration::from_millis(700));
        let started = Instant::now();
        if !edit(&mut session.document, i) {
            return Ok(None);
        }
        values.push(session.first(session.order(true), started)?.0);
    }
    Ok(Some(values))
}

fn color(i: u32) -> Data {
    let v = 0.2 + 0.03 * f64::from(i);
    Data::Array([v, 0.5, 0.4].into_iter().map(|v| Value::new(Data::Number(v))).collect())
}

/// Sets the first of these keys that takes the value.
fn set_one(document: &mut Document, paths: impl Iterator<Item = String>, value: &Data) -> bool {
    for path in paths {
        if document.set("Edit", None, &[(path, value.clone())]).is_ok() {
            return true;
        }
    }
    false
}

fn material(document: &mut Document, i: u32) -> bool {
    let names = document.desc().names().materials;
    let paths = names
        .iter()
        .take(20)
        .flat_map(|name| ["color", "base_color"].map(|key| format!("material.{name}.{key}")));
    set_one(document, paths.collect::<Vec<_>>().into_iter(), &color(i))
}

fn light(document: &mut Document, i: u32) -> bool {
    let count = document.desc().lights.len();
    let keys = ["intensity", "power", "sun_strength", "strength"];
    let paths = (0..count).rev().flat_map(|light| keys.map(|key| format!("light.{light}.{key}")));
    set_one(document, paths, &Data::Number(0.5 + 0.05 * f64::from(i)))
}

/// The environment light or the sky; a background where there is none.
fn environment(document: &mut Document, i: u32) -> bool {
    let count = document.desc().lights.len();
    let paths =
        (0..count).flat_map(|light| ["rotation", "azimuth"].map(|key| format!("light.{light}.{key}")));
    set_one(document, paths, &Data::Number(10.0 * f64::from(i + 1)))
        || set_one(document, ["background.color".to_owned()].into_iter(), &color(i))
}

fn move_object(document: &mut Document, i: u32) -> bool {
    let moved = document.edit("Move", None, |desc| {
        let middle = desc.objects.len() / 2;
        desc.objects[middle].transform.0.translation.y = 0.1 + 0.01 * f64::from(i);
        Ok(())
    });
    moved.is_ok()
}

/// Time from the choice of a model of a million triangles to its first picture.
pub(super) fn opening(table: &mut Table) -> Result<(), String> {
    let folder = tempfile::tempdir().map_err(|e| e.to_string())?;
    let path = folder.path().join("million.ply");
    scenes::write_million(&path).map_err(|e| e.to_string())?;
    let size = [1280, 720];
    let mut values = Vec::new();
    for _ in 0..3 {
        let started = Instant::now();
        let (send, woken) = std::sync::mpsc::channel();
        let opening = Opening::start(path.clone(), move || {
            let _ = send.send(());
        });
        let _ = woken.recv();
        let document = opening.poll().ok_or("the model was not read")?.map_err(|e| e.message)?;
        let session = Session::new(document, size);
        values.push(session.first(session.order(false), started)?.0);
    }
    let what = "open to first picture";
    let row = Row {
        scene: "1 M triangles",
        size: Some(size),
        what,
        unit: "ms",
        values,
        target: Some(OPEN),
        note: String::new(),
    };
    table.add(&row);
    Ok(())
}
