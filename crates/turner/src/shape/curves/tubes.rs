//! Curves as triangles, for formats without curves.

use super::Curves;
use super::cubic::Cubic;
use crate::math::DVec3;
use crate::math::elementary::sin_cos_turns;
use crate::schema::MeshData;

/// Sides of a tube.
const SIDES: u32 = 6;
/// Rings of a segment.
const RINGS: u32 = 4;
/// Most triangles of all tubes; more curves are not converted.
pub const MAX_TRIANGLES: u64 = 20_000_000;

impl Curves {
    /// Number of triangles of [`Curves::tubes`].
    pub fn triangles(&self) -> u64 {
        self.count() as u64 * u64::from(2 * SIDES * RINGS)
    }

    /// Each segment as a tube with six sides, open at both ends; `None` if they have more than [`MAX_TRIANGLES`]. (u, v) are
    /// along and around the curve.
    pub fn tubes(&self) -> Option<MeshData> {
        if self.triangles() > MAX_TRIANGLES {
            return None;
        }
        let mut data = MeshData::default();
        let mut side = DVec3::ZERO;
        for segment in 0..self.count() as u32 {
            let cubic = self.cubic(segment);
            if !cubic.p.iter().all(|p| p.is_finite()) {
                continue;
            }
            let first = data.positions.len() as u32;
            for ring in 0..=RINGS {
                self.ring(segment, &cubic, f64::from(ring) / f64::from(RINGS), &mut side, &mut data);
            }
            for ring in 0..RINGS {
                for i in 0..SIDES {
                    let [a, b] = [i, (i + 1) % SIDES].map(|i| first + ring * SIDES + i);
                    let [c, d] = [a + SIDES, b + SIDES];
                    for triangle in [[a, b, d], [a, d, c]] {
                        // At a tip the points coincide.
                        let [p, q, r] = triangle.map(|i| data.positions[i as usize]);
                        if p != q && q != r && r != p {
                            data.triangles.push(triangle);
                        }
                    }
                }
            }
        }
        Some(data)
    }

    /// Adds one ring. `side` is carried from ring to ring, which avoids twist.
    fn ring(&self, segment: u32, cubic: &Cubic, t: f64, side: &mut DVec3, data: &mut MeshData) {
        let along = cubic.direction(t);
        *side = (*side - along * side.dot(along))
            .try_normalize()
            .unwrap_or_else(|| along.any_orthonormal_vector());
        let up = along.cross(*side);
        let at = cubic.at(t);
        let hit = crate::shape::ShapeHit { t: 0.0, part: segment, u: t, v: 0.0 };
        let u = self.uv(&hit).x as f32;
        let single = |v: DVec3| v.as_vec3().to_array();
        for i in 0..SIDES {
            let turn = f64::from(i) / f64::from(SIDES);
            let (s, c) = sin_cos_turns(turn);
            let out = *side * c + up * s;
            data.positions.push(single(at.c + out * at.r));
            data.normals.push(single(out));
            data.uvs.push([u, turn as f32]);
            if let Some(color) = self.color(&hit) {
                data.colors.push(color);
            }
        }
    }
}
