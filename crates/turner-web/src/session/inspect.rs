//! What lies under a pixel, why it has its colour, and what is doubtful in the scene.

use serde_json::{Value as Json, json};
use turner::doctor::{Options, examine};
use turner::explain::Names;
use turner::schema::Remedy;
use turner_explain::{Format, Wanted, page_style, written};
use turner_live::engine::{Frame, Stage};
use turner_live::node::Node;
use turner_live::pick::pick as picked_at;

use super::calls::Args;
use super::values::to_json;
use super::{CallError, Reply, Session};

pub(super) fn pick(session: &Session, args: &Json) -> Result<Reply, CallError> {
    let given = Args(args);
    let at = [given.number("x")?, given.number("y")?];
    let frame = session.frame()?;
    let Some(picked) = picked_at(&frame.stand, at) else {
        return Ok(Json::Object(Default::default()).into());
    };
    let desc = &frame.stand.desc;
    let names = desc.names();
    let object = picked.object.map(Node::Object);
    let material = Node::Material(picked.material.index());
    let part =
        |node: Node, label: String| node.path(&names).map(|path| json!({ "path": path, "label": label }));
    Ok(json!({
        "object": object.and_then(|node| part(node, picked.label.clone())),
        "label": picked.label,
        "material": Some(material).filter(|n| n.exists(desc)).and_then(|n| part(n, n.label(desc))),
        "point": picked.point.to_array(),
        "normal": picked.normal.to_array(),
        "distance": picked.distance,
    })
    .into())
}

/// A pixel of the film in the shown picture.
fn index(frame: &Frame, x: f64, y: f64) -> Option<usize> {
    let (picture, film) = (&frame.picture, &frame.stand.prepared.view.film);
    let place = |at: f64, film: u32, shown: u32| {
        let scaled = at * f64::from(shown) / f64::from(film.max(1));
        (scaled >= 0.0 && scaled < f64::from(shown)).then_some(scaled as usize)
    };
    let (x, y) = (place(x, film.width, picture.width)?, place(y, film.height, picture.height)?);
    Some(y * picture.width as usize + x)
}

pub(super) fn value(session: &Session, args: &Json) -> Result<Reply, CallError> {
    let given = Args(args);
    let frame = session.frame()?;
    let at = index(&frame, given.number("x")?, given.number("y")?);
    let Some(at) = at else { return Ok(Json::Object(Default::default()).into()) };
    let is_final = frame.stage == Stage::Settled;
    Ok(json!({
        "linear": frame.picture.linear.get(at),
        "display": frame.picture.display.get(at),
        "settled": is_final,
    })
    .into())
}

pub(super) fn explain(session: &Session, args: &Json) -> Result<Reply, CallError> {
    let given = Args(args);
    let whole = |key| {
        given.optional_index(key)?.ok_or_else(|| CallError::new(format!("the argument \"{key}\" is missing")))
    };
    let pixel = (whole("x")?, whole("y")?);
    let sample = given.optional_index("sample")?.map(|n| n as usize);
    let format = match given.optional_text("format")? {
        None | Some("page") => Format::Fragment,
        Some("html") => Format::Html,
        Some("text") => Format::Text { colors: false },
        Some("json") => Format::Json,
        Some("svg") => Format::Svg,
        Some(other) => {
            let message = format!("there is no format \"{other}\"; expected page, html, text, json or svg");
            return Err(CallError::new(message));
        }
    };
    let frame = session.frame()?;
    let names = Names { prepared: &frame.stand.prepared, desc: &frame.stand.desc, path_of: None };
    let wanted = Wanted { pixel, sample, all: false };
    let (text, exact) = written(&names, (session.document.name(), String::new()), &wanted, format)?;
    let style = if format == Format::Fragment { page_style() } else { String::new() };
    Ok(json!({ "text": text, "style": style, "exact": exact }).into())
}

pub(super) fn doctor(session: &Session) -> Result<Reply, CallError> {
    let frame = session.frame()?;
    let options = Options { threads: session.threads, ..Options::default() };
    let examination = examine(&frame.stand.prepared, &frame.stand.desc, &options);
    let edits = |remedy: &Remedy| match remedy {
        Remedy::Set(edits) => {
            let each = edits.iter().map(|edit| {
                let path: Vec<String> =
                    edit.path.iter().map(|part| turner::schema::path_part(&part.key)).collect();
                json!([path.join("."), to_json(&edit.value.data)])
            });
            Some(each.collect::<Vec<_>>())
        }
        _ => None,
    };
    let findings: Vec<Json> = examination
        .findings
        .iter()
        .map(|finding| {
            json!({
                "code": finding.code,
                "severity": finding.severity.word(),
                "message": finding.what,
                "why": finding.why,
                "help": finding.remedy,
                "edits": finding.remedies.iter().filter_map(edits).collect::<Vec<_>>(),
            })
        })
        .collect();
    Ok(json!({ "findings": findings }).into())
}
