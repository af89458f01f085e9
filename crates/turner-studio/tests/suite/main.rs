//! Tests of the program and of its window without a display.

mod command_line;
mod jobs;
mod render_panel;
