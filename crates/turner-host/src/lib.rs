//! What differs between an operating system and a web page: threads and the clock.
//!
//! On an operating system these are the standard library's. A web page cannot start threads in WebAssembly; its script
//! starts workers, each of which calls `thread::serve`. There, [`thread::scope`] gives tasks to those workers. Without
//! workers, each task runs where it is joined: programs written for threads run on one.
//!
//! ```
//! use turner_host::thread;
//!
//! let sum = thread::scope(|scope| {
//!     let halves = [1..500, 500..1001].map(|half| scope.spawn(move || half.sum::<u32>()));
//!     halves.into_iter().map(|half| half.join().unwrap()).sum::<u32>()
//! });
//! assert_eq!(sum, 500_500);
//! ```

#[cfg(any(test, target_arch = "wasm32"))]
#[cfg_attr(not(target_arch = "wasm32"), allow(dead_code, unreachable_pub, reason = "only tests use it here"))]
mod pool;

/// Threads, as in [`std::thread`].
pub mod thread {
    #[cfg(target_arch = "wasm32")]
    pub use crate::pool::{Builder, JoinHandle, Scope, ScopedJoinHandle, available, scope, serve};
    #[cfg(not(target_arch = "wasm32"))]
    pub use std::thread::{Builder, JoinHandle, Scope, ScopedJoinHandle, scope};

    /// Number of threads that run at the same time, at least 1.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn available() -> usize {
        std::thread::available_parallelism().map_or(1, |n| n.get())
    }
}

/// A clock, as in [`std::time`].
pub mod time {
    #[cfg(target_arch = "wasm32")]
    pub use crate::page_clock::Instant;
    #[cfg(not(target_arch = "wasm32"))]
    pub use std::time::Instant;
}

#[cfg(target_arch = "wasm32")]
mod page_clock;
