//! Renumbering of IDs when one scene is inserted into another, or when parts of a scene are removed or sorted.

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
    /// If set, the new IDs of each kind by the old ones, instead of offsets.
    pub(crate) maps: Option<IdMaps>,
    /// If set, the IDs passed in are recorded and stay the same.
    pub(crate) log: Option<RefCell<Vec<PartId>>>,
    /// If set, images and meshes are numbered in the order of their first use instead.
    pub(crate) uses: Option<[OrderOfUse; 2]>,
}

/// A part of a scene that others refer to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PartId {
    Texture(u32),
    Material(u32),
    Medium(u32),
    Group(u32),
    Image(u32),
    Mesh(u32),
}

/// New IDs by old ones; `u32::MAX` for parts that are removed.
#[derive(Clone, Debug, Default)]
pub(crate) struct IdMaps {
    pub(crate) textures: Vec<u32>,
    pub(crate) materials: Vec<u32>,
    pub(crate) media: Vec<u32>,
    pub(crate) groups: Vec<u32>,
    pub(crate) images: Vec<u32>,
    pub(crate) meshes: Vec<u32>,
}

impl IdMaps {
    fn of(&self, part: PartId) -> u32 {
        let (map, id) = match part {
            PartId::Texture(id) => (&self.textures, id),
            PartId::Material(id) => (&self.materials, id),
            PartId::Medium(id) => (&self.media, id),
            PartId::Group(id) => (&self.groups, id),
            PartId::Image(id) => (&self.images, id),
            PartId::Mesh(id) => (&self.meshes, id),
        };
        map.get(id as usize).copied().unwrap_or(id)
    }
}

impl Renumber {
    /// The new ID of a part: recorded, from the map, or with an offset.
    fn number(&self, part: PartId, id: u32, offset: u32) -> u32 {
        if let Some(log) = &self.log {
            log.borrow_mut().push(part);
            return id;
        }
        self.maps.as_ref().map_or(id + offset, |maps| maps.of(part))
    }
    /// Records the IDs passed in.
    pub(crate) fn recording() -> Renumber {
        Renumber { log: Some(RefCell::default()), ..Renumber::default() }
    }
    /// The IDs recorded so far, in order.
    pub(crate) fn recorded(self) -> Vec<PartId> {
        self.log.map_or_else(Vec::new, RefCell::into_inner)
    }
    /// The new ID of a material.
    pub(crate) fn material(&self, id: MaterialId) -> MaterialId {
        MaterialId(self.number(PartId::Material(id.0), id.0, self.materials))
    }
    /// The new ID of a group.
    pub(crate) fn group(&self, id: GroupId) -> GroupId {
        GroupId(self.number(PartId::Group(id.0), id.0, self.groups))
    }
    /// The new ID of a medium.
    pub(crate) fn medium(&self, id: MediumId) -> MediumId {
        MediumId(self.number(PartId::Medium(id.0), id.0, self.media))
    }
    /// The new ID of an image.
    pub(crate) fn image(&self, id: ImageId) -> ImageId {
        match &self.uses {
            Some([images, _]) => ImageId(images.number(id.0)),
            None => ImageId(self.number(PartId::Image(id.0), id.0, self.images)),
        }
    }
    /// The new ID of a mesh.
    pub(crate) fn mesh(&self, id: MeshId) -> MeshId {
        match &self.uses {
            Some([_, meshes]) => MeshId(meshes.number(id.0)),
            None => MeshId(self.number(PartId::Mesh(id.0), id.0, self.meshes)),
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
            ColorSource::Texture(id) => {
                ColorSource::Texture(TextureId(self.number(PartId::Texture(id.0), id.0, self.textures)))
            }
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
