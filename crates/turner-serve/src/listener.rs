//! Connections as they come: their number is limited, and those that send nothing end.

use std::io;
use std::net::{IpAddr, SocketAddr};
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};
use std::time::Duration;

use axum::extract::connect_info::Connected;
use axum::serve::{IncomingStream, Listener};
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::time::{Instant, Sleep, sleep};

/// Most connections at a time: a browser has six of each page. Files of scenes need descriptors, too.
const MAX_CONNECTIONS: usize = 512;

/// Longest time in which a connection sends nothing. Sockets are asked for a sign of life more often.
const SILENCE: Duration = Duration::from_secs(75);

/// See the module.
pub(crate) struct LimitedListener {
    listener: TcpListener,
    room: Arc<Semaphore>,
}

impl LimitedListener {
    pub(crate) fn new(listener: TcpListener) -> LimitedListener {
        LimitedListener { listener, room: Arc::new(Semaphore::new(MAX_CONNECTIONS)) }
    }
}

/// A connection.
pub(crate) struct Connection {
    stream: TcpStream,
    /// When it ends unless something arrives.
    end: Pin<Box<Sleep>>,
    _room: Option<OwnedSemaphorePermit>,
}

impl Listener for LimitedListener {
    type Io = Connection;
    type Addr = SocketAddr;

    async fn accept(&mut self) -> (Connection, SocketAddr) {
        // The semaphore is never closed.
        let room = Arc::clone(&self.room).acquire_owned().await.ok();
        let (stream, peer) = Listener::accept(&mut self.listener).await;
        // Small messages are sent at once; if that is refused, they come later.
        let _ = stream.set_nodelay(true);
        (Connection { stream, end: Box::pin(sleep(SILENCE)), _room: room }, peer)
    }

    fn local_addr(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }
}

impl AsyncRead for Connection {
    fn poll_read(self: Pin<&mut Self>, cx: &mut Context<'_>, to: &mut ReadBuf<'_>) -> Poll<io::Result<()>> {
        let connection = self.get_mut();
        match Pin::new(&mut connection.stream).poll_read(cx, to) {
            Poll::Ready(read) => {
                connection.end.as_mut().reset(Instant::now() + SILENCE);
                Poll::Ready(read)
            }
            Poll::Pending => connection.end.as_mut().poll(cx).map(|()| Err(io::ErrorKind::TimedOut.into())),
        }
    }
}

impl AsyncWrite for Connection {
    fn poll_write(self: Pin<&mut Self>, cx: &mut Context<'_>, from: &[u8]) -> Poll<io::Result<usize>> {
        Pin::new(&mut self.get_mut().stream).poll_write(cx, from)
    }

    fn poll_flush(self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.get_mut().stream).poll_flush(cx)
    }

    fn poll_shutdown(self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.get_mut().stream).poll_shutdown(cx)
    }
}

/// The addresses of a connection: that of this machine and that of the browser.
#[derive(Clone, Copy)]
pub(crate) struct Addresses {
    pub(crate) local: IpAddr,
    pub(crate) peer: IpAddr,
}

impl Connected<IncomingStream<'_, LimitedListener>> for Addresses {
    fn connect_info(stream: IncomingStream<'_, LimitedListener>) -> Addresses {
        let unknown = IpAddr::from([0, 0, 0, 0]);
        let local = stream.io().stream.local_addr().map_or(unknown, |address| address.ip());
        Addresses { local, peer: stream.remote_addr().ip() }
    }
}
