//! Limits on the files that a scene may read and on its memory: options, and defaults of the machine.

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use turner::schema::{Limits, Memory};

/// Limits for untrusted scene files. An error names the option that raises the limit.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct LimitArgs {
    /// Also allow the scene to read files in this folder (repeatable)
    #[arg(long, value_name = "DIR")]
    pub(crate) allow_path: Vec<PathBuf>,
    /// Allow the scene to read files anywhere
    #[arg(long)]
    pub(crate) allow_outside: bool,
    /// Memory limit, e.g. 4G or 500M [default: four fifths of the machine's memory]
    #[arg(long, value_name = "SIZE", value_parser = parse_size)]
    max_memory: Option<u64>,
    /// Longest side of a texture image; larger images are halved until they fit
    #[arg(long, value_name = "PIXELS", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) max_texture_size: Option<u32>,
    /// Limit on the triangles of all meshes, each mesh counted once
    #[arg(long, value_name = "N", value_parser = parse_count)]
    max_triangles: Option<u64>,
}

/// Smallest memory limit, for the program and its threads.
const LEAST: u64 = 32 << 20;

impl LimitArgs {
    /// These limits for the scene of a checkpoint, which records the size of textures only.
    pub(crate) fn with_textures_of(&self, recorded: &LimitArgs) -> LimitArgs {
        LimitArgs { max_texture_size: recorded.max_texture_size, ..self.clone() }
    }

    /// A limit of memory alone.
    pub(crate) fn of_memory(max_memory: Option<u64>) -> LimitArgs {
        LimitArgs { max_memory, ..LimitArgs::default() }
    }

    /// The given limits, otherwise those of the machine.
    pub(crate) fn limits(&self) -> Limits {
        let memory = match self.max_memory.or_else(default_memory) {
            Some(limit) => Memory::new(limit, resident),
            None => Memory::default(),
        };
        Limits { memory: Arc::new(memory), max_triangles: self.max_triangles.unwrap_or(u64::MAX) }
    }
}

/// The limits of the machine, for commands without these options.
pub fn of_machine() -> Limits {
    LimitArgs::default().limits()
}

/// A number of bytes: `500M`, `4G`, `1.5GiB`, `2000000`. Letters are powers of 1024.
pub(crate) fn parse_size(text: &str) -> Result<u64, String> {
    let expected = || "expected a size such as 4G or 500M".to_owned();
    let lower = text.trim().to_ascii_lowercase();
    let digits = lower.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let shift = match lower.get(digits.len()..).unwrap_or_default() {
        "" | "b" => 0,
        "k" | "kb" | "kib" => 10,
        "m" | "mb" | "mib" => 20,
        "g" | "gb" | "gib" => 30,
        "t" | "tb" | "tib" => 40,
        _ => return Err(expected()),
    };
    let number: f64 = digits.parse().map_err(|_| expected())?;
    let bytes = number * (1u64 << shift) as f64;
    if bytes.is_nan() || bytes < LEAST as f64 {
        return Err(format!("expected at least {}M", LEAST >> 20));
    }
    if bytes >= u64::MAX as f64 { Err(expected()) } else { Ok(bytes as u64) }
}

/// A count: `2000000`, `20M`, `1.5k`. Letters are powers of 1000.
fn parse_count(text: &str) -> Result<u64, String> {
    let expected = || "expected a number such as 20000000 or 20M".to_owned();
    let lower = text.trim().to_ascii_lowercase();
    let digits = lower.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let factor = match lower.get(digits.len()..).unwrap_or_default() {
        "" => 1.0,
        "k" => 1e3,
        "m" => 1e6,
        "g" => 1e9,
        _ => return Err(expected()),
    };
    match digits.parse::<f64>() {
        Ok(n) if n >= 0.0 && n * factor < 1e18 => Ok((n * factor) as u64),
        _ => Err(expected()),
    }
}

/// Four fifths of the memory available to the process; `None` where the system does not report it.
fn default_memory() -> Option<u64> {
    let all = [machine(), control_group(), address_space()].into_iter().flatten().min()?;
    Some((all / 5 * 4).max(LEAST))
}

/// Resident memory of the process, bytes.
#[cfg(target_os = "linux")]
fn resident() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/statm").ok()?;
    let pages: u64 = text.split_ascii_whitespace().nth(1)?.parse().ok()?;
    pages.checked_mul(rustix::param::page_size() as u64)
}

#[cfg(not(target_os = "linux"))]
fn resident() -> Option<u64> {
    None
}

/// Memory of the machine, bytes.
fn machine() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|l| l.strip_prefix("MemTotal:"))?;
    line.split_ascii_whitespace().next()?.parse::<u64>().ok()?.checked_mul(1024)
}

/// The memory limit of the control group of the process and of its parents (cgroup v2 or v1), bytes.
fn control_group() -> Option<u64> {
    let number = |path: PathBuf| std::fs::read_to_string(path).ok()?.trim().parse::<u64>().ok();
    let groups = std::fs::read_to_string("/proc/self/cgroup").unwrap_or_default();
    let mut found = None;
    for line in groups.lines() {
        let mut parts = line.splitn(3, ':').skip(1);
        let (Some(kinds), Some(group)) = (parts.next(), parts.next()) else { continue };
        let (root, file) = match kinds {
            "" => ("/sys/fs/cgroup", "memory.max"),
            _ if kinds.split(',').any(|k| k == "memory") => {
                ("/sys/fs/cgroup/memory", "memory.limit_in_bytes")
            }
            _ => continue,
        };
        let mut folder = PathBuf::from(root).join(group.trim_start_matches('/'));
        while folder.starts_with(root) {
            let here = number(folder.join(file));
            found = found.into_iter().chain(here).min();
            folder.pop();
        }
    }
    found
}

/// The limit set by `ulimit -v`, bytes.
fn address_space() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/limits").ok()?;
    let line = text.lines().find_map(|l| l.strip_prefix("Max address space"))?;
    line.split_ascii_whitespace().next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_and_counts_have_suffixes() {
        assert_eq!(parse_size("4G"), Ok(4 << 30));
        assert_eq!(parse_size("500M"), Ok(500 << 20));
        assert_eq!(parse_size("1.5GiB"), Ok(3 << 29));
        assert_eq!(parse_size("100000000"), Ok(100_000_000));
        for bad in ["", "G", "-4G", "4X", "1M", "nan", "inf", "1e30G", "4 gigs"] {
            assert!(parse_size(bad).is_err(), "{bad}");
        }
        assert_eq!(parse_count("20M"), Ok(20_000_000));
        assert_eq!(parse_count("0"), Ok(0));
        for bad in ["", "-1", "many", "1e19", "nan"] {
            assert!(parse_count(bad).is_err(), "{bad}");
        }
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn the_machine_reports_its_memory() {
        let (limit, used) = (default_memory().unwrap(), resident().unwrap());
        assert!(used > 1 << 20 && used < machine().unwrap(), "{used}");
        assert!(limit <= machine().unwrap() / 5 * 4, "{limit}");
    }
}
