//! Developed AOVs: from sums and labels to the channels of a file.

use super::Renderer;
use super::cryptomatte::{self, Matte};
use crate::denoise::{DenoiseOptions, denoise_part};
use crate::film::{Aov, Average, Film, HITS, Half, LabelKind};
use crate::scene::Scene;
use crate::schema::MaterialId;
use crate::view::View;

/// The samples of a channel, row by row from the top left.
#[derive(Clone, Debug, PartialEq)]
pub enum AovValues {
    /// Floats.
    Float(Vec<f32>),
    /// Integers.
    Uint(Vec<u32>),
}

/// A developed channel of an AOV.
#[derive(Clone, Debug, PartialEq)]
pub struct AovChannel {
    /// The AOV.
    pub aov: Aov,
    /// Its name in an EXR file: `Z`, `N.X`, `albedo.R`.
    pub name: String,
    /// One sample for each pixel of the crop.
    pub values: AovValues,
}

/// Less coverage than this counts as none.
const LEAST_HITS: f32 = 1e-6;

impl Renderer {
    /// The channels of the film's AOVs so far, in the order of [`Aov::all`]. A pixel without samples has the values
    /// of one that hits nothing. `threads` of 0 uses all.
    pub fn develop_aovs(&self, threads: usize) -> Vec<AovChannel> {
        let (film, aovs) = (&self.film, &self.prepared.view.film.aovs);
        let mut out = Vec::new();
        for aov in aovs.iter() {
            let layout = aov.layout();
            let mut add = |name: &str, values| out.push(AovChannel { aov, name: name.to_owned(), values });
            match layout.average {
                Average::Samples => {
                    for name in aovs.channels_of(aov) {
                        add(&name, AovValues::Float(film.channel_values(&name, threads)));
                    }
                }
                Average::Hits(none) => {
                    let hits = film.channel_values(HITS, threads);
                    for name in layout.channels {
                        let sums = film.channel_values(name, threads);
                        let mean = |(v, hit): (&f32, &f32)| if *hit > LEAST_HITS { v / hit } else { none };
                        add(name, AovValues::Float(sums.iter().zip(&hits).map(mean).collect()));
                    }
                }
                Average::Nearest => {
                    let number = |x, y| film.nearest_label(aov.word(), x, y).map_or(0, |label| label + 1);
                    for name in layout.channels {
                        add(name, AovValues::Uint(each(film, number)));
                    }
                }
                Average::Coverage => {
                    for (name, values) in self.matte(aov).channels(film) {
                        add(&name, AovValues::Float(values));
                    }
                }
                Average::Film if aov == Aov::SampleCount => {
                    let count = each(film, |x, y| self.sample_count(x, y));
                    layout.channels.iter().for_each(|name| add(name, AovValues::Uint(count.clone())));
                }
                Average::Film if aov == Aov::Variance => {
                    let variance = each(film, |x, y| film.variance(x, y));
                    layout.channels.iter().for_each(|name| add(name, AovValues::Float(variance.clone())));
                }
                Average::Film if aov == Aov::Shadow => {
                    let shadow = each(film, |x, y| film.shadow(x, y));
                    layout.channels.iter().for_each(|name| add(name, AovValues::Float(shadow.clone())));
                }
                Average::Film if aov == Aov::Error => {
                    let zeros = || vec![0.0; film.crop.area() as usize];
                    let error = film.error(threads).map_or_else(zeros, |error| error.half_width);
                    layout.channels.iter().for_each(|name| add(name, AovValues::Float(error.clone())));
                }
                Average::Film => {
                    let light = each(film, |x, y| film.light(&self.prepared.view.film, x, y));
                    for (i, name) in layout.channels.iter().enumerate() {
                        add(name, AovValues::Float(light.iter().map(|v| v[i]).collect()));
                    }
                }
            }
        }
        if self.prepared.view.film.denoise_aovs {
            self.denoise_aovs(&mut out, threads);
        }
        out
    }

    /// Removes the noise of the AOVs of light, of which each has red, green and blue one after another.
    fn denoise_aovs(&self, channels: &mut [AovChannel], threads: usize) {
        let View { film, instruction_set, .. } = &self.prepared.view;
        let picture = self.film.developed(film, threads);
        let Some(buffers) = self.denoising_buffers(&picture, threads) else { return };
        let options = DenoiseOptions { threads, set: *instruction_set, cancel: None };
        let is_light = |channel: &AovChannel| channel.aov.is_light() && channel.aov != Aov::Denoising;
        let of_light: Vec<&mut AovChannel> = channels.iter_mut().filter(|c| is_light(c)).collect();
        let mut of_light = of_light.into_iter();
        while let (Some(red), Some(green), Some(blue)) = (of_light.next(), of_light.next(), of_light.next()) {
            let is_seen = red.aov == Aov::Emission;
            let planes = [red, green, blue].map(|channel| &mut channel.values);
            let [AovValues::Float(r), AovValues::Float(g), AovValues::Float(b)] = planes else { return };
            let values: Vec<[f32; 3]> = (0..r.len()).map(|i| [r[i], g[i], b[i]]).collect();
            let Some(clean) = denoise_part(&buffers, &values, is_seen, &options) else { return };
            for (c, plane) in [r, g, b].into_iter().enumerate() {
                plane.iter_mut().zip(&clean).for_each(|(to, v)| *to = v[c]);
            }
        }
    }

    /// What a reader of the file needs besides the channels: the attributes of Cryptomatte, and the names of numbers as
    /// JSON. Sorted by name.
    pub fn aov_attributes(&self) -> Vec<(String, String)> {
        let mut out = Vec::new();
        for aov in self.prepared.view.film.aovs.iter() {
            match (aov.layout().average, aov.labels()) {
                (Average::Coverage, _) => out.extend(self.matte(aov).attributes(&self.film)),
                (Average::Nearest, Some(kind)) => {
                    let numbers = each(&self.film, |x, y| self.film.nearest_label(aov.word(), x, y));
                    let mut labels: Vec<u32> = numbers.into_iter().flatten().collect();
                    labels.sort_unstable();
                    labels.dedup();
                    let names = labels
                        .into_iter()
                        .map(|l| ((l + 1).to_string(), label_name(&self.prepared.scene, kind, l)));
                    out.push((format!("turner:{}", aov.word()), cryptomatte::json(names)));
                }
                _ => {}
            }
        }
        out.sort();
        out
    }

    fn matte(&self, aov: Aov) -> Matte<'_> {
        let kind = aov.labels().unwrap_or(LabelKind::Object);
        Matte::new(&self.prepared.scene, aov, kind)
    }

    /// The number of samples of a pixel itself.
    fn sample_count(&self, x: u32, y: u32) -> u32 {
        let grid = self.film.tiles();
        let region = &self.film.region;
        let (column, row) = ((x - region.x) / crate::film::TILE, (y - region.y) / crate::film::TILE);
        let count =
            self.film.held_half(row as usize * grid.columns() + column as usize, Half::of(x, y)).len();
        u32::try_from(count).unwrap_or(u32::MAX)
    }
}

/// A value for each pixel of the crop.
pub(super) fn each<T>(film: &Film, value: impl Fn(u32, u32) -> T) -> Vec<T> {
    let crop = film.crop;
    let rows = crop.y..crop.y + crop.height;
    rows.flat_map(|y| (crop.x..crop.x + crop.width).map(move |x| (x, y))).map(|(x, y)| value(x, y)).collect()
}

/// The name of what a label, counted from 0, numbers: that of the scene, or a number from 1 such as `object.3`. An object
/// of an instance has the names of both: `tree/leaf`.
pub fn label_name(scene: &Scene, kind: LabelKind, label: u32) -> String {
    let number = u64::from(label) + 1;
    match kind {
        LabelKind::Object => {
            let name = scene.object_name(label);
            let own = name.own.map_or_else(|| format!("object.{number}"), str::to_owned);
            match name.instance {
                Some(instance) => format!("{instance}/{own}"),
                None => own,
            }
        }
        LabelKind::Material => {
            scene.material_name(MaterialId(label)).map_or_else(|| format!("material.{number}"), str::to_owned)
        }
        LabelKind::Instance => {
            scene.entry_name(label).map_or_else(|| format!("instance.{number}"), str::to_owned)
        }
    }
}
