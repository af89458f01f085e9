//! Tests of the program as a user runs it.

mod bench;
mod commands;
mod common;
mod compare;
mod convert;
mod dependable;
mod docs;
mod doctor;
mod explain;
mod hostile;
mod interrupt;
mod kernels;
mod limits;
mod models;
mod names;
mod render;
mod scene_options;
mod start;
mod unsafe_code;
mod verify;
