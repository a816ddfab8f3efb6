//! An association of bytes that a peer said, without a connection: for tests of what they lead to.

use std::io::{Cursor, Read, Write};

use super::super::outcome::Outcome;
use super::super::store::Store;
use super::super::wire::Wire;
use super::{Association, Place, Rules, agree};

/// A peer that has said all it will say, and hears nothing.
struct Spoken<'a>(Cursor<&'a [u8]>);

impl Read for Spoken<'_> {
    fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
        self.0.read(out)
    }
}

impl Write for Spoken<'_> {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

/// Receives what a peer says in these bytes, the request included, as from a connection; `None` where there is no association.
pub fn serve_bytes(bytes: &[u8], rules: &Rules, store: &Store) -> Option<Outcome> {
    let stop = || false;
    let mut wire = Wire::new(Spoken(Cursor::new(bytes)), &stop);
    let agreed = agree(&mut wire, rules, || true).ok()?;
    let tell = |_: &str| {};
    let place = Place {
        rules,
        store,
        tell: &tell,
    };
    Some(Association::new(&mut wire, place, agreed).run(&mut |_| {}))
}
