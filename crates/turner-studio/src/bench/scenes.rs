//! What is measured: files, scenes of the gallery, and two large scenes.

use std::io::Write;
use std::path::{Path, PathBuf};

use turner::description::{ObjectDesc, SceneDesc};
use turner::math::DVec3;
use turner::schema::MaterialId;
use turner::shape::{ShapeDesc, SphereDesc};
use turner_live::document::{Document, STARTS};

/// Scenes of the gallery that are measured.
const GALLERY: [&str; 3] = ["13. Thirty spheres", "Material balls", "Interior"];

/// Rows and columns of the scene of 10,000 objects.
const SIDE: u32 = 100;

/// A scene to measure.
pub(super) struct Scene {
    pub(super) name: String,
    source: Source,
    /// Whether its converged picture is compared.
    pub(super) converges: bool,
}

enum Source {
    File(PathBuf),
    Gallery(&'static str),
    Many,
}

/// The scenes of these files; without files the default ones.
pub(super) fn list(files: &[PathBuf]) -> Result<Vec<Scene>, String> {
    if files.is_empty() {
        let gallery = GALLERY.map(|name| Scene {
            name: name.to_owned(),
            source: Source::Gallery(name),
            converges: true,
        });
        let many = Scene { name: "10,000 objects".into(), source: Source::Many, converges: false };
        return Ok(gallery.into_iter().chain([many]).collect());
    }
    let of = |path: &PathBuf| {
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let scene = Scene { name, source: Source::File(path.clone()), converges: true };
        // What cannot be read is said before hours of measuring.
        scene.open([64, 36]).map(|_| scene)
    };
    files.iter().map(of).collect()
}

impl Scene {
    /// The scene as a document whose film has this size.
    pub(super) fn open(&self, size: [u32; 2]) -> Result<Document, String> {
        let mut document = match &self.source {
            Source::File(path) => Document::open(path).map_err(|e| e.message)?,
            Source::Gallery(name) => {
                let start = STARTS.iter().find(|start| start.name == *name);
                let start = start.ok_or(format!("the gallery has no scene {name}"))?;
                Document::start(start).map_err(|e| e.message)?
            }
            Source::Many => Document::of(many(), self.name.clone(), PathBuf::from(".")),
        };
        let sized = document.edit("Size", None, |desc| {
            [desc.film.width, desc.film.height] = size;
            Ok(())
        });
        sized.map_err(|e| e.message)?;
        Ok(document)
    }

    /// Whether one of many objects is moved.
    pub(super) fn has_many(&self) -> bool {
        matches!(self.source, Source::Many)
    }
}

/// A field of 10,000 spheres of ten materials, lit by the environment of the default studio.
fn many() -> SceneDesc {
    let text = "[integrator]\ntype = \"path\"\n[camera]\nposition = [0, 40, 70]\nlook_at = [0, 0, 0]\nfov = 50\n\
                [[light]]\ntype = \"environment\"\n[[light]]\ntype = \"point\"\nposition = [20, 40, 30]\nintensity = 2000\n";
    let materials =
        (0..10).map(|i| format!("[material.m{i}]\ntype = \"matte\"\ncolor = [0.{i}, 0.5, 0.4]\n"));
    let text = text.to_owned() + &materials.collect::<String>();
    let assets = turner_io::assets::MemoryAssets::default();
    let loaded = turner_io::scene::load_text(text, "many.toml", &assets, &Default::default());
    let mut desc = loaded.map(|loaded| loaded.desc).unwrap_or_default();
    let center = |i: u32| DVec3::new(f64::from(i % SIDE) - 49.5, 0.0, f64::from(i / SIDE) - 49.5);
    let ball = |i: u32| ObjectDesc {
        material: Some(MaterialId(i % 10)),
        ..ObjectDesc::new(ShapeDesc::Sphere(SphereDesc { center: center(i), radius: 0.4 }))
    };
    desc.objects = (0..SIDE * SIDE).map(ball).collect();
    desc
}

/// Writes a hilly terrain of a million triangles as binary PLY.
pub(super) fn write_million(path: &Path) -> std::io::Result<()> {
    const SQUARES: u32 = 708;
    let (points, triangles) = ((SQUARES + 1) * (SQUARES + 1), 2 * SQUARES * SQUARES);
    let mut out = std::io::BufWriter::new(std::fs::File::create(path)?);
    write!(
        out,
        "ply\nformat binary_little_endian 1.0\nelement vertex {points}\nproperty float x\nproperty float y\n\
         property float z\nelement face {triangles}\nproperty list uchar int vertex_indices\nend_header\n"
    )?;
    for i in 0..points {
        let (x, z) = (i % (SQUARES + 1), i / (SQUARES + 1));
        let height = ((x * 7 + z * 13) % 17) as f32 * 2e-4;
        for v in [x as f32 / SQUARES as f32 - 0.5, height, z as f32 / SQUARES as f32 - 0.5] {
            out.write_all(&v.to_le_bytes())?;
        }
    }
    for i in 0..SQUARES * SQUARES {
        let a = i / SQUARES * (SQUARES + 1) + i % SQUARES;
        for corners in [[a, a + SQUARES + 1, a + SQUARES + 2], [a, a + SQUARES + 2, a + 1]] {
            out.write_all(&[3])?;
            for corner in corners {
                out.write_all(&corner.to_le_bytes())?;
            }
        }
    }
    out.flush()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_large_scenes_are_large() {
        let scenes = list(&[]).unwrap();
        let many = scenes.iter().find(|scene| scene.has_many()).unwrap().open([64, 36]).unwrap();
        assert_eq!((many.desc().objects.len(), many.desc().materials.len()), (10_000, 10));
        assert_eq!((many.desc().lights.len(), many.desc().film.width), (2, 64));
        many.desc().prepare(&Default::default()).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("million.ply");
        write_million(&path).unwrap();
        let document = Document::open(&path).unwrap();
        let triangles: usize = document.desc().meshes.iter().map(|mesh| mesh.data.triangles.len()).sum();
        assert!(triangles >= 1_000_000, "{triangles}");
    }

    #[test]
    fn a_file_that_cannot_be_read_is_refused_at_once() {
        assert!(list(&["no-such-scene.toml".into()]).is_err());
    }
}
