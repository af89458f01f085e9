//! What a path is inside of: solids that light passes through, nested or overlapping.
//!
//! Where solids overlap, the one with the higher index of refraction is there, and the boundary of the other within it is none
//! (Schmidt & Budge 2002, "Simple nested dielectrics in ray traced images", with the index as priority): a drink may reach into its glass.

use crate::color::Spectrum;
use crate::material::OpenPbr;
use crate::math::elementary::{exp, ln};
use crate::scene::{Scene, SurfaceInteraction};
use crate::schema::{ColorSource, MaterialId};

/// Materials of solids around a point; more than these are taken for nothing.
const MAX_NESTED: usize = 8;

#[derive(Clone, Copy, Debug)]
struct Medium {
    material: MaterialId,
    ior: f32,
    /// Share absorbed per unit of length, exponential.
    absorption: [f32; 3],
    /// How many solids of this material.
    count: u32,
}

/// The solids around a point of a path, in place: nothing is allocated on the way.
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

/// What a boundary between solids is to a ray.
pub(super) enum Boundary {
    /// Between the solid and another medium of this index of refraction.
    Between(f64),
    /// Nothing: a solid that stands above it is on both sides.
    Hidden,
}

impl Media {
    /// Around a point in the open.
    pub(super) const NONE: Media = Media {
        list: [Medium { material: MaterialId(0), ior: 1.0, absorption: [0.0; 3], count: 0 }; MAX_NESTED],
        len: 0,
    };

    /// Takes all out.
    #[inline]
    pub(super) fn clear(&mut self) {
        self.len = 0;
    }

    fn list(&self) -> &[Medium] {
        &self.list[..self.len]
    }

    /// Whether there are none.
    pub(super) fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The materials of the solids, in the order they were entered.
    pub(super) fn materials(&self) -> impl Iterator<Item = MaterialId> + '_ {
        self.list().iter().map(|m| m.material)
    }

    /// The material of the solid that is there.
    #[inline]
    pub(super) fn top(&self) -> Option<MaterialId> {
        if self.len == 0 { None } else { self.top_except(None).map(|m| m.material) }
    }

    /// Whether a solid of a material is among them.
    pub(super) fn holds(&self, material: MaterialId) -> bool {
        self.list().iter().any(|m| m.material == material)
    }

    /// The solid that is there, other than one of a material.
    fn top_except(&self, except: Option<MaterialId>) -> Option<&Medium> {
        let others = self.list().iter().filter(|m| Some(m.material) != except);
        others.max_by(|a, b| a.ior.total_cmp(&b.ior).then(b.material.cmp(&a.material)))
    }

    /// The share of light that is left after a way of some length.
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

    /// What the boundary of a solid is, met from outside (`entering`) or inside.
    pub(super) fn boundary(&self, material: MaterialId, ior: f64, entering: bool) -> Boundary {
        let inside = self.list().iter().find(|m| m.material == material).map_or(0, |m| m.count);
        // Of solids of one material in one another, only the outermost boundary shows.
        if if entering { inside > 0 } else { inside > 1 } {
            return Boundary::Hidden;
        }
        match self.top_except(Some(material)) {
            Some(top) if (top.ior, material) > (ior as f32, top.material) => Boundary::Hidden,
            Some(top) => Boundary::Between(f64::from(top.ior)),
            None => Boundary::Between(1.0),
        }
    }

    /// The path has crossed the boundary of a solid at `surface`.
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

/// Per unit of length, by the colour that is left after `transmission_depth` (Beer–Lambert). A texture counts as it is where the path
/// enters.
fn absorption(scene: &Scene, surface: &SurfaceInteraction, material: &OpenPbr) -> [f32; 3] {
    let depth = material.desc.transmission_depth;
    if depth <= 0.0 {
        return [0.0; 3];
    }
    let left = match material.desc.transmission_color {
        ColorSource::Constant(c) => c,
        source => scene.textures.color(source, &scene.texture_point(surface)),
    };
    // A film a millionth of a millionth thick would be opaque anyway.
    left.to_array().map(|v| {
        let v = f64::from(v).clamp(1e-10, 1.0);
        (-ln(v) / depth).min(1e30) as f32
    })
}
