//! A receiver in a network of its own, with keys, at the other end of a cable that can be pulled or made bad.

use std::process::Command;
use std::time::Duration;

use tempfile::TempDir;

use crate::cable::Cable;
use crate::rig::{Program, Room, Second, keys, remote_proc, world};

/// A room here, and who looks on from there.
pub(crate) struct Far {
    pub(crate) receiver: Program,
    _sender: Program,
    pub(crate) room: Room,
    pub(crate) second: Second,
    pub(crate) cable: Cable,
    _world: TempDir,
}

impl Far {
    /// With an examination of `dims`; `port` tells tests apart. `None`, with a printed reason, where there are no networks to be had.
    pub(crate) fn open(dims: [u32; 3], port: u32) -> Option<Self> {
        Self::open_by(dims, port, |_| true)
    }

    /// The same over a cable that `bad` has made so; `None` also where it could not.
    pub(crate) fn open_by(dims: [u32; 3], port: u32, bad: impl FnOnce(&Cable) -> bool) -> Option<Self> {
        let cable = Cable::new()?;
        if !bad(&cable) {
            return None;
        }
        let world = world();
        let (head, last) = cable.address.rsplit_once('.').unwrap();
        let here = format!("{head}.{}", last.parse::<u8>().unwrap() - 1);
        let endpoint = format!("tls/{here}:{}", port + std::process::id() % 1000);
        let keys = keys(world.path(), &here);
        let room = Room::open(world.path(), Duration::from_secs(1), dims, |_| {});
        let second = Second::open(world.path(), "second", &endpoint);
        let with_keys = |mut command: Command, verb: &str| {
            command.args([verb, "--keys", &keys]);
            command
        };
        let sender = room.send_by(with_keys(remote_proc(), "send"), world.path(), &endpoint);
        let there = cable.command(env!("CARGO_BIN_EXE_remote-proc").as_ref());
        let receiver = second.receive_by(with_keys(there, "receive"), world.path(), &endpoint, &room.id());
        Some(Self {
            receiver,
            _sender: sender,
            room,
            second,
            cable,
            _world: world,
        })
    }
}
