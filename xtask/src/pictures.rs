//! The images of the documentation and the commands that make them. To add one, add a line.

use std::path::Path;
use std::process::Command;

use crate::layers::{self, Layer};
use crate::{root, run, sheet};

/// An image in `docs/images`.
pub(crate) struct Picture {
    /// File name.
    pub(crate) file: &'static str,
    how: How,
}

enum How {
    /// `turner` with these arguments and `-o FILE`.
    Turner(&'static str),
    /// A sheet of several images: the number of columns, common arguments, and the arguments of each image.
    Sheet(u32, &'static str, &'static [&'static str]),
    /// A sheet with each pixel enlarged to five by five.
    Enlarged(u32, &'static str, &'static [&'static str]),
    /// A sheet of layers of one EXR file: the number of columns, arguments, the size of the picture, and the layers.
    Layers(u32, &'static str, (u32, u32), &'static [Layer]),
    /// Several `turner` commands. `{tmp}` is a temporary folder and `{file}` the image.
    Steps(&'static [&'static str]),
}

use How::{Enlarged, Layers, Sheet, Steps, Turner};

const fn picture(file: &'static str, how: How) -> Picture {
    Picture { file, how }
}

/// All images.
pub(crate) const PICTURES: &[Picture] = &[
    // README
    picture("hello.jpg", Turner("scenes/hello.toml")),
    picture("still-life.jpg", Turner("scenes/still-life.toml --width 720 --height 480")),
    picture("temple.jpg", Turner("scenes/temple.toml --width 720 --height 405")),
    picture("sphereflake.jpg", Turner("scenes/sphereflake.toml --width 720 --height 480")),
    picture("doctor.png", Turner("doctor scenes/showcase/glass-still-life.toml --width 320 --height 214")),
    // Tutorial: the first scene, with more samples than in its files and a little smaller, so that the JPEGs stay small.
    picture("tutorial-first-1.jpg", Turner("scenes/tutorial/first/step-1.toml --samples 128")),
    picture(
        "tutorial-first-2.jpg",
        Turner("scenes/tutorial/first/step-2.toml --samples 128 --width 448 --height 280"),
    ),
    picture(
        "tutorial-first-3.jpg",
        Turner("scenes/tutorial/first/step-3.toml --samples 128 --width 448 --height 280"),
    ),
    picture(
        "tutorial-first-4.jpg",
        Turner("scenes/tutorial/first/step-4.toml --samples 128 --width 448 --height 280"),
    ),
    picture(
        "tutorial-first-5.jpg",
        Turner("scenes/tutorial/first/step-5.toml --samples 128 --width 448 --height 280"),
    ),
    picture(
        "tutorial-first-6.jpg",
        Turner("scenes/tutorial/first/step-6.toml --samples 128 --width 448 --height 280"),
    ),
    picture(
        "tutorial-first-7.jpg",
        Turner("scenes/tutorial/first/step-7.toml --samples 128 --width 448 --height 280"),
    ),
    picture(
        "tutorial-first-8.jpg",
        Turner("scenes/tutorial/first/step-8.toml --samples 192 --width 480 --height 300"),
    ),
    // Guide: Whitted's method in eight steps
    picture("tutorial-1.jpg", Turner("scenes/tutorial/step-1.toml")),
    picture("tutorial-2.jpg", Turner("scenes/tutorial/step-2.toml")),
    picture("tutorial-3.jpg", Turner("scenes/tutorial/step-3.toml")),
    picture("tutorial-4.jpg", Turner("scenes/tutorial/step-4.toml")),
    picture("tutorial-5.jpg", Turner("scenes/tutorial/step-5.toml")),
    picture("tutorial-6.jpg", Turner("scenes/tutorial/step-6.toml")),
    picture("tutorial-7.jpg", Turner("scenes/tutorial/step-7.toml")),
    picture(
        "tutorial-8.jpg",
        Sheet(
            4,
            "scenes/tutorial/step-8.toml --width 320 --height 240",
            &["--max-depth 1", "--max-depth 2", "--max-depth 4", "--max-depth 12"],
        ),
    ),
    // Classic scenes
    picture(
        "classic.jpg",
        Sheet(
            5,
            "--width 240 --height 240",
            &[
                "scenes/classic/000-program-sketch.toml",
                "scenes/classic/001-eight-steps.toml",
                "scenes/classic/002-13-thirty-spheres.toml",
                "scenes/classic/003-simplistic.toml",
                "scenes/classic/004-from-scratch.toml",
            ],
        ),
    ),
    picture("002-07.jpg", Turner("scenes/classic/002-07-two-shadows.toml --width 240 --height 240")),
    picture("002-09.jpg", Turner("scenes/classic/002-09-reflection-texture.toml --width 240 --height 240")),
    picture("002-11.jpg", Turner("scenes/classic/002-11-plane.toml --width 240 --height 240")),
    picture("002-12.jpg", Turner("scenes/classic/002-12-cube.toml --width 240 --height 240")),
    // Anti-aliasing: a crop, each pixel enlarged to 5 x 5
    picture(
        "antialiasing.png",
        Enlarged(
            5,
            "scenes/tutorial/step-7.toml --crop 318,106,48,44",
            &[
                "--antialias none",
                "--antialias mean",
                "--antialias grid --samples 16",
                "--antialias adaptive",
                "--antialias monte-carlo --samples 16",
            ],
        ),
    ),
    // Compare
    picture(
        "compare-reference.png",
        Turner(
            "scenes/still-life.toml --integrator path --antialias monte-carlo --samples 256 --seed 1 --width 240 --height 160",
        ),
    ),
    picture(
        "compare-noisy.png",
        Turner(
            "scenes/still-life.toml --integrator path --antialias monte-carlo --samples 4 --seed 2 --width 240 --height 160",
        ),
    ),
    picture(
        "compare-flip.png",
        Steps(&[
            "compare docs/images/compare-reference.png docs/images/compare-noisy.png --metric flip --diff {file}",
        ]),
    ),
    picture(
        "compare-ssim.png",
        Steps(&[
            "compare docs/images/compare-reference.png docs/images/compare-noisy.png --metric ssim --diff {file}",
        ]),
    ),
    // Debug views
    picture(
        "looking.jpg",
        Sheet(
            3,
            "scenes/showcase/glass-still-life.toml --antialias none --width 320 --height 213",
            &[
                "--integrator normals",
                "--integrator depth",
                "--integrator position",
                "--integrator uv",
                "--integrator albedo",
                "--integrator ids",
                "--integrator wireframe",
                "--integrator ambient-occlusion",
                "--integrator cost",
            ],
        ),
    ),
    // Shared paths, textures
    picture(
        "shared-off.png",
        Turner("scenes/peers/s1.toml --samples 4 --crop 120,120,240,240 --shared-paths off"),
    ),
    picture(
        "shared-auto.png",
        Turner("scenes/peers/s1.toml --samples 4 --crop 120,120,240,240 --shared-paths auto"),
    ),
    picture("horizon-points.png", Turner("scenes/textures/horizon.toml -D film.texture_filter=\"off\"")),
    picture("horizon-filtered.png", Turner("scenes/textures/horizon.toml")),
    picture("texture-mappings.jpg", Turner("scenes/textures/mappings.toml")),
    picture("texture-relief.jpg", Turner("scenes/textures/relief.toml --denoise")),
    // Explain
    picture("explain-classic.svg", Steps(&["explain scenes/explain.toml --pixel 451,273 -o {file}"])),
    picture(
        "explain-path.svg",
        Steps(&[
            "explain scenes/explain.toml --pixel 250,400 --integrator path --samples 16 --antialias monte-carlo --sample 1 -o {file}",
        ]),
    ),
    // Showcase
    picture(
        "show-caustics.jpg",
        Turner("scenes/showcase/caustics.toml --width 560 --height 350 --samples 64"),
    ),
    picture("show-pool.jpg", Turner("scenes/showcase/pool.toml --width 480 --height 300 --samples 32")),
    picture("smoke.jpg", Turner("scenes/showcase/smoke.toml --width 400 --height 300 --samples 64")),
    picture("fire.jpg", Turner("scenes/showcase/fire.toml --width 320 --height 400 --samples 256 --denoise")),
    picture(
        "candle.jpg",
        Turner("scenes/showcase/candle.toml --width 320 --height 256 --samples 110 --clamp-indirect 1"),
    ),
    picture(
        "foggy-beam.jpg",
        Turner(
            "scenes/showcase/foggy-beam.toml --width 400 --height 250 --samples 48 --max-depth 4 --clamp-indirect 1",
        ),
    ),
    picture(
        "show-interior.jpg",
        Turner("scenes/showcase/interior.toml --width 480 --height 300 --samples 256 --clamp-indirect 1"),
    ),
    picture(
        "show-product.jpg",
        Turner("scenes/showcase/product.toml --width 360 --height 450 --samples 400 --clamp-indirect 10"),
    ),
    picture(
        "show-glass-still-life.jpg",
        Turner(
            "scenes/showcase/glass-still-life.toml --width 560 --height 420 --samples 400 --clamp-indirect 1",
        ),
    ),
    picture(
        "show-material-balls.jpg",
        Turner(
            "scenes/showcase/material-balls.toml --width 560 --height 374 --samples 200 --clamp-indirect 10",
        ),
    ),
    picture(
        "show-cornell-box.jpg",
        Turner("scenes/showcase/cornell-box.toml --width 360 --height 360 --samples 400 --clamp-indirect 10"),
    ),
    picture(
        "show-evening.jpg",
        Turner("scenes/showcase/evening.toml --width 560 --height 315 --samples 200 --clamp-indirect 1"),
    ),
    // Guides
    picture(
        "product-shot.jpg",
        Turner("scenes/guides/product-shot.toml --width 450 --height 360 --samples 256 --clamp-indirect 10"),
    ),
    picture(
        "aovs.jpg",
        Layers(
            4,
            "scenes/guides/product-shot.toml --samples 256 --clamp-indirect 10 --aov albedo,normal,depth,crypto_object,\
             direct,indirect,light_groups,cost,error",
            (210, 168),
            &[
                Layer::Color("", 1.6),
                Layer::Color("albedo", 1.0),
                Layer::Vector("N"),
                Layer::Distance("Z"),
                Layer::Matte("CryptoObject"),
                Layer::Color("direct", 1.6),
                Layer::Color("indirect", 1.6),
                Layer::Color("light.key", 1.6),
                Layer::Color("light.fill", 1.6),
                Layer::Color("light.rim", 1.6),
                Layer::Number("cost", 20.0),
                Layer::Number("error", 0.03),
            ],
        ),
    ),
    picture(
        "turntable.jpg",
        Sheet(
            6,
            "scenes/guides/turntable.toml --width 120 --height 120 --samples 96",
            &[
                "--camera orbit:0,22,3.6",
                "--camera orbit:60,22,3.6",
                "--camera orbit:120,22,3.6",
                "--camera orbit:180,22,3.6",
                "--camera orbit:240,22,3.6",
                "--camera orbit:300,22,3.6",
            ],
        ),
    ),
    picture(
        "turn.webp",
        Turner(
            "scenes/guides/turntable.toml --turntable 12 --camera orbit:0,22,3.6 --width 120 --height 120 --samples 96 --fps 6",
        ),
    ),
    picture(
        "depth-of-field.jpg",
        Turner(
            "scenes/guides/depth-of-field.toml --width 450 --height 300 --samples 324 --clamp-indirect 0.5",
        ),
    ),
    picture(
        "lens.jpg",
        Turner("scenes/guides/lens.toml --width 450 --height 300 --samples 324 --clamp-indirect 0.5"),
    ),
    picture(
        "depth-of-field-sheet.jpg",
        Sheet(
            3,
            "scenes/guides/depth-of-field.toml --width 210 --height 140 --samples 256 --clamp-indirect 0.5",
            &[
                "-D camera.lens_radius=0.04",
                "-D camera.lens_radius=0.12",
                "-D camera.lens_radius=0.36",
                "-D camera.lens_radius=0.2 -D camera.focus_distance=3.6",
                "-D camera.lens_radius=0.2 -D camera.focus_distance=5.1",
                "-D camera.lens_radius=0.2 -D camera.focus_distance=6.8",
            ],
        ),
    ),
    picture(
        "animation.jpg",
        Sheet(
            3,
            "scenes/guides/animation.toml --width 320 --height 180 --samples 64 --denoise",
            &[
                "--frame 3",
                "--frame 12",
                "--frame 17",
                "--frame 3 --motion-blur 0.5",
                "--frame 12 --motion-blur 0.5",
                "--frame 17 --motion-blur 1",
            ],
        ),
    ),
    picture("csg.jpg", Turner("scenes/guides/csg.toml --width 640 --height 320 --samples 32 --denoise")),
    picture(
        "solids.jpg",
        Turner("scenes/guides/solids.toml --width 640 --height 360 --samples 32 --denoise"),
    ),
    picture("hair.jpg", Turner("scenes/guides/hair.toml --width 640 --height 320 --samples 48 --denoise")),
    picture(
        "surfaces.jpg",
        Turner("scenes/guides/surfaces.toml --width 640 --height 360 --samples 32 --denoise"),
    ),
    picture("displacement.jpg", Turner("scenes/guides/displacement.toml --samples 64 --denoise")),
    picture("text.jpg", Turner("scenes/guides/text.toml --width 640 --height 320 --samples 64 --denoise")),
    picture("subdivision.jpg", Turner("scenes/guides/subdivision.toml --samples 64 --denoise")),
    picture("cutout.png", Turner("scenes/guides/transparent.toml --width 240 --height 200 --samples 192")),
    picture(
        "cutout-floor.png",
        Turner("scenes/guides/transparent-floor.toml --width 240 --height 200 --samples 192"),
    ),
    picture(
        "caustics-off.jpg",
        Turner("scenes/showcase/caustics.toml --width 320 --height 200 --samples 16 --caustics off"),
    ),
    picture(
        "caustics-full.jpg",
        Turner("scenes/showcase/caustics.toml --width 320 --height 200 --samples 16 --caustics full"),
    ),
    // One term of the classic shading rule more in each.
    picture(
        "classic-switches.jpg",
        Sheet(
            3,
            "scenes/explain.toml --width 200 --height 150 --antialias adaptive",
            &[
                "-D integrator.diffuse=false -D integrator.highlights=false -D integrator.shadows=false -D integrator.reflection=false -D integrator.refraction=false",
                "-D integrator.highlights=false -D integrator.shadows=false -D integrator.reflection=false -D integrator.refraction=false",
                "-D integrator.shadows=false -D integrator.reflection=false -D integrator.refraction=false",
                "-D integrator.reflection=false -D integrator.refraction=false",
                "-D integrator.refraction=false",
                "",
            ],
        ),
    ),
];

impl Picture {
    /// The commands that make the image.
    pub(crate) fn about(&self) -> String {
        match &self.how {
            Turner(args) | Layers(_, args, ..) => format!("turner {args}"),
            Sheet(_, args, parts) | Enlarged(_, args, parts) => {
                parts.iter().map(|p| format!("turner {args} {p}")).collect::<Vec<_>>().join("; ")
            }
            Steps(commands) => commands.iter().map(|c| format!("turner {c}")).collect::<Vec<_>>().join("; "),
        }
    }

    /// Makes the image.
    pub(crate) fn make(&self, turner: &Path, to: &Path) -> Result<(), String> {
        let tmp = tempfile::tempdir().map_err(|e| format!("cannot create a temporary folder: {e}"))?;
        let call = |line: &str, output: Option<&Path>| {
            let words = line.split_whitespace().map(|word| {
                let word = word.replace("{file}", &to.display().to_string());
                word.replace("{tmp}", &tmp.path().display().to_string())
            });
            let mut command = Command::new(turner);
            command.current_dir(root()).args(words);
            if let Some(output) = output {
                command.arg("--quiet").arg("-o").arg(output);
            }
            run(&mut command)
        };
        match &self.how {
            Turner(args) => call(args, Some(to)),
            Steps(commands) => commands.iter().try_for_each(|line| call(line, None)),
            Layers(columns, args, size, layers) => {
                let exr = tmp.path().join("layers.exr");
                call(&format!("{args} --width {} --height {}", size.0, size.1), Some(&exr))?;
                let files: Vec<_> = (0..layers.len()).map(|i| tmp.path().join(format!("{i}.png"))).collect();
                for (layer, file) in layers.iter().zip(&files) {
                    layers::write(&exr, *size, *layer, file)?;
                }
                sheet::write(&files, *columns, 1, to)
            }
            Sheet(columns, args, parts) | Enlarged(columns, args, parts) => {
                let zoom = if matches!(self.how, Enlarged(..)) { 5 } else { 1 };
                let files: Vec<_> = (0..parts.len()).map(|i| tmp.path().join(format!("{i}.png"))).collect();
                for (part, file) in parts.iter().zip(&files) {
                    call(&format!("{part} {args}"), Some(file))?;
                }
                sheet::write(&files, *columns, zoom, to)
            }
        }
    }
}
