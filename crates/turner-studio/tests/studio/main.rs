//! The window, driven through its accessibility tree: what a user or a screen reader can reach.

mod common;
mod contrast;
mod docs;
mod faults;
mod files;
mod forms;
mod insights;
mod keyboard;
mod menus;
mod panels;
mod parameters;
mod picture;
mod random;
mod widgets;
