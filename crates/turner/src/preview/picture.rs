//! The picture that a preview shows.

/// No object.
pub const NO_OBJECT: u32 = u32::MAX;

/// A picture for display.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PreviewPicture {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Linear radiance times coverage, like the film's mean colour; row by row from the top.
    pub color: Vec<[f32; 3]>,
    /// Coverage, 0..=1.
    pub alpha: Vec<f32>,
    /// What the ray through the centre of the pixel hits first: the ID of the primitive, its index in the description with
    /// instances in order; [`NO_OBJECT`] where it hits nothing.
    pub object: Vec<u32>,
    /// Distance from the camera to that hit; infinite where there is none.
    pub depth: Vec<f32>,
}

impl PreviewPicture {
    pub(super) fn resize(&mut self, width: u32, height: u32) {
        let count = width as usize * height as usize;
        (self.width, self.height) = (width, height);
        self.color.resize(count, [0.0; 3]);
        self.alpha.resize(count, 0.0);
        self.object.resize(count, NO_OBJECT);
        self.depth.resize(count, f32::INFINITY);
    }
}
