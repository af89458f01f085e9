//! Tests of the program as a user runs it.

mod commands;
mod common;
mod compare;
mod convert;
mod dependable;
mod docs;
mod doctor;
mod errors;
mod explain;
mod folder;
mod hostile;
mod instruction_sets;
mod interrupt;
mod limits;
mod models;
mod names;
mod render;
mod scene_options;
mod sh_blocks;
mod start;
mod tutorial;
mod unsafe_code;
mod verify;
mod words;
