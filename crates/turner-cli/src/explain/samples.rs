//! Which of a pixel's samples are explained.

use turner::film::Antialias;
use turner::integrator::IntegratorDesc;
use turner::integrator::classic::{self as classic_record, TreeRecord};
use turner::integrator::path::{self as path_record, PathRecord};
use turner::render::{PixelRecord, SampleRecord};
use turner::scene::Scene;
use turner::scene::error::{ErrorCode, SceneError};

use super::model::{Explanation, SampleTree};
use super::names::Names;
use super::number::short;
use super::{classic, other, path};

/// Samples that are explained where many are wanted, and where all are.
const MANY: usize = 25;
const ALL: usize = 1024;
/// Samples that are looked through for one that touches what `--path-of` asks for.
const SEARCHED: usize = 1024;

/// What was asked for.
pub(super) struct Wanted<'a> {
    pub(super) sample: Option<usize>,
    pub(super) path_of: Option<&'a str>,
    pub(super) all: bool,
    /// Whether there is room for many samples.
    pub(super) many: bool,
    /// Whether trees of classic samples and paths are read: JSON has their records.
    pub(super) nodes: bool,
}

/// What happened to a sample, by whoever traced it.
pub(super) enum Record {
    Tree(Box<TreeRecord>),
    Path(Box<PathRecord>),
    Other,
}

/// An explanation, and the records that it was made from: one for each tree.
pub(super) struct Explained<'a> {
    pub(super) names: Names<'a>,
    pub(super) explanation: Explanation,
    pub(super) records: Vec<Record>,
}

/// How much a sample brings to the pixel.
fn carries(s: &SampleRecord) -> f64 {
    let most = s.radiance.color.map(f32::abs).max_component();
    if most.is_finite() { s.weight * f64::from(most) } else { f64::MAX }
}

/// Explains a pixel. Errors: a sample that it has not.
pub(super) fn explain<'a>(
    names: &Names<'a>,
    scene_name: String,
    pixel: PixelRecord,
    wanted: &Wanted<'_>,
) -> Result<Explained<'a>, SceneError> {
    let scene = names.scene;
    let listed = pixel.samples.len();
    if let Some(n) = wanted.sample
        && n >= listed
    {
        let has = match listed {
            1 => "this pixel has one sample, number 0".to_owned(),
            _ => format!("samples of this pixel are numbered 0 to {}", listed.saturating_sub(1)),
        };
        let message = format!("there is no sample {n}: {has}");
        let help = "`--samples N --antialias monte-carlo` takes more";
        return Err(SceneError::new(ErrorCode::OutOfRange, message).help(help));
    }
    // The ones that carry most come first.
    let mut order: Vec<usize> = (0..listed).collect();
    order.sort_by(|&a, &b| {
        let brings = |i: usize| pixel.samples.get(i).map_or(0.0, carries);
        brings(b).total_cmp(&brings(a)).then(a.cmp(&b))
    });
    let mut choice = None;
    let mut numbers = match wanted.sample {
        Some(n) => vec![n],
        None => {
            let room = if wanted.all {
                ALL
            } else if wanted.many {
                MANY
            } else {
                1
            };
            choice = chosen(&pixel, &order, room);
            order.iter().copied().take(room).collect()
        }
    };
    if let (Some(name), None) = (wanted.path_of, wanted.sample) {
        let touching = touching(names, &pixel, &order, wanted)?;
        let searched = listed.min(SEARCHED);
        if listed > 1 {
            choice = Some(match touching.len() {
                0 => format!("none of {searched} samples touches \"{name}\""),
                n => format!("{n} of {searched} samples touch \"{name}\""),
            });
        }
        if !touching.is_empty() {
            numbers = touching.into_iter().take(numbers.len()).collect();
        }
    }
    numbers.sort_unstable();
    let (mut trees, mut records) = (Vec::new(), Vec::new());
    for n in numbers {
        let Some(sample) = pixel.samples.get(n) else { continue };
        let (tree, record) = one(names, n, *sample, wanted)?;
        trees.push(tree);
        records.push(record);
    }
    let explanation = Explanation {
        scene: scene_name,
        integrator: scene.integrator.type_name(),
        size: [scene.film.width, scene.film.height],
        seed: scene.film.seed,
        averaging: averaging(scene, &pixel),
        pixel,
        trees,
        path_of: wanted.path_of.map(str::to_owned),
        choice,
    };
    Ok(Explained { names: *names, explanation, records })
}

fn one(
    names: &Names<'_>,
    n: usize,
    sample: SampleRecord,
    wanted: &Wanted<'_>,
) -> Result<(SampleTree, Record), SceneError> {
    let nodes = wanted.nodes || wanted.path_of.is_some();
    Ok(match &names.scene.integrator {
        IntegratorDesc::Classic(_) => {
            let record = classic_record::replay_at(names.scene, sample.id, sample.place)?;
            let tree = match nodes {
                true => classic::tree(names, &record, n, sample, wanted.path_of),
                false => SampleTree::new(n, sample, record.sum()),
            };
            (tree, Record::Tree(Box::new(record)))
        }
        IntegratorDesc::Path(_) | IntegratorDesc::Direct(_) => {
            let record = path_record::replay_at(names.scene, sample.id, sample.place)?;
            let tree = match nodes {
                true => path::tree(names, &record, n, sample, wanted.path_of),
                false => SampleTree::new(n, sample, record.sum()),
            };
            (tree, Record::Path(Box::new(record)))
        }
        _ => (other::tree(names, n, sample, wanted.path_of), Record::Other),
    })
}

/// The samples that touch what is asked for, those that carry most first.
fn touching(
    names: &Names<'_>,
    pixel: &PixelRecord,
    order: &[usize],
    wanted: &Wanted<'_>,
) -> Result<Vec<usize>, SceneError> {
    let mut out = Vec::new();
    for &n in order.iter().take(SEARCHED) {
        let Some(sample) = pixel.samples.get(n) else { continue };
        let (tree, _) = one(names, n, *sample, wanted)?;
        if tree.nodes.iter().any(|node| node.touches) {
            out.push(n);
        }
    }
    Ok(out)
}

/// Which sample carries most.
fn chosen(pixel: &PixelRecord, order: &[usize], room: usize) -> Option<String> {
    let most = *order.first()?;
    if pixel.samples.len() < 2 {
        return None;
    }
    let all: f64 = pixel.samples.iter().map(carries).sum();
    let share = pixel.samples.get(most).map_or(0.0, carries) / all;
    let percent =
        if share.is_finite() { format!(", {} % of the pixel", short(share * 100.0)) } else { String::new() };
    let shown = match pixel.samples.len() <= room {
        true => String::new(),
        false if room == 1 => "; it is shown: --sample N shows another, --all all of them".to_owned(),
        false => format!("; the {room} that carry most are shown"),
    };
    Some(format!("sample {most} carries most{percent}{shown}"))
}

/// Whether the film scales a sample down.
fn is_cut(scene: &Scene, s: &SampleRecord) -> bool {
    let most = scene.film.max_sample;
    most > 0.0 && s.radiance.color.max_component() > most as f32
}

/// How the samples become the pixel.
fn averaging(scene: &Scene, pixel: &PixelRecord) -> String {
    let mut samples = mean_of_samples(scene, pixel);
    let cut = pixel.samples.iter().filter(|s| is_cut(scene, s)).count();
    if cut > 0 {
        samples += &format!("; {cut} of them cut to {} (film.max_sample)", short(scene.film.max_sample));
    }
    match scene.caustics {
        Some(_) => {
            format!("{samples}; in the picture light paths bring more to it (--caustics off: nothing)")
        }
        None => samples,
    }
}

fn mean_of_samples(scene: &Scene, pixel: &PixelRecord) -> String {
    let n = pixel.count;
    match scene.film.antialias {
        Antialias::None => "its one sample".to_owned(),
        Antialias::Mean => format!("the mean of {n} samples: its own and those of its neighbours"),
        Antialias::Grid => format!("the mean of {n} samples on a grid"),
        Antialias::MonteCarlo if n == 1 => "its one sample, at a random place".to_owned(),
        Antialias::MonteCarlo => format!("the mean of {n} samples at random places"),
        Antialias::Adaptive => {
            let squares = pixel.squares.len();
            let divided = if squares == 1 {
                "one square: its corners are much alike".to_owned()
            } else {
                format!(
                    "{squares} squares, divided where corners differ by more than {}",
                    scene.film.threshold
                )
            };
            format!("{n} samples at the corners of {divided}; a square counts as the mean of its corners")
        }
    }
}
