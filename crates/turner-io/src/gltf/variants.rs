//! Material variants (`KHR_materials_variants`).

use super::fault::{Fault, Outcome};
use super::json::{Document, Index, Primitive};
use super::nodes::choose;

/// The variant with this name or index.
pub(super) fn chosen(document: &Document, wanted: Option<&str>) -> Outcome<Option<Index>> {
    let Some(wanted) = wanted else { return Ok(None) };
    let variants = document.extensions.variants.as_ref().map_or(&[][..], |v| &v.variants);
    let names: Vec<_> = variants.iter().map(|v| Some(v.name.as_str())).collect();
    choose(wanted, &names, "variant").map(Some)
}

/// The material of a primitive in a variant; its default material if the variant does not mention it.
pub(super) fn material(
    document: &Document,
    primitive: &Primitive,
    variant: Option<Index>,
    pointer: &str,
) -> Outcome<Option<Index>> {
    let mapped = variant.and_then(|variant| {
        let mappings = &primitive.extensions.as_deref()?.variants.as_ref()?.mappings;
        mappings.iter().find(|m| m.variants.contains(&variant)).map(|m| m.material)
    });
    match mapped.or(primitive.material) {
        Some(material) if material.index() >= document.materials.len() => {
            Err(Fault::dangling(pointer, "material", material.0, document.materials.len()))
        }
        material => Ok(material),
    }
}
