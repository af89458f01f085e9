//! The media of a scene and what they fill.

use crate::material::MaterialDesc;
use crate::medium::{Medium, MediumDesc};
use crate::schema::{ErrorCode, MaterialId, MediumId, Named, SceneError};

/// Which medium is where.
#[derive(Clone, Debug)]
pub(crate) struct Volumes {
    media: Vec<Medium>,
    /// Where no solid is.
    open: Option<u32>,
    /// By material: what is inside of solids of it.
    interiors: Vec<Option<u32>>,
    /// Whether any solid has a medium: if not, shadow rays meet but one.
    pub(crate) bounded: bool,
}

impl Volumes {
    /// Those of a scene; `open` is where no solid is. `None` if there are none, or none that does anything to light.
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
                let message = format!("there is no medium number {id} in the scene");
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
            let hollow = |m: &MaterialDesc| matches!(m, MaterialDesc::Boundary(_));
            let bounded = bounded || materials.iter().any(|m| hollow(&m.value));
            Volumes { media, open, interiors, bounded }
        }))
    }

    /// How many there are.
    pub(crate) fn count(&self) -> usize {
        self.media.len()
    }

    /// What is lost per unit of length at density 1, the mean of the bands; 0 for a medium that is not there.
    pub(crate) fn extinction(&self, id: u32) -> f64 {
        self.media.get(id as usize).map_or(0.0, |m| m.coefficients().extinction.iter().sum::<f64>() / 3.0)
    }

    /// Puts a medium in the place of another and gives that; `None` if that is none, or does nothing.
    pub(crate) fn exchange(&mut self, id: u32, medium: Medium) -> Option<Medium> {
        let place = self.media.get_mut(id as usize)?;
        let own = std::mem::replace(place, medium);
        (!own.is_void()).then_some(own)
    }

    /// The medium inside a solid of a material, or in the open; `None` if there is none, or none that does anything.
    #[inline]
    pub(crate) fn within(&self, solid: Option<MaterialId>) -> Option<&Medium> {
        let id = match solid {
            None => self.open,
            Some(material) => self.interiors.get(material.index()).copied().flatten(),
        };
        self.media.get(id? as usize).filter(|m| !m.is_void())
    }
}

/// The medium that a material has inside; of a mix that of the first of its materials which says one.
fn interior(materials: &[Named<MaterialDesc>], material: usize) -> Option<u32> {
    let mut stack = vec![material];
    // Mixes that contain themselves have been refused; their number is bounded all the same.
    for _ in 0..1024 {
        match &materials.get(stack.pop()?)?.value {
            MaterialDesc::Boundary(m) => return m.interior.map(|id| id.0),
            MaterialDesc::Principled(m) if m.interior.is_some() => return m.interior.map(|id| id.0),
            MaterialDesc::Dielectric(m) if m.interior.is_some() => return m.interior.map(|id| id.0),
            MaterialDesc::Mix(m) => stack.extend(m.materials.iter().rev().map(|m| m.index())),
            MaterialDesc::Principled(_)
            | MaterialDesc::Dielectric(_)
            | MaterialDesc::Classic(_)
            | MaterialDesc::Matte(_)
            | MaterialDesc::Metal(_)
            | MaterialDesc::Plastic(_)
            | MaterialDesc::Emissive(_) => {}
        }
    }
    None
}
