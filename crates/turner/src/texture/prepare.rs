//! From descriptions to textures that can be evaluated without end or surprise: every reference exists, none
//! leads back to itself, none nests too deep or costs too much.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::decoder::Decoder;
use super::mipmap::Mipmap;
use super::{Encoding, Mapping, TextureDesc, Textures};
use crate::color::Transfer;
use crate::image::Image;
use crate::schema::error::escape;
use crate::schema::{Asset, ColorSource, ErrorCode, ImageId, Named, SceneError, TextureId, Transform};

/// How many textures may stand one inside the other; bounds the recursion of evaluation.
pub(super) const MAX_DEPTH: u32 = 64;

/// How many textures one lookup may evaluate: a dozen textures that each mix two of the next would take
/// thousands, sixty of them forever.
pub(super) const MAX_LOOKUPS: u64 = 4096;

/// What every texture description can do.
pub(super) trait Kind {
    /// What it becomes.
    type Ready;
    /// How many of its colours one lookup may need.
    const AT_ONCE: u64;
    /// Its colours that may be textures.
    fn sources(&self, visit: &mut dyn FnMut(ColorSource));
    /// Where it looks itself up.
    fn mapping(&self) -> Mapping;
    /// The exponent of mixing and the transform of one that is looked up along three axes.
    fn triplanar(&self) -> Option<(f64, Transform)> {
        None
    }
    /// Makes it ready.
    fn prepare(&self, cx: &mut Preparing<'_>) -> Result<Self::Ready, SceneError>;
}

/// What preparing one texture may need.
pub(super) struct Preparing<'a> {
    /// The film's transfer curve.
    pub(super) transfer: Transfer,
    images: &'a [Asset<Image>],
    used: Vec<bool>,
    decoders: [Decoder; 3],
    /// Whether look-ups have footprints.
    filtered: bool,
    /// By picture and by whether it is decoded by a curve.
    mipmaps: BTreeMap<(u32, bool), Arc<Mipmap>>,
    kept: &'a CachedMipmaps,
}

/// Pyramids of pictures as they were made, by the pictures: what a later preparation need not make again.
#[derive(Debug, Default)]
pub struct CachedMipmaps {
    /// By the address of the picture, which is held, and whether it is decoded by a curve.
    mipmaps: BTreeMap<(usize, bool), (Arc<Image>, Arc<Mipmap>)>,
}

impl Preparing<'_> {
    /// A picture, checked, whose samples will be taken as `encoding` says.
    pub(super) fn image(&mut self, id: ImageId, encoding: Encoding) -> Result<Arc<Image>, SceneError> {
        let asset = self.images.get(id.index()).ok_or_else(|| dangling("a picture"))?;
        if !asset.data.is_consistent() {
            let message = format!("the samples of {} do not fit its size", escape(&asset.uri));
            return Err(SceneError::new(ErrorCode::Image, message));
        }
        self.used[id.index()] = true;
        self.decoders[encoding as usize].include(&asset.data, encoding.transfer(self.transfer));
        Ok(asset.data.clone())
    }

    /// The smaller sizes of a picture, made once, if anything will look at them.
    pub(super) fn mipmap(&mut self, id: ImageId, image: &Image, encoding: Encoding) -> Option<Arc<Mipmap>> {
        let transfer = encoding.transfer(self.transfer);
        let data = self.images.get(id.index()).map_or(0, |asset| Arc::as_ptr(&asset.data) as usize);
        let known = self.kept.mipmaps.get(&(data, transfer != Transfer::None));
        let made = || known.map_or_else(|| Arc::new(Mipmap::new(image, transfer)), |(_, p)| p.clone());
        let key = (id.0, transfer != Transfer::None);
        self.filtered.then(|| self.mipmaps.entry(key).or_insert_with(made).clone())
    }
}

fn dangling(what: &str) -> SceneError {
    SceneError::new(ErrorCode::Internal, format!("a texture refers to {what} that the scene does not have"))
}

impl Textures {
    /// Makes the textures of a scene ready. `images` are the scene's, by [`ImageId`]; `transfer` is the film's. Where look-ups
    /// will have footprints (`filtered`) pictures get pyramids of smaller sizes.
    ///
    /// Refuses textures that contain themselves or nest deeper than 64 ([`ErrorCode::Cycle`]) and textures that
    /// mix so many others that one lookup would take more than 4096 ([`ErrorCode::TooLarge`]).
    pub fn prepare(
        descs: &[Named<TextureDesc>],
        images: &[Asset<Image>],
        transfer: Transfer,
        filtered: bool,
    ) -> Result<Textures, SceneError> {
        Textures::prepare_with(descs, images, transfer, filtered, &mut CachedMipmaps::default())
    }

    /// The same, where pyramids of the same pictures are taken from `kept`, which then has those of these textures.
    pub fn prepare_with(
        descs: &[Named<TextureDesc>],
        images: &[Asset<Image>],
        transfer: Transfer,
        filtered: bool,
        kept: &mut CachedMipmaps,
    ) -> Result<Textures, SceneError> {
        let uv = check_references(descs)?;
        let decoders =
            [Encoding::Auto, Encoding::Srgb, Encoding::Linear].map(|e| Decoder::new(e.transfer(transfer)));
        let used = vec![false; images.len()];
        let mipmaps = BTreeMap::new();
        let mut cx = Preparing { transfer, images, used, decoders, filtered, mipmaps, kept };
        let mut list = Vec::with_capacity(descs.len());
        for desc in descs {
            list.push(desc.value.prepare(&mut cx).map_err(|e| e.or_at(desc.span))?);
        }
        let used = images.iter().zip(&cx.used).filter(|(_, used)| **used);
        let pictures: usize = used.map(|(image, _)| image.data.memory()).sum();
        let mipmaps: usize = cx.mipmaps.values().map(|p| p.memory()).sum();
        let image_memory = pictures + mipmaps;
        let decoders = cx.decoders;
        let of_image = |((id, curved), mipmap): (&(u32, bool), &Arc<Mipmap>)| {
            let image = images.get(*id as usize)?.data.clone();
            Some(((Arc::as_ptr(&image) as usize, *curved), (image, mipmap.clone())))
        };
        kept.mipmaps = cx.mipmaps.iter().filter_map(of_image).collect();
        Ok(Textures { list, uv, decoders, image_memory })
    }
}

/// What is known of a texture once all it refers to is known.
#[derive(Clone, Copy)]
struct Known {
    depth: u32,
    lookups: u64,
    uv: bool,
}

/// Depth first, with a stack of our own: scenes may chain any number of named textures. Says for each texture
/// whether it needs (u, v).
fn check_references(descs: &[Named<TextureDesc>]) -> Result<Vec<bool>, SceneError> {
    let mut known: Vec<Option<Known>> = vec![None; descs.len()];
    let mut entered = vec![false; descs.len()];
    let mut path: Vec<(usize, Vec<usize>)> = Vec::new();
    for root in 0..descs.len() {
        if known[root].is_some() {
            continue;
        }
        entered[root] = true;
        path.push((root, children(descs, root)?));
        while let Some((node, ahead)) = path.last_mut() {
            let node = *node;
            if let Some(child) = ahead.pop() {
                if known[child].is_some() {
                    continue;
                }
                if entered[child] {
                    let first = path.iter().position(|(n, _)| *n == child).expect("entered, not left");
                    let mut cycle: Vec<usize> = path[first..].iter().map(|(n, _)| *n).collect();
                    cycle.push(child);
                    let message = format!("a texture contains itself: {}", chain(descs, &cycle));
                    return Err(SceneError::new(ErrorCode::Cycle, message).or_at(descs[child].span));
                }
                entered[child] = true;
                path.push((child, children(descs, child)?));
                continue;
            }
            known[node] = Some(summarise(descs, node, &known)?);
            path.pop();
        }
    }
    Ok(known.into_iter().map(|k| k.is_some_and(|k| k.uv)).collect())
}

/// The textures that a texture names, the first on top of the stack.
fn children(descs: &[Named<TextureDesc>], node: usize) -> Result<Vec<usize>, SceneError> {
    let mut list = Vec::new();
    descs[node].value.sources(&mut |source| {
        if let ColorSource::Texture(TextureId(id)) = source {
            list.push(id as usize);
        }
    });
    list.reverse();
    if list.iter().any(|child| *child >= descs.len()) {
        return Err(dangling("a texture").or_at(descs[node].span));
    }
    Ok(list)
}

fn summarise(
    descs: &[Named<TextureDesc>],
    node: usize,
    known: &[Option<Known>],
) -> Result<Known, SceneError> {
    let desc = &descs[node];
    let mut named = children(descs, node)?;
    named.sort_unstable();
    // A texture that is mixed with itself is looked up once.
    named.dedup();
    let inner: Vec<Known> = named.into_iter().filter_map(|c| known[c]).collect();
    let costliest = inner.iter().map(|k| k.lookups).max().unwrap_or(0);
    let sides = if desc.value.triplanar().is_some() { 3 } else { 1 };
    let at_once = sides * desc.value.at_once().min(inner.len() as u64);
    let depth = 1 + inner.iter().map(|k| k.depth).max().unwrap_or(0);
    let lookups = costliest.saturating_mul(at_once).saturating_add(1);
    if depth > MAX_DEPTH {
        let message =
            format!("textures nest deeper than {MAX_DEPTH}: {}", chain(descs, &deepest(descs, node)));
        return Err(SceneError::new(ErrorCode::Cycle, message).or_at(desc.span));
    }
    if lookups > MAX_LOOKUPS {
        let message =
            format!("the texture {} mixes more than {MAX_LOOKUPS} textures at a point", label(descs, node));
        return Err(SceneError::new(ErrorCode::TooLarge, message)
            .or_at(desc.span)
            .help("use plain colours in some of the textures that it is made of"));
    }
    Ok(Known { depth, lookups, uv: desc.value.uses_uv() || inner.iter().any(|k| k.uv) })
}

/// Some way down from a texture that nests too deep: its first references, which is what a reader follows.
fn deepest(descs: &[Named<TextureDesc>], node: usize) -> Vec<usize> {
    let mut way = vec![node];
    while let Ok(inner) = children(descs, way[way.len() - 1])
        && let Some(first) = inner.last()
    {
        way.push(*first);
    }
    way
}

/// `a -> b -> a`; long ones shortened.
fn chain(descs: &[Named<TextureDesc>], nodes: &[usize]) -> String {
    const SHOWN: usize = 12;
    let mut labels: Vec<String> = nodes.iter().map(|n| label(descs, *n)).collect();
    if labels.len() > SHOWN {
        let hidden = labels.len() - SHOWN;
        labels.splice(SHOWN / 2..SHOWN / 2 + hidden, [format!("({hidden} more)")]);
    }
    labels.join(" -> ")
}

/// The name, or the type of a texture written in place.
fn label(descs: &[Named<TextureDesc>], node: usize) -> String {
    match &descs[node].name {
        Some(name) => escape(name),
        None => format!("{{ {} }}", descs[node].value.type_name()),
    }
}
