//! Input of the path tracer from text and files, and what is rejected.

mod bad_input;
mod ies_files;
mod volumes;
