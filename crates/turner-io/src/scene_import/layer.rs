//! The inner side of clear layers.

/// Fraction of diffuse light that the inner side of a smooth dielectric reflects: 1 − (1 − R) / η², where R is
/// what the outer side reflects and η the IOR.
pub(crate) fn inner_reflectance(ior: f64) -> f64 {
    const STEPS: u32 = 256;
    let ior = ior.clamp(1.0, 100.0);
    // R = ∫ F(μ) 2μ dμ in equal steps of μ².
    let outer: f64 = (0..STEPS)
        .map(|i| {
            let cos = ((f64::from(i) + 0.5) / f64::from(STEPS)).sqrt();
            let inside = (1.0 - (1.0 - cos * cos) / (ior * ior)).max(0.0).sqrt();
            let s = (cos - ior * inside) / (cos + ior * inside);
            let p = (ior * cos - inside) / (ior * cos + inside);
            0.5 * (s * s + p * p)
        })
        .sum();
    1.0 - (1.0 - outer / f64::from(STEPS)) / (ior * ior)
}

#[cfg(test)]
mod tests {
    use super::inner_reflectance;

    #[test]
    fn the_inner_side_reflects_most() {
        // Egan and Hilgeman 1973: 0.5963 for 1.5, 0.4730 for 1.33.
        assert!((inner_reflectance(1.5) - 0.5963).abs() < 1e-3, "{}", inner_reflectance(1.5));
        assert!((inner_reflectance(1.33) - 0.473).abs() < 2e-3, "{}", inner_reflectance(1.33));
        assert_eq!(inner_reflectance(1.0), 0.0);
    }
}
