//! The shadow terminator of smooth meshes: diffuse reflection fades before the flat triangles hide the light, which
//! they do before the interpolated normal turns away (Chiang, Li and Burley 2019, "Taming the shadow terminator",
//! eq. 3 and 4).
//!
//! ```text
//!       ng  ns   .wi        g = (ng·wi) / (ng·ns · ns·wi)
//!        |  /  .            factor: 1 where g >= 1, else g + g² − g³, and 0 below the triangle
//!   _____|_/_.______
//! ```
//!
//! The factor takes light at grazing angles. The rest becomes brighter by as much, so that the surface reflects as much
//! of uniform light as without the factor. Lobes of metal, coats and interfaces do not show the terminator and are left
//! as they are.

use turner_bvh::lanes::{F64x8, Mask8, Simd, Vec3x8};

use crate::math::DVec3;

/// Coefficients of R − 1 = sin δ · cos δ · (c0 + c1 sin δ + c2 sin² δ + c3 sin³ δ), where δ is the angle between the
/// normals and R the reflected fraction of uniform light without the factor over that with it. A least-squares fit to
/// numeric quadrature; R is within 0.002 of it.
const KEEP: [f64; 4] = [0.090_793_819, 0.860_161_411, -1.309_650_119, 0.738_211_304];

/// The interpolated and the geometric normal of a smooth mesh, in the frame of the directions.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Terminator {
    ns: DVec3,
    ng: DVec3,
    /// Cosine of the angle between them.
    cos: f64,
    /// R, see [`KEEP`].
    keep: f64,
}

impl Terminator {
    pub(crate) fn new(ns: DVec3, ng: DVec3) -> Terminator {
        let cos = ng.dot(ns);
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        let [a, b, c, d] = KEEP;
        let keep = 1.0 + sin * cos * (a + sin * (b + sin * (c + sin * d)));
        Terminator { ns, ng, cos, keep }
    }

    /// The same with both normals in another frame.
    pub(super) fn turned(self, turn: impl Fn(DVec3) -> DVec3) -> Terminator {
        Terminator { ns: turn(self.ns), ng: turn(self.ng), ..self }
    }

    /// The factor of diffuse reflection for light from `wi`.
    #[inline]
    pub(crate) fn softening(&self, wi: DVec3) -> f64 {
        let g = self.ng.dot(wi) / (self.cos * self.ns.dot(wi));
        let factor = if g >= 1.0 {
            1.0
        } else if g > 0.0 {
            g * (1.0 + g * (1.0 - g))
        } else {
            0.0
        };
        factor * self.keep
    }
}

/// Eight [`Terminator`]s.
#[derive(Clone, Copy)]
pub(crate) struct TerminatorX8<S: Simd> {
    ns: Vec3x8<S>,
    ng: Vec3x8<S>,
    cos: F64x8<S>,
    keep: F64x8<S>,
    /// The lanes that have one.
    on: Mask8<S>,
}

impl<S: Simd> TerminatorX8<S> {
    #[inline(always)]
    pub(crate) fn new(simd: S, ns: Vec3x8<S>, ng: Vec3x8<S>, on: Mask8<S>) -> TerminatorX8<S> {
        let splat = |v: f64| F64x8::splat(simd, v);
        let one = splat(1.0);
        let cos = ng.dot(ns);
        let sin = (one - cos * cos).or_larger(splat(0.0)).sqrt();
        let [a, b, c, d] = KEEP.map(splat);
        let keep = one + sin * cos * (a + sin * (b + sin * (c + sin * d)));
        TerminatorX8 { ns, ng, cos, keep, on }
    }

    /// The factors of diffuse reflection for light from `wi`; 1 in the other lanes.
    #[inline(always)]
    pub(crate) fn softening(&self, simd: S, wi: Vec3x8<S>) -> F64x8<S> {
        let (zero, one) = (F64x8::splat(simd, 0.0), F64x8::splat(simd, 1.0));
        if !self.on.any() {
            return one;
        }
        let g = self.ng.dot(wi) / (self.cos * self.ns.dot(wi));
        let soft = g.gt(zero).select(g * (one + g * (one - g)), zero);
        self.on.select(g.ge(one).select(one, soft) * self.keep, one)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::{Bsdf, PrincipledPoint, sample_cosine};
    use crate::color::Spectrum;
    use crate::math::elementary::sin_cos;
    use crate::math::radians;

    /// The normal of a triangle whose shading normal is +z.
    fn tilted(degrees: f64) -> DVec3 {
        let (sin, cos) = sin_cos(radians(degrees));
        DVec3::new(sin, 0.0, cos)
    }

    /// Reflected fraction of uniform light that arrives above the triangle.
    fn albedo(bsdf: &Bsdf<'_>, wo: DVec3, ng: DVec3, softens: bool) -> f64 {
        const SIDE: u32 = 400;
        let seen = bsdf.towards(wo);
        let seen = if softens { seen.softened(Terminator::new(DVec3::Z, ng)) } else { seen };
        let mut sum = 0.0;
        for i in 0..SIDE * SIDE {
            let at = |i: u32| (f64::from(i) + 0.5) / f64::from(SIDE);
            let wi = sample_cosine([at(i / SIDE), at(i % SIDE)]);
            if wi.dot(ng) > 0.0 {
                sum += f64::from(seen.eval_pdf(wi).0.g) * std::f64::consts::PI;
            }
        }
        sum / f64::from(SIDE * SIDE)
    }

    /// Above the triangle is the fraction (1 + cos δ) / 2 of the projected hemisphere.
    #[test]
    fn diffuse_reflection_keeps_its_energy() {
        let white = Bsdf::lambert(Spectrum::WHITE);
        for degrees in [1.0, 5.0, 20.0, 45.0, 70.0, 88.0] {
            let ng = tilted(degrees);
            let expected = 0.5 * (1.0 + ng.z);
            let found = albedo(&white, DVec3::Z, ng, true);
            assert!((found - expected).abs() < 0.003, "{degrees}: {found} {expected}");
        }
    }

    /// Metal, and the interface of plastic, are the same in every direction.
    #[test]
    fn other_lobes_are_left_as_they_are() {
        let (ng, wo) = (tilted(25.0), tilted(40.0));
        let metal = PrincipledPoint { base_metalness: 1.0, ..PrincipledPoint::default() };
        let gloss = PrincipledPoint { base_color: Spectrum::BLACK, ..PrincipledPoint::default() };
        for point in [metal, gloss] {
            let bsdf = Bsdf::new(&point);
            let soft = bsdf.towards(wo).softened(Terminator::new(DVec3::Z, ng));
            for i in 0..64 {
                let wi = sample_cosine([f64::from(i) / 64.0, f64::from(i % 8) / 8.0]);
                assert_eq!(soft.eval_pdf(wi), bsdf.eval_pdf(wo, wi), "{point:?}");
            }
        }
        let plastic = Bsdf::new(&PrincipledPoint::default());
        let (hard, soft) = (albedo(&plastic, wo, ng, false), albedo(&plastic, wo, ng, true));
        assert!((hard - soft).abs() < 0.003, "{hard} {soft}");
    }

    #[test]
    fn light_fades_towards_the_edge_of_the_triangle() {
        let terminator = Terminator::new(DVec3::Z, tilted(30.0));
        let at = |degrees: f64| terminator.softening(tilted(degrees));
        // 90° from the geometric normal is 60° on the other side of the shading normal.
        assert!(at(-59.999) < 1e-4 && at(-61.0) == 0.0);
        assert!(at(-50.0) < at(-30.0) && at(-30.0) < at(0.0) && at(0.0) == at(60.0));
    }
}
