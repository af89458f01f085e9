#![forbid(unsafe_code)]
//! File formats.
