//! `turner farm split`: the job of a picture for a queue that exists.
//!
//! Every queue runs the same two commands: `turner render --part I/N` for each part, `turner merge` after all of them. A
//! template says how the queue counts parts, repeats those that fail, and waits for all. Parts may be rendered twice, in any
//! order, and on any machine: each is written whole under its own name, and equal samples have equal bytes.

mod queue;

use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};
use turner::schema::{ErrorCode, SceneError};
use turner_io::image::OutputFile;

use crate::failure::{Failure, two_lines};
use crate::text::{print, shell_word};
use crate::{checkpoint, report};
use queue::Queue;

/// Make the job of a picture for a render farm, a cluster or another queue
#[derive(Debug, Args)]
pub(crate) struct FarmArgs {
    #[command(subcommand)]
    command: FarmCommand,
}

#[derive(Debug, Subcommand)]
enum FarmCommand {
    Split(SplitArgs),
}

/// Write a job that renders a picture in parts and merges them
///
/// The parts are ranges of the samples, so that they take equally long, and one that is lost is rendered again alone. Scene
/// and job must lie in a folder that all machines see. Options after `--` are those of `turner render`.
#[derive(Debug, Args)]
pub(crate) struct SplitArgs {
    /// Scene or model file
    scene: PathBuf,
    /// The number of parts: at most the samples per pixel
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    parts: u32,
    /// The queue that the job is for
    #[arg(long, value_name = "NAME", default_value = "shell")]
    queue: Queue,
    /// The picture [default: SCENE.png]
    #[arg(long, value_name = "FILE")]
    picture: Option<PathBuf>,
    /// Threads of each part
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1024))]
    threads: u32,
    /// Container image with `turner` in it, for kubernetes
    #[arg(long, value_name = "IMAGE", default_value = "turner:latest")]
    image: String,
    /// Output file; `-` is standard output
    #[arg(short, long, value_name = "FILE", default_value = "-")]
    output: PathBuf,
    /// Options of `turner render`, the same for all parts
    #[arg(last = true, value_name = "OPTION")]
    options: Vec<String>,
}

/// Runs the command.
pub(crate) fn run(args: &FarmArgs) -> u8 {
    let FarmCommand::Split(split) = &args.command;
    match written(split) {
        Ok(()) => 0,
        Err(failure) => {
            report::print_error(&failure);
            failure.exit
        }
    }
}

fn written(args: &SplitArgs) -> Result<(), Failure> {
    let job = job(args)?;
    if args.output == Path::new("-") {
        print(&job);
        return Ok(());
    }
    let failed =
        |e: turner_io::image::OutputError| Failure::new(two_lines(ErrorCode::Output, &e.to_string()));
    OutputFile::create(&args.output).and_then(|file| file.commit(job.as_bytes())).map_err(failed)?;
    let path = args.output.display();
    print(&format!("{path} written\n\n  {}\n", args.queue.command(&shell_word(&path.to_string()))));
    Ok(())
}

/// The text of the job.
fn job(args: &SplitArgs) -> Result<String, Failure> {
    let usage =
        |message: String, help: &str| Failure::usage(SceneError::new(ErrorCode::Usage, message).help(help));
    let (Some(scene), Some(_)) = (args.scene.to_str().filter(|scene| *scene != "-"), args.scene.file_stem())
    else {
        return Err(usage(
            "the scene of a job must be a file whose name is UTF-8".to_owned(),
            "write it to a file",
        ));
    };
    if !args.scene.is_file() {
        return Err(usage(
            format!("{}: no such file", args.scene.display()),
            "name the scene as this machine sees it",
        ));
    }
    // Options that would make parts of parts, or name other files.
    let refused = [
        "--part",
        "--sample-range",
        "--checkpoint",
        "--output",
        "-o",
        "--crop",
        "--resume",
        "--budget",
        "--noise",
        "--frames",
        "--turntable",
    ];
    let name = |option: &str| option.split('=').next().unwrap_or_default().to_owned();
    if let Some(bad) = args.options.iter().map(|o| name(o)).find(|o| refused.contains(&o.as_str())) {
        return Err(usage(
            format!("{bad} cannot be an option of all parts"),
            "leave it out: parts differ in their samples alone",
        ));
    }
    let texts = args.options.iter().map(String::as_str).chain([scene, args.image.as_str()]);
    if texts
        .chain(args.picture.as_ref().and_then(|p| p.to_str()))
        .any(|text| text.chars().any(char::is_control))
    {
        return Err(usage(
            "a name or an option contains a control character".to_owned(),
            "choose another name",
        ));
    }
    let stem = args.scene.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let picture = match &args.picture {
        Some(path) => path
            .to_str()
            .map(str::to_owned)
            .ok_or_else(|| usage("the picture's name must be UTF-8".to_owned(), "choose another name"))?,
        None => format!("{stem}.png"),
    };
    if checkpoint::has_extension(Path::new(&picture)) {
        return Err(usage("the picture of a job must be a picture".to_owned(), "name a .png or .exr file"));
    }
    let folder = format!("{stem}-parts");
    let options: String = args.options.iter().map(|option| format!(" {}", shell_word(option))).collect();
    let name: String =
        stem.chars().map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '-' }).collect();
    let name = format!("turner-{}", name.trim_matches('-').chars().take(40).collect::<String>());
    let values = [
        ("@SCENE@", shell_word(scene)),
        ("@PICTURE@", shell_word(&picture)),
        ("@FOLDER@", shell_word(&folder)),
        ("@OPTIONS@", options),
        ("@PARTS@", args.parts.to_string()),
        ("@LAST@", (args.parts - 1).to_string()),
        ("@THREADS@", args.threads.to_string()),
        ("@NAME@", name.trim_matches('-').to_owned()),
        ("@IMAGE@", args.image.clone()),
        ("@VERSION@", env!("CARGO_PKG_VERSION").to_owned()),
    ];
    let template = args.queue.template();
    Ok(filled(template, &values))
}

/// The template with its places filled, once: a value that looks like a place stays as it is.
fn filled(template: &str, values: &[(&str, String)]) -> String {
    let mut out = String::new();
    let mut rest = template;
    while let Some(at) = rest.find('@') {
        out += &rest[..at];
        rest = &rest[at..];
        match values.iter().find(|(place, _)| rest.starts_with(place)) {
            Some((place, value)) => {
                out += value;
                rest = &rest[place.len()..];
            }
            None => {
                out.push('@');
                rest = &rest[1..];
            }
        }
    }
    out + rest
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::ValueEnum;

    fn args(queue: Queue, options: &[&str]) -> SplitArgs {
        SplitArgs {
            scene: Path::new(env!("CARGO_MANIFEST_DIR")).join("templates/classic.toml"),
            parts: 8,
            queue,
            picture: None,
            threads: 2,
            image: "turner:latest".to_owned(),
            output: "-".into(),
            options: options.iter().map(|o| (*o).to_owned()).collect(),
        }
    }

    #[test]
    fn jobs_of_all_queues_render_all_parts_and_merge_them() {
        for queue in Queue::value_variants() {
            let text = job(&args(*queue, &["-D", "film.samples=64 "])).unwrap();
            assert!(!text.contains('@') || text.contains("[@]"), "{queue:?}: {text}");
            assert!(text.contains("turner render") && text.contains("turner merge"), "{queue:?}");
            assert!(text.contains("/8") && text.contains("'film.samples=64 '"), "{queue:?}: {text}");
        }
    }

    #[test]
    fn options_that_parts_cannot_share_are_refused() {
        for bad in [&["--crop", "0,0,4,4"][..], &["--part=1/2"], &["-o", "a.png"], &["a\nb"]] {
            assert!(job(&args(Queue::Shell, bad)).is_err(), "{bad:?}");
        }
        let missing = SplitArgs { scene: "no.toml".into(), ..args(Queue::Shell, &[]) };
        assert!(job(&missing).is_err());
    }

    #[test]
    fn values_are_not_filled_again() {
        assert_eq!(filled("a @X@ @Y@ @", &[("@X@", "@Y@".into()), ("@Y@", "2".into())]), "a @Y@ 2 @");
    }
}
