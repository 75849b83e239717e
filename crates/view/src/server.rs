//! The page and its questions, by HTTP on this machine's own address.
//!
//! | address, after the token | answer |
//! | --- | --- |
//! | `GET /`, `first.js`, `view.js` | the page, with the model's first picture in it (`picture`) |
//! | `GET events` | what happens, as server-sent events of JSON |
//! | `GET scene` | all that is drawn (`packing`) |
//! | `GET account` | measures and report |
//! | `POST describe` `{revision, pick}` | rows of what was picked, and where they are drawn |
//! | `POST between` `{revision, picks}` | rows of distances and angles, and where they are drawn |
//! | `POST parameters` `{name: value}` | nothing; the model is made again |
//! | `GET download/FORMAT` | a file |

use std::collections::BTreeMap;
use std::convert::Infallible;
use std::net::SocketAddr;
use std::sync::mpsc::Sender;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::thread;
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
use crate::picture::FirstPictures;
use crate::shown::Shown;
use crate::source::{Parameter, Problem};

/// The most bytes of a question: names and values of parameters are short.
const LARGEST_QUESTION: usize = 64 << 10;
/// How long the page waits for the model that its first picture is of; longer ones are shown as
/// far as they are, or by the page's script.
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
    shown: Mutex<Option<Published>>,
    wishes: Mutex<Sender<Wish>>,
    /// Of the work that is being done.
    cancel: Mutex<CancelToken>,
}

/// A model, packed and drawn.
#[derive(Clone)]
struct Published {
    shown: Arc<Shown>,
    bytes: Bytes,
    pictures: Arc<Pictures>,
}

/// For a light page and a dark one, as [`FirstPictures`] draws them.
#[derive(Default)]
struct Pictures {
    scene: OnceLock<Option<FirstPictures>>,
    addresses: [OnceLock<Option<String>>; 2],
}

impl Published {
    /// One of the first pictures, drawn when it is wanted first.
    fn picture(&self, is_dark: bool) -> Option<&str> {
        let Pictures { scene, addresses } = &*self.pictures;
        let scene = scene.get_or_init(|| FirstPictures::of(&self.shown));
        let address = &addresses[usize::from(is_dark)];
        let address = address.get_or_init(|| scene.as_ref()?.address(is_dark));
        address.as_deref()
    }
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

    /// Puts another model in place of the one that is shown. The first fine one is drawn at once,
    /// as the browser will soon ask for the page.
    pub(crate) fn publish(&self, shown: Shown) {
        let bytes = Bytes::from(shown.pack());
        let revision = shown.revision;
        // (After a coarse one, if there was one.)
        let is_first = !shown.is_coarse && revision <= 2;
        let published = Published {
            shown: Arc::new(shown),
            bytes,
            pictures: Arc::default(),
        };
        *locked(&self.shown) = Some(published.clone());
        self.status.send_modify(|status| status.revision = revision);
        if is_first {
            // (Where there is no thread, it is drawn when it is asked for.)
            let drawer = thread::Builder::new().name("first picture".to_owned());
            let _ = drawer.spawn(move || {
                published.picture(false);
                published.picture(true);
            });
        }
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

    fn shown(&self) -> Option<Published> {
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
        .route("/", get(page))
        .route(
            "/first.js",
            get(|| async { script(include_str!("../web/first.js")) }),
        )
        .route(
            "/view.js",
            get(|| async { script(include_str!("../web/dist/view.js")) }),
        )
        .route("/events", get(events))
        .route("/scene", get(scene))
        .route("/account", get(account))
        .route("/describe", post(describe))
        .route("/between", post(between))
        .route("/parameters", post(parameters))
        .route("/download/{format}", get(download));
    let app = Router::new()
        .nest("/{token}", pages.clone())
        // (A nested page is without the last slash otherwise.)
        .route("/{token}/", get(page))
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

fn script(text: &'static str) -> Response {
    let kind = [(header::CONTENT_TYPE, "text/javascript; charset=utf-8")];
    (kind, text).into_response()
}

/// The page in one piece, with its style and its first picture, so that the browser needs to ask
/// for nothing else before there is something to see. What comes before the picture is sent
/// at once, and so is the one for a light page before the one for a dark page is drawn.
async fn page(State(desk): State<Arc<Desk>>) -> Response {
    let text = include_str!("../web/page.html");
    let (before, after) = text.split_once(PICTURES).unwrap_or((text, ""));
    let style = include_str!("../web/view.css");
    let before = before.replace(STYLE, &format!("<style>\n{style}</style>"));
    let pictures = tokio_stream::iter([false, true]).then(move |is_dark| {
        let desk = Arc::clone(&desk);
        async move { first_picture(&desk, is_dark).await.unwrap_or_default() }
    });
    let parts = tokio_stream::once(before)
        .chain(pictures)
        .chain(tokio_stream::once(after.to_owned()))
        .map(Ok::<_, Infallible>);
    let kind = [(header::CONTENT_TYPE, "text/html; charset=utf-8")];
    (kind, Body::from_stream(parts)).into_response()
}

/// In the page: its style, and the place of the first pictures.
const STYLE: &str = r#"<link rel="stylesheet" href="view.css">"#;
const PICTURES: &str = "<!-- The first pictures. -->";

/// A first picture; nothing if there is nothing to draw soon.
async fn first_picture(desk: &Desk, is_dark: bool) -> Option<String> {
    let mut status = desk.status.subscribe();
    let is_done = |status: &Status| status.revision > 0 && !status.is_working;
    let is_there = status.wait_for(|status| is_done(status) || status.problem.is_some());
    // (If there is only a coarse one by then, it does.)
    let _ = tokio::time::timeout(PATIENCE, is_there).await;
    let published = desk.shown()?;
    let address = move || published.picture(is_dark).map(str::to_owned);
    let address = tokio::task::spawn_blocking(address).await.ok()??;
    let theme = if is_dark { "dark" } else { "light" };
    Some(format!(
        r#"<img class="first {theme}" src="{address}" alt="" decoding="sync" elementtiming="first">"#
    ))
}

async fn events(State(desk): State<Arc<Desk>>) -> impl IntoResponse {
    let stream = WatchStream::new(desk.status.subscribe()).map(|status| {
        let text = serde_json::to_string(&status).unwrap_or_default();
        Ok::<_, Infallible>(Event::default().data(text))
    });
    Sse::new(stream).keep_alive(KeepAlive::default())
}

async fn scene(State(desk): State<Arc<Desk>>) -> Response {
    match desk.shown() {
        Some(Published { bytes, .. }) => {
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
    let Some(published) = desk.shown() else {
        return Err(StatusCode::NO_CONTENT.into_response());
    };
    let done = tokio::task::spawn_blocking(move || work(&published.shown)).await;
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
