//! The traversal stack: children to visit, nearest on top.

use std::mem::MaybeUninit;

use crate::node::MAX_WIDE_DEPTH;
use crate::simd::{Lanes, Simd};

/// Each level leaves at most seven children on the stack, and pushes write eight at once.
const SIZE: usize = 7 * MAX_WIDE_DEPTH + 8 + 8;

/// Children and their entry t. Not initialised: that would cost as much as a short traversal.
#[derive(Clone)]
pub(crate) struct Stack {
    children: MaybeUninit<[u32; SIZE]>,
    near: MaybeUninit<[f32; SIZE]>,
    len: usize,
}

impl Stack {
    #[inline(always)]
    pub(crate) fn new() -> Stack {
        // Field by field: writing the complete value makes the compiler clear the arrays.
        let mut stack = MaybeUninit::<Stack>::uninit();
        // SAFETY: the arrays are `MaybeUninit`, and `len` is written.
        unsafe {
            (&raw mut (*stack.as_mut_ptr()).len).write(0);
            stack.assume_init()
        }
    }

    #[inline(always)]
    pub(crate) fn clear(&mut self) {
        self.len = 0;
    }

    /// Pointer to entry `i`. Entries below `len` were written, and `len` is at most `SIZE - 8`.
    #[inline(always)]
    fn child(&mut self, i: usize) -> *mut u32 {
        debug_assert!(i + 8 <= SIZE);
        // SAFETY: within the array, because the depth is bounded.
        unsafe { self.children.as_mut_ptr().cast::<u32>().add(i) }
    }

    #[inline(always)]
    fn entry(&mut self, i: usize) -> *mut f32 {
        debug_assert!(i + 8 <= SIZE);
        // SAFETY: within the array, because the depth is bounded.
        unsafe { self.near.as_mut_ptr().cast::<f32>().add(i) }
    }

    #[inline(always)]
    pub(crate) fn push(&mut self, child: u32, near: f32) {
        // SAFETY: `len` is within the arrays.
        unsafe {
            self.child(self.len).write(child);
            self.entry(self.len).write(near);
        }
        self.len += 1;
    }

    #[inline(always)]
    pub(crate) fn pop(&mut self) -> Option<(u32, f32)> {
        if self.len == 0 {
            return None;
        }
        self.len -= 1;
        // SAFETY: everything below the old `len` was written.
        unsafe { Some((self.child(self.len).read(), self.entry(self.len).read())) }
    }

    #[inline(always)]
    pub(crate) fn pop_child(&mut self) -> Option<u32> {
        let top = self.top();
        self.len = self.len.saturating_sub(1);
        top
    }

    /// Pops the top child; the stack must not be empty.
    #[inline(always)]
    pub(crate) fn take(&mut self) -> u32 {
        debug_assert!(self.len > 0);
        self.len = self.len.wrapping_sub(1);
        // SAFETY: as in `pop`.
        unsafe { self.child(self.len).read() }
    }

    /// Removes entries with an entry distance beyond `t`.
    #[inline(always)]
    pub(crate) fn sweep<S: Simd>(&mut self, simd: S, t: f32) {
        let len = self.len;
        self.len = 0;
        let mut from = 0;
        while from < len {
            // SAFETY: eight entries may be read from any index below `len`, because SIZE leaves room for eight more.
            // Entries from `len` on were written by an earlier push of eight or never; the mask excludes them.
            let (children, near) =
                unsafe { (*self.child(from).cast::<[u32; 8]>(), *self.entry(from).cast::<[f32; 8]>()) };
            let valid = if len - from >= 8 { 255 } else { (1 << (len - from)) - 1 };
            let kept = simd.load8(&near).le(simd.splat8(t)) & valid;
            let (to_child, to_near) = self.room();
            let count = simd.push_kept(kept, &children, &near, to_child, to_near);
            self.len += count;
            from += 8;
        }
    }

    /// The child that `pop` would return.
    #[inline(always)]
    pub(crate) fn top(&mut self) -> Option<u32> {
        // SAFETY: as in `pop`.
        (self.len != 0).then(|| unsafe { self.child(self.len - 1).read() })
    }

    /// Space for eight more entries; call `grow` afterwards.
    #[inline(always)]
    pub(crate) fn room(&mut self) -> (&mut [u32; 8], &mut [f32; 8]) {
        debug_assert!(self.len + 8 <= SIZE);
        // SAFETY: the depth is bounded, so eight more entries fit (see SIZE). They are written before they are read,
        // and any bits are valid numbers.
        unsafe {
            (&mut *self.child(self.len).cast::<[u32; 8]>(), &mut *self.entry(self.len).cast::<[f32; 8]>())
        }
    }

    #[inline(always)]
    pub(crate) fn grow(&mut self, count: usize) {
        self.len += count;
    }
}
