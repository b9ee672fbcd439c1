//! A page for people: the jobs, their progress and their pictures, live. `docs/PAGE.md` tells what it can do and what its files are for.

use axum::Router;
use axum::http::header;
use axum::response::IntoResponse;
use axum::routing::get;

const PAGE: &str = "text/html; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";
const STYLE: &str = "text/css; charset=utf-8";
const DRAWING: &str = "image/svg+xml";

/// All files of the page but itself: where they are, below `/` and below `src/api/dashboard`, their media types, and their texts.
const FILES: &[(&str, &str, &str)] = &[
    ("page.js", SCRIPT, include_str!("dashboard/page.js")),
    ("page/charts/charts.js", SCRIPT, include_str!("dashboard/page/charts/charts.js")),
    ("page/charts/line_chart.js", SCRIPT, include_str!("dashboard/page/charts/line_chart.js")),
    ("page/charts/recorder.js", SCRIPT, include_str!("dashboard/page/charts/recorder.js")),
    ("page/connection/api.js", SCRIPT, include_str!("dashboard/page/connection/api.js")),
    ("page/connection/farm_stream.js", SCRIPT, include_str!("dashboard/page/connection/farm_stream.js")),
    ("page/connection/follow_farm.js", SCRIPT, include_str!("dashboard/page/connection/follow_farm.js")),
    ("page/connection/shared_stream.js", SCRIPT, include_str!("dashboard/page/connection/shared_stream.js")),
    ("page/elements/dialogs.js", SCRIPT, include_str!("dashboard/page/elements/dialogs.js")),
    ("page/elements/dom.js", SCRIPT, include_str!("dashboard/page/elements/dom.js")),
    ("page/elements/lists.js", SCRIPT, include_str!("dashboard/page/elements/lists.js")),
    ("page/elements/numbers.js", SCRIPT, include_str!("dashboard/page/elements/numbers.js")),
    ("page/elements/problem_note.js", SCRIPT, include_str!("dashboard/page/elements/problem_note.js")),
    ("page/elements/tabs.js", SCRIPT, include_str!("dashboard/page/elements/tabs.js")),
    ("page/icon.svg", DRAWING, include_str!("dashboard/page/icon.svg")),
    ("page/jobs/actions.js", SCRIPT, include_str!("dashboard/page/jobs/actions.js")),
    ("page/jobs/details.js", SCRIPT, include_str!("dashboard/page/jobs/details.js")),
    ("page/jobs/job_head.js", SCRIPT, include_str!("dashboard/page/jobs/job_head.js")),
    ("page/jobs/journal.js", SCRIPT, include_str!("dashboard/page/jobs/journal.js")),
    ("page/jobs/list.js", SCRIPT, include_str!("dashboard/page/jobs/list.js")),
    ("page/jobs/progress.js", SCRIPT, include_str!("dashboard/page/jobs/progress.js")),
    ("page/jobs/row.js", SCRIPT, include_str!("dashboard/page/jobs/row.js")),
    ("page/jobs/selection.js", SCRIPT, include_str!("dashboard/page/jobs/selection.js")),
    ("page/jobs/thumbnails.js", SCRIPT, include_str!("dashboard/page/jobs/thumbnails.js")),
    ("page/login.js", SCRIPT, include_str!("dashboard/page/login.js")),
    ("page/paths/draw_paths.js", SCRIPT, include_str!("dashboard/page/paths/draw_paths.js")),
    ("page/paths/light_paths.js", SCRIPT, include_str!("dashboard/page/paths/light_paths.js")),
    ("page/paths/path_list.js", SCRIPT, include_str!("dashboard/page/paths/path_list.js")),
    ("page/paths/paths_panel.js", SCRIPT, include_str!("dashboard/page/paths/paths_panel.js")),
    ("page/paths/projection.js", SCRIPT, include_str!("dashboard/page/paths/projection.js")),
    ("page/paths/render_paths.js", SCRIPT, include_str!("dashboard/page/paths/render_paths.js")),
    ("page/paths/scene_layout.js", SCRIPT, include_str!("dashboard/page/paths/scene_layout.js")),
    ("page/sequences/frame_cells.js", SCRIPT, include_str!("dashboard/page/sequences/frame_cells.js")),
    ("page/sequences/sequences.js", SCRIPT, include_str!("dashboard/page/sequences/sequences.js")),
    ("page/store.js", SCRIPT, include_str!("dashboard/page/store.js")),
    ("page/style/forms.css", STYLE, include_str!("dashboard/page/style/forms.css")),
    ("page/style/jobs.css", STYLE, include_str!("dashboard/page/style/jobs.css")),
    ("page/style/layout.css", STYLE, include_str!("dashboard/page/style/layout.css")),
    ("page/style/paths.css", STYLE, include_str!("dashboard/page/style/paths.css")),
    ("page/style/sequences.css", STYLE, include_str!("dashboard/page/style/sequences.css")),
    ("page/style/theme.css", STYLE, include_str!("dashboard/page/style/theme.css")),
    ("page/style/viewer.css", STYLE, include_str!("dashboard/page/style/viewer.css")),
    ("page/submit/form.js", SCRIPT, include_str!("dashboard/page/submit/form.js")),
    ("page/submit/method_fields.js", SCRIPT, include_str!("dashboard/page/submit/method_fields.js")),
    ("page/submit/scene_files.js", SCRIPT, include_str!("dashboard/page/submit/scene_files.js")),
    ("page/submit/sequence_fields.js", SCRIPT, include_str!("dashboard/page/submit/sequence_fields.js")),
    ("page/submit/stop_fields.js", SCRIPT, include_str!("dashboard/page/submit/stop_fields.js")),
    ("page/submit/submit.js", SCRIPT, include_str!("dashboard/page/submit/submit.js")),
    ("page/submit/tags.js", SCRIPT, include_str!("dashboard/page/submit/tags.js")),
    ("page/submit/upload.js", SCRIPT, include_str!("dashboard/page/submit/upload.js")),
    ("page/submit/zip.js", SCRIPT, include_str!("dashboard/page/submit/zip.js")),
    ("page/viewer/actions.js", SCRIPT, include_str!("dashboard/page/viewer/actions.js")),
    ("page/viewer/budget.js", SCRIPT, include_str!("dashboard/page/viewer/budget.js")),
    ("page/viewer/comparison.js", SCRIPT, include_str!("dashboard/page/viewer/comparison.js")),
    ("page/viewer/controls.js", SCRIPT, include_str!("dashboard/page/viewer/controls.js")),
    ("page/viewer/draw.js", SCRIPT, include_str!("dashboard/page/viewer/draw.js")),
    ("page/viewer/geometry.js", SCRIPT, include_str!("dashboard/page/viewer/geometry.js")),
    ("page/viewer/half.js", SCRIPT, include_str!("dashboard/page/viewer/half.js")),
    ("page/viewer/histogram_view.js", SCRIPT, include_str!("dashboard/page/viewer/histogram_view.js")),
    ("page/viewer/keys.js", SCRIPT, include_str!("dashboard/page/viewer/keys.js")),
    ("page/viewer/layers.js", SCRIPT, include_str!("dashboard/page/viewer/layers.js")),
    ("page/viewer/light_groups.js", SCRIPT, include_str!("dashboard/page/viewer/light_groups.js")),
    ("page/viewer/look.js", SCRIPT, include_str!("dashboard/page/viewer/look.js")),
    ("page/viewer/paint.js", SCRIPT, include_str!("dashboard/page/viewer/paint.js")),
    ("page/viewer/palette.js", SCRIPT, include_str!("dashboard/page/viewer/palette.js")),
    ("page/viewer/picture_source.js", SCRIPT, include_str!("dashboard/page/viewer/picture_source.js")),
    ("page/viewer/pointer.js", SCRIPT, include_str!("dashboard/page/viewer/pointer.js")),
    ("page/viewer/readout.js", SCRIPT, include_str!("dashboard/page/viewer/readout.js")),
    ("page/viewer/region.js", SCRIPT, include_str!("dashboard/page/viewer/region.js")),
    ("page/viewer/statistics.js", SCRIPT, include_str!("dashboard/page/viewer/statistics.js")),
    ("page/viewer/tile_painter.js", SCRIPT, include_str!("dashboard/page/viewer/tile_painter.js")),
    ("page/viewer/tone.js", SCRIPT, include_str!("dashboard/page/viewer/tone.js")),
    ("page/viewer/viewer.js", SCRIPT, include_str!("dashboard/page/viewer/viewer.js")),
    ("page/workers/workers.js", SCRIPT, include_str!("dashboard/page/workers/workers.js")),
];

/// The page and its parts; it reads the API itself and loads nothing else.
pub(crate) fn routes() -> Router {
    let file = |media_type: &'static str, text: &'static str| {
        get(move || async move { ([(header::CONTENT_TYPE, media_type)], text).into_response() })
    };
    let page = Router::new().route("/", file(PAGE, include_str!("dashboard/page.html")));
    FILES
        .iter()
        .fold(page, |router, (path, media_type, text)| router.route(&format!("/{path}"), file(media_type, text)))
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::{Path, PathBuf};

    use super::*;

    fn files_below(folder: &Path) -> Vec<PathBuf> {
        let entries = fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
        entries.flat_map(|path| if path.is_dir() { files_below(&path) } else { vec![path] }).collect()
    }

    #[test]
    fn every_file_of_the_page_is_served() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/api/dashboard");
        let below = |path: &PathBuf| path.strip_prefix(&folder).expect("below").to_string_lossy().replace('\\', "/");
        let mut there: Vec<String> =
            files_below(&folder).iter().map(below).filter(|name| name != "page.html").collect();
        there.sort();
        let mut served: Vec<&str> = FILES.iter().map(|(path, ..)| *path).collect();
        served.sort_unstable();
        assert_eq!(served, there);
    }
}
