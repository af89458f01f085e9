//! Limits on memory and triangles, checked before memory is allocated.
//!
//! A file may describe a scene of any size, and a failed allocation aborts the program. So code that is about to
//! allocate much memory first calls [`Memory::need`], once per file, mesh, BVH or film, never per element. The memory
//! in use is the process's resident memory as reported by the operating system, so nothing has to be released. On
//! systems that do not report it, the sum of all requests counts.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use crate::schema::{ErrorCode, Remedy, SceneError};

/// Returns the memory of the process in bytes, if the system reports it.
pub type Gauge = fn() -> Option<u64>;

/// Requests below this many bytes are granted without querying the system: 64 KiB.
const SMALL: u64 = 1 << 16;

/// Limits on memory and triangles. Clones share the count of memory in use.
#[derive(Clone)]
pub struct Limits {
    /// The limit on memory.
    pub memory: Arc<Memory>,
    /// Maximum number of triangles of all meshes. A mesh counts once, independent of the number of its instances.
    pub max_triangles: u64,
}

impl Default for Limits {
    /// No limits.
    fn default() -> Limits {
        Limits { memory: Arc::default(), max_triangles: u64::MAX }
    }
}

impl PartialEq for Limits {
    fn eq(&self, other: &Limits) -> bool {
        (self.memory.limit, self.max_triangles) == (other.memory.limit, other.max_triangles)
    }
}

impl std::fmt::Debug for Limits {
    /// The limits, without the memory in use.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Limits")
            .field("memory", &self.memory.limit)
            .field("max_triangles", &self.max_triangles)
            .finish()
    }
}

impl Limits {
    /// Checks a number of triangles. `what` is the subject of the message.
    ///
    /// Errors: more than `max_triangles`.
    pub fn check_triangles(&self, count: u64, what: impl FnOnce() -> String) -> Result<(), SceneError> {
        if count <= self.max_triangles {
            return Ok(());
        }
        let message = format!("{} has {count} triangles; expected at most {}", what(), self.max_triangles);
        Err(SceneError::new(ErrorCode::TooLarge, message)
            .help("raise the limit of triangles, or use a mesh with fewer triangles")
            .remedy(Remedy::MoreTriangles))
    }
}

/// A limit on memory.
pub struct Memory {
    limit: u64,
    gauge: Gauge,
    /// Bytes granted so far; counts if the system does not report memory.
    granted: AtomicU64,
    /// Bytes granted for later allocation.
    promised: AtomicU64,
    /// The current work, for messages.
    work: Mutex<String>,
}

impl std::fmt::Debug for Memory {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Memory").field("limit", &self.limit).finish_non_exhaustive()
    }
}

impl Default for Memory {
    fn default() -> Memory {
        Memory::new(u64::MAX, || None)
    }
}

impl Memory {
    /// A limit of `limit` bytes; `gauge` reports the memory in use.
    pub fn new(limit: u64, gauge: Gauge) -> Memory {
        let (granted, promised) = (AtomicU64::new(0), AtomicU64::new(0));
        Memory { limit, gauge, granted, promised, work: Mutex::default() }
    }

    /// The limit in bytes.
    pub fn limit(&self) -> u64 {
        self.limit
    }

    /// Memory of the process in bytes, if the system reports it.
    pub fn in_use(&self) -> Option<u64> {
        (self.gauge)()
    }

    /// Bytes that may still be allocated.
    pub fn left(&self) -> u64 {
        if self.limit == u64::MAX {
            return u64::MAX;
        }
        let used = self.in_use().unwrap_or_else(|| self.granted.load(Ordering::Relaxed));
        self.limit.saturating_sub(used.saturating_add(self.promised.load(Ordering::Relaxed)))
    }

    /// Requests `bytes` that are allocated immediately. `what` is the subject of the message, e.g. "the film of 64x64
    /// pixels".
    ///
    /// Errors: more than [`Memory::left`].
    pub fn need(&self, bytes: u64, what: impl FnOnce() -> String) -> Result<(), SceneError> {
        if self.limit == u64::MAX {
            return Ok(());
        }
        if bytes >= SMALL {
            let left = self.left();
            if bytes > left {
                return Err(self.refused(bytes, left, &what()));
            }
        }
        self.granted.fetch_add(bytes, Ordering::Relaxed);
        Ok(())
    }

    /// Requests `bytes` that are allocated later. They count as used from this call on.
    ///
    /// Errors: more than [`Memory::left`].
    pub fn promise(&self, bytes: u64, what: impl FnOnce() -> String) -> Result<(), SceneError> {
        self.need(bytes, what)?;
        if self.limit != u64::MAX && self.in_use().is_some() {
            self.promised.fetch_add(bytes, Ordering::Relaxed);
        }
        Ok(())
    }

    /// Sets the current work, which [`Memory::exhausted`] names.
    pub fn begin(&self, work: impl Into<String>) {
        *self.work.lock().unwrap_or_else(PoisonError::into_inner) = work.into();
    }

    /// The error for memory that ran out during the current work.
    pub fn exhausted(&self) -> SceneError {
        let work = self.work.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let work = if work.is_empty() { "this scene".to_owned() } else { work };
        let message = format!("{work} needs more memory than the limit of {}", in_words(self.limit));
        SceneError::new(ErrorCode::TooLarge, message).help(HELP).remedy(Remedy::MoreMemory)
    }

    fn refused(&self, bytes: u64, left: u64, what: &str) -> SceneError {
        let message = format!(
            "{what} needs {} of memory; expected at most {}, the rest of the limit of {}",
            in_words(bytes),
            in_words(left),
            in_words(self.limit)
        );
        SceneError::new(ErrorCode::TooLarge, message).help(HELP).remedy(Remedy::MoreMemory)
    }
}

const HELP: &str = "raise the memory limit, or make the scene smaller";

/// Bytes as text, e.g. `1.5 GiB`, rounded up so that a request never looks smaller than it is.
fn in_words(bytes: u64) -> String {
    let units = [("GiB", 30), ("MiB", 20), ("KiB", 10)];
    match units.iter().find(|(_, shift)| bytes >> shift > 0) {
        Some((unit, shift)) => {
            let tenths = (u128::from(bytes) * 10).div_ceil(1 << shift);
            match tenths % 10 {
                0 => format!("{} {unit}", tenths / 10),
                part => format!("{}.{part} {unit}", tenths / 10),
            }
        }
        None => format!("{bytes} bytes"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_that_the_system_reports_counts() {
        let memory = Memory::new(10 << 20, || Some(4 << 20));
        assert_eq!(memory.left(), 6 << 20);
        // Nothing has to be released.
        for _ in 0..3 {
            memory.need(6 << 20, || unreachable!()).unwrap();
        }
        let error = memory.need((6 << 20) + 1, || "the mesh a.ply".into()).unwrap_err();
        assert_eq!(error.code, ErrorCode::TooLarge);
        assert_eq!(
            error.message,
            "the mesh a.ply needs 6.1 MiB of memory; expected at most 6 MiB, the rest of the limit of 10 MiB"
        );
        assert_eq!(error.remedy.as_deref(), Some(&Remedy::MoreMemory));
        memory.promise(2 << 20, || unreachable!()).unwrap();
        assert_eq!(memory.left(), 4 << 20);
    }

    #[test]
    fn without_a_report_the_sum_of_all_requests_counts() {
        let memory = Memory::new(10 << 20, || None);
        memory.need(6 << 20, || unreachable!()).unwrap();
        assert!(memory.need(6 << 20, String::new).is_err());
        memory.promise(4 << 20, || unreachable!()).unwrap();
        assert_eq!(memory.left(), 0);
    }

    #[test]
    fn without_a_limit_nothing_is_refused() {
        let memory = Memory::default();
        assert_eq!(memory.left(), u64::MAX);
        memory.need(u64::MAX, || unreachable!()).unwrap();
        memory.need(u64::MAX, || unreachable!()).unwrap();
        memory.promise(u64::MAX, || unreachable!()).unwrap();
    }

    #[test]
    fn triangles_are_counted_against_their_limit() {
        let limits = Limits { max_triangles: 12, ..Limits::default() };
        limits.check_triangles(12, || unreachable!()).unwrap();
        let error = limits.check_triangles(13, || "a.ply".into()).unwrap_err();
        assert!(error.message.contains("a.ply has 13 triangles") && error.message.contains("12"), "{error}");
        assert_eq!(error.remedy.as_deref(), Some(&Remedy::MoreTriangles));
    }

    #[test]
    fn bytes_are_rounded_up() {
        assert_eq!(in_words(4 << 30), "4 GiB");
        assert_eq!(in_words((1 << 30) + 1), "1.1 GiB");
        assert_eq!(in_words(3 << 19), "1.5 MiB");
        assert_eq!(in_words(1023), "1023 bytes");
        assert!(in_words(u64::MAX).starts_with("17179869184 GiB"));
    }
}
