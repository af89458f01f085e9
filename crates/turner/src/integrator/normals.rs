//! Normals as colours, for looking at geometry.

use crate::scene::schema::{choice, params};

choice! {
    /// Which normal is shown.
    pub enum NormalKind {
        /// The shading normal, turned towards the viewer.
        Shading = "shading",
        /// The geometric normal, as it points out of the shape.
        Geometric = "geometric",
    }
}

params! {
    /// Shows the normal at the first hit as a colour: 0.5 + 0.5·(x, y, z).
    pub struct NormalsDesc as "normals" {
        /// Which normal.
        normal: NormalKind = NormalKind::Shading;
    }
    example r#"[integrator]
type = "normals"
"#
}
