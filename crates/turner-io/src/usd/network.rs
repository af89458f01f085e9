//! Shading networks (UsdShade): what the inputs of a material's surface are connected to.

use std::collections::BTreeMap;

use turner::math::elementary::sin_cos;

use super::paths::split_property;
use super::stage::{Opinion, Prim, Stage};
use super::value::{Read, Value};

/// Most connections from one to the next.
const MAX_HOPS: usize = 32;

/// What an input of a surface is.
#[derive(Clone, Debug)]
pub(super) enum Input {
    Value(Value),
    Texture(Box<Texture>),
    /// The colours of the mesh.
    Colors,
    /// A node of another type.
    Unknown(String),
}

/// A texture (UsdUVTexture).
#[derive(Clone, Debug)]
pub(super) struct Texture {
    pub(super) file: String,
    /// The layer that names the file.
    pub(super) layer: String,
    /// The output that is used: `rgb`, `r`, `g`, `b` or `a`.
    pub(super) output: String,
    /// The name of the texture coordinates.
    pub(super) set: String,
    /// Rows of the matrix that is applied to them.
    pub(super) matrix: Option<[f64; 6]>,
    pub(super) wrap: [String; 2],
    pub(super) scale: [f32; 4],
    pub(super) bias: Option<[f32; 4]>,
    pub(super) color_space: String,
    /// The value without the file.
    pub(super) fallback: Option<[f64; 4]>,
}

/// The surface of a material: the inputs of a UsdPreviewSurface.
#[derive(Debug, Default)]
pub(super) struct Network {
    pub(super) inputs: BTreeMap<String, Input>,
}

impl Network {
    /// The names of the texture coordinates that its textures use.
    pub(super) fn sets(&self) -> impl Iterator<Item = &String> {
        self.inputs.values().filter_map(|input| match input {
            Input::Texture(texture) => Some(&texture.set),
            _ => None,
        })
    }
}

/// What an attribute's value comes from.
enum End {
    Shader(Prim, String),
    Value(Opinion),
    Nothing,
}

/// Follows the connections of an attribute.
fn follow(stage: &Stage<'_>, prim: &Prim, name: &str) -> Read<End> {
    let (mut prim, mut name) = (prim.clone(), name.to_owned());
    for _ in 0..MAX_HOPS {
        let targets = stage.targets(&prim, &name, "connectionPaths")?;
        let Some(target) = targets.first() else {
            return Ok(stage.opinion(&prim, &name)?.map_or(End::Nothing, End::Value));
        };
        let (path, Some(property)) = split_property(target) else { return Ok(End::Nothing) };
        let Some(next) = stage.prim_at(path)? else { return Ok(End::Nothing) };
        let property = property.to_owned();
        if stage.text_field(&next, "typeName")? == "Shader" && property.starts_with("outputs:") {
            return Ok(End::Shader(next, property["outputs:".len()..].to_owned()));
        }
        (prim, name) = (next, property);
    }
    Ok(End::Nothing)
}

/// The value of an attribute, through connections.
fn value(stage: &Stage<'_>, prim: &Prim, name: &str) -> Read<Option<Value>> {
    Ok(match follow(stage, prim, name)? {
        End::Value(opinion) => Some(opinion.value),
        _ => None,
    })
}

fn text(stage: &Stage<'_>, prim: &Prim, name: &str) -> Read<String> {
    Ok(value(stage, prim, name)?.and_then(|v| v.text().map(str::to_owned)).unwrap_or_default())
}

fn vector<const N: usize>(stage: &Stage<'_>, prim: &Prim, name: &str) -> Read<Option<[f64; N]>> {
    Ok(match value(stage, prim, name)? {
        Some(Value::Vector(v)) => v.first_chunk::<N>().copied().filter(|v| v.iter().all(|c| c.is_finite())),
        _ => None,
    })
}

/// The surface of a material; the error is what it has instead, in words.
pub(super) fn surface(stage: &Stage<'_>, path: &str) -> Read<Result<Network, String>> {
    let Some(material) = stage.prim_at(path)? else { return Ok(Err("does not exist".to_owned())) };
    let mut outputs = vec!["outputs:surface".to_owned()];
    let names = stage.names(&material, "properties")?;
    outputs.extend(names.into_iter().filter(|n| n.starts_with("outputs:") && n.ends_with(":surface")));
    let mut other = String::new();
    for output in outputs {
        let End::Shader(shader, _) = follow(stage, &material, &output)? else { continue };
        let id = text(stage, &shader, "info:id")?;
        if id == "UsdPreviewSurface" {
            return inputs(stage, &shader).map(Ok);
        }
        if other.is_empty() {
            other = if id.is_empty() { "a shader without info:id".to_owned() } else { id };
        }
    }
    Ok(Err(if other.is_empty() { "has no surface".to_owned() } else { format!("is {other}") }))
}

/// The inputs of a surface.
fn inputs(stage: &Stage<'_>, shader: &Prim) -> Read<Network> {
    let mut network = Network::default();
    for name in stage.names(shader, "properties")? {
        let Some(short) = name.strip_prefix("inputs:") else { continue };
        let input = match follow(stage, shader, &name)? {
            End::Value(opinion) => Input::Value(opinion.value),
            End::Nothing => continue,
            End::Shader(node, output) => self::node(stage, &node, output)?,
        };
        network.inputs.insert(short.to_owned(), input);
    }
    Ok(network)
}

fn node(stage: &Stage<'_>, node: &Prim, output: String) -> Read<Input> {
    let id = text(stage, node, "info:id")?;
    match id.as_str() {
        "UsdUVTexture" => texture(stage, node, output),
        "UsdPrimvarReader_float3" | "UsdPrimvarReader_float4" | "UsdPrimvarReader_float"
            if matches!(
                text(stage, node, "inputs:varname")?.trim_start_matches("primvars:"),
                "displayColor" | "displayOpacity"
            ) =>
        {
            Ok(Input::Colors)
        }
        _ => Ok(Input::Unknown(if id.is_empty() { "a shader without info:id".to_owned() } else { id })),
    }
}

fn texture(stage: &Stage<'_>, node: &Prim, output: String) -> Read<Input> {
    let End::Value(file) = follow(stage, node, "inputs:file")? else {
        return Ok(Input::Unknown("a UsdUVTexture without a file".to_owned()));
    };
    let name = file.value.text().unwrap_or_default().to_owned();
    let four = |v: Option<[f64; 4]>| v.map(|v| v.map(|c| c as f32));
    let (set, matrix) = coordinates(stage, node)?;
    Ok(Input::Texture(Box::new(Texture {
        file: name,
        layer: file.layer,
        output,
        set,
        matrix,
        wrap: [text(stage, node, "inputs:wrapS")?, text(stage, node, "inputs:wrapT")?],
        scale: four(vector(stage, node, "inputs:scale")?).unwrap_or([1.0; 4]),
        bias: four(vector(stage, node, "inputs:bias")?),
        color_space: text(stage, node, "inputs:sourceColorSpace")?,
        fallback: vector(stage, node, "inputs:fallback")?,
    })))
}

/// The texture coordinates of a texture: their name, and what transforms them.
fn coordinates(stage: &Stage<'_>, node: &Prim) -> Read<(String, Option<[f64; 6]>)> {
    /// Most transforms one after the other.
    const MOST: usize = 8;
    let mut matrix: Option<[f64; 6]> = None;
    let mut from = (node.clone(), "inputs:st".to_owned());
    for _ in 0..MOST {
        let End::Shader(reader, _) = follow(stage, &from.0, &from.1)? else { break };
        if text(stage, &reader, "info:id")? != "UsdTransform2d" {
            let name = text(stage, &reader, "inputs:varname")?;
            let name = name.trim_start_matches("primvars:");
            return Ok((if name.is_empty() { "st".to_owned() } else { name.to_owned() }, matrix));
        }
        let degrees = value(stage, &reader, "inputs:rotation")?.as_ref().and_then(Value::real).unwrap_or(0.0);
        let [sx, sy] = vector(stage, &reader, "inputs:scale")?.unwrap_or([1.0; 2]);
        let [tx, ty] = vector(stage, &reader, "inputs:translation")?.unwrap_or([0.0; 2]);
        let (s, c) = sin_cos(degrees.to_radians());
        // Scaled, turned counter-clockwise, moved.
        let own = [c * sx, -s * sy, tx, s * sx, c * sy, ty];
        matrix = Some(matrix.map_or(own, |outer| product(outer, own)));
        from = (reader, "inputs:in".to_owned());
    }
    Ok(("st".to_owned(), matrix))
}

/// `a` after `b`.
fn product(a: [f64; 6], b: [f64; 6]) -> [f64; 6] {
    let row = |r: usize| {
        [
            a[r] * b[0] + a[r + 1] * b[3],
            a[r] * b[1] + a[r + 1] * b[4],
            a[r] * b[2] + a[r + 1] * b[5] + a[r + 2],
        ]
    };
    let ([a, b, c], [d, e, f]) = (row(0), row(3));
    [a, b, c, d, e, f]
}
