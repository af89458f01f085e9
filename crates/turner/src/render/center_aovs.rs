//! AOVs of what the centres of pixels show, without light and without a film: labels for learning, of which thousands are
//! made.
//!
//! One ray is traced through the centre of each pixel and of the lens, at time 0 of the shutter. The values are those of a
//! film with one such sample, but they go straight to their places: no sums, no tiles, no locks.

use std::sync::Mutex;

use turner_bvh::lanes::{Block, LANES};

use super::aovs::AovValues;
use super::work::Work;
use super::{PassOptions, Prepared};
use crate::film::{Aov, Average, FilmDesc, Fixed96, NO_LABEL, PixelRect};
use crate::integrator::aovs::SurfaceAovs;
use crate::scene::{Hit, Scene};
use crate::schema::{ErrorCode, SceneError};
use crate::view::{CameraSamples, View, take_centers};

/// Rows of a task.
const ROWS: u32 = 4;

/// Width of a batch in pixels. Its rays and hits fit in the caches.
const COLUMNS: u32 = 64;

/// Width of a packet in pixels: its 16 rays form a block of 4 x 4.
const SIDE: u32 = 4;

/// An AOV at the centres of pixels, row by row from the top left.
#[derive(Clone, Debug, PartialEq)]
pub struct CenterAov {
    /// The AOV.
    pub aov: Aov,
    /// For each pixel of the crop as many values as the AOV has channels.
    pub values: AovValues,
}

/// The rows of an AOV that belong to one task.
enum Rows<'a> {
    Float(&'a mut [f32]),
    Uint(&'a mut [u32]),
}

/// The AOVs of the film of a prepared scene at the centres of the pixels of its crop, in the order of
/// [`Aov::all`](crate::film::Aov::all). `None` if it was cancelled.
///
/// Errors: AOVs of light or of several samples ([`ErrorCode::Conflict`]); a panic in a worker.
pub fn center_aovs(
    prepared: &Prepared,
    options: &PassOptions<'_>,
) -> Result<Option<Vec<CenterAov>>, SceneError> {
    let film = &prepared.view.film;
    for aov in film.aovs.iter() {
        let is_first = matches!(aov.layout().average, Average::Samples | Average::Hits(_) | Average::Nearest);
        if !is_first || aov.needs_paths() {
            let message = format!("the AOV \"{}\" is not one of the first surface", aov.word());
            return Err(SceneError::new(ErrorCode::Conflict, message).help("render the picture for it"));
        }
    }
    let view = View { labels: true, moves: false, motion: None, ..prepared.view.clone() };
    let crop = crop_of(film);
    let mut out: Vec<CenterAov> = film.aovs.iter().map(|aov| empty(aov, crop.area() as usize)).collect();
    let tasks = tasks_of(&mut out, &crop);
    let whole = Work::new(options).run(tasks.len(), |numbers| {
        let mut batch = Batch::new(prepared, &view);
        for number in numbers {
            let mut rows = tasks[number].lock().unwrap_or_else(|e| e.into_inner());
            let top = number as u32 * ROWS;
            let height = ROWS.min(crop.height - top);
            for left in (0..crop.width).step_by(COLUMNS as usize) {
                batch.trace(PixelRect { x: left, y: top, width: COLUMNS.min(crop.width - left), height });
                batch.fill(&mut rows);
            }
        }
    })?;
    drop(tasks);
    Ok(whole.then_some(out))
}

/// The number of channels of an AOV.
fn depth(aov: Aov) -> usize {
    aov.layout().channels.len()
}

/// An AOV of so many pixels, without values.
fn empty(aov: Aov, pixels: usize) -> CenterAov {
    let values = match aov.layout().average {
        Average::Nearest => AovValues::Uint(vec![0; pixels * depth(aov)]),
        _ => AovValues::Float(vec![0.0; pixels * depth(aov)]),
    };
    CenterAov { aov, values }
}

/// For each task the rows of all AOVs that it fills.
fn tasks_of<'a>(out: &'a mut [CenterAov], crop: &PixelRect) -> Vec<Mutex<Vec<Rows<'a>>>> {
    let mut tasks: Vec<Vec<Rows<'a>>> = Vec::new();
    tasks.resize_with(crop.height.div_ceil(ROWS) as usize, Vec::new);
    let pixels = (ROWS * crop.width) as usize;
    for CenterAov { aov, values } in out {
        let length = pixels * depth(*aov);
        match values {
            AovValues::Float(all) => {
                tasks.iter_mut().zip(all.chunks_mut(length)).for_each(|(task, v)| task.push(Rows::Float(v)));
            }
            AovValues::Uint(all) => {
                tasks.iter_mut().zip(all.chunks_mut(length)).for_each(|(task, v)| task.push(Rows::Uint(v)));
            }
        }
    }
    tasks.into_iter().map(Mutex::new).collect()
}

/// The samples of some pixels, one for each.
struct Batch<'a> {
    scene: &'a Scene,
    view: &'a View,
    crop: PixelRect,
    aovs: SurfaceAovs<'a>,
    samples: CameraSamples,
    hits: Vec<Option<Hit>>,
    packets: Packets,
    /// The first column of the batch within the crop.
    left: u32,
}

/// The pixels of a batch in the order of its ray packets, relative to the top left pixel of the batch.
#[derive(Default)]
struct Packets {
    size: [u32; 2],
    /// Their centres, in blocks of eight; NaN in the lanes after the last.
    centers: Vec<[Block; 2]>,
    /// Their indices among those of a task.
    pixels: Vec<usize>,
}

impl Packets {
    fn new([width, height]: [u32; 2], columns: u32) -> Packets {
        let mut out = Packets { size: [width, height], ..Packets::default() };
        for first in (0..width).step_by(SIDE as usize) {
            for row in 0..height {
                for column in first..width.min(first + SIDE) {
                    let lane = out.pixels.len() % LANES;
                    if lane == 0 {
                        out.centers.push([Block([f64::NAN; LANES]); 2]);
                    }
                    if let Some([x, y]) = out.centers.last_mut() {
                        (x.0[lane], y.0[lane]) = (f64::from(column) + 0.5, f64::from(row) + 0.5);
                    }
                    out.pixels.push((row * columns + column) as usize);
                }
            }
        }
        out
    }
}

impl<'a> Batch<'a> {
    fn new(prepared: &'a Prepared, view: &'a View) -> Batch<'a> {
        Batch {
            scene: &prepared.scene,
            view,
            crop: crop_of(&view.film),
            aovs: SurfaceAovs::new(&prepared.scene, view),
            samples: CameraSamples::default(),
            hits: Vec::new(),
            packets: Packets::default(),
            left: 0,
        }
    }

    /// Traces the camera rays through the pixel centres of a rectangle within the crop, packet by packet.
    fn trace(&mut self, rect: PixelRect) {
        let size = [rect.width, rect.height];
        if self.packets.size != size {
            self.packets = Packets::new(size, self.crop.width);
        }
        self.left = rect.x;
        let left = f64::from(self.crop.x + rect.x);
        let top = f64::from(self.crop.y + rect.y);
        self.samples.clear();
        let mut count = self.packets.pixels.len();
        for [x, y] in &self.packets.centers {
            let at = [Block(x.0.map(|x| left + x)), Block(y.0.map(|y| top + y))];
            take_centers(self.view, &mut self.samples, &at, count.min(LANES));
            count -= count.min(LANES);
        }
        self.scene.intersect_batch(&mut self.samples.rays, &mut self.hits);
        self.scene.look_past_hidden(&self.samples.rays, &mut self.hits);
    }

    /// Writes the values to the rows of a task.
    fn fill(&mut self, rows: &mut [Rows<'_>]) {
        let left = self.left as usize;
        let blocks = self.packets.pixels.chunks(LANES).zip(self.hits.chunks(LANES));
        for (number, (pixels, hits)) in blocks.enumerate() {
            let first = number * LANES;
            let mut present = [false; LANES];
            present.iter_mut().zip(hits).for_each(|(present, hit)| *present = hit.is_some());
            if present.contains(&true) {
                self.aovs.compute(&self.samples, &self.hits, first..first + hits.len());
            }
            let mut summed = 0;
            for (aov, rows) in self.view.film.aovs.iter().zip(&mut *rows) {
                match (rows, aov.labels()) {
                    (Rows::Uint(rows), Some(kind)) => {
                        for (pixel, hit) in pixels.iter().zip(hits) {
                            let label = hit.as_ref().map_or(NO_LABEL, |hit| self.aovs.label(kind, hit));
                            // 0 says that there is nothing.
                            rows[left + *pixel] = if label == NO_LABEL { 0 } else { label + 1 };
                        }
                    }
                    (Rows::Float(rows), _) => {
                        let none = match aov.layout().average {
                            Average::Hits(none) => none,
                            _ => 0.0,
                        };
                        let channel = |channel: usize| {
                            // As the sum of one sample in a film.
                            let values = Fixed96::means_of_one(self.aovs.channel(summed, channel));
                            std::array::from_fn(|lane| if present[lane] { values[lane] } else { none })
                        };
                        match depth(aov) {
                            1 => write([channel(0)], pixels, left, rows),
                            2 => write([0, 1].map(channel), pixels, left, rows),
                            _ => write([0, 1, 2].map(channel), pixels, left, rows),
                        }
                        summed += 1;
                    }
                    (Rows::Uint(_), None) => {}
                }
            }
        }
    }
}

/// Writes the channels of up to eight pixels.
#[inline]
fn write<const N: usize>(channels: [[f32; LANES]; N], pixels: &[usize], left: usize, rows: &mut [f32]) {
    let rows = rows.as_chunks_mut::<N>().0;
    for (lane, pixel) in pixels.iter().enumerate() {
        rows[left + *pixel] = channels.map(|channel| channel[lane]);
    }
}

/// The pixels that are shown.
fn crop_of(film: &FilmDesc) -> PixelRect {
    let [x, y, width, height] = film.crop.unwrap_or([0, 0, film.width, film.height]);
    PixelRect { x, y, width, height }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::AtomicBool;

    use super::*;
    use crate::Renderer;
    use crate::camera::{CameraDesc, FisheyeDesc, PinholeDesc};
    use crate::description::{ObjectDesc, SceneDesc};
    use crate::film::{Antialias, Aov, Aovs};
    use crate::math::{DAffine3, DVec3};
    use crate::schema::{Asset, MeshData, MeshId, PrepareOptions, Transform};
    use crate::shape::{BoxDesc, MeshDesc, PlaneDesc, ShapeDesc, SphereDesc};

    fn scene(aovs: &[Aov]) -> SceneDesc {
        let mut desc = SceneDesc::default();
        (desc.film.width, desc.film.height) = (61, 37);
        desc.film.antialias = Antialias::None;
        desc.film.aovs = Aovs::new(aovs);
        desc.objects.push(ObjectDesc::new(ShapeDesc::Sphere(SphereDesc::default())));
        desc.objects.push(ObjectDesc::new(ShapeDesc::Box(BoxDesc::default())));
        desc.objects.push(ObjectDesc::new(ShapeDesc::Plane(PlaneDesc::default())));
        let positions = vec![[-1.0, 0.0, 0.5], [1.5, 0.2, 0.0], [0.3, 1.7, 0.1], [1.4, 1.2, 0.9]];
        let data = MeshData { positions, triangles: vec![[0, 1, 2], [1, 3, 2]], ..MeshData::default() };
        desc.meshes.push(Asset { uri: String::new(), data: Arc::new(data) });
        for angle in [0.0, 2.0] {
            let mut object =
                ObjectDesc::new(ShapeDesc::Mesh(MeshDesc { mesh: MeshId(0), ..MeshDesc::default() }));
            object.transform = Transform(DAffine3::from_rotation_y(angle));
            desc.objects.push(object);
        }
        desc
    }

    /// What a film with one sample through each centre has, to the last bit.
    #[test]
    fn values_are_those_of_a_film() {
        let all = [
            Aov::Depth,
            Aov::Normal,
            Aov::ObjectId,
            Aov::Position,
            Aov::MaterialId,
            Aov::Uv,
            Aov::Albedo,
            Aov::InstanceId,
        ];
        // The corners of the second picture have no rays.
        let pinhole = CameraDesc::Pinhole(PinholeDesc::default());
        let fisheye = CameraDesc::Fisheye(FisheyeDesc {
            position: DVec3::new(0.0, 1.0, 5.0),
            ..FisheyeDesc::default()
        });
        for (crop, aovs, camera) in [
            (None, &all[..], &pinhole),
            (None, &all[..], &fisheye),
            (Some([7, 5, 30, 21]), &all[..3], &pinhole),
            (None, &all[2..3], &pinhole),
        ] {
            let mut desc = scene(aovs);
            desc.camera = Some(camera.clone().into());
            desc.film.crop = crop;
            let prepared = desc.prepare(&PrepareOptions::default()).unwrap();
            let never = AtomicBool::new(false);
            let mut renderer = Renderer::new(prepared.clone()).unwrap();
            let options = PassOptions { threads: 2, cancel: &never, progress: None };
            renderer.pass(1, &options).unwrap();
            for threads in [1, 3] {
                let options = PassOptions { threads, ..options };
                let found = center_aovs(&prepared, &options).unwrap().unwrap();
                let mut of_film = renderer.develop_aovs(1).into_iter();
                for own in &found {
                    let depth = own.aov.layout().channels.len();
                    for channel in 0..depth {
                        let film = of_film.next().unwrap();
                        assert_eq!(own.aov, film.aov);
                        let of_channel = channel_of(&own.values, depth, channel);
                        let differs = difference(&of_channel, &film.values);
                        assert!(of_channel == film.values, "{} {crop:?}: {differs}", film.name);
                    }
                }
                assert_eq!(of_film.next(), None);
            }
        }
    }

    /// Whatever the camera sees is as without the limit, or farther away than it: in `center_aovs` and in a film.
    #[test]
    fn what_is_beyond_far_is_invisible() {
        let never = AtomicBool::new(false);
        let options = PassOptions { threads: 1, cancel: &never, progress: None };
        let depths = |far: Option<f64>| {
            let mut desc = scene(&[Aov::Depth]);
            let pinhole = PinholeDesc { position: DVec3::new(0.0, 1.0, 5.0), far, ..PinholeDesc::default() };
            desc.camera = Some(CameraDesc::Pinhole(pinhole).into());
            let prepared = desc.prepare(&PrepareOptions::default()).unwrap();
            let own = center_aovs(&prepared, &options).unwrap().unwrap();
            let mut renderer = Renderer::new(prepared).unwrap();
            renderer.pass(1, &options).unwrap();
            let of_film = renderer.develop_aovs(1).into_iter().next().unwrap();
            assert_eq!(own[0].values, of_film.values);
            let AovValues::Float(values) = of_film.values else { panic!("numbers") };
            values
        };
        // The depth of nothing.
        let none = 1e10;
        let all = depths(None);
        let hidden = [3.0, 4.2, 6.0, 20.0].map(|far| {
            let expected: Vec<f32> =
                all.iter().map(|d| if f64::from(*d) <= far { *d } else { none }).collect();
            let found = depths(Some(far));
            assert!(found == expected, "{far}: {:?}", found.iter().zip(&expected).find(|(a, b)| a != b));
            found.iter().filter(|d| **d == none).count()
        });
        assert!(hidden[0] < all.len() && hidden[3] > 0, "{hidden:?} of {}", all.len());
        assert!(hidden.is_sorted_by(|a, b| a > b), "{hidden:?}");
    }

    /// One channel of the values of all.
    fn channel_of(values: &AovValues, depth: usize, channel: usize) -> AovValues {
        match values {
            AovValues::Float(v) => AovValues::Float(v.iter().copied().skip(channel).step_by(depth).collect()),
            AovValues::Uint(v) => AovValues::Uint(v.iter().copied().skip(channel).step_by(depth).collect()),
        }
    }

    /// The first values that differ.
    fn difference(a: &AovValues, b: &AovValues) -> String {
        match (a, b) {
            (AovValues::Float(a), AovValues::Float(b)) => {
                format!("{:?} of {}, {}", a.iter().zip(b).find(|(a, b)| a != b), a.len(), b.len())
            }
            (a, b) => format!("{} differs", if a == b { "nothing" } else { "a label" }),
        }
    }

    #[test]
    fn light_is_refused_and_cancels_are_heard() {
        for aov in [Aov::Direct, Aov::CryptoObject, Aov::SampleCount, Aov::Cost, Aov::Denoising] {
            let prepared = scene(&[aov]).prepare(&PrepareOptions::default()).unwrap();
            let never = AtomicBool::new(false);
            let options = PassOptions { threads: 1, cancel: &never, progress: None };
            assert_eq!(center_aovs(&prepared, &options).unwrap_err().code, ErrorCode::Conflict, "{aov:?}");
        }
        let prepared = scene(&[Aov::Depth]).prepare(&PrepareOptions::default()).unwrap();
        let options = PassOptions { threads: 1, cancel: &AtomicBool::new(true), progress: None };
        assert_eq!(center_aovs(&prepared, &options).unwrap(), None);
    }
}
