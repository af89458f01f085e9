//! The keys of a model file that is placed in the scene. A change reads the file again.

use egui::{Grid, Ui};
use turner::description::ModelDesc;

use crate::studio::Studio;
use crate::widgets::field::{self, Around, Change};

pub(crate) fn show(ui: &mut Ui, studio: &mut Studio, object: usize, around: &Around<'_>) {
    let keys = studio.document.desc().model_keys(object);
    let Some(Some(table)) = studio.check(keys) else { return };
    ui.strong("Model");
    let mut changes = Vec::new();
    Grid::new("model").num_columns(2).spacing([10.0, 4.0]).striped(true).show(ui, |ui| {
        for field in ModelDesc::DOC.fields {
            let value = table.get(field.name).map(|value| &value.data);
            let change = match (field.kind)() == "\"text\"" {
                true => field::written(ui, field, value),
                false => field::row(ui, field, value, around),
            };
            changes.extend(change.map(|change| (field.name, change)));
        }
    });
    for (key, change) in changes {
        let value = match change {
            Change::Set(data) => Some(data),
            Change::Unset => None,
            Change::File(_) | Change::Follow(..) => continue,
        };
        let result = studio.document.set_model_key(object, key, value);
        studio.check(result);
    }
}
