//! The binary chunk of a GLB file. Its parts are planned first and written at the end, so that no mesh is copied.

use serde_json::{Value, json};
use std::io::{self, Write};

/// Purpose of a buffer view (glTF's `target`).
#[derive(Clone, Copy)]
pub(super) enum Target {
    /// Vertex attributes.
    Vertices = 34962,
    /// Vertex indices.
    Indices = 34963,
}

/// Writes a part with exactly the announced number of bytes.
type WritePart<'a> = Box<dyn Fn(&mut dyn Write) -> io::Result<()> + 'a>;

/// The parts, and the JSON of their buffer views and accessors.
#[derive(Default)]
pub(super) struct Buffer<'a> {
    parts: Vec<(u64, WritePart<'a>)>,
    length: u64,
    pub(super) views: Vec<Value>,
    pub(super) accessors: Vec<Value>,
}

/// Bytes up to the next multiple of four.
fn padding(length: u64) -> u64 {
    length.wrapping_neg() % 4
}

impl<'a> Buffer<'a> {
    /// Adds a part of `length` bytes; returns the index of its buffer view.
    pub(super) fn view(
        &mut self,
        length: u64,
        target: Option<Target>,
        write: impl Fn(&mut dyn Write) -> io::Result<()> + 'a,
    ) -> usize {
        let mut view = json!({ "buffer": 0, "byteOffset": self.length, "byteLength": length });
        if let Some(target) = target {
            view["target"] = json!(target as u32);
        }
        self.views.push(view);
        self.parts.push((length, Box::new(write)));
        self.length += length + padding(length);
        self.views.len() - 1
    }

    /// Adds an accessor of float vectors, one per vertex, each converted by `make`; returns its index.
    pub(super) fn rows<const N: usize>(
        &mut self,
        rows: &'a [[f32; N]],
        make: impl Fn([f32; N]) -> [f32; N] + 'a,
    ) -> usize {
        let bounds = (N == 3).then(|| {
            let range = |k: usize| {
                let values = || rows.iter().map(|row| f64::from(make(*row)[k]));
                (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max))
            };
            [0, 1, 2].map(range)
        });
        let view = self.view(rows.len() as u64 * N as u64 * 4, Some(Target::Vertices), move |out| {
            for block in rows.chunks(4096) {
                let bytes: Vec<u8> =
                    block.iter().flat_map(|row| make(*row)).flat_map(f32::to_le_bytes).collect();
                out.write_all(&bytes)?;
            }
            Ok(())
        });
        let kind = match N {
            2 => "VEC2",
            3 => "VEC3",
            _ => "VEC4",
        };
        let mut accessor =
            json!({ "bufferView": view, "componentType": 5126, "count": rows.len(), "type": kind });
        if let Some(bounds) = bounds {
            accessor["min"] = json!(bounds.map(|b| b.0));
            accessor["max"] = json!(bounds.map(|b| b.1));
        }
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// Adds an accessor of the times or values of keyframes; returns its index.
    pub(super) fn values<const N: usize>(&mut self, rows: Vec<[f32; N]>) -> usize {
        let range = |k: usize| {
            let values = || rows.iter().map(|row| row[k]);
            (values().fold(f32::INFINITY, f32::min), values().fold(f32::NEG_INFINITY, f32::max))
        };
        let bounds: Vec<(f32, f32)> = (0..N).map(range).collect();
        let kind = ["SCALAR", "VEC2", "VEC3", "VEC4"][(N - 1).min(3)];
        let count = rows.len();
        let view = self.view(count as u64 * N as u64 * 4, None, move |out| {
            let bytes: Vec<u8> = rows.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
            out.write_all(&bytes)
        });
        let (min, max): (Vec<f32>, Vec<f32>) = bounds.into_iter().unzip();
        let accessor = json!({ "bufferView": view, "componentType": 5126, "count": count, "type": kind,
            "min": min, "max": max });
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// Adds an accessor with the indices of those triangles whose index `wanted` accepts.
    pub(super) fn triangles(
        &mut self,
        triangles: &'a [[u32; 3]],
        wanted: impl Fn(usize) -> bool + 'a,
    ) -> Option<usize> {
        let count = (0..triangles.len()).filter(|i| wanted(*i)).count();
        if count == 0 {
            return None;
        }
        let view = self.view(count as u64 * 12, Some(Target::Indices), move |out| {
            let mut bytes = Vec::with_capacity(1 << 16);
            for (i, triangle) in triangles.iter().enumerate() {
                if wanted(i) {
                    bytes.extend(triangle.iter().flat_map(|v| v.to_le_bytes()));
                }
                if bytes.len() > (1 << 16) - 12 {
                    out.write_all(&bytes)?;
                    bytes.clear();
                }
            }
            out.write_all(&bytes)
        });
        self.accessors
            .push(json!({ "bufferView": view, "componentType": 5125, "count": 3 * count, "type": "SCALAR" }));
        Some(self.accessors.len() - 1)
    }

    /// Length of the buffer, in bytes.
    pub(super) fn length(&self) -> u64 {
        self.length
    }

    /// Writes a GLB file: header, JSON, parts (glTF 2.0 §4.4). The format allows less than 4 GiB.
    pub(super) fn write(&self, json: &[u8], out: &mut dyn Write) -> io::Result<()> {
        let json_length = json.len() as u64 + padding(json.len() as u64);
        let has_binary = u64::from(self.length > 0);
        let total = 12 + 8 + json_length + has_binary * (8 + self.length);
        let word = |v: u64| {
            let too_large =
                || io::Error::new(io::ErrorKind::InvalidInput, "a .glb file cannot hold more than 4 GiB");
            u32::try_from(v).map(u32::to_le_bytes).map_err(|_| too_large())
        };
        out.write_all(b"glTF")?;
        out.write_all(&2_u32.to_le_bytes())?;
        out.write_all(&word(total)?)?;
        out.write_all(&word(json_length)?)?;
        out.write_all(b"JSON")?;
        out.write_all(json)?;
        // JSON is padded with spaces, binary data with zeros.
        out.write_all(&b"   "[..padding(json.len() as u64) as usize])?;
        if has_binary == 0 {
            return Ok(());
        }
        out.write_all(&word(self.length)?)?;
        out.write_all(b"BIN\0")?;
        for (length, write) in &self.parts {
            write(out)?;
            out.write_all(&[0; 3][..padding(*length) as usize])?;
        }
        Ok(())
    }
}
