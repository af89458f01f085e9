//! The keys of a model that is placed in a scene: its file, its animation, the materials in its slots.
//!
//! A placed model is an instance of the group that was read from its file. A change of its keys reads the file again and
//! puts the new group in the place of the old one.

use super::borrowed_assets::BorrowedAssets;
use super::write::{Writer, write_object};
use crate::description::*;
use crate::schema::value::{Data, Span, Table, Value};
use crate::schema::{KeyEdit, SceneError, Transform};

impl SceneDesc {
    /// The model that an entry of the list of objects places.
    pub fn model_of(&self, object: usize) -> Option<&ModelDesc> {
        match self.objects.get(object)?.content {
            ObjectContent::Instance(group) => self.groups.get(group.index())?.value.model.as_deref(),
            ObjectContent::Shape(_) => None,
        }
    }

    /// Its keys, as a scene file would have them. Keys at their default are absent.
    ///
    /// Errors: an ID that the description does not have.
    pub fn model_keys(&self, object: usize) -> Result<Option<Table>, SceneError> {
        let mut lent = BorrowedAssets::of(self);
        let mut cx = Writer::new(self, &mut lent);
        self.model_of(object).map(|model| model.write(&mut cx)).transpose()
    }

    /// Sets a key of a model and reads the model again; `None` sets it to its default. Name, material and place of the object
    /// stay. Nothing happens to an object that is no model.
    ///
    /// Errors: those of reading the model. The description then stays the same.
    pub fn set_model_key(
        &mut self,
        object: usize,
        key: &str,
        value: Option<Data>,
        assets: &mut dyn SceneAssets,
    ) -> Result<(), SceneError> {
        let (Some(mut keys), Some(model)) = (self.model_keys(object)?, self.model_of(object)) else {
            return Ok(());
        };
        let up = model.up.rotation().inverse();
        let mut own = self.objects[object].clone();
        // The rotation of the file's axes is part of the transform once it is read.
        own.transform = Transform(own.transform.0 * up);
        own.motion = own.motion.map(|motion| Transform(motion.0 * up));
        let mut table = {
            let mut lent = BorrowedAssets::of(self);
            write_object(&own, &mut Writer::new(self, &mut lent))?
        };
        table.entries.retain(|entry| entry.key != "type" && entry.key != "group");
        keys.entries.retain(|entry| entry.key != key);
        if let Some(value) = value {
            keys.set(key, Span::NONE, Value::new(value));
        }
        table.push("type", Data::String(ModelDesc::DOC.name.to_owned()));
        table.entries.append(&mut keys.entries);
        let mut next = self.clone();
        // The new object takes the place of the old one, which goes with everything that only it used.
        let last = next.objects.len();
        let path = next.add_object(ObjectDesc { span: own.span, ..ObjectDesc::default() });
        next.edit(&[KeyEdit::new(&path, Data::Table(table))], assets)?;
        next.objects.swap(object, last);
        next.objects[object].span = own.span;
        next.remove(&[&path])?;
        *self = next;
        Ok(())
    }
}
