//! Participating media and the regions that they fill.

use crate::material::MaterialDesc;
use crate::medium::{Medium, MediumDesc};
use crate::schema::{ErrorCode, MaterialId, MediumId, Named, SceneError};

/// The medium of each region.
#[derive(Clone, Debug)]
pub(crate) struct Volumes {
    media: Vec<Medium>,
    /// The medium outside all solids.
    open: Option<u32>,
    /// By material: the interior medium of solids.
    interiors: Vec<Option<u32>>,
    /// Whether any solid has a medium or is a hollow in one; if not, shadow rays cross one medium only.
    pub(crate) bounded: bool,
}

impl Volumes {
    /// The media of a scene; `open` is the medium outside all solids. `None` if no medium affects light.
    pub(crate) fn prepare(
        media_descs: &[Named<MediumDesc>],
        materials: &[Named<MaterialDesc>],
        open: Option<MediumId>,
    ) -> Result<Option<Volumes>, SceneError> {
        let mut media = Vec::with_capacity(media_descs.len());
        for medium in media_descs {
            media.push(medium.value.prepare().map_err(|e| e.or_at(medium.span))?);
        }
        let known = |id: u32| match media.get(id as usize) {
            Some(_) => Ok(id),
            None => {
                let message = format!("the scene has no medium with index {id}");
                Err(SceneError::new(ErrorCode::UnknownName, message))
            }
        };
        let open = open.map(|id| known(id.0)).transpose()?;
        let interiors: Vec<Option<u32>> = (0..materials.len())
            .map(|i| interior(materials, i).map(known).transpose())
            .collect::<Result<_, _>>()?;
        let there = |id: &u32| media.get(*id as usize).is_some_and(|m| !m.is_void());
        let bounded = interiors.iter().flatten().any(there);
        let found = bounded || open.as_ref().is_some_and(there);
        Ok(found.then(|| {
            // A hollow in fog is bounded, too.
            let hollow = |m: &MaterialDesc| matches!(m, MaterialDesc::Interface(_));
            let bounded = bounded || materials.iter().any(|m| hollow(&m.value));
            Volumes { media, open, interiors, bounded }
        }))
    }

    /// Number of media.
    pub(crate) fn count(&self) -> usize {
        self.media.len()
    }

    /// Extinction per unit of length at density 1, averaged over the channels; 0 for an unknown id.
    pub(crate) fn extinction(&self, id: u32) -> f64 {
        self.media.get(id as usize).map_or(0.0, |m| m.coefficients().extinction.iter().sum::<f64>() / 3.0)
    }

    /// Replaces a medium and returns the old one; `None` if the id is unknown or the old medium does not affect
    /// light.
    pub(crate) fn exchange(&mut self, id: u32, medium: Medium) -> Option<Medium> {
        let slot = self.media.get_mut(id as usize)?;
        let own = std::mem::replace(slot, medium);
        (!own.is_void()).then_some(own)
    }

    /// The medium inside a solid of this material, or outside all solids; `None` if there is none or it does not
    /// affect light.
    #[inline]
    pub(crate) fn within(&self, solid: Option<MaterialId>) -> Option<&Medium> {
        let id = match solid {
            None => self.open,
            Some(material) => self.interiors.get(material.index()).copied().flatten(),
        };
        self.media.get(id? as usize).filter(|m| !m.is_void())
    }
}

/// The interior medium of a material; for a mix that of the first of its materials which has one.
fn interior(materials: &[Named<MaterialDesc>], material: usize) -> Option<u32> {
    let mut stack = vec![material];
    // Mixes that contain themselves are refused earlier; the bound is a safeguard.
    for _ in 0..1024 {
        match &materials.get(stack.pop()?)?.value {
            MaterialDesc::Interface(m) => return m.interior.map(|id| id.0),
            MaterialDesc::Principled(m) if m.interior.is_some() => return m.interior.map(|id| id.0),
            MaterialDesc::Disney(m) if m.interior.is_some() => return m.interior.map(|id| id.0),
            MaterialDesc::Measured(m) if m.interior.is_some() => return m.interior.map(|id| id.0),
            MaterialDesc::Dielectric(m) if m.interior.is_some() => return m.interior.map(|id| id.0),
            MaterialDesc::Mix(m) => stack.extend(m.materials.iter().rev().map(|m| m.index())),
            MaterialDesc::Principled(_)
            | MaterialDesc::Dielectric(_)
            | MaterialDesc::Classic(_)
            | MaterialDesc::Matte(_)
            | MaterialDesc::Metal(_)
            | MaterialDesc::Plastic(_)
            | MaterialDesc::Emissive(_)
            | MaterialDesc::Disney(_)
            | MaterialDesc::Measured(_)
            | MaterialDesc::Hair(_) => {}
        }
    }
    None
}
