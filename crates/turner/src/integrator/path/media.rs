//! The solids that a path is inside of, nested or overlapping.
//!
//! ```text
//!  air  |   glass 1.5   :  |   liquid 1.33
//!       |<---------------->|                  extent of the glass
//!                       :<----------------    extent of the liquid; its boundary (:) in the glass has no effect
//! ```
//!
//! Where solids overlap, the one with the higher index of refraction has priority, and the boundary of the other inside
//! it has no effect (Schmidt and Budge 2002, "Simple nested dielectrics in ray traced images", with the index as
//! priority). So a liquid may be modelled slightly larger than the inside of its glass. Inside a solid light is
//! absorbed by the Beer–Lambert law.

use crate::color::Spectrum;
use crate::material::OpenPbr;
use crate::math::DVec3;
use crate::math::elementary::{exp, ln};
use crate::scene::{Scene, SurfaceInteraction};
use crate::schema::{ColorSource, MaterialId};

/// Maximum number of solids around a point; further ones are ignored.
const MAX_NESTED: usize = 8;

#[derive(Clone, Copy, Debug)]
struct Medium {
    material: MaterialId,
    ior: f32,
    /// Absorption coefficient per scene unit.
    absorption: [f32; 3],
    /// Number of solids of this material.
    count: u32,
}

/// The solids around a point of a path, stored in place to avoid allocation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Media {
    list: [Medium; MAX_NESTED],
    len: usize,
}

impl Default for Media {
    fn default() -> Media {
        Media::NONE
    }
}

/// What the boundary of a solid is to a ray.
pub(super) enum Boundary {
    /// The boundary between the solid and a medium with this index of refraction.
    Between(f64),
    /// None: a solid of higher priority is on both sides.
    Hidden,
}

impl Media {
    /// No solids.
    pub(super) const NONE: Media = Media {
        list: [Medium { material: MaterialId(0), ior: 1.0, absorption: [0.0; 3], count: 0 }; MAX_NESTED],
        len: 0,
    };

    /// Removes all solids.
    #[inline]
    pub(super) fn clear(&mut self) {
        self.len = 0;
    }

    fn list(&self) -> &[Medium] {
        &self.list[..self.len]
    }

    /// Whether there are no solids.
    pub(super) fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The materials of the solids, in the order of entry.
    pub(super) fn materials(&self) -> impl Iterator<Item = MaterialId> + '_ {
        self.list().iter().map(|m| m.material)
    }

    /// The material of the solid with the highest priority.
    #[inline]
    pub(super) fn top(&self) -> Option<MaterialId> {
        if self.len == 0 { None } else { self.top_except(None).map(|m| m.material) }
    }

    /// Whether a solid of a material is among them.
    pub(super) fn contains(&self, material: MaterialId) -> bool {
        self.list().iter().any(|m| m.material == material)
    }

    /// The solid with the highest priority, except those of one material.
    fn top_except(&self, except: Option<MaterialId>) -> Option<&Medium> {
        let others = self.list().iter().filter(|m| Some(m.material) != except);
        others.max_by(|a, b| a.ior.total_cmp(&b.ior).then(b.material.cmp(&a.material)))
    }

    /// Transmittance over a distance by the Beer–Lambert law; `None` where nothing is absorbed.
    #[inline]
    pub(super) fn transmittance(&self, length: f64) -> Option<Spectrum> {
        if self.len == 0 {
            return None;
        }
        let absorption = self.top_except(None)?.absorption;
        if absorption == [0.0; 3] {
            return None;
        }
        let through = |a: f32| match a {
            0.0 => 1.0,
            a => exp(-f64::from(a) * length) as f32,
        };
        Some(Spectrum::from(absorption.map(through)))
    }

    /// What the boundary of a solid is, hit from outside (`entering`) or inside.
    pub(super) fn boundary(&self, material: MaterialId, ior: f64, entering: bool) -> Boundary {
        let inside = self.list().iter().find(|m| m.material == material).map_or(0, |m| m.count);
        // Of nested solids of one material only the outermost boundary counts.
        if if entering { inside > 0 } else { inside > 1 } {
            return Boundary::Hidden;
        }
        match self.top_except(Some(material)) {
            Some(top) if (top.ior, material) > (ior as f32, top.material) => Boundary::Hidden,
            Some(top) => Boundary::Between(f64::from(top.ior)),
            None => Boundary::Between(1.0),
        }
    }

    /// Updates the solids after a path has crossed `surface` towards `to`, if anything is inside.
    pub(super) fn pass(
        &mut self,
        scene: &Scene,
        surface: &SurfaceInteraction,
        material: &OpenPbr,
        to: DVec3,
    ) {
        if material.has_inside() || material.admits_medium() {
            self.cross(scene, surface, material, to.dot(surface.ng) < 0.0);
        }
    }

    /// The solids after [`Media::pass`].
    pub(super) fn after(
        mut self,
        scene: &Scene,
        surface: &SurfaceInteraction,
        material: &OpenPbr,
        to: DVec3,
    ) -> Media {
        self.pass(scene, surface, material, to);
        self
    }

    /// Updates the solids after the path has crossed a boundary at `surface`.
    pub(super) fn cross(
        &mut self,
        scene: &Scene,
        surface: &SurfaceInteraction,
        material: &OpenPbr,
        entering: bool,
    ) {
        let id = surface.material;
        let found = self.list().iter().position(|m| m.material == id);
        match (found, entering) {
            (Some(i), true) => self.list[i].count += 1,
            (Some(i), false) if self.list[i].count > 1 => self.list[i].count -= 1,
            (Some(i), false) => {
                self.list.copy_within(i + 1..self.len, i);
                self.len -= 1;
            }
            (None, true) if self.len < MAX_NESTED => {
                let ior = material.desc.specular_ior as f32;
                let absorption = absorption(scene, surface, material);
                self.list[self.len] = Medium { material: id, ior, absorption, count: 1 };
                self.len += 1;
            }
            (None, _) => {}
        }
    }
}

/// Absorption coefficient per scene unit, from the colour that is left after `transmission_depth` (Beer–Lambert law). A
/// texture is evaluated at the point of entry.
fn absorption(scene: &Scene, surface: &SurfaceInteraction, material: &OpenPbr) -> [f32; 3] {
    let depth = material.desc.transmission_depth;
    if depth <= 0.0 {
        return [0.0; 3];
    }
    let left = match material.desc.transmission_color {
        ColorSource::Constant(c) => c,
        source => scene.textures.color(source, &scene.texture_point(surface)),
    };
    // The bounds keep the coefficient finite; the solid is opaque there in any case.
    left.to_array().map(|v| {
        let v = f64::from(v).clamp(1e-10, 1.0);
        (-ln(v) / depth).min(1e30) as f32
    })
}
