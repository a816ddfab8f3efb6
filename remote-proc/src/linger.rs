//! Connections that are let go at once.
//!
//! zenoh asks the kernel to hold up whoever closes a connection until the peer has taken all that was sent, or for 10 s; there is no
//! setting for it. A receiver that stands still would so hold up the link of all others when it is given up. Here the request is taken back
//! on every connection of this process, which then closes at once; what the peer has not taken is the kernel's to get rid of.

use std::io;
use std::os::fd::OwnedFd;

use rustix::net::sockopt::{set_socket_linger, socket_linger};

use crate::sockets;

/// Takes the request back wherever it stands; how often it stood.
///
/// # Errors
/// Where the system lets a process not even look at its own descriptors.
pub(crate) fn let_go_at_once() -> io::Result<usize> {
    Ok(sockets::own()?.iter().filter(|socket| taken_back(socket)).count())
}

fn taken_back(socket: &OwnedFd) -> bool {
    matches!(socket_linger(socket), Ok(Some(_))) && set_socket_linger(socket, None).is_ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::net::{TcpListener, TcpStream};
    use std::time::Duration;

    #[test]
    fn a_connection_that_would_hold_up_is_let_go() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let stream = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
        set_socket_linger(&stream, Some(Duration::from_secs(10))).unwrap();
        assert!(let_go_at_once().unwrap() >= 1);
        assert_eq!(socket_linger(&stream).unwrap(), None);
    }
}
