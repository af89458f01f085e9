//! Readers of the parts of a scene file, each from its table.

use crate::camera::CameraDesc;
use crate::color::named;
use crate::description::default_studio::StudioDesc;
use crate::description::{ModelDesc, SceneLight};
use crate::film::FilmDesc;
use crate::integrator::{ClassicDesc, IntegratorDesc};
use crate::light::{BackgroundDesc, LightDesc};
use crate::material::MaterialDesc;
use crate::medium::MediumDesc;
use crate::schema::value::{Data, Span, Value};
use crate::schema::{
    self, ErrorCode, Named, ReadContext, SceneError, TableReader, Transform, old_names, wrong_type,
};
use crate::shape::ShapeDesc;
use crate::texture::TextureDesc;

/// Reads `[film]`. Missing keys get the film's defaults for the integrator.
pub(super) fn read_film(
    value: &Value,
    integrator: &str,
    cx: &mut dyn ReadContext,
) -> Result<FilmDesc, SceneError> {
    FilmDesc::read_for(integrator, value, cx)
}

/// The integrator of a scene file without `type` in `[integrator]`.
const DEFAULT_INTEGRATOR: &str = ClassicDesc::DOC.name;

/// The `type` of `[integrator]`. It is checked later, when the section is read.
pub(super) fn integrator_type(section: &Value) -> &str {
    let Data::Table(table) = &section.data else { return DEFAULT_INTEGRATOR };
    match table.get("type").map(|value| &value.data) {
        Some(Data::String(name)) => name,
        _ => DEFAULT_INTEGRATOR,
    }
}

pub(super) fn read_background(value: &Value, cx: &mut dyn ReadContext) -> Result<BackgroundDesc, SceneError> {
    read_table(value, "[background]", cx, BackgroundDesc::read)
}

pub(super) fn read_studio(value: &Value, cx: &mut dyn ReadContext) -> Result<StudioDesc, SceneError> {
    read_table(value, "[studio]", cx, StudioDesc::read)
}

pub(super) fn read_integrator(value: &Value, cx: &mut dyn ReadContext) -> Result<IntegratorDesc, SceneError> {
    let mut table = TableReader::of(value, "[integrator]")?;
    let doc = &IntegratorDesc::DOC;
    read_kind(&mut table, "integrator", Some(DEFAULT_INTEGRATOR), cx, doc, IntegratorDesc::read)
}

/// Reads a light with its name and light group.
pub(super) fn read_light(value: &Value, cx: &mut dyn ReadContext) -> Result<SceneLight, SceneError> {
    let mut table = TableReader::of(value, "a light")?;
    let name = table.optional::<String>("name", None, cx)?;
    let key = if table.has("light_group") { "light_group" } else { "group" };
    if table.has("group") && key == "group" {
        old_names::note("group", "light_group", table.span_of("group"), cx);
    }
    // Both keys count as known, whichever the table has.
    let group = light_group(&mut table, key, cx)?;
    table.take("light_group");
    let hidden = table.optional::<bool>("hidden", None, cx)?.unwrap_or(false);
    let motion = table.optional::<Transform>("motion", None, cx)?;
    let light = read_kind(&mut table, LightDesc::DOC.one, None, cx, &LightDesc::DOC, LightDesc::read)?;
    Ok(SceneLight { name, group, span: Some(value.span), hidden, motion, value: light })
}

/// Checks that the name of a texture is not the name of a colour.
pub(super) fn check_texture_name(name: &str, span: Span) -> Result<(), SceneError> {
    if named(name).is_none() {
        return Ok(());
    }
    let message = format!("\"{name}\" is the name of a colour and cannot name a texture");
    Err(SceneError::at(ErrorCode::Conflict, span, message).help("choose another name"))
}

/// Reads a camera with its name.
pub(super) fn read_camera(
    value: &Value,
    what: &str,
    cx: &mut dyn ReadContext,
) -> Result<Named<CameraDesc>, SceneError> {
    let mut table = TableReader::of(value, what)?;
    let name = table.optional::<String>("name", None, cx)?;
    let camera = read_kind(&mut table, "camera", Some("pinhole"), cx, &CameraDesc::DOC, CameraDesc::read)?;
    Ok(Named { name, span: Some(value.span), value: camera })
}

/// Reads a table without `type` and reports unknown keys.
fn read_table<T>(
    value: &Value,
    what: &str,
    cx: &mut dyn ReadContext,
    read: impl Fn(&mut TableReader<'_>, &mut dyn ReadContext) -> Result<T, SceneError>,
) -> Result<T, SceneError> {
    let mut table = TableReader::of(value, what)?;
    let read = read(&mut table, cx)?;
    table.finish(cx)?;
    Ok(read)
}

/// Reads the `type` of a table and the keys of that type, and reports unknown keys; see [`schema::read_kind`].
pub(super) fn read_kind<T: Default>(
    table: &mut TableReader<'_>,
    kind: &str,
    default: Option<&str>,
    cx: &mut dyn ReadContext,
    doc: &schema::FamilyDoc,
    read: impl Fn(&str, &mut TableReader<'_>, &mut dyn ReadContext) -> Result<Option<T>, SceneError>,
) -> Result<T, SceneError> {
    let others: &[&str] = if kind == ShapeDesc::DOC.one { &["instance", ModelDesc::DOC.name] } else { &[] };
    schema::read_kind(table, (kind, others), default, cx, doc, read)
}

pub(super) fn read_texture(value: &Value, cx: &mut dyn ReadContext) -> Result<TextureDesc, SceneError> {
    let mut table = TableReader::of(value, "a texture")?;
    read_kind(&mut table, "texture", None, cx, &TextureDesc::DOC, TextureDesc::read)
}

pub(super) fn read_material(value: &Value, cx: &mut dyn ReadContext) -> Result<MaterialDesc, SceneError> {
    let mut table = TableReader::of(value, "a material")?;
    let doc = &MaterialDesc::DOC;
    read_kind(&mut table, "material", Some("classic"), cx, doc, MaterialDesc::read)
}

pub(super) fn read_medium(value: &Value, cx: &mut dyn ReadContext) -> Result<MediumDesc, SceneError> {
    let mut table = TableReader::of(value, "a medium")?;
    read_kind(&mut table, "medium", Some("homogeneous"), cx, &MediumDesc::DOC, MediumDesc::read)
}

/// The tables `[kind.NAME]` as (name, position of the name, value).
pub(super) fn named_tables<'a>(
    section: Option<&'a Value>,
    kind: &str,
) -> Result<Vec<(&'a str, Span, &'a Value)>, SceneError> {
    let Some(section) = section else { return Ok(Vec::new()) };
    let Data::Table(table) = &section.data else {
        return Err(wrong_type(section, &format!("named tables [{kind}.NAME]"))
            .help(format!("give it a name, e.g. `[{kind}.red]`, and refer to it by that name")));
    };
    Ok(table.entries.iter().map(|e| (e.key.as_str(), e.key_span, &e.value)).collect())
}

pub(super) fn array_of_tables<'a>(section: Option<&'a Value>, kind: &str) -> Result<&'a [Value], SceneError> {
    let Some(section) = section else { return Ok(&[]) };
    match &section.data {
        Data::Array(items) => Ok(items),
        _ => Err(wrong_type(section, &format!("tables headed [[{kind}]]"))
            .help(format!("write [[{kind}]] with two brackets: there may be several"))),
    }
}

/// Reads the name of a light group, which must not be empty.
pub(super) fn light_group(
    table: &mut TableReader<'_>,
    key: &'static str,
    cx: &mut dyn ReadContext,
) -> Result<Option<String>, SceneError> {
    let group = table.optional::<String>(key, None, cx)?;
    if group.as_ref().is_some_and(|g| g.trim().is_empty()) {
        let message = format!("`{key}` must be the name of a light group, found \"\"");
        cx.fault(
            SceneError::at(ErrorCode::OutOfRange, table.span_of(key), message)
                .help("give it a name, e.g. \"key light\", or omit the key"),
        )?;
    }
    Ok(group)
}
