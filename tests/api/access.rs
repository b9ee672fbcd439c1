//! Who may do what over real HTTP, for every endpoint that the API's own description names.

use std::time::Duration;

use crate::http_client::http_client;
use photonfarm::api;
use photonfarm::farm::store::{Store, StoreLocation};
use photonfarm::farm::{CoordinatorOptions, Limits, LocalFarm, UserLimits};
use reqwest::{Method, RequestBuilder};
use serde_json::{Value, json};

const SCENE: &str = include_str!("../references/furnace-closed/scene.xml");

struct Farm {
    base: String,
    http: reqwest::Client,
    local: LocalFarm,
}

/// A token, or none.
type Token<'a> = Option<&'a str>;

impl Farm {
    async fn start(store: Store) -> Self {
        Self::start_with(store, Limits::default()).await
    }

    async fn start_with(store: Store, limits: Limits) -> Self {
        let routes = |coordinator, shutdown| api::router(api::ApiState { coordinator, shutdown });
        let options = CoordinatorOptions { limits, ..CoordinatorOptions::default() };
        let builder = LocalFarm::builder().workers(0).options(options).store(store);
        let local = builder.routes(routes).start().await.expect("a farm");
        Self { base: local.url(), http: http_client(Duration::from_secs(60)), local }
    }

    fn request(&self, method: Method, path: &str, token: Token<'_>) -> RequestBuilder {
        let request = self.http.request(method, format!("{}{path}", self.base));
        if let Some(token) = token { request.bearer_auth(token) } else { request }
    }

    async fn status(&self, method: Method, path: &str, token: Token<'_>) -> u16 {
        // No body: whoever is let in gets 4xx for that, but not for who they are.
        let request = self.request(method, path, token).header("Content-Type", "application/json");
        request.send().await.expect("an answer").status().as_u16()
    }

    async fn json(&self, method: Method, path: &str, token: Token<'_>, body: Value) -> (u16, Value) {
        let request = self.request(method, path, token).header("Content-Type", "application/json");
        let response = request.body(body.to_string()).send().await.expect("an answer");
        let status = response.status().as_u16();
        (status, serde_json::from_slice(&response.bytes().await.expect("a body")).unwrap_or_default())
    }

    async fn add(&self, admin: Token<'_>, name: &str, role: &str) -> String {
        let (status, added) = self.json(Method::POST, "/v1/users", admin, json!({ "name": name, "role": role })).await;
        assert_eq!(status, 201, "{added}");
        added["token"]["secret"].as_str().expect("a secret").to_owned()
    }

    async fn submit(&self, token: Token<'_>) -> (u16, Value) {
        let job = json!({ "scene_inline": SCENE, "stop": { "passes": 5 } });
        self.json(Method::POST, "/v1/jobs", token, job).await
    }
}

async fn farm() -> Farm {
    Farm::start(Store::in_memory().await.expect("a store")).await
}

/// Every operation of the API's description, with the job and the scene that are there put into its address.
async fn operations(farm: &Farm, job: &str, sequence: &str, scene: &str) -> Vec<(Method, String)> {
    let text = farm.request(Method::GET, "/v1/openapi.json", None).send().await.expect("an answer").text().await;
    let description: Value = serde_json::from_str(&text.expect("text")).expect("JSON");
    let mut operations = Vec::new();
    for (path, methods) in description["paths"].as_object().expect("paths") {
        let id = if path.starts_with("/v1/sequences") { sequence } else { job };
        let names = [("{id}", id), ("{hash}", scene), ("{name}", "nobody")];
        let address = names.iter().fold(path.clone(), |path, (name, value)| path.replace(name, value));
        for method in methods.as_object().expect("methods").keys() {
            operations.push((method.to_uppercase().parse().expect("a method"), address.clone()));
        }
    }
    operations
}

/// What anybody may do who reaches a coordinator with users.
const PUBLIC: &[&str] = &[
    "GET /healthz",
    "GET /readyz",
    "GET /version",
    "GET /v1/session",
    "POST /v1/session",
    "DELETE /v1/session",
    "GET /v1/session/provider",
    "GET /v1/session/provider/return",
];

#[tokio::test(flavor = "multi_thread")]
async fn every_endpoint_asks_who_it_is() {
    let farm = farm().await;
    let anna = farm.add(None, "anna", "admin").await;
    let vera = farm.add(Some(&anna), "vera", "viewer").await;
    let ben = farm.add(Some(&anna), "ben", "artist").await;
    let (_, job) = farm.submit(Some(&anna)).await;
    let (job, scene) =
        (job["id"].as_str().expect("an id").to_owned(), job["scene"].as_str().expect("a scene").to_owned());
    let frames = json!({ "first": 1, "last": 3, "camera_path": ["0", "0"] });
    let sequence = json!({ "job": { "scene_inline": SCENE }, "frames": frames });
    let (_, sequence) = farm.json(Method::POST, "/v1/sequences", Some(&anna), sequence).await;
    let sequence = sequence["id"].as_str().expect("an id").to_owned();
    let operations = operations(&farm, &job, &sequence, &scene).await;
    assert!(operations.len() > 30, "{operations:?}");
    for (method, path) in operations {
        let what = format!("{method} {path}");
        if PUBLIC.contains(&what.as_str()) || what.ends_with("/events") {
            continue;
        }
        let status = async |token: Token<'static>| farm.status(method.clone(), &path, token).await;
        assert_eq!(status(None).await, 401, "{what} without a token");
        assert_eq!(status(Some("photonfarm_guessed")).await, 401, "{what} with a guessed token");
        let reads = method == Method::GET;
        let is_for_admins =
            path.starts_with("/v1/users") || path.starts_with("/v1/webhooks") || path.ends_with("/drain");
        let is_for_users = path.starts_with("/v1/tokens") || path.starts_with("/v1/me");
        let viewer = farm.status(method.clone(), &path, Some(&vera)).await;
        let is_refused = |status: u16| status == 401 || status == 403;
        assert_eq!(is_refused(viewer), is_for_admins || !(reads || is_for_users), "{what} by a viewer: {viewer}");
        let artist = farm.status(method.clone(), &path, Some(&ben)).await;
        let is_owned = path.contains(&job) || path.contains(&sequence) || path.contains(&scene);
        let is_others = !reads && is_owned && !path.ends_with("/clone");
        let is_revoked = path.starts_with("/v1/tokens/");
        assert_eq!(is_refused(artist), is_for_admins || is_others && !is_revoked, "{what} by an artist: {artist}");
        // Whoever is let in deletes it, so that comes last.
        if method != Method::DELETE {
            assert!(!is_refused(farm.status(method, &path, Some(&anna)).await), "{what} by an admin");
        }
    }
    let [job, sequence, scene] = [format!("jobs/{job}"), format!("sequences/{sequence}"), format!("scenes/{scene}")];
    for path in [job, sequence, scene, "users/vera".to_owned()] {
        let path = format!("/v1/{path}");
        assert_eq!(farm.status(Method::DELETE, &path, Some(&anna)).await, 204, "{path} by an admin");
    }
}

/// Whoever deletes a sequence deletes its frames' scenes, but none that somebody else made first.
#[tokio::test(flavor = "multi_thread")]
async fn a_sequence_takes_no_scene_of_somebody_else_along() {
    let farm = farm().await;
    let anna = farm.add(None, "anna", "admin").await;
    let ben = farm.add(Some(&anna), "ben", "artist").await;
    let cora = farm.add(Some(&anna), "cora", "artist").await;
    let path = json!({ "first": 1, "last": 1, "camera_path": ["0", "0"] });
    let sequence = json!({ "job": { "scene_inline": SCENE }, "frames": path });
    let submit = async |token: &str| farm.json(Method::POST, "/v1/sequences", Some(token), sequence.clone()).await.1;
    let [bens, coras] = [submit(&ben).await, submit(&cora).await];
    assert_eq!((&bens["owner"], &coras["owner"]), (&json!("ben"), &json!("cora")));
    let (_, jobs) = farm.json(Method::GET, "/v1/jobs", Some(&anna), Value::Null).await;
    let jobs = jobs["jobs"].as_array().expect("jobs").clone();
    assert_eq!(jobs[0]["scene"], jobs[1]["scene"]);
    // Ben's job goes first, so that only ownership keeps the scene.
    let job = format!("/v1/jobs/{}", jobs[0]["id"].as_str().expect("an id"));
    assert_eq!(farm.status(Method::DELETE, &job, Some(&ben)).await, 204);
    let coras = format!("/v1/sequences/{}", coras["id"].as_str().expect("an id"));
    assert_eq!(farm.status(Method::DELETE, &coras, Some(&ben)).await, 403);
    assert_eq!(farm.status(Method::DELETE, &coras, Some(&cora)).await, 204);
    let scene = format!("/v1/scenes/{}", jobs[0]["scene"].as_str().expect("a hash"));
    assert_eq!(farm.status(Method::GET, &scene, Some(&cora)).await, 200);
}

#[tokio::test(flavor = "multi_thread")]
async fn users_change_their_own_jobs_only() {
    let farm = farm().await;
    // Of the time before there were users.
    let (_, nobodys) = farm.submit(None).await;
    let anna = farm.add(None, "anna", "admin").await;
    let ben = farm.add(Some(&anna), "ben", "artist").await;
    let cora = farm.add(Some(&anna), "cora", "artist").await;
    let (status, job) = farm.submit(Some(&ben)).await;
    assert_eq!((status, job["owner"].as_str()), (202, Some("ben")));
    let cancel = format!("/v1/jobs/{}/cancel", job["id"].as_str().expect("an id"));
    let (status, refused) = farm.json(Method::POST, &cancel, Some(&cora), Value::Null).await;
    assert_eq!((status, refused["type"].as_str()), (403, Some("urn:photonfarm:problem:not-yours")), "{refused}");
    let old = format!("/v1/jobs/{}/cancel", nobodys["id"].as_str().expect("an id"));
    assert_eq!(farm.status(Method::POST, &old, Some(&ben)).await, 403);
    assert_eq!(farm.status(Method::POST, &old, Some(&anna)).await, 200);
    assert_eq!(farm.status(Method::POST, &cancel, Some(&ben)).await, 200);
    let clone = format!("/v1/jobs/{}/clone", job["id"].as_str().expect("an id"));
    let (status, copy) = farm.json(Method::POST, &clone, Some(&cora), json!({})).await;
    assert_eq!((status, copy["owner"].as_str()), (202, Some("cora")), "{copy}");
    let (_, own) = farm.json(Method::GET, "/v1/jobs?owner=cora", Some(&ben), Value::Null).await;
    assert_eq!(own["jobs"].as_array().map(Vec::len), Some(1));
    assert_eq!(farm.submit(None).await.0, 401);
    // A demoted user's tokens allow less at once.
    let (status, _) = farm.json(Method::PATCH, "/v1/users/cora", Some(&anna), json!({ "role": "viewer" })).await;
    assert_eq!(status, 200);
    assert_eq!(farm.submit(Some(&cora)).await.0, 403);
    assert_eq!(farm.status(Method::DELETE, "/v1/users/cora", Some(&anna)).await, 204);
    assert_eq!(farm.status(Method::GET, "/v1/jobs", Some(&cora)).await, 401);
}

/// Nobody but an admin fills the farm alone.
#[tokio::test(flavor = "multi_thread")]
async fn one_user_takes_no_more_than_their_share() {
    let user = UserLimits { live_jobs: 2, pixels: 3 * 64 * 64, scene_bytes: SCENE.len() as u64, seconds: 60.0 };
    let limits = Limits { user, ..Limits::default() };
    let farm = Farm::start_with(Store::in_memory().await.expect("a store"), limits).await;
    let anna = farm.add(None, "anna", "admin").await;
    let ben = farm.add(Some(&anna), "ben", "artist").await;
    let cora = farm.add(Some(&anna), "cora", "artist").await;
    assert_eq!([farm.submit(Some(&ben)).await.0, farm.submit(Some(&ben)).await.0], [202, 202]);
    let (status, busy) = farm.submit(Some(&ben)).await;
    assert!(status == 429 && busy["retry_after"].is_u64(), "{busy}");
    assert_eq!(farm.submit(Some(&cora)).await.0, 202, "others are not in the way");
    for _ in 0..3 {
        assert_eq!(farm.submit(Some(&anna)).await.0, 202, "an admin is not limited");
    }
    let job = |stop: Value, scene: String| json!({ "scene_inline": scene, "stop": stop });
    let post = async |body: Value| farm.json(Method::POST, "/v1/jobs", Some(&cora), body).await.0;
    assert_eq!(post(job(json!({ "seconds": 61 }), SCENE.to_owned())).await, 422);
    let large = SCENE.replace("64", "128");
    assert_eq!(post(job(json!({ "passes": 1 }), large)).await, 429, "a picture of too many pixels");
    let further = format!("{SCENE}<!-- another scene -->");
    let upload = farm.request(Method::POST, "/v1/scenes", Some(&ben)).body(further.clone());
    assert_eq!(upload.send().await.expect("an answer").status(), 429, "ben was the first to upload the scene");
    let upload = farm.request(Method::POST, "/v1/scenes", Some(&anna)).body(further);
    assert_eq!(upload.send().await.expect("an answer").status(), 201);
}

#[tokio::test(flavor = "multi_thread")]
async fn tokens_allow_no_more_than_whoever_makes_them() {
    let farm = farm().await;
    let anna = farm.add(None, "anna", "admin").await;
    let ben = farm.add(Some(&anna), "ben", "artist").await;
    let make = async |token: &str, wanted: Value| farm.json(Method::POST, "/v1/tokens", Some(token), wanted).await;
    let (status, read) = make(&ben, json!({ "scope": "read", "label": "a script", "days": 1 })).await;
    assert_eq!((status, read["user"].as_str(), read["scope"].as_str()), (201, Some("ben"), Some("read")), "{read}");
    let secret = read["secret"].as_str().expect("a secret").to_owned();
    assert_eq!(farm.submit(Some(&secret)).await.0, 403);
    assert_eq!(make(&secret, json!({ "scope": "submit" })).await.0, 403, "a token for reading makes none for more");
    assert_eq!(make(&ben, json!({ "scope": "admin" })).await.0, 422);
    assert_eq!(make(&ben, json!({ "scope": "worker" })).await.0, 403);
    assert_eq!(make(&ben, json!({ "user": "anna" })).await.0, 403);
    assert_eq!(make(&anna, json!({ "user": "nobody" })).await.0, 404);
    assert_eq!(make(&anna, json!({ "user": "ben" })).await.1["scope"], "submit");
    let (_, listed) = farm.json(Method::GET, "/v1/tokens", Some(&ben), Value::Null).await;
    let tokens = listed["tokens"].as_array().expect("a list");
    assert!(tokens.len() == 3 && tokens.iter().all(|token| token["user"] == "ben"), "{listed}");
    assert!(!listed.to_string().contains(&secret), "secrets are shown once");
    let of_anna = farm.json(Method::GET, "/v1/tokens", Some(&anna), Value::Null).await.1;
    let first = of_anna["tokens"][0]["id"].as_str().expect("an id").to_owned();
    assert_eq!(farm.status(Method::DELETE, &format!("/v1/tokens/{first}"), Some(&ben)).await, 404, "anna's");
    let id = read["id"].as_str().expect("an id");
    assert_eq!(farm.status(Method::DELETE, &format!("/v1/tokens/{id}"), Some(&ben)).await, 204);
    assert_eq!(farm.status(Method::GET, "/v1/jobs", Some(&secret)).await, 401);
}

#[tokio::test(flavor = "multi_thread")]
async fn nobody_locks_all_admins_out() {
    let farm = farm().await;
    let (status, _) = farm.json(Method::POST, "/v1/users", None, json!({ "name": "ben", "role": "artist" })).await;
    assert_eq!(status, 409, "the first user is an admin");
    let anna = farm.add(None, "anna", "admin").await;
    assert_eq!(farm.status(Method::DELETE, "/v1/users/anna", Some(&anna)).await, 409);
    let (status, _) = farm.json(Method::PATCH, "/v1/users/anna", Some(&anna), json!({ "role": "viewer" })).await;
    assert_eq!(status, 409);
    for name in ["", "Anna", "a b"] {
        let (status, _) =
            farm.json(Method::POST, "/v1/users", Some(&anna), json!({ "name": name, "role": "admin" })).await;
        assert_eq!(status, 422, "{name}");
    }
    let (status, _) =
        farm.json(Method::POST, "/v1/users", Some(&anna), json!({ "name": "anna", "role": "admin" })).await;
    assert_eq!(status, 409);
}

/// The page's cookie cannot be read by scripts or sent by other sites, and ends with the token that it came from.
#[tokio::test(flavor = "multi_thread")]
async fn a_page_logs_in_with_a_cookie() {
    let farm = farm().await;
    let anna = farm.add(None, "anna", "admin").await;
    let ben = farm.add(Some(&anna), "ben", "artist").await;
    let login = async |token: &str| {
        let request = farm.request(Method::POST, "/v1/session", None).header("Content-Type", "application/json");
        request.body(json!({ "token": token }).to_string()).send().await.expect("an answer")
    };
    assert_eq!(login("guess").await.status(), 401);
    let answer = login(&ben).await;
    let cookie = answer.headers()["set-cookie"].to_str().expect("text").to_owned();
    assert!(cookie.contains("HttpOnly") && cookie.contains("SameSite=Strict"), "{cookie}");
    let session = cookie.split(';').next().expect("a value").to_owned();
    assert!(!session.contains(&ben), "the cookie is a token of its own");
    let with_cookie = async |method: Method, path: &str, origin: Option<&str>| {
        let mut request = farm.request(method, path, None).header("Cookie", &session);
        if let Some(origin) = origin {
            request = request.header("Origin", origin);
        }
        request.send().await.expect("an answer").status().as_u16()
    };
    assert_eq!(with_cookie(Method::GET, "/v1/me", None).await, 200);
    assert_eq!(with_cookie(Method::POST, "/v1/jobs", Some("https://evil.example")).await, 403);
    let (_, tokens) = farm.json(Method::GET, "/v1/tokens", Some(&ben), Value::Null).await;
    let first = tokens["tokens"].as_array().expect("a list").iter().find(|token| token["label"] == "first");
    let path = format!("/v1/tokens/{}", first.expect("it is there")["id"].as_str().expect("an id"));
    assert_eq!(with_cookie(Method::DELETE, &path, Some(&farm.base)).await, 204);
    assert_eq!(with_cookie(Method::GET, "/v1/me", None).await, 401, "it ended with the token");
    // Logging out ends the cookie's token, and no other.
    let answer = login(&anna).await;
    let cookie = answer.headers()["set-cookie"].to_str().expect("text").split(';').next().expect("a value").to_owned();
    let out = farm.request(Method::DELETE, "/v1/session", None).header("Cookie", &cookie);
    assert_eq!(out.send().await.expect("an answer").status(), 204);
    let me = farm.request(Method::GET, "/v1/me", None).header("Cookie", &cookie);
    assert_eq!(me.send().await.expect("an answer").status(), 401);
    assert_eq!(farm.status(Method::GET, "/v1/me", Some(&anna)).await, 200);
}

#[tokio::test(flavor = "multi_thread")]
async fn users_and_tokens_outlive_the_coordinator_and_secrets_are_nowhere_in_the_store() {
    let folder = tempfile::tempdir().expect("a folder");
    let location = StoreLocation::folder(folder.path());
    let farm = Farm::start(Store::open(&location).await.expect("a store")).await;
    let anna = farm.add(None, "anna", "admin").await;
    let (_, job) = farm.submit(Some(&anna)).await;
    let id = job["id"].as_str().expect("an id").to_owned();
    farm.local.stop().await;
    for entry in std::fs::read_dir(folder.path()).expect("a folder") {
        let file = entry.expect("an entry").path();
        let bytes = if file.is_file() { std::fs::read(&file).expect("a file") } else { Vec::new() };
        let secret = anna.as_bytes();
        assert!(!bytes.windows(secret.len()).any(|window| window == secret), "{}", file.display());
    }
    let farm = Farm::start(Store::open(&location).await.expect("a store")).await;
    assert_eq!(farm.status(Method::GET, "/v1/jobs", None).await, 401);
    let (status, job) = farm.json(Method::GET, &format!("/v1/jobs/{id}"), Some(&anna), Value::Null).await;
    assert_eq!((status, job["owner"].as_str()), (200, Some("anna")));
}

/// Sessions end with the token that somebody logged in with first, whatever was made of them meanwhile, and no later than it.
#[tokio::test(flavor = "multi_thread")]
async fn nothing_made_of_a_token_outlives_it() {
    let farm = farm().await;
    let anna = farm.add(None, "anna", "admin").await;
    let login = async |token: &str| {
        let request = farm.request(Method::POST, "/v1/session", None).header("Content-Type", "application/json");
        let answer = request.body(json!({ "token": token }).to_string()).send().await.expect("an answer");
        let cookie = answer.headers()["set-cookie"].to_str().expect("text");
        cookie.split([';', '=']).nth(1).expect("a value").to_owned()
    };
    let (_, short) = farm.json(Method::POST, "/v1/tokens", Some(&anna), json!({ "days": 1, "label": "short" })).await;
    let secret = short["secret"].as_str().expect("a secret").to_owned();
    let first = login(&secret).await;
    let second = login(&first).await;
    let (status, further) = farm.json(Method::POST, "/v1/tokens", Some(&secret), json!({ "label": "further" })).await;
    assert_eq!((status, further["expires"].as_i64() <= short["expires"].as_i64()), (201, true), "{further}");
    let (_, list) = farm.json(Method::GET, "/v1/tokens", Some(&anna), Value::Null).await;
    let pages = list["tokens"].as_array().expect("a list").iter().filter(|token| token["label"] == "page");
    assert!(pages.clone().count() == 2 && pages.into_iter().all(|page| page["expires"] == short["expires"]), "{list}");
    let id = short["id"].as_str().expect("an id");
    assert_eq!(farm.status(Method::DELETE, &format!("/v1/tokens/{id}"), Some(&anna)).await, 204);
    for token in [&secret, &first, &second] {
        assert_eq!(farm.status(Method::GET, "/v1/me", Some(token)).await, 401);
    }
}

/// Who was given at start logs in to the page, too.
#[tokio::test(flavor = "multi_thread")]
async fn an_admin_given_at_start_logs_in() {
    let secret = "a".repeat(40);
    let options = CoordinatorOptions { admin_token: secret.parse().ok(), ..CoordinatorOptions::default() };
    let routes = |coordinator, shutdown| api::router(api::ApiState { coordinator, shutdown });
    let local = LocalFarm::builder().workers(0).options(options).routes(routes).start().await.expect("a farm");
    let farm = Farm { base: local.url(), http: http_client(Duration::from_secs(60)), local };
    let request = farm.request(Method::POST, "/v1/session", None).header("Content-Type", "application/json");
    let answer = request.body(json!({ "token": secret }).to_string()).send().await.expect("an answer");
    let cookie = answer.headers()["set-cookie"].to_str().expect("text").split(';').next().expect("a value").to_owned();
    let me =
        async || farm.request(Method::GET, "/v1/me", None).header("Cookie", &cookie).send().await.expect("an answer");
    assert_eq!(me().await.status(), 200);
    let out = farm.request(Method::DELETE, "/v1/session", None).header("Cookie", &cookie);
    assert_eq!(out.send().await.expect("an answer").status(), 204);
    assert_eq!(me().await.status(), 401);
}

/// The same bytes have one owner, and limits hold for many requests at once.
#[tokio::test(flavor = "multi_thread")]
async fn uploads_at_the_same_time_pass_no_limit() {
    let user = UserLimits { scene_bytes: SCENE.len() as u64 + 100, ..UserLimits::default() };
    let farm = Farm::start_with(Store::in_memory().await.expect("a store"), Limits { user, ..Limits::default() }).await;
    let anna = farm.add(None, "anna", "admin").await;
    let ben = farm.add(Some(&anna), "ben", "artist").await;
    let upload = async |token: &str, text: String| {
        let request = farm.request(Method::POST, "/v1/scenes", Some(token)).body(text);
        let response = request.send().await.expect("an answer");
        let status = response.status().as_u16();
        let scene: Value = serde_json::from_slice(&response.bytes().await.expect("a body")).unwrap_or_default();
        (status, scene["owner"].as_str().unwrap_or_default().to_owned())
    };
    let other = || format!("{SCENE}<!-- other -->");
    let (one, another) = tokio::join!(upload(&ben, SCENE.to_owned()), upload(&ben, other()));
    let mut statuses = [one.0, another.0];
    statuses.sort_unstable();
    assert_eq!(statuses, [201, 429]);
    let third = format!("{SCENE}<!-- third -->");
    let (of_anna, of_ben) = tokio::join!(upload(&anna, third.clone()), upload(&anna, third));
    assert_eq!((of_anna.1.as_str(), of_ben.1.as_str()), ("anna", "anna"));
}
