//! Which denoiser removes the noise of the finished picture.

use crate::schema::choice;

choice! {
    /// What happens to the noise of the finished picture.
    pub enum Denoise {
        /// It stays.
        Off = "off",
        /// Turner's denoiser removes it, guided by albedo, normals and distance: the same bytes on every machine.
        On = "on",
        /// The same denoiser with one fit for each block of 4 x 4 pixels: for pictures in motion. It takes about a tenth of
        /// the time.
        Fast = "fast",
        /// Open Image Denoise removes it, if its library is found when the render starts. The bytes depend on its version
        /// and on the processor.
        Oidn = "oidn",
    }
}
