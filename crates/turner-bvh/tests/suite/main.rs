//! The crate from outside: one program, so that it links once.

mod build;
mod common;
mod exact;
mod lanes;
mod search;
