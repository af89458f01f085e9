//! What text and files bring to path tracing, and what is refused of them.

mod bad_input;
mod lamp_files;
mod volumes;
