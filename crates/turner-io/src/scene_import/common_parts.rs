//! The scene under construction: the lists that every importer fills, and the files that a scene names.

use std::collections::BTreeMap;
use std::sync::Arc;

use turner::description::{GroupDesc, ObjectContent, ObjectDesc, SceneLight};
use turner::image::Image;
use turner::math::{DAffine3, DMat3};
use turner::schema::{
    Asset, ColorSource, ErrorCode, GroupId, ImageId, MaterialId, MeasuredFile, MeshData, MeshId, Named,
    TextureId, Transform,
};
use turner::texture::TextureDesc;

use super::report::{Fault, Place, Report};
use super::scene_files::{FilesAhead, LoadedFile, LoadedImage, SceneFile};
use crate::assets::{AssetError, AssetSource, printable};
use crate::image::{DecodeLimits, decode};
use crate::import::ImportOptions;

/// Largest image file, bytes.
const MAX_PICTURE: u64 = 1 << 30;
/// Most bytes of all decoded images.
const MAX_DECODED: u64 = 16 << 30;
/// Most objects: the renderer's limit.
const MAX_OBJECTS: usize = 1 << 24;

/// Appends to a list of at most `limit` elements; the error is the problem in words.
pub(crate) fn push<T>(list: &mut Vec<T>, value: T, limit: usize) -> Result<(), &'static str> {
    if list.len() == list.capacity() {
        if list.len() >= limit {
            return Err("the list exceeds the limit for a file");
        }
        let more = list.len().clamp(4, limit.max(4));
        list.try_reserve(more).map_err(|_| "not enough memory for the list")?;
    }
    list.push(value);
    Ok(())
}

/// The scene under construction.
pub(crate) struct CommonParts<'a> {
    pub(crate) assets: &'a dyn AssetSource,
    /// The scene file; names in it are relative to its folder.
    pub(crate) uri: String,
    pub(crate) options: &'a ImportOptions,
    /// Names of the files read. A [`Place`] refers to them by index.
    pub(crate) files: Vec<String>,
    pub(crate) report: Report,
    pub(crate) texture_list: Vec<Named<TextureDesc>>,
    pub(crate) medium_list: Vec<Named<turner::medium::MediumDesc>>,
    pub(crate) images: Vec<Asset<Image>>,
    pub(crate) image_ids: BTreeMap<String, Option<ImageId>>,
    pub(crate) meshes: Vec<Asset<MeshData>>,
    /// Meshes of files, by path and orientation.
    pub(crate) mesh_ids: BTreeMap<(String, bool), Option<MeshId>>,
    pub(crate) groups: Vec<Named<GroupDesc>>,
    pub(crate) objects: Vec<ObjectDesc>,
    pub(crate) lights: Vec<SceneLight>,
    /// Textures whose values were mapped by a function, by texture and function.
    pub(crate) mapped: BTreeMap<(TextureId, String), ColorSource>,
    /// Measured BRDFs by path; `None` for damaged ones.
    pub(crate) measured: BTreeMap<String, Option<MeasuredFile>>,
    /// Files that other threads read.
    pub(crate) ahead: Option<&'a FilesAhead<'a>>,
    decoded: u64,
    /// Bytes of images that may still be derived from others.
    copies: u64,
    /// Vertices that subdivided, swept and tessellated shapes may still take: a few bytes of a file must not
    /// make unbounded geometry.
    made: u64,
    pub(crate) shapes: u64,
}

impl<'a> CommonParts<'a> {
    pub(crate) fn new(assets: &'a dyn AssetSource, uri: &str, options: &'a ImportOptions) -> CommonParts<'a> {
        CommonParts {
            assets,
            uri: uri.to_owned(),
            options,
            files: Vec::new(),
            report: Report::default(),
            texture_list: Vec::new(),
            medium_list: Vec::new(),
            images: Vec::new(),
            image_ids: BTreeMap::new(),
            meshes: Vec::new(),
            mesh_ids: BTreeMap::new(),
            groups: Vec::new(),
            objects: Vec::new(),
            lights: Vec::new(),
            mapped: BTreeMap::new(),
            measured: BTreeMap::new(),
            ahead: None,
            decoded: 0,
            copies: 64 << 20,
            made: 1 << 21,
            shapes: 0,
        }
    }

    /// Takes `vertices` from the budget of subdivided shapes. Each call adds 256 to it, so that many small
    /// shapes fit.
    pub(crate) fn divide(&mut self, vertices: u64, place: Place) -> Result<(), Fault> {
        self.made = self.made.saturating_add(256);
        match self.made.checked_sub(vertices) {
            Some(left) => {
                self.made = left;
                Ok(())
            }
            None => {
                let message = format!("{vertices} vertices exceed the limit for subdivided surfaces");
                Err(Fault::at(place, ErrorCode::TooLarge, message).help("use fewer subdivisions"))
            }
        }
    }

    /// Adds an object with its transforms at the start and the end of the motion.
    pub(crate) fn place_at(
        &mut self,
        content: ObjectContent,
        material: Option<MaterialId>,
        [start, end]: [DAffine3; 2],
        place: Place,
    ) -> Result<(), Fault> {
        if !(is_sound(&start) && is_sound(&end)) {
            self.report.doubtful(place, "a shape whose transform is not invertible: omitted");
            return Ok(());
        }
        let object = ObjectDesc {
            name: None,
            span: None,
            content,
            material,
            light_group: None,
            shadow_catcher: false,
            hidden_from_camera: false,
            hidden: false,
            transform: Transform(start),
            motion: (start != end).then_some(Transform(end)),
        };
        push(&mut self.objects, object, MAX_OBJECTS).map_err(|p| Fault::at(place, ErrorCode::TooLarge, p))
    }

    /// Moves the objects from index `first` on into a group.
    pub(crate) fn group(&mut self, name: &str, first: usize, place: Place) -> Result<GroupId, Fault> {
        let objects = self.objects.split_off(first.min(self.objects.len()));
        let group =
            Named { name: Some(name.to_owned()), span: None, value: GroupDesc { objects, model: None } };
        push(&mut self.groups, group, MAX_OBJECTS).map_err(|p| Fault::at(place, ErrorCode::TooLarge, p))?;
        Ok(GroupId(self.groups.len() as u32 - 1))
    }

    /// Adds a mesh.
    pub(crate) fn mesh(&mut self, uri: String, data: MeshData) -> MeshId {
        self.meshes.push(Asset { uri, data: Arc::new(data) });
        MeshId(self.meshes.len() as u32 - 1)
    }

    /// Adds a texture, or finds an equal one.
    pub(crate) fn texture(&mut self, desc: TextureDesc) -> ColorSource {
        // Equal textures often follow one another: the last 16 are compared.
        let recent = self.texture_list.iter().enumerate().rev().take(16);
        let known = recent.filter(|(_, t)| t.value == desc).map(|(i, _)| i).next();
        let index = known.unwrap_or_else(|| {
            self.texture_list.push(Named { name: None, span: None, value: desc });
            self.texture_list.len() - 1
        });
        ColorSource::Texture(TextureId(index as u32))
    }

    /// The description of a source that is a texture.
    pub(crate) fn texture_desc(&self, source: ColorSource) -> Option<&TextureDesc> {
        match source {
            ColorSource::Texture(id) => self.texture_list.get(id.index()).map(|t| &t.value),
            ColorSource::Constant(_) => None,
        }
    }

    /// Reads a file that the scene names; returns its path and bytes. Names are relative to the scene's folder.
    pub(crate) fn read(&self, name: &str, limit: u64, place: Place) -> Result<(String, Vec<u8>), Fault> {
        let fault = |e: AssetError| Fault::from_scene(place, e.to_scene_error());
        let path = self.assets.resolve(&self.uri, name).map_err(fault)?;
        let bytes = self.assets.read(&path, limit).map_err(fault)?;
        Ok((path, bytes))
    }

    /// An image, read and decoded once; `None` if that fails, which is reported.
    pub(crate) fn image(&mut self, name: &str, place: Place) -> Option<ImageId> {
        if let Some(known) = self.image_ids.get(name) {
            return *known;
        }
        let id = match self.load_image(name) {
            Ok(LoadedImage { image, path, bytes, .. }) => {
                self.copies = self.copies.saturating_add(4 * image.memory() as u64);
                let id = self.add_image(name, image);
                if let (Some(kept), Some(added)) = (self.options.keeps_pictures(), self.images.last()) {
                    kept.keep(&added.data, &path, bytes);
                }
                Some(id)
            }
            Err(problem) => {
                self.report.ignored(place, format!("the image {problem}; omitted"));
                None
            }
        };
        self.image_ids.insert(name.to_owned(), id);
        id
    }

    fn load_image(&self, name: &str) -> Result<LoadedImage, String> {
        // Where the limit for all images is near, the image is read under what is left of it.
        let is_scarce = self.decoded > MAX_DECODED / 2;
        match self.read_ahead(&SceneFile::Picture(name.to_owned())).filter(|_| !is_scarce) {
            Some(LoadedFile::Image(loaded)) => Ok(*loaded),
            _ => load_image(self.assets, &self.uri, name, self.options, self.decoded, false),
        }
    }

    /// A file that another thread has read.
    pub(crate) fn read_ahead(&self, file: &SceneFile) -> Option<LoadedFile> {
        let mut loaded = self.ahead?.take(file)?;
        if let Some(mark) = loaded.mark() {
            self.assets.used(mark);
        }
        Some(loaded)
    }

    /// Takes `bytes` from the budget of derived images, which is a few times the size of those in files. False
    /// if it is spent.
    pub(crate) fn may_copy(&mut self, bytes: u64) -> bool {
        let left = self.copies.checked_sub(bytes);
        self.copies = left.unwrap_or(self.copies);
        left.is_some()
    }

    /// Factor for the resolution of an environment map that is resampled. A map with fewer than 256 rows gets
    /// at least that many, so that resampling loses little.
    pub(crate) fn finer(&mut self, rows: u32) -> u32 {
        const FINE: u32 = 256;
        let finer = FINE.div_ceil(rows.max(1)).min(FINE);
        let bytes = 24 * u64::from(FINE) * u64::from(FINE);
        if finer > 1 && self.may_copy(bytes) { finer } else { 1 }
    }

    /// Adds a computed image.
    pub(crate) fn add_image(&mut self, name: &str, image: Image) -> ImageId {
        self.decoded = self.decoded.saturating_add(image.memory() as u64);
        self.images.push(Asset { uri: printable(name), data: Arc::new(image) });
        ImageId(self.images.len() as u32 - 1)
    }
}

/// Reads and decodes an image that a scene names; `decoded` are the bytes of the images that it has already. The error is
/// the problem in words.
pub(crate) fn load_image(
    assets: &dyn AssetSource,
    uri: &str,
    name: &str,
    options: &ImportOptions,
    decoded: u64,
    ahead: bool,
) -> Result<LoadedImage, String> {
    let first = |text: String| text.lines().next().unwrap_or_default().to_owned();
    let resolve = |e: AssetError| first(e.to_string());
    let path = assets.resolve(uri, name).map_err(resolve)?;
    let (bytes, mark) = read_file(assets, &path, MAX_PICTURE, ahead).map_err(resolve)?;
    let mut limits = DecodeLimits::of_scene(&options.limits, options.max_texture_size, 1);
    limits.max_bytes = limits.max_bytes.min(MAX_DECODED.saturating_sub(decoded));
    let image = decode(&bytes, &path, &limits).map_err(|e| first(e.to_string()))?;
    let image = match options.max_texture_size {
        Some(max) => crate::image::to_fit(image, max, crate::image::ColorOrData::Color, &path)
            .map_err(|e| first(e.to_string()))?,
        None => image,
    };
    Ok(LoadedImage { image, path, bytes, mark })
}

/// Reads a file, with its mark if it is read ahead.
pub(crate) fn read_file(
    assets: &dyn AssetSource,
    path: &str,
    limit: u64,
    ahead: bool,
) -> Result<(Vec<u8>, Option<String>), AssetError> {
    if ahead {
        let (bytes, mark) = assets.read_ahead(path, limit)?;
        return Ok((bytes, Some(mark)));
    }
    Ok((assets.read(path, limit)?, None))
}

/// Whether a transform is invertible, as scenes require.
pub(crate) fn is_sound(m: &DAffine3) -> bool {
    let inverse = m.inverse();
    let round_trip = (m.matrix3 * inverse.matrix3 - DMat3::IDENTITY).to_cols_array();
    m.is_finite() && inverse.is_finite() && round_trip.iter().all(|v| v.abs() < 1e-6)
}
