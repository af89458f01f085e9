//! Other renderers: installed in a Python environment, and run in processes of their own.

pub(crate) mod install;
mod process;

pub(crate) use process::{Peer, PeerKind};
