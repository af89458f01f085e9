//! Faults of KTX2 files, without the file's name.

/// Why a file could not be read.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Fault {
    /// The file is not valid.
    Damaged(String),
    /// The file is valid but uses an unsupported feature.
    Unsupported {
        /// The feature.
        found: String,
        /// What is supported.
        expected: &'static str,
    },
    /// Out of memory for this many bytes.
    Memory(u64),
}

/// A result with a [`Fault`].
pub(super) type Outcome<T> = Result<T, Fault>;

impl Fault {
    pub(super) fn damaged(problem: impl Into<String>) -> Fault {
        Fault::Damaged(problem.into())
    }

    pub(super) fn unsupported(found: impl Into<String>, expected: &'static str) -> Fault {
        Fault::Unsupported { found: found.into(), expected }
    }
}

/// A list of `len` default values.
pub(super) fn list<T: Clone + Default>(len: usize) -> Outcome<Vec<T>> {
    let mut list = Vec::new();
    let bytes = (len as u64).saturating_mul(size_of::<T>() as u64);
    list.try_reserve_exact(len).map_err(|_| Fault::Memory(bytes))?;
    list.resize(len, T::default());
    Ok(list)
}
