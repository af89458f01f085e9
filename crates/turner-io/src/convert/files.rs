//! The data files of a converted scene: meshes, images, IES profiles, measured BRDFs, density grids and fonts. Each is written once.

use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use turner::description::{ObjectContent, SceneAssetWriter, SceneDesc};
use turner::image::{Image, Pixels};
use turner::schema::{
    Asset, ErrorCode, FontFile, GridFile, ImageId, MeasuredFile, MeshData, MeshId, ProfileFile, SceneError,
    Warning, WarningKind,
};
use turner::shape::ShapeDesc;

use super::file_names::{Taken, safe, stem};
use super::{ConvertOptions, Converted, WrittenFile, create, exists, output_error};
use crate::image::{ImageFormat, exr, png};
use crate::mesh::{hair, ply};

/// Most vertices and triangles of a mesh that is written inline, so that a person can read it.
const FEW: usize = 12;

/// The kind of a data file, which determines its folder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Mesh,
    Picture,
    Data,
}

/// The suffix of each kind's folder.
const FOLDERS: [(Kind, &str); 3] =
    [(Kind::Mesh, "meshes"), (Kind::Picture, "pictures"), (Kind::Data, "data")];

/// Writes the data files of a scene.
pub(crate) struct Files<'a> {
    options: &'a ConvertOptions,
    /// The folder of the scene, and the prefix of the data folders.
    beside: PathBuf,
    stem: String,
    taken: [Taken; 3],
    /// Folders created here.
    made: Vec<PathBuf>,
    written: Vec<WrittenFile>,
    warnings: Vec<Warning>,
    images: BTreeMap<u32, String>,
    meshes: BTreeMap<u32, Option<String>>,
    profiles: Vec<(ProfileFile, String)>,
    measured: Vec<(MeasuredFile, String)>,
    grids: Vec<(GridFile, String)>,
    fonts: Vec<(FontFile, String)>,
    /// Number of objects that use each mesh.
    uses: Vec<u32>,
}

impl<'a> Files<'a> {
    /// Prepares for a scene that is written to `out`.
    ///
    /// Errors: non-empty data folders, unless existing files may be replaced.
    pub(crate) fn new(
        desc: &SceneDesc,
        out: &Path,
        options: &'a ConvertOptions,
    ) -> Result<Files<'a>, SceneError> {
        let beside = out.parent().map(Path::to_owned).unwrap_or_default();
        let name = out.file_stem().unwrap_or_default().to_string_lossy();
        let stem = Some(safe(&name)).filter(|s| !s.is_empty()).unwrap_or_else(|| "scene".to_owned());
        for (_, end) in FOLDERS {
            let folder = beside.join(format!("{stem}-{end}"));
            match folder.symlink_metadata() {
                Err(_) => {}
                Ok(meta) if !meta.is_dir() => {
                    return Err(exists(&folder, "exists and is not a folder").help("choose another name"));
                }
                Ok(_) if options.overwrite => {}
                Ok(_) => {
                    if fs::read_dir(&folder).is_ok_and(|mut entries| entries.next().is_some()) {
                        return Err(exists(&folder, "the folder exists and contains files"));
                    }
                }
            }
        }
        let mut uses = vec![0; desc.meshes.len()];
        let in_groups = desc.groups.iter().flat_map(|g| &g.value.objects);
        for object in desc.objects.iter().chain(in_groups) {
            let mesh = match &object.content {
                ObjectContent::Shape(ShapeDesc::Mesh(mesh)) => mesh.mesh,
                ObjectContent::Shape(ShapeDesc::Points(points)) => points.points,
                ObjectContent::Shape(ShapeDesc::Curves(curves)) => curves.curves,
                _ => continue,
            };
            if let Some(count) = uses.get_mut(mesh.index()) {
                *count += 1;
            }
        }
        Ok(Files {
            options,
            beside,
            stem,
            taken: Default::default(),
            made: Vec::new(),
            written: Vec::new(),
            warnings: Vec::new(),
            images: BTreeMap::new(),
            meshes: BTreeMap::new(),
            profiles: Vec::new(),
            measured: Vec::new(),
            grids: Vec::new(),
            fonts: Vec::new(),
            uses,
        })
    }

    /// The files written, with the scene itself.
    pub(crate) fn finish(mut self, main: WrittenFile) -> Converted {
        self.written.push(main);
        Converted { files: self.written, warnings: self.warnings }
    }

    /// Removes the files and folders written so far, unless existing files were replaced.
    pub(crate) fn remove(self) {
        if self.options.overwrite {
            return;
        }
        // A failure to remove is ignored; the original error is reported.
        self.written.iter().for_each(|file| drop(fs::remove_file(&file.path)));
        self.made.iter().for_each(|folder| drop(fs::remove_dir(folder)));
    }

    /// Writes a file into the folder of its kind; returns its name relative to the scene.
    fn file(
        &mut self,
        kind: Kind,
        (wanted, extension): (&str, &str),
        write: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
    ) -> Result<String, SceneError> {
        let (index, end) = match kind {
            Kind::Mesh => (0, "mesh"),
            Kind::Picture => (1, "picture"),
            Kind::Data => (2, "data"),
        };
        let folder_name = format!("{}-{}", self.stem, FOLDERS[index].1);
        let folder = self.beside.join(&folder_name);
        match fs::create_dir(&folder) {
            Ok(()) => self.made.push(folder.clone()),
            Err(e) if e.kind() == std::io::ErrorKind::AlreadyExists => {}
            Err(e) => {
                let name = crate::assets::printable(&folder.to_string_lossy());
                let message = format!("{name}: the folder cannot be created: {e}");
                return Err(SceneError::new(ErrorCode::Output, message).help("choose another path"));
            }
        }
        let name = self.taken[index].name(wanted, end, extension);
        let path = folder.join(&name);
        let file = create(&path, self.options.overwrite)?;
        file.commit_with(write).map_err(output_error)?;
        let bytes = fs::metadata(&path).map_or(0, |m| m.len());
        self.written.push(WrittenFile { path, bytes });
        Ok(format!("{folder_name}/{name}"))
    }

    fn warn(&mut self, kind: WarningKind, message: String) {
        self.warnings.push(Warning::new(kind, message));
    }
}

/// Whether a mesh can be written inline, with the same bits when it is read again: text has neither -0 nor NaN.
fn is_readable(mesh: &MeshData) -> bool {
    let plain = mesh.more_uvs.len() <= 1 && mesh.more_uvs.iter().all(|set| !set.is_empty());
    let is_cloud = mesh.triangles.is_empty();
    // Inline points have only positions and colours.
    let fits =
        !is_cloud || mesh.normals.len() + mesh.uvs.len() + mesh.more_uvs.len() + mesh.tangents.len() == 0;
    let lists = [
        mesh.positions.as_flattened(),
        mesh.normals.as_flattened(),
        mesh.uvs.as_flattened(),
        mesh.tangents.as_flattened(),
        mesh.colors.as_flattened(),
    ];
    let mut numbers = lists.into_iter().chain(mesh.more_uvs.iter().map(|set| set.as_flattened())).flatten();
    mesh.positions.len() <= FEW
        && mesh.triangles.len() <= FEW
        && plain
        && fits
        && mesh.material_names.is_empty()
        && mesh.fans().is_some()
        && numbers.all(|v| v.is_finite() && v.to_bits() != (-0.0_f32).to_bits())
}

impl SceneAssetWriter for Files<'_> {
    fn image(&mut self, id: ImageId, asset: &Asset<Image>) -> Result<String, SceneError> {
        if let Some(name) = self.images.get(&id.0) {
            return Ok(name.clone());
        }
        let wanted = stem(&asset.uri);
        let kept = self.options.pictures.find(&asset.data);
        let kept = kept.and_then(|(name, bytes)| Some((ImageFormat::of_bytes(&bytes, &name).ok()?, bytes)));
        let name = match kept {
            Some((format, bytes)) => {
                let extension = format.extensions().first().copied().unwrap_or("png");
                self.file(Kind::Picture, (wanted, extension), |out| out.write_all(&bytes))?
            }
            None => {
                let floats = matches!(asset.data.pixels, Pixels::F32(_));
                let encoded =
                    if floats { exr::encode_samples(&asset.data) } else { png::encode_samples(&asset.data) };
                let bytes = encoded.map_err(|e| crate::scene::two_lines(ErrorCode::Image, &e.to_string()))?;
                if floats && asset.data.channels.is_multiple_of(2) {
                    let message = "floating-point images with alpha: written with premultiplied alpha, as OpenEXR requires; colours may differ in the last bit";
                    self.warn(WarningKind::Approximated, message.into());
                }
                let extension = if floats { "exr" } else { "png" };
                self.file(Kind::Picture, (wanted, extension), |out| out.write_all(&bytes))?
            }
        };
        self.images.insert(id.0, name.clone());
        Ok(name)
    }

    fn mesh(&mut self, id: MeshId, asset: &Asset<MeshData>) -> Result<Option<String>, SceneError> {
        if let Some(name) = self.meshes.get(&id.0) {
            return Ok(name.clone());
        }
        let used_once = self.uses.get(id.index()).is_some_and(|count| *count == 1);
        let is_curves = !(asset.data.strands.is_empty() && asset.data.widths.is_empty());
        let name = if used_once && is_readable(&asset.data) || is_curves && !hair::can_write(&asset.data) {
            None
        } else if is_curves {
            asset.data.check()?;
            let wanted = stem(&asset.uri);
            Some(self.file(Kind::Mesh, (wanted, "hair"), |out| hair::write(&asset.data, out))?)
        } else {
            asset.data.check()?;
            let wanted = stem(&asset.uri);
            Some(self.file(Kind::Mesh, (wanted, "ply"), |out| ply::write(&asset.data, out))?)
        };
        self.meshes.insert(id.0, name.clone());
        Ok(name)
    }

    fn light_profile(&mut self, profile: &ProfileFile) -> Result<String, SceneError> {
        let known = self.profiles.iter().find(|(p, _)| Arc::ptr_eq(&p.data, &profile.data));
        if let Some((_, name)) = known {
            return Ok(name.clone());
        }
        let wanted = stem(&profile.uri);
        let name = self.file(Kind::Data, (wanted, "ies"), |out| crate::ies::write(&profile.data, out))?;
        self.profiles.push((profile.clone(), name.clone()));
        Ok(name)
    }

    fn measured_brdf(&mut self, measured: &MeasuredFile) -> Result<String, SceneError> {
        let known = self.measured.iter().find(|(m, _)| Arc::ptr_eq(&m.data, &measured.data));
        if let Some((_, name)) = known {
            return Ok(name.clone());
        }
        let wanted = stem(&measured.uri);
        let name =
            self.file(Kind::Data, (wanted, "bsdf"), |out| crate::measured::write(&measured.data, out))?;
        self.measured.push((measured.clone(), name.clone()));
        Ok(name)
    }

    fn grid(&mut self, grid: &GridFile) -> Result<String, SceneError> {
        let known = self.grids.iter().find(|(g, _)| Arc::ptr_eq(&g.data, &grid.data));
        if let Some((_, name)) = known {
            return Ok(name.clone());
        }
        let wanted = stem(crate::grid::split_name(&grid.uri).0);
        let name = self.file(Kind::Data, (wanted, "grid"), |out| crate::grid::write(&grid.data, out))?;
        self.grids.push((grid.clone(), name.clone()));
        Ok(name)
    }

    fn font(&mut self, font: &FontFile) -> Result<String, SceneError> {
        let known = self.fonts.iter().find(|(f, _)| f == font);
        if let Some((_, name)) = known {
            return Ok(name.clone());
        }
        let bytes = font.font.bytes();
        if bytes.is_empty() {
            // A text that has no font yet names none.
            return Ok(font.uri.clone());
        }
        let wanted = stem(&font.uri);
        let name =
            self.file(Kind::Data, (wanted, crate::font::extension(bytes)), |out| out.write_all(bytes))?;
        self.fonts.push((font.clone(), name.clone()));
        Ok(name)
    }
}
