//! The BSDFs of OpenPBR materials that are evaluated for eight points at a time: those of opaque bases, without coat,
//! fuzz, film, transmission or subsurface scattering.

use super::{AlphaMode, MaterialEvalContext, OpenPbr, PrincipledMaterial};
use crate::bsdf::{Bsdf, OpaqueBase, Rgb, base_albedo, lambert};
use crate::color::Spectrum;
use crate::interaction::SurfaceInteraction;
use crate::schema::ColorSource;

/// A BSDF that is evaluated for eight points at a time.
#[derive(Clone, Copy, Debug)]
pub(crate) enum BlockBsdf<'a> {
    /// The BRDF of Lambertian reflection.
    Lambert(Spectrum),
    Opaque(OpaqueBase<'a>),
}

impl BlockBsdf<'_> {
    /// The form of a BSDF that has one.
    #[inline]
    fn of<'a>(bsdf: &'a Bsdf<'a>) -> Option<BlockBsdf<'a>> {
        match bsdf.as_lambert() {
            Some(f) => (!f.is_black()).then_some(BlockBsdf::Lambert(f)),
            None => bsdf.as_opaque_base().map(BlockBsdf::Opaque),
        }
    }

    fn is_same(&self, other: &BlockBsdf<'_>) -> bool {
        match (self, other) {
            (BlockBsdf::Lambert(a), BlockBsdf::Lambert(b)) => a == b,
            (BlockBsdf::Opaque(a), BlockBsdf::Opaque(b)) => a.is_same(b),
            _ => false,
        }
    }
}

/// An opaque dielectric base of which only the base colour is textured: it changes the diffuse albedo and nothing else.
#[derive(Clone, Debug)]
pub(crate) struct TexturedBase {
    color: ColorSource,
    /// For the outer and the inner side: the BSDF of a white base, and the base weight.
    sides: [(Bsdf<'static>, f64); 2],
}

impl TexturedBase {
    /// `None` if anything else is textured.
    fn new(desc: &PrincipledMaterial) -> Option<TexturedBase> {
        let white = PrincipledMaterial { base_color: ColorSource::Constant(Spectrum::WHITE), ..desc.clone() };
        let point = white.constant_point()?;
        let dielectric = point.base_metalness <= 0.0 && point.subsurface_weight <= 0.0;
        dielectric.then(|| TexturedBase {
            color: desc.base_color,
            sides: [true, false].map(|entering| {
                let point = desc.on_side(point, entering);
                (Bsdf::new(&point), point.base_weight)
            }),
        })
    }

    /// The BSDF at a point, if it has a diffuse lobe there.
    fn at(
        &self,
        scene: &impl MaterialEvalContext,
        surface: &SurfaceInteraction,
        outside: bool,
    ) -> Option<BlockBsdf<'_>> {
        let color = scene.textures().color(self.color, &scene.texture_point(surface));
        let (bsdf, weight) = &self.sides[usize::from(!outside)];
        let albedo = base_albedo(color, *weight);
        if albedo == Rgb::ZERO {
            return None;
        }
        match bsdf.as_lambert() {
            Some(_) => Some(BlockBsdf::Lambert(lambert(albedo))).filter(|_| !lambert(albedo).is_black()),
            None => bsdf.as_opaque_base().map(|base| BlockBsdf::Opaque(base.with_albedo(albedo))),
        }
    }

    /// The same as a whole BSDF.
    pub(super) fn bsdf(
        &self,
        scene: &impl MaterialEvalContext,
        surface: &SurfaceInteraction,
        outside: bool,
    ) -> Option<Bsdf<'static>> {
        let color = scene.textures().color(self.color, &scene.texture_point(surface));
        let (bsdf, weight) = &self.sides[usize::from(!outside)];
        bsdf.with_base_albedo(base_albedo(color, *weight))
    }
}

impl OpenPbr {
    /// Finds which of its BSDFs are evaluated in blocks.
    pub(super) fn prepare_blocks(&mut self) {
        self.is_opaque_base = self.has_opaque_base();
        (self.is_plain_outside, self.is_plain) = self.plain_sides();
        let textured = self.is_opaque_base && matches!(self.desc.base_color, ColorSource::Texture(_));
        self.textured_base = if textured { TexturedBase::new(&self.desc).map(Box::new) } else { None };
    }

    /// The BSDF, if it is an opaque base, the same everywhere and on both sides, around the surface's own normal.
    #[inline]
    pub(crate) fn plain(&self) -> Option<BlockBsdf<'_>> {
        let [outer, _] = self.constant.as_ref().filter(|_| self.is_plain)?;
        BlockBsdf::of(outer)
    }

    /// The BSDF on the outer side, if it is an opaque base, the same everywhere, around the surface's own normal.
    #[inline]
    pub(crate) fn plain_outside(&self) -> Option<BlockBsdf<'_>> {
        let [outer, _] = self.constant.as_ref().filter(|_| self.is_plain_outside)?;
        BlockBsdf::of(outer)
    }

    /// The BSDF at a surface hit on its outer (`outside`) or inner side, if it is an opaque base; `made` keeps what is
    /// evaluated for it.
    pub(crate) fn block_bsdf<'a, 'm: 'a>(
        &'m self,
        scene: &impl MaterialEvalContext,
        surface: &SurfaceInteraction,
        outside: bool,
        made: &'a mut Option<Bsdf<'m>>,
    ) -> Option<BlockBsdf<'a>> {
        if let Some(bsdf) = self.constant_bsdf(outside) {
            return BlockBsdf::of(bsdf);
        }
        match &self.textured_base {
            Some(base) => base.at(scene, surface, outside),
            None => BlockBsdf::of(made.insert(self.bsdf(scene, surface, 1.0, outside))),
        }
    }

    fn has_opaque_base(&self) -> bool {
        let d = &self.desc;
        let none = |source: ColorSource| source == ColorSource::Constant(Spectrum::BLACK);
        d.alpha_mode != AlphaMode::Blend
            && !d.unlit
            && !self.is_emissive()
            && !self.walks
            && !d.thin_walled
            && !d.is_transmissive()
            && self.dispersion.is_none()
            && none(d.base_diffuse_roughness)
            && none(d.specular_roughness_anisotropy)
            && none(d.coat_weight)
            && none(d.fuzz_weight)
            && none(d.thin_film_weight)
    }

    /// Whether its BSDF is a constant opaque base around the surface's own normal: on the outer side, and on both sides
    /// the same.
    fn plain_sides(&self) -> (bool, bool) {
        let is_mapped = self.desc.bump().is_some() || self.desc.normal_map.is_some();
        let Some([outer, inner]) = self.constant.as_ref().filter(|_| self.is_opaque_base && !is_mapped)
        else {
            return (false, false);
        };
        match (BlockBsdf::of(outer), BlockBsdf::of(inner)) {
            (Some(a), Some(b)) => (true, a.is_same(&b)),
            (Some(_), None) => (true, false),
            (None, _) => (false, false),
        }
    }
}
