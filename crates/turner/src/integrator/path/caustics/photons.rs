//! Photons: vertices of light paths that camera paths gather (vertex merging).
//!
//! ```text
//!  o camera                 * light
//!   \                      /
//!    m mirror            target
//!     \                  /
//!      \   .-------.    /
//!       \ ( · x  ·  )  /        x: vertex of the camera path;  ·: photons within radius r
//!          '-------'
//! ```
//!
//! A caustic seen in a mirror or through glass cannot be joined to the camera. Where a camera path that came by
//! specular surfaces alone reaches another surface, the photons within the radius r estimate the density of light there
//! (Jensen 1996): L = sum of f · power / (π r²) over photons, over the number of light paths. This blurs, so r shrinks
//! with the sample index n, r² ∝ n^(α−1) with α = 0.7, and the mean over samples converges (Knaus and Zwicker 2011,
//! "Progressive photon mapping: a probabilistic approach"). Photons are found in a hashed grid of cells with edges of
//! 2 r: at most eight cells per query.

use super::light_path_batch::LightPathBatch;
use super::strategy::CausticsStrategy;
use crate::color::Spectrum;
use crate::film::Splat;
use crate::integrator::RayStats;
use crate::integrator::path::Context;
use crate::math::DVec3;
use crate::math::elementary::pow;

/// The α of r² ∝ n^(α−1).
const SHRINK: f64 = 0.7;

/// Minimum cosine between the normals of a photon and of the surface that gathers it.
const SAME_SIDE: f32 = 0.7;

/// Light that arrives at a surface: 72 bytes.
#[derive(Clone, Copy, Debug)]
pub struct Photon {
    /// Position.
    pub p: DVec3,
    /// Unit vector towards where the light comes from.
    pub light: [f32; 3],
    /// Geometric normal at the position.
    pub normal: [f32; 3],
    /// Power, as if each light path carried all of it: divide by the number of light paths.
    pub power: Spectrum,
    /// Number of scattering events before.
    pub depth: u32,
    /// The light group that it comes from, as an index; `u32::MAX` for none.
    pub group: u32,
    /// Whether the first scattering was by a delta lobe, which camera paths can find only by BSDF sampling.
    pub by_delta: bool,
}

/// The photons of one sample index in a hashed grid.
#[derive(Clone, Debug)]
pub struct PhotonMap {
    /// Sample index.
    pub index: u32,
    /// Radius of the density estimate, in scene units.
    pub radius: f64,
    /// Sorted by cell, within a cell by index.
    photons: Vec<Photon>,
    /// First photon of each cell, then the number of photons.
    cell_starts: Vec<u32>,
    paths: f64,
}

/// The result of a query.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gathered {
    /// Number of photons.
    pub count: u32,
    /// Radiance.
    pub radiance: Spectrum,
}

impl CausticsStrategy {
    /// Radius of the photons for a sample index, in scene units.
    pub fn radius(&self, index: u32) -> f64 {
        self.first_radius * pow(f64::from(index) + 1.0, 0.5 * (SHRINK - 1.0))
    }
}

impl PhotonMap {
    /// Builds the map from photons in the order of their paths.
    pub(crate) fn new(strategy: &CausticsStrategy, index: u32, all: Vec<Photon>) -> PhotonMap {
        let mut map = PhotonMap {
            index,
            radius: strategy.radius(index),
            photons: Vec::new(),
            cell_starts: Vec::new(),
            paths: strategy.paths as f64,
        };
        let cells = all.len().next_power_of_two().clamp(1, 1 << 24);
        map.cell_starts = vec![0; cells + 1];
        let cell_of: Vec<u32> = all.iter().map(|photon| map.cell(map.grid(photon.p))).collect();
        for cell in &cell_of {
            map.cell_starts[*cell as usize + 1] += 1;
        }
        for i in 0..cells {
            map.cell_starts[i + 1] += map.cell_starts[i];
        }
        let mut next_slots = map.cell_starts.clone();
        let mut order = vec![0u32; all.len()];
        for (i, cell) in cell_of.iter().enumerate() {
            let place = &mut next_slots[*cell as usize];
            order[*place as usize] = i as u32;
            *place += 1;
        }
        map.photons = order.iter().map(|i| all[*i as usize]).collect();
        map
    }

    /// Traces the light paths of a sample index in this thread, for a sample that is traced separately.
    pub(in crate::integrator::path) fn of_sample(
        context: Context<'_>,
        strategy: &CausticsStrategy,
        index: u32,
    ) -> PhotonMap {
        let mut batch = LightPathBatch::new(context, strategy);
        let mut photons = Vec::new();
        let mut first = 0;
        while first < strategy.paths {
            let count = (strategy.paths - first).min(4096);
            let number = strategy.paths * u64::from(index) + first;
            batch.advance(number, count as u32, &mut RayStats::default(), |_: Splat, _, _| {});
            photons.append(&mut batch.photons);
            first += count;
        }
        PhotonMap::new(strategy, index, photons)
    }

    /// The grid cell of a point; cells have edges of twice the radius.
    fn grid(&self, p: DVec3) -> [i64; 3] {
        let p = p / (2.0 * self.radius);
        // Coordinates beyond the range of integers lie in the last cell.
        [p.x.floor() as i64, p.y.floor() as i64, p.z.floor() as i64]
    }

    fn cell(&self, [x, y, z]: [i64; 3]) -> u32 {
        let mixed = (x as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15)
            ^ (y as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f)
            ^ (z as u64).wrapping_mul(0x1656_67b1_9e37_79f9);
        let mixed = (mixed ^ (mixed >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        (mixed >> 32) as u32 & (self.cell_starts.len() as u32 - 2)
    }

    /// Visits the photons around a point of a surface with the normal `n`.
    fn for_each_near(&self, p: DVec3, n: [f32; 3], mut visit: impl FnMut(&Photon)) {
        let low = self.grid(p - self.radius);
        let high = self.grid(p + self.radius);
        let mut seen = [u32::MAX; 8];
        let mut len = 0;
        let r2 = self.radius * self.radius;
        for x in low[0]..=high[0].min(low[0].saturating_add(1)) {
            for y in low[1]..=high[1].min(low[1].saturating_add(1)) {
                for z in low[2]..=high[2].min(low[2].saturating_add(1)) {
                    let cell = self.cell([x, y, z]);
                    // Two cells of space may share a cell of the hash table.
                    if seen[..len].contains(&cell) {
                        continue;
                    }
                    seen[len] = cell;
                    len += 1;
                    let (first, end) = (self.cell_starts[cell as usize], self.cell_starts[cell as usize + 1]);
                    for photon in &self.photons[first as usize..end as usize] {
                        let [a, b, c] = photon.normal;
                        if (photon.p - p).length_squared() < r2 && a * n[0] + b * n[1] + c * n[2] > SAME_SIDE
                        {
                            visit(photon);
                        }
                    }
                }
            }
        }
    }

    /// Radiance from the photons around a point that were scattered at most `max_depth` times. `scatters` returns the
    /// BSDF for light from a direction times the cosine of the shading normal to it. `found` receives the light group and
    /// the radiance of each photon.
    pub(super) fn gather(
        &self,
        p: DVec3,
        ng: DVec3,
        max_depth: u32,
        mut scatters: impl FnMut(DVec3) -> Spectrum,
        mut found: impl FnMut(u32, Spectrum),
    ) -> Gathered {
        let mut gathered = Gathered::default();
        let area = std::f64::consts::PI * self.radius * self.radius;
        let density = (1.0 / (area * self.paths)) as f32;
        self.for_each_near(p, ng.as_vec3().to_array(), |photon| {
            if photon.depth > max_depth {
                return;
            }
            let light = DVec3::new(photon.light[0].into(), photon.light[1].into(), photon.light[2].into());
            let cos = light.dot(ng).abs();
            if cos > 0.0 {
                gathered.count += 1;
                let radiance = scatters(light) * photon.power * (1.0 / cos) as f32;
                gathered.radiance += radiance;
                found(photon.group, radiance * density);
            }
        });
        gathered.radiance *= density;
        gathered
    }

    /// Size in bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.photons[..]) + size_of_val(&self.cell_starts[..])
    }
}
