//! The parts of the scene and their keys, from the schema.

use serde_json::{Value as Json, json};
use turner::SceneDesc;
use turner::description::{ModelDesc, ObjectContent};
use turner::schema::value::{Data, Table, Value};
use turner::schema::{EntryDoc, Field, KeyEdit};
use turner_live::node::{GROUP, MOTION, Node, OBJECT_KEYS};

use super::calls::Args;
use super::values::{of_json, to_json};
use super::{CallError, Reply, Session};

/// The most entries of a list that are sent; `count` has the number of all.
const MOST: usize = 2_000;

/// The lines of a documentation as one text.
pub(super) fn paragraph(lines: &[&str]) -> String {
    lines.iter().map(|line| line.trim()).collect::<Vec<_>>().join(" ")
}

pub(super) fn outline(session: &Session) -> Result<Reply, CallError> {
    let desc = session.document.desc();
    let names = desc.names();
    let entry = |node: Node| {
        let kind = match node {
            Node::Object(i) => match &desc.objects[i].content {
                ObjectContent::Shape(shape) => shape.type_name(),
                ObjectContent::Instance(_) if desc.model_of(i).is_some() => "model",
                ObjectContent::Instance(_) => "instance",
            },
            Node::Light(i) => desc.lights[i].value.type_name(),
            Node::Material(i) => desc.materials[i].value.type_name(),
            Node::Texture(i) => desc.textures[i].value.type_name(),
            Node::Medium(i) => desc.media[i].value.type_name(),
            Node::Integrator => desc.integrator.type_name(),
            Node::Camera | Node::View(_) | Node::Film | Node::Background | Node::Studio => "",
        };
        let path = node.path(&names)?;
        let family = node.family().map_or("", |family| family.one);
        Some(json!({ "path": path, "label": node.label(desc), "family": family, "type": kind }))
    };
    type List = (&'static str, usize, fn(usize) -> Node);
    let settings = [Node::Camera, Node::Film, Node::Integrator, Node::Background, Node::Studio];
    let first: Vec<Json> = settings.into_iter().filter(|node| node.exists(desc)).filter_map(entry).collect();
    let mut lists = vec![json!({ "title": "Settings", "entries": first, "count": first.len() })];
    let all: [List; 6] = [
        ("Objects", desc.objects.len(), Node::Object),
        ("Lights", desc.lights.len(), Node::Light),
        ("Materials", desc.materials.len(), Node::Material),
        ("Textures", desc.textures.len(), Node::Texture),
        ("Media", desc.media.len(), Node::Medium),
        ("Views", desc.cameras.len(), Node::View),
    ];
    for (title, count, node) in all.into_iter().filter(|(_, count, _)| *count > 0) {
        let entries: Vec<Json> = (0..count.min(MOST)).filter_map(|i| entry(node(i))).collect();
        lists.push(json!({ "title": title, "entries": entries, "count": count }));
    }
    Ok(json!({ "lists": lists }).into())
}

/// The keys of a part, in the order of the form.
fn fields(node: Node, desc: &SceneDesc, kind: &str) -> Vec<&'static Field> {
    let entry: Option<&'static EntryDoc> = match node {
        Node::Object(i) if desc.model_of(i).is_some() => Some(&ModelDesc::DOC),
        _ => match node.family() {
            Some(family) => family.entries.iter().find(|entry| entry.name == kind).copied(),
            None => node.entry(),
        },
    };
    let mut out: Vec<&'static Field> = Vec::new();
    if let Node::Object(i) = node {
        out.extend(OBJECT_KEYS);
        if matches!(desc.objects[i].content, ObjectContent::Instance(_)) && desc.model_of(i).is_none() {
            out.push(&GROUP);
        }
    }
    out.extend(entry.into_iter().flat_map(|entry| entry.fields));
    if matches!(node, Node::Object(_)) {
        out.push(&MOTION);
    }
    out
}

pub(super) fn part(session: &Session, args: &Json) -> Result<Reply, CallError> {
    let path = Args(args).text("path")?;
    let desc = session.document.desc();
    let names = desc.names();
    let Some(node) = Node::of_path(path, &names).filter(|node| node.exists(desc)) else {
        return Err(CallError::new(format!("the scene has no part \"{path}\"")));
    };
    let table = match desc.value_at(path)? {
        Some(Value { data: Data::Table(table), .. }) => table,
        _ => Table::default(),
    };
    let own = match table.get("type").map(|value| &value.data) {
        Some(Data::String(name)) => name.clone(),
        _ => node.family().and_then(|f| f.entries.first()).map_or_else(String::new, |e| e.name.to_owned()),
    };
    let is_model = matches!(node, Node::Object(i) if desc.model_of(i).is_some());
    let is_instance =
        matches!(node, Node::Object(i) if matches!(desc.objects[i].content, ObjectContent::Instance(_)));
    let types = node.family().filter(|_| !is_instance).map(|family| {
        let each = family.entries.iter().map(|e| json!({ "name": e.name, "doc": paragraph(e.doc) }));
        each.collect::<Vec<_>>()
    });
    let doc = node.family().and_then(|f| f.entries.iter().find(|e| e.name == own)).map(|e| e.doc);
    let doc = doc.or_else(|| node.entry().map(|entry| entry.doc));
    let keys: Vec<Json> = fields(node, desc, &own).into_iter().map(|field| key(field, &table)).collect();
    Ok(json!({
        "path": path,
        "label": node.label(desc),
        "family": node.family().map(|family| family.one),
        "type": if is_model { "model".to_owned() } else { own },
        "types": types,
        "doc": doc.map(paragraph),
        "keys": keys,
        "names": { "materials": names.materials, "textures": names.textures, "media": names.media, "groups": names.groups },
    })
    .into())
}

/// A key with its value.
pub(super) fn key(field: &Field, table: &Table) -> Json {
    let value = table.get(field.name).map(|value| to_json(&value.data));
    json!({
        "name": field.name,
        "kind": (field.kind)(),
        "set": value.is_some(),
        "value": value,
        "default": field.default.map(|show| show()),
        "range": field.range.map(|range| range.to_string()),
        "bounds": field.range.map(|range| bounds(&range)),
        "words": (field.words)(),
        "doc": paragraph(field.doc),
    })
}

/// The ends of a range; null for an open one.
fn bounds(range: &turner::schema::Range) -> [Option<f64>; 2] {
    [range.min, range.max].map(|end| (end.abs() < f64::MAX).then_some(end))
}

pub(super) fn set(session: &mut Session, args: &Json) -> Result<Reply, CallError> {
    let given = Args(args);
    let label = given.optional_text("label")?.unwrap_or("Edit");
    let merge = given.optional_text("merge")?;
    let (mut edits, mut models) = (Vec::new(), Vec::new());
    for edit in given.list("edits")? {
        let pair = edit.as_array().map(Vec::as_slice);
        let Some([Json::String(path), value]) = pair else {
            return Err(CallError::new("an edit is a list of a key path and a value"));
        };
        let data = if value.is_null() { None } else { Some(of_json(value)?) };
        if let Some((object, key)) = key_of_model(session.document.desc(), path) {
            models.push((object, key, data));
            continue;
        }
        edits.push(match data {
            Some(data) => KeyEdit::new(path, data),
            None => without(session.document.desc(), path)?,
        });
    }
    for (object, key, data) in models {
        session.document.set_model_key(object, &key, data)?;
    }
    session.document.apply(label, merge, &edits)?;
    session.order();
    Ok(Json::Object(Default::default()).into())
}

/// The object and the key of a path that names a key of a model.
fn key_of_model(desc: &SceneDesc, path: &str) -> Option<(usize, String)> {
    let (object, key) = path.strip_prefix("object.")?.split_once('.')?;
    let object = object.parse().ok()?;
    let is_own = ModelDesc::DOC.fields.iter().any(|field| field.name == key);
    (is_own && desc.model_of(object).is_some()).then(|| (object, key.to_owned()))
}

/// The edit that takes a key away: its part without it.
fn without(desc: &SceneDesc, path: &str) -> Result<KeyEdit, CallError> {
    let mut parts = turner::schema::KeyPart::split(path);
    let (key, part) = match parts.pop() {
        Some(key) if !parts.is_empty() => (key.key, parts),
        _ => return Err(CallError::new(format!("\"{path}\" is no key of a part"))),
    };
    let part: Vec<String> = part.iter().map(|part| turner::schema::path_part(&part.key)).collect();
    let part = part.join(".");
    let mut table = match desc.value_at(&part)? {
        Some(Value { data: Data::Table(table), .. }) => table,
        _ => Table::default(),
    };
    table.entries.retain(|entry| entry.key != key);
    Ok(KeyEdit::new(&part, Data::Table(table)))
}
