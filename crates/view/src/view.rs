//! Serving a model and making it again.

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::net::{Ipv4Addr, SocketAddr};
use std::sync::{Arc, mpsc};
use std::thread;

use crate::guard::Token;
use crate::server::{self, Desk, Status, Wish};
use crate::shown::{Settings, stages};
use crate::source::{Problem, Source};
use crate::watch;

/// How a page is served.
#[derive(Clone, Debug, Default)]
pub struct ViewOptions {
    /// The port on this machine's own address; 0 for one that is free.
    pub port: u16,
    /// Whether the page is opened in the browser.
    pub open: bool,
    /// How the model is meshed.
    pub settings: Settings,
}

/// Why there is no page.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ViewError {
    /// The port cannot be had.
    #[error(
        "port {port} of this machine cannot be had: {source} (leave it out to have a free one)"
    )]
    Port {
        /// Which.
        port: u16,
        /// What the system says.
        source: io::Error,
    },
    /// The file's folder cannot be watched.
    #[error("the folder of {} cannot be watched: {source}", .file.display())]
    Watch {
        /// The file.
        file: std::path::PathBuf,
        /// What the system says.
        source: notify::Error,
    },
    /// There is no randomness for the token.
    #[error("no random numbers: {0}")]
    Random(getrandom::Error),
    /// The server ended.
    #[error("the page is no longer served: {0}")]
    Server(io::Error),
}

/// Serves a page that shows the model, until the process ends; `announce` is told its
/// address. Whoever has the address can see the model, change its parameters and download it;
/// only programs on this machine can reach it.
///
/// The model is made on the thread that calls.
///
/// # Errors
/// See [`ViewError`]. What is wrong with the model is shown on the page.
pub fn view(
    source: &mut dyn Source,
    options: &ViewOptions,
    announce: impl FnOnce(&str),
) -> Result<(), ViewError> {
    let address = SocketAddr::from((Ipv4Addr::LOCALHOST, options.port));
    let port = |source| ViewError::Port {
        port: options.port,
        source,
    };
    let listener = std::net::TcpListener::bind(address).map_err(port)?;
    listener.set_nonblocking(true).map_err(port)?;
    let at = listener.local_addr().map_err(port)?;
    let token = Token::random().map_err(ViewError::Random)?;
    let address = format!("http://{at}/{}/", token.as_str());
    let (sender, wishes) = mpsc::channel();
    let desk = Arc::new(Desk::new(token, at, sender));
    let _watcher = match source.file() {
        Some(file) => Some(watch::watch(file, &desk).map_err(|error| ViewError::Watch {
            file: file.to_owned(),
            source: error,
        })?),
        None => None,
    };
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build();
    let runtime = runtime.map_err(ViewError::Server)?;
    let served = Arc::clone(&desk);
    let server = thread::spawn(move || {
        runtime.block_on(async {
            let listener = tokio::net::TcpListener::from_std(listener)?;
            server::serve(listener, served).await
        })
    });
    announce(&address);
    if options.open
        && let Err(error) = open::that_detached(&address)
    {
        // (Nobody may read it.)
        let _ = writeln!(
            io::stderr(),
            "warning: no browser could be opened ({error}): open the address yourself"
        );
    }
    desk.status
        .send_modify(|status| status.parameters = source.parameters());
    let mut maker = Maker {
        source,
        settings: &options.settings,
        desk: &desk,
        values: BTreeMap::new(),
        revision: 0,
    };
    maker.make();
    while !server.is_finished() {
        let Ok(wish) = wishes.recv() else { break };
        maker.heed(wish);
        // What was wished meanwhile is done at once.
        while let Ok(wish) = wishes.try_recv() {
            maker.heed(wish);
        }
        maker.make();
    }
    match server.join() {
        Ok(Err(error)) => Err(ViewError::Server(error)),
        _ => Ok(()),
    }
}

struct Maker<'a> {
    source: &'a mut dyn Source,
    settings: &'a Settings,
    desk: &'a Desk,
    values: BTreeMap<String, String>,
    revision: u64,
}

impl Maker<'_> {
    fn heed(&mut self, wish: Wish) {
        if let Wish::Values(values) = wish {
            self.values.extend(values);
        }
    }

    /// Makes the model and shows it; what is wrong is shown, too, beside what was there before.
    fn make(&mut self) {
        let cancel = self.desk.begin();
        let values = self.values.clone();
        let tell = |change: &dyn Fn(&mut Status)| self.desk.status.send_modify(change);
        tell(&|status| {
            status.is_working = true;
            status.values.clone_from(&values);
        });
        let made = self.source.load(&values).map_err(Some).and_then(|loaded| {
            let (desk, revision) = (self.desk, &mut self.revision);
            stages(
                &self.source.name(),
                loaded,
                self.settings,
                &cancel,
                |mut shown| {
                    *revision += 1;
                    shown.revision = *revision;
                    desk.publish(shown);
                },
            )
        });
        let problem: Option<Problem> = made.err().flatten();
        let is_cancelled = cancel.is_cancelled();
        tell(&|status| {
            // (More is wished already, which tells by itself.)
            status.is_working = is_cancelled;
            status.problem.clone_from(&problem);
        });
    }
}
