//! The parts of a scene that edits name, as a tree of values: each is written when the first edit comes to it.

use super::edit::drop_foreign_keys;
use super::write::{Writer, with_name, write_light, write_object};
use crate::description::{ObjectDesc, SceneAssetWriter, SceneDesc};
use crate::schema::value::{Data, Entry, FileId, Span, Table, Value};
use crate::schema::{KeyEdit, KeyPart, SceneError, wrong_type};

/// Where items of lists stand that no edit came to: their value is their number.
const KEPT: Span = Span { file: FileId(u32::MAX), start: u32::MAX, end: u32::MAX };

/// The number of an item that no edit came to.
pub(super) fn kept(value: &Value) -> Option<usize> {
    match value.data {
        Data::Integer(i) if value.span == KEPT => usize::try_from(i).ok(),
        _ => None,
    }
}

fn kept_items(count: usize) -> Data {
    Data::Array((0..count as i64).map(|i| Value { data: Data::Integer(i), span: KEPT }).collect())
}

/// The names of things, as paths and references have them.
#[derive(Default)]
pub(super) struct Names {
    pub(super) textures: Vec<String>,
    pub(super) materials: Vec<String>,
    pub(super) media: Vec<String>,
    pub(super) groups: Vec<String>,
}

/// What edits make of the parts that they name.
pub(super) struct Draft<'a> {
    cx: Writer<'a>,
    root: Value,
}

impl<'a> Draft<'a> {
    /// Applies all edits in order. The tree holds the sections that were touched: whole tables, lists whose other items are
    /// [`kept`], named things that were touched.
    pub(super) fn apply(
        desc: &'a SceneDesc,
        edits: &[KeyEdit],
        assets: &'a mut dyn SceneAssetWriter,
    ) -> Result<(Value, Names), SceneError> {
        let root = Value::new(Data::Table(Table::default()));
        let mut draft = Draft { cx: Writer::new(desc, assets), root };
        for edit in edits {
            draft.touch(&edit.path)?;
            draft.root.set(&edit.path, edit.value.clone())?;
        }
        edits.iter().for_each(|edit| draft.forget(edit, edits));
        let Writer { textures, materials, media, groups, .. } = draft.cx;
        Ok((draft.root, Names { textures, materials, media, groups }))
    }

    /// Writes what a path leads through and is not in the tree.
    fn touch(&mut self, path: &[KeyPart]) -> Result<(), SceneError> {
        let cx = &mut self.cx;
        let desc = cx.desc;
        let keys: Vec<&str> = path.iter().map(|part| part.key.as_str()).collect();
        let Some((&section, rest)) = keys.split_first() else { return Ok(()) };
        let root = table(&mut self.root)?;
        if root.get(section).is_none()
            && let Some(value) = whole_section(section, cx)?
        {
            push(root, section, value);
        }
        let Some(value) = root.get_mut(section) else { return Ok(()) };
        match (section, rest) {
            ("view", [index, _, ..]) => touch_item(value, index, |i| {
                let camera = &desc.cameras[i];
                Ok(placed(with_name(camera.value.write(cx)?, &camera.name), camera.span))
            }),
            ("light", [index, _, ..]) => touch_item(value, index, |i| {
                let light = &desc.lights[i];
                Ok(placed(write_light(light, cx)?, light.span))
            }),
            ("object", [index, _, ..]) => touch_item(value, index, |i| object(&desc.objects[i], cx)),
            ("texture" | "material" | "medium", [name, _, ..]) => touch_named(value, section, name, cx),
            ("group", [name, rest @ ..]) if !rest.is_empty() => {
                touch_named(value, section, name, cx)?;
                let Some(i) = cx.groups.iter().position(|own| own == name) else { return Ok(()) };
                let group = table(value)?.get_mut(name).map(table).transpose()?;
                let objects = group.and_then(|group| group.get_mut("object"));
                match (objects, rest) {
                    (Some(objects), ["object", index, _, ..]) => {
                        touch_item(objects, index, |k| object(&desc.groups[i].value.objects[k], cx))
                    }
                    _ => Ok(()),
                }
            }
            _ => Ok(()),
        }
    }

    /// Where an edit changes the type of a thing, the thing forgets what was said of the old type alone, but for what edits say.
    fn forget(&mut self, edit: &KeyEdit, edits: &[KeyEdit]) {
        let Some((last, part)) = edit.path.split_last().filter(|(last, _)| last.key == "type") else {
            return;
        };
        let same =
            |a: &[KeyPart], b: &[KeyPart]| a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.key == b.key);
        // Who says the whole says what is in it.
        let said_whole = |e: &KeyEdit| e.path.len() <= part.len() && same(&e.path, &part[..e.path.len()]);
        if edits.iter().any(said_whole) {
            return;
        }
        let said = |key: &str| {
            let is = |e: &KeyEdit| {
                e.path.len() > part.len()
                    && same(&e.path[..part.len()], part)
                    && e.path[part.len()].key == key
            };
            key == last.key || edits.iter().any(is)
        };
        let mut at = &mut self.root;
        for step in part {
            let next = match &mut at.data {
                Data::Table(table) => table.get_mut(&step.key),
                Data::Array(items) => step.key.parse::<usize>().ok().and_then(|i| items.get_mut(i)),
                _ => None,
            };
            let Some(next) = next else { return };
            at = next;
        }
        let family = match part {
            [group, .., _] if group.key == "group" => "object",
            [section, ..] => section.key.as_str(),
            [] => return,
        };
        if let Data::Table(table) = &mut at.data {
            drop_foreign_keys(family, table, &said);
        }
    }
}

/// The table that a value is.
fn table(value: &mut Value) -> Result<&mut Table, SceneError> {
    let wrong = wrong_type(value, "a table { key = value, … }");
    match &mut value.data {
        Data::Table(table) => Ok(table),
        _ => Err(wrong),
    }
}

fn push(table: &mut Table, key: &str, value: Value) {
    table.entries.push(Entry { key: key.to_owned(), key_span: Span::NONE, value });
}

fn placed(table: Table, span: Option<Span>) -> Value {
    Value { data: Data::Table(table), span: span.unwrap_or(Span::NONE) }
}

fn object(object: &ObjectDesc, cx: &mut Writer<'_>) -> Result<Value, SceneError> {
    Ok(placed(write_object(object, cx)?, object.span))
}

/// A section as it is before any of its things are written; `None` where there is nothing.
fn whole_section(section: &str, cx: &mut Writer<'_>) -> Result<Option<Value>, SceneError> {
    let desc = cx.desc;
    let data = match section {
        // With the keys whose default depends on the integrator: an edit may change it.
        "film" => Data::Table(desc.film.write_for(None, cx)?),
        "integrator" => Data::Table(desc.integrator.write(cx)?),
        "background" => Data::Table(desc.background.write(cx)?),
        "studio" => match &desc.studio {
            Some(studio) => Data::Table(studio.write(cx)?),
            None => return Ok(None),
        },
        "camera" => match &desc.camera {
            Some(camera) => {
                return Ok(Some(placed(with_name(camera.value.write(cx)?, &camera.name), camera.span)));
            }
            None => return Ok(None),
        },
        "view" => kept_items(desc.cameras.len()),
        "light" => kept_items(desc.lights.len()),
        "object" => kept_items(desc.objects.len()),
        "texture" | "material" | "medium" | "group" => Data::Table(Table::default()),
        _ => return Ok(None),
    };
    Ok(Some(Value::new(data)))
}

/// Writes an item of a list, unless it was written before. What is no number of an item is for [`Value::set`] to refuse.
fn touch_item(
    list: &mut Value,
    index: &str,
    write: impl FnOnce(usize) -> Result<Value, SceneError>,
) -> Result<(), SceneError> {
    let Data::Array(items) = &mut list.data else { return Ok(()) };
    let item = index.parse::<usize>().ok().and_then(|i| items.get_mut(i));
    if let Some(item) = item
        && let Some(own) = kept(item)
    {
        *item = write(own)?;
    }
    Ok(())
}

/// Writes a named thing, unless it was written before or there is none of that name.
fn touch_named(section: &mut Value, kind: &str, name: &str, cx: &mut Writer<'_>) -> Result<(), SceneError> {
    let section = table(section)?;
    if section.get(name).is_some() {
        return Ok(());
    }
    let desc = cx.desc;
    let number = |names: &[String]| names.iter().position(|own| own == name);
    let value = match kind {
        "texture" => match number(&cx.textures) {
            Some(i) => placed(desc.textures[i].value.write(cx)?, desc.textures[i].span),
            None => return Ok(()),
        },
        "material" => match number(&cx.materials) {
            Some(i) => placed(desc.materials[i].value.write(cx)?, desc.materials[i].span),
            None => return Ok(()),
        },
        "medium" => match number(&cx.media) {
            Some(i) => placed(desc.media[i].value.write(cx)?, desc.media[i].span),
            None => return Ok(()),
        },
        _ => match number(&cx.groups) {
            Some(i) => {
                let mut group = Table::default();
                group.push("object", kept_items(desc.groups[i].value.objects.len()));
                placed(group, desc.groups[i].span)
            }
            None => return Ok(()),
        },
    };
    push(section, name, value);
    Ok(())
}
