//! The instruction sets that searches are compiled for, and which of them this machine has.

use std::fmt;

use super::Simd;
use super::portable::Portable;
#[cfg(target_arch = "x86_64")]
use super::x86::{Avx2, Avx512};

/// A set of instructions that this machine has: a value of the type is the proof. All sets give the same bits.
///
/// Nothing here reads the environment or a setting of the process: whoever wants another set than the
/// [best](InstructionSet::best) one passes it in, with [`BuildOptions`](crate::BuildOptions) for instance.
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

/// The sets that there are for this architecture, the best last.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Kind {
    /// Baseline instructions of the target.
    Scalar,
    #[cfg(target_arch = "aarch64")]
    Neon,
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
        #[cfg(target_arch = "x86_64")]
        Kind::Avx2,
        #[cfg(target_arch = "x86_64")]
        Kind::Avx512,
    ];

    /// Whether this machine can run it.
    fn is_available(self) -> bool {
        match self {
            Kind::Scalar => true,
            #[cfg(target_arch = "aarch64")]
            Kind::Neon => true,
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
    /// The baseline of the target, which every machine has: `scalar`.
    pub const PORTABLE: InstructionSet = InstructionSet(Kind::Scalar);

    /// The sets that this machine has, the best last.
    pub fn available() -> impl Iterator<Item = InstructionSet> {
        Kind::ALL.iter().filter(|kind| kind.is_available()).map(|kind| InstructionSet(*kind))
    }

    /// The best one that this machine has.
    pub fn best() -> InstructionSet {
        InstructionSet::available().last().unwrap_or(InstructionSet::PORTABLE)
    }

    /// The set of this [name](InstructionSet::name), upper case or lower; `None` where there is no such set, or this machine
    /// does not have it.
    pub fn named(name: &str) -> Option<InstructionSet> {
        InstructionSet::available().find(|set| set.name().eq_ignore_ascii_case(name))
    }

    /// Its name: `scalar`, `neon`, `avx2` or `avx512`.
    pub const fn name(self) -> &'static str {
        match self.0 {
            Kind::Scalar => "scalar",
            #[cfg(target_arch = "aarch64")]
            Kind::Neon => "neon",
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2 => "avx2",
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512 => "avx512",
        }
    }

    /// Which one it is.
    #[inline(always)]
    pub(crate) fn kind(self) -> Kind {
        self.0
    }
}

impl Default for InstructionSet {
    /// The [best](InstructionSet::best) one.
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

/// Something to do with whatever instructions there are.
pub(crate) trait WithSimd {
    type Output;

    /// To be marked `#[inline(always)]`, like all it calls: only what is inlined gets the instructions.
    fn run<S: Simd>(self, simd: S) -> Self::Output;
}

/// Runs `work` with an instruction set.
#[inline(always)]
pub(crate) fn dispatch<W: WithSimd>(set: InstructionSet, work: W) -> W::Output {
    match set.kind() {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: there are values only of sets that this machine has.
        Kind::Avx512 => unsafe { run_avx512(work) },
        #[cfg(target_arch = "x86_64")]
        // SAFETY: as above.
        Kind::Avx2 => unsafe { run_avx2(work) },
        #[cfg(target_arch = "aarch64")]
        Kind::Neon => work.run(super::neon::Neon::new()),
        Kind::Scalar => run_portable(work),
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512vl,avx512bw,avx512dq,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
unsafe fn run_avx512<W: WithSimd>(work: W) -> W::Output {
    // SAFETY: the caller has these instructions.
    work.run(unsafe { Avx512::new() })
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
unsafe fn run_avx2<W: WithSimd>(work: W) -> W::Output {
    // SAFETY: the caller has these instructions.
    work.run(unsafe { Avx2::new() })
}

fn run_portable<W: WithSimd>(work: W) -> W::Output {
    work.run(Portable)
}
