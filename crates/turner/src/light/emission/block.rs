//! Sampling of eight emitters of one type at a time, each from its own lit point.
//!
//! Results equal those of `sample` bit by bit.

use turner_bvh::lanes::{Block, F64x8, LANES, Simd, Vec3x8};

use super::EmitterSample;
use crate::math::DVec3;

/// The inputs and outputs of eight lanes.
#[derive(Clone, Debug, Default)]
pub struct EmitterBlock {
    /// Lit points.
    p: [Block; 3],
    /// Two random numbers per lane.
    random: [Block; 2],
    q: [Block; 3],
    n: [Block; 3],
    uv: [Block; 2],
    pdf: Block,
    /// Bit mask of the lanes with a sample.
    found: u8,
}

impl EmitterBlock {
    /// Sets the inputs of a lane: sample the point that `u` chooses, seen from `p`.
    #[inline]
    pub fn ask(&mut self, lane: usize, p: DVec3, u: [f64; 2]) {
        for (block, v) in self.p.iter_mut().zip(p.to_array()) {
            block.0[lane] = v;
        }
        for (block, v) in self.random.iter_mut().zip(u) {
            block.0[lane] = v;
        }
    }

    /// The lit point of a lane.
    #[inline]
    pub fn lit(&self, lane: usize) -> DVec3 {
        vector(&self.p, lane)
    }

    /// The sample of a lane.
    #[inline]
    pub fn get(&self, lane: usize) -> Option<EmitterSample> {
        (self.found >> lane & 1 == 1).then(|| EmitterSample {
            q: vector(&self.q, lane),
            n: vector(&self.n, lane),
            u: self.uv[0].0[lane],
            v: self.uv[1].0[lane],
            pdf: self.pdf.0[lane],
        })
    }

    /// The lit points and the random numbers.
    #[inline(always)]
    pub(super) fn inputs<S: Simd>(&self, simd: S) -> (Vec3x8<S>, [F64x8<S>; 2]) {
        let [a, b] = &self.random;
        (Vec3x8::load(simd, &self.p), [F64x8::load(simd, a), F64x8::load(simd, b)])
    }

    /// Stores the samples of the lanes in `found`.
    #[inline(always)]
    pub(super) fn store<S: Simd>(
        &mut self,
        found: u8,
        q: Vec3x8<S>,
        n: Vec3x8<S>,
        uv: [F64x8<S>; 2],
        pdf: F64x8<S>,
    ) {
        q.store(&mut self.q);
        n.store(&mut self.n);
        let [u, v] = uv;
        u.store(&mut self.uv[0]);
        v.store(&mut self.uv[1]);
        pdf.store(&mut self.pdf);
        self.found = found;
    }

    /// Stores a sample computed in scalar code.
    pub(super) fn store_one(&mut self, lane: usize, s: Option<EmitterSample>) {
        let Some(s) = s else {
            self.found &= !(1 << lane);
            return;
        };
        for (block, v) in self.q.iter_mut().zip(s.q.to_array()) {
            block.0[lane] = v;
        }
        for (block, v) in self.n.iter_mut().zip(s.n.to_array()) {
            block.0[lane] = v;
        }
        (self.uv[0].0[lane], self.uv[1].0[lane], self.pdf.0[lane]) = (s.u, s.v, s.pdf);
        self.found |= 1 << lane;
    }

    /// The random numbers of a lane.
    pub(super) fn random_pair(&self, lane: usize) -> [f64; 2] {
        [self.random[0].0[lane], self.random[1].0[lane]]
    }
}

#[inline]
fn vector([x, y, z]: &[Block; 3], lane: usize) -> DVec3 {
    DVec3::new(x.0[lane], y.0[lane], z.0[lane])
}

/// Eight emitters, which may all be the same one.
#[derive(Clone, Copy)]
pub(super) struct Eight<'a, E> {
    emitters: [&'a E; LANES],
    same: bool,
}

impl<'a, E> Eight<'a, E> {
    #[inline]
    pub(super) fn new(emitters: [&'a E; LANES]) -> Eight<'a, E> {
        Eight { emitters, same: emitters.iter().all(|e| std::ptr::eq(*e, emitters[0])) }
    }

    /// One value of each emitter.
    #[inline(always)]
    pub(super) fn scalar<S: Simd>(&self, simd: S, of: impl Fn(&E) -> f64) -> F64x8<S> {
        if self.same {
            return F64x8::splat(simd, of(self.emitters[0]));
        }
        let mut block = Block::default();
        for lane in 0..LANES {
            block.0[lane] = of(self.emitters[lane]);
        }
        F64x8::load(simd, &block)
    }

    /// One vector of each emitter.
    #[inline(always)]
    pub(super) fn vector<S: Simd>(&self, simd: S, of: impl Fn(&E) -> DVec3) -> Vec3x8<S> {
        Vec3x8 {
            x: self.scalar(simd, |e| of(e).x),
            y: self.scalar(simd, |e| of(e).y),
            z: self.scalar(simd, |e| of(e).z),
        }
    }
}

/// The lanes in which a pdf per area converts to one per solid angle, and the result: as [`super::per_solid_angle`].
#[inline(always)]
pub(super) fn per_solid_angle<S: Simd>(
    simd: S,
    per_area: F64x8<S>,
    p: Vec3x8<S>,
    q: Vec3x8<S>,
    n: Vec3x8<S>,
) -> (turner_bvh::lanes::Mask8<S>, F64x8<S>) {
    let d = q - p;
    let d2 = d.dot(d);
    let cosine = d.dot(n).abs() / d2.sqrt();
    let pdf = per_area * d2 / cosine;
    (pdf.gt(F64x8::splat(simd, 0.0)) & pdf.lt(F64x8::splat(simd, f64::INFINITY)), pdf)
}

#[cfg(test)]
mod tests {
    use super::super::{RectangleEmitter, SphereEmitter, TriangleBlock, TriangleEmitter};
    use super::*;
    use crate::testing::Random;
    use turner_bvh::InstructionSet;

    /// Compares `sample` and `sample_block` at random points: far, near, on and in the emitters.
    fn check<E>(
        make: impl Fn(&mut Random) -> E,
        one: impl Fn(&E, DVec3, [f64; 2]) -> Option<EmitterSample>,
        eight: impl Fn(InstructionSet, [&E; LANES], &mut EmitterBlock),
    ) {
        let mut random = Random::new(3);
        let sets: Vec<InstructionSet> = InstructionSet::available().collect();
        let mut samples = 0;
        for round in 0..3000 {
            let emitters: [E; LANES] = std::array::from_fn(|_| make(&mut random));
            let chosen: [&E; LANES] =
                std::array::from_fn(|i| if round % 2 == 0 { &emitters[0] } else { &emitters[i] });
            let mut block = EmitterBlock::default();
            for lane in 0..LANES {
                let [x, y, z, size] = random.units::<4>();
                let scale = [0.5, 2.0, 30.0, 1e4][(size * 4.0) as usize];
                let p = scale * (2.0 * DVec3::new(x, y, z) - 1.0);
                let p = if round % 7 == 0 { DVec3::new(p.x, 0.0, p.z) } else { p };
                block.ask(lane, p, random.units::<2>());
            }
            let set = sets[round % sets.len()];
            eight(set, chosen, &mut block);
            for (lane, emitter) in chosen.iter().enumerate() {
                let alone = one(emitter, block.lit(lane), block.random_pair(lane));
                assert_eq!(alone, block.get(lane), "round {round}, lane {lane}, {set}");
                samples += usize::from(alone.is_some());
            }
        }
        assert!(samples > 20_000, "{samples}");
    }

    #[test]
    fn rectangles_eight_at_a_time() {
        let make = |random: &mut Random| {
            let [x, z, skew, side] = random.units::<4>();
            let v = DVec3::new(if skew < 0.3 { skew } else { 0.0 }, 0.0, 0.1 + z);
            let side = if side < 0.5 { 1.0 } else { -1.0 };
            RectangleEmitter::new(DVec3::new(-x, 0.0, -z), DVec3::X * (0.1 + 2.0 * x), v, side).unwrap()
        };
        check(make, |e, p, u| e.sample(p, u), RectangleEmitter::sample_block);
    }

    #[test]
    fn spheres_eight_at_a_time() {
        let make = |random: &mut Random| {
            let [x, y, z, radius] = random.units::<4>();
            SphereEmitter { center: DVec3::new(x, y, z), radius: 0.01 + radius }
        };
        check(make, |e, p, u| e.sample(p, u), SphereEmitter::sample_block);
    }

    #[test]
    fn triangles_eight_at_a_time() {
        let make = |random: &mut Random| {
            let [side, thin] = random.units::<2>();
            let side = if side < 0.5 { 1.0 } else { -1.0 };
            let mut corner = || 2.0 * random.in_cube();
            let [a, b, c] = [corner(), corner(), corner()];
            // Some are thin, some have no area.
            let corners = match (thin * 10.0) as u32 {
                0 => [a, b, a + (b - a) * 0.5 + 1e-7 * c],
                1 => [a, b, b],
                _ => [a, b, c],
            };
            (corners, side)
        };
        let one = |(corners, side): &([DVec3; 3], f64), p: DVec3, u: [f64; 2]| {
            TriangleEmitter::new(*corners, *side)?.sample(p, u)
        };
        check(make, one, |set, triangles, block| {
            let mut own = TriangleBlock::default();
            for (lane, (corners, side)) in triangles.into_iter().enumerate() {
                own.ask(lane, *corners, *side, block.lit(lane), block.random_pair(lane));
            }
            own.sample(set);
            *block = own.block().clone();
        });
    }
}
