//! Values that OpenUSD 26.11 wrote: `arrays.usdc` has each kind of storage.

use super::*;

const ARRAYS: &[u8] = include_bytes!("../../../tests/assets/usd/arrays.usdc");

fn value(name: &str) -> Value {
    let file = Binary::read(ARRAYS.to_vec()).unwrap();
    file.decode(file.stored(&format!("/A.{name}"), "default").unwrap()).unwrap()
}

#[test]
fn compressed_integers_are_decoded() {
    assert_eq!(value("ints"), Value::Ints((0..100).map(|i| (i * i) % 97 - 40).collect()));
    assert_eq!(value("steps"), Value::Ints((0..40).map(|i| 70_000 * i).collect()));
    assert_eq!(value("long"), Value::Ints((0..40).map(|i| (1 << 40) + i * i).collect()));
    assert_eq!(value("bools"), Value::Ints(vec![1, 0, 1]));
}

#[test]
fn compressed_numbers_are_decoded() {
    let table = [0.1, 0.25, 0.7];
    assert_eq!(value("whole"), Value::Floats(1, (0..60).map(|i| (i % 5) as f32).collect()));
    assert_eq!(value("table"), Value::Floats(1, (0..60).map(|i| table[i % 3] as f32).collect()));
    assert_eq!(value("double"), Value::Doubles(1, (0..60).map(|i| table[i % 3]).collect()));
    assert_eq!(value("plain"), Value::Floats(1, (0..5).map(|i| (f64::from(i) / 7.0) as f32).collect()));
    assert_eq!(value("halfs"), Value::Floats(3, vec![0.5, -2.0, 65504.0]));
}

#[test]
fn scalars_and_vectors_are_decoded_where_they_are() {
    assert_eq!(value("short"), Value::Vector(vec![1.0, -2.0, 3.0]));
    assert_eq!(value("vector"), Value::Vector(vec![1.5, -2.0, 3.0]));
    let mut matrix = vec![0.0; 16];
    (matrix[0], matrix[5], matrix[10], matrix[15]) = (2.0, 3.0, 4.0, 1.0);
    assert_eq!(value("matrix"), Value::Vector(matrix));
    assert_eq!(value("m3"), Value::Vector(vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.5]));
    // w comes first, as in text.
    assert_eq!(value("q"), Value::Vector([0.5_f32, 0.1, 0.2, 0.3].map(f64::from).to_vec()));
    assert_eq!(value("h2"), Value::Vector(vec![0.5, 1.5]));
    assert_eq!(value("i2"), Value::Vector(vec![1000.0, -3.0]));
    assert_eq!((value("big"), value("neg")), (Value::Int(1 << 40), Value::Int(-5)));
    assert_eq!((value("d"), value("d1")), (Value::Real(0.1), Value::Real(0.5)));
    let half = value("half").real().unwrap();
    assert!((half - 0.333).abs() < 2e-4, "{half}");
    assert_eq!(value("tokens"), Value::Texts(vec!["a".into(), "b".into()]));
    assert_eq!(
        (value("asset"), value("string")),
        (Value::Asset("x/y.png".into()), Value::Text("text".into()))
    );
}

#[test]
fn time_samples_are_decoded_when_asked_for() {
    let file = Binary::read(ARRAYS.to_vec()).unwrap();
    let Value::Samples(samples) = file.decode(file.stored("/A.t", "timeSamples").unwrap()).unwrap() else {
        panic!()
    };
    let decoded = samples.iter().map(|(time, value)| match value {
        Value::Stored(stored) => (*time, file.decode(*stored).unwrap()),
        other => panic!("{other:?}"),
    });
    assert_eq!(decoded.collect::<Vec<_>>(), [(0.0, Value::Real(1.0)), (10.0, Value::Real(3.0))]);
}

#[test]
fn damaged_arrays_do_not_panic() {
    for at in 0..ARRAYS.len() {
        for byte in [0, 0xFF, ARRAYS[at] ^ 0x40, ARRAYS[at].wrapping_add(1)] {
            let mut bytes = ARRAYS.to_vec();
            bytes[at] = byte;
            let Ok(file) = Binary::read(bytes) else { continue };
            for path in file.specs.keys() {
                for name in ["default", "timeSamples"] {
                    let _ = file.stored(path, name).map(|stored| file.decode(stored));
                }
            }
        }
    }
}
