//! Classic recursive ray tracing from text to pixels.

mod batches;
pub(crate) mod common;
mod documents;
mod looking;
mod oracle;
mod replay;
