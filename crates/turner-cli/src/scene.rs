//! From the arguments to a prepared scene: overrides, loading, preparation.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::builder::{PossibleValue, PossibleValuesParser};
use clap::{Args, ValueEnum};
use turner::color::Tonemap;
use turner::description::SceneDesc;
use turner::film::{Antialias, Denoise, FilmDesc};
use turner::filter::FilterKind;
use turner::integrator::{Caustics, IntegratorDesc, Prepared, SharedPathsMode};
use turner::lint::lint;
use turner::schema::{EntryDoc, ErrorCode, Limits, PrepareOptions, Quality, SceneError};
use turner_io::assets::FolderAssets;
use turner_io::image::KeptPictures;
use turner_io::load_with;
use turner_io::scene::{
    LoadError, LoadOptions, Loaded, MAX_TEXT, ModelOverrides, Override, Sources, hash_with, load_text,
    open_to,
};

use crate::control::Control;
use crate::failure::{Failure, Labels};
use crate::flags;
use crate::instructions::instruction_set;
use crate::limits::LimitArgs;
use crate::reference::{first_sentence, paragraph};
use crate::studio::StudioArgs;

/// The scene, and the options that change it.
#[derive(Debug, Args)]
pub(crate) struct SceneArgs {
    /// Scene or model file; `-` reads a scene from standard input
    pub(crate) scene: PathBuf,
    /// Set any value of the scene, e.g. -D object.0.radius=2 (repeatable)
    #[arg(short = 'D', long = "set", value_name = "KEY.PATH=VALUE", value_parser = parse_override)]
    pub(crate) set: Vec<Override>,
    /// Set a $name of a Mitsuba scene, e.g. --define spp=256 (repeatable); for .xml also -D spp=256
    #[arg(long, value_name = "NAME=VALUE", value_parser = parse_define)]
    define: Vec<(String, String)>,
    #[command(flatten)]
    pub(crate) studio: StudioArgs,
    #[command(flatten)]
    pub(crate) limits: LimitArgs,
    /// Build quality of the mesh BVHs: affects build time and speed, never the picture
    #[arg(long, value_name = "QUALITY", default_value = "balanced")]
    bvh_quality: BvhQuality,
}

/// Build quality of the BVHs of meshes.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum BvhQuality {
    /// Fastest build, slower rays
    Fast,
    /// Good for most scenes
    Balanced,
    /// Several times the build time, faster rays
    High,
}

/// Options for keys of `[film]` and `[integrator]`.
#[derive(Debug, Default, Args)]
pub(crate) struct FilmArgs {
    /// Width in pixels; without --height the aspect ratio is kept
    #[arg(long, value_name = "PIXELS")]
    width: Option<u32>,
    /// Height in pixels; without --width the aspect ratio is kept
    #[arg(long, value_name = "PIXELS")]
    height: Option<u32>,
    /// Render only a part: first column, first row, columns, rows
    #[arg(long, value_name = "X,Y,W,H", value_parser = parse_crop)]
    crop: Option<String>,
    /// Further channels from the same samples, e.g. albedo,normal,depth: `turner list aovs`
    #[arg(long, value_name = "NAME,…", value_parser = parse_aovs)]
    aov: Option<String>,
    /// Exposure in stops: 1 doubles the brightness, -1 halves it
    #[arg(long, value_name = "STOPS", allow_negative_numbers = true)]
    exposure: Option<f64>,
    /// Choose the exposure from the picture; --exposure is added to it
    #[arg(long)]
    auto_exposure: bool,
    /// Tone mapping for display formats; EXR and HDR files keep scene values
    #[arg(long, value_name = "NAME", value_parser = words(Tonemap::DOCS))]
    tonemap: Option<String>,
    /// Samples, depth and denoiser together; options of their own, such as --samples, refine it
    #[arg(long, value_name = "QUALITY")]
    quality: Option<PictureQuality>,
    /// Samples per pixel
    #[arg(long, value_name = "N")]
    samples: Option<u32>,
    /// Give noisy parts of the picture more samples than others; --samples is then their mean
    #[arg(long)]
    adaptive: bool,
    /// Remove the noise of the finished picture; EXR files keep the raw one as the layer "raw" [default: on for models]
    #[arg(long, value_name = "DENOISER", num_args = 0..=1, default_missing_value = "on", value_parser = words(Denoise::DOCS))]
    denoise: Option<String>,
    /// Remove the noise of the AOVs of light, too: emission, direct, indirect, light_groups
    #[arg(long)]
    denoise_aovs: bool,
    /// Anti-aliasing: where the samples of a pixel lie and how they are averaged
    #[arg(long, value_name = "MODE", value_parser = words(Antialias::DOCS))]
    antialias: Option<String>,
    /// Pixel filter of monte-carlo anti-aliasing
    #[arg(long, value_name = "NAME", value_parser = words(FilterKind::DOCS))]
    filter: Option<String>,
    /// Seed of the random numbers
    #[arg(long, value_name = "N")]
    seed: Option<u32>,
    /// Light transport algorithm, or a debug view; keys of `[integrator]` that it does not have are dropped
    #[arg(long, value_name = "NAME", value_parser = integrators())]
    integrator: Option<String>,
    /// Longest path, in bounces
    #[arg(long, value_name = "N")]
    max_depth: Option<u32>,
    /// Caustics of mirrors and glass, for "path"
    #[arg(long, value_name = "MODE", value_parser = words(Caustics::DOCS))]
    caustics: Option<String>,
    /// Limit on the radiance of an indirect path, for "path": removes fireflies and some energy
    #[arg(long, value_name = "RADIANCE")]
    clamp_indirect: Option<f64>,
    /// Shared paths among neighbouring pixels, for "path": less noise of indirect light
    #[arg(long, alias = "reuse", value_name = "MODE", value_parser = words(SharedPathsMode::DOCS))]
    shared_paths: Option<String>,
}

/// The words of a choice, with their meanings for `--help-all`.
pub(crate) fn words(docs: &[(&'static str, &'static str)]) -> PossibleValuesParser {
    PossibleValuesParser::new(docs.iter().map(|(word, meaning)| PossibleValue::new(*word).help(*meaning)))
}

fn integrators() -> PossibleValuesParser {
    let value = |e: &&'static EntryDoc| PossibleValue::new(e.name).help(first_sentence(&paragraph(e.doc)));
    PossibleValuesParser::new(IntegratorDesc::DOC.entries.iter().map(value))
}

fn parse_override(text: &str) -> Result<Override, String> {
    Override::parse(text).map_err(|e| match e.help {
        Some(help) => format!("{}; {help}", e.message),
        None => e.message,
    })
}

fn parse_define(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, value)) if !name.is_empty() => {
            Ok((name.trim_start_matches('$').to_owned(), value.to_owned()))
        }
        _ => Err("expected NAME=VALUE; write `--define spp=256`".to_owned()),
    }
}

/// Four integers, kept as text: the film checks whether they fit the picture.
fn parse_crop(text: &str) -> Result<String, String> {
    let numbers: Result<Vec<u32>, _> = text.split(',').map(|n| n.trim().parse::<u32>()).collect();
    match numbers {
        Ok(n) if n.len() == 4 => Ok(text.to_owned()),
        _ => Err("expected four integers X,Y,W,H; write `--crop 0,0,320,240`".to_owned()),
    }
}

/// Names separated by commas. The film checks whether there are such AOVs.
fn parse_aovs(text: &str) -> Result<String, String> {
    let is_word = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '.' | ':' | ' ');
    let is_name = |name: &str| !name.trim().is_empty() && name.chars().all(is_word);
    match text.split(',').all(is_name) {
        true => Ok(text.to_owned()),
        false => Err("expected names separated by commas; write `--aov albedo,normal`".to_owned()),
    }
}

/// Samples, depth and denoiser together.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum PictureQuality {
    /// 4 samples per pixel, 4 bounces, denoised
    Draft,
    /// 8 samples per pixel, denoised
    Good,
    /// 256 samples per pixel, denoised
    Final,
}

impl PictureQuality {
    /// Keys of the scene and their values.
    fn settings(self) -> &'static [(&'static str, &'static str)] {
        match self {
            PictureQuality::Draft => {
                &[("film.samples", "4"), ("integrator.max_depth", "4"), ("film.denoise", "\"on\"")]
            }
            PictureQuality::Good => &[("film.samples", "8"), ("film.denoise", "\"on\"")],
            PictureQuality::Final => &[("film.samples", "256"), ("film.denoise", "\"on\"")],
        }
    }
}

impl FilmArgs {
    /// The overrides, each with the option as given.
    fn overrides(&self) -> Vec<(Override, String)> {
        let mut out = Vec::new();
        let mut set = |path: &str, value: Option<String>, shown: Option<&str>| {
            if let Some(value) = value {
                let option = flags::option(path).unwrap_or_default();
                let label = format!("{option} {}", shown.unwrap_or(&value)).trim_end().to_owned();
                out.push((Override { path: path.to_owned(), value }, label));
            }
        };
        let number = |n: Option<u32>| n.map(|n| n.to_string());
        let quoted = |s: &Option<String>| s.as_ref().map(|s| format!("\"{s}\""));
        let own = |path: &str| match path {
            "film.samples" => self.samples.is_some(),
            "film.denoise" => self.denoise.is_some(),
            _ => self.max_depth.is_some(),
        };
        for (path, value) in self.quality.iter().flat_map(|quality| quality.settings()) {
            if !own(path) {
                set(path, Some((*value).to_owned()), None);
            }
        }
        set("integrator.max_depth", number(self.max_depth), None);
        let clamp = self.clamp_indirect.map(|most| format!("{most:?}").to_lowercase());
        set("integrator.clamp_indirect", clamp, None);
        set("integrator.caustics", quoted(&self.caustics), self.caustics.as_deref());
        set(flags::SHARED_PATHS, quoted(&self.shared_paths), self.shared_paths.as_deref());
        if self.side().is_none() {
            set("film.width", number(self.width), None);
            set("film.height", number(self.height), None);
        }
        set("film.crop", self.crop.as_ref().map(|c| format!("[{c}]")), self.crop.as_deref());
        let aovs = self.aov.as_ref().map(|names| {
            let names: Vec<String> = names.split(',').map(|name| format!("\"{}\"", name.trim())).collect();
            format!("[{}]", names.join(", "))
        });
        set("film.aovs", aovs, self.aov.as_deref());
        set("film.samples", number(self.samples), None);
        set("film.adaptive_sampling", self.adaptive.then(|| "true".to_owned()), Some(""));
        set("film.denoise", quoted(&self.denoise), self.denoise.as_deref());
        set("film.denoise_aovs", self.denoise_aovs.then(|| "true".to_owned()), Some(""));
        set("film.antialias", quoted(&self.antialias), self.antialias.as_deref());
        set("film.filter", quoted(&self.filter), self.filter.as_deref());
        set("film.seed", number(self.seed), None);
        set("film.tonemap", quoted(&self.tonemap), self.tonemap.as_deref());
        let exposure = self.exposure.map(|stops| format!("{stops:?}").to_lowercase());
        set("film.exposure", exposure, None);
        let auto_exposure = self.auto_exposure.then(|| "true".to_owned());
        set("film.auto_exposure", auto_exposure, Some(""));
        out
    }

    /// The side that was given alone, and whether it is the width. A side of 0 is left to the film, which refuses it.
    fn side(&self) -> Option<(u32, bool)> {
        match (self.width, self.height) {
            (Some(side @ 1..), None) => Some((side, true)),
            (None, Some(side @ 1..)) => Some((side, false)),
            _ => None,
        }
    }

    /// Scales the film to the given width or height and keeps the aspect ratio. A crop of the scene scales with it.
    fn fit(&self, film: &mut FilmDesc, hash: &mut Hashes) {
        let Some((side, is_width)) = self.side() else { return };
        let (old, across) = if is_width { (film.width, film.height) } else { (film.height, film.width) };
        let by = f64::from(side) / f64::from(old.max(1));
        let scaled = |v: u32| (f64::from(v) * by).round().clamp(1.0, f64::from(u32::MAX)) as u32;
        let across = scaled(across);
        [film.width, film.height] = if is_width { [side, across] } else { [across, side] };
        if self.crop.is_none()
            && let Some([x, y, w, h]) = &mut film.crop
        {
            let part = |start: &mut u32, size: &mut u32, all: u32| {
                let end = scaled(start.saturating_add(*size)).min(all);
                *start = if *start == 0 { 0 } else { scaled(*start).min(all - 1) };
                *size = end.saturating_sub(*start).max(1);
            };
            part(x, w, film.width);
            part(y, h, film.height);
        }
        hash.add(format!("{} {}", film.width, film.height).as_bytes());
    }

    /// Replaces `--samples`.
    pub(crate) fn set_samples(&mut self, samples: u32) {
        self.samples = Some(samples);
    }

    /// Whether `--samples` was given.
    pub(crate) fn has_samples(&self) -> bool {
        self.samples.is_some()
    }
}

/// Hashes of what determines a picture.
#[derive(Clone, Debug)]
pub(crate) struct Hashes {
    /// Of everything.
    pub(crate) whole: String,
    /// Without `--samples` and `--crop`: equal for all parts of a picture.
    pub(crate) shared: String,
}

impl Hashes {
    /// Extends both.
    pub(crate) fn add(&mut self, bytes: &[u8]) {
        self.whole = hash_with(&self.whole, bytes);
        self.shared = hash_with(&self.shared, bytes);
    }

    /// At a time of the animation, seconds.
    pub(crate) fn at_time(mut self, time: Option<f64>) -> Hashes {
        if let Some(time) = time {
            self.add(format!("time {time:?}").as_bytes());
        }
        self
    }
}

/// A prepared scene, with sources and labels for messages.
pub(crate) struct Ready {
    /// The description.
    pub(crate) desc: SceneDesc,
    /// The scene prepared for rendering.
    pub(crate) prepared: Prepared,
    /// The texts.
    pub(crate) sources: Sources,
    /// Names of options.
    pub(crate) labels: Labels,
    /// Hashes of everything that determines the picture.
    pub(crate) hash: Hashes,
    /// The same without the time of the animation.
    pub(crate) timeless: Hashes,
    /// Seconds to load and prepare.
    pub(crate) seconds: f64,
}

/// A scene description, with sources and labels for messages.
pub(crate) struct Described {
    /// The description.
    pub(crate) desc: SceneDesc,
    /// The texts.
    pub(crate) sources: Sources,
    /// Names of options.
    pub(crate) labels: Labels,
    /// Hashes of everything that determines the picture.
    pub(crate) hash: Hashes,
    /// The same without the time of the animation.
    pub(crate) timeless: Hashes,
}

impl Described {
    /// Prepares the scene with the default options, to learn what the studio adds.
    pub(crate) fn prepare(&self, limits: &Limits) -> Result<Prepared, Failure> {
        let options = PrepareOptions { limits: limits.clone(), ..PrepareOptions::default() };
        let prepared = self.desc.prepare_unchosen(self.desc.integrator.integrator(), &options);
        prepared.map_err(|e| Failure::in_scene(e, &self.sources, &self.labels))
    }
}

impl SceneArgs {
    /// Loads and prepares the scene.
    pub(crate) fn ready(
        &self,
        film: &FilmArgs,
        models: ModelOverrides,
        threads: usize,
        control: &Control,
    ) -> Result<Ready, Failure> {
        let start = Instant::now();
        let limits = self.watched_limits(control);
        let Described { desc, sources, labels, hash, timeless } =
            self.described(film, models, threads, None, &limits)?;
        let quality = match self.bvh_quality {
            BvhQuality::Fast => Quality::Fast,
            BvhQuality::Balanced => Quality::Balanced,
            BvhQuality::High => Quality::High,
        };
        let options = PrepareOptions { threads, quality, limits, instruction_set: instruction_set() };
        let mut prepared = desc
            .prepare_unchosen(desc.integrator.integrator(), &options)
            .map_err(|e| Failure::in_scene(e, &sources, &labels))?;
        let more = lint(&desc, &prepared);
        prepared.warnings.extend(more);
        let seconds = start.elapsed().as_secs_f64();
        Ok(Ready { desc, prepared, sources, labels, hash, timeless, seconds })
    }

    /// The limits of the scene. The main thread watches the memory from here on.
    pub(crate) fn watched_limits(&self, control: &Control) -> Limits {
        let limits = self.limits.limits();
        control.watch_memory(&limits.memory);
        limits
    }

    /// Loads the scene and applies the options. `kept_pictures` keeps the bytes of image files, for `turner convert`.
    pub(crate) fn described(
        &self,
        film: &FilmArgs,
        models: ModelOverrides,
        threads: usize,
        kept_pictures: Option<KeptPictures>,
        limits: &Limits,
    ) -> Result<Described, Failure> {
        let input = Input::new(&self.scene)?;
        let mut film_overrides = film.overrides();
        film_overrides.extend(self.studio.overrides());
        let mut labels: Labels =
            film_overrides.iter().map(|(o, label)| (format!("-D {}", o.text()), label.clone())).collect();
        if let Some(name) = &film.integrator {
            labels
                .insert(format!("-D {}", Override::integrator(name).text()), format!("--integrator {name}"));
        }
        let mut overrides: Vec<Override> = film_overrides.into_iter().map(|(o, _)| o).collect();
        // As in Mitsuba's own program, `-D name=value` defines a parameter: every key of a scene has a dot in its path.
        let is_mitsuba = self.scene.extension().is_some_and(|e| e.eq_ignore_ascii_case("xml"));
        let is_define = |o: &&Override| is_mitsuba && !o.path.contains('.');
        let defined = self.set.iter().filter(is_define).map(|o| (o.path.clone(), o.value.clone()));
        let defines = self.define.iter().cloned().chain(defined).collect();
        overrides.extend(self.set.iter().filter(|o| !is_define(o)).cloned());
        let options = LoadOptions {
            integrator: film.integrator.clone(),
            overrides,
            defines,
            allow_outside: self.limits.allow_outside,
            allow_paths: self.limits.allow_path.clone(),
            max_texture_size: self.limits.max_texture_size,
            limits: limits.clone(),
            models,
            threads,
            kept_pictures,
        };
        let Loaded { mut desc, sources, hash, shared_hash } =
            input.load(&options).map_err(|e| needs_path(Failure::load(e, &labels)))?;
        let mut hash = Hashes { whole: hash, shared: shared_hash };
        film.fit(&mut desc.film, &mut hash);
        self.studio.apply_backdrop(&mut desc);
        self.studio.apply_camera(&mut desc, &mut hash);
        self.studio.apply_environment(&mut desc, &mut hash, &options)?;
        let ModelOverrides { time, frame, animation, variant } = &options.models;
        if animation.is_some() || variant.is_some() || options.max_texture_size.is_some() {
            hash.add(format!("{animation:?} {variant:?} {:?}", options.max_texture_size).as_bytes());
        }
        desc.film.motion_blur.then(|| hash.add(format!("frame {frame:?}").as_bytes()));
        let timeless = hash.clone();
        Ok(Described { desc, sources, labels, hash: hash.at_time(*time), timeless })
    }
}

/// Options of the path tracer that were given for another integrator: their errors name the remedy.
fn needs_path(mut failure: Failure) -> Failure {
    const OPTIONS: [&str; 3] = ["--caustics", "--clamp-indirect", flags::SHARED_PATHS_OPTION];
    for error in failure.errors.iter_mut().filter(|e| e.code == ErrorCode::UnknownKey) {
        let source = error.span.and_then(|span| failure.sources.get(span.file));
        let label = source.and_then(|source| failure.labels.get(&source.name));
        let option = OPTIONS.iter().find(|o| label.is_some_and(|l| l.split(' ').next() == Some(**o)));
        if let Some(option) = option {
            error.message = format!("`{option}` is an option of the integrator \"path\"");
            error.help = Some("add `--integrator path`".to_owned());
        }
    }
    failure
}

/// The scene file, or the text read from standard input.
enum Input<'a> {
    File(&'a Path),
    Text(String),
}

impl Input<'_> {
    fn new(path: &Path) -> Result<Input<'_>, Failure> {
        if path.is_dir() {
            let message = format!("{}: is a folder; expected a scene or model file", path.display());
            let help = "name a file in it; `turner list formats` lists the formats";
            return Err(Failure::new(SceneError::new(ErrorCode::File, message).help(help)));
        }
        if path != Path::new("-") {
            return Ok(Input::File(path));
        }
        let mut text = String::new();
        let read = std::io::stdin().lock().take(MAX_TEXT + 1).read_to_string(&mut text);
        read.map_err(|e| {
            let message = format!("cannot read standard input: {e}");
            Failure::new(SceneError::new(ErrorCode::File, message).help("scenes are UTF-8 text"))
        })?;
        Ok(Input::Text(text))
    }

    fn load(&self, options: &LoadOptions) -> Result<Loaded, LoadError> {
        match self {
            Input::File(path) => load_with(path, options),
            Input::Text(text) => {
                let assets = FolderAssets::new("")
                    .map_err(|e| LoadError { error: e.to_scene_error(), sources: Sources::default() })?;
                let assets = open_to(assets, options)
                    .map_err(|e| LoadError { error: e.to_scene_error(), sources: Sources::default() })?;
                load_text(text.clone(), "-", &assets, options)
            }
        }
    }
}
