//! The memory budget of a file: how much memory the importer may use for its content.

use std::cell::Cell;

use turner::schema::{Memory, Remedy};

use super::fault::{Fault, Outcome};

/// Bytes that any file may use: 256 MiB.
const BASE: u64 = 256 << 20;
/// Additional bytes for each byte of the file. Compressed meshes expand by up to 64; shared vertices and instances by
/// more.
const PER_BYTE: u64 = 256;

/// The remaining bytes for the content of a file. A budget is needed because a few kilobytes can describe any number
/// of meshes that share their vertices.
#[derive(Debug)]
pub(super) struct Budget {
    left: Cell<u64>,
    all: u64,
    help: &'static str,
    remedy: Option<Remedy>,
}

impl Budget {
    /// The budget of a file of this many bytes, including its buffers.
    pub(super) fn of_file(bytes: u64) -> Budget {
        let all = BASE.saturating_add(bytes.saturating_mul(PER_BYTE));
        Budget { left: Cell::new(all), all, help: "use a smaller file", remedy: None }
    }

    /// Limits the budget to the available memory.
    pub(super) fn within(self, memory: &Memory) -> Budget {
        match memory.left() {
            left if left < self.all => Budget {
                left: Cell::new(left),
                all: left,
                help: "raise the memory limit",
                remedy: Some(Remedy::MoreMemory),
            },
            _ => self,
        }
    }

    /// Charges `count` elements of `size` bytes before they are allocated. `pointer` is the JSON pointer of what
    /// needs them.
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
                    "{count} elements of {size} bytes exceed the memory budget of {} MiB for this file",
                    self.all >> 20
                ),
            )
            .help(self.help)
            .remedy(self.remedy.clone())),
        }
    }

    /// An empty list with capacity for `count` elements, charged to the budget.
    pub(super) fn list<T>(&self, count: usize, pointer: &str) -> Outcome<Vec<T>> {
        self.take(count, size_of::<T>(), pointer)?;
        let mut list = Vec::new();
        match list.try_reserve_exact(count) {
            Ok(()) => Ok(list),
            Err(_) => Err(Fault::too_large(pointer, format!("not enough memory for {count} elements"))),
        }
    }
}
