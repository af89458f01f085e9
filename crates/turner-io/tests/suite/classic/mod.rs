//! Classic recursive ray tracing, from scene text to pixels.

pub(crate) mod common;
mod documents;
mod oracle;
mod replay;
