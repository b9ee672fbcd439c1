//! Parts of pictures (RFC 9110, 14): a download that broke off goes on where it was.

use std::ops::Bound;

use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use bytes::Bytes;
use headers::{HeaderMapExt, Range};

use super::problem::Problem;
use crate::farm::http::bearer::text;

/// A picture as an answer: whole, or the part of it that the request asks for.
pub(super) fn image(content_type: &'static str, tag: &str, bytes: Vec<u8>, request: &HeaderMap) -> Response {
    let headers = [
        (header::CONTENT_TYPE, content_type),
        (header::CACHE_CONTROL, "no-cache"),
        (header::ETAG, tag),
        (header::ACCEPT_RANGES, "bytes"),
    ];
    let length = bytes.len() as u64;
    let Some(range) = wanted_range(request, tag, length) else { return (headers, bytes).into_response() };
    // Of several ranges none is answered: whoever asks gets the whole.
    let mut ranges = range.satisfiable_ranges(length);
    let first = ranges.next().and_then(|(start, end)| Some((first_byte(start)?, last_byte(end, length)?)));
    if ranges.next().is_some() {
        return (headers, bytes).into_response();
    }
    match first.filter(|(start, end)| start <= end) {
        Some((start, end)) => {
            let part = Bytes::from(bytes).slice(start as usize..=end as usize);
            let place = [(header::CONTENT_RANGE, format!("bytes {start}-{end}/{length}"))];
            (StatusCode::PARTIAL_CONTENT, headers, place, part).into_response()
        }
        None => {
            let problem =
                Problem::new(StatusCode::RANGE_NOT_SATISFIABLE, "bad-range", format!("there are {length} bytes"));
            let place = [(header::CONTENT_RANGE, format!("bytes */{length}"))];
            (place, problem.remedy("ask for a part of them")).into_response()
        }
    }
}

fn first_byte(bound: Bound<u64>) -> Option<u64> {
    match bound {
        Bound::Included(start) => Some(start),
        Bound::Excluded(before) => before.checked_add(1),
        Bound::Unbounded => Some(0),
    }
}

fn last_byte(bound: Bound<u64>, length: u64) -> Option<u64> {
    let last = length.checked_sub(1)?;
    match bound {
        Bound::Included(end) => Some(end.min(last)),
        Bound::Excluded(after) => after.checked_sub(1).map(|end| end.min(last)),
        Bound::Unbounded => Some(last),
    }
}

/// The range that a request asks for, unless it means another picture than this, or the end of it by more bytes than there are: that is all of it.
fn wanted_range(request: &HeaderMap, tag: &str, length: u64) -> Option<Range> {
    let means_this = text(request, header::IF_RANGE).is_none_or(|wanted| wanted == tag);
    let suffix =
        text(request, header::RANGE).and_then(|range| range.trim().strip_prefix("bytes=-")?.parse::<u64>().ok());
    let means_all = suffix.is_some_and(|suffix| suffix >= length);
    request.typed_get::<Range>().filter(|_| means_this && !means_all)
}
