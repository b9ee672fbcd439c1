//! A page for people: the jobs, their progress and their pictures, live.

use axum::Router;
use axum::http::header;
use axum::response::IntoResponse;
use axum::routing::get;

/// The page and its parts; it reads the API itself and loads nothing else.
pub fn routes() -> Router {
    let file = |media_type: &'static str, text: &'static str| {
        get(move || async move { ([(header::CONTENT_TYPE, media_type)], text).into_response() })
    };
    Router::new()
        .route("/", file("text/html; charset=utf-8", include_str!("dashboard/page.html")))
        .route("/page.css", file("text/css; charset=utf-8", include_str!("dashboard/page.css")))
        .route("/page.js", file("text/javascript; charset=utf-8", include_str!("dashboard/page.js")))
}
