//! Tests of the public interface, in one program so that it links once.

mod build;
mod bytes;
mod common;
mod custom;
mod exact;
mod lanes;
mod search;
