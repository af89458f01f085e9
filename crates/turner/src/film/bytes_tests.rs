//! Bytes of films: round trips, and errors for everything else.

use proptest::prelude::*;

use super::*;
use crate::color::Spectrum;
use crate::math::DVec2;
use crate::schema::{ErrorCode, Limits, Memory};

/// The settings of an empty scene.
fn plain() -> FilmDesc {
    crate::description::SceneDesc::default().film
}

fn read(bytes: &[u8]) -> Result<Film, crate::schema::SceneError> {
    Film::from_bytes(bytes, &Limits::default())
}

fn set(range: std::ops::Range<u64>) -> SampleSet {
    let mut set = SampleSet::default();
    set.insert(range);
    set
}

/// A film that uses every field of the format: two tiles, additional channels, light paths, non-finite samples.
fn full() -> Film {
    let desc = FilmDesc {
        width: 30,
        height: 20,
        crop: Some([3, 2, 19, 11]),
        antialias: Antialias::MonteCarlo,
        samples: 9,
        ..plain()
    };
    let mut film = Film::with_channels(&desc, vec![Channel::new("Z"), Channel::new("N.X")]).unwrap();
    film.estimate_error().unwrap();
    film.take_light(100).unwrap();
    film.note_cluster(8);
    film.set_scene(77);
    let (filter, mut sums) = (desc.filter(), TileSums::default());
    sums.reset(film.tiles().rect(1), 2, true);
    for i in 0..3 {
        let v = i as f32;
        let color = Spectrum::new(v, 0.5, -v);
        assert!(sums.add_weighted(
            i,
            &SampleValues { color, alpha: 1.0, extra: &[7.0, v], index: i as u32 },
            1.0
        ));
    }
    let non_finite = NonFinite { count: 1, first: Some((2, 19, 4)) };
    let shared = film.share();
    assert!(shared.deposit_sums((1, None), &sums, &set(2..5), &non_finite, 0));
    let splat = Splat { place: DVec2::new(5.5, 6.5), color: Spectrum::grey(300.0) };
    assert!(shared.deposit_light(&filter, 100..300, &[splat]));
    film.count_non_finite();
    film
}

fn one_sample() -> Film {
    let mut film = Film::new(&FilmDesc { width: 20, height: 3, ..plain() }).unwrap();
    let samples = (0..12u8).map(|i| (Spectrum::grey(f32::from(i)), 0.25));
    assert!(film.share().deposit_samples(1, samples, &NonFinite::default()));
    film
}

#[test]
fn films_round_trip() {
    for film in [full(), one_sample(), Film::new(&plain()).unwrap()] {
        let bytes = film.to_bytes();
        let back = read(&bytes).unwrap();
        assert!(back.to_bytes() == bytes);
        assert_eq!((back.identity(), back.channels()), (film.identity(), film.channels()));
        assert_eq!(
            (back.non_finite, back.samples(), back.memory()),
            (film.non_finite, film.samples(), film.memory())
        );
        for tile in 0..film.tiles().count() {
            assert_eq!(back.held(tile), film.held(tile));
        }
        let desc = plain();
        let bits = |film: &Film| {
            film.develop(&desc, 1).linear.iter().flat_map(|p| p.map(f32::to_bits)).collect::<Vec<_>>()
        };
        assert_eq!(bits(&back), bits(&film));
        assert_eq!(back.channel("Z", 20, 2), film.channel("Z", 20, 2));
    }
    let film = full();
    assert_eq!((film.channel("Z", 20, 2), film.channel("N.X", 21, 2)), (Some(7.0), Some(2.0)));
    assert_eq!(
        (film.channel("Z", 3, 2), film.channel("Z", 50, 50), film.channel("Y", 20, 2)),
        (None, None, None)
    );
    // A tile without pixels takes five bytes.
    assert_eq!(
        one_sample().to_bytes().len()
            - Film::new(&FilmDesc { width: 20, height: 3, ..plain() }).unwrap().to_bytes().len(),
        16 + 12 * 16
    );
}

#[test]
fn every_truncation_is_refused() {
    for film in [full(), one_sample()] {
        let bytes = film.to_bytes();
        for length in 0..bytes.len() {
            assert!(read(&bytes[..length]).is_err(), "{length}");
            // Also with a valid checksum.
            let cut = length.min(bytes.len() - 9);
            assert!(read(&resealed(bytes[..cut].to_vec())).is_err(), "{length}");
        }
        let mut longer = bytes[..bytes.len() - 8].to_vec();
        longer.push(0);
        assert!(read(&resealed(longer)).unwrap_err().message.contains("more bytes than"));
    }
}

#[test]
fn every_flipped_bit_is_noticed() {
    for film in [full(), one_sample()] {
        let bytes = film.to_bytes();
        for bit in 0..8 * bytes.len() {
            let mut bytes = bytes.clone();
            bytes[bit / 8] ^= 1 << (bit % 8);
            let error = read(&bytes).unwrap_err();
            assert_eq!(error.code, ErrorCode::Film, "{bit}");
        }
    }
}

/// The content followed by its checksum.
fn resealed(mut content: Vec<u8>) -> Vec<u8> {
    let seal = checksum(&content);
    content.extend(seal.to_le_bytes());
    content
}

/// Reads arbitrary bytes; an accepted film can be developed, merged and written.
fn try_out(bytes: &[u8]) {
    static LIMIT: u64 = 1 << 28;
    let limits = Limits { memory: std::sync::Arc::new(Memory::new(LIMIT, || Some(0))), ..Limits::default() };
    if let Ok(mut film) = Film::from_bytes(bytes, &limits) {
        assert!(film.memory() as u64 <= LIMIT);
        let _ = (film.samples(), film.first_missing(), film.channel("Z", 4, 4));
        let other = film.clone();
        let _ = film.merge(&other);
        if film.memory() < 1 << 20 {
            film.develop(&plain(), 1);
            assert!(Film::from_bytes(&film.to_bytes(), &limits).is_ok());
        }
    }
}

#[test]
fn hostile_bytes_with_a_valid_checksum_do_no_harm() {
    for film in [full(), one_sample()] {
        let bytes = film.to_bytes();
        let content = &bytes[..bytes.len() - 8];
        for at in 8..content.len().min(700) {
            for value in [0, 1, 2, 0x7f, 0x80, 0xff, content[at] ^ 1] {
                let mut content = content.to_vec();
                content[at] = value;
                try_out(&resealed(content));
            }
        }
    }
}

proptest! {
    #[test]
    fn random_bytes_do_no_harm(
        random in proptest::collection::vec(any::<u8>(), 0..400),
        changes in proptest::collection::vec((any::<u16>(), any::<u8>()), 1..20),
    ) {
        try_out(&random);
        try_out(&resealed([&b"TURNFILM\x02\0\0\0"[..], &random].concat()));
        let mut content = full().to_bytes();
        content.truncate(content.len() - 8);
        for (at, value) in changes {
            let at = 12 + usize::from(at) % (content.len() - 12);
            content[at] = value;
        }
        try_out(&resealed(content));
    }
}

#[test]
fn errors_say_what_is_wrong() {
    let message = |bytes: &[u8]| read(bytes).unwrap_err().message;
    assert_eq!(message(b"PNG"), "the film cannot be read: it is not a Turner film");
    let content = |bytes: Vec<u8>| bytes[..bytes.len() - 8].to_vec();
    let mut newer = content(full().to_bytes());
    newer[8] = 9;
    assert_eq!(message(&resealed(newer)), "the film's bytes have version 9; expected 7");
    let mut damaged = full().to_bytes();
    damaged[40] ^= 4;
    assert_eq!(message(&damaged), "the film cannot be read: its checksum is wrong");
    // 60000 x 60000 pixels exceed the maximum; 16000 x 16000 are more than a short file can contain.
    let with_size = |size: u32| {
        let mut content = content(full().to_bytes());
        for (i, v) in [size, size, 0, 0, size, size, 0, 0, size, size].into_iter().enumerate() {
            content[12 + 4 * i..16 + 4 * i].copy_from_slice(&v.to_le_bytes());
        }
        resealed(content)
    };
    assert_eq!(read(&with_size(60_000)).unwrap_err().code, ErrorCode::TooLarge);
    assert!(message(&with_size(16_000)).contains("ends too early"));
    // Memory limits apply.
    let limits =
        Limits { memory: std::sync::Arc::new(Memory::new(1 << 20, || Some(0))), ..Limits::default() };
    let desc = FilmDesc { width: 300, height: 300, samples: 4, antialias: Antialias::Grid, ..plain() };
    let large = Film::new(&desc).unwrap().to_bytes();
    assert!(read(&large).is_ok());
    let error = Film::from_bytes(&large, &limits).unwrap_err();
    assert_eq!(
        (error.code, error.message.starts_with("the film of 300x300 pixels needs")),
        (ErrorCode::TooLarge, true)
    );
}

#[test]
fn channels_need_names_of_their_own() {
    let desc = plain();
    let refused = |names: &[&str]| {
        Film::with_channels(&desc, names.iter().copied().map(Channel::new).collect()).is_err()
    };
    assert!(refused(&["Z", "Z"]) && refused(&["R"]) && refused(&[""]) && refused(&[&"x".repeat(256)]));
    assert!(!refused(&["Z", "N.X", "N.Y"]));
}
