//! Who may ask: only the page itself, which was opened with the token in its address.

use std::net::SocketAddr;

use axum::http::{HeaderMap, StatusCode, header};

/// The secret in the page's address.
#[derive(Clone, Debug)]
pub(crate) struct Token(String);

impl Token {
    /// 128 random bits.
    pub(crate) fn random() -> Result<Self, getrandom::Error> {
        let mut bytes = [0; 16];
        getrandom::fill(&mut bytes)?;
        Ok(Self(bytes.map(|byte| format!("{byte:02x}")).concat()))
    }

    pub(crate) fn as_str(&self) -> &str {
        &self.0
    }

    /// In a time that does not tell where they differ.
    fn is(&self, other: &str) -> bool {
        let differences = self.0.bytes().zip(other.bytes());
        let any = differences.fold(0, |any, (a, b)| any | (a ^ b));
        self.0.len() == other.len() && any == 0
    }
}

/// Whether a request is answered; if not, why.
///
/// Another page in the same browser can send requests to any port of this machine: it does not
/// know the token, its `Origin` is another, and where a name of its own points here, so is the
/// `Host`.
pub(crate) fn check(
    path: &str,
    headers: &HeaderMap,
    token: &Token,
    at: SocketAddr,
) -> Result<(), StatusCode> {
    let hosts = [
        format!("127.0.0.1:{}", at.port()),
        format!("localhost:{}", at.port()),
    ];
    let text = |name| headers.get(name).map(|value| value.to_str().unwrap_or("?"));
    let mut host = headers.get_all(header::HOST).iter();
    let is_ours = match (text(header::HOST), host.nth(1)) {
        (Some(host), None) => hosts.iter().any(|ours| ours == host),
        _ => false,
    };
    if !is_ours {
        return Err(StatusCode::FORBIDDEN);
    }
    if let Some(origin) = text(header::ORIGIN)
        && !hosts
            .iter()
            .any(|ours| origin.strip_prefix("http://") == Some(ours))
    {
        return Err(StatusCode::FORBIDDEN);
    }
    if headers
        .get("sec-fetch-site")
        .is_some_and(|site| site != "same-origin" && site != "none")
    {
        return Err(StatusCode::FORBIDDEN);
    }
    let first = path
        .strip_prefix('/')
        .and_then(|path| path.split('/').next());
    if first.is_some_and(|first| token.is(first)) {
        Ok(())
    } else {
        Err(StatusCode::NOT_FOUND)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tokens_are_not_the_same_twice() {
        let [one, other] = [(); 2].map(|()| Token::random().expect("randomness"));
        assert_eq!(one.as_str().len(), 32);
        assert!(one.is(one.as_str()) && !one.is(other.as_str()) && !one.is(""));
    }

    #[test]
    fn only_the_page_itself_is_answered() {
        let token = Token::random().expect("randomness");
        let path = format!("/{}/scene", token.as_str());
        let at = SocketAddr::from(([127, 0, 0, 1], 4711));
        let asked = |path: &str, headers: &[(&'static str, &'static str)]| {
            let mut map = HeaderMap::new();
            for &(name, value) in headers {
                map.append(name, value.parse().expect("a header"));
            }
            check(path, &map, &token, at)
        };
        let ours = ("host", "127.0.0.1:4711");
        assert_eq!(asked(&path, &[ours]), Ok(()));
        assert_eq!(asked(&path, &[("host", "localhost:4711")]), Ok(()));
        assert_eq!(
            asked(&path, &[ours, ("origin", "http://127.0.0.1:4711")]),
            Ok(())
        );
        for headers in [
            &[][..],
            &[("host", "127.0.0.1:4712")],
            &[("host", "127.0.0.1")],
            &[("host", "evil.example:4711")],
            &[ours, ("host", "evil.example:4711")],
            &[ours, ("origin", "http://evil.example")],
            &[ours, ("origin", "http://127.0.0.1:80")],
            &[ours, ("origin", "https://127.0.0.1:4711")],
            &[ours, ("origin", "null")],
            &[ours, ("sec-fetch-site", "cross-site")],
            &[ours, ("sec-fetch-site", "same-site")],
        ] {
            assert_eq!(
                asked(&path, headers),
                Err(StatusCode::FORBIDDEN),
                "{headers:?}"
            );
        }
        for path in [
            "/",
            "",
            "/scene",
            "//",
            "/0123456789abcdef0123456789abcdef/scene",
        ] {
            assert_eq!(asked(path, &[ours]), Err(StatusCode::NOT_FOUND), "{path}");
        }
        let longer = format!("/{}0/scene", token.as_str());
        assert_eq!(asked(&longer, &[ours]), Err(StatusCode::NOT_FOUND));
    }
}
