//! Random numbers.

/// A splitmix64 generator: the same numbers for the same seed on every machine.
#[derive(Clone, Debug)]
pub struct Random(u64);

/// Mixes all bits of a number.
pub(super) fn hash(x: u64) -> u64 {
    let z = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

impl Random {
    /// The sequence of a seed.
    pub fn new(seed: u64) -> Random {
        Random(hash(seed.wrapping_add(0x9e37_79b9_7f4a_7c15)))
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        hash(self.0)
    }

    /// Uniform in `0.0..1.0`.
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1 << 24) as f32
    }

    /// Uniform in `low..high`.
    pub fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }

    /// Uniform in the cube from -1 to 1.
    pub fn in_cube(&mut self) -> [f32; 3] {
        std::array::from_fn(|_| self.between(-1.0, 1.0))
    }

    /// Uniform on the unit sphere, by rejection.
    pub fn direction(&mut self) -> [f32; 3] {
        loop {
            let [x, y, z] = self.in_cube();
            let square = x * x + y * y + z * z;
            if (1e-4..=1.0).contains(&square) {
                let scale = 1.0 / square.sqrt();
                return [x * scale, y * scale, z * scale];
            }
        }
    }

    /// A direction around a unit normal, with a density proportional to the cosine.
    pub fn cosine(&mut self, normal: [f32; 3]) -> [f32; 3] {
        loop {
            // The normal plus a point on the unit sphere is cosine-distributed.
            let direction = self.direction();
            let [x, y, z] = std::array::from_fn(|i| normal[i] + direction[i]);
            let square: f32 = x * x + y * y + z * z;
            if square > 1e-6 {
                let scale = 1.0 / square.sqrt();
                return [x * scale, y * scale, z * scale];
            }
        }
    }
}
