//! The server as browsers see it: over HTTP and WebSockets, without a browser.

mod common;
mod guarded;
mod shown;
mod speed;
