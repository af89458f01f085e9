//! Each lane has the result of scalar code, to the last bit, with every instruction set.

use turner_bvh::InstructionSet;
use turner_bvh::lanes::{Block, Block32, F32x8, F64x8, LANES, Mask8, Simd, Vec3x8, Work, dispatch};

/// Values that distinguish the operations.
const VALUES: [f64; 14] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    1.0 / 3.0,
    -7.25,
    1e-310,
    f64::MIN_POSITIVE,
    1e300,
    -1e300,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::NAN,
    2.625,
];

struct Operations<'a> {
    a: &'a Block,
    b: &'a Block,
}

/// Results by name; masks as 0 and 1.
type Results = Vec<(&'static str, Block)>;

impl Work for Operations<'_> {
    type Output = Results;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Results {
        let (a, b) = (F64x8::load(simd, self.a), F64x8::load(simd, self.b));
        let mut results = Results::new();
        let mut number = |name, v: F64x8<S>| {
            let mut out = Block::default();
            v.store(&mut out);
            results.push((name, out));
        };
        number("add", a + b);
        number("sub", a - b);
        number("mul", a * b);
        number("div", a / b);
        number("sqrt", a.sqrt());
        number("neg", -a);
        number("abs", a.abs());
        number("copysign", a.copysign(b));
        number("or_larger", a.or_larger(b));
        number("splat", F64x8::splat(simd, self.a.0[3]));
        number("select", a.lt(b).select(a, b));
        let bits = (self.a.0[0].to_bits() >> 13) as u8;
        number("mask", Mask8::new(simd, bits).select(a, b));
        let v = Vec3x8 { x: a, y: b, z: a };
        number("dot", v.dot(Vec3x8 { x: b, y: b, z: a }));
        number("cross", v.cross(Vec3x8 { x: b, y: b, z: a }).y);
        let mut mask = |name, m: Mask8<S>| {
            let bits = m.bits();
            results.push((name, Block(std::array::from_fn(|i| f64::from(bits >> i & 1)))));
        };
        mask("lt", a.lt(b));
        mask("le", a.le(b));
        mask("gt", a.gt(b));
        mask("ge", a.ge(b));
        mask("eq", a.eq(b));
        mask("is_nan", a.is_nan());
        mask("has_bit", a.has_bit(52));
        mask("and", a.lt(b) & b.gt(F64x8::splat(simd, 0.5)));
        mask("or", a.lt(b) | b.gt(F64x8::splat(simd, 0.5)));
        mask("and_not", a.lt(b).and_not(b.gt(F64x8::splat(simd, 0.5))));
        let (h, k) = (a.narrow(), b.narrow());
        let mut single = |name, v: F32x8<S>| {
            let mut out = Block32::default();
            v.store(&mut out);
            results.push((name, Block(out.0.map(f64::from))));
        };
        single("narrow", h);
        single("widen", (h.widen() * h.widen()).narrow());
        single("add32", h + k);
        single("mul32", h * k);
        single("select32", a.lt(b).select32(h, k));
        single("mask32", h.eq(k).select32(F32x8::splat(simd, 1.5), h));
        results
    }
}

/// The scalar result.
fn expected(name: &str, a: &Block, b: &Block) -> Block {
    let each = |f: &dyn Fn(f64, f64) -> f64| Block(std::array::from_fn(|i| f(a.0[i], b.0[i])));
    let truth = |f: &dyn Fn(f64, f64) -> bool| each(&|a, b| f64::from(u8::from(f(a, b))));
    let single = |f: &dyn Fn(f32, f32) -> f32| each(&|a, b| f64::from(f(a as f32, b as f32)));
    let bits = (a.0[0].to_bits() >> 13) as u8;
    match name {
        "add" => each(&|a, b| a + b),
        "sub" => each(&|a, b| a - b),
        "mul" => each(&|a, b| a * b),
        "div" => each(&|a, b| a / b),
        "sqrt" => each(&|a, _| a.sqrt()),
        "neg" => each(&|a, _| -a),
        "abs" => each(&|a, _| a.abs()),
        "copysign" => each(&|a, b| a.copysign(b)),
        "or_larger" => each(&|a, b| if b > a || a.is_nan() { b } else { a }),
        "splat" => Block([a.0[3]; LANES]),
        "select" => each(&|a, b| if a < b { a } else { b }),
        "mask" => Block(std::array::from_fn(|i| if bits >> i & 1 == 1 { a.0[i] } else { b.0[i] })),
        "dot" => each(&|a, b| a * b + b * b + a * a),
        "cross" => each(&|a, b| a * b - a * a),
        "lt" => truth(&|a, b| a < b),
        "le" => truth(&|a, b| a <= b),
        "gt" => truth(&|a, b| a > b),
        "ge" => truth(&|a, b| a >= b),
        "eq" => truth(&|a, b| a == b),
        "is_nan" => truth(&|a, _| a.is_nan()),
        "has_bit" => truth(&|a, _| a.to_bits() >> 52 & 1 == 1),
        "and" => truth(&|a, b| a < b && b > 0.5),
        "or" => truth(&|a, b| a < b || b > 0.5),
        "and_not" => truth(&|a, b| a < b && b.partial_cmp(&0.5) != Some(std::cmp::Ordering::Greater)),
        "narrow" => single(&|a, _| a),
        "widen" => each(&|a, _| f64::from((f64::from(a as f32) * f64::from(a as f32)) as f32)),
        "add32" => single(&|a, b| a + b),
        "mul32" => single(&|a, b| a * b),
        "select32" => each(&|a, b| f64::from(if a < b { a as f32 } else { b as f32 })),
        "mask32" => single(&|a, b| if a == b { 1.5 } else { a }),
        _ => panic!("{name}"),
    }
}

/// The bits; all NaNs are equal.
fn bits(v: f64) -> u64 {
    if v.is_nan() { u64::MAX } else { v.to_bits() }
}

#[test]
fn every_operation_on_every_instruction_set() {
    let kinds: Vec<InstructionSet> = InstructionSet::available().collect();
    assert!(kinds.contains(&InstructionSet::PORTABLE));
    for start in 0..VALUES.len() {
        for shift in 0..VALUES.len() {
            let a = Block(std::array::from_fn(|i| VALUES[(start + i) % VALUES.len()]));
            let b = Block(std::array::from_fn(|i| VALUES[(start + shift + 3 * i) % VALUES.len()]));
            for kind in &kinds {
                for (name, got) in dispatch(*kind, Operations { a: &a, b: &b }) {
                    let expected = expected(name, &a, &b);
                    assert_eq!(got.0.map(bits), expected.0.map(bits), "{name} {kind:?} {a:?} {b:?}");
                }
            }
        }
    }
}

struct Exponents<'a> {
    whole: &'a Block,
    positive: &'a Block,
    /// Powers of two; exponents and fractions of the positive numbers.
    out: &'a mut [Block; 3],
}

impl Work for Exponents<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let positive = F64x8::load(simd, self.positive);
        F64x8::load(simd, self.whole).power_of_two().store(&mut self.out[0]);
        positive.exponent().store(&mut self.out[1]);
        positive.fraction().store(&mut self.out[2]);
    }
}

#[test]
fn exponents_on_every_instruction_set() {
    for kind in InstructionSet::available() {
        for first in (-1022..=1016).step_by(7).chain([1016]) {
            let whole = Block(std::array::from_fn(|i| f64::from(first + i as i32)));
            let power = whole.0.map(|k| f64::from_bits(((k + 1023.0) as u64) << 52));
            for fraction in [1.0, 1.0 + f64::EPSILON, 1.5, 2.0 - f64::EPSILON] {
                let positive = Block(power.map(|p| p * fraction));
                let mut out = [Block::default(); 3];
                dispatch(kind, Exponents { whole: &whole, positive: &positive, out: &mut out });
                assert_eq!(out.map(|b| b.0), [power, whole.0, [fraction; LANES]], "{kind:?}");
            }
        }
    }
}
