//! Boxes that hold every hit of an instance.
//!
//! Let M take points of the object to the group, W be its inverse as it is used (rounded), and a ray hit the object at t, by
//! the arithmetic of the object: the point `o' + t d'` then lies within a *slack* of a point p in the object's box. The
//! question is how far `x = o + t d` may lie from M p, because the tree above looks for x. As `x = M (W' x)` with the exact
//! inverse W',
//!
//! ```text
//! x - M p = M ( (W' x - (o' + t d')) + (o' + t d' - p) )
//! ```
//!
//! Write A for the largest coordinate of o, R for that of x, u = 2^-24, e = 2 u; `s_k` for the sum of row k of |W|, s for
//! the largest of them, `w_k` for its translation's size, w for the largest, T for the size of M's translation. In row k,
//!
//! - rounding o' (four operations): 4 u (`s_k` A + `w_k`)
//! - rounding d' (three), with |t d| <= R + A: 3 u `s_k` (R + A)
//! - rounding W to single precision: u (`s_k` R + `w_k`)
//! - computing W in double precision: 2^-30 s (R + T), for a matrix whose condition is below 10^6
//! - the slack: e (alpha A' + beta), where A' <= s A + w is the largest coordinate of o'. For a triangle tree, alpha is
//!   [`PADDING`] and beta is that times the reach of the tree. For a group, alpha is larger by its `far_padding`.
//!
//! Multiplied by |M| this is, for each axis of the group, `base + by_reach R + by_origin A`. The part with A <= R goes into
//! the box of the instance. For rays from farther away, the tree's rays are padded by `by_origin (A - R)` more, that of the
//! worst instance: [`Space::far_padding`](crate::traverse::Space). R itself is the largest coordinate of all padded boxes,
//! `R >= (size + base) / (1 - by_reach - by_origin)` for each. Instances for which that sum exceeds 1/4 (their inverse is so
//! badly conditioned that a hit's place is mostly rounding) have no box; every ray meets them.
//!
//! A moving transform is `M(time) = (1 - time) M0 + time M1`: the box around both ends' boxes holds every point of it. What
//! its inverse may become is bounded on short intervals around their middles: with `q = |W_m| |M - M_m|` and all row sums of
//! q below 1/2, `|W| <= |W_m| + q s / (1 - q)` in rows. Where that fails even on short intervals (the transform turns
//! inside out on its way) there is no box either.

use super::matrix::{Affine, Affine64, between, inverse64, rounded, scaled};
use crate::Aabb;
use crate::traverse::PADDING;

const U: f64 = 1.01 / (1 << 24) as f64;
const E: f64 = 2.0 * U;
/// What double precision leaves of an inverse.
const FUZZ: f64 = 1.0 / (1 << 30) as f64;

/// What an object takes up: its box, and how far from it a hit may lie by its own arithmetic, in units of `f32::EPSILON`: `alpha`
/// times the largest coordinate of the ray's origin, plus `beta`. Without a box, every ray has to be tried.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    pub(super) bounds: Option<Aabb>,
    pub(super) alpha: f64,
    pub(super) beta: f64,
}

impl Extent {
    /// Of a tree with the given reach, in the units outside.
    pub(super) fn new(bounds: Option<Aabb>, reach: f64, far_padding: f64) -> Extent {
        let padding = f64::from(PADDING);
        Extent { bounds, alpha: padding + far_padding, beta: padding * reach }
    }
}

/// How an instance is placed.
#[derive(Clone, Copy, Debug)]
pub(super) enum Place<'a> {
    Still(&'a Affine),
    Moving(&'a Affine, &'a Affine),
}

/// Where an instance's hits may be, in the units of the group's tree.
#[derive(Clone, Copy, Debug)]
pub(super) enum Reach {
    /// Nowhere: there is no inverse, or the object is empty.
    Nowhere,
    /// Anywhere.
    Anywhere,
    /// In a box, and so much around it: `base`, and parts of the group's reach and of how far away rays start.
    Box { min: [f64; 3], max: [f64; 3], base: [f64; 3], by_reach: [f64; 3], by_origin: [f64; 3] },
}

impl Reach {
    pub(super) fn new(place: Place<'_>, object: &Extent, scale: f64) -> Reach {
        let (m0, m1) = match place {
            Place::Still(m) => (m, m),
            Place::Moving(a, b) => (a, b),
        };
        if !m0.iter().chain(m1).flatten().all(|x| x.is_finite()) {
            return Reach::Nowhere;
        }
        let ends = [m0, m1].map(|m| scaled(&m.map(|row| row.map(f64::from)), scale));
        let row_sums = match place {
            Place::Still(_) => {
                let Some(w) = inverse64(&ends[0]).filter(|w| rounded(w).is_some()) else {
                    return Reach::Nowhere;
                };
                Some(sums(&w))
            }
            Place::Moving(..) => moving_sums(m0, m1, scale, 0.0, 1.0),
        };
        let Some(bounds) = object.bounds else { return Reach::Anywhere };
        if bounds == Aabb::EMPTY {
            return Reach::Nowhere;
        }
        let Some(s) = row_sums else { return Reach::Anywhere };
        // |M| and |T|, at any time.
        let size = |i: usize, j: usize| ends[0][i][j].abs().max(ends[1][i][j].abs());
        let t = (0..3).map(|i| size(i, 3)).fold(0.0, f64::max);
        // |W M_translation|: known from the rows.
        let w = s.map(|s| s * t);
        let (s_max, w_max) = (s[0].max(s[1]).max(s[2]), w[0].max(w[1]).max(w[2]));
        let (mut base, mut by_reach, mut by_origin) = ([0.0; 3], [0.0; 3], [0.0; 3]);
        for i in 0..3 {
            for k in 0..3 {
                let m = size(i, k);
                base[i] += m * (5.0 * U * w[k] + FUZZ * s_max * t + E * (object.alpha * w_max + object.beta));
                by_reach[i] += m * (4.0 * U * s[k] + FUZZ * s_max);
                by_origin[i] += m * (7.0 * U * s[k] + E * object.alpha * s_max);
            }
        }
        let sure = (0..3).all(|i| by_reach[i] + by_origin[i] <= 0.25 && base[i].is_finite());
        // Beyond these, numbers may underflow.
        if !sure || !(1e-30..1e30).contains(&s_max) {
            return Reach::Anywhere;
        }
        let (mut min, mut max) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for m in &ends {
            let (low, high) = placed(m, bounds);
            for i in 0..3 {
                min[i] = low[i].min(min[i]);
                max[i] = high[i].max(max[i]);
            }
        }
        Reach::Box { min, max, base, by_reach, by_origin }
    }

    /// The least reach of a group that holds it.
    pub(super) fn needed(&self) -> f64 {
        let Reach::Box { min, max, base, by_reach, by_origin } = self else { return 0.0 };
        let along =
            (0..3).map(|i| (min[i].abs().max(max[i].abs()) + base[i]) / (1.0 - by_reach[i] - by_origin[i]));
        along.fold(0.0, f64::max)
    }

    /// The padding of far rays it needs, in units of `f32::EPSILON`.
    pub(super) fn far_padding(&self) -> f64 {
        let Reach::Box { by_origin, .. } = self else { return 0.0 };
        by_origin.iter().fold(0.0_f64, |a, &b| a.max(b)) / f64::from(f32::EPSILON)
    }

    /// The box, in a group of a reach.
    pub(super) fn padded(&self, reach: f64) -> Option<Aabb> {
        let Reach::Box { min, max, base, by_reach, by_origin } = self else { return None };
        let pad: [f64; 3] = std::array::from_fn(|i| base[i] + (by_reach[i] + by_origin[i]) * reach);
        let outward =
            Aabb::outward(std::array::from_fn(|i| min[i] - pad[i]), std::array::from_fn(|i| max[i] + pad[i]));
        outward.is_valid().then_some(outward)
    }
}

/// The box of a box, up to rounding in double precision.
fn placed(m: &Affine64, bounds: Aabb) -> ([f64; 3], [f64; 3]) {
    let half: [f64; 3] = std::array::from_fn(|i| 0.5 * (f64::from(bounds.max[i]) - f64::from(bounds.min[i])));
    let middle: [f64; 3] =
        std::array::from_fn(|i| 0.5 * (f64::from(bounds.max[i]) + f64::from(bounds.min[i])));
    let at = m.map(|[x, y, z, w]| x * middle[0] + y * middle[1] + z * middle[2] + w);
    let around = m.map(|[x, y, z, _]| x.abs() * half[0] + y.abs() * half[1] + z.abs() * half[2]);
    (std::array::from_fn(|i| at[i] - around[i]), std::array::from_fn(|i| at[i] + around[i]))
}

/// The sums of the rows, without signs.
fn sums(w: &Affine64) -> [f64; 3] {
    w.map(|[x, y, z, _]| x.abs() + y.abs() + z.abs())
}

/// Bounds of the sums at all times between two.
fn moving_sums(m0: &Affine, m1: &Affine, scale: f64, from: f64, to: f64) -> Option<[f64; 3]> {
    let middle = scaled(&between(m0, m1, (0.5 * (from + to)) as f32), scale);
    let half = 0.5 * (to - from) * scale;
    if let Some(w) = inverse64(&middle) {
        let s = sums(&w);
        let s_max = s[0].max(s[1]).max(s[2]);
        // The largest change of M, by column.
        let q: [f64; 3] = std::array::from_fn(|k| {
            let along = |j: usize| -> f64 {
                (0..3).map(|i| w[k][i].abs() * half * (f64::from(m1[i][j]) - f64::from(m0[i][j])).abs()).sum()
            };
            along(0) + along(1) + along(2)
        });
        let q_max = q[0].max(q[1]).max(q[2]);
        if q_max < 0.5 {
            return Some(std::array::from_fn(|k| s[k] + q[k] * s_max / (1.0 - q_max)));
        }
    }
    if to - from < 1.0 / 128.0 {
        return None;
    }
    let between = 0.5 * (from + to);
    let first = moving_sums(m0, m1, scale, from, between)?;
    let second = moving_sums(m0, m1, scale, between, to)?;
    Some(std::array::from_fn(|k| first[k].max(second[k])))
}
