//! What happens, as JSON lines for programs. `SCHEMA` is the documentation: `turner help json` prints it.

use std::io::Write;

use serde_json::Value;

/// The events and their keys.
pub(crate) const SCHEMA: &str = r#"With --json, turner writes one JSON object per line to standard output (to standard error when
the picture goes to standard output) and no other text. Keys may be added; none changes its meaning.
`null` stands where there is nothing to say. Usage errors found before a command runs are plain text.

{"event":"start"}      rendering begins
    scene              name of the scene as given
    output             file that will be written, "-" for standard output
    width, height      pixels of the picture that is written (the crop, if there is one)
    samples_per_pixel  samples each pixel gets
    threads            threads that render

{"event":"progress"}   at most four per second
    done               share of the work that is done, 0 to 1
    seconds            since rendering began
    seconds_left       estimate, null at first

{"event":"warning"}    something ignored or doubtful; equal ones are one event
    message            what
    count              how often
    file, line, column where the first stands, or null

{"event":"done"}       the picture is written; also after an interrupt
    output             file that was written, "-" for standard output, null if nothing was
    width, height      pixels
    complete           false if rendering was interrupted
    finished           share of the work that was done, 0 to 1
    seconds            {load, render, save}: reading and preparing; tracing rays; encoding and writing
    rays               {camera, shadow, reflected, refracted, total}
    rays_per_second    total / seconds.render
    samples            samples in the picture
    non_finite         {count, first}: samples left out; first is {x, y, sample} or null
    scene_hash         over all files of the scene and the options that change it
    version            of turner

{"event":"converted"}  `turner convert` is done
    output             the scene that was written
    files              [{file, bytes}]: all that was written, the scene last
    seconds            all of it
    version            of turner

{"event":"error"}      the command failed; exit code 1, or 2 for a bad option
    code               stable: see `turner list errors`
    message            what is wrong
    file, line, column where, or null
    help               what would be right, or null
"#;

/// Where events go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Events {
    /// Standard output.
    Stdout,
    /// Standard error.
    Stderr,
}

impl Events {
    /// Writes one line. A closed pipe is the reader's choice.
    pub fn send(self, event: Value) {
        let line = format!("{event}\n");
        let _ = match self {
            Events::Stdout => {
                let mut out = std::io::stdout().lock();
                out.write_all(line.as_bytes()).and_then(|()| out.flush())
            }
            Events::Stderr => std::io::stderr().lock().write_all(line.as_bytes()),
        };
    }
}
