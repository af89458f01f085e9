//! BSDFs of Mitsuba 0.6 that later versions do not have: Phong, Ward ("Measuring and modeling anisotropic
//! reflection", 1992), coatings, mixtures and diffuse transmission.

use turner::color::Spectrum;
use turner::material::{MaterialDesc, MixMaterial, PrincipledMaterial};
use turner::schema::{ColorSource, ErrorCode};

use super::assembly::Assembly;
use super::leaves::stretched;
use super::materials::{Use, color_of, grey, number_of};
use super::params::{Object, numbers};
use super::spectra::{Role, index};
use super::textures::source;
use crate::scene_import::report::Fault;
use crate::scene_import::{Through, map_values};

/// Most BSDFs of a mixture.
const MAX_PARTS: usize = 64;

/// One of the two lobes of Phong and Ward.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Lobe {
    Diffuse,
    Glossy,
}

/// The weight of the glossy lobe in the mix. The colour of each lobe is divided by its weight, so that the sum
/// is that of the file. The values of textures are not known: half each.
fn glossy_share(glossy: ColorSource) -> f64 {
    match glossy {
        ColorSource::Constant(c) => f64::from(c.max_component()).clamp(0.0, 1.0),
        ColorSource::Texture(_) => 0.5,
    }
}

/// `phong` and `ward`: a mix of a diffuse surface and a rough mirror, or the one of both that `usage` names.
pub(super) fn two_lobes(
    scene: &mut Assembly<'_>,
    object: &Object,
    usage: Use,
) -> Result<MaterialDesc, Fault> {
    let glossy = color_of(scene, object, "specular_reflectance", 0.2, usage.surface)?;
    let share = glossy_share(glossy);
    let lobe = match usage.lobe {
        Some(lobe) => lobe,
        None if share <= 0.0 => Lobe::Diffuse,
        None => {
            let node = Some(object.node);
            let message = format!("{}: rendered as a diffuse surface plus a rough mirror", object.title());
            scene.report.approximated(object.place, message);
            let parts = [Lobe::Diffuse, Lobe::Glossy]
                .map(|lobe| scene.materials.wanted(node, Use { lobe: Some(lobe), ..usage.clone() }));
            let weights = vec![grey(share)];
            return Ok(MaterialDesc::Mix(MixMaterial { materials: parts.to_vec(), weights }));
        }
    };
    let diffuse = color_of(scene, object, "diffuse_reflectance", 0.5, usage.surface)?;
    let surface = match lobe {
        Lobe::Diffuse => {
            let left = 1.0 / (1.0 - share).max(1e-3);
            let base_color = map_values(&mut scene.stock, diffuse, object.place, Through::Scale(left));
            PrincipledMaterial { base_color, ..PrincipledMaterial::matte() }
        }
        Lobe::Glossy => {
            let through = Through::Scale(1.0 / share.max(1e-3));
            let mut mirror = PrincipledMaterial {
                base_weight: grey(0.0),
                specular_ior: 0.0,
                specular_color: map_values(&mut scene.stock, glossy, object.place, through),
                ..PrincipledMaterial::default()
            };
            let [u, v] = widths(scene, object, &usage)?;
            stretched(u, v, &mut mirror);
            mirror
        }
    };
    object.pass(&["variant", "exponent", "alpha", "alpha_u", "alpha_v"]);
    Ok(super::materials::shown(scene, object, surface, usage))
}

/// α of the lobe along u and v. A lobe cosⁿ around the mirror direction is half as wide in half vectors: α² = 1
/// / (2n + 1).
fn widths(scene: &mut Assembly<'_>, object: &Object, usage: &Use) -> Result<[f64; 2], Fault> {
    if object.kind == "phong" {
        let is_number =
            object.find("exponent").is_some_and(|(_, node)| node.tag == "float" || node.tag == "integer");
        let exponent = if is_number { object.float("exponent")? } else { None };
        return Ok([(1.0 / (2.0 * exponent.unwrap_or(30.0).max(0.0) + 1.0)).sqrt(); 2]);
    }
    let mut number = |name, or: f64| {
        number_of(scene, object, name, or, usage.surface).map(|source| match source {
            ColorSource::Constant(c) => f64::from(c.g),
            ColorSource::Texture(_) => or,
        })
    };
    let both = number("alpha", 0.1)?;
    Ok([number("alpha_u", both)?, number("alpha_v", both)?])
}

/// `mixturebsdf`: several BSDFs with their weights. If the weights sum to less than 1, they are scaled up.
pub(super) fn mixture(scene: &mut Assembly<'_>, object: &Object, usage: Use) -> Result<MaterialDesc, Fault> {
    let parts = object.objects(&["bsdf"])?;
    let text = object.string("weights")?.unwrap_or_default();
    let weights = numbers(text, MAX_PARTS).filter(|w| w.len() == parts.len() && !w.is_empty());
    let Some(weights) = weights.filter(|w| w.iter().all(|v| *v >= 0.0) && w.iter().sum::<f64>() > 0.0) else {
        let message = format!("weights \"{}\" for {} BSDFs", crate::assets::printable(text), parts.len());
        return Err(Fault::at(object.place_of("weights"), ErrorCode::WrongType, message)
            .help("expected a number for each, as in \"0.7, 0.3\""));
    };
    scene.finish(object);
    if let &[only] = &parts[..] {
        let inner = Object::new(&scene.document, only)?;
        return super::materials::make(scene, inner, usage);
    }
    let wanted = |part: &usize| scene.materials.wanted(Some(*part), usage.clone());
    let materials: Vec<_> = parts.iter().map(wanted).collect();
    Ok(MaterialDesc::Mix(MixMaterial { materials, weights: weights.into_iter().map(grey).collect() }))
}

/// `coating` and `roughcoating`: a clearcoat on the inner BSDF.
pub(super) fn coat(scene: &mut Assembly<'_>, object: &Object, usage: Use) -> Result<MaterialDesc, Fault> {
    let outer = index(object, "ext_ior", 1.000277)?;
    let ior = (index(object, "int_ior", 1.5046)? / outer).clamp(1.0, 3.0);
    let thickness = object.float("thickness")?.unwrap_or(1.0).max(0.0);
    let absorbed = match object.find("sigma_a") {
        Some((node, _)) => source(scene, node, Role::Unbounded, usage.surface)?,
        None => grey(0.0),
    };
    let alpha = match (object.kind.as_str(), number_of(scene, object, "alpha", 0.1, usage.surface)?) {
        ("coating", _) => 0.0,
        (_, ColorSource::Constant(c)) => f64::from(c.g).clamp(0.0, 1.0),
        (_, ColorSource::Texture(_)) => 0.1,
    };
    object.pass(&["distribution", "specular_reflectance", "alpha", "sample_visible"]);
    let inner = object.objects(&["bsdf"])?;
    let Some(inner) = inner.first() else {
        let message = format!("{} contains no BSDF", object.title());
        return Err(Fault::at(object.place, ErrorCode::MissingKey, message));
    };
    scene.finish(object);
    let inner = Object::new(&scene.document, *inner)?;
    let made = super::materials::make(scene, inner, usage)?;
    let MaterialDesc::Principled(mut surface) = made else {
        let message = format!("{} on a mixture of BSDFs", object.title());
        scene.report.ignored(object.place, message);
        return Ok(made);
    };
    if let ColorSource::Constant(c) = absorbed {
        // In and out, at normal incidence.
        let through =
            c.map(|s| turner::math::elementary::exp(-2.0 * thickness * f64::from(s.max(0.0))) as f32);
        surface.coat_color = ColorSource::Constant(through);
    }
    (surface.coat_weight, surface.coat_ior, surface.coat_roughness) = (grey(1.0), ior, grey(alpha.sqrt()));
    Ok(MaterialDesc::Principled(surface))
}

/// `difftrans`: diffuse transmission only.
pub(super) fn translucent(
    scene: &mut Assembly<'_>,
    object: &Object,
    usage: Use,
) -> Result<MaterialDesc, Fault> {
    let through = color_of(scene, object, "transmittance", 0.5, usage.surface)?;
    let surface = PrincipledMaterial {
        thin_walled: true,
        subsurface_weight: grey(1.0),
        subsurface_color: through,
        base_color: ColorSource::Constant(Spectrum::BLACK),
        ..PrincipledMaterial::matte()
    };
    Ok(super::materials::shown(scene, object, surface, usage))
}
