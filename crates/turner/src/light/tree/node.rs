//! Four bounds side by side, and what they may bring to a point.

use super::Receiver;
use crate::material::GlossyLobe;

/// Children of a node.
pub(crate) const WIDTH: usize = 4;

/// Marks a child that is a light.
pub(super) const LEAF: u32 = 1 << 31;

/// Cosines count as 0 only below this: single precision and the bounds' rounding must not put a light out.
const MARGIN: f32 = 1e-3;

/// The bounds of four children, in the tree's own space; those that are none have no power.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Node {
    /// The middles of their spheres, by coordinate.
    pub(super) center: [[f32; WIDTH]; 3],
    pub(super) radius: [f32; WIDTH],
    /// The axes of their cones, by coordinate.
    pub(super) axis: [[f32; WIDTH]; 3],
    pub(super) cos_o: [f32; WIDTH],
    pub(super) cos_e: [f32; WIDTH],
    /// −1 for those that shine on both sides, else 1.
    pub(super) back: [f32; WIDTH],
    pub(super) power: [f32; WIDTH],
    /// The number of a node, or of a light with [`LEAF`].
    pub(super) child: [u32; WIDTH],
}

/// The cosine of max(0, α − β), by the cosines and sines of both.
#[inline(always)]
fn cos_less(cos_a: f32, sin_a: f32, cos_b: f32, sin_b: f32) -> f32 {
    if cos_a >= cos_b { 1.0 } else { cos_a * cos_b + sin_a * sin_b }
}

/// The sine of that.
#[inline(always)]
fn sin_less(cos_a: f32, sin_a: f32, cos_b: f32, sin_b: f32) -> f32 {
    if cos_a >= cos_b { 0.0 } else { sin_a * cos_b - cos_a * sin_b }
}

#[inline(always)]
fn sine(cos: f32) -> f32 {
    (1.0 - cos * cos).max(0.0).sqrt()
}

impl Node {
    /// About the most that each child brings to the point `p` of a surface with the normal `n`, or with light from everywhere if that is 0:
    /// power · cos θ' · cos θi' / d² (Conty Estevez and Kulla 2018, eq. 3). 0 only where nothing arrives.
    ///
    /// Of many lights in a sphere the nearest bring more than their share, so that its middle counts as nearer than it is where the point is in it or close
    /// by: d² − r²/4, at least r²/4. For lights on a ceiling, in a slab and along a street that left a third to a
    /// thirteenth of the variance that d², at least r², had.
    ///
    /// Glossy surfaces multiply that by what they reflect from the direction of the sphere that is nearest to their lobe's axis.
    #[inline]
    pub(super) fn importance(&self, p: [f32; 3], at: &Receiver) -> [f32; WIDTH] {
        let n = at.n;
        let mut out = [0.0; WIDTH];
        let everywhere = n == [0.0; 3];
        for (i, out) in out.iter_mut().enumerate() {
            let (dx, dy, dz) = (self.center[0][i] - p[0], self.center[1][i] - p[1], self.center[2][i] - p[2]);
            let d2 = dx * dx + dy * dy + dz * dz;
            let r2 = self.radius[i] * self.radius[i];
            let near2 = d2.max(r2).max(f32::MIN_POSITIVE);
            let per_distance = 1.0 / near2.sqrt();
            // The angle that the sphere fills; inside all directions are there.
            let inside = d2 <= r2;
            let sin2_u = r2 / near2;
            let (sin_u, cos_u) =
                if inside { (0.0, -1.0) } else { (sin2_u.sqrt(), (1.0 - sin2_u).max(0.0).sqrt()) };
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

    /// How many times as much light as without its lobe a glossy surface at `p` reflects from each child.
    #[inline]
    fn reflected(&self, p: [f32; 3], lobe: &GlossyLobe) -> [f32; WIDTH] {
        let mut out = [1.0; WIDTH];
        let [x, y, z] = lobe.axis;
        for (i, out) in out.iter_mut().enumerate() {
            let (dx, dy, dz) = (self.center[0][i] - p[0], self.center[1][i] - p[1], self.center[2][i] - p[2]);
            let d2 = dx * dx + dy * dy + dz * dz;
            let r2 = self.radius[i] * self.radius[i];
            let sin2_u = r2 / d2.max(f32::MIN_POSITIVE);
            let cos_l = ((x * dx + y * dy + z * dz) / d2.max(f32::MIN_POSITIVE).sqrt()).clamp(-1.0, 1.0);
            let cos_l = cos_less(cos_l, sine(cos_l), (1.0 - sin2_u).max(0.0).sqrt(), sin2_u.min(1.0).sqrt());
            let cos_l = if d2 <= r2 { 1.0 } else { cos_l };
            // Facets are turned by half the angle.
            let tan2 = (1.0 - cos_l) / (1.0 + cos_l).max(1e-6);
            let flat_triangles = 1.0 / (1.0 + tan2 * lobe.tightness);
            *out = 1.0 + lobe.peak * flat_triangles * flat_triangles;
        }
        out
    }
}
