//! Lights (UsdLux).
//!
//! A light emits `intensity` · 2^`exposure` · `color` as radiance. With `normalize` that is divided by the area of the
//! light in units of the stage, so that its power does not depend on its size. Lights with an area become shapes that
//! emit light and that the camera does not see.

use std::f64::consts::{FRAC_PI_2, PI};
use turner::color::Spectrum;
use turner::description::{ObjectContent, SceneLight};
use turner::light::{Attenuation, DirectionalDesc, EnvironmentDesc, LightDesc, PointDesc, SpotDesc};
use turner::material::{AlphaMode, MaterialDesc, PrincipledMaterial};
use turner::math::elementary::{pow, sin};
use turner::math::{DAffine3, DMat3, DVec3};
use turner::schema::{ColorSource, MaterialId, Named, WarningKind};
use turner::shape::{CylinderDesc, DiskDesc, RectangleDesc, ShapeDesc, SphereDesc};

use super::scene::{Scene, State};
use super::stage::Prim;
use super::value::{Read, Value};
use crate::scene_import::environment_light;
use crate::scene_import::report::Fault;
use crate::spectral;

/// Falls off with 1/d².
const INVERSE_SQUARE: Attenuation = Attenuation { coefficients: [0.0, 0.0, 1.0] };

/// The attributes that all lights share.
struct Emission {
    color: Spectrum,
    /// Radiance of white, before `normalize`.
    strength: f64,
    is_normalized: bool,
}

/// An attribute of a light; older files write it without `inputs:`.
fn input(scene: &Scene<'_>, prim: &Prim, name: &str) -> Read<Option<Value>> {
    let value = scene.stage.value(prim, &format!("inputs:{name}"))?;
    if value.is_some() { Ok(value) } else { scene.stage.value(prim, name) }
}

fn number(scene: &Scene<'_>, prim: &Prim, name: &str, otherwise: f64) -> Read<f64> {
    let v = input(scene, prim, name)?.as_ref().and_then(Value::real);
    Ok(v.filter(|v| v.is_finite()).unwrap_or(otherwise))
}

fn flag(scene: &Scene<'_>, prim: &Prim, name: &str) -> Read<bool> {
    Ok(input(scene, prim, name)?.as_ref().and_then(Value::flag).unwrap_or(false))
}

impl Emission {
    fn read(scene: &Scene<'_>, prim: &Prim, kind: &str) -> Read<Emission> {
        let otherwise = if kind == "DistantLight" { 50_000.0 } else { 1.0 };
        let intensity = number(scene, prim, "intensity", otherwise)?.max(0.0);
        let exposure = number(scene, prim, "exposure", 0.0)?.clamp(-100.0, 100.0);
        let mut color = match input(scene, prim, "color")? {
            Some(Value::Vector(c)) if c.len() == 3 => {
                let [r, g, b] = [c[0], c[1], c[2]].map(|v| v.clamp(0.0, 1e30) as f32);
                Spectrum::new(r, g, b)
            }
            _ => Spectrum::WHITE,
        };
        if flag(scene, prim, "enableColorTemperature")? {
            color = color * spectral::blackbody(number(scene, prim, "colorTemperature", 6500.0)?);
        }
        let strength = (intensity * pow(2.0, exposure)).min(1e30);
        Ok(Emission { color, strength, is_normalized: flag(scene, prim, "normalize")? })
    }

    /// The radiance of white for a light with this area or solid angle.
    fn radiance(&self, size: f64) -> f64 {
        if self.is_normalized && size > 0.0 { self.strength / size } else { self.strength }
    }
}

/// Adds a light.
pub(super) fn add(scene: &mut Scene<'_>, prim: &Prim, kind: &str, state: &State) -> Result<(), Fault> {
    let emission = Emission::read(scene, prim, kind)?;
    if emission.strength == 0.0 || emission.color == Spectrum::BLACK {
        return Ok(());
    }
    for name in ["diffuse", "specular"] {
        if (number(scene, prim, name, 1.0)? - 1.0).abs() > 1e-6 {
            scene.ignored("factors of lights for diffuse or specular reflection");
        }
    }
    let light = match kind {
        "DistantLight" => distant(scene, prim, &emission, state)?,
        "DomeLight" | "DomeLight_1" => dome(scene, prim, kind, &emission, state)?,
        "SphereLight" | "RectLight" | "DiskLight" | "CylinderLight" => {
            return area(scene, prim, kind, &emission, state);
        }
        other => {
            scene.ignored(format!("a light of the type {other}"));
            None
        }
    };
    let Some(light) = light else { return Ok(()) };
    push(scene, prim, light);
    Ok(())
}

fn push(scene: &mut Scene<'_>, prim: &Prim, light: LightDesc) {
    if scene.depth > 0 {
        scene.ignored("lights without a surface in instances");
        return;
    }
    let name = Some(super::paths::name(&prim.path).to_owned());
    scene.counts.lights += 1;
    scene.stock.lights.push(SceneLight { name, ..light.into() });
}

fn distant(scene: &Scene<'_>, prim: &Prim, emission: &Emission, state: &State) -> Read<Option<LightDesc>> {
    let angle = number(scene, prim, "angle", 0.53)?.clamp(0.0, 180.0);
    let half = sin(0.5 * angle.to_radians());
    // The irradiance of a disc of constant radiance.
    let size = PI * half * half;
    let irradiance = if size > 0.0 { emission.radiance(size) * size } else { emission.strength };
    let direction = (state.transform.matrix3 * DVec3::NEG_Z).try_normalize();
    Ok(direction.map(|direction| {
        LightDesc::Directional(DirectionalDesc {
            direction: Some(direction),
            color: emission.color,
            intensity: irradiance,
            angle,
            ..DirectionalDesc::default()
        })
    }))
}

/// A dome: the centre of its image lies along +z, and +x to its left; +y is up.
fn dome(
    scene: &mut Scene<'_>,
    prim: &Prim,
    kind: &str,
    emission: &Emission,
    state: &State,
) -> Read<Option<LightDesc>> {
    let opinion = match scene.stage.opinion(prim, "inputs:texture:file")? {
        None => scene.stage.opinion(prim, "texture:file")?,
        some => some,
    };
    let format = input(scene, prim, "texture:format")?;
    let mut file = None;
    if let Some(opinion) = opinion
        && let Some(name) = opinion.value.text().filter(|n| !n.is_empty())
    {
        if !matches!(format.as_ref().and_then(Value::text), None | Some("automatic" | "latlong")) {
            scene.ignored("a dome light whose image is not in equirectangular projection");
            return Ok(None);
        }
        file = scene.picture(&opinion.layer, name);
        if file.is_none() {
            return Ok(None);
        }
    }
    let file = file.unwrap_or_else(|| environment_light::white(&mut scene.stock));
    let own = EnvironmentDesc {
        file: Some(file),
        tint: emission.color,
        strength: emission.strength,
        ..EnvironmentDesc::default()
    };
    let pole = match input(scene, prim, "poleAxis")?.as_ref().and_then(Value::text) {
        _ if kind != "DomeLight_1" => "Y".to_owned(),
        None | Some("scene") => {
            let up = scene.stage.metadata("upAxis")?;
            up.as_ref().and_then(Value::text).unwrap_or("Y").to_owned()
        }
        Some(axis) => axis.to_owned(),
    };
    let raised = if pole == "Z" { DMat3::from_rotation_x(FRAC_PI_2) } else { DMat3::IDENTITY };
    let turned = state.transform.matrix3 * raised * DMat3::from_rotation_y(PI);
    if let Some(light) = own.clone().turned_by(turned) {
        return Ok(Some(LightDesc::Environment(light)));
    }
    scene.warn(
        WarningKind::Approximated,
        "a dome light that is mirrored or sheared: it has only its rotation",
    );
    let (x, y) = (turned.x_axis.normalize_or(DVec3::X), turned.y_axis);
    let z = x.cross(y).normalize_or(DVec3::Z);
    Ok(own.turned_by(DMat3::from_cols(x, z.cross(x), z)).map(LightDesc::Environment))
}

/// The shape of a light in its own space, its area there, and its scale.
struct Surface {
    shape: ShapeDesc,
    area: f64,
    /// Projected area of the whole light as seen along its axis.
    seen: f64,
    is_one_sided: bool,
}

fn surface(scene: &Scene<'_>, prim: &Prim, kind: &str, scale: DVec3) -> Read<Option<Surface>> {
    let size = |name, otherwise| number(scene, prim, name, otherwise).map(|v| v.max(0.0));
    let mean = (scale.x + scale.y + scale.z) / 3.0;
    Ok(match kind {
        "SphereLight" => {
            let radius = size("radius", 0.5)?;
            let r = radius * mean;
            (radius > 0.0).then_some(Surface {
                shape: ShapeDesc::Sphere(SphereDesc { center: DVec3::ZERO, radius }),
                area: 4.0 * PI * r * r,
                seen: PI * r * r,
                is_one_sided: false,
            })
        }
        "RectLight" => {
            let (width, height) = (size("width", 1.0)?, size("height", 1.0)?);
            let area = width * scale.x * height * scale.y;
            let (edge_u, edge_v) = (DVec3::X * width, DVec3::NEG_Y * height);
            (area > 0.0).then_some(Surface {
                shape: ShapeDesc::Rectangle(RectangleDesc { center: DVec3::ZERO, edge_u, edge_v }),
                area,
                seen: area,
                is_one_sided: true,
            })
        }
        "DiskLight" => {
            let radius = size("radius", 0.5)?;
            let area = PI * radius * scale.x * radius * scale.y;
            let disk = DiskDesc { normal: DVec3::NEG_Z, radius, ..DiskDesc::default() };
            (radius > 0.0).then_some(Surface {
                shape: ShapeDesc::Disk(disk),
                area,
                seen: area,
                is_one_sided: true,
            })
        }
        _ => {
            let (length, radius) = (size("length", 1.0)?, size("radius", 0.5)?);
            let end = DVec3::X * (0.5 * length);
            let r = radius * 0.5 * (scale.y + scale.z);
            (radius > 0.0 && length > 0.0).then(|| Surface {
                shape: ShapeDesc::Cylinder(CylinderDesc { from: -end, to: end, radius, capped: false }),
                area: 2.0 * PI * r * length * scale.x,
                seen: 2.0 * r * length * scale.x,
                is_one_sided: false,
            })
        }
    })
}

/// Adds a light with an area, or one in a point: with a cone, or where the file asks for it.
fn area(
    scene: &mut Scene<'_>,
    prim: &Prim,
    kind: &str,
    emission: &Emission,
    state: &State,
) -> Result<(), Fault> {
    let m = state.transform.matrix3;
    // In units of the stage.
    let scale = DVec3::new(m.x_axis.length(), m.y_axis.length(), m.z_axis.length()) / scene.unit;
    let surface = surface(scene, prim, kind, scale)?;
    let widest = if kind == "SphereLight" || kind == "CylinderLight" { 180.0 } else { 90.0 };
    let cone = number(scene, prim, "shaping:cone:angle", widest)?;
    if input(scene, prim, "shaping:ies:file")?.is_some_and(|v| v.text().is_some_and(|t| !t.is_empty())) {
        scene.ignored("light profiles of lights (shaping:ies:file)");
    }
    if number(scene, prim, "shaping:focus", 0.0)? > 0.0 {
        scene.ignored("the focus of lights (shaping:focus)");
    }
    let is_point = flag(scene, prim, "treatAsPoint")? || surface.is_none();
    if cone < widest || is_point {
        let candela = match &surface {
            Some(surface) => emission.radiance(surface.area) * surface.seen,
            // The limit of small spheres.
            None if kind == "SphereLight" && emission.is_normalized => 0.25 * emission.strength,
            None => {
                scene.warn(WarningKind::Doubtful, format!("a {kind} without a size: it emits no light"));
                return Ok(());
            }
        };
        let intensity = candela * scene.unit * scene.unit;
        let radius = match &surface {
            Some(surface) if !is_point => (surface.seen / PI).sqrt() * scene.unit,
            _ => 0.0,
        };
        if radius > 0.0 && kind != "SphereLight" {
            scene.warn(
                WarningKind::Approximated,
                "lights with a cone: they become spot lights with the radius of a disk of the same area",
            );
        }
        point(scene, prim, (emission, intensity, radius), (cone, widest), state.transform)?;
        return Ok(());
    }
    let Some(surface) = surface else { return Ok(()) };
    let material = emitter(scene, emission, emission.radiance(surface.area), surface.is_one_sided);
    let before = scene.stock.objects.len();
    scene.place(ObjectContent::Shape(surface.shape), Some(material), prim, state.transform)?;
    if let Some(object) = scene.stock.objects.get_mut(before) {
        object.hidden_from_camera = true;
    }
    scene.counts.lights += 1;
    if input(scene, prim, "texture:file")?.is_some_and(|v| v.text().is_some_and(|t| !t.is_empty())) {
        scene.ignored("images of rectangular lights: they emit evenly");
    }
    Ok(())
}

/// A point light; with a cone, a spot light with a radius in scene units.
fn point(
    scene: &mut Scene<'_>,
    prim: &Prim,
    (emission, intensity, radius): (&Emission, f64, f64),
    (cone, widest): (f64, f64),
    world: DAffine3,
) -> Read<()> {
    let position = world.translation;
    let color = emission.color;
    if cone >= widest {
        let desc =
            PointDesc { position, color, intensity, attenuation: INVERSE_SQUARE, ..PointDesc::default() };
        push(scene, prim, LightDesc::Point(desc));
        return Ok(());
    }
    let Some(axis) = (world.matrix3 * DVec3::NEG_Z).try_normalize() else { return Ok(()) };
    let softness = number(scene, prim, "shaping:cone:softness", 0.0)?.clamp(0.0, 1.0);
    let angle = cone.clamp(1e-3, 180.0);
    let desc = SpotDesc {
        position,
        look_at: position + axis * (1.0 + position.abs().max_element()),
        angle,
        penumbra: angle * softness,
        color,
        intensity,
        radius,
        attenuation: INVERSE_SQUARE,
        ..SpotDesc::default()
    };
    push(scene, prim, LightDesc::Spot(desc));
    Ok(())
}

/// A black surface that emits light.
fn emitter(scene: &mut Scene<'_>, emission: &Emission, radiance: f64, is_one_sided: bool) -> MaterialId {
    let black = ColorSource::Constant(Spectrum::BLACK);
    let value = MaterialDesc::Principled(PrincipledMaterial {
        base_color: black,
        specular_weight: black,
        emission_color: ColorSource::Constant(emission.color),
        emission_luminance: radiance,
        emission_front_only: is_one_sided,
        // Rays pass its back.
        double_sided: !is_one_sided,
        alpha_mode: AlphaMode::Opaque,
        ..PrincipledMaterial::default()
    });
    scene.add_material(Named { name: None, span: None, value })
}
