//! The engine as its callers see it: whatever is ordered in between, it settles on the bytes of the offline render.

mod common;
mod errors;
mod mix;
mod paused;
mod settles;
mod stops;
