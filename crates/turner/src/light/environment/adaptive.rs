//! Adaptive sampling of an environment: learns which part of the sky each part of the scene sees.
//!
//! In a room the sky is seen through windows. Sampling in proportion to the luminance of the sky sends most shadow rays
//! into walls. So a pilot run traces some shadow rays first. It divides the sky into tiles ([`Tiles`]) and space into
//! cells ([`Cells`]), and keeps for each cell and tile the mean square of visibility times cosine, g². Tiles are then
//! chosen in proportion to
//!
//! ```text
//!   P(tile | cell)  ∝  luminance of the tile · √(mean g²)        pdf(ω) = P(tile | cell) · p(ω | tile)
//! ```
//!
//! which minimises the variance among all choices of tiles. A tenth of the samples follows luminance alone, so every
//! direction that emits light has a pdf above 0, and the estimator stays unbiased whatever the pilot run has missed.
//! Cells with few rays borrow from the larger cells that hold them, and tiles from their neighbours.
//!
//! The method is that of Atanasov et al. 2018, "Adaptive Environment Sampling on CPU and GPU".

use std::ops::RangeInclusive;
use std::sync::Arc;

use turner_bvh::lanes::{Block, LANES};

use super::cells::Cells;
use super::distribution::{Distribution, Row};
use super::tiles::{COLUMNS, ROWS, TILES, Tiles, choose, ends};
use super::{EnvironmentLight, EnvironmentSample, map};
use crate::color::Spectrum;
use crate::math::{DVec2, DVec3};

/// Points of the pilot run per cell.
const POINTS_PER_CELL: usize = 48;

/// Mean square that a cell without any rays has, and the number of rays that this assumption and the means of larger
/// cells count for.
const PRIOR: f32 = 0.05;
const WEIGHT: f32 = 2.0;

/// How much a ray counts in the eight tiles around its own: what is seen of them is similar, and at the edges of windows
/// some light is seen in tiles where no ray has found it.
const NEIGHBOURS: f32 = 0.25;

/// Rows of pixels of the image that directions are sampled from. Larger images are scaled down for that: the tables fit
/// into caches, and radiance still comes from the full image. Smaller ones, such as a uniform environment, are enlarged,
/// so that each tile has pixels.
const IMAGE_ROWS: RangeInclusive<u32> = 64..=256;

/// Part of the choices that follows luminance alone.
const SAFE: f64 = 0.1;

/// Variance, relative to sampling by luminance, above which nothing is gained.
const MOST_VARIANCE: f64 = 0.7;

/// An environment with a choice of tiles for each cell of space.
#[derive(Clone, Debug)]
pub struct AdaptiveEnvironment {
    /// Index of the light in the scene.
    light: u32,
    environment: EnvironmentLight,
    tables: Arc<Tables>,
}

#[derive(Debug)]
struct Tables {
    distribution: Distribution,
    tiles: Tiles,
    cells: Cells,
    choices: Vec<TileChoice>,
}

/// The choice of a tile in a cell: of a row by the second random number, and of a column in it by the first.
#[derive(Clone, Debug)]
struct TileChoice {
    /// The end of each row in 0..=1.
    rows: [f32; ROWS],
    /// The end of each column in 0..=1, row by row.
    columns: [f32; TILES],
}

impl TileChoice {
    /// In proportion to `weights`.
    fn new(weights: &[f64; TILES]) -> TileChoice {
        let mut choice = TileChoice { rows: [1.0; ROWS], columns: [1.0; TILES] };
        let sums: [f64; ROWS] = std::array::from_fn(|row| weights[row * COLUMNS..][..COLUMNS].iter().sum());
        ends(&sums, &mut choice.rows);
        for (weights, columns) in weights.chunks(COLUMNS).zip(choice.columns.chunks_mut(COLUMNS)) {
            ends(weights, columns);
        }
        choice
    }

    /// The tile, its probability, and the random numbers rescaled to 0..1.
    #[inline]
    fn sample(&self, [u, v]: [f64; 2]) -> (usize, f64, [f64; 2]) {
        let (row, of_row, v) = choose(&self.rows, v);
        let (column, of_column, u) = choose(&self.columns[row * COLUMNS..][..COLUMNS], u);
        (row * COLUMNS + column, of_row * of_column, [u, v])
    }

    #[inline]
    fn probability(&self, tile: usize) -> f64 {
        let (row, column) = (tile / COLUMNS, tile % COLUMNS);
        let width = |ends: &[f32], i: usize| {
            f64::from(ends[i]) - i.checked_sub(1).map_or(0.0, |before| f64::from(ends[before]))
        };
        width(&self.rows, row) * width(&self.columns[row * COLUMNS..][..COLUMNS], column)
    }
}

impl AdaptiveEnvironment {
    /// The index of the light in the scene.
    pub fn light(&self) -> u32 {
        self.light
    }

    /// The cell of a point.
    #[inline]
    pub fn cell(&self, p: DVec3) -> u32 {
        self.tables.cells.of(p) as u32
    }

    /// The cells of eight points, by coordinate.
    #[inline]
    pub fn cells_of_block(&self, p: &[Block; 3]) -> [u32; LANES] {
        self.tables.cells.of_block(p).map(|cell| cell as u32)
    }

    /// Samples a direction for a cell from two uniform numbers in 0..1.
    pub fn sample(&self, cell: u32, u: [f64; 2]) -> Option<EnvironmentSample> {
        let (row, factor) = self.row(cell, u)?;
        let (map, distribution) = (&self.environment.prepared.map, &self.tables.distribution);
        let (across, cos_theta, pdf) = distribution.position(&row, distribution.span(&row)?)?;
        let sin_theta = (1.0 - cos_theta * cos_theta).max(0.0).sqrt();
        let uv = DVec2::new(across, map::height(sin_theta, cos_theta));
        let direction = self.environment.to_world(map::direction_at(across, sin_theta, cos_theta));
        let (radiance, pdf) = (self.environment.scaled(map.at(uv)), pdf * factor);
        (pdf > 0.0).then_some(EnvironmentSample { direction, radiance, pdf })
    }

    /// The first half of sampling: the row and the position in it, and the factor of the density.
    #[inline]
    pub(super) fn row(&self, cell: u32, u: [f64; 2]) -> Option<(Row, f64)> {
        let Tables { distribution, tiles, choices, .. } = &*self.tables;
        let (tile, chosen, u) = choices.get(cell as usize)?.sample(u);
        let row = tiles.row_in(distribution, tile, u)?;
        Some((row, chosen / tiles.probability(tile)))
    }

    /// The pdf at (u, v) of the image in a cell.
    #[inline]
    pub(super) fn pdf_at(&self, cell: u32, uv: DVec2) -> f64 {
        let Tables { distribution, tiles, choices, .. } = &*self.tables;
        let tile = tiles.at(uv);
        let probability = tiles.probability(tile);
        match choices.get(cell as usize) {
            Some(choice) if probability > 0.0 => {
                distribution.pdf_at(uv) * (choice.probability(tile) / probability)
            }
            _ => 0.0,
        }
    }

    /// Radiance in a direction, and the pdf of [`AdaptiveEnvironment::sample`] in a cell.
    pub fn found(&self, cell: u32, direction: DVec3) -> (Spectrum, f64) {
        let uv = map::coordinates_fast(self.environment.to_image(direction));
        (self.environment.scaled(self.environment.prepared.map.at(uv)), self.pdf_at(cell, uv))
    }

    /// The light that is sampled, and the density within tiles.
    pub(super) fn parts(&self) -> (&EnvironmentLight, &Distribution) {
        (&self.environment, &self.tables.distribution)
    }

    /// Memory of the tables in bytes, without the image.
    pub fn memory(&self) -> usize {
        let Tables { distribution, tiles, cells, choices } = &*self.tables;
        distribution.memory() + tiles.memory() + cells.memory() + size_of_val(&**choices)
    }
}

/// What the rays of a pilot run have found so far.
#[derive(Debug)]
pub struct EnvironmentLearning {
    environment: EnvironmentLight,
    distribution: Distribution,
    tiles: Tiles,
    cells: Cells,
    /// For each node of the tree of cells (inner nodes first) and each tile: number of rays, and sum of g².
    seen: Vec<[f32; 2]>,
}

impl EnvironmentLearning {
    /// For points like these; `None` if the environment is black or memory is short.
    pub fn new(light: &EnvironmentLight, mut points: Vec<DVec3>) -> Option<EnvironmentLearning> {
        if light.is_black() || points.is_empty() {
            return None;
        }
        // Not compensated: directions dimmer than the mean are sampled, too.
        let distribution = Distribution::new(&light.prepared.map.scaled_to(IMAGE_ROWS), false).ok()?;
        if distribution.is_black() {
            return None;
        }
        let tiles = Tiles::new(&distribution);
        let cells = Cells::new(&mut points, POINTS_PER_CELL);
        let seen = vec![[0.0; 2]; (2 * cells.len() - 1) * TILES];
        Some(EnvironmentLearning { environment: light.clone(), distribution, tiles, cells, seen })
    }

    /// A direction in proportion to luminance.
    pub fn direction(&self, u: [f64; 2]) -> Option<DVec3> {
        self.distribution.sample(u).map(|(direction, ..)| self.environment.to_world(direction))
    }

    /// Adds a ray from a point; `g` is visibility times cosine.
    pub fn add(&mut self, p: DVec3, direction: DVec3, g: f32) {
        let uv = map::coordinates_fast(self.environment.to_image(direction));
        let node = self.cells.len() - 1 + self.cells.of(p);
        let [count, sum] = &mut self.seen[node * TILES + self.tiles.at(uv)];
        (*count, *sum) = (*count + 1.0, *sum + g * g);
    }

    /// The adaptive environment; `None` if it reduces the variance too little. `light` is the index of the light.
    pub fn finish(mut self, light: u32) -> Option<AdaptiveEnvironment> {
        let leaves = self.cells.len();
        let inner = leaves - 1;
        for node in (0..inner).rev() {
            for tile in 0..TILES {
                let [a, b] = [1, 2].map(|child| self.seen[(2 * node + child) * TILES + tile]);
                self.seen[node * TILES + tile] = [a[0] + b[0], a[1] + b[1]];
            }
        }
        // Means, from the root down: each is drawn towards that of the larger cell.
        for node in 0..inner + leaves {
            let sums: Vec<[f32; 2]> = self.seen[node * TILES..][..TILES].to_vec();
            for tile in 0..TILES {
                let of_parent =
                    node.checked_sub(1).map_or(PRIOR, |child| self.seen[child / 2 * TILES + tile][1]);
                let mut beside = [0.0; 2];
                for near in beside_tile(tile) {
                    for (to, v) in beside.iter_mut().zip(sums[near]) {
                        *to += v;
                    }
                }
                let [count, sum] = [0, 1].map(|i| sums[tile][i] + NEIGHBOURS * beside[i]);
                self.seen[node * TILES + tile][1] = (sum + WEIGHT * of_parent) / (count + WEIGHT);
            }
        }
        let probability: Vec<f64> = (0..TILES).map(|tile| self.tiles.probability(tile)).collect();
        let (mut choices, mut before, mut after) = (Vec::with_capacity(leaves), 0.0, 0.0);
        for means in self.seen[inner * TILES..].chunks(TILES) {
            let rays: f64 = means.iter().map(|[count, _]| f64::from(*count)).sum();
            let mean = |tile: usize| f64::from(means[tile][1]);
            let mut weights: [f64; TILES] = std::array::from_fn(|tile| probability[tile] * mean(tile).sqrt());
            let sum: f64 = weights.iter().sum();
            for (weight, probability) in weights.iter_mut().zip(&probability) {
                *weight = (1.0 - SAFE) * *weight / sum + SAFE * probability;
            }
            let squares = |choice: &dyn Fn(usize) -> f64| {
                let of = |tile| probability[tile] * probability[tile] * mean(tile) / choice(tile);
                (0..TILES).filter(|tile| probability[*tile] > 0.0).map(of).sum::<f64>()
            };
            before += rays * squares(&|tile| probability[tile]);
            after += rays * squares(&|tile| weights[tile]);
            choices.push(TileChoice::new(&weights));
        }
        let EnvironmentLearning { environment, distribution, tiles, cells, .. } = self;
        (after < MOST_VARIANCE * before).then(|| AdaptiveEnvironment {
            light,
            environment,
            tables: Arc::new(Tables { distribution, tiles, cells, choices }),
        })
    }
}

/// The neighbours of a tile. Columns wrap around.
fn beside_tile(tile: usize) -> impl Iterator<Item = usize> {
    let (row, column) = (tile / COLUMNS, tile % COLUMNS);
    (row.saturating_sub(1)..=(row + 1).min(ROWS - 1))
        .flat_map(move |row| [COLUMNS - 1, 0, 1].map(|step| row * COLUMNS + (column + step) % COLUMNS))
        .filter(move |near| *near != tile)
}
