//! REST under `/v1`, live events and a page to look at. Speaks to the farm through its handle only.
//!
//! | file | what |
//! |---|---|
//! | [`problem`] | every error answer, `application/problem+json` |
//! | `ranges` | parts of pictures |
//! | [`preferences`] | headers by which programs say how to be served |
//! | [`extract`] | path, query and body of a request, with errors as problems |
//! | [`security_headers`] | what every answer tells browsers not to do |
//! | [`guard`] | who may use which endpoint |
//! | [`session`], [`provider_login`], [`members`] | who one is; users and tokens |
//! | [`scenes`], [`jobs`], [`job_control`], [`sequences`], [`images`], [`maps`], [`pixels`], [`layout`], [`history`], [`events`], [`methods`], [`workers`], [`webhooks`], [`metrics`] | the endpoints |
//! | [`standby`] | what is answered while another coordinator leads |
//! | [`openapi`], [`schemas`] | the description of all this, generated from the handlers |

pub(crate) mod dashboard;
pub(crate) mod events;
pub(crate) mod extract;
pub(crate) mod guard;
pub(crate) mod history;
pub(crate) mod images;
pub(crate) mod job_control;
pub(crate) mod jobs;
mod json_answer;
pub(crate) mod layout;
pub(crate) mod maps;
pub(crate) mod members;
pub(crate) mod methods;
pub(crate) mod metrics;
pub(crate) mod openapi;
pub(crate) mod pixels;
pub(crate) mod preferences;
pub(crate) mod problem;
pub(crate) mod provider_login;
mod ranges;
pub(crate) mod scenes;
pub(crate) mod schemas;
pub(crate) mod security_headers;
pub(crate) mod sequences;
pub(crate) mod session;
pub(crate) mod standby;
mod unique_keys;
pub(crate) mod webhooks;
pub(crate) mod workers;

use axum::extract::{DefaultBodyLimit, Request, State};
use axum::middleware::{Next, from_fn_with_state, map_response};
use axum::response::Response;
use axum::{Extension, Router};
use tokio_util::sync::CancellationToken;
use utoipa::OpenApi;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use crate::farm::http::visitor;
use crate::farm::{CoordinatorHandle, Limits};
use pixels::PixelCache;
use problem::Problem;

/// What the endpoints share.
#[derive(Clone)]
pub struct ApiState {
    /// The door to the coordinator.
    pub coordinator: CoordinatorHandle,
    /// Cancelled when the server stops; ends event streams, which would otherwise go on as long as their jobs.
    pub shutdown: CancellationToken,
}

/// Bytes of a body that is neither a scene nor a job.
const SMALL_BODY: usize = 1 << 16;

/// The API and the dashboard, without the workers' protocol.
pub fn router(state: ApiState) -> Router {
    let limits = state.coordinator.limits();
    let (router, description) = described_routes(&state, limits).split_for_parts();
    Router::new()
        .merge(router.with_state(state.clone()))
        .merge(openapi::routes(openapi::with_problems(description)))
        .merge(dashboard::routes())
        .fallback(problem::not_found)
        .method_not_allowed_fallback(problem::method_not_allowed)
        .layer(from_fn_with_state(state, refuse_strangers))
        .layer(map_response(security_headers::add))
}

/// Nobody's web page changes anything here, or reads it under a name that was pointed here.
async fn refuse_strangers(State(state): State<ApiState>, request: Request, next: Next) -> Result<Response, Problem> {
    visitor::check(request.method(), request.uri(), request.headers(), state.coordinator.host_names())?;
    Ok(next.run(request).await)
}

fn described_routes(state: &ApiState, limits: &Limits) -> OpenApiRouter<ApiState> {
    let bytes = |limit: u64| DefaultBodyLimit::max(usize::try_from(limit).unwrap_or(usize::MAX));
    let uploads = OpenApiRouter::new()
        .routes(routes!(scenes::list_scenes, scenes::upload_scene))
        .layer(bytes(limits.scene_bytes));
    let submissions = OpenApiRouter::new()
        .routes(routes!(jobs::list_jobs, jobs::submit_job))
        .routes(routes!(jobs::validate_job))
        .routes(routes!(sequences::list_sequences, sequences::submit_sequence))
        .layer(bytes(limits.job_bytes));
    let version_1 = OpenApiRouter::new()
        .merge(uploads)
        .merge(submissions)
        .routes(routes!(scenes::show_scene, scenes::delete_scene))
        .routes(routes!(jobs::show_job, job_control::change_job, job_control::delete_job))
        .routes(routes!(job_control::pause_job))
        .routes(routes!(job_control::resume_job))
        .routes(routes!(job_control::extend_job))
        .routes(routes!(job_control::clone_job))
        .routes(routes!(jobs::cancel_job))
        .routes(routes!(sequences::show_sequence, sequences::delete_sequence))
        .routes(routes!(sequences::pause_sequence))
        .routes(routes!(sequences::resume_sequence))
        .routes(routes!(sequences::cancel_sequence))
        .routes(routes!(events::job_events))
        .routes(routes!(events::all_events))
        .merge(images::display::routes())
        .routes(routes!(images::image_exr))
        .routes(routes!(images::chart_svg))
        .routes(routes!(history::history))
        .routes(routes!(layout::layout))
        .merge(OpenApiRouter::new().routes(routes!(pixels::pixels)).layer(Extension(PixelCache::default())))
        .routes(routes!(maps::map_png))
        .routes(routes!(maps::map_svg))
        .routes(routes!(methods::list_methods))
        .routes(routes!(workers::list_workers))
        .routes(routes!(workers::journal))
        .routes(routes!(workers::limits))
        .route_layer(from_fn_with_state(state.clone(), guard::read_or_submit))
        .merge(member_routes(state))
        .routes(routes!(provider_login::ways_to_log_in, session::log_in, session::log_out))
        .routes(routes!(provider_login::leave_for_provider))
        .routes(routes!(provider_login::return_from_provider))
        .layer(DefaultBodyLimit::max(SMALL_BODY));
    let watched = OpenApiRouter::new()
        .routes(routes!(metrics::metrics))
        .route_layer(from_fn_with_state(state.clone(), guard::users));
    OpenApiRouter::with_openapi(openapi::Description::openapi())
        .merge(watched)
        .routes(routes!(workers::health))
        .routes(routes!(workers::readiness))
        .routes(routes!(workers::version))
        .nest("/v1", version_1)
}

fn member_routes(state: &ApiState) -> OpenApiRouter<ApiState> {
    let for_users = OpenApiRouter::new()
        .routes(routes!(session::who_am_i))
        .routes(routes!(members::list_tokens, members::make_token))
        .routes(routes!(members::revoke_token))
        .route_layer(from_fn_with_state(state.clone(), guard::users));
    let for_admins = OpenApiRouter::new()
        .routes(routes!(members::list_users, members::add_user))
        .routes(routes!(members::change_user, members::delete_user))
        .routes(routes!(webhooks::list_webhooks, webhooks::add_webhook))
        .routes(routes!(webhooks::delete_webhook))
        .routes(routes!(workers::drain_worker))
        .route_layer(from_fn_with_state(state.clone(), guard::admins));
    for_users.merge(for_admins)
}
