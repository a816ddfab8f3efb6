//! A connection to the X server that does not wait for ever: a server that hangs must not hang its watcher.

use std::io::{self, IoSlice};
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fd::AsFd;
use x11rb::errors::{ConnectError, DisplayParsingError};
use x11rb::reexports::x11rb_protocol::{parse_display, xauth};
use x11rb::rust_connection::{DefaultStream, PollMode, RustConnection, Stream};
use x11rb::utils::RawFdContainer;

/// A server that answers nothing for so long is taken to hang. A busy one takes a tenth of it.
const PATIENCE: Duration = Duration::from_millis(1500);

/// A stream whose waits end with [`io::ErrorKind::TimedOut`].
#[derive(Debug)]
pub(super) struct Patient(DefaultStream);

impl Stream for Patient {
    fn poll(&self, mode: PollMode) -> io::Result<()> {
        let mut flags = PollFlags::empty();
        flags.set(PollFlags::IN, mode.readable());
        flags.set(PollFlags::OUT, mode.writable());
        let fd = self.0.as_fd();
        let patience = Timespec::try_from(PATIENCE).map_err(io::Error::other)?;
        match poll(&mut [PollFd::from_borrowed_fd(fd, flags)], Some(&patience)) {
            Ok(0) => Err(io::Error::new(io::ErrorKind::TimedOut, "the X server does not answer")),
            // Returning without anything to read is allowed, and an interrupted wait begins anew.
            Ok(_) | Err(rustix::io::Errno::INTR) => Ok(()),
            Err(error) => Err(error.into()),
        }
    }

    fn read(&self, bytes: &mut [u8], fds: &mut Vec<RawFdContainer>) -> io::Result<usize> {
        self.0.read(bytes, fds)
    }

    fn write(&self, bytes: &[u8], fds: &mut Vec<RawFdContainer>) -> io::Result<usize> {
        self.0.write(bytes, fds)
    }

    fn write_vectored(&self, bytes: &[IoSlice<'_>], fds: &mut Vec<RawFdContainer>) -> io::Result<usize> {
        self.0.write_vectored(bytes, fds)
    }
}

/// Connects to `display`; returns the connection and the number of its screen.
///
/// # Errors
/// Where the name is none, nobody listens there, or the server refuses.
pub(super) fn connect(display: &str) -> Result<(RustConnection<Patient>, usize), ConnectError> {
    let parsed = parse_display::parse_display(Some(display))?;
    let screen = usize::from(parsed.screen);
    let mut last = ConnectError::from(DisplayParsingError::Unknown);
    for address in parsed.connect_instruction() {
        match DefaultStream::connect(&address) {
            Ok((stream, (family, host))) => {
                // Without a cookie it is tried all the same: a server may need none.
                let cookie = xauth::get_auth(family, &host, parsed.display).ok().flatten();
                let (name, data) = cookie.unwrap_or_default();
                let patient = Patient(stream);
                let connection = RustConnection::connect_to_stream_with_auth_info(patient, screen, name, data)?;
                return Ok((connection, screen));
            }
            Err(error) => last = error.into(),
        }
    }
    Err(last)
}
