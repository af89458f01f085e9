//! Preparation of textures, with checks that make evaluation safe: every reference exists, there are no cycles, and
//! depth and cost are bounded.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::decoder::Decoder;
use super::mipmap::Mipmap;
use super::{Encoding, Mapping, TextureDesc, Textures};
use crate::color::Transfer;
use crate::image::Image;
use crate::schema::error::escape;
use crate::schema::{Asset, ColorSource, ErrorCode, ImageId, Named, SceneError, TextureId, Transform};

/// How deep textures may nest; bounds the recursion of evaluation.
pub(super) const MAX_DEPTH: u32 = 64;

/// How many textures one lookup may evaluate. A dozen textures that each mix two of the next would need thousands of
/// evaluations; sixty would never end.
pub(super) const MAX_LOOKUPS: u64 = 4096;

/// What every texture description provides.
pub(super) trait Kind {
    /// The prepared form.
    type Prepared;
    /// The maximum number of its inputs that one lookup evaluates.
    const MAX_INPUTS: u64;
    /// Visits its inputs: colours that may be textures.
    fn sources(&self, visit: &mut dyn FnMut(ColorSource));
    /// The mapping it is evaluated with.
    fn mapping(&self) -> Mapping;
    /// Blend exponent and transform, if its mapping is triplanar.
    fn triplanar(&self) -> Option<(f64, Transform)> {
        None
    }
    /// Prepares it.
    fn prepare(&self, cx: &mut PrepareContext<'_>) -> Result<Self::Prepared, SceneError>;
}

/// The context for preparing a texture.
pub(super) struct PrepareContext<'a> {
    /// The film's transfer curve.
    pub(super) transfer: Transfer,
    images: &'a [Asset<Image>],
    used: Vec<bool>,
    decoders: [Decoder; 3],
    /// Whether lookups have footprints.
    filtered: bool,
    /// By image, and whether a curve decodes it.
    mipmaps: BTreeMap<(u32, bool), Arc<Mipmap>>,
    kept: &'a CachedMipmaps,
}

/// Prepared mipmaps by image, which the next preparation can reuse.
#[derive(Debug, Default)]
pub struct CachedMipmaps {
    /// Key: the address of the image (kept alive by the entry), and whether a curve decodes it.
    mipmaps: BTreeMap<(usize, bool), (Arc<Image>, Arc<Mipmap>)>,
}

impl PrepareContext<'_> {
    /// A checked image, whose samples will be decoded by `encoding`.
    pub(super) fn image(&mut self, id: ImageId, encoding: Encoding) -> Result<Arc<Image>, SceneError> {
        let asset = self.images.get(id.index()).ok_or_else(|| dangling("an image"))?;
        if !asset.data.is_consistent() {
            let message = format!("the samples of {} do not fit its size", escape(&asset.uri));
            return Err(SceneError::new(ErrorCode::Image, message));
        }
        self.used[id.index()] = true;
        self.decoders[encoding as usize].include(&asset.data, encoding.transfer(self.transfer));
        Ok(asset.data.clone())
    }

    /// The mipmap of an image, created once, if lookups are filtered.
    pub(super) fn mipmap(&mut self, id: ImageId, image: &Image, encoding: Encoding) -> Option<Arc<Mipmap>> {
        let transfer = encoding.transfer(self.transfer);
        let data = self.images.get(id.index()).map_or(0, |asset| Arc::as_ptr(&asset.data) as usize);
        let known = self.kept.mipmaps.get(&(data, transfer != Transfer::None));
        let made = || known.map_or_else(|| Arc::new(Mipmap::new(image, transfer)), |(_, p)| p.clone());
        let key = (id.0, transfer != Transfer::None);
        self.filtered.then(|| self.mipmaps.entry(key).or_insert_with(made).clone())
    }
}

impl PrepareContext<'_> {
    /// Creates the mipmaps of textures in parallel. Faults of the textures are found later.
    fn create_mipmaps(&mut self, descs: &[Named<TextureDesc>], threads: usize) {
        let mut wanted: BTreeMap<(u32, bool), (&Image, Transfer)> = BTreeMap::new();
        for desc in descs {
            let TextureDesc::Image(d) = &desc.value else { continue };
            let Some(asset) = self.images.get(d.file.index()).filter(|_| d.is_mipmapped()) else { continue };
            let transfer = d.encoding.transfer(self.transfer);
            let curved = transfer != Transfer::None;
            let known = self.kept.mipmaps.contains_key(&(Arc::as_ptr(&asset.data) as usize, curved));
            if !known && asset.data.is_consistent() {
                wanted.insert((d.file.0, curved), (&*asset.data, transfer));
            }
        }
        let mut wanted: Vec<_> = wanted.into_iter().collect();
        // The largest first, so that no thread starts it when the others have finished.
        wanted.sort_by_key(|(_, (image, _))| std::cmp::Reverse(image.memory()));
        let all = || turner_host::thread::available();
        let threads = if threads == 0 { all() } else { threads }.min(wanted.len());
        let next = AtomicUsize::new(0);
        let work = || {
            let mut made = Vec::new();
            while let Some((key, (image, transfer))) = wanted.get(next.fetch_add(1, Ordering::Relaxed)) {
                made.push((*key, Arc::new(Mipmap::new(image, *transfer))));
            }
            made
        };
        let made = turner_host::thread::scope(|scope| {
            let helpers: Vec<_> = (1..threads).map(|_| scope.spawn(work)).collect();
            let mut made = work();
            for helper in helpers {
                made.extend(helper.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
            }
            made
        });
        self.mipmaps.extend(made);
    }
}

fn dangling(what: &str) -> SceneError {
    SceneError::new(ErrorCode::Internal, format!("a texture refers to {what} that the scene does not have"))
}

impl Textures {
    /// Prepares the textures of a scene. `images` are the scene's, by [`ImageId`]; `transfer` is the film's. If
    /// lookups have footprints (`filtered`), images get mipmaps.
    ///
    /// Errors: textures that contain themselves or nest deeper than 64 ([`ErrorCode::Cycle`]); textures of which one
    /// lookup would evaluate more than 4096 ([`ErrorCode::TooLarge`]).
    pub fn prepare(
        descs: &[Named<TextureDesc>],
        images: &[Asset<Image>],
        transfer: Transfer,
        filtered: bool,
    ) -> Result<Textures, SceneError> {
        Textures::prepare_with(descs, images, transfer, filtered, 1, &mut CachedMipmaps::default())
    }

    /// As [`Textures::prepare`]; reuses mipmaps from `kept`, and replaces its contents by those of these textures. Others
    /// are created on `threads` threads (0: all available).
    pub fn prepare_with(
        descs: &[Named<TextureDesc>],
        images: &[Asset<Image>],
        transfer: Transfer,
        filtered: bool,
        threads: usize,
        kept: &mut CachedMipmaps,
    ) -> Result<Textures, SceneError> {
        let uv = check_references(descs)?;
        let decoders =
            [Encoding::Auto, Encoding::Srgb, Encoding::Linear].map(|e| Decoder::new(e.transfer(transfer)));
        let used = vec![false; images.len()];
        let mipmaps = BTreeMap::new();
        let mut cx = PrepareContext { transfer, images, used, decoders, filtered, mipmaps, kept };
        if filtered {
            cx.create_mipmaps(descs, threads);
        }
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

/// Properties of a texture, known once those of its inputs are.
#[derive(Clone, Copy)]
struct Known {
    depth: u32,
    lookups: u64,
    uv: bool,
}

/// Computes, for each texture, whether it needs (u, v), and checks all references. Depth-first with an explicit
/// stack, because scenes may chain any number of named textures.
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
                    let first =
                        path.iter().position(|(n, _)| *n == child).expect("an open node is on the path");
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

/// The inputs of a texture that are textures, in reverse order.
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
    // A texture that is mixed with itself is evaluated once.
    named.dedup();
    let inner: Vec<Known> = named.into_iter().filter_map(|c| known[c]).collect();
    let costliest = inner.iter().map(|k| k.lookups).max().unwrap_or(0);
    let sides = if desc.value.triplanar().is_some() { 3 } else { 1 };
    let max_inputs = sides * desc.value.max_inputs().min(inner.len() as u64);
    let depth = 1 + inner.iter().map(|k| k.depth).max().unwrap_or(0);
    let lookups = costliest.saturating_mul(max_inputs).saturating_add(1);
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
            .help("use plain colours for some of its inputs"));
    }
    Ok(Known { depth, lookups, uv: desc.value.uses_uv() || inner.iter().any(|k| k.uv) })
}

/// A chain of nested textures from one that nests too deep: the first input at each level.
fn deepest(descs: &[Named<TextureDesc>], node: usize) -> Vec<usize> {
    let mut path = vec![node];
    while let Ok(inner) = children(descs, path[path.len() - 1])
        && let Some(first) = inner.last()
    {
        path.push(*first);
    }
    path
}

/// `a -> b -> a`; long chains are shortened.
fn chain(descs: &[Named<TextureDesc>], nodes: &[usize]) -> String {
    const SHOWN: usize = 12;
    let mut labels: Vec<String> = nodes.iter().map(|n| label(descs, *n)).collect();
    if labels.len() > SHOWN {
        let hidden = labels.len() - SHOWN;
        labels.splice(SHOWN / 2..SHOWN / 2 + hidden, [format!("({hidden} more)")]);
    }
    labels.join(" -> ")
}

/// The name, or the type of an inline texture.
fn label(descs: &[Named<TextureDesc>], node: usize) -> String {
    match &descs[node].name {
        Some(name) => escape(name),
        None => format!("{{ {} }}", descs[node].value.type_name()),
    }
}
