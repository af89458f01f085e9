//! The shading model, eight hits at a time: ka·Ia·C + Σ S·I·(kd·C·max(0, N·L) + ks·H·max(0, R·V)^n)
//!
//! C is the surface colour, H that of the highlight, Ia the ambient light, I the light's intensity after
//! attenuation, S its transmittance (Whitted 1980, with Phong's highlight).

// Several arrays of colour channels share one index.
#![allow(clippy::needless_range_loop)]

use std::marker::PhantomData;

use turner_bvh::lanes::{Block, F32x8, F64x8, LANES, Mask8, Simd, Vec3x8, Work};

use super::notes::TermNotes;
use super::points::{PointBlock, set};
use super::record::Record;
use super::{ClassicDesc, Highlight};
use crate::color::Spectrum;
use crate::light::{Light, Uniform};
use crate::math::elementary::Exponent;
use crate::scene::{RayBatch, SpectrumBlock};

/// The term of one light at eight hits.
#[derive(Clone, Copy, Default)]
pub(super) struct TermBlock {
    /// kd·C·max(0, N·L) + ks·H·max(0, R·V)^n.
    pub(super) term: SpectrumBlock,
    /// The unshadowed intensity; unused for lights with a [`Uniform`].
    pub(super) intensity: SpectrumBlock,
    /// Towards the light; unused for lights with a [`Uniform`].
    pub(super) to_light: [Block; 3],
    /// Lanes that the light can reach.
    pub(super) active: u8,
}

/// Eight colours in registers.
type Color8<S> = [F32x8<S>; 3];

#[inline(always)]
fn load<S: Simd>(simd: S, color: &SpectrumBlock) -> Color8<S> {
    [0, 1, 2].map(
        #[inline(always)]
        |i| F32x8::load(simd, &color.0[i]),
    )
}

#[inline(always)]
fn splat<S: Simd>(simd: S, color: Spectrum) -> Color8<S> {
    let [r, g, b] = color.to_array();
    [F32x8::splat(simd, r), F32x8::splat(simd, g), F32x8::splat(simd, b)]
}

#[inline(always)]
fn is_black<S: Simd>(simd: S, [r, g, b]: Color8<S>) -> Mask8<S> {
    let zero = F32x8::splat(simd, 0.0);
    r.eq(zero) & g.eq(zero) & b.eq(zero)
}

/// Initialises the local colours with the ambient term.
pub(super) struct Ambient<'a> {
    pub(super) points: &'a mut [PointBlock],
    pub(super) ambient: Option<Spectrum>,
}

impl Work for Ambient<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let zero = F32x8::splat(simd, 0.0);
        for b in self.points {
            let Some(ambient) = self.ambient else {
                b.local = SpectrumBlock::default();
                continue;
            };
            let ambient = splat(simd, ambient);
            let color = load(simd, &b.color);
            let ka = F32x8::load(simd, &b.ka);
            for i in 0..3 {
                (zero + ambient[i] * color[i] * ka).store(&mut b.local.0[i]);
            }
        }
    }
}

/// Evaluates one light, or one sample of an area light, and creates its shadow rays.
pub(super) struct Illuminate<'a, R> {
    pub(super) integrator: &'a ClassicDesc,
    pub(super) points: &'a [PointBlock],
    pub(super) terms: &'a mut [TermBlock],
    /// For lights whose position or direction and intensity are the same at all points. For other lights,
    /// `to_light`, `intensity` and `active` of the terms are already set.
    pub(super) uniform: Option<Uniform>,
    /// Whether the light has a position: then only objects nearer than it cast shadows.
    pub(super) finite: bool,
    pub(super) shadow_rays: &'a mut RayBatch,
    /// Filled if there is a recorder.
    pub(super) notes: &'a mut [TermNotes],
    pub(super) recorder: PhantomData<R>,
}

impl<R: Record> Work for Illuminate<'_, R> {
    /// The number of lanes that the light can reach.
    type Output = u64;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> u64 {
        let zero = F64x8::splat(simd, 0.0);
        let one = F64x8::splat(simd, 1.0);
        let zero32 = F32x8::splat(simd, 0.0);
        let integrator = self.integrator;
        let mut reached = 0;
        for (block, (b, out)) in self.points.iter().zip(self.terms).enumerate() {
            let p = Vec3x8::load(simd, &b.p);
            let (to_light, intensity, arrives) = match &self.uniform {
                Some(Uniform::Point { position, intensity }) => {
                    let to_light = Vec3x8::splat(simd, position.to_array()) - p;
                    let there = to_light.dot(to_light).eq(zero);
                    (to_light, splat(simd, *intensity), Mask8::new(simd, b.shaded).and_not(there))
                }
                Some(Uniform::Directional { to_light, intensity }) => {
                    let to_light = Vec3x8::splat(simd, to_light.to_array());
                    (to_light, splat(simd, *intensity), Mask8::new(simd, b.shaded))
                }
                None => {
                    let arrives = Mask8::new(simd, b.shaded & out.active);
                    (Vec3x8::load(simd, &out.to_light), load(simd, &out.intensity), arrives)
                }
            };
            let arrives = arrives.and_not(is_black(simd, intensity));
            if R::NOTES
                && let Some(notes) = self.notes.get_mut(block)
            {
                notes.reaches = arrives.bits();
                to_light.store(&mut notes.to_light);
                (0..3).for_each(|i| intensity[i].store(&mut notes.intensity.0[i]));
            }
            out.active = 0;
            let rays = self.shadow_rays.add_block(LANES);
            if !arrives.any() {
                continue;
            }
            let lit = Vec3x8::load(simd, &b.lit);
            let l = to_light * (one / to_light.dot(to_light).sqrt());
            let n_dot_l = lit.dot(l);
            let color = load(simd, &b.color);
            let kd = F64x8::load(simd, &b.kd);
            let diffuse = kd.gt(zero) & n_dot_l.gt(zero);
            let k = (kd * n_dot_l).narrow();
            let mut term = [zero32; 3];
            for i in 0..3 {
                term[i] = diffuse.select32(zero32 + color[i] * k, zero32);
            }
            if R::NOTES
                && let Some(notes) = self.notes.get_mut(block)
            {
                n_dot_l.store(&mut notes.n_dot_l);
                (0..3).for_each(|i| term[i].store(&mut notes.diffuse.0[i]));
            }
            if b.glossy != 0 {
                // R is L mirrored about N; V is −d.
                let mirrored = lit * (F64x8::splat(simd, 2.0) * n_dot_l) - l;
                let r_dot_v = -mirrored.dot(Vec3x8::load(simd, &b.d));
                // Below `dark` the highlight rounds to 0 in single precision; adding it would change nothing.
                let seen = arrives
                    & Mask8::new(simd, b.glossy)
                    & r_dot_v.gt(zero)
                    & r_dot_v.ge(F64x8::load(simd, &b.dark));
                if seen.any() {
                    let cosine = seen.select(r_dot_v.lt(one).select(r_dot_v, one), zero);
                    let power = power(simd, b, cosine, seen);
                    let k = (F64x8::load(simd, &b.ks) * power).narrow();
                    for i in 0..3 {
                        let highlight = match integrator.highlight {
                            Highlight::Light => F32x8::splat(simd, 1.0),
                            Highlight::Material => color[i],
                        };
                        if R::NOTES
                            && let Some(notes) = self.notes.get_mut(block)
                        {
                            r_dot_v.store(&mut notes.r_dot_v);
                            seen.select32(highlight * k, zero32).store(&mut notes.highlight.0[i]);
                        }
                        term[i] = seen.select32(term[i] + highlight * k, term[i]);
                    }
                }
            }
            // Lanes where both terms are black need no shadow ray.
            let active = arrives.and_not(is_black(simd, term));
            out.active = active.bits();
            reached += u64::from(out.active.count_ones());
            for i in 0..3 {
                term[i].store(&mut out.term.0[i]);
            }
            if !integrator.shadows || out.active == 0 {
                continue;
            }
            let (origin, direction, t_min) = if integrator.epsilon > 0.0 {
                (p, to_light, integrator.epsilon)
            } else {
                let origin = b.leave_wide(simd, to_light);
                (origin, if self.finite { p + to_light - origin } else { to_light }, 0.0)
            };
            let t_max = F64x8::splat(simd, if self.finite { 1.0 } else { f64::INFINITY });
            origin.store(&mut rays.origin);
            direction.store(&mut rays.direction);
            F64x8::splat(simd, t_min).store(&mut rays.t_min);
            active.select(t_max, F64x8::splat(simd, f64::NAN)).store(&mut rays.t_max);
        }
        reached
    }
}

/// The power of a highlight by repeated squaring, as [`pow_int`](crate::math::elementary::pow_int) computes it.
#[inline(always)]
fn power<S: Simd>(simd: S, b: &PointBlock, cosine: F64x8<S>, seen: Mask8<S>) -> F64x8<S> {
    let exponent = F64x8::load(simd, &b.exponent);
    let (mut x, mut result) = (cosine, F64x8::splat(simd, 1.0));
    let mut bits = b.exponent_bits;
    let mut bit = 0;
    while bits != 0 {
        if bits & 1 == 1 {
            result = exponent.has_bit(bit).select(result * x, result);
        }
        x = x * x;
        bit += 1;
        bits >>= 1;
    }
    let real = b.real_exponent & seen.bits();
    if real != 0 {
        let (mut cosines, mut powers) = (Block::default(), Block::default());
        cosine.store(&mut cosines);
        result.store(&mut powers);
        for lane in (0..LANES).filter(|lane| real >> lane & 1 == 1) {
            powers.0[lane] = Exponent::Real(b.exponent.0[lane]).of(cosines.0[lane]);
        }
        result = F64x8::load(simd, &powers);
    }
    result
}

/// Adds the terms of a light to the local colours, times its transmittance.
pub(super) struct Accumulate<'a, R> {
    pub(super) points: &'a mut [PointBlock],
    pub(super) terms: &'a [TermBlock],
    /// The light's intensity, where it is the same at all points.
    pub(super) intensity: Option<Spectrum>,
    /// The transmittance; `None` without shadows.
    pub(super) through: Option<&'a [SpectrumBlock]>,
    /// The fraction of light that reaches points in shadow.
    pub(super) shadow_factor: f32,
    /// Filled if there is a recorder.
    pub(super) notes: &'a mut [TermNotes],
    pub(super) recorder: PhantomData<R>,
}

impl<R: Record> Work for Accumulate<'_, R> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let f = self.shadow_factor;
        for (block, (b, term)) in self.points.iter_mut().zip(self.terms).enumerate() {
            if term.active == 0 {
                continue;
            }
            let active = Mask8::new(simd, term.active);
            let intensity = match self.intensity {
                Some(intensity) => splat(simd, intensity),
                None => load(simd, &term.intensity),
            };
            let seen = match self.through {
                None => [F32x8::splat(simd, 1.0); 3],
                Some(through) => load(simd, &through[block]),
            };
            let color = load(simd, &term.term);
            let local = load(simd, &b.local);
            for i in 0..3 {
                let seen = if self.through.is_some() && f > 0.0 {
                    seen[i] * F32x8::splat(simd, 1.0 - f) + F32x8::splat(simd, f)
                } else {
                    seen[i]
                };
                if R::NOTES
                    && let Some(notes) = self.notes.get_mut(block)
                {
                    (color[i] * intensity[i] * seen).store(&mut notes.added.0[i]);
                }
                let sum = local[i] + color[i] * intensity[i] * seen;
                active.select32(sum, local[i]).store(&mut b.local.0[i]);
            }
        }
    }
}

/// The results of eight hits: the weighted local colours and the reflected rays.
#[derive(Clone, Copy, Default)]
pub(super) struct LeavingBlock {
    pub(super) color: SpectrumBlock,
    /// Valid in lanes with a reflected ray.
    pub(super) origin: [Block; 3],
    pub(super) direction: [Block; 3],
}

/// Weights the local colours and computes the reflected rays.
pub(super) struct Leave<'a> {
    pub(super) integrator: &'a ClassicDesc,
    pub(super) points: &'a [PointBlock],
    pub(super) leaving: &'a mut [LeavingBlock],
}

impl Work for Leave<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let zero = F64x8::splat(simd, 0.0);
        let two = F64x8::splat(simd, 2.0);
        for (b, out) in self.points.iter().zip(self.leaving) {
            let weight = F64x8::load(simd, &b.weight).narrow();
            let local = load(simd, &b.local);
            for i in 0..3 {
                (local[i] * weight).store(&mut out.color.0[i]);
            }
            if b.mirrors != 0 {
                let entering = Mask8::new(simd, b.entering);
                let d = Vec3x8::load(simd, &b.d);
                let (ns, ng) = (Vec3x8::load(simd, &b.ns), Vec3x8::load(simd, &b.ng));
                let n = Vec3x8::select(entering, ns, -ns);
                let ng = Vec3x8::select(entering, ng, -ng);
                let mut direction = d - n * (two * d.dot(n));
                // A shading normal can reflect the ray below the surface; then the geometric normal is used.
                let below = direction.dot(ng).le(zero);
                if below.any() {
                    direction = Vec3x8::select(below, d - ng * (two * d.dot(ng)), direction);
                }
                let origin = if self.integrator.epsilon > 0.0 {
                    Vec3x8::load(simd, &b.p)
                } else {
                    b.leave_wide(simd, direction)
                };
                origin.store(&mut out.origin);
                direction.store(&mut out.direction);
            }
        }
    }
}

/// Evaluates a light without [`Uniform`] point by point.
pub(super) fn illuminate_points(
    light: &Light,
    i: u32,
    points: &[PointBlock],
    terms: &mut [TermBlock],
    mut jitter: impl FnMut(usize) -> crate::math::DVec2,
) {
    for (block, (b, out)) in points.iter().zip(terms).enumerate() {
        out.active = 0;
        for lane in (0..LANES).filter(|lane| b.shaded >> lane & 1 == 1) {
            let p = super::points::get(&b.p, lane);
            let Some(lit) = light.illuminate(p, i, jitter(block * LANES + lane)) else { continue };
            out.active |= 1 << lane;
            set(&mut out.to_light, lane, lit.to_light);
            out.intensity.set(lane, lit.intensity);
        }
    }
}
