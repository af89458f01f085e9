//! Tables of materials by name.

use crate::schema::value::{Data, Span, Table, Value};
use crate::schema::{MaterialId, ParamType, ReadContext, Renumber, SceneError, WriteContext, wrong_type};

/// Materials that replace a model's own materials of the same names.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialsByName(pub Vec<(String, Span, MaterialId)>);

impl ParamType for MaterialsByName {
    fn kind() -> String {
        "{ NAME = material, … }".into()
    }
    fn read(value: &Value, cx: &mut dyn ReadContext) -> Result<MaterialsByName, SceneError> {
        let Data::Table(table) = &value.data else { return Err(wrong_type(value, &Self::kind())) };
        let mut list = Vec::with_capacity(table.entries.len());
        for entry in &table.entries {
            let material = cx.material(&entry.value);
            list.extend(cx.noted(material)?.map(|id| (entry.key.clone(), entry.key_span, id)));
        }
        Ok(MaterialsByName(list))
    }
    fn show(&self) -> String {
        "materials".into()
    }
    fn write(&self, cx: &mut dyn WriteContext) -> Result<Option<Data>, SceneError> {
        let mut table = Table::default();
        for (name, _, material) in &self.0 {
            table.push(name, cx.material(*material)?);
        }
        Ok(Some(Data::Table(table)))
    }
    fn renumber(&mut self, by: &Renumber) {
        self.0.iter_mut().for_each(|(_, _, material)| *material = by.material(*material));
    }
}
