//! `EXT_mesh_gpu_instancing`: many instances of a node's mesh.

use super::accessors::Elements;
use super::buffers::Buffers;
use super::fault::{Fault, Outcome};
use super::json::{Document, Instancing};
use super::nodes::from_parts;
use turner::math::{DAffine3, DVec3};

/// The transforms of a node's instances, in the node's space.
pub(super) struct Instances<'a> {
    /// Number of instances.
    pub(super) count: usize,
    translation: Option<Elements<'a>>,
    rotation: Option<Elements<'a>>,
    scale: Option<Elements<'a>>,
}

impl<'a> Instances<'a> {
    /// Opens the accessors of a node.
    pub(super) fn open(
        document: &Document,
        buffers: &'a Buffers,
        instancing: &Instancing,
        pointer: &str,
    ) -> Outcome<Instances<'a>> {
        let open = |name: &str, width: usize| match instancing.attributes.get(name) {
            Some(at) => Elements::open(document, buffers, *at, pointer)?.with_width(&[width], name).map(Some),
            None => Ok(None),
        };
        let (translation, rotation, scale) =
            (open("TRANSLATION", 3)?, open("ROTATION", 4)?, open("SCALE", 3)?);
        let mut count = None;
        for elements in [&translation, &rotation, &scale].into_iter().flatten() {
            if let Some(count) = count {
                elements.with_count(count, "the other attributes of the instances")?;
            }
            count = Some(elements.count);
        }
        // If there are only application-specific attributes, they still give the count.
        let custom = instancing.attributes.values().next();
        let count = match (count, custom) {
            (Some(count), _) => count,
            (None, Some(at)) => Elements::open(document, buffers, *at, pointer)?.count,
            (None, None) => return Err(Fault::at(pointer, "has no attributes; expected at least one")),
        };
        Ok(Instances { count, translation, rotation, scale })
    }

    /// The transform of one instance.
    pub(super) fn transform(&self, i: usize) -> DAffine3 {
        let vector = |v: &Option<Elements<'_>>, otherwise: DVec3| {
            v.as_ref().map_or(otherwise, |e| DVec3::from(e.get::<3>(i).map(f64::from)))
        };
        let rotation = self.rotation.as_ref().map_or([0.0, 0.0, 0.0, 1.0], |e| e.get::<4>(i).map(f64::from));
        from_parts(vector(&self.translation, DVec3::ZERO), rotation, vector(&self.scale, DVec3::ONE))
    }
}
