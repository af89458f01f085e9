//! Options of all commands that render.

use clap::Args;

use crate::events::Events;
use crate::report::Reporter;

/// How a command runs and reports.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct RunArgs {
    /// Number of threads [default: all cores]; the picture does not depend on it
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    pub(crate) threads: usize,
    /// Print errors only
    #[arg(long)]
    pub(crate) quiet: bool,
    /// Print events as JSON lines: `turner help json`
    #[arg(long)]
    pub(crate) json: bool,
}

impl RunArgs {
    /// Reports to people, or with `--json` to programs on `stream`.
    pub(crate) fn reporter(&self, stream: Events) -> Reporter {
        Reporter { quiet: self.quiet, events: self.json.then_some(stream) }
    }
}
