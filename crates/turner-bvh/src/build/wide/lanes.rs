//! Four floats at a time: SSE2 on x86-64, arrays elsewhere, with the same results.

#[cfg(not(target_arch = "x86_64"))]
pub(super) use portable::F4;
#[cfg(target_arch = "x86_64")]
pub(super) use sse2::F4;

/// Whether 256-bit registers are available; they do not change results.
#[cfg(target_arch = "x86_64")]
#[inline]
pub(super) fn has_avx2() -> bool {
    std::arch::is_x86_feature_detected!("avx2")
}

#[cfg(target_arch = "x86_64")]
mod sse2 {
    use std::arch::x86_64::*;

    macro_rules! sse {
        ($call:expr) => {
            // SAFETY: every x86-64 processor has SSE2.
            #[allow(unused_unsafe)]
            unsafe {
                $call
            }
        };
    }

    #[derive(Clone, Copy, Debug)]
    #[repr(transparent)]
    pub(in super::super) struct F4(__m128);

    impl F4 {
        #[inline(always)]
        pub(in super::super) fn new(a: [f32; 4]) -> F4 {
            F4(sse!(_mm_set_ps(a[3], a[2], a[1], a[0])))
        }

        #[inline(always)]
        pub(in super::super) fn splat(x: f32) -> F4 {
            F4(sse!(_mm_set1_ps(x)))
        }

        #[inline(always)]
        pub(in super::super) fn array(self) -> [f32; 4] {
            // SAFETY: both types are 16 bytes in which every bit pattern is valid.
            unsafe { std::mem::transmute(self.0) }
        }

        #[inline(always)]
        pub(in super::super) fn add(self, other: F4) -> F4 {
            F4(sse!(_mm_add_ps(self.0, other.0)))
        }

        #[inline(always)]
        pub(in super::super) fn sub(self, other: F4) -> F4 {
            F4(sse!(_mm_sub_ps(self.0, other.0)))
        }

        #[inline(always)]
        pub(in super::super) fn mul(self, other: F4) -> F4 {
            F4(sse!(_mm_mul_ps(self.0, other.0)))
        }

        /// The smaller of both; `other` if either is NaN.
        #[inline(always)]
        pub(in super::super) fn min(self, other: F4) -> F4 {
            F4(sse!(_mm_min_ps(self.0, other.0)))
        }

        /// The larger of both; `other` if either is NaN.
        #[inline(always)]
        pub(in super::super) fn max(self, other: F4) -> F4 {
            F4(sse!(_mm_max_ps(self.0, other.0)))
        }

        /// All bits set where `self >= other`.
        #[inline(always)]
        pub(in super::super) fn at_least(self, other: F4) -> F4 {
            F4(sse!(_mm_cmpge_ps(self.0, other.0)))
        }

        #[inline(always)]
        pub(in super::super) fn or(self, other: F4) -> F4 {
            F4(sse!(_mm_or_ps(self.0, other.0)))
        }

        /// Clears the bits of `mask`.
        #[inline(always)]
        pub(in super::super) fn without(self, mask: F4) -> F4 {
            F4(sse!(_mm_andnot_ps(mask.0, self.0)))
        }

        /// Lanes 1, 2, 0, 3.
        #[inline(always)]
        pub(in super::super) fn rotated(self) -> F4 {
            F4(sse!(_mm_shuffle_ps::<0b11_00_10_01>(self.0, self.0)))
        }

        /// Rounded towards zero; all lanes must be within the range of `i32`.
        #[inline(always)]
        pub(in super::super) fn truncated(self) -> [i32; 4] {
            // SAFETY: both types are 16 bytes in which every bit pattern is valid.
            unsafe { std::mem::transmute(sse!(_mm_cvttps_epi32(self.0))) }
        }
    }
}

#[cfg(any(test, not(target_arch = "x86_64")))]
mod portable {
    #[derive(Clone, Copy, Debug)]
    #[repr(C, align(16))]
    pub(in super::super) struct F4([f32; 4]);

    impl F4 {
        #[inline(always)]
        fn zip(self, other: F4, f: impl Fn(f32, f32) -> f32) -> F4 {
            F4(std::array::from_fn(|i| f(self.0[i], other.0[i])))
        }

        #[inline(always)]
        fn bits(self, other: F4, f: impl Fn(u32, u32) -> u32) -> F4 {
            self.zip(other, |a, b| f32::from_bits(f(a.to_bits(), b.to_bits())))
        }

        #[inline(always)]
        pub(in super::super) fn new(a: [f32; 4]) -> F4 {
            F4(a)
        }

        #[inline(always)]
        pub(in super::super) fn splat(x: f32) -> F4 {
            F4([x; 4])
        }

        #[inline(always)]
        pub(in super::super) fn array(self) -> [f32; 4] {
            self.0
        }

        #[inline(always)]
        pub(in super::super) fn add(self, other: F4) -> F4 {
            self.zip(other, |a, b| a + b)
        }

        #[inline(always)]
        pub(in super::super) fn sub(self, other: F4) -> F4 {
            self.zip(other, |a, b| a - b)
        }

        #[inline(always)]
        pub(in super::super) fn mul(self, other: F4) -> F4 {
            self.zip(other, |a, b| a * b)
        }

        /// The smaller of both; `other` if either is NaN.
        #[inline(always)]
        pub(in super::super) fn min(self, other: F4) -> F4 {
            self.zip(other, |a, b| if a < b { a } else { b })
        }

        /// The larger of both; `other` if either is NaN.
        #[inline(always)]
        pub(in super::super) fn max(self, other: F4) -> F4 {
            self.zip(other, |a, b| if a > b { a } else { b })
        }

        /// All bits set where `self >= other`.
        #[inline(always)]
        pub(in super::super) fn at_least(self, other: F4) -> F4 {
            self.zip(other, |a, b| f32::from_bits(if a >= b { u32::MAX } else { 0 }))
        }

        #[inline(always)]
        pub(in super::super) fn or(self, other: F4) -> F4 {
            self.bits(other, |a, b| a | b)
        }

        /// Clears the bits of `mask`.
        #[inline(always)]
        pub(in super::super) fn without(self, mask: F4) -> F4 {
            self.bits(mask, |a, b| a & !b)
        }

        /// Lanes 1, 2, 0, 3.
        #[inline(always)]
        pub(in super::super) fn rotated(self) -> F4 {
            let [a, b, c, d] = self.0;
            F4([b, c, a, d])
        }

        /// Rounded towards zero; all lanes must be within the range of `i32`.
        #[inline(always)]
        pub(in super::super) fn truncated(self) -> [i32; 4] {
            self.0.map(|x| x as i32)
        }
    }
}

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use super::{portable, sse2};

    #[test]
    fn both_kinds_agree_to_the_last_bit() {
        let numbers =
            [0.0, -0.0, 1.0, -1.5, 1e-40, 3e38, f32::INFINITY, f32::NEG_INFINITY, 7.25, f32::MIN_POSITIVE];
        let quads: Vec<[f32; 4]> =
            (0..40).map(|i| [0, 1, 2, 3].map(|k| numbers[(i * (k + 1) + 3 * k) % numbers.len()])).collect();
        macro_rules! check {
            ($($name:ident)*) => {
                for &a in &quads {
                    for &b in &quads {
                        $(
                            let x = sse2::F4::new(a).$name(sse2::F4::new(b)).array();
                            let y = portable::F4::new(a).$name(portable::F4::new(b)).array();
                            let same = |(x, y): (f32, f32)| x.to_bits() == y.to_bits() || x.is_nan() && y.is_nan();
                            assert!(x.into_iter().zip(y).all(same), "{} {a:?} {b:?}", stringify!($name));
                        )*
                    }
                }
            };
        }
        check!(add sub mul min max at_least or without);
        // A minimum ignores NaN in its first operand.
        let nan = [f32::NAN; 4];
        for &a in &quads {
            assert_eq!(sse2::F4::new(nan).min(sse2::F4::new(a)).array(), a);
            assert_eq!(portable::F4::new(nan).min(portable::F4::new(a)).array(), a);
            assert_eq!(sse2::F4::new(a).rotated().array(), portable::F4::new(a).rotated().array());
        }
        let places = [0.0, 0.99, 7.5, 31.0];
        assert_eq!(sse2::F4::new(places).truncated(), portable::F4::new(places).truncated());
        assert_eq!(sse2::F4::splat(2.5).array(), portable::F4::splat(2.5).array());
    }
}
