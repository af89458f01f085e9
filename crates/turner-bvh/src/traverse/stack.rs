//! What is left to search, nearest on top.

use std::mem::MaybeUninit;

use crate::node::MAX_WIDE_DEPTH;

/// A node leaves at most seven children behind on each level, and pushes write eight at once.
const SIZE: usize = 7 * MAX_WIDE_DEPTH + 8 + 8;

/// Children and the t at which they are entered. Not cleared before use: that would cost as much as a short search.
pub(crate) struct Stack {
    children: [MaybeUninit<u32>; SIZE],
    near: [MaybeUninit<f32>; SIZE],
    len: usize,
}

impl Stack {
    #[inline(always)]
    pub(crate) fn new() -> Stack {
        Stack { children: [MaybeUninit::uninit(); SIZE], near: [MaybeUninit::uninit(); SIZE], len: 0 }
    }

    #[inline(always)]
    pub(crate) fn clear(&mut self) {
        self.len = 0;
    }

    #[inline(always)]
    pub(crate) fn push(&mut self, child: u32, near: f32) {
        self.children[self.len].write(child);
        self.near[self.len].write(near);
        self.len += 1;
    }

    #[inline(always)]
    pub(crate) fn is_empty(&self) -> bool {
        self.len == 0
    }

    #[inline(always)]
    pub(crate) fn pop(&mut self) -> Option<(u32, f32)> {
        if self.len == 0 {
            return None;
        }
        self.len -= 1;
        // SAFETY: everything below `len` was written, and `len` is within the arrays.
        unsafe {
            Some((
                self.children.get_unchecked(self.len).assume_init(),
                self.near.get_unchecked(self.len).assume_init(),
            ))
        }
    }

    #[inline(always)]
    pub(crate) fn pop_child(&mut self) -> Option<u32> {
        let top = self.top();
        self.len = self.len.saturating_sub(1);
        top
    }

    /// The child that `pop` would give.
    #[inline(always)]
    pub(crate) fn top(&self) -> Option<u32> {
        // SAFETY: as in `pop`.
        (self.len != 0).then(|| unsafe { self.children.get_unchecked(self.len - 1).assume_init() })
    }

    /// Room for eight more, to be followed by `grow`.
    #[inline(always)]
    pub(crate) fn room(&mut self) -> (&mut [u32; 8], &mut [f32; 8]) {
        debug_assert!(self.len + 8 <= SIZE);
        // SAFETY: depth is limited, so that there is always room for eight (see SIZE). Vectors are written there before
        // anything is read, and any bits are a number.
        unsafe {
            (
                &mut *self.children.as_mut_ptr().add(self.len).cast::<[u32; 8]>(),
                &mut *self.near.as_mut_ptr().add(self.len).cast::<[f32; 8]>(),
            )
        }
    }

    #[inline(always)]
    pub(crate) fn grow(&mut self, count: usize) {
        self.len += count;
    }
}
