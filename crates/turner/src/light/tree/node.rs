//! A node of the light tree: the bounds of four children side by side, and their importance at a point.

use super::Receiver;
use crate::material::GlossyLobe;

/// Children per node.
pub(crate) const WIDTH: usize = 4;

/// Marks a child that is a light.
pub(super) const LEAF: u32 = 1 << 31;

/// Importance is 0 only where a cosine is below −MARGIN: rounding in single precision must not cut off a light.
const MARGIN: f32 = 1e-3;

/// The bounds of four children, in tree space. Unused children have no power.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Node {
    /// Centres of the bounding spheres, by coordinate.
    pub(super) center: [[f32; WIDTH]; 3],
    pub(super) radius: [f32; WIDTH],
    /// Axes of the emission cones, by coordinate.
    pub(super) axis: [[f32; WIDTH]; 3],
    pub(super) cos_o: [f32; WIDTH],
    pub(super) cos_e: [f32; WIDTH],
    /// −1 for two-sided emitters, else 1.
    pub(super) back: [f32; WIDTH],
    pub(super) power: [f32; WIDTH],
    /// The index of a node, or of a light with [`LEAF`].
    pub(super) child: [u32; WIDTH],
}

/// The cosine of max(0, α − β), from the cosines and sines of both.
#[inline(always)]
fn cos_less(cos_a: f32, sin_a: f32, cos_b: f32, sin_b: f32) -> f32 {
    if cos_a >= cos_b { 1.0 } else { cos_a * cos_b + sin_a * sin_b }
}

/// The sine of max(0, α − β).
#[inline(always)]
fn sin_less(cos_a: f32, sin_a: f32, cos_b: f32, sin_b: f32) -> f32 {
    if cos_a >= cos_b { 0.0 } else { sin_a * cos_b - cos_a * sin_b }
}

#[inline(always)]
fn sine(cos: f32) -> f32 {
    (1.0 - cos * cos).max(0.0).sqrt()
}

impl Node {
    /// The importance of each child at the point `p`: about the most light that it can contribute there, 0 only where
    /// nothing arrives (Conty Estevez and Kulla 2018, eq. 3):
    ///
    /// ```text
    ///         axis                       importance = power · cos θ' · cos θi' / d²
    ///    θo \  |                         θ'  = max(0, θ − θo − θu), 0 beyond θe
    ///        \ |  θ                      θi' = max(0, θi − θu)
    ///         (o)---___                  θ  between the axis and the direction to p
    ///        sphere d  ---___  θu        θu half angle of the sphere seen from p
    ///                    ___---p         θi between the normal n and the direction to the centre
    ///                     θi  |
    ///                         n
    /// ```
    ///
    /// The factor cos θi' is omitted if `n` is 0. A glossy surface multiplies the importance by what its lobe
    /// reflects: see [`Node::reflected`].
    ///
    /// The nearest of many lights in a sphere contribute more than average, so if the point is in the sphere or close
    /// to it, the squared distance to the centre is reduced: d² − r²/4, at least r²/4. For lights on a ceiling, in a
    /// slab and along a street, this has a third to a thirteenth of the variance that max(d², r²) has.
    #[inline]
    pub(super) fn importance(&self, p: [f32; 3], at: &Receiver) -> [f32; WIDTH] {
        let n = at.n;
        let mut out = [0.0; WIDTH];
        let everywhere = n == [0.0; 3];
        for (i, out) in out.iter_mut().enumerate() {
            let seen = self.seen(i, p);
            let Seen { dx, dy, dz, d2, per_distance, sin_u, cos_u } = seen;
            let r2 = self.radius[i] * self.radius[i];
            let cos_w = -(self.axis[0][i] * dx + self.axis[1][i] * dy + self.axis[2][i] * dz) * per_distance;
            let cos_w = cos_w.max(cos_w * self.back[i]).clamp(-1.0, 1.0);
            let (sin_w, cos_o) = (sine(cos_w), self.cos_o[i]);
            let sin_o = sine(cos_o);
            let cos_x = cos_less(cos_w, sin_w, cos_o, sin_o);
            let sin_x = sin_less(cos_w, sin_w, cos_o, sin_o);
            let cos_x = cos_less(cos_x, sin_x, cos_u, sin_u);
            let leaves = if cos_x < self.cos_e[i] - MARGIN { 0.0 } else { cos_x.max(MARGIN) };
            let cos_i = ((n[0] * dx + n[1] * dy + n[2] * dz) * per_distance).clamp(-1.0, 1.0);
            let cos_i = cos_less(cos_i, sine(cos_i), cos_u, sin_u);
            let arrives = if cos_i < -MARGIN { 0.0 } else { cos_i.max(MARGIN) };
            let arrives = if everywhere { 1.0 } else { arrives };
            let d2 = (d2 - 0.25 * r2).max(0.25 * r2).max(f32::MIN_POSITIVE);
            *out = self.power[i] * leaves * arrives / d2;
        }
        if at.lobe.peak > 0.0 {
            for (out, reflected) in out.iter_mut().zip(self.reflected(p, &at.lobe)) {
                *out *= reflected;
            }
        }
        out
    }

    /// A child's sphere as the point `p` sees it.
    #[inline(always)]
    fn seen(&self, i: usize, p: [f32; 3]) -> Seen {
        let (dx, dy, dz) = (self.center[0][i] - p[0], self.center[1][i] - p[1], self.center[2][i] - p[2]);
        let d2 = dx * dx + dy * dy + dz * dz;
        let radius = self.radius[i];
        let r2 = radius * radius;
        let per_distance = 1.0 / d2.max(r2).max(f32::MIN_POSITIVE).sqrt();
        // From inside, the sphere fills all directions.
        let inside = d2 <= r2;
        let sin_u = radius * per_distance;
        let cos_u = (1.0 - sin_u * sin_u).max(0.0).sqrt();
        let (sin_u, cos_u) = if inside { (0.0, -1.0) } else { (sin_u, cos_u) };
        Seen { dx, dy, dz, d2, per_distance, sin_u, cos_u }
    }

    /// How many times more light a glossy surface at `p` reflects from each child than it does without its lobe: the
    /// lobe's value in the direction of the sphere nearest to its axis, times the fraction of the sphere that the lobe
    /// covers. Without that fraction, a large lamp in a narrow highlight, or two lamps on both sides of it, would take
    /// all samples from the lights that only the diffuse base reflects.
    #[inline]
    fn reflected(&self, p: [f32; 3], lobe: &GlossyLobe) -> [f32; WIDTH] {
        let mut out = [1.0; WIDTH];
        let [x, y, z] = lobe.axis;
        for (i, out) in out.iter_mut().enumerate() {
            let Seen { dx, dy, dz, per_distance, sin_u, cos_u, .. } = self.seen(i, p);
            let cos_l = ((x * dx + y * dy + z * dz) * per_distance).clamp(-1.0, 1.0);
            let cos_l = cos_less(cos_l, sine(cos_l), cos_u, sin_u);
            // 1 / (1 + tan² · tightness) with tan² of half the angle: that is how far the microfacet normals are rotated.
            let whole = (1.0 + cos_l).max(1e-6);
            let spread = whole / (whole + (1.0 - cos_l) * lobe.tightness);
            // The solid angle 4π α² of the lobe over 2π (1 − cos θu) of the sphere.
            let span = if cos_u > 0.0 { sin_u * sin_u / (1.0 + cos_u) } else { 1.0 - cos_u };
            let covered = (2.0 / (lobe.tightness * span).max(f32::MIN_POSITIVE)).min(1.0);
            *out = 1.0 + lobe.peak * spread * spread * covered;
        }
        out
    }
}

/// A sphere as a point sees it.
struct Seen {
    /// From the point to its centre, and the squared distance.
    dx: f32,
    dy: f32,
    dz: f32,
    d2: f32,
    per_distance: f32,
    /// Sine and cosine of half the angle that it fills, θu.
    sin_u: f32,
    cos_u: f32,
}
