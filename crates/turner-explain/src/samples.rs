//! Selects the samples of a pixel that are explained, and replays them.

use turner::color::Spectrum;
use turner::film::Antialias;
use turner::integrator::Prepared;
use turner::render::{PixelRecord, SampleRecord};
use turner::schema::{ErrorCode, SceneError};

use super::record::{Explanation, Listed, Sample, Square, VERSION};
use turner::explain::number::short;
use turner::explain::{Names, Replay, contribution};

/// Most samples that are explained on pages and in JSON, and with `--all`.
const MANY: usize = 25;
const ALL: usize = 1024;
/// Most samples that are searched for `--path-of`.
const SEARCHED: usize = 1024;

/// The requested samples.
pub(crate) struct Wanted {
    pub(crate) sample: Option<usize>,
    pub(crate) all: bool,
    /// Whether the format shows many samples.
    pub(crate) many: bool,
}

/// Explains a pixel. Errors: there is no such sample.
pub(crate) fn explain<'a>(
    names: &Names<'a>,
    (scene_name, scene_hash): (String, String),
    pixel: PixelRecord,
    wanted: &Wanted,
) -> Result<Explanation<'a>, SceneError> {
    let p = names.prepared;
    let listed = pixel.samples.len();
    if let Some(n) = wanted.sample
        && n >= listed
    {
        let has = match listed {
            1 => "this pixel has one sample, number 0".to_owned(),
            _ => format!("samples of this pixel are numbered 0 to {}", listed.saturating_sub(1)),
        };
        let message = format!("there is no sample {n}: {has}");
        let help = "take more samples with `--samples N --antialias monte-carlo`";
        return Err(SceneError::new(ErrorCode::OutOfRange, message).help(help));
    }
    // By falling contribution.
    let mut order: Vec<usize> = (0..listed).collect();
    order.sort_by(|&a, &b| {
        let of = |i: usize| pixel.samples.get(i).map_or(0.0, contribution);
        of(b).total_cmp(&of(a)).then(a.cmp(&b))
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
    if let (Some(name), None) = (names.path_of, wanted.sample) {
        let touching = touching(names, &pixel, &order)?;
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
    let samples = numbers.into_iter().filter_map(|n| Some(one(names, n, pixel.samples.get(n)?)));
    let explained = samples.collect::<Result<Vec<_>, _>>()?;
    let [r, g, b, alpha] = pixel.color;
    Ok(Explanation {
        format: "turner-explanation",
        version: VERSION,
        turner: env!("CARGO_PKG_VERSION"),
        scene: scene_name,
        scene_hash,
        integrator: names.desc.integrator.type_name(),
        seed: p.view.film.seed,
        size: [p.view.film.width, p.view.film.height],
        pixel: [pixel.x, pixel.y],
        color: Spectrum::new(r, g, b),
        alpha,
        antialias: p.view.film.antialias.word(),
        sample_count: pixel.count,
        samples: pixel.samples.iter().map(listed_sample).collect(),
        squares: pixel.squares.iter().map(square).collect(),
        path_of: names.path_of.map(str::to_owned),
        exact: explained.iter().all(|s| s.exact),
        explained,
        averaging: averaging(p, &pixel),
        choice,
    })
}

fn listed_sample(s: &SampleRecord) -> Listed {
    Listed { pixel_position: s.place, weight: s.weight, color: s.radiance.color, alpha: s.radiance.alpha }
}

fn square(s: &turner::render::Square) -> Square {
    Square { corner: s.corner, size: s.size, spread: s.spread }
}

fn one<'a>(names: &Names<'a>, n: usize, sample: &SampleRecord) -> Result<Sample<'a>, SceneError> {
    Ok(Sample::new(names, n, sample, Replay::new(names.prepared, names.desc, sample)?))
}

/// The samples that `--path-of` selects, by falling contribution.
fn touching(names: &Names<'_>, pixel: &PixelRecord, order: &[usize]) -> Result<Vec<usize>, SceneError> {
    let mut out = Vec::new();
    for &n in order.iter().take(SEARCHED) {
        let Some(sample) = pixel.samples.get(n) else { continue };
        if one(names, n, sample)?.touches == Some(true) {
            out.push(n);
        }
    }
    Ok(out)
}

/// Says which sample has the largest contribution.
fn chosen(pixel: &PixelRecord, order: &[usize], room: usize) -> Option<String> {
    let most = *order.first()?;
    if pixel.samples.len() < 2 {
        return None;
    }
    let all: f64 = pixel.samples.iter().map(contribution).sum();
    let fraction = pixel.samples.get(most).map_or(0.0, contribution) / all;
    let percent = if fraction.is_finite() {
        format!(", {} % of the pixel", short(fraction * 100.0))
    } else {
        String::new()
    };
    let shown = match pixel.samples.len() <= room {
        true => String::new(),
        false if room == 1 => "; it is shown: --sample N shows another, --all all of them".to_owned(),
        false => format!("; the {room} with the largest contributions are shown"),
    };
    Some(format!("sample {most} has the largest contribution{percent}{shown}"))
}

/// Whether `film.clamp_sample` scales the sample down.
fn is_clamped(p: &Prepared, s: &SampleRecord) -> bool {
    p.view.film.clamp_factor(s.radiance.color * p.view.weight(s.place.into())) < 1.0
}

/// How the samples are averaged.
fn averaging(p: &Prepared, pixel: &PixelRecord) -> String {
    let mut samples = mean_of_samples(p, pixel);
    let clamped = pixel.samples.iter().filter(|s| is_clamped(p, s)).count();
    if clamped > 0 {
        samples += &format!(
            "; {clamped} of them clamped to {} (film.clamp_sample)",
            short(p.view.film.clamp_sample)
        );
    }
    if p.view.weighted {
        let center = [f64::from(pixel.x) + 0.5, f64::from(pixel.y) + 0.5];
        let factor = f64::from(p.view.weight(center.into()));
        samples += &format!("; the lens of the camera multiplies them by about {}", short(factor));
    }
    if pixel.fireflies > 0 {
        samples += &format!("; {} of them scaled down as fireflies (film.fireflies)", pixel.fireflies);
    }
    match p.path().and_then(|path| path.caustics()) {
        Some(_) => {
            format!("{samples}; the picture adds light paths for caustics (--caustics off disables them)")
        }
        None => samples,
    }
}

fn mean_of_samples(p: &Prepared, pixel: &PixelRecord) -> String {
    let n = pixel.count;
    match p.view.film.antialias {
        Antialias::None => "its only sample".to_owned(),
        Antialias::Mean => format!("the mean of {n} samples: its own and those of its neighbours"),
        Antialias::Grid => format!("the mean of {n} samples on a grid"),
        Antialias::MonteCarlo if p.view.film.weights_samples() => {
            let filter = p.view.film.filter.word();
            format!("the mean of the {n} samples within reach of the filter \"{filter}\", weighted by it")
        }
        Antialias::MonteCarlo if n == 1 => "its only sample, at a random position".to_owned(),
        Antialias::MonteCarlo => format!("the mean of {n} samples at random positions"),
        Antialias::Adaptive => {
            let squares = pixel.squares.len();
            let divided = if squares == 1 {
                "one square: its corners are similar".to_owned()
            } else {
                format!(
                    "{squares} squares, divided where corners differ by more than {}",
                    p.view.film.threshold
                )
            };
            format!("{n} samples at the corners of {divided}; a square counts as the mean of its corners")
        }
    }
}
