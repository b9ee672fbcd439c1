//! What every answer tells browsers not to do: guess types, keep answers, run or load anything from elsewhere, stand in a frame.

use axum::http::{HeaderName, HeaderValue, header};
use axum::response::Response;

/// The page's own script, style, pictures and requests, and nothing else.
const PAGE: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self'; \
                    base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
/// Drawings hold their style in themselves.
const DRAWING: &str = "default-src 'none'; style-src 'unsafe-inline'; frame-ancestors 'none'";

/// Adds these headers to an answer.
pub(crate) async fn add(mut response: Response) -> Response {
    let headers = response.headers_mut();
    let is_drawing = headers.get(header::CONTENT_TYPE).is_some_and(|kind| kind.as_bytes().starts_with(b"image/svg"));
    let fixed: [(HeaderName, &str); 6] = [
        (header::CONTENT_SECURITY_POLICY, if is_drawing { DRAWING } else { PAGE }),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::X_FRAME_OPTIONS, "DENY"),
        (header::REFERRER_POLICY, "no-referrer"),
        (HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
        (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
    ];
    for (name, value) in fixed {
        headers.insert(name, HeaderValue::from_static(value));
    }
    // What has a tag may be kept and asked for again; it is its owner's alone.
    let may_keep = headers.contains_key(header::ETAG);
    let keeping = if may_keep { "private, no-cache" } else { "no-store" };
    headers.entry(header::CACHE_CONTROL).or_insert(HeaderValue::from_static(keeping));
    response
}
