//! A page for people: the jobs, their progress and their pictures, live.

use axum::response::Html;

/// The page; it reads the API itself and loads nothing else.
pub async fn page() -> Html<&'static str> {
    Html(include_str!("dashboard.html"))
}
