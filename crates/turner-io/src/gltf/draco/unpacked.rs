//! The Draco mesh of a primitive in place of its accessors' bytes. Type and normalisation remain those of the
//! accessors.

use std::collections::BTreeMap;

use super::values::{Data, Kind};
use super::{Attribute, Mesh, decode};
use crate::gltf::accessors::{Component, Elements};
use crate::gltf::budget::Budget;
use crate::gltf::buffers::Buffers;
use crate::gltf::fault::{Fault, Outcome};
use crate::gltf::json::{Document, Primitive};
use crate::gltf::report::Report;

/// Modes of primitives that a Draco mesh may have.
const TRIANGLES: u32 = 4;
const TRIANGLE_STRIP: u32 = 5;

/// The decoded mesh of a primitive.
#[derive(Debug)]
pub(in crate::gltf) struct Unpacked {
    /// Its triangles, also if the primitive is a strip.
    pub(in crate::gltf) faces: Vec<[u32; 3]>,
    /// The elements of its attributes by their names, without padding.
    attributes: BTreeMap<String, Vec<u8>>,
}

impl Unpacked {
    /// Decodes the Draco mesh of a primitive. `None` if it has none. `pointer` is the primitive's JSON pointer.
    ///
    /// The mesh has the last word on the numbers of points and triangles: old exporters wrote those of the mesh before
    /// it was compressed.
    pub(in crate::gltf) fn read(
        document: &Document,
        buffers: &Buffers,
        primitive: &Primitive,
        (budget, report): (&Budget, &mut Report),
        pointer: &str,
    ) -> Outcome<Option<Unpacked>> {
        let Some(json) = primitive.extensions.as_deref().and_then(|e| e.draco.as_ref()) else {
            return Ok(None);
        };
        let mode = primitive.mode.map_or(TRIANGLES, |m| m.0);
        if mode != TRIANGLES && mode != TRIANGLE_STRIP {
            let message = format!("is {mode}; expected 4 or 5 for a Draco mesh");
            return Err(Fault::at(format!("{pointer}/mode"), message));
        }
        let at = format!("{pointer}/extensions/KHR_draco_mesh_compression");
        let mesh = decode(buffers.view(json.buffer_view, &at)?.0, budget, &at)?;
        // The indices of a strip are counted as those of the strip.
        let mut disagrees = match primitive.indices {
            Some(at) => {
                let indices = Elements::describe(document, at, pointer)?;
                mode == TRIANGLES && indices.count != 3 * mesh.faces.len()
            }
            None => false,
        };
        let mut attributes = BTreeMap::new();
        for (name, id) in &json.attributes {
            // Turner reads no attributes of applications.
            let Some(accessor) = primitive.attributes.get(name).filter(|_| !name.starts_with('_')) else {
                continue;
            };
            let Some(attribute) = mesh.attributes.iter().find(|a| a.id == id.0) else {
                let message = format!("refers to Draco attribute {}, which its mesh lacks", id.0);
                return Err(Fault::at(format!("{at}/attributes/{name}"), message));
            };
            let elements = Elements::describe(document, *accessor, pointer)?;
            elements.with_width(&[attribute.width], "its Draco attribute")?;
            disagrees |= elements.count != mesh.points;
            attributes.insert(name.clone(), pack(attribute, &mesh, &elements, budget)?);
        }
        if disagrees {
            report.doubtful("a Draco mesh with another number of vertices or indices than its accessors say");
        }
        Ok(Some(Unpacked { faces: mesh.faces, attributes }))
    }

    /// The elements of an attribute; `None` if it is not part of the Draco mesh.
    pub(in crate::gltf) fn attribute(&self, name: &str) -> Option<&[u8]> {
        self.attributes.get(name).map(Vec::as_slice)
    }
}

/// The values of all points in the component type of the accessor.
fn pack(attribute: &Attribute, mesh: &Mesh, elements: &Elements<'_>, budget: &Budget) -> Outcome<Vec<u8>> {
    let at = format!("/accessors/{}", elements.accessor.0);
    let (component, width) = (elements.component, attribute.width);
    let mut bytes = budget.list(mesh.points.saturating_mul(width * component.size()), &at)?;
    for point in 0..mesh.points {
        for i in attribute.values(point) {
            let packed = match component {
                Component::F32 => float(&attribute.data, attribute.normalized, i).map(f32::to_le_bytes),
                _ => attribute
                    .data
                    .integer(i)
                    .filter(|v| component.holds(*v))
                    .map(|v| (v as u32).to_le_bytes()),
            };
            let Some(packed) = packed else {
                let held = match (&attribute.data, attribute.data.integer(i)) {
                    (Data::Integers(..), Some(value)) => format!("{value} at point {point}"),
                    (Data::Floats(_), _) => "floats".to_owned(),
                    _ => "numbers of a type that glTF lacks".to_owned(),
                };
                let message = format!("has component type {component:?}, but its Draco attribute has {held}");
                return Err(Fault::at(at, message));
            };
            bytes.extend_from_slice(&packed[..component.size()]);
        }
    }
    Ok(bytes)
}

/// Value `i` as a float. Normalised integers become −1 to 1.
fn float(data: &Data, normalized: bool, i: usize) -> Option<f32> {
    let value = match data {
        Data::Floats(_) => return data.float(i),
        _ => data.integer(i)? as f64,
    };
    let most = match data {
        Data::Integers(kind, _) if normalized => kind.most(),
        _ => return Some(value as f32),
    };
    Some((value / most).max(-1.0) as f32)
}

impl Kind {
    /// The largest integer.
    fn most(self) -> f64 {
        match self {
            Kind::I8 => f64::from(i8::MAX),
            Kind::U8 => f64::from(u8::MAX),
            Kind::I16 => f64::from(i16::MAX),
            Kind::U16 => f64::from(u16::MAX),
            Kind::I32 => f64::from(i32::MAX),
            Kind::U32 | Kind::F32 | Kind::Wide => f64::from(u32::MAX),
        }
    }
}

#[cfg(test)]
mod tests;
