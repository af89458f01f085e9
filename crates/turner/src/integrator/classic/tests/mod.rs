//! Tests of the classic integrator, from scene to pixels.

mod closed_forms;
