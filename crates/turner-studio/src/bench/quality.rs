//! How good the picture is, moments after a move: FLIP against the converged picture.

use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use turner::compare::{Canvas, Metric, Pair};
use turner::film::auto_exposure;
use turner::image::{Image, Pixels};
use turner::{PassOptions, Picture, Renderer, SceneDesc};
use turner_io::image::{ImageFormat, OutputFile, OutputImage, decode, encode};

use super::motion::orbit;
use super::scenes::Scene;
use super::session::Session;
use super::table::{Row, Table};

/// Moments after the move in milliseconds, and the most that the FLIP of a scene and the mean of all scenes may be.
const MOMENTS: [(u64, Option<f64>, Option<f64>); 4] =
    [(80, None, Some(0.15)), (250, None, None), (1500, Some(0.14), Some(0.08)), (4000, None, None)];

/// Samples per pixel of the converged picture.
const SAMPLES: u32 = 256;

/// After this time without a move the window says that nothing moves.
const STILL: Duration = Duration::from_millis(150);

/// Repetitions of the move.
const REPEAT: usize = 3;

/// The values of all scenes.
#[derive(Default)]
pub(super) struct Total {
    /// For each moment the means of the scenes.
    means: [Vec<f64>; 4],
}

impl Total {
    pub(super) fn print(&self, size: [u32; 2], table: &mut Table) {
        for ((ms, _, target), means) in
            MOMENTS.into_iter().zip(&self.means).filter(|(_, means)| !means.is_empty())
        {
            let mean = means.iter().sum::<f64>() / means.len() as f64;
            let what = format!("mean FLIP {ms} ms after a move");
            let note = String::new();
            let row = Row {
                scene: "all",
                size: Some(size),
                what: &what,
                unit: "",
                values: vec![mean],
                target,
                note,
            };
            table.add(&row);
        }
    }
}

pub(super) fn measure(
    scene: &Scene,
    size: [u32; 2],
    references: Option<&Path>,
    table: &mut Table,
    total: &mut Total,
) -> Result<(), String> {
    let mut session = Session::new(scene.open(size)?, size);
    let begun = Instant::now();
    let (_, first) = session.first(session.order(false), begun)?;
    orbit(&mut session.document, Some(&first), 0.15)?;
    let moved = session.document.desc().camera.clone();
    let reference = reference(scene, session.document.desc(), size, references)?;
    let mut values: [Vec<f64>; 4] = Default::default();
    for _ in 0..REPEAT {
        orbit(&mut session.document, None, -0.15)?;
        session.first(session.order(false), begun)?;
        session.rest(Duration::from_millis(1500));
        let back = session.document.edit("Camera", Some("camera"), |desc| {
            desc.camera.clone_from(&moved);
            Ok(())
        });
        back.map_err(|e| e.message)?;
        let started = Instant::now();
        session.order(true);
        let mut is_still = false;
        for ((ms, ..), values) in MOMENTS.iter().zip(&mut values) {
            let moment = Duration::from_millis(*ms);
            if moment > STILL && !is_still {
                std::thread::sleep(STILL.saturating_sub(started.elapsed()));
                session.order(false);
                is_still = true;
            }
            std::thread::sleep(moment.saturating_sub(started.elapsed()));
            let shown = session.shown().ok_or("nothing is shown")?;
            values.push(flip(&reference, &shown.picture)?);
        }
    }
    for (i, (ms, target, _)) in MOMENTS.into_iter().enumerate() {
        let values = std::mem::take(&mut values[i]);
        total.means[i].push(values.iter().sum::<f64>() / values.len() as f64);
        let what = format!("FLIP {ms} ms after a move");
        let note = String::new();
        table.add(&Row { scene: &scene.name, size: Some(size), what: &what, unit: "", values, target, note });
    }
    Ok(())
}

/// The display values of a picture.
fn canvas(picture: &Picture) -> Canvas {
    let bytes = picture.display.iter().flat_map(|[r, g, b, _]| [*r, *g, *b]).collect();
    let (width, height) = (picture.width, picture.height);
    Canvas::new(&Image { width, height, channels: 3, pixels: Pixels::U8(bytes) }, false)
}

/// FLIP of display values. A smaller picture is enlarged as the window does it.
fn flip(reference: &Picture, shown: &Picture) -> Result<f64, String> {
    let shown = canvas(shown).resized(reference.width, reference.height);
    let pair = Pair::new(canvas(reference), shown).map_err(|e| e.to_string())?;
    Ok(Metric::Flip.measure(&pair, 0).value)
}

/// The converged picture: read from the folder, or rendered and kept there.
fn reference(
    scene: &Scene,
    desc: &SceneDesc,
    size: [u32; 2],
    folder: Option<&Path>,
) -> Result<Picture, String> {
    let plain = |c: char| if c.is_alphanumeric() { c } else { '-' };
    let name: String = scene.name.chars().map(plain).collect();
    let path = folder.map(|folder| folder.join(format!("{name}-{}x{}.exr", size[0], size[1])));
    if let Some(path) = path.as_deref().filter(|path| path.is_file()) {
        let bytes = std::fs::read(path).map_err(|e| format!("{}: {e}", path.display()))?;
        let image =
            decode(&bytes, &path.display().to_string(), &Default::default()).map_err(|e| e.to_string())?;
        if [image.width, image.height] != size {
            return Err(format!("{}: has another size", path.display()));
        }
        let places = (0..image.height).flat_map(|y| (0..image.width).map(move |x| (x, y)));
        let pixel = |(x, y)| {
            let [r, g, b] = image.rgb(x, y);
            [r, g, b, image.alpha(x, y)]
        };
        return Ok(shown(desc, size, places.map(pixel).collect()));
    }
    let mut desc = desc.clone();
    desc.film.samples = SAMPLES;
    let prepared = desc.prepare(&Default::default()).map_err(|e| e.message)?;
    let mut renderer = Renderer::new(prepared).map_err(|e| e.message)?;
    let never = AtomicBool::new(false);
    renderer
        .pass(u32::MAX, &PassOptions { threads: 0, cancel: &never, progress: None })
        .map_err(|e| e.message)?;
    let picture = renderer.develop();
    if let Some(path) = path {
        std::fs::create_dir_all(path.parent().unwrap_or(Path::new("."))).map_err(|e| e.to_string())?;
        let [width, height] = size;
        let linear = Some(&picture.linear[..]);
        let image = OutputImage { width, height, alpha: picture.has_alpha, linear, ..OutputImage::default() };
        let bytes = encode(&image, ImageFormat::Exr).map_err(|e| e.to_string())?;
        OutputFile::create(&path).and_then(|file| file.commit(&bytes)).map_err(|e| e.to_string())?;
    }
    Ok(shown(&desc, size, picture.linear))
}

/// A picture with the display values that the film gives it.
fn shown(desc: &SceneDesc, size: [u32; 2], linear: Vec<[f32; 4]>) -> Picture {
    let automatic = if desc.film.auto_exposure { auto_exposure(&linear) } else { 0.0 };
    let mut picture = Picture {
        width: size[0],
        height: size[1],
        display: Vec::new(),
        has_alpha: linear.iter().any(|pixel| pixel[3] != 1.0),
        missing: 0,
        exposure: desc.film.exposure + automatic,
        linear,
    };
    picture.display = picture.transform(&desc.film).to_8_bits(&picture.linear, 0);
    picture
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::scenes;

    #[test]
    fn a_kept_reference_is_the_rendered_one() {
        let folder = tempfile::tempdir().unwrap();
        let scene = scenes::list(&[]).unwrap().remove(0);
        let size = [48, 27];
        let document = scene.open(size).unwrap();
        let rendered = reference(&scene, document.desc(), size, Some(folder.path())).unwrap();
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
        let read = reference(&scene, document.desc(), size, Some(folder.path())).unwrap();
        assert!(read.display == rendered.display);
        assert_eq!(flip(&rendered, &read).unwrap(), 0.0);
        let mut other = rendered.clone();
        other.display.iter_mut().for_each(|pixel| *pixel = [255, 0, 255, 255]);
        assert!(flip(&rendered, &other).unwrap() > 0.3);
    }
}
