//! Turner's page, traced by this program at full speed: `turner serve`.
//!
//! ```text
//!  browser ── HTTP: files, below their token ──► listener ─ routes ─ guard, token
//!     ▲                                                   │
//!     └── WebSocket: calls, answers, changed tiles ──► socket ─ outbox ─ tiles     one for each viewer
//!                                                         │
//!                                                        hub ─ call_queue ─► engine    one thread: a turner_web::Session
//! ```
//!
//! One session is shared by all. The owner's address may change it; with [`Options::share`] another address looks on.
//! A viewer who is slower than the renderer gets the newest picture, not all. `socket` has the messages.
//!
//! Nothing of the disk is served: the page is in the program, and a scene is read once, with its files.
#![forbid(unsafe_code)]

mod call_queue;
mod engine;
mod guard;
mod hub;
mod listener;
mod outbox;
mod routes;
mod socket;
mod tiles;
mod token;

use std::io;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener, UdpSocket};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use tokio::sync::Notify;
use turner::schema::Limits;
use turner_web::{LoadError, Session};

use hub::Hub;
use listener::{Addresses, LimitedListener};
use routes::{AppState, router};
use token::Token;

/// The port, if none is asked for and it is free.
pub const PORT: u16 = 7373;

/// What is served, and to whom.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// The scene or model to open.
    pub scene: Option<PathBuf>,
    /// The address to listen at; by default this machine alone, with `share` all of its addresses.
    pub bind: Option<IpAddr>,
    /// The port; 0 is any. By default [`PORT`], or any if it is taken.
    pub port: Option<u16>,
    /// Whether there is an address for viewers, who change nothing.
    pub share: bool,
    /// Names of this machine that browsers may use, besides `localhost` and its IP addresses.
    pub names: Vec<String>,
    /// Threads that render; 0 uses all.
    pub threads: usize,
    /// Limits of memory and size.
    pub limits: Limits,
}

/// Why nothing is served.
#[derive(Debug)]
pub enum ServeError {
    /// The scene cannot be read.
    Scene(LoadError),
    /// The address cannot be listened at.
    Address(SocketAddr, io::Error),
    /// The system refuses something else: threads, random numbers.
    System(io::Error),
}

/// A server that listens.
pub struct Server {
    listener: TcpListener,
    state: AppState,
    session: Session,
    options: Options,
    stop: Arc<Notify>,
}

/// Ends a server from another thread.
#[derive(Clone)]
pub struct Stopper(Arc<Notify>);

impl Stopper {
    /// Ends it.
    pub fn stop(&self) {
        self.0.notify_one();
    }
}

impl Server {
    /// Opens the scene and begins to listen. Requests are answered by [`Server::run`].
    ///
    /// Errors: see [`ServeError`].
    pub fn new(options: Options) -> Result<Server, ServeError> {
        let mut session = Session::new(options.threads, options.limits.clone());
        if let Some(scene) = &options.scene {
            session.open_path(scene).map_err(ServeError::Scene)?;
        }
        let everywhere = if options.share { Ipv4Addr::UNSPECIFIED } else { Ipv4Addr::LOCALHOST };
        let ip = options.bind.unwrap_or(everywhere.into());
        let listener = listen(ip, options.port)?;
        let token = || Token::new().map_err(ServeError::System);
        let state = AppState {
            hub: Arc::default(),
            owner: token()?,
            viewer: options.share.then(token).transpose()?,
            is_open: options.bind.is_some_and(|ip| !ip.is_loopback()),
            names: options.names.clone(),
            threads: threads(options.threads),
        };
        Ok(Server { listener, state, session, options, stop: Arc::default() })
    }

    /// Where it listens.
    ///
    /// Errors: the system does not tell.
    pub fn at(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }

    /// The address for the owner, with its token.
    pub fn owner(&self) -> String {
        let ip = self.ip();
        // Without `bind` the owner is at this machine.
        let ip = if ip.is_unspecified() && !self.state.is_open { Ipv4Addr::LOCALHOST.into() } else { ip };
        self.address(ip, &self.state.owner)
    }

    /// The address for viewers, with its token.
    pub fn viewers(&self) -> Option<String> {
        self.state.viewer.as_ref().map(|token| self.address(self.ip(), token))
    }

    fn ip(&self) -> IpAddr {
        self.at().map_or(Ipv4Addr::LOCALHOST.into(), |at| at.ip())
    }

    fn address(&self, ip: IpAddr, token: &Token) -> String {
        let ip = if ip.is_unspecified() { own_address().unwrap_or(Ipv4Addr::LOCALHOST.into()) } else { ip };
        let port = self.at().map_or(0, |at| at.port());
        let named = self.options.names.first().filter(|_| !ip.is_loopback());
        match named {
            Some(name) => format!("http://{name}:{port}/{}/", token.text()),
            None => format!("http://{}/{}/", SocketAddr::new(ip, port), token.text()),
        }
    }

    /// What ends it.
    pub fn stopper(&self) -> Stopper {
        Stopper(Arc::clone(&self.stop))
    }

    /// Serves until it is ended.
    ///
    /// Errors: the system refuses a thread or the socket.
    pub fn run(self) -> io::Result<()> {
        const STACK: usize = 8 << 20;
        let Server { listener, state, session, options, stop } = self;
        let hub: Arc<Hub> = Arc::clone(&state.hub);
        let for_engine = Arc::clone(&hub);
        let work = move || engine::run(session, &for_engine, options.threads, &options.limits);
        std::thread::Builder::new().name("session".into()).stack_size(STACK).spawn(work)?;
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
        let ended = runtime.block_on(async {
            listener.set_nonblocking(true)?;
            let listener = LimitedListener::new(tokio::net::TcpListener::from_std(listener)?);
            let service = router(Arc::new(state)).into_make_service_with_connect_info::<Addresses>();
            tokio::select! {
                ended = async { axum::serve(listener, service).await } => ended,
                () = stop.notified() => Ok(()),
            }
        });
        hub.close();
        runtime.shutdown_timeout(Duration::from_millis(50));
        ended
    }
}

fn listen(ip: IpAddr, port: Option<u16>) -> Result<TcpListener, ServeError> {
    let at = |port| SocketAddr::new(ip, port);
    let bind = |port| TcpListener::bind(at(port)).map_err(|error| ServeError::Address(at(port), error));
    match port {
        Some(port) => bind(port),
        None => bind(PORT).or_else(|_| bind(0)),
    }
}

fn threads(wanted: usize) -> usize {
    let all = || std::thread::available_parallelism().map_or(1, usize::from);
    if wanted == 0 { all() } else { wanted }
}

/// The address of this machine in its network: that from which others would be reached. Nothing is sent.
fn own_address() -> Option<IpAddr> {
    let socket = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0)).ok()?;
    // An address for documentation (RFC 5737).
    socket.connect((Ipv4Addr::new(192, 0, 2, 1), 9)).ok()?;
    socket.local_addr().ok().map(|at| at.ip()).filter(|ip| !ip.is_unspecified())
}
