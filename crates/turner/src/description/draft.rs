//! The parts of a scene that edits name, as a tree of values (step 1 of [`super::edit`]).
//!
//! The tree has the structure of a scene file but starts empty. Before an edit is applied, [`Draft::touch`] writes the
//! parts on its path that the tree lacks:
//!
//! - sections without items, such as `film` and `camera`, entirely,
//! - lists (`object`, `light`, `view`) with a placeholder for each item, which is an integer with the span [`KEPT`],
//! - of the items and named parts, only those on the path.
//!
//! So an edit of `object.7.radius` writes one object, and the list around it as integers. [`Value::set`] then sets the
//! value, by the same rules as in a tree that was read from a file.

use super::edit::drop_foreign_keys;
use super::write::{Writer, with_name, write_light, write_object};
use super::write_names::PartNames;
use crate::description::{ObjectDesc, SceneAssetWriter, SceneDesc};
use crate::schema::value::{Data, Entry, FileId, Span, Table, Value};
use crate::schema::{KeyEdit, KeyPart, SceneError, wrong_type};

/// The span of placeholders for list items that no edit changes. Their value is the item's index.
const KEPT: Span = Span { file: FileId(u32::MAX), start: u32::MAX, end: u32::MAX };

/// The index of an item that no edit changes.
pub(super) fn kept(value: &Value) -> Option<usize> {
    match value.data {
        Data::Integer(i) if value.span == KEPT => usize::try_from(i).ok(),
        _ => None,
    }
}

fn kept_items(count: usize) -> Data {
    Data::Array((0..count as i64).map(|i| Value { data: Data::Integer(i), span: KEPT }).collect())
}

/// The tree under construction.
pub(super) struct Draft<'a> {
    cx: Writer<'a>,
    root: Value,
}

impl<'a> Draft<'a> {
    /// Applies all edits in order. Returns the tree and the names that references in it use.
    ///
    /// Errors: a path that does not exist, at the part concerned.
    pub(super) fn apply(
        desc: &'a SceneDesc,
        edits: &[KeyEdit],
        assets: &'a mut dyn SceneAssetWriter,
    ) -> Result<(Value, PartNames), SceneError> {
        let root = Value::new(Data::Table(Table::default()));
        let mut draft = Draft { cx: Writer::new(desc, assets), root };
        for edit in edits {
            draft.touch(&edit.path)?;
            let mut value = edit.value.clone();
            // An item that a program replaces as a whole keeps its position in the file.
            if value.span == Span::NONE {
                value.span = draft.span_of_item(&edit.path).unwrap_or(Span::NONE);
            }
            draft.root.set(&edit.path, value)?;
        }
        edits.iter().for_each(|edit| draft.drop_keys_of_old_type(edit, edits));
        Ok((draft.root, draft.cx.names))
    }

    /// The position of the complete item that a path names, before it is replaced.
    fn span_of_item(&self, path: &[KeyPart]) -> Option<Span> {
        let keys: Vec<&str> = path.iter().map(|part| part.key.as_str()).collect();
        let desc = self.cx.desc;
        let Data::Table(root) = &self.root.data else { return None };
        let mut item = root.get(keys.first()?)?;
        for key in &keys[1..] {
            item = match &item.data {
                Data::Table(table) => table.get(key)?,
                Data::Array(items) => items.get(key.parse::<usize>().ok()?)?,
                _ => return None,
            };
        }
        match (keys.as_slice(), kept(item)) {
            (["object", _], Some(i)) => desc.objects.get(i)?.span,
            (["light", _], Some(i)) => desc.lights.get(i)?.span,
            (["view", _], Some(i)) => desc.cameras.get(i)?.span,
            (["animation", _], Some(i)) => desc.animations.get(i)?.span,
            (["group", group, "object", _], Some(i)) => {
                let group = self.cx.names.groups.iter().position(|own| own == group)?;
                desc.groups[group].value.objects.get(i)?.span
            }
            (
                ["camera"] | ["object" | "light" | "view" | "animation", _] | ["group", _, "object", _],
                None,
            ) => Some(item.span),
            _ => None,
        }
    }

    /// Writes the parts on a path that the tree lacks.
    fn touch(&mut self, path: &[KeyPart]) -> Result<(), SceneError> {
        let cx = &mut self.cx;
        let desc = cx.desc;
        let keys: Vec<&str> = path.iter().map(|part| part.key.as_str()).collect();
        let Some((&section, rest)) = keys.split_first() else { return Ok(()) };
        let root = table(&mut self.root)?;
        if root.get(section).is_none()
            && let Some(value) = write_section(section, cx)?
        {
            push(root, section, value);
        }
        let Some(value) = root.get_mut(section) else { return Ok(()) };
        match (section, rest) {
            ("view", [index, _, ..]) => touch_item(value, index, |i| {
                let camera = &desc.cameras[i];
                Ok(value_at(with_name(camera.value.write(cx)?, &camera.name), camera.span))
            }),
            ("animation", [index, _, ..]) => touch_item(value, index, |i| {
                let animation = &desc.animations[i];
                Ok(value_at(with_name(animation.value.write(cx)?, &animation.name), animation.span))
            }),
            ("light", [index, _, ..]) => touch_item(value, index, |i| {
                let light = &desc.lights[i];
                Ok(value_at(write_light(light, cx)?, light.span))
            }),
            ("object", [index, _, ..]) => touch_item(value, index, |i| object(&desc.objects[i], cx)),
            ("texture" | "material" | "medium", [name, _, ..]) => touch_named(value, section, name, cx),
            ("group", [name, rest @ ..]) if !rest.is_empty() => {
                touch_named(value, section, name, cx)?;
                let Some(i) = cx.names.groups.iter().position(|own| own == name) else { return Ok(()) };
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

    /// If an edit changes a `type`, drops the keys that only the old type has, unless edits set them.
    fn drop_keys_of_old_type(&mut self, edit: &KeyEdit, edits: &[KeyEdit]) {
        let Some((last, part)) = edit.path.split_last().filter(|(last, _)| last.key == "type") else {
            return;
        };
        let same =
            |a: &[KeyPart], b: &[KeyPart]| a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.key == b.key);
        // An edit that replaces the complete part decides itself which keys the part has.
        let replaces_part = |e: &KeyEdit| e.path.len() <= part.len() && same(&e.path, &part[..e.path.len()]);
        if edits.iter().any(replaces_part) {
            return;
        }
        let is_set = |key: &str| {
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
            drop_foreign_keys(family, table, &is_set);
        }
    }
}

/// The value as a table.
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

pub(super) fn value_at(table: Table, span: Option<Span>) -> Value {
    Value { data: Data::Table(table), span: span.unwrap_or(Span::NONE) }
}

pub(super) fn object(object: &ObjectDesc, cx: &mut Writer<'_>) -> Result<Value, SceneError> {
    Ok(value_at(write_object(object, cx)?, object.span))
}

/// Writes a section, with placeholders for its items; `None` if the scene does not have it.
fn write_section(section: &str, cx: &mut Writer<'_>) -> Result<Option<Value>, SceneError> {
    let desc = cx.desc;
    let data = match section {
        // Includes the keys whose default depends on the integrator, because an edit may change the integrator.
        "film" => Data::Table(desc.film.write_for(None, cx)?),
        "integrator" => Data::Table(desc.integrator.write(cx)?),
        "background" => Data::Table(desc.background.write(cx)?),
        "studio" => match &desc.studio {
            Some(studio) => Data::Table(studio.write(cx)?),
            None => return Ok(None),
        },
        "camera" => match &desc.camera {
            Some(camera) => {
                return Ok(Some(value_at(with_name(camera.value.write(cx)?, &camera.name), camera.span)));
            }
            None => return Ok(None),
        },
        "view" => kept_items(desc.cameras.len()),
        "light" => kept_items(desc.lights.len()),
        "animation" => kept_items(desc.animations.len()),
        "object" => kept_items(desc.objects.len()),
        "texture" | "material" | "medium" | "group" => Data::Table(Table::default()),
        _ => return Ok(None),
    };
    Ok(Some(Value::new(data)))
}

/// Writes an item of a list, unless it was written before. [`Value::set`] reports an `index` that does not exist.
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

/// Writes a named part, unless it was written before or does not exist.
fn touch_named(section: &mut Value, kind: &str, name: &str, cx: &mut Writer<'_>) -> Result<(), SceneError> {
    let section = table(section)?;
    if section.get(name).is_some() {
        return Ok(());
    }
    let desc = cx.desc;
    let number = |names: &[String]| names.iter().position(|own| own == name);
    let value = match kind {
        "texture" => match number(&cx.names.textures) {
            Some(i) => value_at(desc.textures[i].value.write(cx)?, desc.textures[i].span),
            None => return Ok(()),
        },
        "material" => match number(&cx.names.materials) {
            Some(i) => value_at(desc.materials[i].value.write(cx)?, desc.materials[i].span),
            None => return Ok(()),
        },
        "medium" => match number(&cx.names.media) {
            Some(i) => value_at(desc.media[i].value.write(cx)?, desc.media[i].span),
            None => return Ok(()),
        },
        _ => match number(&cx.names.groups) {
            Some(i) => {
                let mut group = Table::default();
                group.push("object", kept_items(desc.groups[i].value.objects.len()));
                value_at(group, desc.groups[i].span)
            }
            None => return Ok(()),
        },
    };
    push(section, name, value);
    Ok(())
}
