//! Classic recursive ray tracing from text to pixels.

mod batches;
mod closed_forms;
pub(crate) mod common;
mod documents;
mod looking;
mod oracle;
mod replay;
