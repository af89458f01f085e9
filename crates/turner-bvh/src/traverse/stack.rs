//! What is left to search, nearest on top.

use std::mem::MaybeUninit;

use crate::node::MAX_WIDE_DEPTH;
use crate::simd::{Lanes, Simd};

/// A node leaves at most seven children behind on each level, and pushes write eight at once.
const SIZE: usize = 7 * MAX_WIDE_DEPTH + 8 + 8;

/// Children and the t at which they are entered. Not cleared before use: that would cost as much as a short search.
#[derive(Clone)]
pub(crate) struct Stack {
    children: MaybeUninit<[u32; SIZE]>,
    near: MaybeUninit<[f32; SIZE]>,
    len: usize,
}

impl Stack {
    #[inline(always)]
    pub(crate) fn new() -> Stack {
        // Field by field: building it whole makes the compiler clear the array beside `len`.
        let mut stack = MaybeUninit::<Stack>::uninit();
        // SAFETY: the arrays need no value, and `len` gets one.
        unsafe {
            (&raw mut (*stack.as_mut_ptr()).len).write(0);
            stack.assume_init()
        }
    }

    #[inline(always)]
    pub(crate) fn clear(&mut self) {
        self.len = 0;
    }

    /// Where entry `i` lies. Entries below `len` were written, and `len` is at most `SIZE - 8` (see there).
    #[inline(always)]
    fn child(&mut self, i: usize) -> *mut u32 {
        debug_assert!(i + 8 <= SIZE);
        // SAFETY: within the array, as depth is limited.
        unsafe { self.children.as_mut_ptr().cast::<u32>().add(i) }
    }

    #[inline(always)]
    fn entry(&mut self, i: usize) -> *mut f32 {
        debug_assert!(i + 8 <= SIZE);
        // SAFETY: within the array, as depth is limited.
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

    /// Takes the top child of a stack that is not empty.
    #[inline(always)]
    pub(crate) fn take(&mut self) -> u32 {
        debug_assert!(self.len > 0);
        self.len = self.len.wrapping_sub(1);
        // SAFETY: as in `pop`.
        unsafe { self.child(self.len).read() }
    }

    /// Removes what is entered behind `t`.
    #[inline(always)]
    pub(crate) fn sweep<S: Simd>(&mut self, simd: S, t: f32) {
        let len = self.len;
        self.len = 0;
        let mut from = 0;
        while from < len {
            // SAFETY: eight entries may be read from anywhere below `len`: SIZE leaves room, and what lies beyond is
            // whatever was written there by a push of eight, or nothing yet; it is kept out by the mask.
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

    /// The child that `pop` would give.
    #[inline(always)]
    pub(crate) fn top(&mut self) -> Option<u32> {
        // SAFETY: as in `pop`.
        (self.len != 0).then(|| unsafe { self.child(self.len - 1).read() })
    }

    /// Room for eight more, to be followed by `grow`.
    #[inline(always)]
    pub(crate) fn room(&mut self) -> (&mut [u32; 8], &mut [f32; 8]) {
        debug_assert!(self.len + 8 <= SIZE);
        // SAFETY: depth is limited, so that there is always room for eight (see SIZE). Vectors are written there before
        // anything is read, and any bits are a number.
        unsafe {
            (&mut *self.child(self.len).cast::<[u32; 8]>(), &mut *self.entry(self.len).cast::<[f32; 8]>())
        }
    }

    #[inline(always)]
    pub(crate) fn grow(&mut self, count: usize) {
        self.len += count;
    }
}
