//! Generated scenes and rays for benchmarks and tests, the same on every machine.
//!
//! A [`SceneKind`] names a scene and [generates](SceneKind::generate) it with about the requested number of triangles.
//! The functions of [`rays`] make the rays of a rendering of it: camera rays, and shadow, diffuse and ambient-occlusion
//! rays from the points that these hit.
//!
//! ```
//! use turner_bvh::generate::{SceneKind, rays};
//!
//! let scene = SceneKind::Cornell.generate(36);
//! assert_eq!(scene.meshes[0].triangles.len(), 36);
//! let camera = rays::primary(&scene.camera, 64);
//! assert_eq!(camera.len(), 64 * 64);
//! ```

mod architecture;
mod cornell;
mod icosphere;
mod instances;
mod math;
mod noise;
mod random;
pub mod rays;
mod sticks;
mod terrain;
#[cfg(test)]
mod tests;

use crate::Aabb;

pub use icosphere::noisy_icosphere;
pub use random::Random;

/// An indexed triangle mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Vertices.
    pub positions: Vec<[f32; 3]>,
    /// Three vertex indices each.
    pub triangles: Vec<[u32; 3]>,
}

/// An instance of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instance {
    /// Index of the mesh in the scene.
    pub mesh: u32,
    /// Object-to-world transform: the rows of a 3x4 matrix.
    pub transform: [[f32; 4]; 3],
}

/// A pinhole camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Position of the camera.
    pub eye: [f32; 3],
    /// The point at the centre of the image.
    pub target: [f32; 3],
    /// The up direction in the image.
    pub up: [f32; 3],
    /// Half the width of the image plane at distance 1.
    pub half_width: f32,
}

/// A scene with a camera and a light.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Meshes. A scene without instances has one mesh, in world space.
    pub meshes: Vec<Mesh>,
    /// Instances of the meshes; empty if the scene is its one mesh.
    pub instances: Vec<Instance>,
    /// A suitable view of the scene.
    pub camera: Camera,
    /// A point light.
    pub light: [f32; 3],
}

/// The available scenes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SceneKind {
    /// The Cornell box: 36 triangles. Fits into the level-1 cache.
    Cornell,
    /// A hall of columns, stairs, railings and ornament: triangles from the length of the hall to a thousandth of it.
    Architecture,
    /// A sphere displaced by noise, like a scanned stone: many triangles of similar size.
    Scan,
    /// Long thin sticks in a cube: boxes that are mostly empty.
    Sticks,
    /// A height field with more triangles than any cache holds.
    Terrain,
    /// A thousand instances of a noisy sphere of 81,920 triangles.
    Instances1k,
    /// A million instances of a noisy sphere of 1,280 triangles.
    Instances1m,
}

impl SceneKind {
    /// All scenes.
    pub const ALL: [SceneKind; 7] = [
        SceneKind::Cornell,
        SceneKind::Architecture,
        SceneKind::Scan,
        SceneKind::Sticks,
        SceneKind::Terrain,
        SceneKind::Instances1k,
        SceneKind::Instances1m,
    ];

    /// The name of the scene, in lower case.
    pub const fn name(self) -> &'static str {
        match self {
            SceneKind::Cornell => "cornell",
            SceneKind::Architecture => "architecture",
            SceneKind::Scan => "scan",
            SceneKind::Sticks => "sticks",
            SceneKind::Terrain => "terrain",
            SceneKind::Instances1k => "instances-1k",
            SceneKind::Instances1m => "instances-1m",
        }
    }

    /// The default size: triangles, or instances.
    pub const fn default_size(self) -> usize {
        match self {
            SceneKind::Cornell => 36,
            SceneKind::Architecture => 66_000,
            SceneKind::Scan => 1_310_720,
            SceneKind::Sticks => 500_000,
            SceneKind::Terrain => 10_000_000,
            SceneKind::Instances1k => 1_000,
            SceneKind::Instances1m => 1_000_000,
        }
    }

    /// The scene with at most `size` triangles, or exactly `size` instances.
    ///
    /// Each scene comes as close to `size` as its structure allows: the Cornell box always has 36 triangles, the scan
    /// the largest 20 * 4^n, the terrain the largest 2 * n^2, the sticks the largest 6 * n. The hall has at least about
    /// 26,000 triangles, which it needs without ornament.
    pub fn generate(self, size: usize) -> Scene {
        match self {
            SceneKind::Cornell => cornell::scene(),
            SceneKind::Architecture => architecture::scene(size),
            SceneKind::Scan => icosphere::scene(size),
            SceneKind::Sticks => sticks::scene(size),
            SceneKind::Terrain => terrain::scene(size),
            SceneKind::Instances1k => instances::scene(size, 6),
            SceneKind::Instances1m => instances::scene(size, 3),
        }
    }
}

impl Mesh {
    /// The bounds of all vertices.
    pub fn bounds(&self) -> Aabb {
        self.positions.iter().fold(Aabb::EMPTY, |bounds, &p| bounds.grow(p))
    }

    /// The vertices of a triangle.
    pub fn triangle(&self, index: usize) -> [[f32; 3]; 3] {
        self.triangles[index].map(|i| self.positions[i as usize])
    }

    /// Adds a vertex and returns its index.
    fn vertex(&mut self, position: [f32; 3]) -> u32 {
        self.positions.push(position);
        (self.positions.len() - 1) as u32
    }

    /// Adds a planar quadrilateral with its own vertices, in order around it.
    fn quad(&mut self, corners: [[f32; 3]; 4]) {
        let [a, b, c, d] = corners.map(|p| self.vertex(p));
        self.triangles.extend([[a, b, c], [a, c, d]]);
    }

    /// Adds a parallelepiped: a corner and the three edges from it. Twelve triangles.
    fn block(&mut self, corner: [f32; 3], edges: [[f32; 3]; 3]) {
        let [x, y, z] = edges;
        let at = |i: f32, j: f32, k: f32| -> [f32; 3] {
            std::array::from_fn(|n| corner[n] + i * x[n] + j * y[n] + k * z[n])
        };
        for side in [0.0, 1.0] {
            self.quad([at(side, 0.0, 0.0), at(side, 1.0, 0.0), at(side, 1.0, 1.0), at(side, 0.0, 1.0)]);
            self.quad([at(0.0, side, 0.0), at(1.0, side, 0.0), at(1.0, side, 1.0), at(0.0, side, 1.0)]);
            self.quad([at(0.0, 0.0, side), at(1.0, 0.0, side), at(1.0, 1.0, side), at(0.0, 1.0, side)]);
        }
    }
}

impl Scene {
    /// A scene of one mesh.
    fn of(mesh: Mesh, camera: Camera, light: [f32; 3]) -> Scene {
        Scene { meshes: vec![mesh], instances: Vec::new(), camera, light }
    }

    /// The bounds of the scene in world space.
    pub fn bounds(&self) -> Aabb {
        let boxes: Vec<Aabb> = self.meshes.iter().map(Mesh::bounds).collect();
        if self.instances.is_empty() {
            return boxes.into_iter().fold(Aabb::EMPTY, Aabb::union);
        }
        let placed = self.instances.iter().map(|i| i.bounds(boxes[i.mesh as usize]));
        placed.fold(Aabb::EMPTY, Aabb::union)
    }

    /// The length of the diagonal of [`bounds`](Self::bounds).
    pub fn extent(&self) -> f32 {
        let bounds = self.bounds();
        math::length(math::sub(bounds.max, bounds.min))
    }

    /// Number of triangles, counted once per instance.
    pub fn triangles(&self) -> usize {
        match self.instances.as_slice() {
            [] => self.meshes.iter().map(|m| m.triangles.len()).sum(),
            placed => placed.iter().map(|i| self.meshes[i.mesh as usize].triangles.len()).sum(),
        }
    }

    /// The vertices of a triangle in world space. `instance` is ignored in a scene without instances.
    pub fn triangle(&self, instance: u32, primitive: u32) -> [[f32; 3]; 3] {
        match self.instances.get(instance as usize) {
            Some(placed) => {
                let corners = self.meshes[placed.mesh as usize].triangle(primitive as usize);
                corners.map(|p| math::transform(&placed.transform, p))
            }
            None => self.meshes[0].triangle(primitive as usize),
        }
    }
}

impl Instance {
    /// The bounds of a box after the instance's transform.
    pub fn bounds(&self, bounds: Aabb) -> Aabb {
        let sides = [bounds.min, bounds.max];
        let corner = |i: usize| [sides[i & 1][0], sides[i >> 1 & 1][1], sides[i >> 2][2]];
        (0..8).fold(Aabb::EMPTY, |all, i| all.grow(math::transform(&self.transform, corner(i))))
    }
}
