//! AVX2 and AVX-512 on x86-64.
//!
//! SAFETY, for every block in this file: the machine supports the instructions, because [`Avx2`] and [`Avx512`] exist
//! only on machines that do, and vectors are made only through them.

use std::arch::x86_64::*;

use super::{Lanes, Simd};

/// AVX2, FMA, BMI and POPCNT.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Avx2(());

/// AVX-512 F, VL, BW, DQ, and everything that [`Avx2`] has.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Avx512(());

impl Avx2 {
    /// # Safety
    ///
    /// The machine must support these instructions, and the caller must be compiled for them.
    #[inline(always)]
    pub(super) unsafe fn new() -> Avx2 {
        Avx2(())
    }
}

impl Avx512 {
    /// # Safety
    ///
    /// The machine must support these instructions, and the caller must be compiled for them.
    #[inline(always)]
    pub(super) unsafe fn new() -> Avx512 {
        Avx512(())
    }
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct X4(__m128);
#[derive(Clone, Copy, Debug)]
pub(crate) struct X8(__m256);
/// Eight numbers with mask registers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct K8(__m256);
#[derive(Clone, Copy, Debug)]
pub(crate) struct K16(__m512);

macro_rules! lanes {
    ($name:ident, $n:literal, $add:ident, $sub:ident, $mul:ident, $div:ident, $min:ident, $max:ident, $fmadd:ident,
     $store:ident, $inverse:ident, $abs:expr, $sign:expr, $le:expr, $lt:expr, $range:expr, $choose:expr) => {
        impl Lanes for $name {
            #[inline(always)]
            fn add(self, other: Self) -> Self {
                // SAFETY: see the head of the file.
                $name(unsafe { $add(self.0, other.0) })
            }

            #[inline(always)]
            fn sub(self, other: Self) -> Self {
                // SAFETY: see the head of the file.
                $name(unsafe { $sub(self.0, other.0) })
            }

            #[inline(always)]
            fn mul(self, other: Self) -> Self {
                // SAFETY: see the head of the file.
                $name(unsafe { $mul(self.0, other.0) })
            }

            #[inline(always)]
            fn div(self, other: Self) -> Self {
                // SAFETY: see the head of the file.
                $name(unsafe { $div(self.0, other.0) })
            }

            #[inline(always)]
            fn min(self, other: Self) -> Self {
                // SAFETY: see the head of the file.
                $name(unsafe { $min(self.0, other.0) })
            }

            #[inline(always)]
            fn max(self, other: Self) -> Self {
                // SAFETY: see the head of the file.
                $name(unsafe { $max(self.0, other.0) })
            }

            #[inline(always)]
            fn abs(self) -> Self {
                // SAFETY: see the head of the file.
                $name(unsafe { $abs(self.0) })
            }

            #[inline(always)]
            fn with_sign(self, other: Self) -> Self {
                // SAFETY: see the head of the file.
                $name(unsafe { $sign(self.0, other.0) })
            }

            #[inline(always)]
            fn mul_add(self, a: Self, b: Self) -> Self {
                // SAFETY: see the head of the file.
                $name(unsafe { $fmadd(self.0, a.0, b.0) })
            }

            #[inline(always)]
            fn near_inverse(self) -> Self {
                // SAFETY: see the head of the file.
                $name(unsafe { $inverse(self.0) })
            }

            #[inline(always)]
            fn le(self, other: Self) -> u32 {
                // SAFETY: see the head of the file.
                unsafe { $le(self.0, other.0) }
            }

            #[inline(always)]
            fn lt(self, other: Self) -> u32 {
                // SAFETY: see the head of the file.
                unsafe { $lt(self.0, other.0) }
            }

            #[inline(always)]
            fn range(self) -> [f32; 2] {
                // SAFETY: see the head of the file.
                unsafe { $range(self.0) }
            }

            #[inline(always)]
            fn choose(self, mask: u32, other: Self) -> Self {
                // SAFETY: see the head of the file.
                $name(unsafe { $choose(mask, self.0, other.0) })
            }

            #[inline(always)]
            fn store(self, to: &mut [f32]) {
                assert!(to.len() >= $n);
                // SAFETY: see the head of the file; there is room for all lanes.
                unsafe { $store(to.as_mut_ptr(), self.0) }
            }
        }
    };
}

lanes!(
    X4,
    4,
    _mm_add_ps,
    _mm_sub_ps,
    _mm_mul_ps,
    _mm_div_ps,
    _mm_min_ps,
    _mm_max_ps,
    _mm_fmadd_ps,
    _mm_storeu_ps,
    _mm_rcp_ps,
    |a| _mm_andnot_ps(_mm_set1_ps(-0.0), a),
    |a, b| _mm_or_ps(_mm_andnot_ps(_mm_set1_ps(-0.0), a), _mm_and_ps(_mm_set1_ps(-0.0), b)),
    |a, b| _mm_movemask_ps(_mm_cmple_ps(a, b)) as u32,
    |a, b| _mm_movemask_ps(_mm_cmplt_ps(a, b)) as u32,
    |a: __m128| {
        let (low, high) = (_mm_min_ps(a, _mm_movehl_ps(a, a)), _mm_max_ps(a, _mm_movehl_ps(a, a)));
        let low = _mm_min_ss(low, _mm_shuffle_ps::<1>(low, low));
        let high = _mm_max_ss(high, _mm_shuffle_ps::<1>(high, high));
        [_mm_cvtss_f32(low), _mm_cvtss_f32(high)]
    },
    |mask, a, b| {
        let bits = _mm_setr_epi32(1, 2, 4, 8);
        let chosen = _mm_cmpeq_epi32(_mm_and_si128(_mm_set1_epi32(mask as i32), bits), bits);
        _mm_blendv_ps(b, a, _mm_castsi128_ps(chosen))
    }
);
lanes!(
    X8,
    8,
    _mm256_add_ps,
    _mm256_sub_ps,
    _mm256_mul_ps,
    _mm256_div_ps,
    _mm256_min_ps,
    _mm256_max_ps,
    _mm256_fmadd_ps,
    _mm256_storeu_ps,
    _mm256_rcp_ps,
    |a| _mm256_andnot_ps(_mm256_set1_ps(-0.0), a),
    |a, b| _mm256_or_ps(_mm256_andnot_ps(_mm256_set1_ps(-0.0), a), _mm256_and_ps(_mm256_set1_ps(-0.0), b)),
    |a, b| _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(a, b)) as u32,
    |a, b| _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LT_OQ>(a, b)) as u32,
    |a: __m256| {
        let (a, b) = (_mm256_castps256_ps128(a), _mm256_extractf128_ps::<1>(a));
        [X4(_mm_min_ps(a, b)).range()[0], X4(_mm_max_ps(a, b)).range()[1]]
    },
    |mask, a, b| {
        let bits = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
        let chosen = _mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32(mask as i32), bits), bits);
        _mm256_blendv_ps(b, a, _mm256_castsi256_ps(chosen))
    }
);
lanes!(
    K8,
    8,
    _mm256_add_ps,
    _mm256_sub_ps,
    _mm256_mul_ps,
    _mm256_div_ps,
    _mm256_min_ps,
    _mm256_max_ps,
    _mm256_fmadd_ps,
    _mm256_storeu_ps,
    _mm256_rcp_ps,
    |a| _mm256_andnot_ps(_mm256_set1_ps(-0.0), a),
    |a, b| _mm256_or_ps(_mm256_andnot_ps(_mm256_set1_ps(-0.0), a), _mm256_and_ps(_mm256_set1_ps(-0.0), b)),
    |a, b| u32::from(_mm256_cmp_ps_mask::<_CMP_LE_OQ>(a, b)),
    |a, b| u32::from(_mm256_cmp_ps_mask::<_CMP_LT_OQ>(a, b)),
    |a: __m256| {
        let (a, b) = (_mm256_castps256_ps128(a), _mm256_extractf128_ps::<1>(a));
        [X4(_mm_min_ps(a, b)).range()[0], X4(_mm_max_ps(a, b)).range()[1]]
    },
    |mask, a, b| _mm256_mask_blend_ps(mask as u8, b, a)
);
lanes!(
    K16,
    16,
    _mm512_add_ps,
    _mm512_sub_ps,
    _mm512_mul_ps,
    _mm512_div_ps,
    _mm512_min_ps,
    _mm512_max_ps,
    _mm512_fmadd_ps,
    _mm512_storeu_ps,
    _mm512_rcp14_ps,
    |a| _mm512_abs_ps(a),
    |a, b| _mm512_or_ps(_mm512_abs_ps(a), _mm512_and_ps(_mm512_set1_ps(-0.0), b)),
    |a, b| u32::from(_mm512_cmp_ps_mask::<_CMP_LE_OQ>(a, b)),
    |a, b| u32::from(_mm512_cmp_ps_mask::<_CMP_LT_OQ>(a, b)),
    |a: __m512| [_mm512_reduce_min_ps(a), _mm512_reduce_max_ps(a)],
    |mask, a, b| _mm512_mask_blend_ps(mask as u16, b, a)
);

/// Methods that both instruction sets share.
macro_rules! make {
    ($f4:ident, $f8:ident) => {
        #[inline(always)]
        fn splat4(self, x: f32) -> $f4 {
            // SAFETY: see the head of the file.
            $f4(unsafe { _mm_set1_ps(x) })
        }

        #[inline(always)]
        fn load4(self, from: &[f32; 4]) -> $f4 {
            // SAFETY: see the head of the file.
            $f4(unsafe { _mm_loadu_ps(from.as_ptr()) })
        }

        #[inline(always)]
        fn splat8(self, x: f32) -> $f8 {
            // SAFETY: see the head of the file.
            $f8(unsafe { _mm256_set1_ps(x) })
        }

        #[inline(always)]
        fn load8(self, from: &[f32; 8]) -> $f8 {
            // SAFETY: see the head of the file.
            $f8(unsafe { _mm256_loadu_ps(from.as_ptr()) })
        }

        #[inline(always)]
        fn transpose8(self, rows: [$f8; 8]) -> [$f8; 8] {
            let [a, b, c, d, e, f, g, h] =
                [rows[0].0, rows[1].0, rows[2].0, rows[3].0, rows[4].0, rows[5].0, rows[6].0, rows[7].0];
            // SAFETY: see the head of the file.
            unsafe {
                // Pairs of rows, then groups of four rows within each half, then halves.
                let (ab, ab_high) = (_mm256_unpacklo_ps(a, b), _mm256_unpackhi_ps(a, b));
                let (cd, cd_high) = (_mm256_unpacklo_ps(c, d), _mm256_unpackhi_ps(c, d));
                let (ef, ef_high) = (_mm256_unpacklo_ps(e, f), _mm256_unpackhi_ps(e, f));
                let (gh, gh_high) = (_mm256_unpacklo_ps(g, h), _mm256_unpackhi_ps(g, h));
                let upper = [
                    _mm256_shuffle_ps::<0x44>(ab, cd),
                    _mm256_shuffle_ps::<0xee>(ab, cd),
                    _mm256_shuffle_ps::<0x44>(ab_high, cd_high),
                    _mm256_shuffle_ps::<0xee>(ab_high, cd_high),
                ];
                let lower = [
                    _mm256_shuffle_ps::<0x44>(ef, gh),
                    _mm256_shuffle_ps::<0xee>(ef, gh),
                    _mm256_shuffle_ps::<0x44>(ef_high, gh_high),
                    _mm256_shuffle_ps::<0xee>(ef_high, gh_high),
                ];
                [
                    $f8(_mm256_permute2f128_ps::<0x20>(upper[0], lower[0])),
                    $f8(_mm256_permute2f128_ps::<0x20>(upper[1], lower[1])),
                    $f8(_mm256_permute2f128_ps::<0x20>(upper[2], lower[2])),
                    $f8(_mm256_permute2f128_ps::<0x20>(upper[3], lower[3])),
                    $f8(_mm256_permute2f128_ps::<0x31>(upper[0], lower[0])),
                    $f8(_mm256_permute2f128_ps::<0x31>(upper[1], lower[1])),
                    $f8(_mm256_permute2f128_ps::<0x31>(upper[2], lower[2])),
                    $f8(_mm256_permute2f128_ps::<0x31>(upper[3], lower[3])),
                ]
            }
        }

        #[inline(always)]
        fn prefetch(self, from: *const u8) {
            let from = from.cast::<i8>();
            // SAFETY: a prefetch may use any address.
            unsafe {
                _mm_prefetch::<_MM_HINT_T0>(from);
                _mm_prefetch::<_MM_HINT_T0>(from.wrapping_add(64));
                _mm_prefetch::<_MM_HINT_T0>(from.wrapping_add(128));
                _mm_prefetch::<_MM_HINT_T0>(from.wrapping_add(192));
            }
        }
    };
}

impl Simd for Avx2 {
    type F4 = X4;
    type F8 = X8;
    type Packet = X8;
    const PACKET: usize = 8;

    make!(X4, X8);

    #[inline(always)]
    fn splat_packet(self, x: f32) -> X8 {
        self.splat8(x)
    }

    #[inline(always)]
    fn load_packet(self, from: &[f32; 16]) -> X8 {
        // SAFETY: see the head of the file; the first half is read.
        X8(unsafe { _mm256_loadu_ps(from.as_ptr()) })
    }

    #[inline(always)]
    fn push_ordered(
        self,
        near: X8,
        far: X8,
        children: &[u32; 8],
        order: u32,
        (to_child, to_near): (&mut [u32; 8], &mut [f32; 8]),
    ) -> usize {
        // SAFETY: see the head of the file; loads and stores are of eight lanes.
        unsafe {
            let shifts = _mm256_setr_epi32(0, 3, 6, 9, 12, 15, 18, 21);
            let lanes = _mm256_srlv_epi32(_mm256_set1_epi32(order as i32), shifts);
            let (in_order, far) =
                (_mm256_permutevar8x32_ps(near.0, lanes), _mm256_permutevar8x32_ps(far.0, lanes));
            let hit = _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(in_order, far)) as usize;
            let packed = _mm256_cvtepu8_epi32(_mm_loadl_epi64(PACK[hit].as_ptr().cast()));
            let lanes = _mm256_permutevar8x32_epi32(lanes, packed);
            let child = _mm256_permutevar8x32_epi32(_mm256_loadu_si256(children.as_ptr().cast()), lanes);
            _mm256_storeu_si256(to_child.as_mut_ptr().cast(), child);
            _mm256_storeu_ps(to_near.as_mut_ptr(), _mm256_permutevar8x32_ps(near.0, lanes));
            hit.count_ones() as usize
        }
    }

    #[inline(always)]
    fn push_any(self, hit: u32, children: &[u32; 8], stack: &mut [u32; 8]) -> usize {
        // SAFETY: see the head of the file; loads and stores are of eight lanes.
        unsafe {
            let packed = _mm256_cvtepu8_epi32(_mm_loadl_epi64(PACK[hit as usize & 255].as_ptr().cast()));
            let child = _mm256_permutevar8x32_epi32(_mm256_loadu_si256(children.as_ptr().cast()), packed);
            _mm256_storeu_si256(stack.as_mut_ptr().cast(), child);
        }
        hit.count_ones() as usize
    }

    #[inline(always)]
    fn push_kept(
        self,
        kept: u32,
        children: &[u32; 8],
        near: &[f32; 8],
        to_child: &mut [u32; 8],
        to_near: &mut [f32; 8],
    ) -> usize {
        // SAFETY: see the head of the file; loads and stores are of eight lanes.
        unsafe {
            let child = _mm256_loadu_si256(children.as_ptr().cast());
            let near = _mm256_loadu_ps(near.as_ptr());
            let packed = _mm256_cvtepu8_epi32(_mm_loadl_epi64(PACK[kept as usize & 255].as_ptr().cast()));
            _mm256_storeu_si256(to_child.as_mut_ptr().cast(), _mm256_permutevar8x32_epi32(child, packed));
            _mm256_storeu_ps(to_near.as_mut_ptr(), _mm256_permutevar8x32_ps(near, packed));
        }
        kept.count_ones() as usize
    }
}

/// For each mask, the indices of its set bits, lowest first.
static PACK: [[u8; 8]; 256] = {
    let mut table = [[0; 8]; 256];
    let mut mask = 0;
    while mask < 256 {
        let (mut bit, mut count) = (0, 0);
        while bit < 8 {
            if mask >> bit & 1 != 0 {
                table[mask][count] = bit as u8;
                count += 1;
            }
            bit += 1;
        }
        mask += 1;
    }
    table
};

impl Simd for Avx512 {
    type F4 = X4;
    type F8 = K8;
    type Packet = K16;
    const PACKET: usize = 16;

    make!(X4, K8);

    #[inline(always)]
    fn splat_packet(self, x: f32) -> K16 {
        // SAFETY: see the head of the file.
        K16(unsafe { _mm512_set1_ps(x) })
    }

    #[inline(always)]
    fn load_packet(self, from: &[f32; 16]) -> K16 {
        // SAFETY: see the head of the file.
        K16(unsafe { _mm512_loadu_ps(from.as_ptr()) })
    }

    #[inline(always)]
    fn push_ordered(
        self,
        near: K8,
        far: K8,
        children: &[u32; 8],
        order: u32,
        (to_child, to_near): (&mut [u32; 8], &mut [f32; 8]),
    ) -> usize {
        // SAFETY: see the head of the file; loads and stores are of eight lanes.
        unsafe {
            let shifts = _mm256_setr_epi32(0, 3, 6, 9, 12, 15, 18, 21);
            let lanes = _mm256_srlv_epi32(_mm256_set1_epi32(order as i32), shifts);
            // The permutation uses three bits of each lane.
            let child = _mm256_permutexvar_epi32(lanes, _mm256_loadu_si256(children.as_ptr().cast()));
            let near = _mm256_permutexvar_ps(lanes, near.0);
            let far = _mm256_permutexvar_ps(lanes, far.0);
            let hit = _mm256_cmp_ps_mask::<_CMP_LE_OQ>(near, far);
            // Compress into registers, then store complete vectors: compressing stores are slow on some machines.
            _mm256_storeu_si256(to_child.as_mut_ptr().cast(), _mm256_maskz_compress_epi32(hit, child));
            _mm256_storeu_ps(to_near.as_mut_ptr(), _mm256_maskz_compress_ps(hit, near));
            hit.count_ones() as usize
        }
    }

    #[inline(always)]
    fn push_any(self, hit: u32, children: &[u32; 8], stack: &mut [u32; 8]) -> usize {
        // SAFETY: see the head of the file; loads and stores are of eight lanes.
        unsafe {
            let child = _mm256_loadu_si256(children.as_ptr().cast());
            _mm256_storeu_si256(stack.as_mut_ptr().cast(), _mm256_maskz_compress_epi32(hit as u8, child));
        }
        hit.count_ones() as usize
    }

    #[inline(always)]
    fn push_kept(
        self,
        kept: u32,
        children: &[u32; 8],
        near: &[f32; 8],
        to_child: &mut [u32; 8],
        to_near: &mut [f32; 8],
    ) -> usize {
        // SAFETY: see the head of the file; loads and stores are of eight lanes.
        unsafe {
            let child = _mm256_loadu_si256(children.as_ptr().cast());
            let near = _mm256_loadu_ps(near.as_ptr());
            _mm256_storeu_si256(to_child.as_mut_ptr().cast(), _mm256_maskz_compress_epi32(kept as u8, child));
            _mm256_storeu_ps(to_near.as_mut_ptr(), _mm256_maskz_compress_ps(kept as u8, near));
        }
        kept.count_ones() as usize
    }
}
