//! A node of the light tree: the bounds of eight children side by side, and their importance at a point.

use turner_bvh::lanes::{Block32, F32x8, LANES, Mask8, Simd};

use super::Receiver;

/// Children per node.
pub(crate) const WIDTH: usize = LANES;

/// Marks a child that is a light.
pub(super) const LEAF: u32 = 1 << 31;

/// Importance is 0 only where a cosine is below −MARGIN: rounding in single precision must not cut off a light.
const MARGIN: f32 = 1e-3;

/// The bounds of eight children, in tree space. Unused children have no power.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Node {
    /// Centres of the bounding spheres, by coordinate.
    pub(super) center: [Block32; 3],
    pub(super) radius: Block32,
    /// Axes of the emission cones, by coordinate.
    pub(super) axis: [Block32; 3],
    pub(super) cos_o: Block32,
    pub(super) cos_e: Block32,
    /// −1 for two-sided emitters, else 1.
    pub(super) back: Block32,
    pub(super) power: Block32,
    /// The index of a node, or of a light with [`LEAF`].
    pub(super) child: [u32; WIDTH],
}

/// A point to be lit, in every lane.
#[derive(Clone, Copy)]
pub(super) struct LitPoint<S: Simd> {
    simd: S,
    p: Lanes3<S>,
    /// The normal, if only light on its side counts.
    n: Option<Lanes3<S>>,
    lobe: Option<Lobe<S>>,
}

#[derive(Clone, Copy)]
struct Lobe<S: Simd> {
    axis: Lanes3<S>,
    tightness: F32x8<S>,
    peak: F32x8<S>,
}

#[derive(Clone, Copy)]
struct Lanes3<S: Simd>([F32x8<S>; 3]);

impl<S: Simd> Lanes3<S> {
    #[inline(always)]
    fn splat(simd: S, v: [f32; 3]) -> Self {
        Lanes3(v.map(|v| F32x8::splat(simd, v)))
    }

    #[inline(always)]
    fn load(simd: S, [x, y, z]: &[Block32; 3]) -> Self {
        Lanes3([F32x8::load(simd, x), F32x8::load(simd, y), F32x8::load(simd, z)])
    }

    #[inline(always)]
    fn minus(self, o: Self) -> Self {
        Lanes3([self.0[0] - o.0[0], self.0[1] - o.0[1], self.0[2] - o.0[2]])
    }

    #[inline(always)]
    fn dot(self, o: Self) -> F32x8<S> {
        self.0[0] * o.0[0] + self.0[1] * o.0[1] + self.0[2] * o.0[2]
    }
}

impl<S: Simd> LitPoint<S> {
    /// A receiver at the point `p` of tree space.
    #[inline(always)]
    pub(super) fn new(simd: S, p: [f32; 3], at: &Receiver) -> Self {
        let lobe = (at.lobe.peak > 0.0).then(|| Lobe {
            axis: Lanes3::splat(simd, at.lobe.axis),
            tightness: F32x8::splat(simd, at.lobe.tightness),
            peak: F32x8::splat(simd, at.lobe.peak),
        });
        let n = (at.n != [0.0; 3]).then(|| Lanes3::splat(simd, at.n));
        LitPoint { simd, p: Lanes3::splat(simd, p), n, lobe }
    }

    #[inline(always)]
    fn splat(&self, v: f32) -> F32x8<S> {
        F32x8::splat(self.simd, v)
    }

    /// The sine of an angle from its cosine.
    #[inline(always)]
    fn sine(&self, cos: F32x8<S>) -> F32x8<S> {
        (self.splat(1.0) - cos * cos).or_larger(self.splat(0.0)).sqrt()
    }

    #[inline(always)]
    fn cosine(&self, v: F32x8<S>) -> F32x8<S> {
        v.or_larger(self.splat(-1.0)).or_smaller(self.splat(1.0))
    }

    /// The cosine of max(0, α − β), from the cosines and sines of both.
    #[inline(always)]
    fn cos_less(
        &self,
        (cos_a, sin_a): (F32x8<S>, F32x8<S>),
        (cos_b, sin_b): (F32x8<S>, F32x8<S>),
    ) -> F32x8<S> {
        cos_a.lt(cos_b).select32(cos_a * cos_b + sin_a * sin_b, self.splat(1.0))
    }

    /// The sine of max(0, α − β).
    #[inline(always)]
    fn sin_less(
        &self,
        (cos_a, sin_a): (F32x8<S>, F32x8<S>),
        (cos_b, sin_b): (F32x8<S>, F32x8<S>),
    ) -> F32x8<S> {
        cos_a.lt(cos_b).select32(sin_a * cos_b - cos_a * sin_b, self.splat(0.0))
    }
}

impl Node {
    /// The importance of each child at a point: about the light that it contributes there, 0 only where nothing arrives
    /// (Conty Estevez and Kulla 2018, eq. 3):
    ///
    /// ```text
    ///         axis                       importance = power · cos θ' · c / d²
    ///    θo \  |                         θ' = max(0, θ − θo − θu), 0 beyond θe
    ///        \ |  θ                      c  = ½ cos max(0, θi − θu) + ½ max(0, cos(θi + θu))
    ///         (o)---___                  θ  between the axis and the direction to p
    ///        sphere d  ---___  θu        θu half angle of the sphere seen from p
    ///                    ___---p         θi between the normal n and the direction to the centre
    ///                     θi  |
    ///                         n
    /// ```
    ///
    /// The factor c is omitted if there is no `n`. It is the mean of the cosines of the nearest and of the farthest
    /// direction: with the nearest alone, groups of lights are chosen too often beside single lights (2 to 7 % more
    /// variance). A glossy surface multiplies the importance by what its lobe reflects: see [`Node::reflected`].
    ///
    /// The nearest of many lights in a sphere contribute more than average, so if the point is in the sphere or close
    /// to it, the squared distance to the centre is reduced: d² − r²/4, at least r²/4. For lights on a ceiling, in a
    /// slab and along a street, this has a third to a thirteenth of the variance that max(d², r²) has.
    #[inline(always)]
    pub(super) fn importance<S: Simd>(&self, at: &LitPoint<S>) -> F32x8<S> {
        let (simd, zero, margin) = (at.simd, at.splat(0.0), at.splat(MARGIN));
        let load = |block: &Block32| F32x8::load(simd, block);
        let seen = self.seen(at);
        let Seen { d, d2, r2, per_distance, half, .. } = seen;
        let cos_w = zero - Lanes3::load(simd, &self.axis).dot(d) * per_distance;
        let cos_w = at.cosine(cos_w.or_larger(cos_w * load(&self.back)));
        let (whole, cone) = ((cos_w, at.sine(cos_w)), load(&self.cos_o));
        let cone = (cone, at.sine(cone));
        let outside = (at.cos_less(whole, cone), at.sin_less(whole, cone));
        let cos_x = at.cos_less(outside, half);
        let leaves = cos_x.lt(load(&self.cos_e) - margin).select32(zero, cos_x.or_larger(margin));
        let quarter = at.splat(0.25) * r2;
        let d2 = (d2 - quarter).or_larger(quarter).or_larger(at.splat(f32::MIN_POSITIVE));
        let mut out = load(&self.power) * leaves;
        if let Some(n) = at.n {
            let cos_i = at.cosine(n.dot(d) * per_distance);
            let sin_i = at.sine(cos_i);
            let (cos_u, sin_u) = half;
            let nearest = at.cos_less((cos_i, sin_i), half);
            let farthest = seen.outside.select32(cos_i * cos_u - sin_i * sin_u, zero).or_larger(zero);
            let mean = at.splat(0.5) * (nearest.or_larger(margin) + farthest);
            out = out * nearest.lt(at.splat(-MARGIN)).select32(zero, mean);
        }
        out = out / d2;
        match &at.lobe {
            Some(lobe) => out * self.reflected(at, &seen, lobe),
            None => out,
        }
    }

    /// The children's spheres as the point sees them.
    #[inline(always)]
    fn seen<S: Simd>(&self, at: &LitPoint<S>) -> Seen<S> {
        let (simd, zero, least) = (at.simd, at.splat(0.0), at.splat(f32::MIN_POSITIVE));
        let d = Lanes3::load(simd, &self.center).minus(at.p);
        let d2 = d.dot(d);
        let radius = F32x8::load(simd, &self.radius);
        let r2 = radius * radius;
        let per_distance = at.splat(1.0) / d2.or_larger(r2).or_larger(least).sqrt();
        // From inside, the sphere fills all directions.
        let outside = r2.lt(d2);
        let sin_u = radius * per_distance;
        let half = (outside.select32(at.sine(sin_u), at.splat(-1.0)), outside.select32(sin_u, zero));
        Seen { d, d2, r2, per_distance, half, outside }
    }

    /// How many times more light a glossy surface at the point reflects from each child than it does without its lobe:
    /// the lobe's value in the direction of the sphere nearest to its axis, times the fraction of the sphere that the
    /// lobe covers. Without that fraction, a large lamp in a narrow highlight, or two lamps on both sides of it, would
    /// take all samples from the lights that only the diffuse base reflects.
    #[inline(always)]
    fn reflected<S: Simd>(&self, at: &LitPoint<S>, seen: &Seen<S>, lobe: &Lobe<S>) -> F32x8<S> {
        let one = at.splat(1.0);
        let Seen { d, per_distance, half, outside, .. } = *seen;
        let cos_l = at.cosine(lobe.axis.dot(d) * per_distance);
        let cos_l = at.cos_less((cos_l, at.sine(cos_l)), half);
        // 1 / (1 + tan² · tightness) with tan² of half the angle: that is how far the microfacet normals are rotated.
        let whole = (one + cos_l).or_larger(at.splat(1e-6));
        let spread = whole / (whole + (one - cos_l) * lobe.tightness);
        // The solid angle 4π α² of the lobe over 2π (1 − cos θu) of the sphere.
        let (cos_u, sin_u) = half;
        let span = outside.select32(sin_u * sin_u / (one + cos_u), one - cos_u);
        let solid = (lobe.tightness * span).or_larger(at.splat(f32::MIN_POSITIVE));
        let covered = (at.splat(2.0) / solid).or_smaller(one);
        one + lobe.peak * spread * spread * covered
    }
}

/// Eight spheres as a point sees them.
#[derive(Clone, Copy)]
struct Seen<S: Simd> {
    /// From the point to the centres.
    d: Lanes3<S>,
    /// Squared distances and radii.
    d2: F32x8<S>,
    r2: F32x8<S>,
    per_distance: F32x8<S>,
    /// Cosine and sine of half the angle that each fills, θu.
    half: (F32x8<S>, F32x8<S>),
    /// Whether the point is outside the sphere.
    outside: Mask8<S>,
}
