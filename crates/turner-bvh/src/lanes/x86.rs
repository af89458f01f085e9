//! Eight f64 lanes on x86-64 with AVX-512 and AVX2.

use std::arch::x86_64::*;

use super::{Block, Block32, Simd, Work};

/// AVX-512 F, VL, BW and DQ: one register for eight numbers, and mask registers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Avx512(());

/// AVX2: two registers for eight numbers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Avx2(());

impl Avx512 {
    /// # Safety
    ///
    /// The machine must support these instructions.
    #[inline]
    pub(super) unsafe fn new() -> Avx512 {
        Avx512(())
    }

    #[inline]
    pub(super) fn run<W: Work>(self, work: W) -> W::Output {
        #[target_feature(enable = "avx512f,avx512vl,avx512bw,avx512dq,avx2")]
        fn inner<W: Work>(simd: Avx512, work: W) -> W::Output {
            work.run(simd)
        }
        // SAFETY: an `Avx512` exists only where the machine supports the instructions.
        unsafe { inner(self, work) }
    }
}

impl Avx2 {
    /// # Safety
    ///
    /// The machine must support these instructions.
    #[inline]
    pub(super) unsafe fn new() -> Avx2 {
        Avx2(())
    }

    #[inline]
    pub(super) fn run<W: Work>(self, work: W) -> W::Output {
        #[target_feature(enable = "avx2")]
        fn inner<W: Work>(simd: Avx2, work: W) -> W::Output {
            work.run(simd)
        }
        // SAFETY: an `Avx2` exists only where the machine supports the instructions.
        unsafe { inner(self, work) }
    }
}

/// Functions of the trait, each one expression of intrinsics.
macro_rules! functions {
    ($(fn $name:ident($($arg:ident: $ty:ty),*) $(-> $ret:ty)? = $body:expr;)*) => { $(
        #[inline(always)]
        #[allow(unused_unsafe)]
        unsafe fn $name($($arg: $ty),*) $(-> $ret)? {
            // SAFETY: the caller has a value of the type, so the machine supports the instructions; blocks are aligned.
            unsafe { $body }
        }
    )* };
}

// SAFETY: values exist only where the machine supports the instructions; lanes are independent IEEE 754 operations.
unsafe impl Simd for Avx512 {
    type F = __m512d;
    type H = __m256;
    type M = u8;

    functions! {
        fn splat(v: f64) -> __m512d = _mm512_set1_pd(v);
        fn load(v: &Block) -> __m512d = _mm512_load_pd(v.0.as_ptr());
        fn store(v: __m512d, to: &mut Block) = _mm512_store_pd(to.0.as_mut_ptr(), v);
        fn add(a: __m512d, b: __m512d) -> __m512d = _mm512_add_pd(a, b);
        fn sub(a: __m512d, b: __m512d) -> __m512d = _mm512_sub_pd(a, b);
        fn mul(a: __m512d, b: __m512d) -> __m512d = _mm512_mul_pd(a, b);
        fn div(a: __m512d, b: __m512d) -> __m512d = _mm512_div_pd(a, b);
        fn sqrt(a: __m512d) -> __m512d = _mm512_sqrt_pd(a);
        fn bits_and(a: __m512d, b: __m512d) -> __m512d =
            _mm512_castsi512_pd(_mm512_and_si512(_mm512_castpd_si512(a), _mm512_castpd_si512(b)));
        fn bits_or(a: __m512d, b: __m512d) -> __m512d =
            _mm512_castsi512_pd(_mm512_or_si512(_mm512_castpd_si512(a), _mm512_castpd_si512(b)));
        fn bits_xor(a: __m512d, b: __m512d) -> __m512d =
            _mm512_castsi512_pd(_mm512_xor_si512(_mm512_castpd_si512(a), _mm512_castpd_si512(b)));
        fn shl52(a: __m512d) -> __m512d = _mm512_castsi512_pd(_mm512_slli_epi64::<52>(_mm512_castpd_si512(a)));
        fn shr52(a: __m512d) -> __m512d = _mm512_castsi512_pd(_mm512_srli_epi64::<52>(_mm512_castpd_si512(a)));
        fn lt(a: __m512d, b: __m512d) -> u8 = _mm512_cmp_pd_mask::<_CMP_LT_OQ>(a, b);
        fn le(a: __m512d, b: __m512d) -> u8 = _mm512_cmp_pd_mask::<_CMP_LE_OQ>(a, b);
        fn eq(a: __m512d, b: __m512d) -> u8 = _mm512_cmp_pd_mask::<_CMP_EQ_OQ>(a, b);
        fn test(a: __m512d, b: __m512d) -> u8 =
            _mm512_test_epi64_mask(_mm512_castpd_si512(a), _mm512_castpd_si512(b));
        fn select(m: u8, a: __m512d, b: __m512d) -> __m512d = _mm512_mask_blend_pd(m, b, a);
        fn mask(bits: u8) -> u8 = bits;
        fn bits(m: u8) -> u8 = m;
        fn and(a: u8, b: u8) -> u8 = a & b;
        fn or(a: u8, b: u8) -> u8 = a | b;
        fn and_not(a: u8, b: u8) -> u8 = a & !b;
        fn splat32(v: f32) -> __m256 = _mm256_set1_ps(v);
        fn load32(v: &Block32) -> __m256 = _mm256_load_ps(v.0.as_ptr());
        fn store32(v: __m256, to: &mut Block32) = _mm256_store_ps(to.0.as_mut_ptr(), v);
        fn add32(a: __m256, b: __m256) -> __m256 = _mm256_add_ps(a, b);
        fn sub32(a: __m256, b: __m256) -> __m256 = _mm256_sub_ps(a, b);
        fn mul32(a: __m256, b: __m256) -> __m256 = _mm256_mul_ps(a, b);
        fn div32(a: __m256, b: __m256) -> __m256 = _mm256_div_ps(a, b);
        fn sqrt32(a: __m256) -> __m256 = _mm256_sqrt_ps(a);
        fn max32(a: __m256, b: __m256) -> __m256 = _mm256_max_ps(a, b);
        fn min32(a: __m256, b: __m256) -> __m256 = _mm256_min_ps(a, b);
        fn lt32(a: __m256, b: __m256) -> u8 = _mm256_cmp_ps_mask::<_CMP_LT_OQ>(a, b);
        fn eq32(a: __m256, b: __m256) -> u8 = _mm256_cmp_ps_mask::<_CMP_EQ_OQ>(a, b);
        fn select32(m: u8, a: __m256, b: __m256) -> __m256 = _mm256_mask_blend_ps(m, b, a);
        fn narrow(a: __m512d) -> __m256 = _mm512_cvtpd_ps(a);
        fn widen(a: __m256) -> __m512d = _mm512_cvtps_pd(a);
    }
}

/// Converts a mask of eight doubles to a mask of eight floats.
#[inline(always)]
unsafe fn mask32([a, b]: [__m256d; 2]) -> __m256 {
    // SAFETY: only called where AVX2 is supported.
    unsafe {
        let (a, b) = (_mm256_castpd_ps(a), _mm256_castpd_ps(b));
        // Take the even words of both within each 128-bit half, then put the quarters in order.
        let even = _mm256_castps_pd(_mm256_shuffle_ps::<0b10_00_10_00>(a, b));
        _mm256_castpd_ps(_mm256_permute4x64_pd::<0b11_01_10_00>(even))
    }
}

/// Converts a mask of eight floats to a mask of eight doubles.
#[inline(always)]
unsafe fn mask64(m: __m256) -> [__m256d; 2] {
    // SAFETY: only called where AVX2 is supported.
    unsafe {
        let m = _mm256_castps_si256(m);
        [
            _mm256_castsi256_pd(_mm256_cvtepi32_epi64(_mm256_castsi256_si128(m))),
            _mm256_castsi256_pd(_mm256_cvtepi32_epi64(_mm256_extracti128_si256::<1>(m))),
        ]
    }
}

// SAFETY: as above.
unsafe impl Simd for Avx2 {
    type F = [__m256d; 2];
    type H = __m256;
    /// A lane has all bits set or none.
    type M = [__m256d; 2];

    functions! {
        fn splat(v: f64) -> Self::F = [_mm256_set1_pd(v); 2];
        fn load(v: &Block) -> Self::F = [_mm256_load_pd(v.0.as_ptr()), _mm256_load_pd(v.0.as_ptr().add(4))];
        fn store(v: Self::F, to: &mut Block) = {
            _mm256_store_pd(to.0.as_mut_ptr(), v[0]);
            _mm256_store_pd(to.0.as_mut_ptr().add(4), v[1]);
        };
        fn add(a: Self::F, b: Self::F) -> Self::F = [_mm256_add_pd(a[0], b[0]), _mm256_add_pd(a[1], b[1])];
        fn sub(a: Self::F, b: Self::F) -> Self::F = [_mm256_sub_pd(a[0], b[0]), _mm256_sub_pd(a[1], b[1])];
        fn mul(a: Self::F, b: Self::F) -> Self::F = [_mm256_mul_pd(a[0], b[0]), _mm256_mul_pd(a[1], b[1])];
        fn div(a: Self::F, b: Self::F) -> Self::F = [_mm256_div_pd(a[0], b[0]), _mm256_div_pd(a[1], b[1])];
        fn sqrt(a: Self::F) -> Self::F = [_mm256_sqrt_pd(a[0]), _mm256_sqrt_pd(a[1])];
        fn bits_and(a: Self::F, b: Self::F) -> Self::F = [_mm256_and_pd(a[0], b[0]), _mm256_and_pd(a[1], b[1])];
        fn bits_or(a: Self::F, b: Self::F) -> Self::F = [_mm256_or_pd(a[0], b[0]), _mm256_or_pd(a[1], b[1])];
        fn bits_xor(a: Self::F, b: Self::F) -> Self::F = [_mm256_xor_pd(a[0], b[0]), _mm256_xor_pd(a[1], b[1])];
        fn shl52(a: Self::F) -> Self::F =
            a.map(|v| _mm256_castsi256_pd(_mm256_slli_epi64::<52>(_mm256_castpd_si256(v))));
        fn shr52(a: Self::F) -> Self::F =
            a.map(|v| _mm256_castsi256_pd(_mm256_srli_epi64::<52>(_mm256_castpd_si256(v))));
        fn lt(a: Self::F, b: Self::F) -> Self::M =
            [_mm256_cmp_pd::<_CMP_LT_OQ>(a[0], b[0]), _mm256_cmp_pd::<_CMP_LT_OQ>(a[1], b[1])];
        fn le(a: Self::F, b: Self::F) -> Self::M =
            [_mm256_cmp_pd::<_CMP_LE_OQ>(a[0], b[0]), _mm256_cmp_pd::<_CMP_LE_OQ>(a[1], b[1])];
        fn eq(a: Self::F, b: Self::F) -> Self::M =
            [_mm256_cmp_pd::<_CMP_EQ_OQ>(a[0], b[0]), _mm256_cmp_pd::<_CMP_EQ_OQ>(a[1], b[1])];
        fn test(a: Self::F, b: Self::F) -> Self::M = {
            let ones = _mm256_castsi256_pd(_mm256_set1_epi64x(-1));
            let half = |a, b| {
                let both = _mm256_castpd_si256(_mm256_and_pd(a, b));
                let zero = _mm256_cmpeq_epi64(both, _mm256_setzero_si256());
                _mm256_andnot_pd(_mm256_castsi256_pd(zero), ones)
            };
            [half(a[0], b[0]), half(a[1], b[1])]
        };
        fn select(m: Self::M, a: Self::F, b: Self::F) -> Self::F =
            [_mm256_blendv_pd(b[0], a[0], m[0]), _mm256_blendv_pd(b[1], a[1], m[1])];
        fn mask(bits: u8) -> Self::M = {
            let bits = _mm256_set1_epi64x(i64::from(bits));
            let half = |lanes| {
                _mm256_castsi256_pd(_mm256_cmpeq_epi64(_mm256_and_si256(bits, lanes), lanes))
            };
            [half(_mm256_setr_epi64x(1, 2, 4, 8)), half(_mm256_setr_epi64x(16, 32, 64, 128))]
        };
        fn bits(m: Self::M) -> u8 = (_mm256_movemask_pd(m[0]) | _mm256_movemask_pd(m[1]) << 4) as u8;
        fn and(a: Self::M, b: Self::M) -> Self::M = [_mm256_and_pd(a[0], b[0]), _mm256_and_pd(a[1], b[1])];
        fn or(a: Self::M, b: Self::M) -> Self::M = [_mm256_or_pd(a[0], b[0]), _mm256_or_pd(a[1], b[1])];
        fn and_not(a: Self::M, b: Self::M) -> Self::M =
            [_mm256_andnot_pd(b[0], a[0]), _mm256_andnot_pd(b[1], a[1])];
        fn splat32(v: f32) -> __m256 = _mm256_set1_ps(v);
        fn load32(v: &Block32) -> __m256 = _mm256_load_ps(v.0.as_ptr());
        fn store32(v: __m256, to: &mut Block32) = _mm256_store_ps(to.0.as_mut_ptr(), v);
        fn add32(a: __m256, b: __m256) -> __m256 = _mm256_add_ps(a, b);
        fn sub32(a: __m256, b: __m256) -> __m256 = _mm256_sub_ps(a, b);
        fn mul32(a: __m256, b: __m256) -> __m256 = _mm256_mul_ps(a, b);
        fn div32(a: __m256, b: __m256) -> __m256 = _mm256_div_ps(a, b);
        fn sqrt32(a: __m256) -> __m256 = _mm256_sqrt_ps(a);
        fn max32(a: __m256, b: __m256) -> __m256 = _mm256_max_ps(a, b);
        fn min32(a: __m256, b: __m256) -> __m256 = _mm256_min_ps(a, b);
        fn lt32(a: __m256, b: __m256) -> Self::M = mask64(_mm256_cmp_ps::<_CMP_LT_OQ>(a, b));
        fn eq32(a: __m256, b: __m256) -> Self::M = mask64(_mm256_cmp_ps::<_CMP_EQ_OQ>(a, b));
        fn select32(m: Self::M, a: __m256, b: __m256) -> __m256 = _mm256_blendv_ps(b, a, mask32(m));
        fn narrow(a: Self::F) -> __m256 = _mm256_set_m128(_mm256_cvtpd_ps(a[1]), _mm256_cvtpd_ps(a[0]));
        fn widen(a: __m256) -> Self::F =
            [_mm256_cvtps_pd(_mm256_castps256_ps128(a)), _mm256_cvtps_pd(_mm256_extractf128_ps::<1>(a))];
    }
}
