//! Tests of the program as a user runs it.

mod bench;
mod commands;
mod common;
mod compare;
mod convert;
mod docs;
mod doctor;
mod explain;
mod interrupt;
mod kernels;
mod models;
mod names;
mod render;
mod scene_options;
mod start;
mod verify;
