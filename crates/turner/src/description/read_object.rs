//! Reads objects of scene files.

use super::read::{Reader, noted};
use super::read_parts::{light_group, read_kind};
use crate::description::{ModelDesc, *};
use crate::material::{InterfaceMaterial, MaterialDesc};
use crate::schema::error::unknown_name;
use crate::schema::value::{Data, Value};
use crate::schema::{ErrorCode, GroupId, MaterialId, Named, ReadContext, SceneError, TableReader, Transform};
use crate::shape::ShapeDesc;

/// Reads an object: a shape, an instance of a group, or a model.
pub(super) fn read_object(value: &Value, cx: &mut Reader<'_>) -> Result<ObjectDesc, SceneError> {
    let mut table = TableReader::of(value, "an object")?;
    let name = table.optional::<String>("name", None, cx)?;
    let light_group = light_group(&mut table, "light_group", cx)?;
    let shadow_catcher = table.optional::<bool>("shadow_catcher", None, cx)?.unwrap_or(false);
    let hidden_from_camera = table.optional::<bool>("hidden_from_camera", None, cx)?.unwrap_or(false);
    let hidden = table.optional::<bool>("hidden", None, cx)?.unwrap_or(false);
    let mut transform = table.optional::<Transform>("transform", None, cx)?.unwrap_or(Transform::IDENTITY);
    let mut motion = table.optional::<Transform>("motion", None, cx)?;
    let material = match table.take("material") {
        Some(value) => {
            let material = cx.material(value);
            noted(cx, material)?
        }
        None => None,
    };
    let material = match table.take("medium") {
        Some(value) if table.has("material") => {
            let message = "an object has a `material` or a `medium`, not both";
            cx.fault(SceneError::at(ErrorCode::Conflict, value.span, message).help(
                "for glass, write `interior = …` in the material; an object with `medium` has no visible surface",
            ))?;
            material
        }
        Some(value) => {
            let medium = cx.medium(value);
            let interior = noted(cx, medium)?;
            let interface = MaterialDesc::Interface(InterfaceMaterial { interior });
            cx.materials.push(Some(Named { name: None, span: Some(value.span), value: interface }));
            Some(MaterialId(cx.materials.len() as u32 - 1))
        }
        None => material,
    };
    let is = |table: &mut TableReader<'_>, kind| matches!(table.take("type").map(|v| &v.data), Some(Data::String(s)) if s == kind);
    let content = if is(&mut table, ModelDesc::DOC.name) {
        table.rename("a model");
        let before = cx.faults();
        let model = cx.read_model(&mut table, (material, hidden), &mut transform, &mut motion);
        let model = (cx as &mut dyn ReadContext).noted_after(before, model)?;
        table.finish(cx)?;
        ObjectContent::Instance(model.unwrap_or(GroupId(0)))
    } else if is(&mut table, "instance") {
        table.rename("an instance");
        let before = cx.faults();
        let group: String = table.required("group", None, cx, String::new)?;
        let id = cx.group_ids.get(&group).copied().ok_or_else(|| {
            let names = cx.names(&cx.group_ids);
            unknown_name(ErrorCode::UnknownName, table.span_of("group"), "group", &group, &names)
        });
        let id = (cx as &mut dyn ReadContext).noted_after(before, id)?;
        table.finish(cx)?;
        ObjectContent::Instance(id.unwrap_or(GroupId(0)))
    } else {
        ObjectContent::Shape(read_kind(&mut table, "shape", None, cx, &ShapeDesc::DOC, ShapeDesc::read)?)
    };
    Ok(ObjectDesc {
        name,
        span: Some(value.span),
        content,
        material,
        light_group,
        shadow_catcher,
        hidden_from_camera,
        hidden,
        transform,
        motion,
    })
}
