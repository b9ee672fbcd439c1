//! Requests that somebody else's web page makes a user's browser send. Browsers reach loopback and the local network, so such a page could cancel
//! jobs there although nobody outside is let in.

use std::fmt;
use std::net::{Ipv4Addr, Ipv6Addr};

use axum::http::uri::Authority;
use axum::http::{HeaderMap, Method, Uri, header};

/// Ends of names that nobody can own in the public name system: RFC 6761, RFC 6762, RFC 8375, and ICANN's reservation of `internal`.
const PRIVATE_ENDS: &[&str] = &[".localhost", ".local", ".internal", ".home.arpa"];

/// Why a request is not taken.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Stranger {
    /// It was meant for another host: a public name that was pointed here, so that a page of that name may read the answers.
    Host(String),
    /// A page of another origin sent it.
    Origin(String),
}

impl fmt::Display for Stranger {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Host(host) => write!(out, "this coordinator is not known as \"{host}\""),
            Self::Origin(origin) => write!(out, "a page of {origin} may not change anything here"),
        }
    }
}

impl Stranger {
    /// What to do about it.
    pub(crate) fn remedy(&self) -> &'static str {
        match self {
            Self::Host(_) => "use its address, or start it with --host-name and this name",
            Self::Origin(_) => "use the coordinator's own page, the command line or a program",
        }
    }
}

/// Lets requests pass that are meant for this host, and changes only from pages of it. Programs that are no browsers send no origin.
///
/// `names` are those by which the coordinator is called beside addresses, names without dots, and names that nobody can own publicly.
pub(crate) fn check(method: &Method, uri: &Uri, headers: &HeaderMap, names: &[String]) -> Result<(), Stranger> {
    let text = |name: &str| headers.get(name).map(|value| String::from_utf8_lossy(value.as_bytes()).into_owned());
    let host = text("host").or_else(|| uri.authority().map(ToString::to_string));
    for host in host.iter().cloned().chain(uri.authority().map(ToString::to_string)) {
        if !is_ours(&host, names) {
            return Err(Stranger::Host(host));
        }
    }
    if [Method::GET, Method::HEAD, Method::OPTIONS].contains(method) {
        return Ok(());
    }
    if let Some(origin) = text(header::ORIGIN.as_str()) {
        let is_own = origin.split_once("://").zip(host).is_some_and(|((_, from), to)| from.eq_ignore_ascii_case(&to));
        if !is_own {
            return Err(Stranger::Origin(origin));
        }
    }
    match text("sec-fetch-site").as_deref() {
        None | Some("same-origin" | "none") => Ok(()),
        Some(site) => Err(Stranger::Origin(format!("another place ({site})"))),
    }
}

fn is_ours(host: &str, names: &[String]) -> bool {
    let Ok(authority) = host.parse::<Authority>() else { return false };
    let name = authority.host().trim_end_matches('.').to_ascii_lowercase();
    let is_address = name.parse::<Ipv4Addr>().is_ok()
        || name.trim_start_matches('[').trim_end_matches(']').parse::<Ipv6Addr>().is_ok();
    let is_private = !name.contains('.') || PRIVATE_ENDS.iter().any(|end| name.ends_with(end));
    is_address || is_private || names.iter().any(|known| known.eq_ignore_ascii_case(&name))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checked(method: Method, headers: &[(&'static str, &str)]) -> Result<(), Stranger> {
        let headers =
            headers.iter().map(|(name, value)| (name.parse().expect("a name"), value.parse().expect("a value")));
        check(&method, &Uri::from_static("/v1/jobs"), &headers.collect(), &["farm.example".to_owned()])
    }

    #[test]
    fn hosts_are_those_that_no_stranger_can_own() {
        let ours = [
            "127.0.0.1:8080",
            "[::1]:8080",
            "10.1.2.3",
            "localhost:80",
            "coordinator",
            "FARM.example:8080",
            "farm.example.",
        ];
        for host in ours.into_iter().chain(["a.b.svc.cluster.local", "studio.internal"]) {
            assert_eq!(checked(Method::GET, &[("host", host)]), Ok(()), "{host}");
        }
        for host in
            ["evil.example", "farm.example.evil.org:8080", "127.0.0.1.evil.org", "local.evil.org", "a b", "@", ""]
        {
            assert_eq!(checked(Method::GET, &[("host", host)]), Err(Stranger::Host(host.to_owned())), "{host}");
        }
    }

    #[test]
    fn changes_come_from_our_own_pages_or_from_programs() {
        let host = ("host", "localhost:8080");
        assert_eq!(checked(Method::POST, &[host]), Ok(()));
        assert_eq!(checked(Method::POST, &[host, ("origin", "http://localhost:8080")]), Ok(()));
        assert_eq!(checked(Method::POST, &[host, ("sec-fetch-site", "same-origin")]), Ok(()));
        assert_eq!(checked(Method::GET, &[host, ("origin", "https://evil.example")]), Ok(()));
        for origin in ["https://evil.example", "http://localhost:8081", "null", ""] {
            assert!(checked(Method::DELETE, &[host, ("origin", origin)]).is_err(), "{origin}");
        }
        for site in ["cross-site", "same-site"] {
            assert!(checked(Method::POST, &[host, ("sec-fetch-site", site)]).is_err(), "{site}");
        }
    }
}
