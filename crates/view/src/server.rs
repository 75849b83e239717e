//! The page and its questions, by HTTP on this machine's own address.
//!
//! | address, after the token | answer |
//! | --- | --- |
//! | `GET /`, `first.js`, `view.js`, `view.css` | the page |
//! | `GET picture/WIDTH/HEIGHT/THEME` | what is shown as the page shows it first, as PNG (`picture`) |
//! | `GET events` | what happens, as server-sent events of JSON |
//! | `GET scene` | all that is drawn (`packing`) |
//! | `GET account` | measures and report |
//! | `POST describe` `{revision, pick}` | rows of what was picked |
//! | `POST between` `{revision, picks}` | rows of distances and angles |
//! | `POST parameters` `{name: value}` | nothing; the model is made again |
//! | `GET download/FORMAT` | a file |

use std::collections::BTreeMap;
use std::convert::Infallible;
use std::net::SocketAddr;
use std::sync::mpsc::Sender;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use axum::Router;
use axum::body::{Body, Bytes};
use axum::extract::{DefaultBodyLimit, Path, Request, State};
use axum::http::{HeaderValue, StatusCode, header};
use axum::middleware::{self, Next};
use axum::response::sse::{Event, KeepAlive, Sse};
use axum::response::{IntoResponse, Json, Response};
use axum::routing::{get, post};
use csg::CancelToken;
use serde::{Deserialize, Serialize};
use tokio::net::TcpListener;
use tokio::sync::watch;
use tokio_stream::StreamExt;
use tokio_stream::wrappers::WatchStream;

use crate::guard::{self, Token};
use crate::pick::{Pick, Row};
use crate::picture::{self, Theme};
use crate::shown::Shown;
use crate::source::{Parameter, Problem};

/// The most bytes of a question: names and values of parameters are short.
const LARGEST_QUESTION: usize = 64 << 10;
/// The most pixels of a picture: a screen of 4096 by 4096.
const LARGEST_PICTURE: u64 = 1 << 24;
/// How long the page waits for the model that its first picture is of.
const PATIENCE: Duration = Duration::from_millis(200);

/// What the page is told whenever something changes.
#[derive(Clone, Debug, Default, Serialize)]
pub(crate) struct Status {
    /// Of what is shown; 0 before there is anything.
    pub(crate) revision: u64,
    pub(crate) is_working: bool,
    pub(crate) problem: Option<Problem>,
    pub(crate) parameters: Vec<Parameter>,
    pub(crate) values: BTreeMap<String, String>,
}

/// Why the model is to be made again.
#[derive(Debug)]
pub(crate) enum Wish {
    /// Its file has changed.
    Changed,
    /// Other values of parameters.
    Values(BTreeMap<String, String>),
}

/// What the server and the maker of models have in common.
pub(crate) struct Desk {
    pub(crate) token: Token,
    pub(crate) at: SocketAddr,
    pub(crate) status: watch::Sender<Status>,
    shown: Mutex<Option<(Arc<Shown>, Bytes)>>,
    wishes: Mutex<Sender<Wish>>,
    /// Of the work that is being done.
    cancel: Mutex<CancelToken>,
}

impl Desk {
    pub(crate) fn new(token: Token, at: SocketAddr, wishes: Sender<Wish>) -> Self {
        Self {
            token,
            at,
            status: watch::Sender::default(),
            shown: Mutex::default(),
            wishes: Mutex::new(wishes),
            cancel: Mutex::default(),
        }
    }

    /// Puts another picture in place of the one that is shown.
    pub(crate) fn publish(&self, shown: Shown) {
        let bytes = Bytes::from(shown.pack());
        let revision = shown.revision;
        *locked(&self.shown) = Some((Arc::new(shown), bytes));
        self.status.send_modify(|status| status.revision = revision);
    }

    /// Ends what is being done, since something else is wished.
    pub(crate) fn wish(&self, wish: Wish) {
        locked(&self.cancel).cancel();
        // (Nobody listens any more only where the process ends.)
        let _ = locked(&self.wishes).send(wish);
    }

    /// A token for work that begins now.
    pub(crate) fn begin(&self) -> CancelToken {
        let token = CancelToken::new();
        *locked(&self.cancel) = token.clone();
        token
    }

    fn shown(&self) -> Option<(Arc<Shown>, Bytes)> {
        locked(&self.shown).clone()
    }
}

/// (Nothing that holds these locks panics.)
fn locked<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Answers until the process ends.
pub(crate) async fn serve(listener: TcpListener, desk: Arc<Desk>) -> std::io::Result<()> {
    let pages = Router::new()
        .route(
            "/",
            get(|| async { page(include_str!("../web/page.html"), "text/html") }),
        )
        .route(
            "/first.js",
            get(|| async { page(include_str!("../web/first.js"), "text/javascript") }),
        )
        .route(
            "/view.js",
            get(|| async { page(include_str!("../web/dist/view.js"), "text/javascript") }),
        )
        .route(
            "/view.css",
            get(|| async { page(include_str!("../web/view.css"), "text/css") }),
        )
        .route("/events", get(events))
        .route("/scene", get(scene))
        .route("/picture/{width}/{height}/{theme}", get(first_picture))
        .route("/account", get(account))
        .route("/describe", post(describe))
        .route("/between", post(between))
        .route("/parameters", post(parameters))
        .route("/download/{format}", get(download));
    let app = Router::new()
        .nest("/{token}", pages.clone())
        // (A nested page is without the last slash otherwise.)
        .route(
            "/{token}/",
            get(|| async { page(include_str!("../web/page.html"), "text/html") }),
        )
        .layer(DefaultBodyLimit::max(LARGEST_QUESTION))
        .layer(middleware::from_fn_with_state(Arc::clone(&desk), guarded))
        .with_state(desk);
    axum::serve(listener, app).await
}

/// Refuses what others ask, and tells browsers to be careful with what is answered.
async fn guarded(State(desk): State<Arc<Desk>>, request: Request, next: Next) -> Response {
    let asked = guard::check(
        request.uri().path(),
        request.headers(),
        &desk.token,
        desk.at,
    );
    let mut response = match asked {
        Ok(()) => next.run(request).await,
        Err(status) => status.into_response(),
    };
    let policy = "default-src 'self'; img-src 'self' blob: data:; style-src 'self' 'unsafe-inline'; \
                  object-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
    for (name, value) in [
        (header::CONTENT_SECURITY_POLICY, policy),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::CACHE_CONTROL, "no-store"),
        (
            header::HeaderName::from_static("cross-origin-resource-policy"),
            "same-origin",
        ),
        (
            header::HeaderName::from_static("cross-origin-opener-policy"),
            "same-origin",
        ),
    ] {
        response
            .headers_mut()
            .insert(name, HeaderValue::from_static(value));
    }
    response
}

fn page(text: &'static str, kind: &'static str) -> Response {
    let kind = format!("{kind}; charset=utf-8");
    ([(header::CONTENT_TYPE, kind)], text).into_response()
}

async fn events(State(desk): State<Arc<Desk>>) -> impl IntoResponse {
    let stream = WatchStream::new(desk.status.subscribe()).map(|status| {
        let text = serde_json::to_string(&status).unwrap_or_default();
        Ok::<_, Infallible>(Event::default().data(text))
    });
    Sse::new(stream).keep_alive(KeepAlive::default())
}

/// The first picture; 204 if there is nothing to draw soon.
async fn first_picture(
    State(desk): State<Arc<Desk>>,
    Path((_, width, height, theme)): Path<(String, u32, u32, Theme)>,
) -> Response {
    if u64::from(width) * u64::from(height) > LARGEST_PICTURE {
        return StatusCode::PAYLOAD_TOO_LARGE.into_response();
    }
    let mut status = desk.status.subscribe();
    let is_there = status.wait_for(|status| status.revision > 0 || status.problem.is_some());
    // (If there is still nothing, `beside` says so.)
    let _ = tokio::time::timeout(PATIENCE, is_there).await;
    let drawn = beside(&desk, move |shown| {
        let picture = picture::first(shown, width, height, theme);
        picture.and_then(|picture| picture.to_png())
    });
    match drawn.await {
        Ok(Ok(png)) => ([(header::CONTENT_TYPE, "image/png")], png).into_response(),
        Ok(Err(error)) => (StatusCode::UNPROCESSABLE_ENTITY, error.to_string()).into_response(),
        Err(response) => response,
    }
}

async fn scene(State(desk): State<Arc<Desk>>) -> Response {
    match desk.shown() {
        Some((_, bytes)) => {
            let kind = (header::CONTENT_TYPE, "application/octet-stream");
            ([kind], Body::from(bytes)).into_response()
        }
        None => StatusCode::NO_CONTENT.into_response(),
    }
}

/// Work on what is shown that may take long, beside the answers to others.
async fn beside<T: Send + 'static>(
    desk: &Desk,
    work: impl FnOnce(&Shown) -> T + Send + 'static,
) -> Result<T, Response> {
    let Some((shown, _)) = desk.shown() else {
        return Err(StatusCode::NO_CONTENT.into_response());
    };
    let done = tokio::task::spawn_blocking(move || work(&shown)).await;
    done.map_err(|_| StatusCode::INTERNAL_SERVER_ERROR.into_response())
}

async fn account(State(desk): State<Arc<Desk>>) -> Response {
    match beside(&desk, Shown::account).await {
        Ok(account) => Json(account).into_response(),
        Err(response) => response,
    }
}

#[derive(Deserialize)]
struct AboutOne {
    revision: u64,
    pick: Pick,
}

#[derive(Deserialize)]
struct AboutTwo {
    revision: u64,
    picks: [Pick; 2],
}

/// Rows about something that is shown; 409 if another picture is shown by now, 404 if there is
/// no such thing.
async fn rows(
    desk: &Desk,
    revision: u64,
    ask: impl FnOnce(&Shown) -> Option<Vec<Row>> + Send + 'static,
) -> Response {
    let answer = beside(desk, move |shown| {
        (shown.revision == revision).then(|| ask(shown))
    });
    match answer.await {
        Ok(Some(Some(rows))) => Json(rows).into_response(),
        Ok(Some(None)) => StatusCode::NOT_FOUND.into_response(),
        Ok(None) => StatusCode::CONFLICT.into_response(),
        Err(response) => response,
    }
}

async fn describe(State(desk): State<Arc<Desk>>, Json(asked): Json<AboutOne>) -> Response {
    rows(&desk, asked.revision, move |shown| {
        shown.describe(asked.pick)
    })
    .await
}

async fn between(State(desk): State<Arc<Desk>>, Json(asked): Json<AboutTwo>) -> Response {
    rows(&desk, asked.revision, move |shown| {
        shown.between(asked.picks)
    })
    .await
}

async fn parameters(
    State(desk): State<Arc<Desk>>,
    Json(values): Json<BTreeMap<String, String>>,
) -> StatusCode {
    desk.wish(Wish::Values(values));
    StatusCode::NO_CONTENT
}

async fn download(
    State(desk): State<Arc<Desk>>,
    Path((_, format)): Path<(String, String)>,
) -> Response {
    let wanted = format.clone();
    let made = beside(&desk, move |shown| {
        (shown.name.clone(), shown.export(&wanted))
    });
    match made.await {
        Ok((name, Ok(bytes))) => {
            let plain = |c: char| c.is_ascii_alphanumeric() || "-_. ".contains(c);
            let name: String = name
                .chars()
                .map(|c| if plain(c) { c } else { '_' })
                .collect();
            let file = format!("attachment; filename=\"{name}.{format}\"");
            let kind = "application/octet-stream".to_owned();
            (
                [
                    (header::CONTENT_TYPE, kind),
                    (header::CONTENT_DISPOSITION, file),
                ],
                bytes,
            )
                .into_response()
        }
        Ok((_, Err(problem))) => (StatusCode::UNPROCESSABLE_ENTITY, problem).into_response(),
        Err(response) => response,
    }
}
