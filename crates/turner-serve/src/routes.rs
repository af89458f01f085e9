//! The pages: only those of the table of `turner_web`, below the token.

use std::sync::Arc;

use axum::Router;
use axum::extract::connect_info::ConnectInfo;
use axum::extract::ws::WebSocketUpgrade;
use axum::extract::{Path, Request, State};
use axum::http::header::{self, HeaderName};
use axum::http::{HeaderMap, HeaderValue, StatusCode};
use axum::middleware::{Next, from_fn, from_fn_with_state};
use axum::response::{IntoResponse, Redirect, Response};
use axum::routing::get;
use turner_web::PAGE;

use crate::guard::{check_host, check_origin};
use crate::hub::Hub;
use crate::listener::Addresses;
use crate::socket::{self, MAX_MESSAGE};
use crate::token::Token;

/// What someone may do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Role {
    /// Open and change scenes.
    Owner,
    /// Look on.
    Viewer,
}

impl Role {
    pub(crate) fn word(self) -> &'static str {
        match self {
            Role::Owner => "owner",
            Role::Viewer => "viewer",
        }
    }
}

/// What requests are answered from.
pub(crate) struct AppState {
    pub(crate) hub: Arc<Hub>,
    pub(crate) owner: Token,
    pub(crate) viewer: Option<Token>,
    /// Whether the owner may come from other machines.
    pub(crate) is_open: bool,
    /// Further names of the machine.
    pub(crate) names: Vec<String>,
    pub(crate) threads: usize,
}

impl AppState {
    /// Who has this token. Both are compared, so that the time tells nothing.
    fn role(&self, word: &str, addresses: Addresses) -> Option<Role> {
        let is_owner = self.owner.is(word) & (self.is_open || addresses.peer.to_canonical().is_loopback());
        let is_viewer = self.viewer.as_ref().is_some_and(|token| token.is(word));
        if is_owner { Some(Role::Owner) } else { is_viewer.then_some(Role::Viewer) }
    }
}

/// The policy of the page; that in the page is the same, without the last.
const POLICY: &str = concat!(
    "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self' blob:; ",
    "style-src 'self'; style-src-attr 'unsafe-inline'; img-src 'self' blob: data:; connect-src 'self'; ",
    "manifest-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
);

/// Headers of every answer.
const HEADERS: [(HeaderName, &str); 7] = [
    (HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
    (HeaderName::from_static("cross-origin-embedder-policy"), "require-corp"),
    (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
    (header::CONTENT_SECURITY_POLICY, POLICY),
    (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (header::REFERRER_POLICY, "no-referrer"),
    (header::CACHE_CONTROL, "no-store"),
];

/// The answers to all requests.
pub(crate) fn router(server: Arc<AppState>) -> Router {
    Router::new()
        .route("/{token}", get(with_slash))
        .route("/{token}/", get(index))
        .route("/{token}/socket", get(socket))
        .route("/{token}/{file}", get(file))
        .fallback(|| async { refused() })
        .layer(from_fn_with_state(Arc::clone(&server), check))
        .layer(from_fn(add_headers))
        .with_state(server)
}

async fn add_headers(request: Request, next: Next) -> Response {
    let mut response = next.run(request).await;
    for (name, value) in HEADERS {
        response.headers_mut().insert(name, HeaderValue::from_static(value));
    }
    response
}

/// Refuses requests that were sent to another host.
async fn check(
    State(server): State<Arc<AppState>>,
    ConnectInfo(addresses): ConnectInfo<Addresses>,
    request: Request,
    next: Next,
) -> Response {
    let host = host(request.headers());
    match check_host(host, addresses.local, &server.names) {
        Ok(()) => next.run(request).await,
        Err(text) => (StatusCode::FORBIDDEN, text).into_response(),
    }
}

fn host(headers: &HeaderMap) -> &str {
    headers.get(header::HOST).and_then(|host| host.to_str().ok()).unwrap_or_default()
}

fn refused() -> Response {
    let text = "the token in the address is missing or wrong\nuse the address that turner serve printed\n";
    (StatusCode::FORBIDDEN, text).into_response()
}

async fn with_slash(
    State(server): State<Arc<AppState>>,
    ConnectInfo(addresses): ConnectInfo<Addresses>,
    Path(token): Path<String>,
) -> Response {
    match server.role(&token, addresses) {
        Some(_) => Redirect::permanent(&format!("/{token}/")).into_response(),
        None => refused(),
    }
}

async fn index(
    state: State<Arc<AppState>>,
    addresses: ConnectInfo<Addresses>,
    Path(token): Path<String>,
) -> Response {
    file(state, addresses, Path((token, "index.html".to_owned()))).await
}

async fn file(
    State(server): State<Arc<AppState>>,
    ConnectInfo(addresses): ConnectInfo<Addresses>,
    Path((token, name)): Path<(String, String)>,
) -> Response {
    let Some(role) = server.role(&token, addresses) else { return refused() };
    let Some((_, kind, bytes)) = PAGE.iter().find(|(own, _, _)| *own == name) else {
        return (StatusCode::NOT_FOUND, "there is no such file\n").into_response();
    };
    let kind = [(header::CONTENT_TYPE, *kind)];
    match (name.as_str(), std::str::from_utf8(bytes)) {
        ("index.html", Ok(text)) => {
            let meta = format!("<head>\n<meta name=\"turner-serve\" content=\"{}\">", role.word());
            (kind, text.replacen("<head>", &meta, 1)).into_response()
        }
        _ => (kind, *bytes).into_response(),
    }
}

async fn socket(
    State(server): State<Arc<AppState>>,
    ConnectInfo(addresses): ConnectInfo<Addresses>,
    Path(token): Path<String>,
    headers: HeaderMap,
    upgrade: Result<WebSocketUpgrade, axum::extract::ws::rejection::WebSocketUpgradeRejection>,
) -> Response {
    let Some(role) = server.role(&token, addresses) else { return refused() };
    let origin = headers.get(header::ORIGIN).map(|origin| origin.to_str().unwrap_or_default());
    if let Err(text) = check_origin(origin, host(&headers)) {
        return (StatusCode::FORBIDDEN, text).into_response();
    }
    match upgrade {
        Ok(upgrade) => upgrade
            .max_message_size(MAX_MESSAGE)
            .max_frame_size(MAX_MESSAGE)
            .on_upgrade(move |socket| socket::serve(socket, Arc::clone(&server.hub), role, server.threads)),
        Err(rejection) => rejection.into_response(),
    }
}
