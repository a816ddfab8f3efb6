//! A network between two ends of this machine on which everything takes a while.

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::mpsc::channel;
use std::time::{Duration, Instant};

/// Everything that goes through comes so much later.
pub(crate) struct Delay {
    port: u16,
}

impl Delay {
    /// Before `endpoint`; `half` is one way.
    pub(crate) fn before(endpoint: &str, half: Duration) -> Self {
        let to = endpoint.split_once('/').unwrap().1.to_owned();
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = listener.local_addr().unwrap().port();
        std::thread::spawn(move || {
            for near in listener.incoming().flatten() {
                let Ok(far) = TcpStream::connect(&to) else { continue };
                for stream in [&near, &far] {
                    stream.set_nodelay(true).unwrap();
                }
                passed(near.try_clone().unwrap(), far.try_clone().unwrap(), half);
                passed(far, near, half);
            }
        });
        Self { port }
    }

    pub(crate) fn endpoint(&self, tls: bool) -> String {
        format!("{}/127.0.0.1:{}", if tls { "tls" } else { "tcp" }, self.port)
    }
}

fn passed(mut from: TcpStream, mut to: TcpStream, half: Duration) {
    let (sender, receiver) = channel::<(Instant, Vec<u8>)>();
    std::thread::spawn(move || {
        let mut bytes = vec![0; 1 << 16];
        while let Ok(count @ 1..) = from.read(&mut bytes) {
            if sender.send((Instant::now() + half, bytes[..count].to_vec())).is_err() {
                return;
            }
        }
    });
    std::thread::spawn(move || {
        for (due, bytes) in receiver {
            std::thread::sleep(due.saturating_duration_since(Instant::now()));
            if to.write_all(&bytes).is_err() {
                return;
            }
        }
    });
}
