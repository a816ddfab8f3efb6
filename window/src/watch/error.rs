//! Why the watcher ended, or cannot see.

use bus::BusError;
use bus::process::JoinError;
use x11rb::errors::{ConnectError, ConnectionError, ReplyError, ReplyOrIdError};

/// Why the watcher ended.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// It could not join the run.
    #[error(transparent)]
    Join(#[from] JoinError),
    /// The bus failed.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// Nobody says which X server shows the window.
    #[error("DISPLAY is not set: it names the X server that shows the window, for instance DISPLAY=:0")]
    NoDisplay,
}

/// Why the screen cannot be seen. The run goes on, and it is tried again.
#[derive(Debug, thiserror::Error)]
pub(super) enum ScreenError {
    /// Nobody listens on the display, or refuses.
    #[error("connecting: {0}")]
    Connect(#[from] ConnectError),
    /// The connection broke, or the server does not answer.
    #[error("{0}")]
    Lost(#[from] ConnectionError),
    /// The server refused a request that it cannot refuse.
    #[error("{0}")]
    Reply(#[from] ReplyError),
    /// There are no numbers left for windows.
    #[error("{0}")]
    Id(#[from] ReplyOrIdError),
    /// Its pixels are of a kind that this program does not know.
    #[error("the screen's pixels are not red, green and blue in 16 to 32 bits")]
    Pixels,
}
