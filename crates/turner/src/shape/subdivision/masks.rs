//! The weights of neighbours: of the next level, and of the limit (Halstead, Kass and DeRose 1993; Biermann, Levin and
//! Zorin 2000).

use super::SubdivisionScheme;
use crate::math::DVec3;
use crate::math::elementary::{cos, sin_cos};

/// The sharpness one level later.
pub(super) fn child(sharp: f32) -> f32 {
    (sharp - 1.0).max(0.0)
}

/// The weight of each of n neighbours of a vertex in Loop's scheme, as pbrt has it (Warren 1995).
pub(super) fn loop_beta(n: u32) -> f64 {
    if n == 3 { 3.0 / 16.0 } else { 3.0 / (8.0 * f64::from(n)) }
}

/// The edges and faces around a vertex.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Around {
    /// The number of edges.
    pub(super) edges: u32,
    /// Sum of their other ends.
    pub(super) ends: DVec3,
    /// Sum of one point of each face: its face point (the mean of its corners), or the opposite corner of a quadrilateral.
    pub(super) faces: DVec3,
    /// The number of edges that are sharp on this level, and on the next one, and the sums of their other ends.
    sharp: [(u32, DVec3); 2],
    /// Edges that are sharp on this level only: their number, and the sum of their sharpness.
    fading: (u32, f64),
}

/// How a vertex moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Rule {
    Smooth,
    /// Along the curve of two sharp edges.
    Crease,
    /// Not at all.
    Corner,
}

impl Around {
    pub(super) fn add_edge(&mut self, end: DVec3, sharp: f32) {
        self.edges += 1;
        self.ends += end;
        for (level, least) in [0.0, 1.0].into_iter().enumerate() {
            if sharp > least {
                self.sharp[level].0 += 1;
                self.sharp[level].1 += end;
            }
        }
        if sharp > 0.0 && sharp <= 1.0 {
            self.fading.0 += 1;
            self.fading.1 += f64::from(sharp);
        }
    }

    pub(super) fn add_face(&mut self, point: DVec3) {
        self.faces += point;
    }

    /// The rule on this level (0) or the next one (1). A single sharp edge ends at a smooth vertex.
    pub(super) fn rule(&self, level: usize, corner: f32) -> Rule {
        match self.sharp[level].0 {
            _ if corner > level as f32 || self.edges == 0 => Rule::Corner,
            0 | 1 => Rule::Smooth,
            2 => Rule::Crease,
            _ => Rule::Corner,
        }
    }

    /// Where a vertex at `p` is on the next level. While sharpness fades below 1, between the two rules.
    pub(super) fn moved(&self, p: DVec3, corner: f32, smooth: impl Fn() -> DVec3) -> DVec3 {
        let by = |level: usize, rule: Rule| match rule {
            Rule::Smooth => smooth(),
            Rule::Crease => 0.75 * p + 0.125 * self.sharp[level].1,
            Rule::Corner => p,
        };
        let [now, next] = [0, 1].map(|level| self.rule(level, corner));
        if now == next {
            return by(0, now);
        }
        let (mut count, mut sum) = self.fading;
        if corner > 0.0 && corner <= 1.0 {
            count += 1;
            sum += f64::from(corner);
        }
        by(1, next).lerp(by(0, now), sum / f64::from(count.max(1)))
    }

    /// The new place of a smooth vertex by Catmull–Clark.
    pub(super) fn catmull_clark(&self, p: DVec3) -> DVec3 {
        let n = f64::from(self.edges);
        p * ((n - 2.0) / n) + (self.ends + self.faces) / (n * n)
    }

    /// The limit of a vertex at `p`. Edges that are still sharp count as sharp for ever; for Catmull–Clark `faces` are
    /// the opposite corners.
    pub(super) fn limit(&self, p: DVec3, corner: f32, scheme: SubdivisionScheme) -> DVec3 {
        let n = f64::from(self.edges);
        match (self.rule(0, corner), scheme) {
            (Rule::Corner, _) => p,
            (Rule::Crease, _) => (4.0 * p + self.sharp[0].1) / 6.0,
            (Rule::Smooth, SubdivisionScheme::CatmullClark) => {
                (n * n * p + 4.0 * self.ends + self.faces) / (n * (n + 5.0))
            }
            (Rule::Smooth, SubdivisionScheme::Loop) => {
                let gamma = 1.0 / (n + 3.0 / (8.0 * loop_beta(self.edges)));
                p * (1.0 - n * gamma) + self.ends * gamma
            }
        }
    }
}

/// A normal of the limit surface at a smooth vertex: `edges` are the other ends of its edges in counter-clockwise order,
/// `faces` the opposite corners of the quadrilaterals between each edge and the next.
pub(super) fn smooth_normal(edges: &[DVec3], faces: &[DVec3], scheme: SubdivisionScheme) -> DVec3 {
    let step = std::f64::consts::TAU / edges.len() as f64;
    let c = cos(step);
    let weight = 1.0 + c + cos(0.5 * step) * (2.0 * (9.0 + c)).sqrt();
    let (mut s, mut t) = (DVec3::ZERO, DVec3::ZERO);
    for (i, edge) in edges.iter().enumerate() {
        let (sin, cos) = sin_cos(step * i as f64);
        match (scheme, faces.get(i)) {
            (SubdivisionScheme::CatmullClark, Some(face)) => {
                let (next_sin, next_cos) = sin_cos(step * (i + 1) as f64);
                s += weight * cos * *edge + (cos + next_cos) * *face;
                t += weight * sin * *edge + (sin + next_sin) * *face;
            }
            _ => {
                s += cos * *edge;
                t += sin * *edge;
            }
        }
    }
    s.cross(t)
}

/// A normal at a border or crease: the first and the last of `edges` run along it.
pub(super) fn crease_normal(p: DVec3, edges: &[DVec3], faces: &[DVec3], scheme: SubdivisionScheme) -> DVec3 {
    let (Some(first), Some(last)) = (edges.first(), edges.last()) else { return DVec3::ZERO };
    let (along, both) = (*first - *last, *first + *last);
    let k = edges.len() - 1;
    let inner = edges.get(1..k).unwrap_or_default();
    let step = std::f64::consts::PI / k as f64;
    let at = |i: usize| sin_cos(step * i as f64).0;
    let (sin, cos) = sin_cos(step);
    let waves = inner.iter().enumerate().map(|(i, e)| at(i + 1) * *e).sum::<DVec3>();
    let across = match (scheme, k) {
        (_, 0 | 1) => both - 2.0 * p,
        (SubdivisionScheme::CatmullClark, _) => {
            let r = (cos + 1.0) / sin;
            let faces = faces.iter().enumerate().map(|(i, f)| (at(i) + at(i + 1)) * *f).sum::<DVec3>();
            4.0 * r * (cos - 1.0) * p - r * (1.0 + 2.0 * cos) * both + 4.0 * waves + faces
        }
        // The left eigenvector of the rules above for the eigenvalue 3/8 + cos(π/k)/4, with the weights sin(iπ/k) inside.
        (SubdivisionScheme::Loop, _) => {
            let (d, sum) = ((2.0 * cos - 1.0) / 8.0, (1.0 + cos) / sin);
            let own = (sin + 3.0 * sum * d) / ((4.0 * d + 1.0) * (2.0 * d - 1.0));
            own * p + (own * (d - 0.25) - 0.375 * sum) * both + waves
        }
    };
    along.cross(across)
}
