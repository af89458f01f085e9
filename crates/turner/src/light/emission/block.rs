//! Points of eight emitters of one form at a time, each seen from a point of its own.
//!
//! What comes out is that of `sample`, one by one, to the last bit.

use turner_bvh::lanes::{Block, F64x8, LANES, Simd, Vec3x8};

use super::EmitterSample;
use crate::math::DVec3;

/// What is asked of eight emitters, and what they answer.
#[derive(Clone, Debug, Default)]
pub struct EmitterBlock {
    /// The points that are lit.
    p: [Block; 3],
    /// Two numbers each.
    chosen: [Block; 2],
    q: [Block; 3],
    n: [Block; 3],
    uv: [Block; 2],
    pdf: Block,
    /// The lanes in which there is an answer.
    found: u8,
}

impl EmitterBlock {
    /// Asks in a lane for the point that `u` chooses, seen from `p`.
    #[inline]
    pub fn ask(&mut self, lane: usize, p: DVec3, u: [f64; 2]) {
        for (block, v) in self.p.iter_mut().zip(p.to_array()) {
            block.0[lane] = v;
        }
        for (block, v) in self.chosen.iter_mut().zip(u) {
            block.0[lane] = v;
        }
    }

    /// The point that is lit in a lane.
    #[inline]
    pub fn lit(&self, lane: usize) -> DVec3 {
        vector(&self.p, lane)
    }

    /// The answer in a lane.
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

    /// The points that are lit, and the numbers that choose.
    #[inline(always)]
    pub(super) fn asked<S: Simd>(&self, simd: S) -> (Vec3x8<S>, [F64x8<S>; 2]) {
        let [a, b] = &self.chosen;
        (Vec3x8::load(simd, &self.p), [F64x8::load(simd, a), F64x8::load(simd, b)])
    }

    /// Takes the answers in the lanes of `found`.
    #[inline(always)]
    pub(super) fn answer<S: Simd>(
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

    /// Takes an answer that was found alone.
    pub(super) fn answer_one(&mut self, lane: usize, s: Option<EmitterSample>) {
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

    /// The numbers that choose in a lane.
    pub(super) fn choice(&self, lane: usize) -> [f64; 2] {
        [self.chosen[0].0[lane], self.chosen[1].0[lane]]
    }
}

#[inline]
fn vector([x, y, z]: &[Block; 3], lane: usize) -> DVec3 {
    DVec3::new(x.0[lane], y.0[lane], z.0[lane])
}

/// Eight emitters, of which all may be one.
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

    /// A number of each.
    #[inline(always)]
    pub(super) fn number<S: Simd>(&self, simd: S, of: impl Fn(&E) -> f64) -> F64x8<S> {
        if self.same {
            return F64x8::splat(simd, of(self.emitters[0]));
        }
        let mut block = Block::default();
        for lane in 0..LANES {
            block.0[lane] = of(self.emitters[lane]);
        }
        F64x8::load(simd, &block)
    }

    /// A vector of each.
    #[inline(always)]
    pub(super) fn vector<S: Simd>(&self, simd: S, of: impl Fn(&E) -> DVec3) -> Vec3x8<S> {
        Vec3x8 {
            x: self.number(simd, |e| of(e).x),
            y: self.number(simd, |e| of(e).y),
            z: self.number(simd, |e| of(e).z),
        }
    }
}

/// The lanes in which a density per area is one per solid angle, and what it is: as [`super::per_solid_angle`].
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
    use super::super::{RectangleEmitter, SphereEmitter};
    use super::*;
    use crate::testing::Random;
    use turner_bvh::InstructionSet;

    /// `sample` and `sample_block` on random points, some far, near, on and in the emitters.
    fn check<E>(
        make: impl Fn(&mut Random) -> E,
        one: impl Fn(&E, DVec3, [f64; 2]) -> Option<EmitterSample>,
        eight: impl Fn(InstructionSet, [&E; LANES], &mut EmitterBlock),
    ) {
        let mut random = Random::new(3);
        let sets: Vec<InstructionSet> = InstructionSet::available().collect();
        let mut answers = 0;
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
                let alone = one(emitter, block.lit(lane), block.choice(lane));
                assert_eq!(alone, block.get(lane), "round {round}, lane {lane}, {set}");
                answers += usize::from(alone.is_some());
            }
        }
        assert!(answers > 20_000, "{answers}");
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
}
