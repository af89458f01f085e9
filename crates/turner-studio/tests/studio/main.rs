//! The window, driven through its accessibility tree: what a user or a screen reader can reach.

mod common;
mod contrast;
mod docs;
mod files;
mod insights;
mod keyboard;
mod menus;
mod parameters;
mod random;
mod widgets;
