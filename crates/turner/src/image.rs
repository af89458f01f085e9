//! Images in memory, the data of textures and environment maps.

/// The samples of an image, row 0 at the top, channels interleaved. Eight-bit files stay eight-bit.
#[derive(Clone, Debug, PartialEq)]
pub enum Pixels {
    /// 8 bits per channel, 1 (grey), 2 (grey, alpha), 3 (RGB) or 4 (RGBA) channels, display-encoded.
    U8(Vec<u8>),
    /// 16 bits per channel, display-encoded.
    U16(Vec<u16>),
    /// 32-bit floats, linear.
    F32(Vec<f32>),
}

/// An image: `width * height * channels` samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Columns, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// 1 (grey), 2 (grey + alpha), 3 (RGB) or 4 (RGB + straight alpha).
    pub channels: u8,
    /// The samples.
    pub pixels: Pixels,
}

impl Pixels {
    /// Bytes per sample.
    pub fn sample_bytes(&self) -> u64 {
        match self {
            Pixels::U8(_) => 1,
            Pixels::U16(_) => 2,
            Pixels::F32(_) => 4,
        }
    }
}

impl Image {
    /// Size of the samples in bytes.
    pub fn memory(&self) -> usize {
        match &self.pixels {
            Pixels::U8(v) => v.len(),
            Pixels::U16(v) => v.len() * 2,
            Pixels::F32(v) => v.len() * 4,
        }
    }

    /// Whether values are display-encoded (8- and 16-bit files) rather than linear (float files).
    pub fn is_display_encoded(&self) -> bool {
        !matches!(self.pixels, Pixels::F32(_))
    }

    /// The pixel in column `x`, row `y` as RGB: 0..=1 for integer samples, unchanged for floats; grey is
    /// repeated. Coordinates are clamped to the image.
    pub fn rgb(&self, x: u32, y: u32) -> [f32; 3] {
        let (x, y) = (x.min(self.width - 1) as usize, y.min(self.height - 1) as usize);
        let n = self.channels as usize;
        let i = (y * self.width as usize + x) * n;
        let at = |c: usize| match &self.pixels {
            Pixels::U8(v) => f32::from(v[i + c]) / 255.0,
            Pixels::U16(v) => f32::from(v[i + c]) / 65535.0,
            Pixels::F32(v) => v[i + c],
        };
        if n < 3 { [at(0); 3] } else { [at(0), at(1), at(2)] }
    }

    /// The alpha of a pixel inside the image: 0..=1 for integer samples, 1 without alpha; NaN counts as 0.
    pub fn alpha(&self, x: u32, y: u32) -> f32 {
        let n = usize::from(self.channels);
        if !matches!(n, 2 | 4) {
            return 1.0;
        }
        let i = (y as usize * self.width as usize + x as usize) * n + n - 1;
        match &self.pixels {
            Pixels::U8(v) => f32::from(v[i]) / 255.0,
            Pixels::U16(v) => f32::from(v[i]) / 65535.0,
            Pixels::F32(v) => v[i].max(0.0),
        }
    }

    /// Whether the image is not empty and the number of samples equals width * height * channels.
    pub fn is_consistent(&self) -> bool {
        let samples = match &self.pixels {
            Pixels::U8(v) => v.len(),
            Pixels::U16(v) => v.len(),
            Pixels::F32(v) => v.len(),
        };
        let pixels = (self.width as usize).checked_mul(self.height as usize);
        (1..=4).contains(&self.channels)
            && samples > 0
            && pixels.and_then(|n| n.checked_mul(usize::from(self.channels))) == Some(samples)
    }

    /// Number of samples that are infinite or NaN; textures treat them as 0.
    pub fn non_finite(&self) -> usize {
        match &self.pixels {
            Pixels::F32(v) => v.iter().filter(|v| !v.is_finite()).count(),
            _ => 0,
        }
    }
}
