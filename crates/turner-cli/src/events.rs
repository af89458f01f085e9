//! Events as JSON lines, for programs. `turner help json` documents them.

use std::io::Write;

use serde_json::Value;

/// The events and their keys.
pub(crate) const SCHEMA: &str = r#"With --json, `render`, `resume`, `merge`, `remake`, `watch` and `convert` write one JSON object per line to standard output
(to standard error when the picture goes to standard output) and no other text. Later versions may add keys; the
meaning of a key does not change. `null` means unknown or none. Usage errors (exit code 2) found before a command
runs are plain text. `explain`, `doctor`, `info`, `compare`, `view` and `list` write one JSON value, `verify` and `bench`
one object per line: see docs/reference.

{"event":"start"}      rendering begins
    scene              name of the scene as given
    output             file that will be written, "-" for standard output
    width, height      pixels of the output picture (of the crop, if there is one)
    samples_per_pixel  samples per pixel, null if --budget or --noise limits them instead
    threads            number of threads

{"event":"progress"}   at most four per second
    done               fraction of the work that is done, 0 to 1
    seconds            since rendering began
    seconds_left       estimate, null at first
    samples_per_pixel  so far
    noise              so far, as in "done"; null if unknown

{"event":"import"}     a model file was read
    file, format       name and format of the file
    counts             {nodes, meshes, triangles, …}: number of each

{"event":"warning"}    a warning or note; equal ones are one event
    kind               "ignored": no effect on the picture; an error with --strict
                       "approximated": shown, but not exactly
                       "doubtful": probably a mistake
                       "note": a choice that the file does not make
    message            text
    count              number of occurrences
    file, line, column location of the first, or null

{"event":"done"}       the picture is written; also sent after an interrupt
    output             output file, "-" for standard output, null if nothing was written
    aov_output         EXR file beside it with the AOVs, null if there is none
    width, height      pixels
    camera             intrinsic matrix, pose, lens: docs/reference/header.md
    checkpoint         checkpoint file that was written, or null: `turner resume FILE` continues it
    complete           false if rendering was interrupted
    finished           fraction of the work that is done, 0 to 1
    seconds            {load, render, save}: loading and preparation; rendering; encoding and writing
    rays               {camera, shadow, reflected, refracted, light, total}
    rays_per_second    total / seconds.render
    samples            total number of samples
    ended_by           "budget" or "noise" if one of these ended the render, or null
    denoised           whether the denoiser changed the picture
    error_after_denoising  the relative error of luminance that about 95 % of the pixels do not
                       exceed after denoising, estimated; null without
    noise              {value, interval, halving}: the relative accuracy that 95 % of the pixels have or exceed (half
                       the width of their 95 % confidence intervals), the interval of this estimate, and the
                       {samples_per_pixel, seconds} that halve it; null if it cannot be estimated
    non_finite         {count, first}: omitted NaN or infinite samples; first is {x, y, sample} or null
    scene_hash         hash of all files of the scene and of the options that change it
    version            version of Turner

{"event":"skipped"}    with --resume: the picture is complete
    output             its file

{"event":"animation"}  the frames of a sequence became one file
    output             animation or video
    frames             number of frames
    frames_per_second  as asked for

{"event":"merged"}     `turner merge` is done
    output             picture or checkpoint
    width, height      pixels
    files              number of parts
    samples_per_pixel  samples per pixel of the complete picture
    finished           fraction of them that the parts hold, 0 to 1

{"event":"remade"}     `turner remake` compared the pictures
    picture            the file as given
    output             file of the new picture, null if it was temporary
    same_bytes         whether the files are equal
    same_pixels        whether all channels of all pixels are equal
    different_pixels   number of pixels that differ, null if size or channels do
    different_metadata names of metadata that differ, if the pixels are equal

{"event":"converted"}  `turner convert` is done
    output             output scene
    files              [{file, bytes}]: all output files, the scene last
    seconds            total time
    version            version of Turner

{"event":"error"}      the command failed, exit code 1, or 2 for a bad option; one event per error
    code               stable code: `turner list errors`
    message            what is wrong
    file, line, column location, or null
    help               the remedy, or null
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
    /// Writes one line. A closed pipe is ignored.
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
