//! BSDFs as materials. A BSDF becomes one material per way in which shapes use it: with emission, with a medium
//! inside, with other (u, v). BSDFs that wrap another one (`twosided`, `mask`, `bumpmap`, `normalmap`) are
//! collected on the way to it.

use std::collections::BTreeMap;

use turner::bsdf::FacetDistribution;
use turner::color::Spectrum;
use turner::material::{
    AlphaMode, BumpUnit, InterfaceMaterial, MaterialDesc, MeasuredMaterial, MixMaterial, PrincipledMaterial,
};
use turner::schema::{ColorSource, ErrorCode, MaterialId, MediumId, Named};

use super::assembly::Assembly;
use super::emitters::Emission;
use super::leaves;
use super::older::{self, Lobe};
use super::params::Object;
use super::rough_layer::RoughLayer;
use super::spectra::Role;
use super::textures::{Surface, is_source, numbers, scalars, shares, source};
use crate::measured::MAX_BSDF;
use crate::scene_import::report::Fault;
use crate::scene_import::{Place, product};

/// Most materials.
const MAX_MATERIALS: usize = 1 << 22;
/// Deepest nesting of BSDFs.
const MAX_NESTING: u32 = 16;

/// Most rough layers that are computed.
const MAX_LAYERS: usize = 512;
/// Resolution of their α and IOR, steps per unit: an IOR that is off by 0.005 changes the light by 1.3 %.
const STEPS: f64 = 1000.0;

/// How a shape uses a BSDF, and what the wrappers of the BSDF add.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Use {
    pub(super) emission: Option<Emission>,
    pub(super) interior: Option<MediumId>,
    pub(super) surface: Surface,
    pub(super) two_sided: bool,
    pub(super) opacity: Option<ColorSource>,
    pub(super) bump: Option<(ColorSource, u64)>,
    pub(super) normal: Option<ColorSource>,
    pub(super) depth: u32,
    /// The lobe, for a BSDF that becomes a mix of two materials.
    pub(super) lobe: Option<Lobe>,
}

/// The materials of a scene.
#[derive(Default)]
pub(super) struct Materials {
    wanted: BTreeMap<(Option<usize>, String), MaterialId>,
    /// BSDF and use of each [`MaterialId`]; `None` is the material of shapes without a BSDF.
    list: Vec<(Option<usize>, Use)>,
    /// By distribution, rounded α and IOR.
    layers: BTreeMap<[u32; 3], RoughLayer>,
}

impl Materials {
    /// The material id of a BSDF for a use.
    pub(super) fn wanted(&mut self, node: Option<usize>, usage: Use) -> MaterialId {
        let key = (node, if usage == Use::default() { String::new() } else { format!("{usage:?}") });
        let next = MaterialId(self.list.len() as u32);
        let id = *self.wanted.entry(key).or_insert(next);
        if id == next {
            self.list.push((node, usage));
        }
        id
    }

    /// The transmittance of a rough layer, computed once for nearly equal parameters. `None` if there are too
    /// many: each takes milliseconds.
    pub(super) fn rough_layer(
        &mut self,
        distribution: FacetDistribution,
        alpha: f64,
        ior: f64,
    ) -> Option<RoughLayer> {
        let steps = |v: f64| (v * STEPS).round().clamp(0.0, 1e6);
        let (alpha, ior) = (steps(alpha), steps(ior));
        let key = [u32::from(distribution == FacetDistribution::Beckmann), alpha as u32, ior as u32];
        if !self.layers.contains_key(&key) && self.layers.len() < MAX_LAYERS {
            self.layers.insert(key, RoughLayer::new(distribution, alpha / STEPS, (ior / STEPS).max(1.0)));
        }
        self.layers.get(&key).copied()
    }

    /// Whether a shape encloses a medium.
    pub(super) fn encloses(&self, medium: MediumId) -> bool {
        self.list.iter().any(|(_, usage)| usage.interior == Some(medium))
    }
}

/// Makes all materials that are in use.
pub(super) fn finish(scene: &mut Assembly<'_>) -> Result<Vec<Named<MaterialDesc>>, Fault> {
    let mut made = Vec::new();
    // A mix adds its parts to the list.
    while let Some((node, usage)) = scene.materials.list.get(made.len()).cloned() {
        let (name, value) = match node {
            None => (None, plain(usage)),
            Some(node) => {
                let object = Object::new(&scene.document, node)?;
                (object.id(), make(scene, object, usage)?)
            }
        };
        if made.len() >= MAX_MATERIALS {
            return Err(Fault::new(ErrorCode::TooLarge, format!("more than {MAX_MATERIALS} materials")));
        }
        made.push(Named { name, span: None, value });
    }
    Ok(made)
}

pub(super) fn grey(v: f64) -> ColorSource {
    ColorSource::Constant(Spectrum::grey(v as f32))
}

/// The material of shapes without a BSDF: diffuse grey, or black if they emit.
fn plain(usage: Use) -> MaterialDesc {
    if usage.interior.is_some() && usage.emission.is_none() {
        return MaterialDesc::Interface(InterfaceMaterial { interior: usage.interior });
    }
    let reflectance = if usage.emission.is_some() { 0.0 } else { 0.5 };
    let surface = PrincipledMaterial { base_color: grey(reflectance), ..PrincipledMaterial::matte() };
    MaterialDesc::Principled(with_use(surface, usage))
}

/// One material for one use.
pub(super) fn make(
    scene: &mut Assembly<'_>,
    mut object: Object,
    mut usage: Use,
) -> Result<MaterialDesc, Fault> {
    loop {
        let place = object.place;
        usage.depth += 1;
        if usage.depth > MAX_NESTING {
            let message = format!("BSDFs nest deeper than {MAX_NESTING}");
            return Err(Fault::at(place, ErrorCode::TooLarge, message));
        }
        let inner = match object.kind.as_str() {
            "twosided" => {
                usage.two_sided = true;
                let inner = object.objects(&["bsdf"])?;
                if inner.len() > 1 {
                    let message = "different BSDFs for front and back: the front's is used on both sides";
                    scene.report.approximated(place, message);
                }
                inner.first().copied()
            }
            "mask" => {
                let opacity = match object.find("opacity") {
                    Some((node, _)) => shares(scene, node, usage.surface)?,
                    None => grey(0.5),
                };
                usage.opacity = Some(match usage.opacity {
                    Some(outer) => product(&mut scene.stock, outer, opacity),
                    None => opacity,
                });
                object.objects(&["bsdf"])?.first().copied()
            }
            "bumpmap" | "bump" => {
                let scale = object.float("scale")?.unwrap_or(1.0);
                if let Some(texture) = only_texture(&object)? {
                    let heights = numbers(scene, texture, Role::Unbounded, usage.surface)?;
                    usage.bump = Some((heights, scale.to_bits()));
                }
                object.objects(&["bsdf"])?.first().copied()
            }
            "normalmap" => {
                if let Some(texture) = only_texture(&object)? {
                    usage.normal = Some(numbers(scene, texture, Role::Unbounded, usage.surface)?);
                }
                object.pass(&["use_shadowing_function", "flip_invalid_normals"]);
                object.objects(&["bsdf"])?.first().copied()
            }
            "blendbsdf" => return blend(scene, &object, usage),
            "mixturebsdf" => return older::mixture(scene, &object, usage),
            "phong" | "ward" => return older::two_lobes(scene, &object, usage),
            "coating" | "roughcoating" => return older::coat(scene, &object, usage),
            "principled" | "principledthin" => return super::disney::material(scene, &object, usage),
            "measured" => return measured(scene, &object, usage),
            "hair" => return super::hair::material(scene, &object, &usage),
            "difftrans" => return older::translucent(scene, &object, usage),
            "null" => {
                scene.finish(&object);
                return Ok(null(scene, place, usage));
            }
            _ => return leaf(scene, &object, usage),
        };
        let Some(inner) = inner else {
            let message = format!("{} contains no BSDF", object.title());
            return Err(Fault::at(place, ErrorCode::MissingKey, message));
        };
        scene.finish(&object);
        object = Object::new(&scene.document, inner)?;
    }
}

/// Its texture, whatever the name.
fn only_texture(object: &Object) -> Result<Option<usize>, Fault> {
    object.pass(&["arbitrary", "normalmap", "normals", "bump"]);
    Ok(object.objects(&["texture"])?.first().copied())
}

fn null(scene: &mut Assembly<'_>, place: Place, usage: Use) -> MaterialDesc {
    if usage.emission.is_none() {
        return MaterialDesc::Interface(InterfaceMaterial { interior: usage.interior });
    }
    scene.report.approximated(place, "an emissive shape with a null BSDF: its surface is black");
    let black = PrincipledMaterial { base_color: grey(0.0), ..PrincipledMaterial::matte() };
    MaterialDesc::Principled(with_use(black, usage))
}

fn blend(scene: &mut Assembly<'_>, object: &Object, usage: Use) -> Result<MaterialDesc, Fault> {
    let weight = match object.find("weight") {
        Some((node, _)) => shares(scene, node, usage.surface)?,
        None => grey(0.5),
    };
    let parts = object.objects(&["bsdf"])?;
    let &[a, b] = &parts[..] else {
        let message = format!("a blendbsdf needs two BSDFs, found {}", parts.len());
        return Err(Fault::at(object.place, ErrorCode::MissingKey, message));
    };
    scene.finish(object);
    let mut wanted = Vec::new();
    for part in [a, b] {
        if Object::new(&scene.document, part)?.kind == "null" {
            let message = "a blend with null: rendered as the other BSDF with its weight as opacity";
            scene.report.approximated(object.place, message);
            let share = match (part == a, weight) {
                (true, w) => w,
                (false, ColorSource::Constant(c)) => ColorSource::Constant(c.map(|v| 1.0 - v)),
                (false, w) => crate::scene_import::map_values(
                    &mut scene.stock,
                    w,
                    object.place,
                    crate::scene_import::Through::Rest,
                ),
            };
            let opacity = match usage.opacity {
                Some(outer) => product(&mut scene.stock, outer, share),
                None => share,
            };
            let other = if part == a { b } else { a };
            let other = Object::new(&scene.document, other)?;
            return make(scene, other, Use { opacity: Some(opacity), ..usage });
        }
        wanted.push(scene.materials.wanted(Some(part), usage.clone()));
    }
    Ok(MaterialDesc::Mix(MixMaterial { materials: wanted, weights: vec![weight] }))
}

/// A measured BRDF; diffuse grey if there is no file, or one that cannot be read.
fn measured(scene: &mut Assembly<'_>, object: &Object, usage: Use) -> Result<MaterialDesc, Fault> {
    let place = object.place_of("filename");
    let file = match object.string("filename")?.map(str::to_owned) {
        Some(name) => {
            let read = scene.read(&name, MAX_BSDF, place)?;
            scene.measured_file(&name, read, place)?
        }
        None => {
            let message = format!("{} without filename: rendered as diffuse grey", object.title());
            scene.report.ignored(object.place, message);
            None
        }
    };
    let grey = PrincipledMaterial { base_color: grey(0.5), ..PrincipledMaterial::matte() };
    let shown = shown(scene, object, grey, usage);
    Ok(match (file, shown) {
        (Some(file), MaterialDesc::Principled(used)) => {
            MaterialDesc::Measured(MeasuredMaterial::with_use_of(file, used))
        }
        (_, shown) => shown,
    })
}

fn leaf(scene: &mut Assembly<'_>, object: &Object, usage: Use) -> Result<MaterialDesc, Fault> {
    let surface = leaves::surface(scene, object, usage.surface)?;
    Ok(shown(scene, object, surface, usage))
}

/// The material of a surface for a use. Unknown parts of the BSDF are reported.
pub(super) fn shown(
    scene: &mut Assembly<'_>,
    object: &Object,
    mut surface: PrincipledMaterial,
    usage: Use,
) -> MaterialDesc {
    scene.finish(object);
    let is_transmissive = surface.transmission_weight != grey(0.0) || surface.thin_walled;
    surface.front_only = !usage.two_sided && !is_transmissive;
    if is_transmissive || usage.opacity.is_some() {
        surface.interior = usage.interior;
    }
    MaterialDesc::Principled(with_use(surface, usage))
}

/// Adds emission, opacity, bump map and normal map.
fn with_use(mut surface: PrincipledMaterial, usage: Use) -> PrincipledMaterial {
    surface.soften_terminator = false;
    surface.alpha_mode = AlphaMode::Opaque;
    if let Some(opacity) = usage.opacity {
        (surface.opacity, surface.alpha_mode) = (opacity, AlphaMode::Blend);
    }
    if let Some((heights @ ColorSource::Texture(_), scale)) = usage.bump {
        (surface.bump_map, surface.bump_scale) = (Some(heights), f64::from_bits(scale));
        surface.bump_unit = BumpUnit::Scene;
    }
    if let Some(normals @ ColorSource::Texture(_)) = usage.normal {
        surface.normal_map = Some(normals);
    }
    if let Some(emission) = usage.emission {
        surface.emission_luminance = 1.0;
        surface.emission_color = emission.radiance;
        surface.emission_front_only = true;
    }
    surface
}

/// A colour or a texture of a BSDF; `or` if it is not given.
pub(super) fn color_of(
    scene: &mut Assembly<'_>,
    object: &Object,
    name: &'static str,
    or: f64,
    surface: Surface,
) -> Result<ColorSource, Fault> {
    match value_of(object, name)? {
        Some(node) => source(scene, node, Role::Albedo, surface),
        None => Ok(grey(or)),
    }
}

/// A number or a texture of numbers.
pub(super) fn number_of(
    scene: &mut Assembly<'_>,
    object: &Object,
    name: &'static str,
    or: f64,
    surface: Surface,
) -> Result<ColorSource, Fault> {
    number_as(scene, object, (name, or), Role::Albedo, surface)
}

/// The same within the limits of a role; `or` if it is not given.
pub(super) fn number_as(
    scene: &mut Assembly<'_>,
    object: &Object,
    (name, or): (&'static str, f64),
    role: Role,
    surface: Surface,
) -> Result<ColorSource, Fault> {
    match value_of(object, name)? {
        Some(node) => scalars(scene, node, role, surface),
        None => Ok(grey(or)),
    }
}

/// The element of a colour, a number or a texture.
fn value_of(object: &Object, name: &'static str) -> Result<Option<usize>, Fault> {
    let Some((index, _)) = object.find(name) else { return Ok(None) };
    let node = object.document.resolve(index)?;
    let Some(element) = object.document.node(node) else { return Ok(None) };
    if is_source(&element.tag) {
        return Ok(Some(node));
    }
    let message = format!("{name} is written as <{}>; expected a colour, a number or a texture", element.tag);
    Err(Fault::at(element.place, ErrorCode::WrongType, message))
}
