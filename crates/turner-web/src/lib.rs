//! Turner for pages: a [`Session`] of calls and events.
//!
//! ```text
//!  page (JavaScript) ── call("orbit", {…}) ──► Session ──► turner_live: document, engine, camera, pick
//!        ▲                                        │
//!        └──── events: frame, status, document ◄──┘ step()
//! ```
//!
//! Calls and events are JSON; pictures and files are bytes. In a browser the session runs as WebAssembly in a worker
//! (the exports below `abi`); behind `turner serve` it runs in a thread of the program. Both have the same calls, so the
//! page is the same. `crates/turner-web/page` has the page, docs/reference/page.md the list of calls.

#[cfg(target_arch = "wasm32")]
mod abi;
pub mod base64;
mod explain_page;
mod layers;
#[cfg(not(target_arch = "wasm32"))]
mod page;
mod picture;
mod session;

pub use explain_page::{ExplainPage, explain_page};
#[cfg(not(target_arch = "wasm32"))]
pub use page::PAGE;
pub use picture::{PictureJob, PictureRequest, picture};
pub use session::{CALLS, Call, CallError, Event, Files, Place, READS, REPLACES, Reply, Session};
pub use turner_io::scene::LoadError;
