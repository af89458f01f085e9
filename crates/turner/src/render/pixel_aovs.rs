//! The AOVs of one pixel, whatever AOVs its film has.

use super::aovs::AovChannel;
use super::tile::TileBuffers;
use super::work::Stop;
use super::{AovValues, Renderer};
use crate::film::{Aov, Aovs, Average, Denoise, FilmDesc};
use crate::integrator::Prepared;
use crate::schema::SceneError;
use crate::view::check_pixel;

/// An AOV that is told of one pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct PixelAov {
    /// The AOV.
    pub aov: Aov,
    /// The name of its layer in an EXR file, without the channel: "albedo", "light.key", "Z".
    pub layer: String,
    /// One value for each channel.
    pub values: Vec<f64>,
}

impl PixelAov {
    /// The label that it numbers, counted from 0; `None` for values that are no labels, and where nothing is hit.
    pub fn label(&self) -> Option<u32> {
        self.aov.labels()?;
        let number = self.values.first().copied().filter(|number| *number >= 1.0)?;
        Some(number as u32 - 1)
    }
}

/// Whether AOVs of one pixel include it. Cryptomatte has a value for each name of the scene, the denoiser's guides are of no use
/// alone, light paths reach all pixels of the picture at once, and errors are smoothed over neighbours.
fn is_told(aov: Aov, splits_light: bool) -> bool {
    let needs_split = aov.is_light() || matches!(aov, Aov::Cost | Aov::Bounces);
    aov.layout().average != Average::Coverage
        && !matches!(aov, Aov::Denoising | Aov::Caustics | Aov::Error)
        && (splits_light || !needs_split)
}

/// The AOVs of the pixel in column `x`, row `y` (from 0, top left), from its first `samples` samples; with all samples of the
/// picture they are those that the AOVs of its film would have there. Light of light paths is left out. `cancel` stops it, and
/// it returns what the samples so far give.
///
/// Errors: a pixel outside the picture ([`ErrorCode::OutOfRange`](crate::schema::ErrorCode::OutOfRange)).
pub fn pixel_aovs(
    p: &Prepared,
    x: u32,
    y: u32,
    samples: u32,
    cancel: &std::sync::atomic::AtomicBool,
) -> Result<Vec<PixelAov>, SceneError> {
    p.choose(1);
    check_pixel(&p.view, x, y)?;
    let splits_light = p.integrator.capabilities().splits_light;
    let told: Vec<Aov> = Aov::all().filter(|aov| is_told(*aov, splits_light)).collect();
    let mut p = p.clone();
    let mut aovs = Aovs::new(&told);
    aovs.know_scene(p.scene.light_groups.names(), p.view.film.aovs.catches_shadows());
    p.view.film = FilmDesc {
        crop: Some([x, y, 1, 1]),
        aovs,
        denoise: Denoise::Off,
        denoise_aovs: false,
        adaptive_sampling: false,
        auto_exposure: false,
        ..p.view.film
    };
    let all = 0..u64::from(samples.clamp(1, p.view.film.samples_per_pixel()));
    let mut renderer = Renderer::new(p)?;
    let prepared = renderer.prepared.clone();
    let mut buffers = TileBuffers::new(&prepared);
    buffers.estimates_error = renderer.film.identity().estimates_error;
    let film = &mut renderer.film;
    for tile in 0..film.tiles().count() {
        let rect = film.tiles().rect(tile);
        let finished = buffers.render(&rect, None, std::slice::from_ref(&all), Stop::when(cancel));
        buffers.deposit((tile, None), &finished, &film.share());
    }
    Ok(layers(renderer.develop_aovs(1)))
}

/// The channels of each layer together.
fn layers(channels: Vec<AovChannel>) -> Vec<PixelAov> {
    let mut out: Vec<PixelAov> = Vec::new();
    for AovChannel { aov, name, values } in channels {
        // The last part of a name is the channel, of a name without parts all of it.
        let layer = match name.rsplit_once('.') {
            Some((layer, channel)) if channel.len() == 1 => layer.to_owned(),
            _ => name,
        };
        let value = match values {
            AovValues::Float(values) => values.first().copied().map(f64::from),
            AovValues::Uint(values) => values.first().copied().map(f64::from),
        };
        match out.last_mut() {
            Some(last) if last.aov == aov && last.layer == layer => last.values.extend(value),
            _ => out.push(PixelAov { aov, layer, values: value.into_iter().collect() }),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicBool;

    use super::*;
    use crate::integrator::{IntegratorDesc, NormalsDesc, PathDesc};
    use crate::render::PassOptions;
    use crate::schema::PrepareOptions;
    use crate::testing::scenes::{grey, lamp, matte, path, plane, sphere, v};

    /// The values of the pixel are those that the picture with these AOVs has there.
    #[test]
    fn a_pixel_has_the_aovs_of_the_picture() {
        let desc = path(PathDesc::default())
            .with(plane(), matte(grey(0.5)))
            .with(sphere(v(0.0, 0.5, 0.0), 0.5), matte(grey(0.8)))
            .lit(lamp(v(2.0, 3.0, 2.0), 9.0))
            .seen_at(v(0.0, 1.0, 4.0), v(0.0, 0.5, 0.0), 40.0)
            .filmed([12, 10], 8);
        let mut whole = desc.clone();
        whole.film.aovs = Aovs::new(&Aov::all().collect::<Vec<_>>());
        let mut renderer = Renderer::new(whole.prepare(&PrepareOptions::default()).unwrap()).unwrap();
        let options = PassOptions { threads: 1, cancel: &AtomicBool::new(false), progress: None };
        renderer.pass(u32::MAX, &options).unwrap();
        let plain = desc.prepare(&PrepareOptions::default()).unwrap();
        let (x, y) = (6, 4);
        let found = pixel_aovs(&plain, x, y, u32::MAX, &AtomicBool::new(false)).unwrap();
        assert!(found.len() > 20);
        for channel in renderer.develop_aovs(1) {
            let Some(own) = found.iter().find(|own| own.aov == channel.aov) else {
                assert!(!is_told(channel.aov, true), "{:?}", channel.aov);
                continue;
            };
            let i = (y * 12 + x) as usize;
            let expected = match &channel.values {
                AovValues::Float(values) => f64::from(values[i]),
                AovValues::Uint(values) => f64::from(values[i]),
            };
            assert!(own.values.contains(&expected), "{}: {:?} {expected}", channel.name, own.values);
        }
        assert_eq!(found.iter().find(|own| own.aov == Aov::ObjectId).and_then(PixelAov::label), Some(1));
        assert!(pixel_aovs(&plain, 12, 0, 1, &AtomicBool::new(false)).is_err());
        // A debug view knows nothing of light.
        let mut normals = desc;
        normals.integrator = IntegratorDesc::Normals(NormalsDesc::default());
        let normals = normals.prepare(&PrepareOptions::default()).unwrap();
        let found = pixel_aovs(&normals, x, y, 4, &AtomicBool::new(false)).unwrap();
        assert!(found.iter().all(|own| !own.aov.is_light()) && found.iter().any(|own| own.aov == Aov::Uv));
    }
}
