//! Path tracing from text to pixels: closed forms first, then one estimator against another.

mod bad_input;
mod lamp_files;
mod volumes;
