//! Classic recursive ray tracing from text to pixels.

pub(crate) mod common;
mod documents;
mod looking;
mod oracle;
mod replay;
