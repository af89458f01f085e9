//! Arranges the help of the commands: headings, common options, examples.
//!
//! `-h` and `--help` show the common options, `--help-all` all of them.

use clap::{Arg, ArgAction, Command};

/// Options under one heading, by the names of their fields.
struct Group {
    heading: &'static str,
    /// Shown by `--help`.
    common: &'static [&'static str],
    /// Shown by `--help-all` only.
    more: &'static [&'static str],
}

const GROUPS: &[Group] = &[
    Group {
        heading: "Output",
        common: &["output", "aov"],
        more: &["format", "bit_depth", "dither", "display_space", "exr_compression"],
    },
    Group {
        heading: "Image",
        common: &["width", "height", "exposure", "tonemap"],
        more: &["crop", "auto_exposure"],
    },
    Group {
        heading: "Sampling",
        common: &["quality", "samples", "budget", "noise", "denoise", "adaptive", "antialias"],
        more: &["denoise_aovs", "filter", "seed"],
    },
    Group {
        heading: "Integrator",
        common: &["integrator", "max_depth"],
        more: &["caustics", "clamp_indirect", "shared_paths"],
    },
    Group {
        heading: "Camera and environment",
        common: &["camera", "fov", "zoom", "background", "environment"],
        more: &["look_at", "fstop", "focus", "env_rotation", "env_strength", "ground", "no_ground"],
    },
    Group { heading: "Models", common: &[], more: &["animation", "variant", "bvh_quality"] },
    Group {
        heading: "Animation",
        common: &["turntable", "frames"],
        more: &["time", "frame", "fps", "motion_blur"],
    },
    Group { heading: "Scene", common: &["set"], more: &["define"] },
    Group {
        heading: "Files and limits",
        common: &[],
        more: &["allow_path", "allow_outside", "max_memory", "max_texture_size", "max_triangles"],
    },
    Group {
        heading: "Checkpoints",
        common: &["resume"],
        more: &["checkpoint", "checkpoint_interval", "sample_range", "part"],
    },
    Group { heading: "Performance", common: &["threads"], more: &[] },
    Group { heading: "Reporting", common: &["preview", "quiet", "json"], more: &["tev", "strict"] },
];

/// Commands whose options are arranged in groups.
const GROUPED: &[&str] = &["render", "resume", "merge", "watch", "explain", "doctor", "convert", "info"];

/// Examples at the start of a command's help.
const EXAMPLES: &[(&str, &[(&str, &str)])] = &[
    (
        "render",
        &[
            ("turner scene.toml", "writes scene.png"),
            ("turner scene.toml -o big.exr --width 1920 --samples 256", "size, quality, linear EXR"),
            ("turner scene.toml --integrator path --max-depth 8", "path tracing"),
            (
                "turner model.glb --environment sky.hdr --camera orbit:30,20",
                "a model under an environment map",
            ),
            ("turner scene.toml -D camera.fov=35 -D light.0.intensity=2", "sets any value of the scene"),
            ("turner model.glb --turntable 36 -o frame_##.png", "36 pictures, once around the model"),
        ],
    ),
    (
        "resume",
        &[
            ("turner resume .scene.png.turner-checkpoint", "continue after Ctrl-C or a crash"),
            ("turner resume part.turner-checkpoint --samples 4096", "add samples to a finished render"),
        ],
    ),
    (
        "merge",
        &[
            (
                "turner merge a.turner-checkpoint b.turner-checkpoint -o scene.png",
                "two halves of the samples",
            ),
            ("turner merge *.turner-checkpoint -o all.turner-checkpoint", "a checkpoint of all parts"),
        ],
    ),
    (
        "farm",
        &[
            (
                "turner farm split scene.toml --parts 64 --queue slurm -o job.sh",
                "an array job; `sbatch job.sh`",
            ),
            (
                "turner farm split scene.toml --parts 8 --queue parallel | sh",
                "eight parts on this machine, then the picture",
            ),
        ],
    ),
    (
        "remake",
        &[
            ("turner remake scene.png", "render it again and compare"),
            ("turner remake frame_0007.exr -o again.exr --scene moved/scene.toml", "keep the new picture"),
        ],
    ),
    (
        "new",
        &[
            ("turner new first", "writes first.toml"),
            ("turner new first --template classic", "the same for Whitted ray tracing"),
        ],
    ),
    (
        "watch",
        &[
            ("turner watch scene.toml", "renders again after each change of a file"),
            ("turner watch scene.toml --width 320 --samples 4", "small and fast while you edit"),
        ],
    ),
    (
        "studio",
        &[
            ("turner studio", "a gallery of scenes to start from"),
            ("turner studio scene.toml", "a scene, in a window"),
        ],
    ),
    (
        "serve",
        &[
            ("turner serve scene.toml --open", "a scene, in the browser of this machine"),
            ("turner serve scene.toml --share", "the same, and an address for others who look on"),
        ],
    ),
    (
        "explain",
        &[
            ("turner explain scene.toml --pixel 320,240", "the ray tree of a pixel, as text"),
            ("turner explain scene.toml --pixel 320,240 -o pixel.html", "as a page to explore"),
        ],
    ),
    (
        "doctor",
        &[
            ("turner doctor scene.toml", "why the picture is black, noisy, washed out or slow"),
            ("turner doctor scene.toml --all -o maps", "with notes and maps of cost and variance"),
        ],
    ),
    (
        "convert",
        &[
            ("turner convert scene.pbrt scene.toml", "a pbrt scene as a Turner scene"),
            ("turner convert scene.toml scene.glb", "a Turner scene as glTF"),
        ],
    ),
    (
        "compare",
        &[
            ("turner compare reference.png picture.png", "all metrics"),
            (
                "turner compare a.exr b.exr --metric rmse --tolerance 0.01",
                "exit code 1 if the error is larger",
            ),
        ],
    ),
    (
        "tonemap",
        &[
            ("turner tonemap picture.exr picture.png", "as it was rendered"),
            ("turner tonemap sky.hdr sky.jpg --exposure -2 --tonemap agx", "darker, with highlights"),
            ("turner tonemap picture.exr hdr.png --display-space rec2100-pq", "16 bits for HDR displays"),
        ],
    ),
    (
        "view",
        &[
            ("turner view picture.exr", "size, channels, values, metadata, and a preview"),
            ("turner view picture.exr --pixel 320,240", "all channels of a pixel"),
        ],
    ),
    ("info", &[("turner info scene.toml", "objects, lights, names, memory, bounds")]),
    (
        "help",
        &[
            ("turner help render", "a command"),
            ("turner help fov", "a key of the scene format, with everything that has it"),
            ("turner help sphere", "a kind, a section, a word such as \"monte-carlo\""),
            ("turner help --samples", "an option"),
            ("turner help E0102", "an error"),
        ],
    ),
];

/// The first example of a command.
pub(crate) fn example(command: &str) -> Option<&'static str> {
    let (_, examples) = EXAMPLES.iter().find(|(of, _)| *of == command)?;
    examples.first().map(|(line, _)| *line)
}

/// The id of the option that shows all options.
const ALL: &str = "help_all";

/// The command line with its help arranged.
pub(crate) fn arrange(cli: Command) -> Command {
    cli.mut_subcommands(one)
}

fn one(command: Command) -> Command {
    let name = command.get_name().to_owned();
    // The setting also applies to nested commands, which get their own option.
    let mut command = command.disable_help_flag(true).mut_subcommands(one);
    let is_grouped = GROUPED.contains(&name.as_str());
    if is_grouped {
        command = command.mut_args(grouped);
    }
    let hidden = command.get_arguments().filter(|a| a.is_hide_short_help_set() && !a.is_hide_set()).count();
    let heading = |arg: Arg| if is_grouped { arg.help_heading("Reporting") } else { arg };
    let help = Arg::new("help").short('h').long("help").action(ArgAction::HelpShort).help("Show this help");
    let all = Arg::new(ALL)
        .long("help-all")
        .action(ArgAction::HelpLong)
        .hide(hidden == 0)
        .help("Show all options, with the meaning of their values");
    command = command.arg(heading(help)).arg(heading(all));
    if let Some((_, examples)) = EXAMPLES.iter().find(|(of, _)| *of == name) {
        command = command.before_help(example_text(examples)).before_long_help(example_text(examples));
    }
    let after = command.get_after_help().map(ToString::to_string).unwrap_or_default();
    if hidden > 0 {
        let gap = if after.is_empty() { "" } else { "\n" };
        let short = format!("{after}{gap}{hidden} more options: `turner {name} --help-all`.");
        let long = if after.is_empty() { None } else { Some(after) };
        command = command.after_help(short);
        if let Some(long) = long {
            command = command.after_long_help(long);
        } else {
            command = command.after_long_help("");
        }
    }
    command
}

fn grouped(arg: Arg) -> Arg {
    let id = arg.get_id().as_str().to_owned();
    for group in GROUPS {
        if group.common.contains(&id.as_str()) {
            return arg.help_heading(group.heading);
        }
        if group.more.contains(&id.as_str()) {
            return arg.help_heading(group.heading).hide_short_help(true);
        }
    }
    arg
}

fn example_text(examples: &[(&str, &str)]) -> String {
    let width = examples.iter().map(|(line, _)| line.len()).max().unwrap_or(0);
    let mut out = String::from("Examples:");
    for (line, what) in examples {
        out += &format!("\n  {line:width$}  {what}");
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    fn render() -> Command {
        let mut cli = arrange(crate::cli::Cli::command());
        cli.build();
        cli.find_subcommand("render").unwrap().clone()
    }

    #[test]
    fn every_option_of_render_has_its_heading() {
        for arg in render().get_arguments().filter(|a| !a.is_positional() && !a.is_hide_set()) {
            assert!(arg.get_help_heading().is_some(), "{}", arg.get_id());
        }
        let heading = |id: &str| {
            let command = render();
            let arg = command.get_arguments().find(|a| a.get_id() == id).unwrap();
            arg.get_help_heading().unwrap().to_owned()
        };
        for (id, expected) in [
            ("output", "Output"),
            ("width", "Image"),
            ("samples", "Sampling"),
            ("threads", "Performance"),
            ("json", "Reporting"),
            ("variant", "Models"),
            ("max_memory", "Files and limits"),
        ] {
            assert_eq!(heading(id), expected, "{id}");
        }
    }

    #[test]
    fn every_name_in_the_groups_is_an_option() {
        let command = render();
        for id in GROUPS.iter().flat_map(|g| g.common.iter().chain(g.more)) {
            assert!(command.get_arguments().any(|a| a.get_id() == id), "{id}");
        }
    }

    #[test]
    fn short_help_has_examples_first_and_common_options_only() {
        let short = render().render_help().to_string();
        assert!(short.starts_with("Examples:"), "{short}");
        assert_eq!(short.lines().skip(1).take_while(|l| l.starts_with("  turner ")).count(), 6);
        assert!(!short.contains("--max-triangles") && short.contains("--help-all`"), "{short}");
        let long = render().render_long_help().to_string();
        assert!(long.contains("--max-triangles") && !long.contains("more options"), "{long}");
    }
}
