//! Helpers for lights: colour by temperature, the sun by date and hour.

use egui::{DragValue, Grid, Ui};
use turner::math::elementary::{asin, atan2, cos, sin, tan};

use super::name_number;

/// The linear colour (sRGB primaries) of a black body at a temperature in kelvins, 1667 to 25000, with its largest channel
/// at 1. The chromaticity is the approximation of Kim et al. 2002 (US patent 7024034, expired); the matrix is that of
/// IEC 61966-2-1.
pub(crate) fn black_body(kelvin: f64) -> [f64; 3] {
    let t = kelvin.clamp(1667.0, 25000.0);
    let by = 1000.0 / t;
    let x = if t <= 4000.0 {
        ((-0.2661239 * by - 0.2343589) * by + 0.8776956) * by + 0.179910
    } else {
        ((-3.0258469 * by + 2.1070379) * by + 0.2226347) * by + 0.240390
    };
    let y = if t <= 2222.0 {
        ((-1.1063814 * x - 1.34811020) * x + 2.18555832) * x - 0.20219683
    } else if t <= 4000.0 {
        ((-0.9549476 * x - 1.37418593) * x + 2.09137015) * x - 0.16748867
    } else {
        ((3.0817580 * x - 5.87338670) * x + 3.75112997) * x - 0.37001483
    };
    let [cx, cz] = [x / y, (1.0 - x - y) / y];
    let rgb = [
        3.2404542 * cx - 1.5371385 - 0.4985314 * cz,
        -0.9692660 * cx + 1.8760108 + 0.0415560 * cz,
        0.0556434 * cx - 0.2040259 + 1.0572252 * cz,
    ];
    let rgb = rgb.map(|v| v.max(0.0));
    let most = rgb.iter().copied().fold(1e-9, f64::max);
    rgb.map(|v| v / most)
}

/// Elevation and azimuth (from north towards east) of the sun in degrees, at a latitude in degrees, a day of the year from 1
/// and a solar hour: at 12 it stands in the south (Meeus 1998, "Astronomical Algorithms", ch. 13, with the mean
/// declination).
pub(crate) fn sun(latitude: f64, day: f64, hour: f64) -> [f64; 2] {
    let radians = f64::to_radians;
    let declination = radians(-23.44) * cos(radians(360.0 / 365.0 * (day + 10.0)));
    let (phi, h) = (radians(latitude), radians(15.0 * (hour - 12.0)));
    let up = sin(phi) * sin(declination) + cos(phi) * cos(declination) * cos(h);
    let from_south = atan2(sin(h), cos(h) * sin(phi) - tan(declination) * cos(phi));
    let azimuth = (from_south.to_degrees() + 180.0).rem_euclid(360.0);
    [asin(up.clamp(-1.0, 1.0)).to_degrees(), azimuth]
}

/// A temperature to choose a colour by. Returns the colour if one was chosen.
pub(crate) fn temperature(ui: &mut Ui) -> Option<[f64; 3]> {
    let id = ui.scope_id().with("temperature");
    let mut kelvin: f64 = ui.data_mut(|d| d.get_temp(id)).unwrap_or(6500.0);
    let mut chosen = false;
    ui.horizontal(|ui| {
        ui.label("Temperature")
            .on_hover_text("Colour of a black body: 1900 K is a candle, 2700 K a lamp, 6500 K daylight");
        let response = ui.add(DragValue::new(&mut kelvin).range(1667.0..=25000.0).speed(20.0).suffix(" K"));
        name_number(&response, "Temperature", kelvin);
        chosen = response.changed();
    });
    ui.data_mut(|d| d.insert_temp(id, kelvin));
    chosen.then(|| black_body(kelvin))
}

/// Place, day and hour of a sun. Returns elevation and azimuth if they were changed.
pub(crate) fn hour(ui: &mut Ui) -> Option<[f64; 2]> {
    let id = ui.scope_id().with("sun");
    let mut values: [f64; 3] = ui.data_mut(|d| d.get_temp(id)).unwrap_or([45.0, 172.0, 15.0]);
    let mut changed = false;
    Grid::new("sun").num_columns(2).show(ui, |ui| {
        let rows = [
            ("Hour", 0.0..=24.0, 0.02, " h"),
            ("Day of the year", 1.0..=365.0, 0.5, ""),
            ("Latitude", -90.0..=90.0, 0.2, "°"),
        ];
        for (i, (name, range, speed, suffix)) in [(2, &rows[0]), (1, &rows[1]), (0, &rows[2])] {
            ui.label(*name);
            let response =
                ui.add(DragValue::new(&mut values[i]).range(range.clone()).speed(*speed).suffix(*suffix));
            name_number(&response, name, values[i]);
            changed |= response.changed();
            ui.end_row();
        }
    });
    ui.data_mut(|d| d.insert_temp(id, values));
    let [latitude, day, hour] = values;
    changed.then(|| sun(latitude, day, hour))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sun_of_known_days() {
        let near = |[e, a]: [f64; 2], [we, wa]: [f64; 2]| {
            assert!((e - we).abs() < 1.0 && (a - wa).abs() < 1.5, "{e} {a}, expected {we} {wa}");
        };
        // At noon of the longest day the sun is 23.44° from the zenith at the equator's side of the tropic.
        near(sun(45.0, 172.0, 12.0), [68.4, 180.0]);
        near(sun(45.0, 355.0, 12.0), [21.6, 180.0]);
        // At the equinox it rises in the east and sets in the west.
        near(sun(45.0, 81.0, 6.0), [0.0, 90.0]);
        near(sun(45.0, 81.0, 18.0), [0.0, 270.0]);
        // In the south it stands in the north at noon.
        near(sun(-35.0, 355.0, 12.0), [78.4, 0.0]);
    }

    #[test]
    fn colours_of_temperatures() {
        let [r, g, b] = black_body(1900.0);
        assert!(r == 1.0 && g < 0.4 && b < 0.05, "{r} {g} {b}");
        let white = black_body(6500.0);
        assert!(white.iter().all(|v| *v > 0.9), "{white:?}");
        let [r, _, b] = black_body(20000.0);
        assert!(b == 1.0 && r < 0.5);
    }
}
