use super::albedo::{CONTRASTS, Row, WIDTHS};
pub(super) static GGX_LOSS: [Row; WIDTHS] = [[0; 23]; WIDTHS];
pub(super) static FUZZ: [Row; WIDTHS] = [[0; 23]; WIDTHS];
pub(super) static REFLECT_SHIFT: [[Row; WIDTHS]; CONTRASTS.len()] = [[[0; 23]; WIDTHS]; 14];
pub(super) static DIELECTRIC_LOSS: [[[Row; WIDTHS]; CONTRASTS.len()]; 2] = [[[[0; 23]; WIDTHS]; 14]; 2];
