//! Which kernels there are, and which one this machine runs.

use std::fmt;
use std::str::FromStr;
use std::sync::atomic::{AtomicU8, Ordering};

use super::Simd;
use super::portable::Portable;
#[cfg(target_arch = "x86_64")]
use super::x86::{Avx2, Avx512};

/// A set of instructions that searches can use. All give the same hits, bit for bit.
///
/// The best one this machine has is taken, unless the environment variable `TURNER_KERNEL` names another or
/// [`Kernel::force`] chose one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Kernel {
    /// Baseline instructions of the target.
    Scalar = 1,
    /// NEON, on 64-bit Arm.
    Neon = 2,
    /// AVX2 and FMA, on x86-64.
    Avx2 = 3,
    /// AVX-512 F, VL, BW and DQ, on x86-64.
    Avx512 = 4,
}

/// The kernel in use; 0 until the first search.
static CHOSEN: AtomicU8 = AtomicU8::new(0);

impl Kernel {
    /// All kernels, the best last.
    pub const ALL: [Kernel; 4] = [Kernel::Scalar, Kernel::Neon, Kernel::Avx2, Kernel::Avx512];

    /// Whether this machine can run it.
    pub fn is_available(self) -> bool {
        match self {
            Kernel::Scalar => true,
            Kernel::Neon => cfg!(target_arch = "aarch64"),
            #[cfg(target_arch = "x86_64")]
            Kernel::Avx2 => ["avx2", "fma", "bmi1", "bmi2", "lzcnt", "popcnt"].into_iter().all(has),
            #[cfg(target_arch = "x86_64")]
            Kernel::Avx512 => {
                Kernel::Avx2.is_available()
                    && ["avx512f", "avx512vl", "avx512bw", "avx512dq"].into_iter().all(has)
            }
            #[cfg(not(target_arch = "x86_64"))]
            Kernel::Avx2 | Kernel::Avx512 => false,
        }
    }

    /// The kernels that this machine can run, the best last.
    pub fn available() -> impl Iterator<Item = Kernel> {
        Kernel::ALL.into_iter().filter(|k| k.is_available())
    }

    /// The kernel that searches use now.
    #[inline]
    pub fn current() -> Kernel {
        match CHOSEN.load(Ordering::Relaxed) {
            1 => Kernel::Scalar,
            2 => Kernel::Neon,
            3 => Kernel::Avx2,
            4 => Kernel::Avx512,
            _ => Kernel::choose(),
        }
    }

    #[cold]
    fn choose() -> Kernel {
        let best = Kernel::available().last().unwrap_or(Kernel::Scalar);
        // A name that is not known, or not for this machine, is as good as none: the hits are the same.
        let asked = std::env::var("TURNER_KERNEL").ok().and_then(|name| name.parse().ok());
        let kernel = asked.filter(|k: &Kernel| k.is_available()).unwrap_or(best);
        CHOSEN.store(kernel as u8, Ordering::Relaxed);
        kernel
    }

    /// Makes all searches of this process use a kernel from now on, for tests and comparisons. Returns whether this
    /// machine can run it; if not, nothing changes.
    pub fn force(self) -> bool {
        let available = self.is_available();
        if available {
            CHOSEN.store(self as u8, Ordering::Relaxed);
        }
        available
    }

    /// Its name, as `TURNER_KERNEL` takes it.
    pub const fn name(self) -> &'static str {
        match self {
            Kernel::Scalar => "scalar",
            Kernel::Neon => "neon",
            Kernel::Avx2 => "avx2",
            Kernel::Avx512 => "avx512",
        }
    }
}

#[cfg(target_arch = "x86_64")]
fn has(feature: &str) -> bool {
    match feature {
        "avx2" => is_x86_feature_detected!("avx2"),
        "fma" => is_x86_feature_detected!("fma"),
        "bmi1" => is_x86_feature_detected!("bmi1"),
        "bmi2" => is_x86_feature_detected!("bmi2"),
        "lzcnt" => is_x86_feature_detected!("lzcnt"),
        "popcnt" => is_x86_feature_detected!("popcnt"),
        "avx512f" => is_x86_feature_detected!("avx512f"),
        "avx512vl" => is_x86_feature_detected!("avx512vl"),
        "avx512bw" => is_x86_feature_detected!("avx512bw"),
        "avx512dq" => is_x86_feature_detected!("avx512dq"),
        _ => false,
    }
}

impl fmt::Display for Kernel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// The name is not that of a kernel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnknownKernel;

impl fmt::Display for UnknownKernel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "not a kernel: scalar, neon, avx2 or avx512")
    }
}

impl std::error::Error for UnknownKernel {}

impl FromStr for Kernel {
    type Err = UnknownKernel;

    fn from_str(name: &str) -> Result<Kernel, UnknownKernel> {
        Kernel::ALL.into_iter().find(|k| k.name().eq_ignore_ascii_case(name)).ok_or(UnknownKernel)
    }
}

/// Something to do with whatever instructions there are.
pub(crate) trait WithSimd {
    type Output;

    /// To be marked `#[inline(always)]`, like all it calls: only what is inlined gets the instructions.
    fn run<S: Simd>(self, simd: S) -> Self::Output;
}

/// Runs `work` with the instructions of the current kernel.
#[inline(always)]
pub(crate) fn dispatch<W: WithSimd>(work: W) -> W::Output {
    match Kernel::current() {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: `current` and `force` give only kernels that this machine can run.
        Kernel::Avx512 => unsafe { run_avx512(work) },
        #[cfg(target_arch = "x86_64")]
        // SAFETY: as above.
        Kernel::Avx2 => unsafe { run_avx2(work) },
        #[cfg(target_arch = "aarch64")]
        Kernel::Neon => work.run(super::neon::Neon::new()),
        _ => run_portable(work),
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
