//! A TCP connection that nobody may block: waiting, reading and writing with an end.

use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::os::fd::AsFd;
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::net::sockopt;

/// A peer that acknowledges nothing for this long is gone.
const UNACKNOWLEDGED_MS: u32 = 2000;
/// What is sent is a few hundred bytes: who does not take them within this time takes nothing.
const SEND: Duration = Duration::from_millis(500);

/// In the words of the system, without its number.
pub(crate) fn words(error: &std::io::Error) -> String {
    let text = error.to_string();
    let end = text.find(" (os error").unwrap_or(text.len());
    text[..end].to_lowercase()
}

/// A peer whose cable is pulled is found out, and what is sent goes out at once.
pub(crate) fn prepared(stream: TcpStream) -> std::io::Result<TcpStream> {
    stream.set_nodelay(true)?;
    stream.set_nonblocking(true)?;
    sockopt::set_tcp_user_timeout(&stream, UNACKNOWLEDGED_MS)?;
    sockopt::set_socket_keepalive(&stream, true)?;
    sockopt::set_tcp_keepidle(&stream, Duration::from_secs(1))?;
    sockopt::set_tcp_keepintvl(&stream, Duration::from_secs(1))?;
    sockopt::set_tcp_keepcnt(&stream, 2)?;
    Ok(stream)
}

/// Whether something can be done with it, at most after `rest`.
pub(crate) fn ready(stream: &impl AsFd, for_what: PollFlags, rest: Duration) -> std::io::Result<bool> {
    let rest = Timespec::try_from(rest).unwrap_or(Timespec { tv_sec: 1, tv_nsec: 0 });
    match poll(&mut [PollFd::new(stream, for_what)], Some(&rest)) {
        Ok(count) => Ok(count > 0),
        Err(rustix::io::Errno::INTR) => Ok(false),
        Err(error) => Err(error.into()),
    }
}

/// Waits for bytes, at most for `rest`; how many came, 0 where none did. The error says why the connection is over.
pub(crate) fn read(stream: &mut TcpStream, room: &mut [u8], rest: Duration) -> Result<usize, String> {
    if !ready(stream, PollFlags::IN, rest).map_err(|error| words(&error))? {
        return Ok(0);
    }
    match stream.read(room) {
        Ok(0) => Err("the peer closed the connection".to_owned()),
        Ok(count) => Ok(count),
        Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => Ok(0),
        Err(error) => Err(words(&error)),
    }
}

/// Writes all of it, or says why the connection is of no use.
pub(crate) fn write(stream: &mut TcpStream, mut bytes: &[u8]) -> Result<(), String> {
    while !bytes.is_empty() {
        match stream.write(bytes) {
            Ok(0) => return Err("the peer takes nothing".to_owned()),
            Ok(count) => bytes = &bytes[count..],
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) if error.kind() == ErrorKind::WouldBlock => match ready(stream, PollFlags::OUT, SEND) {
                Ok(true) => {}
                Ok(false) => return Err("the peer takes nothing".to_owned()),
                Err(error) => return Err(words(&error)),
            },
            Err(error) => return Err(words(&error)),
        }
    }
    Ok(())
}
