use turner_bvh::InstructionSet;

use super::*;

const WIDTH: usize = 100;
const HEIGHT: usize = 70;

fn options(threads: usize, set: InstructionSet) -> DenoiseOptions<'static> {
    DenoiseOptions { threads, set, cancel: None }
}

/// A uniform number for a pixel.
fn random(i: usize, k: u32) -> f32 {
    let hash = (i as u32).wrapping_mul(2_654_435_761) ^ k.wrapping_mul(0x9e37_79b9);
    let hash = (hash ^ hash >> 15).wrapping_mul(0x85eb_ca6b);
    ((hash ^ hash >> 13) >> 8) as f32 / (1 << 24) as f32
}

/// Two surfaces of different albedo and normal, of which the left one has stripes, lit unevenly, with a lamp. Returns the
/// buffers and the picture without noise. Noise is uniform, with this standard deviation relative to the light.
fn scene(noise: f32) -> (Buffers, Vec<Rgb>) {
    let mut b = Buffers { width: WIDTH, height: HEIGHT, ..Buffers::default() };
    let mut truth = Vec::new();
    for i in 0..WIDTH * HEIGHT {
        let (x, y) = (i % WIDTH, i / WIDTH);
        let is_lamp = (80..90).contains(&x) && (20..30).contains(&y);
        let is_left = x < 50;
        let stripe = if x % 4 < 2 { 0.9 } else { 0.3 };
        let albedo: Rgb = match (is_lamp, is_left) {
            (true, _) => [0.0; 3],
            (_, true) => [stripe, 0.5, 0.2],
            _ => [0.4; 3],
        };
        let normal = if is_left { [1.0, 0.0, 0.0] } else { [0.0, 0.0, 1.0] };
        let light = 0.5 + y as f32 / HEIGHT as f32;
        let reflected: Rgb = albedo.map(|a| a * (light + 0.2));
        let emission = if is_lamp { [20.0; 3] } else { [0.0; 3] };
        truth.push(std::array::from_fn(|c| reflected[c] + emission[c]));
        let noisy = |v: Rgb, k: u32| {
            let by = 1.0 + noise * 12f32.sqrt() * (random(i, k) - 0.5);
            let new = v.map(|v| v * by);
            let deviation = noise * luminance(&v);
            (new, deviation * deviation)
        };
        for (part, (mean, variance)) in
            [(&mut b.emission, (emission, 0.0)), (&mut b.reflected, noisy(reflected, 1))]
        {
            part.mean.push(mean);
            part.variance.push(variance);
        }
        let [r, g, blue] = albedo;
        let [nx, ny, nz] = normal;
        b.guides.push([r, g, blue, nx, ny, nz, 2.0]);
        b.guide_variances.push([0.0; 3]);
    }
    (b, truth)
}

fn error(found: &[Rgb], truth: &[Rgb]) -> f64 {
    let each = found.iter().flatten().zip(truth.iter().flatten());
    each.map(|(a, b)| f64::from((a - b) * (a - b))).sum::<f64>() / found.len() as f64
}

#[test]
fn without_noise_the_picture_stays() {
    let (buffers, truth) = scene(0.0);
    let found = denoise(&buffers, &options(1, InstructionSet::best())).unwrap();
    for (a, b) in found.iter().flatten().zip(truth.iter().flatten()) {
        assert!((a - b).abs() <= 1e-5 * b, "{a} {b}");
    }
}

#[test]
fn noise_goes_edges_textures_and_energy_stay() {
    let (buffers, truth) = scene(0.4);
    let raw: Vec<Rgb> = (0..truth.len())
        .map(|i| std::array::from_fn(|c| buffers.emission.mean[i][c] + buffers.reflected.mean[i][c]))
        .collect();
    let found = denoise(&buffers, &options(1, InstructionSet::best())).unwrap();
    let (before, after) = (error(&raw, &truth), error(&found, &truth));
    assert!(after < 0.05 * before, "{before} {after}");
    let mean = |picture: &[Rgb]| picture.iter().flatten().map(|v| f64::from(*v)).sum::<f64>();
    assert!((mean(&found) / mean(&raw) - 1.0).abs() < 0.01, "{} {}", mean(&found), mean(&raw));
    // Neighbouring stripes differ as they should, and the lamp is as it was.
    let at = |x: usize, y: usize| found[y * WIDTH + x];
    let ratio = at(21, 35)[0] / at(23, 35)[0];
    assert!((ratio - 3.0).abs() < 0.15, "{ratio}");
    assert_eq!(at(85, 25), [20.0; 3]);
}

#[test]
fn threads_and_instruction_sets_do_not_change_a_bit() {
    let (buffers, _) = scene(0.4);
    for denoise in [denoise, denoise_fast] {
        let bits = |threads, set| -> Vec<u32> {
            denoise(&buffers, &options(threads, set)).unwrap().iter().flatten().map(|v| v.to_bits()).collect()
        };
        let first = bits(1, InstructionSet::PORTABLE);
        for set in InstructionSet::available() {
            for threads in [1, 3] {
                assert!(bits(threads, set) == first, "{} {threads}", set.name());
            }
        }
    }
}

#[test]
fn one_fit_per_block_keeps_edges_textures_and_energy() {
    let (buffers, truth) = scene(0.4);
    let raw = buffers.colors(1);
    let found = denoise_fast(&buffers, &options(1, InstructionSet::best())).unwrap();
    let (before, after) = (error(&raw, &truth), error(&found, &truth));
    assert!(after < 0.1 * before, "{before} {after}");
    let mean = |picture: &[Rgb]| picture.iter().flatten().map(|v| f64::from(*v)).sum::<f64>();
    assert!((mean(&found) / mean(&raw) - 1.0).abs() < 0.01, "{} {}", mean(&found), mean(&raw));
    assert_eq!(found[25 * WIDTH + 85], [20.0; 3]);
}

/// Light groups, of which one has three quarters of the light.
#[test]
fn parts_lose_their_noise_too() {
    let (buffers, truth) = scene(0.4);
    let share = |picture: &[Rgb]| picture.iter().map(|v| v.map(|v| 0.75 * v)).collect::<Vec<Rgb>>();
    let (part, whole) = (share(&buffers.reflected.mean), share(&truth));
    let found = denoise_part(&buffers, &part, false, &options(1, InstructionSet::best())).unwrap();
    let is_lit = |i: &usize| buffers.emission.mean[*i] == [0.0; 3];
    let lit = |picture: &[Rgb]| (0..picture.len()).filter(is_lit).map(|i| picture[i]).collect::<Vec<Rgb>>();
    let (before, after) = (error(&lit(&part), &lit(&whole)), error(&lit(&found), &lit(&whole)));
    assert!(after < 0.06 * before, "{before} {after}");
}

/// Few samples find the light: most pixels are black, and nothing in them tells of noise.
#[test]
fn black_pixels_among_noise_get_light() {
    let (mut buffers, truth) = scene(0.0);
    for i in 0..truth.len() {
        let is_found = random(i, 5) < 0.125;
        let by = if is_found { 8.0 } else { 0.0 };
        let part = &mut buffers.reflected;
        let bright = luminance(&part.mean[i]) * by;
        part.variance[i] = bright * bright;
        part.mean[i] = part.mean[i].map(|v| v * by);
    }
    // The fast denoiser limits bright pixels more.
    for (found, least) in [
        (denoise(&buffers, &options(1, InstructionSet::best())).unwrap(), 0.2),
        (denoise_fast(&buffers, &options(1, InstructionSet::best())).unwrap(), 0.02),
    ] {
        let dark = (0..truth.len()).filter(|i| luminance(&found[*i]) < least * luminance(&truth[*i])).count();
        assert!(dark < truth.len() / 50, "{dark} of {} below {least}", truth.len());
    }
}

/// A single bright sample, as of a caustic that few samples find.
#[test]
fn single_bright_samples_are_limited() {
    let (mut buffers, truth) = scene(0.1);
    let i = 50 * WIDTH + 70;
    buffers.reflected.mean[i] = [50.0; 3];
    buffers.reflected.variance[i] = 2500.0;
    let found = denoise(&buffers, &options(1, InstructionSet::best())).unwrap();
    let near = around(WIDTH, HEIGHT, i, 4);
    let worst = near.map(|j| (found[j][1] / truth[j][1] - 1.0).abs()).fold(0.0, f32::max);
    assert!(worst < 0.2, "{worst}");
}

/// Rounding may leave emission a little below 0, where a shadow catcher behind other objects was taken out of it.
#[test]
fn all_values_are_finite_with_emission_below_zero() {
    let (mut buffers, _) = scene(0.4);
    for i in 0..buffers.emission.mean.len() {
        let value = if i % 2 == 0 { -1e-5 } else { 0.0 };
        (buffers.emission.mean[i], buffers.emission.variance[i]) = ([value; 3], 1e-16);
    }
    for denoise in [denoise, denoise_fast] {
        let found = denoise(&buffers, &options(1, InstructionSet::best())).unwrap();
        assert!(found.iter().flatten().all(|v| v.is_finite()));
    }
}

/// The estimate of the error that is left needs no reference.
#[test]
fn the_error_that_is_left_is_near_the_true_one() {
    let set = InstructionSet::best();
    for noise in [0.2, 0.6] {
        let (buffers, truth) = scene(noise);
        let found = denoise(&buffers, &options(1, set)).unwrap();
        let estimate = left(&buffers, &found, 1, &|buffers| denoise(buffers, &options(1, set))).unwrap();
        let relative =
            |(a, b): (&Rgb, &Rgb)| f64::from((luminance(a) - luminance(b)).abs() / luminance(b).max(1e-3));
        let mut all: Vec<f64> = found.iter().zip(&truth).map(relative).collect();
        all.sort_by(f64::total_cmp);
        let exceeded = all[all.len() * 95 / 100];
        assert!((0.6..1.8).contains(&(estimate / exceeded)), "{noise}: {estimate}, truly {exceeded}");
    }
    let (buffers, _) = scene(0.2);
    assert_eq!(left(&buffers, &buffers.colors(1), 1, &|_| None), None);
}

#[test]
fn a_cancelled_denoiser_returns_nothing() {
    let (buffers, _) = scene(0.4);
    let cancel = AtomicBool::new(true);
    let options = DenoiseOptions { cancel: Some(&cancel), ..options(2, InstructionSet::best()) };
    assert!(denoise(&buffers, &options).is_none());
    assert!(denoise_fast(&buffers, &options).is_none());
    cancel.store(false, Ordering::SeqCst);
    assert!(denoise_fast(&buffers, &options).is_some());
}
