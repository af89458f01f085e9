//! Classic recursive ray tracing from text to pixels.
#![allow(
    clippy::disallowed_methods,
    reason = "expected values are independent of the renderer's own functions"
)]

mod batches;
mod closed_forms;
mod common;
mod documents;
mod looking;
mod oracle;
mod replay;
