//! The instruction sets that traversal is compiled for, and which of them this machine supports.

use std::fmt;

use super::Simd;
#[cfg(not(all(target_arch = "wasm32", target_feature = "simd128")))]
use super::portable::Portable;
#[cfg(target_arch = "x86_64")]
use super::x86::{Avx2, Avx512};

/// An instruction set that this machine supports; a value of the type proves it. Results are the same bit for bit for
/// all sets.
///
/// Nothing reads the environment: to use another set than the [best](InstructionSet::best) one, pass it in, for example
/// with [`BuildOptions`](crate::BuildOptions).
///
/// ```
/// use turner_bvh::InstructionSet;
///
/// let best = InstructionSet::best();
/// assert_eq!(InstructionSet::named(best.name()), Some(best));
/// assert_eq!(InstructionSet::named("scalar"), Some(InstructionSet::PORTABLE));
/// assert_eq!(InstructionSet::named("abacus"), None);
/// ```
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct InstructionSet(Kind);

/// The sets of this architecture, best last.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Kind {
    /// Baseline instructions of the target.
    Scalar,
    #[cfg(target_arch = "aarch64")]
    Neon,
    /// The 128-bit SIMD of WebAssembly.
    #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
    Simd128,
    /// AVX2, FMA and BMI.
    #[cfg(target_arch = "x86_64")]
    Avx2,
    /// AVX-512 F, VL, BW and DQ.
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl Kind {
    const ALL: &'static [Kind] = &[
        Kind::Scalar,
        #[cfg(target_arch = "aarch64")]
        Kind::Neon,
        #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
        Kind::Simd128,
        #[cfg(target_arch = "x86_64")]
        Kind::Avx2,
        #[cfg(target_arch = "x86_64")]
        Kind::Avx512,
    ];

    /// Whether this machine supports it.
    fn is_available(self) -> bool {
        match self {
            Kind::Scalar => true,
            #[cfg(target_arch = "aarch64")]
            Kind::Neon => true,
            #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
            Kind::Simd128 => true,
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2 => {
                is_x86_feature_detected!("avx2")
                    && is_x86_feature_detected!("fma")
                    && is_x86_feature_detected!("bmi1")
                    && is_x86_feature_detected!("bmi2")
                    && is_x86_feature_detected!("lzcnt")
                    && is_x86_feature_detected!("popcnt")
            }
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512 => {
                Kind::Avx2.is_available()
                    && is_x86_feature_detected!("avx512f")
                    && is_x86_feature_detected!("avx512vl")
                    && is_x86_feature_detected!("avx512bw")
                    && is_x86_feature_detected!("avx512dq")
            }
        }
    }
}

impl InstructionSet {
    /// The baseline of the target, supported by every machine: `scalar`.
    pub const PORTABLE: InstructionSet = InstructionSet(Kind::Scalar);

    /// The sets that this machine supports, best last.
    pub fn available() -> impl Iterator<Item = InstructionSet> {
        Kind::ALL.iter().filter(|kind| kind.is_available()).map(|kind| InstructionSet(*kind))
    }

    /// The best set that this machine supports.
    pub fn best() -> InstructionSet {
        InstructionSet::available().last().unwrap_or(InstructionSet::PORTABLE)
    }

    /// The set with this [name](InstructionSet::name), in any case. `None` if the name is unknown or this machine does
    /// not support the set.
    pub fn named(name: &str) -> Option<InstructionSet> {
        InstructionSet::available().find(|set| set.name().eq_ignore_ascii_case(name))
    }

    /// The name: `scalar`, `neon`, `simd128`, `avx2` or `avx512`.
    pub const fn name(self) -> &'static str {
        match self.0 {
            Kind::Scalar => "scalar",
            #[cfg(target_arch = "aarch64")]
            Kind::Neon => "neon",
            #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
            Kind::Simd128 => "simd128",
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2 => "avx2",
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512 => "avx512",
        }
    }

    /// The kind of the set.
    #[inline(always)]
    pub(crate) fn kind(self) -> Kind {
        self.0
    }
}

impl Default for InstructionSet {
    /// [`InstructionSet::best`].
    fn default() -> InstructionSet {
        InstructionSet::best()
    }
}

impl fmt::Debug for InstructionSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("InstructionSet").field(&self.0).finish()
    }
}

impl fmt::Display for InstructionSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Work that runs with any instruction set.
pub(crate) trait WithSimd {
    type Output;

    /// Mark it and everything it calls `#[inline(always)]`: only inlined code gets the target features.
    fn run<S: Simd>(self, simd: S) -> Self::Output;
}

/// Runs `work` with an instruction set.
#[inline(always)]
pub(crate) fn dispatch<W: WithSimd>(set: InstructionSet, work: W) -> W::Output {
    match set.kind() {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: an `InstructionSet` exists only for sets that this machine supports.
        Kind::Avx512 => unsafe { run_avx512(work) },
        #[cfg(target_arch = "x86_64")]
        // SAFETY: as above.
        Kind::Avx2 => unsafe { run_avx2(work) },
        #[cfg(target_arch = "aarch64")]
        Kind::Neon => work.run(super::neon::Neon::new()),
        #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
        Kind::Simd128 => work.run(super::simd128::Simd128::new()),
        // A second copy of the traversal would take a tenth of a page's download.
        #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
        Kind::Scalar => work.run(super::simd128::Simd128::new()),
        #[cfg(not(all(target_arch = "wasm32", target_feature = "simd128")))]
        Kind::Scalar => run_portable(work),
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512vl,avx512bw,avx512dq,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
unsafe fn run_avx512<W: WithSimd>(work: W) -> W::Output {
    // SAFETY: the caller has these target features.
    work.run(unsafe { Avx512::new() })
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
unsafe fn run_avx2<W: WithSimd>(work: W) -> W::Output {
    // SAFETY: the caller has these target features.
    work.run(unsafe { Avx2::new() })
}

#[cfg(not(all(target_arch = "wasm32", target_feature = "simd128")))]
fn run_portable<W: WithSimd>(work: W) -> W::Output {
    work.run(Portable)
}
