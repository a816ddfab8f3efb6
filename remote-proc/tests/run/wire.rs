//! A wire between two ends of this machine: it can be cut, or stand still, is as slow as it is told, and counts what goes over it.

use std::io::{Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// Bytes that go on at a time: 4 ms at 4 MB/s.
const CHUNK: usize = 1 << 14;

/// Between who dials and who listens.
pub(crate) struct Wire {
    port: u16,
    inner: Arc<Inner>,
}

#[derive(Default)]
struct Inner {
    is_cut: AtomicBool,
    is_still: AtomicBool,
    /// Bytes that went to who dials.
    came: AtomicU64,
    /// Of these at most in a second; 0: as many as come.
    per_s: AtomicU64,
    ends: Mutex<Vec<TcpStream>>,
}

impl Wire {
    /// Before `endpoint`; at most `per_s` bytes a second go to who dials, 0: as many as come.
    pub(crate) fn before(endpoint: &str, per_s: u64) -> Self {
        let to = endpoint.split_once('/').unwrap().1.to_owned();
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = listener.local_addr().unwrap().port();
        let inner = Arc::new(Inner::default());
        inner.per_s.store(per_s, Ordering::SeqCst);
        let taken = inner.clone();
        std::thread::spawn(move || {
            for near in listener.incoming().flatten() {
                taken.wait_while_still();
                // Who comes to a wire that is cut finds nobody.
                let far = (!taken.is_cut.load(Ordering::SeqCst)).then(|| TcpStream::connect(&to));
                if let Some(Ok(far)) = far {
                    taken.join(near, far);
                }
            }
        });
        Self { port, inner }
    }

    /// Where to dial.
    pub(crate) fn endpoint(&self) -> String {
        format!("tcp/127.0.0.1:{}", self.port)
    }

    /// Bytes that went to who dials since the last call.
    pub(crate) fn came(&self) -> u64 {
        self.inner.came.swap(0, Ordering::SeqCst)
    }

    /// Ends all connections, and takes no more until it is mended.
    pub(crate) fn cut(&self) {
        self.inner.is_cut.store(true, Ordering::SeqCst);
        for end in self.inner.ends.lock().unwrap().drain(..) {
            let _ = end.shutdown(Shutdown::Both);
        }
    }

    /// Ends being cut.
    pub(crate) fn mend(&self) {
        self.inner.is_cut.store(false, Ordering::SeqCst);
    }

    /// Nothing goes either way, as with a cable that is out, or again as before.
    pub(crate) fn stand_still(&self, is_still: bool) {
        self.inner.is_still.store(is_still, Ordering::SeqCst);
    }
}

impl Inner {
    fn wait_while_still(&self) {
        while self.is_still.load(Ordering::SeqCst) {
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    fn join(self: &Arc<Self>, near: TcpStream, far: TcpStream) {
        for stream in [&near, &far] {
            stream.set_nodelay(true).unwrap();
            self.ends.lock().unwrap().push(stream.try_clone().unwrap());
        }
        let both = [(near.try_clone().unwrap(), far.try_clone().unwrap()), (far, near)];
        for (is_back, (from, to)) in [false, true].into_iter().zip(both) {
            let inner = self.clone();
            std::thread::spawn(move || inner.pass(from, to, is_back));
        }
    }

    fn pass(&self, mut from: TcpStream, mut to: TcpStream, is_back: bool) {
        let mut bytes = vec![0; CHUNK];
        while let Ok(count @ 1..) = from.read(&mut bytes) {
            self.wait_while_still();
            let per_s = self.per_s.load(Ordering::SeqCst);
            if is_back && per_s > 0 {
                std::thread::sleep(Duration::from_secs_f64(count as f64 / per_s as f64));
            }
            if to.write_all(&bytes[..count]).is_err() {
                break;
            }
            if is_back {
                self.came.fetch_add(count as u64, Ordering::SeqCst);
            }
        }
        // The other end learns that this one has gone.
        for stream in [from, to] {
            let _ = stream.shutdown(Shutdown::Both);
        }
    }
}
