//! Eight numbers, masks or vectors with the operators of scalars.
//!
//! They can only be made with a value of their instruction set, which proves that the machine supports it.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Sub};

use super::{Block, Block32, Simd};

/// 1.5 · 2^52: the low bits of its sum with a whole number are those of the number.
const WHOLE: f64 = 6_755_399_441_055_744.0;
/// 2^52: its low bits are 0.
const LOW: f64 = 4_503_599_627_370_496.0;
/// What the bits of an exponent exceed it by.
const BIAS: f64 = 1023.0;

/// Eight f64.
#[derive(Clone, Copy)]
pub struct F64x8<S: Simd>(S::F);

/// Eight f32.
#[derive(Clone, Copy)]
pub struct F32x8<S: Simd>(S::H);

/// Eight booleans.
#[derive(Clone, Copy)]
pub struct Mask8<S: Simd>(S::M);

macro_rules! operator {
    ($type:ident, $trait:ident, $method:ident, $function:ident) => {
        impl<S: Simd> $trait for $type<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: the operands were made with a value of `S`.
                $type(unsafe { S::$function(self.0, other.0) })
            }
        }
    };
}

operator!(F64x8, Add, add, add);
operator!(F64x8, Sub, sub, sub);
operator!(F64x8, Mul, mul, mul);
operator!(F64x8, Div, div, div);
operator!(F32x8, Add, add, add32);
operator!(F32x8, Sub, sub, sub32);
operator!(F32x8, Mul, mul, mul32);
operator!(F32x8, Div, div, div32);
operator!(Mask8, BitAnd, bitand, and);
operator!(Mask8, BitOr, bitor, or);

#[allow(clippy::should_implement_trait)]
impl<S: Simd> F64x8<S> {
    /// The same value in every lane.
    #[inline(always)]
    pub fn splat(_: S, v: f64) -> Self {
        // SAFETY: a value of `S` was passed.
        F64x8(unsafe { S::splat(v) })
    }

    /// Loads from memory.
    #[inline(always)]
    pub fn load(_: S, from: &Block) -> Self {
        // SAFETY: a value of `S` was passed.
        F64x8(unsafe { S::load(from) })
    }

    /// Stores to memory.
    #[inline(always)]
    pub fn store(self, to: &mut Block) {
        // SAFETY: these lanes were made with a value of `S`.
        unsafe { S::store(self.0, to) }
    }

    /// The square root.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        // SAFETY: these lanes were made with a value of `S`.
        F64x8(unsafe { S::sqrt(self.0) })
    }

    /// The absolute value.
    #[inline(always)]
    pub fn abs(self) -> Self {
        // SAFETY: these lanes were made with a value of `S`.
        F64x8(unsafe { S::bits_and(self.0, S::splat(f64::from_bits(u64::MAX >> 1))) })
    }

    /// This magnitude with the sign of `sign`.
    #[inline(always)]
    pub fn copysign(self, sign: Self) -> Self {
        // SAFETY: these lanes were made with a value of `S`.
        F64x8(unsafe {
            let mask = S::splat(-0.0);
            S::bits_or(self.abs().0, S::bits_and(sign.0, mask))
        })
    }

    /// `self < other`.
    #[inline(always)]
    pub fn lt(self, other: Self) -> Mask8<S> {
        // SAFETY: these lanes were made with a value of `S`.
        Mask8(unsafe { S::lt(self.0, other.0) })
    }

    /// `self <= other`.
    #[inline(always)]
    pub fn le(self, other: Self) -> Mask8<S> {
        // SAFETY: these lanes were made with a value of `S`.
        Mask8(unsafe { S::le(self.0, other.0) })
    }

    /// `self > other`.
    #[inline(always)]
    pub fn gt(self, other: Self) -> Mask8<S> {
        other.lt(self)
    }

    /// `self >= other`.
    #[inline(always)]
    pub fn ge(self, other: Self) -> Mask8<S> {
        other.le(self)
    }

    /// `self == other`.
    #[inline(always)]
    pub fn eq(self, other: Self) -> Mask8<S> {
        // SAFETY: these lanes were made with a value of `S`.
        Mask8(unsafe { S::eq(self.0, other.0) })
    }

    /// Whether bit `bit` of the number's bits is set.
    #[inline(always)]
    pub fn has_bit(self, bit: u32) -> Mask8<S> {
        // SAFETY: these lanes were made with a value of `S`.
        Mask8(unsafe { S::test(self.0, S::splat(f64::from_bits(1 << bit))) })
    }

    /// 2 to the power of this whole number, −1022..=1023.
    #[inline(always)]
    pub fn power_of_two(self) -> Self {
        // The low bits of the sum are those of the biased exponent.
        // SAFETY: these lanes were made with a value of `S`.
        F64x8(unsafe { S::shl52(S::add(self.0, S::splat(WHOLE + BIAS))) })
    }

    /// The binary exponent of a positive, normal number, as a number: its logarithm, rounded down.
    #[inline(always)]
    pub fn exponent(self) -> Self {
        // SAFETY: these lanes were made with a value of `S`.
        F64x8(unsafe { S::sub(S::bits_or(S::shr52(self.0), S::splat(LOW)), S::splat(LOW + BIAS)) })
    }

    /// A positive, normal number divided by 2 to the power of its exponent: 1..2.
    #[inline(always)]
    pub fn fraction(self) -> Self {
        // SAFETY: these lanes were made with a value of `S`.
        F64x8(unsafe {
            let bits = S::bits_and(self.0, S::splat(f64::from_bits((1 << 52) - 1)));
            S::bits_or(bits, S::splat(1.0))
        })
    }

    /// The maximum: `self` if both are equal, `other` if `self` is NaN.
    #[inline(always)]
    pub fn or_larger(self, other: Self) -> Self {
        // If `other` is NaN, both conditions are false unless `self` is NaN too.
        (other.gt(self) | self.is_nan()).select(other, self)
    }

    /// Whether the lane is NaN.
    #[inline(always)]
    pub fn is_nan(self) -> Mask8<S> {
        let number = self.eq(self);
        // SAFETY: these lanes were made with a value of `S`.
        Mask8(unsafe { S::and_not(S::mask(u8::MAX), number.0) })
    }

    /// Rounds to single precision.
    #[inline(always)]
    pub fn narrow(self) -> F32x8<S> {
        // SAFETY: these lanes were made with a value of `S`.
        F32x8(unsafe { S::narrow(self.0) })
    }
}

impl<S: Simd> Neg for F64x8<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        // SAFETY: these lanes were made with a value of `S`.
        F64x8(unsafe { S::bits_xor(self.0, S::splat(-0.0)) })
    }
}

#[allow(clippy::should_implement_trait)]
impl<S: Simd> F32x8<S> {
    /// The same value in every lane.
    #[inline(always)]
    pub fn splat(_: S, v: f32) -> Self {
        // SAFETY: a value of `S` was passed.
        F32x8(unsafe { S::splat32(v) })
    }

    /// Loads from memory.
    #[inline(always)]
    pub fn load(_: S, from: &Block32) -> Self {
        // SAFETY: a value of `S` was passed.
        F32x8(unsafe { S::load32(from) })
    }

    /// Stores to memory.
    #[inline(always)]
    pub fn store(self, to: &mut Block32) {
        // SAFETY: these lanes were made with a value of `S`.
        unsafe { S::store32(self.0, to) }
    }

    /// The square root.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        // SAFETY: these lanes were made with a value of `S`.
        F32x8(unsafe { S::sqrt32(self.0) })
    }

    /// `self` where it is larger, else `other`.
    #[inline(always)]
    pub fn or_larger(self, other: Self) -> Self {
        // SAFETY: these lanes were made with a value of `S`.
        F32x8(unsafe { S::max32(self.0, other.0) })
    }

    /// `self` where it is smaller, else `other`.
    #[inline(always)]
    pub fn or_smaller(self, other: Self) -> Self {
        // SAFETY: these lanes were made with a value of `S`.
        F32x8(unsafe { S::min32(self.0, other.0) })
    }

    /// `self < other`.
    #[inline(always)]
    pub fn lt(self, other: Self) -> Mask8<S> {
        // SAFETY: these lanes were made with a value of `S`.
        Mask8(unsafe { S::lt32(self.0, other.0) })
    }

    /// `self == other`.
    #[inline(always)]
    pub fn eq(self, other: Self) -> Mask8<S> {
        // SAFETY: these lanes were made with a value of `S`.
        Mask8(unsafe { S::eq32(self.0, other.0) })
    }

    /// Converts to double precision, exactly.
    #[inline(always)]
    pub fn widen(self) -> F64x8<S> {
        // SAFETY: these lanes were made with a value of `S`.
        F64x8(unsafe { S::widen(self.0) })
    }
}

impl<S: Simd> Mask8<S> {
    /// From bits: bit i is lane i.
    #[inline(always)]
    pub fn new(_: S, bits: u8) -> Self {
        // SAFETY: a value of `S` was passed.
        Mask8(unsafe { S::mask(bits) })
    }

    /// As bits: lane i is bit i.
    #[inline(always)]
    pub fn bits(self) -> u8 {
        // SAFETY: these lanes were made with a value of `S`.
        unsafe { S::bits(self.0) }
    }

    /// Whether any lane is set.
    #[inline(always)]
    pub fn any(self) -> bool {
        self.bits() != 0
    }

    /// `self & !other`.
    #[inline(always)]
    pub fn and_not(self, other: Self) -> Self {
        // SAFETY: these lanes were made with a value of `S`.
        Mask8(unsafe { S::and_not(self.0, other.0) })
    }

    /// `a` where the mask is set, `b` elsewhere.
    #[inline(always)]
    pub fn select(self, a: F64x8<S>, b: F64x8<S>) -> F64x8<S> {
        // SAFETY: these lanes were made with a value of `S`.
        F64x8(unsafe { S::select(self.0, a.0, b.0) })
    }

    /// `a` where the mask is set, `b` elsewhere.
    #[inline(always)]
    pub fn select32(self, a: F32x8<S>, b: F32x8<S>) -> F32x8<S> {
        // SAFETY: these lanes were made with a value of `S`.
        F32x8(unsafe { S::select32(self.0, a.0, b.0) })
    }
}

/// Eight vectors.
#[derive(Clone, Copy)]
pub struct Vec3x8<S: Simd> {
    /// x coordinates.
    pub x: F64x8<S>,
    /// y coordinates.
    pub y: F64x8<S>,
    /// z coordinates.
    pub z: F64x8<S>,
}

impl<S: Simd> Vec3x8<S> {
    /// The same vector in every lane.
    #[inline(always)]
    pub fn splat(simd: S, [x, y, z]: [f64; 3]) -> Self {
        Vec3x8 { x: F64x8::splat(simd, x), y: F64x8::splat(simd, y), z: F64x8::splat(simd, z) }
    }

    /// Loads from memory, one block per coordinate.
    #[inline(always)]
    pub fn load(simd: S, [x, y, z]: &[Block; 3]) -> Self {
        Vec3x8 { x: F64x8::load(simd, x), y: F64x8::load(simd, y), z: F64x8::load(simd, z) }
    }

    /// Stores to memory, one block per coordinate.
    #[inline(always)]
    pub fn store(self, [x, y, z]: &mut [Block; 3]) {
        self.x.store(x);
        self.y.store(y);
        self.z.store(z);
    }

    /// (x·x + y·y) + z·z.
    #[inline(always)]
    pub fn dot(self, o: Self) -> F64x8<S> {
        self.x * o.x + self.y * o.y + self.z * o.z
    }

    /// The cross product.
    #[inline(always)]
    pub fn cross(self, o: Self) -> Self {
        Vec3x8 {
            x: self.y * o.z - o.y * self.z,
            y: self.z * o.x - o.z * self.x,
            z: self.x * o.y - o.x * self.y,
        }
    }

    /// `a` where the mask is set, `b` elsewhere.
    #[inline(always)]
    pub fn select(mask: Mask8<S>, a: Self, b: Self) -> Self {
        Vec3x8 { x: mask.select(a.x, b.x), y: mask.select(a.y, b.y), z: mask.select(a.z, b.z) }
    }
}

impl<S: Simd> Add for Vec3x8<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Vec3x8 { x: self.x + o.x, y: self.y + o.y, z: self.z + o.z }
    }
}

impl<S: Simd> Sub for Vec3x8<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Vec3x8 { x: self.x - o.x, y: self.y - o.y, z: self.z - o.z }
    }
}

impl<S: Simd> Neg for Vec3x8<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Vec3x8 { x: -self.x, y: -self.y, z: -self.z }
    }
}

impl<S: Simd> Mul<F64x8<S>> for Vec3x8<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, k: F64x8<S>) -> Self {
        Vec3x8 { x: self.x * k, y: self.y * k, z: self.z * k }
    }
}
