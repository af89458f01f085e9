//! Which requests are answered: those to an address of this machine, from a page of this server.
//!
//! A web page of another site may send requests to this machine. Its name can be made to point here (DNS rebinding), so
//! the name that the browser asked for must be one of the machine itself; a socket must come from the same origin.

use std::net::IpAddr;

/// Why a request is refused: the text of the answer.
pub(crate) type Refusal = String;

/// The host of `name:port`, without the port and the brackets of an IPv6 address.
fn host_of(authority: &str) -> &str {
    if let Some(rest) = authority.strip_prefix('[') {
        return rest.split(']').next().unwrap_or_default();
    }
    match authority.rsplit_once(':') {
        Some((host, port)) if port.bytes().all(|b| b.is_ascii_digit()) => host,
        _ => authority,
    }
}

/// Checks the header `Host` of a request that arrived at the address `local`. `names` are further names of the machine.
/// Any port will do: tunnels have others.
pub(crate) fn check_host(host: &str, local: IpAddr, names: &[String]) -> Result<(), Refusal> {
    let name = host_of(host);
    let is_own = |ip: IpAddr| ip.is_loopback() || ip.to_canonical() == local.to_canonical();
    let is_known = name.eq_ignore_ascii_case("localhost")
        || name.parse().is_ok_and(is_own)
        || names.iter().any(|own| own.eq_ignore_ascii_case(name));
    if is_known {
        return Ok(());
    }
    Err(format!(
        "this server does not answer to the name \"{}\"\nuse localhost or its IP address, or start it with --host NAME\n",
        printable(name)
    ))
}

/// Checks the header `Origin` of a socket: it must be the page of the same host.
pub(crate) fn check_origin(origin: Option<&str>, host: &str) -> Result<(), Refusal> {
    // A proxy may speak https.
    let own = |origin: &str| {
        let rest = origin.strip_prefix("http://").or_else(|| origin.strip_prefix("https://"));
        rest.is_some_and(|rest| rest.eq_ignore_ascii_case(host))
    };
    match origin {
        Some(origin) if own(origin) => Ok(()),
        Some(origin) => Err(format!("a page of {} may not connect to this server\n", printable(origin))),
        None => Err("a socket must state its origin\n".to_owned()),
    }
}

/// A text of a request for an answer.
fn printable(text: &str) -> String {
    text.chars().filter(|c| !c.is_control()).take(100).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hosts_are_the_machine_itself() {
        let local: IpAddr = "192.168.1.7".parse().unwrap();
        let names = ["lab7.example.org".to_owned()];
        let check = |host: &str| check_host(host, local, &names).is_ok();
        let good = [
            "localhost:80",
            "127.0.0.1:7373",
            "[::1]:9000",
            "192.168.1.7:7373",
            "LAB7.example.org",
            "localhost",
        ];
        assert!(good.iter().all(|host| check(host)));
        let bad = [
            "evil.example",
            "192.168.1.8:7373",
            "localhost.evil.example",
            "",
            "127.0.0.1.evil:80",
            "[::1",
            "[]",
        ];
        for host in bad {
            // An address without its last bracket is still this machine.
            assert_eq!(check(host), host == "[::1", "{host}");
        }
    }

    #[test]
    fn origins_are_the_page_itself() {
        assert!(check_origin(Some("http://localhost:7373"), "localhost:7373").is_ok());
        assert!(check_origin(Some("https://lab7.example.org"), "lab7.example.org").is_ok());
        for bad in
            ["http://localhost:7374", "http://evil.example", "null", "", "file://", "http://localhost:7373/x"]
        {
            assert!(check_origin(Some(bad), "localhost:7373").is_err(), "{bad}");
        }
        assert!(check_origin(None, "localhost:7373").is_err());
    }
}
