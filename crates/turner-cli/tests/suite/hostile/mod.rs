//! Hostile files: each gives a picture or a clear error, in bounded time and memory, and discloses nothing from
//! outside its folder. `TURNER_HOSTILE=200 cargo test --release -p turner-cli hostile` tries 200 mutations of each
//! seed instead of a few.
#![cfg(unix)]

mod models;
mod mutate;
mod numbers;
mod paths;
mod pictures;
mod run;
mod scenes;

use run::{Case, try_all};
use turner_io::testing::seeds::{companions, seeds};

/// Mutations of each seed.
fn mutations() -> usize {
    std::env::var("TURNER_HOSTILE").ok().and_then(|n| n.parse().ok()).unwrap_or(6)
}

#[test]
fn damaged_files_give_an_error_or_a_picture() {
    let mut cases = Vec::new();
    for seed in seeds() {
        let around: Vec<(String, Vec<u8>)> = companions()
            .into_iter()
            .map(|(name, bytes)| (name.to_owned(), bytes))
            .chain(seed.scene.iter().map(|(name, text)| ((*name).to_owned(), text.clone().into_bytes())))
            .collect();
        let main = seed.scene.as_ref().map_or(seed.name, |(name, _)| name);
        for (how, bytes) in mutate::mutations(&seed.bytes, mutations()) {
            let mut files = around.clone();
            files.retain(|(name, _)| name != seed.name);
            files.push((seed.name.to_owned(), bytes));
            cases.push(Case::new(format!("{} {how}", seed.name), main, files));
        }
    }
    try_all(cases);
}

#[test]
fn hostile_scenes() {
    try_all(scenes::cases());
    try_all(numbers::cases());
}

#[test]
fn hostile_models() {
    try_all(models::cases());
}

#[test]
fn hostile_pictures_and_packed_files() {
    try_all(pictures::cases());
}

#[test]
fn paths_that_lead_out() {
    paths::try_them();
}
