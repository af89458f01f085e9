//! Paths of prims and properties: `/World/Ball.radius`, `/World{look=red}Ball`.

/// The path of a child.
pub(super) fn child(parent: &str, name: &str) -> String {
    if parent.ends_with(['/', '}']) { format!("{parent}{name}") } else { format!("{parent}/{name}") }
}

/// The path of a property.
pub(super) fn property(prim: &str, name: &str) -> String {
    format!("{prim}.{name}")
}

/// The prim of a path, and its property, if it is that of one.
pub(super) fn split_property(path: &str) -> (&str, Option<&str>) {
    let start = path.rfind(['/', '}']).map_or(0, |i| i + 1);
    match path[start..].find('.') {
        Some(i) => (&path[..start + i], Some(&path[start + i + 1..])),
        None => (path, None),
    }
}

/// The last name of a path.
pub(super) fn name(path: &str) -> &str {
    path.rsplit(['/', '}']).next().unwrap_or_default()
}

/// A path as written in a prim, made absolute: `../Ball` in `/World/Box` is `/World/Ball`.
pub(super) fn resolve(prim: &str, path: &str) -> String {
    if path.starts_with('/') {
        return path.to_owned();
    }
    let mut base = without_variants(prim);
    let mut rest = path;
    loop {
        if let Some(after) = rest.strip_prefix("..") {
            base.truncate(base.rfind('/').unwrap_or(0));
            rest = after.strip_prefix('/').unwrap_or(after);
        } else if let Some(after) = rest.strip_prefix("./") {
            rest = after;
        } else {
            break;
        }
    }
    if rest.is_empty() || rest == "." {
        return if base.is_empty() { "/".to_owned() } else { base };
    }
    if rest.starts_with('.') {
        return format!("{base}{rest}");
    }
    if base == "/" {
        base.clear();
    }
    format!("{base}/{rest}")
}

/// A path without its variant selections: `/A{v=x}B` is `/A/B`.
pub(super) fn without_variants(path: &str) -> String {
    if !path.contains('{') {
        return path.to_owned();
    }
    let mut out = String::with_capacity(path.len());
    let mut rest = path;
    while let Some(open) = rest.find('{') {
        out += &rest[..open];
        let after = rest[open..].find('}').map_or("", |close| &rest[open + close + 1..]);
        if !after.is_empty() && !after.starts_with(['/', '{', '.']) {
            out.push('/');
        }
        rest = after;
    }
    out + rest
}

/// `path` with the prefix `from` replaced by `to`; `None` if it does not begin with it.
pub(super) fn moved(path: &str, from: &str, to: &str) -> Option<String> {
    let rest = if from == "/" { path.strip_prefix('/')? } else { path.strip_prefix(from)? };
    if from == "/" {
        return Some(if rest.is_empty() { to.to_owned() } else { child(to, rest) });
    }
    match rest.chars().next() {
        None => Some(to.to_owned()),
        Some('/') if to == "/" => Some(rest.to_owned()),
        Some('/') if to.ends_with('}') => Some(format!("{to}{}", &rest[1..])),
        Some('/' | '.' | '{') => Some(format!("{to}{rest}")),
        // A child of a variant: `/A{v=x}B`.
        Some(_) if from.ends_with('}') => Some(child(to, rest)),
        Some(_) => None,
    }
}
