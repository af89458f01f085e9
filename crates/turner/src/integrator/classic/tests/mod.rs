//! Classic recursive ray tracing from a scene to pixels.

mod closed_forms;
