//! USD seeds: one stage as text, as binary, and in a package with a texture.

use super::seeds::Seed;

/// The stage as text.
pub(crate) const TEXT: &str = include_str!("seed.usda");
/// The same as binary.
pub(crate) const BINARY: &[u8] = include_bytes!("seed.usdc");

/// A stage whose material has a texture in the same package.
const TEXTURED: &str = r#"#usda 1.0
(
    defaultPrim = "Card"
    metersPerUnit = 1
)
def Mesh "Card"
{
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]
    texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1)] ( interpolation = "vertex" )
    rel material:binding = </Card/Look>
    def Material "Look"
    {
        token outputs:surface.connect = </Card/Look/Surface.outputs:surface>
        def Shader "Surface"
        {
            uniform token info:id = "UsdPreviewSurface"
            color3f inputs:diffuseColor.connect = </Card/Look/Picture.outputs:rgb>
        }
        def Shader "Picture"
        {
            uniform token info:id = "UsdUVTexture"
            asset inputs:file = @textures/picture.png@
            float2 inputs:st.connect = </Card/Look/Coordinates.outputs:result>
            token inputs:wrapS = "clamp"
        }
        def Shader "Coordinates"
        {
            uniform token info:id = "UsdPrimvarReader_float2"
            string inputs:varname = "st"
        }
    }
}
"#;

/// A package of stored files.
pub(crate) fn package(files: &[(&str, &[u8])]) -> Vec<u8> {
    let (mut out, mut list): (Vec<u8>, Vec<u8>) = (Vec::new(), Vec::new());
    for (name, bytes) in files {
        let at = out.len() as u32;
        // Data begin at multiples of 64 bytes.
        let pad = (64 - (out.len() + 30 + name.len() + 4) % 64) % 64;
        let mut common: Vec<u8> = vec![20, 0, 0, 0, 0, 0, 0, 0, 0x21, 0];
        common.extend(checksum(bytes).to_le_bytes());
        common.extend([bytes.len() as u32; 2].map(u32::to_le_bytes).as_flattened());
        common.extend((name.len() as u16).to_le_bytes());
        out.extend(b"PK\x03\x04");
        out.extend(&common);
        out.extend((pad as u16 + 4).to_le_bytes());
        out.extend(name.as_bytes());
        out.extend([0x86, 0x19]);
        out.extend((pad as u16).to_le_bytes());
        out.extend(vec![0; pad]);
        out.extend(*bytes);
        list.extend(b"PK\x01\x02\x14\0");
        list.extend(&common);
        list.extend([0; 12]);
        list.extend(at.to_le_bytes());
        list.extend(name.as_bytes());
    }
    let (start, size, count) = (out.len() as u32, list.len() as u32, files.len() as u16);
    out.extend(list);
    out.extend(b"PK\x05\x06\0\0\0\0");
    out.extend([count; 2].map(u16::to_le_bytes).as_flattened());
    out.extend(size.to_le_bytes());
    out.extend(start.to_le_bytes());
    out.extend([0; 2]);
    out
}

/// CRC-32 of ZIP.
fn checksum(bytes: &[u8]) -> u32 {
    let bit = |crc: u32| if crc & 1 == 1 { crc >> 1 ^ 0xEDB8_8320 } else { crc >> 1 };
    !bytes.iter().fold(u32::MAX, |crc, b| (0..8).fold(crc ^ u32::from(*b), |crc, _| bit(crc)))
}

/// The seeds; `picture` is a PNG file.
pub(super) fn seeds(picture: &[u8]) -> Vec<Seed> {
    let packed = package(&[("card.usda", TEXTURED.as_bytes()), ("textures/picture.png", picture)]);
    vec![
        Seed { name: "model.usda", bytes: TEXT.into(), scene: None },
        Seed { name: "model.usdc", bytes: BINARY.to_vec(), scene: None },
        Seed { name: "model.usdz", bytes: packed, scene: None },
    ]
}
