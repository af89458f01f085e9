//! A surface hit with its BSDF: the material evaluated in a shading frame on the side of the ray.

use super::bent_normal::{bent_normal, with_normal};
use super::{MaterialEvalContext, OpenPbr};
use crate::bsdf::{Bsdf, BsdfFromWo, BsdfSample, Terminator};
use crate::color::Spectrum;
use crate::interaction::SurfaceInteraction;
use crate::math::{DVec3, Frame, Ray};

/// A surface hit with its BSDF, on the side that the ray came from.
pub(crate) struct Vertex<'a> {
    pub(crate) surface: &'a SurfaceInteraction,
    /// Around the shading normal; z on the side the ray came from.
    pub(crate) frame: Frame,
    /// Geometric normal: outward for surfaces with an interior, otherwise on the side the ray came from.
    pub(crate) ng: DVec3,
    /// The BSDF, seen from wo.
    pub(crate) bsdf: BsdfFromWo<'a>,
    /// Direction towards the ray's origin, in world space and in the frame.
    pub(crate) wo: DVec3,
    pub(crate) wo_local: DVec3,
}

/// A light sample as the surface sees it.
pub(crate) struct Met {
    /// Direction towards the light, in world space and in the frame, and the light's distance.
    pub(crate) wi: DVec3,
    pub(crate) wi_local: DVec3,
    pub(crate) distance: f64,
    /// Whether the light is transmitted through the surface.
    pub(crate) crosses: bool,
    /// The BSDF and the density with which BSDF sampling finds `wi`.
    pub(crate) f: Spectrum,
    pub(crate) pdf: f64,
}

impl Vertex<'_> {
    pub(crate) fn surface(&self) -> &SurfaceInteraction {
        self.surface
    }

    /// Direction towards the ray's origin.
    pub(crate) fn wo(&self) -> DVec3 {
        self.wo
    }

    /// Absolute cosine between the shading normal and a direction.
    pub(crate) fn cosine(&self, w: DVec3) -> f64 {
        self.frame.z.dot(w).abs()
    }

    /// The BSDF for light from `wi` and its sampling density.
    pub(crate) fn eval_towards(&self, wi: DVec3) -> (Spectrum, f64) {
        let found = self.eval(wi, self.frame.to_local(wi));
        found.map_or((Spectrum::BLACK, 0.0), |(_, f, pdf)| (f, pdf))
    }

    /// In addition, whether light is transmitted; `None` where the shading and geometric normals disagree on the sides.
    #[inline]
    fn eval(&self, wi: DVec3, wi_local: DVec3) -> Option<(bool, Spectrum, f64)> {
        let crosses = self.crosses(wi, wi_local)?;
        let (f, pdf) = self.bsdf.eval_pdf(wi_local);
        Some((crosses, f, pdf))
    }

    /// Evaluates a light sample at the vector `to_light`; `None` where the shading and geometric normals disagree on
    /// the sides.
    #[inline]
    pub(crate) fn met(&self, to_light: DVec3) -> Option<Met> {
        let distance = to_light.length();
        let wi = to_light / distance;
        let wi_local = self.frame.to_local(wi);
        let (crosses, f, pdf) = self.eval(wi, wi_local)?;
        Some(Met { wi, wi_local, distance, crosses, f, pdf })
    }

    /// Whether any lobe is not a delta lobe.
    pub(crate) fn is_smooth(&self) -> bool {
        self.bsdf.has_smooth()
    }

    /// A BSDF sample with its direction in world space; `None` where the shading and geometric normals disagree on the
    /// sides.
    pub(crate) fn sample_in_scene(&self, u: [f64; 3]) -> Option<(BsdfSample, DVec3)> {
        let s = self.bsdf.sample(u)?;
        let wi = self.frame.to_world(s.wi);
        self.crosses(wi, s.wi)?;
        Some((s, wi))
    }

    /// Fraction of light that passes straight through a pane, if the shading and geometric normals agree on the sides.
    pub(crate) fn straight(&self) -> Spectrum {
        match self.crosses(-self.wo, -self.wo_local) {
            Some(true) => self.bsdf.straight(),
            _ => Spectrum::BLACK,
        }
    }

    /// Whether light from `wi` is transmitted; `None` where the shading and geometric normals disagree on the sides.
    #[inline]
    pub(crate) fn crosses(&self, wi: DVec3, wi_local: DVec3) -> Option<bool> {
        let crosses = (wi.dot(self.ng) > 0.0) != (self.wo.dot(self.ng) > 0.0);
        (crosses == ((wi_local.z > 0.0) != (self.wo_local.z > 0.0))).then_some(crosses)
    }
}

/// The surface with its BSDF, for a ray that hit its outer (`outside`) or inner side.
pub(crate) fn prepare<'a>(
    scene: &impl MaterialEvalContext,
    ray: &Ray,
    material: &OpenPbr,
    surface: &'a SurfaceInteraction,
    bsdf: &'a Bsdf<'a>,
    outside: bool,
) -> Vertex<'a> {
    let wo = -ray.direction;
    if material.is_hair() {
        // A fibre scatters into the whole sphere: the sides are those of the frame.
        let frame = OpenPbr::hair_frame(scene, surface, wo);
        let wo_local = frame.to_local(wo);
        return Vertex { surface, frame, ng: frame.z, bsdf: bsdf.towards(wo_local), wo, wo_local };
    }
    let mut frame = material.frame(scene, surface);
    let mut ng = surface.ng;
    // Sign of the side that the ray came from.
    let side = if outside { 1.0 } else { -1.0 };
    if frame.z != ng {
        let bent = side * bent_normal(wo, side * frame.z, side * ng);
        if bent != frame.z {
            frame = with_normal(&frame, bent);
        }
    }
    if !outside {
        frame = Frame { x: frame.x, y: -frame.y, z: -frame.z };
        if !material.has_inside() {
            ng = -ng;
        }
    }
    let wo_local = frame.to_local(wo);
    let mut bsdf = bsdf.towards(wo_local);
    if material.desc.soften_terminator && surface.ns != surface.ng {
        bsdf = bsdf.softened(Terminator::new(frame.to_local(surface.ns), frame.to_local(surface.ng)));
    }
    Vertex { surface, frame, ng, bsdf, wo, wo_local }
}

/// The BSDF with the coat's own normal, if it has one.
pub(crate) fn coated<'m>(
    scene: &impl MaterialEvalContext,
    ray: &Ray,
    material: &OpenPbr,
    surface: &SurfaceInteraction,
    bsdf: &Bsdf<'m>,
    outside: bool,
) -> Option<Bsdf<'m>> {
    let n = material.coat_normal(scene, surface)?;
    let base = prepare(scene, ray, material, surface, bsdf, outside);
    let side = if outside { 1.0 } else { -1.0 };
    let n = bent_normal(base.wo, side * n, base.frame.z);
    Some(bsdf.with_coat_normal(base.frame.to_local(n)))
}
