//! Textures, materials and media.

use std::sync::Arc;

use crate::color::Transfer;
use crate::description::SceneDesc;
use crate::image::Image;
use crate::material::{Cutout, Material, MaterialDesc, ShadowKind, mix};
use crate::medium::MediumDesc;
use crate::scene::volumes::Volumes;
use crate::schema::{MediumId, PrepareOptions, SceneError};
use crate::texture::{CachedMipmaps, TextureDesc, Textures};

/// The textures of the last description, with their inputs.
#[derive(Default)]
pub(super) struct CachedTextures {
    made: Option<TexturesByDesc>,
    mipmaps: CachedMipmaps,
}

struct TexturesByDesc {
    descs: Vec<TextureDesc>,
    images: Vec<Arc<Image>>,
    transfer: Transfer,
    filtered: bool,
    textures: Arc<Textures>,
}

impl CachedTextures {
    /// The textures of a scene, and whether they were prepared again.
    ///
    /// Errors: those of the textures; not enough memory.
    pub(super) fn prepare(
        &mut self,
        desc: &SceneDesc,
        filtered: bool,
        options: &PrepareOptions,
    ) -> Result<(Arc<Textures>, bool), SceneError> {
        let transfer = desc.film.transfer;
        let same = |m: &&TexturesByDesc| {
            let textures = m.descs.len() == desc.textures.len()
                && m.descs.iter().zip(&desc.textures).all(|(a, b)| *a == b.value);
            let images = m.images.len() == desc.images.len()
                && m.images.iter().zip(&desc.images).all(|(a, b)| Arc::ptr_eq(a, &b.data));
            textures && images && m.transfer == transfer && m.filtered == filtered
        };
        if let Some(made) = self.made.as_ref().filter(same) {
            return Ok((made.textures.clone(), false));
        }
        desc.need_for_pictures(filtered, &options.limits.memory)?;
        let (threads, kept) = (options.threads, &mut self.mipmaps);
        let textures =
            Textures::prepare_with(&desc.textures, &desc.images, transfer, filtered, threads, kept)?;
        let textures = Arc::new(textures);
        self.made = Some(TexturesByDesc {
            descs: desc.textures.iter().map(|t| t.value.clone()).collect(),
            images: desc.images.iter().map(|i| i.data.clone()).collect(),
            transfer,
            filtered,
            textures: textures.clone(),
        });
        Ok((textures, true))
    }
}

/// The materials of the last description, with their inputs.
#[derive(Default)]
pub(super) struct CachedMaterials {
    made: Vec<(MaterialDesc, Material)>,
    physical: bool,
}

/// The properties of a material that the geometry needs: opacity and the kind of shadow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MaterialTraits {
    cutout: Option<Cutout>,
    shadow: ShadowKind,
}

impl CachedMaterials {
    /// Prepares changed materials. Returns their number, and whether any of them is or was emissive.
    ///
    /// Errors: mixes that refer to missing materials or to themselves.
    pub(super) fn prepare(&mut self, desc: &SceneDesc, physical: bool) -> Result<(usize, bool), SceneError> {
        mix::check(&desc.materials)?;
        // A mix depends on other materials.
        let mixes = |m: &MaterialDesc| matches!(m, MaterialDesc::Mix(_));
        let differ = |(made, now): (&(MaterialDesc, Material), &MaterialDesc)| made.0 != *now;
        let now = || desc.materials.iter().map(|m| &m.value);
        let edited = self.made.len() != desc.materials.len() || self.made.iter().zip(now()).any(differ);
        if self.physical != physical {
            self.made.clear();
        }
        self.physical = physical;
        let (mut rebuilt, mut emissive) = (0, self.made.len() > desc.materials.len());
        for (i, material) in now().enumerate() {
            let known = self.made.get(i).filter(|made| made.0 == *material);
            if known.is_some() && !(edited && mixes(material)) {
                continue;
            }
            let made = (material.clone(), material.prepare(physical, &desc.materials));
            emissive |= made.1.may_emit() || self.made.get(i).is_none_or(|old| old.1.may_emit());
            rebuilt += 1;
            match self.made.get_mut(i) {
                Some(slot) => *slot = made,
                None => self.made.push(made),
            }
        }
        self.made.truncate(desc.materials.len());
        Ok((rebuilt, emissive))
    }

    /// All materials of the description, followed by the default one.
    pub(super) fn materials(&self) -> Vec<Material> {
        let default = MaterialDesc::default().prepare(self.physical, &[]);
        self.made.iter().map(|(_, made)| made.clone()).chain([default]).collect()
    }

    /// The traits of all materials.
    pub(super) fn traits(&self) -> Vec<MaterialTraits> {
        let of = |(desc, made): &(MaterialDesc, Material)| MaterialTraits {
            cutout: desc.cutout(self.physical),
            shadow: made.shadow(),
        };
        self.made.iter().map(of).collect()
    }
}

/// The media of the last description, with their inputs.
#[derive(Default)]
pub(super) struct CachedMedia {
    media: Vec<MediumDesc>,
    materials: Vec<MaterialDesc>,
    open: Option<MediumId>,
    physical: bool,
    volumes: Option<Arc<Volumes>>,
}

impl CachedMedia {
    /// The volumes of a scene; `None` without media, or if the integrator is not physically based. Returns also
    /// whether they changed.
    ///
    /// Errors: those of the media; references to missing media.
    pub(super) fn prepare(
        &mut self,
        desc: &SceneDesc,
        physical: bool,
    ) -> Result<(Option<Arc<Volumes>>, bool), SceneError> {
        let same = self.physical == physical
            && self.open == desc.background.medium
            && self.media.iter().eq(desc.media.iter().map(|m| &m.value))
            && (desc.media.is_empty() || self.materials.iter().eq(desc.materials.iter().map(|m| &m.value)));
        // Report an undefined medium on every update, even if nothing changed.
        if same && !(desc.media.is_empty() && physical) {
            return Ok((self.volumes.clone(), false));
        }
        let made = match physical {
            true => Volumes::prepare(&desc.media, &desc.materials, desc.background.medium)?.map(Arc::new),
            false => None,
        };
        let new = made.is_some() || self.volumes.is_some();
        self.media = desc.media.iter().map(|m| m.value.clone()).collect();
        self.materials = desc.materials.iter().map(|m| m.value.clone()).collect();
        (self.open, self.physical, self.volumes) = (desc.background.medium, physical, made);
        Ok((self.volumes.clone(), new))
    }
}
