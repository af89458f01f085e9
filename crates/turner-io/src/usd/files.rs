//! The files that a stage names: in the scene's folder, or in a package as `model.usdz[textures/wood.png]`.

use std::collections::BTreeMap;
use std::io::Read;
use std::sync::{Arc, Mutex, PoisonError};

use super::package::Package;
use super::stage::Source;
use crate::assets::{AssetError, AssetSource, printable};

/// Largest layer or package, bytes.
const MAX_FILE: u64 = 4 << 30;

/// The files of a stage.
pub(super) struct Files<'a> {
    assets: &'a dyn AssetSource,
    packages: Mutex<BTreeMap<String, Arc<Package>>>,
}

/// `package.usdz` and `inner` of `package.usdz[inner]`.
fn split(uri: &str) -> Option<(&str, &str)> {
    uri.strip_suffix(']')?.split_once('[')
}

fn joined(package: &str, inner: &str) -> String {
    format!("{package}[{inner}]")
}

fn is_package(uri: &str) -> bool {
    uri.len() >= 5
        && uri.is_char_boundary(uri.len() - 5)
        && uri[uri.len() - 5..].eq_ignore_ascii_case(".usdz")
}

impl<'a> Files<'a> {
    pub(super) fn new(assets: &'a dyn AssetSource) -> Files<'a> {
        Files { assets, packages: Mutex::default() }
    }

    /// Adds the package that the user named; returns the name of its root layer and the layer's bytes.
    pub(super) fn add_package(&self, uri: &str, bytes: Vec<u8>) -> Result<(String, Vec<u8>), String> {
        let package = Arc::new(Package::open(bytes)?);
        let root = package.file(&package.first).unwrap_or_default().to_vec();
        let name = joined(uri, &package.first);
        self.packages.lock().unwrap_or_else(PoisonError::into_inner).insert(uri.to_owned(), package);
        Ok((name, root))
    }

    fn package(&self, uri: &str) -> Result<Arc<Package>, AssetError> {
        if let Some(known) = self.packages.lock().unwrap_or_else(PoisonError::into_inner).get(uri) {
            return Ok(Arc::clone(known));
        }
        let bytes = self.assets.read(uri, MAX_FILE)?;
        let invalid = |_| AssetError::Invalid { uri: printable(uri), reason: "is a damaged package" };
        let package = Arc::new(Package::open(bytes).map_err(invalid)?);
        let mut packages = self.packages.lock().unwrap_or_else(PoisonError::into_inner);
        packages.insert(uri.to_owned(), Arc::clone(&package));
        Ok(package)
    }

    fn packaged(&self, package: &str, inner: &str) -> Result<Vec<u8>, AssetError> {
        match self.package(package)?.file(inner) {
            Some(bytes) => Ok(bytes.to_vec()),
            None => Err(missing(package, inner)),
        }
    }
}

fn missing(package: &str, inner: &str) -> AssetError {
    AssetError::Missing { uri: printable(inner), folder: printable(package), nearest: String::new() }
}

/// A path relative to a folder in a package; `None` if it leaves the package.
fn inside(folder: &str, uri: &str) -> Option<String> {
    let mut parts: Vec<&str> = folder.split('/').filter(|p| !p.is_empty()).collect();
    for part in uri.split(['/', '\\']) {
        match part {
            "" | "." => {}
            ".." => drop(parts.pop()?),
            name => parts.push(name),
        }
    }
    Some(parts.join("/"))
}

impl AssetSource for Files<'_> {
    fn read(&self, uri: &str, limit: u64) -> Result<Vec<u8>, AssetError> {
        match split(uri) {
            Some((package, inner)) => {
                let bytes = self.packaged(package, inner)?;
                let size = bytes.len() as u64;
                if size > limit {
                    return Err(AssetError::TooLarge { uri: printable(uri), size, limit });
                }
                Ok(bytes)
            }
            None => self.assets.read(uri, limit),
        }
    }

    fn read_ahead(&self, uri: &str, limit: u64) -> Result<(Vec<u8>, String), AssetError> {
        self.assets.read_ahead(uri, limit)
    }

    fn used(&self, mark: String) {
        self.assets.used(mark);
    }

    fn open<'b>(&'b self, uri: &str, limit: u64) -> Result<Box<dyn Read + 'b>, AssetError> {
        if split(uri).is_some() {
            return AssetSource::read(self, uri, limit)
                .map(|b| Box::new(std::io::Cursor::new(b)) as Box<dyn Read + 'b>);
        }
        self.assets.open(uri, limit)
    }

    fn describe(&self, uri: &str) -> String {
        match split(uri) {
            Some((package, inner)) => joined(&self.assets.describe(package), &printable(inner)),
            None => self.assets.describe(uri),
        }
    }

    fn resolve(&self, from: &str, uri: &str) -> Result<String, AssetError> {
        if let Some((package, inner)) = split(uri) {
            return Ok(joined(&self.assets.resolve(from, package)?, inner));
        }
        let Some((package, anchor)) = split(from) else { return self.assets.resolve(from, uri) };
        let outside = || AssetError::Outside {
            uri: printable(uri),
            reason: "leaves the package",
            root: printable(package),
        };
        if uri.starts_with('/') || uri.contains(':') {
            return Err(outside());
        }
        // Relative to the layer, or to the package.
        let folder = anchor.rsplit_once('/').map_or("", |(folder, _)| folder);
        let files = self.package(package)?;
        let paths = [inside(folder, uri), inside("", uri)];
        match paths.iter().flatten().find(|path| files.file(path).is_some()) {
            Some(path) => Ok(joined(package, path)),
            None if paths[0].is_none() => Err(outside()),
            None => Err(missing(package, uri)),
        }
    }
}

impl Source for Files<'_> {
    fn resolve(&self, anchor: &str, asset: &str) -> Result<String, String> {
        let name = AssetSource::resolve(self, anchor, asset).map_err(first_line)?;
        if is_package(&name) {
            let package = self.package(&name).map_err(first_line)?;
            return Ok(joined(&name, &package.first));
        }
        Ok(name)
    }

    fn read(&self, name: &str) -> Result<Vec<u8>, String> {
        AssetSource::read(self, name, MAX_FILE).map_err(first_line)
    }
}

fn first_line(error: AssetError) -> String {
    error.to_string().lines().next().unwrap_or_default().to_owned()
}
