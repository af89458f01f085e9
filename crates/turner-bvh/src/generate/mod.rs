//! Scenes and rays to measure and test trees with: generated, the same on every machine.
//!
//! A [`SceneKind`] names a scene and [generates](SceneKind::generate) it with as many triangles as asked for. The
//! functions of [`rays`] make the rays of a picture of it: those of the camera, and shadow, diffuse and ambient-occlusion
//! rays from what these hit.
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

/// Triangles by the indices of their vertices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Vertices.
    pub positions: Vec<[f32; 3]>,
    /// Three vertices each.
    pub triangles: Vec<[u32; 3]>,
}

/// A placed copy of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instance {
    /// Which of the scene's meshes.
    pub mesh: u32,
    /// From the mesh to the world: the rows of a 3x4 matrix.
    pub transform: [[f32; 4]; 3],
}

/// Where a picture is taken from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The eye.
    pub eye: [f32; 3],
    /// What lies in the middle of the picture.
    pub target: [f32; 3],
    /// What points upwards in the picture.
    pub up: [f32; 3],
    /// Half the width of the picture at distance 1.
    pub half_width: f32,
}

/// A scene with a camera and a light.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Meshes. Without instances there is one, and it stands for itself.
    pub meshes: Vec<Mesh>,
    /// Copies of the meshes; none if the scene is its one mesh.
    pub instances: Vec<Instance>,
    /// The sensible place to look from.
    pub camera: Camera,
    /// A point light.
    pub light: [f32; 3],
}

/// The scenes there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SceneKind {
    /// The Cornell box: 36 triangles. Everything fits the fastest cache.
    Cornell,
    /// A hall of columns, stairs, railings and ornament: triangles from the length of the hall to a thousandth of it.
    Architecture,
    /// A sphere with noise upon it, as a scanner sees a stone: many triangles of one size.
    Scan,
    /// Long thin sticks criss-cross in a cube: boxes that hold next to nothing.
    Sticks,
    /// A landscape: more triangles than any cache holds.
    Terrain,
    /// A thousand copies of a noisy sphere of 81,920 triangles.
    Instances1k,
    /// A million copies of a noisy sphere of 1,280 triangles.
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

    /// The name of the scene, in small letters.
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

    /// The usual size: triangles, or instances.
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
    /// Each scene has as many triangles as its structure lets it come near to `size`: the Cornell box always 36, the
    /// scan the largest 20 * 4^n, the terrain the largest 2 * n^2, the sticks the largest 6 * n. The hall needs about
    /// 26,000 triangles without ornament and has them even if fewer are asked for.
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
    /// The box around all vertices.
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

    /// Adds a flat quadrilateral with vertices of its own, in order around it.
    fn quad(&mut self, corners: [[f32; 3]; 4]) {
        let [a, b, c, d] = corners.map(|p| self.vertex(p));
        self.triangles.extend([[a, b, c], [a, c, d]]);
    }

    /// Adds a box that may be turned: a corner and the three edges from it. Twelve triangles.
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

    /// The box around everything.
    pub fn bounds(&self) -> Aabb {
        let boxes: Vec<Aabb> = self.meshes.iter().map(Mesh::bounds).collect();
        if self.instances.is_empty() {
            return boxes.into_iter().fold(Aabb::EMPTY, Aabb::union);
        }
        let placed = self.instances.iter().map(|i| i.bounds(boxes[i.mesh as usize]));
        placed.fold(Aabb::EMPTY, Aabb::union)
    }

    /// The length of the diagonal of the box around everything.
    pub fn extent(&self) -> f32 {
        let bounds = self.bounds();
        math::length(math::sub(bounds.max, bounds.min))
    }

    /// Triangles, each as often as it is placed.
    pub fn triangles(&self) -> usize {
        match self.instances.as_slice() {
            [] => self.meshes.iter().map(|m| m.triangles.len()).sum(),
            placed => placed.iter().map(|i| self.meshes[i.mesh as usize].triangles.len()).sum(),
        }
    }

    /// The vertices of a triangle in the world. `instance` is not looked at in a scene without instances.
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
    /// The box around a placed box.
    pub fn bounds(&self, bounds: Aabb) -> Aabb {
        let sides = [bounds.min, bounds.max];
        let corner = |i: usize| [sides[i & 1][0], sides[i >> 1 & 1][1], sides[i >> 2][2]];
        (0..8).fold(Aabb::EMPTY, |all, i| all.grow(math::transform(&self.transform, corner(i))))
    }
}
