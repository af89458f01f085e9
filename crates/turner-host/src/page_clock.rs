//! The clock of a web page: `performance.now()`, imported as `turner.now`.

use std::time::Duration;

#[link(wasm_import_module = "turner")]
unsafe extern "C" {
    /// Milliseconds since any fixed time, the same for all workers of the page.
    #[link_name = "now"]
    safe fn now() -> f64;
}

/// A time of the page's clock.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Instant(f64);

impl Instant {
    /// The present.
    pub fn now() -> Instant {
        Instant(now())
    }

    /// The time since then; zero if the clock was set back.
    pub fn elapsed(&self) -> Duration {
        Duration::try_from_secs_f64((now() - self.0) / 1e3).unwrap_or_default()
    }
}
