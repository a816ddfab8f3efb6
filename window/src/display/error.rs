//! Why there is no window.

use x11rb::errors::{ConnectError, ConnectionError, ReplyError, ReplyOrIdError};

/// Why there is no window.
#[derive(Debug, thiserror::Error)]
pub enum DisplayError {
    /// Nobody says where a display is.
    #[error("no display: DISPLAY is not set. Start it where a screen is, or run with --headless")]
    None,
    /// The display refuses.
    #[error("no display: {display} does not answer: {source}")]
    Connect {
        /// Its name.
        display: String,
        /// What went wrong.
        source: ConnectError,
    },
    /// The pixels of the display are of another kind.
    #[error("the display has {depth} bits a pixel; 24 bits of red, green and blue are needed")]
    Depth {
        /// Bits of a pixel.
        depth: u8,
    },
    /// The display went away.
    #[error("the display was lost: {0}")]
    Lost(String),
    /// Memory for the pixels.
    #[error("memory for the pixels of the window: {0}")]
    Memory(#[from] std::io::Error),
}

macro_rules! lost {
    ($($error:ty),*) => {
        $(impl From<$error> for DisplayError {
            fn from(error: $error) -> Self {
                Self::Lost(error.to_string())
            }
        })*
    };
}
lost!(ConnectionError, ReplyError, ReplyOrIdError);
