//! Renumbering of IDs when one scene is inserted into another.

use std::cell::RefCell;

use crate::schema::{ColorSource, GroupId, ImageId, MaterialId, MediumId, MeshId, TextureId};

/// Offsets to add to the IDs of each kind.
#[derive(Debug, Default)]
pub struct Renumber {
    pub(crate) textures: u32,
    pub(crate) materials: u32,
    pub(crate) images: u32,
    pub(crate) meshes: u32,
    pub(crate) groups: u32,
    pub(crate) media: u32,
    /// If set, images and meshes are numbered in the order of their first use instead.
    pub(crate) uses: Option<[OrderOfUse; 2]>,
}

impl Renumber {
    /// The new ID of a material.
    pub(crate) fn material(&self, id: MaterialId) -> MaterialId {
        MaterialId(id.0 + self.materials)
    }
    /// The new ID of a group.
    pub(crate) fn group(&self, id: GroupId) -> GroupId {
        GroupId(id.0 + self.groups)
    }
    /// The new ID of a medium.
    pub(crate) fn medium(&self, id: MediumId) -> MediumId {
        MediumId(id.0 + self.media)
    }
    /// The new ID of an image.
    pub(crate) fn image(&self, id: ImageId) -> ImageId {
        match &self.uses {
            Some([images, _]) => ImageId(images.number(id.0)),
            None => ImageId(id.0 + self.images),
        }
    }
    /// The new ID of a mesh.
    pub(crate) fn mesh(&self, id: MeshId) -> MeshId {
        match &self.uses {
            Some([_, meshes]) => MeshId(meshes.number(id.0)),
            None => MeshId(id.0 + self.meshes),
        }
    }
    /// Numbers images and meshes in the order of their first use; all other IDs stay the same.
    pub(crate) fn in_order_of_use() -> Renumber {
        Renumber { uses: Some(Default::default()), ..Renumber::default() }
    }
    /// The old IDs of the images used so far, in order of first use.
    pub(crate) fn images_in_order(&self) -> Vec<u32> {
        self.uses.as_ref().map_or_else(Vec::new, |[images, _]| images.seen())
    }
    /// The old IDs of the meshes used so far, in order of first use.
    pub(crate) fn meshes_in_order(&self) -> Vec<u32> {
        self.uses.as_ref().map_or_else(Vec::new, |[_, meshes]| meshes.seen())
    }
    /// The source with its new texture ID; constants stay the same.
    pub(crate) fn source(&self, source: ColorSource) -> ColorSource {
        match source {
            ColorSource::Texture(id) => ColorSource::Texture(TextureId(id.0 + self.textures)),
            constant => constant,
        }
    }
}

/// Assigns new IDs in the order in which old ones are first passed in.
#[derive(Debug, Default)]
pub(crate) struct OrderOfUse {
    seen: RefCell<Vec<u32>>,
    numbers: RefCell<std::collections::BTreeMap<u32, u32>>,
}

impl OrderOfUse {
    pub(crate) fn number(&self, old: u32) -> u32 {
        *self.numbers.borrow_mut().entry(old).or_insert_with(|| {
            let mut seen = self.seen.borrow_mut();
            seen.push(old);
            seen.len() as u32 - 1
        })
    }

    pub(crate) fn seen(&self) -> Vec<u32> {
        self.seen.borrow().clone()
    }
}
