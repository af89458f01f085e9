//! A scene in the making: lists that importers add to, and files that the scene names.

use std::collections::BTreeMap;
use std::sync::Arc;

use turner::description::{GroupDesc, ObjectContent, ObjectDesc, SceneLight};
use turner::image::Image;
use turner::math::{DAffine3, DMat3};
use turner::schema::{
    Asset, ColorSource, ErrorCode, GroupId, ImageId, MaterialId, MeshData, MeshId, Named, TextureId,
    Transform,
};
use turner::texture::TextureDesc;

use super::report::{Fault, Place, Report};
use crate::assets::{AssetSource, printable};
use crate::image::{DecodeLimits, decode};
use crate::import::ImportOptions;

/// Most bytes of a picture in its file.
const MAX_PICTURE: u64 = 1 << 30;
/// Most bytes of all pictures, decoded.
const MAX_DECODED: u64 = 16 << 30;
/// Most objects, that of the renderer.
const MAX_OBJECTS: usize = 1 << 24;

/// Adds to a list of at most `limit` elements; an error in words where there is no memory.
pub(crate) fn push<T>(list: &mut Vec<T>, value: T, limit: usize) -> Result<(), &'static str> {
    if list.len() == list.capacity() {
        if list.len() >= limit {
            return Err("the list is longer than the limit of a file");
        }
        let more = list.len().clamp(4, limit.max(4));
        list.try_reserve(more).map_err(|_| "not enough memory for the list")?;
    }
    list.push(value);
    Ok(())
}

/// The scene in the making.
pub(crate) struct CommonParts<'a> {
    pub(crate) assets: &'a dyn AssetSource,
    /// The scene file; names in it are relative to its folder.
    pub(crate) uri: String,
    pub(crate) options: &'a ImportOptions,
    /// Names of the files read, for places.
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
    /// Textures whose values went through a function, by texture and function.
    pub(crate) mapped: BTreeMap<(TextureId, String), ColorSource>,
    decoded: u64,
    /// Bytes of pictures that may still be copied.
    copies: u64,
    /// Elements that may still be made from few bytes: of subdivided, swept and divided surfaces.
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
            decoded: 0,
            copies: 64 << 20,
            made: 1 << 21,
            shapes: 0,
        }
    }

    /// Takes room for so many vertices that a surface is divided into. Each shape in the file is worth some.
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

    /// Adds an object at a transform.
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
            transform: Transform(start),
            motion: (start != end).then_some(Transform(end)),
        };
        push(&mut self.objects, object, MAX_OBJECTS).map_err(|p| Fault::at(place, ErrorCode::TooLarge, p))
    }

    /// The objects from `first` on as a group.
    pub(crate) fn group(&mut self, name: &str, first: usize, place: Place) -> Result<GroupId, Fault> {
        let objects = self.objects.split_off(first.min(self.objects.len()));
        let group = Named { name: Some(name.to_owned()), span: None, value: GroupDesc { objects } };
        push(&mut self.groups, group, MAX_OBJECTS).map_err(|p| Fault::at(place, ErrorCode::TooLarge, p))?;
        Ok(GroupId(self.groups.len() as u32 - 1))
    }

    /// Adds a mesh.
    pub(crate) fn mesh(&mut self, uri: String, data: MeshData) -> MeshId {
        self.meshes.push(Asset { uri, data: Arc::new(data) });
        MeshId(self.meshes.len() as u32 - 1)
    }

    /// One more texture; equal ones are shared.
    pub(crate) fn texture(&mut self, desc: TextureDesc) -> ColorSource {
        // Those that follow one another are often equal.
        let recent = self.texture_list.iter().enumerate().rev().take(16);
        let known = recent.filter(|(_, t)| t.value == desc).map(|(i, _)| i).next();
        let index = known.unwrap_or_else(|| {
            self.texture_list.push(Named { name: None, span: None, value: desc });
            self.texture_list.len() - 1
        });
        ColorSource::Texture(TextureId(index as u32))
    }

    /// What a texture is made of, if a source is one.
    pub(crate) fn texture_desc(&self, source: ColorSource) -> Option<&TextureDesc> {
        match source {
            ColorSource::Texture(id) => self.texture_list.get(id.index()).map(|t| &t.value),
            ColorSource::Constant(_) => None,
        }
    }

    /// The bytes of a file that the scene names, and its path. Names are relative to the scene's folder.
    pub(crate) fn read(&self, name: &str, limit: u64, place: Place) -> Result<(String, Vec<u8>), Fault> {
        let fault = |e: crate::assets::AssetError| Fault::from_scene(place, e.to_scene_error());
        let path = self.assets.resolve(&self.uri, name).map_err(fault)?;
        let bytes = self.assets.read(&path, limit).map_err(fault)?;
        Ok((path, bytes))
    }

    /// A picture, read and decoded once; `None` if it cannot be, which is reported.
    pub(crate) fn image(&mut self, name: &str, place: Place) -> Option<ImageId> {
        if let Some(known) = self.image_ids.get(name) {
            return *known;
        }
        let id = match self.load_image(name) {
            Ok((image, path, bytes)) => {
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

    /// Whether so many bytes of pictures may be made of others: a few times what these have.
    pub(crate) fn may_copy(&mut self, bytes: u64) -> bool {
        let left = self.copies.checked_sub(bytes);
        self.copies = left.unwrap_or(self.copies);
        left.is_some()
    }

    /// How many times as many rows and columns a picture of the surroundings gets that is looked up again: small ones so many that
    /// little of them is lost between the new pixels.
    pub(crate) fn finer(&mut self, rows: u32) -> u32 {
        const FINE: u32 = 256;
        let finer = FINE.div_ceil(rows.max(1)).min(FINE);
        let bytes = 24 * u64::from(FINE) * u64::from(FINE);
        if finer > 1 && self.may_copy(bytes) { finer } else { 1 }
    }

    /// Adds a picture that was made.
    pub(crate) fn add_image(&mut self, name: &str, image: Image) -> ImageId {
        self.decoded = self.decoded.saturating_add(image.memory() as u64);
        self.images.push(Asset { uri: printable(name), data: Arc::new(image) });
        ImageId(self.images.len() as u32 - 1)
    }

    fn load_image(&self, name: &str) -> Result<(Image, String, Vec<u8>), String> {
        let first = |text: String| text.lines().next().unwrap_or_default().to_owned();
        let resolve = |e: crate::assets::AssetError| first(e.to_string());
        let path = self.assets.resolve(&self.uri, name).map_err(resolve)?;
        let bytes = self.assets.read(&path, MAX_PICTURE).map_err(resolve)?;
        let mut limits = DecodeLimits::of_scene(&self.options.limits, self.options.max_texture_size, 1);
        limits.max_bytes = limits.max_bytes.min(MAX_DECODED.saturating_sub(self.decoded));
        let image = decode(&bytes, &path, &limits).map_err(|e| first(e.to_string()))?;
        let image = match self.options.max_texture_size {
            Some(max) => crate::image::to_fit(image, max, crate::image::ColorOrData::Color, &path)
                .map_err(|e| first(e.to_string()))?,
            None => image,
        };
        Ok((image, path, bytes))
    }
}

/// Whether a transform can be undone, as scenes need it.
pub(crate) fn is_sound(m: &DAffine3) -> bool {
    let inverse = m.inverse();
    let round_trip = (m.matrix3 * inverse.matrix3 - DMat3::IDENTITY).to_cols_array();
    m.is_finite() && inverse.is_finite() && round_trip.iter().all(|v| v.abs() < 1e-6)
}
