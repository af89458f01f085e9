//! How much memory a file may make the importer use.

use std::cell::Cell;

use turner::schema::{Memory, Remedy};

use super::fault::{Fault, Outcome};

/// What any file may use: 256 MiB.
const BASE: u64 = 256 << 20;
/// What it may use beyond that for each of its bytes. Compressed meshes grow by up to 64, parts that share
/// vertices and instances by more.
const PER_BYTE: u64 = 256;

/// Bytes of memory that are left for what a file describes. A few kilobytes can describe any number of meshes
/// that share their vertices.
#[derive(Debug)]
pub(super) struct Budget {
    left: Cell<u64>,
    all: u64,
    help: &'static str,
    remedy: Option<Remedy>,
}

impl Budget {
    /// For a file of so many bytes, those of its buffers included.
    pub(super) fn of_file(bytes: u64) -> Budget {
        let all = BASE.saturating_add(bytes.saturating_mul(PER_BYTE));
        Budget { left: Cell::new(all), all, help: "use a smaller file", remedy: None }
    }

    /// No more than is left of the memory.
    pub(super) fn within(self, memory: &Memory) -> Budget {
        match memory.left() {
            left if left < self.all => Budget {
                left: Cell::new(left),
                all: left,
                help: "raise the limit of memory",
                remedy: Some(Remedy::MoreMemory),
            },
            _ => self,
        }
    }

    /// Takes room for `count` elements of `size` bytes, wanted at `pointer`, before they are allocated.
    pub(super) fn take(&self, count: usize, size: usize, pointer: &str) -> Outcome<()> {
        let bytes = (count as u64).saturating_mul(size as u64);
        match self.left.get().checked_sub(bytes) {
            Some(left) => {
                self.left.set(left);
                Ok(())
            }
            None => Err(Fault::too_large(
                pointer,
                format!(
                    "{count} elements of {size} bytes exceed what is left of {} MiB for this file",
                    self.all >> 20
                ),
            )
            .help(self.help)
            .remedy(self.remedy.clone())),
        }
    }

    /// An empty list with room for `count` elements.
    pub(super) fn list<T>(&self, count: usize, pointer: &str) -> Outcome<Vec<T>> {
        self.take(count, size_of::<T>(), pointer)?;
        let mut list = Vec::new();
        match list.try_reserve_exact(count) {
            Ok(()) => Ok(list),
            Err(_) => Err(Fault::too_large(pointer, format!("not enough memory for {count} elements"))),
        }
    }
}
