//! An examination of many pieces: gone on with after a cut, and refused where one of them was altered.

use std::path::Path;
use std::time::Duration;

use remote_proc::protocol::{PIECE_VALUES, pieces};
use rustix::process::Signal;

use crate::liar::{Liar, RUN};
use crate::rig::{Program, Room, Second, Voxels, alone, free_endpoint, until, world};
use crate::wire::Wire;

/// 96 pieces, 12 MiB.
const DIMS: [u32; 3] = [512, 128, 96];
/// So that it takes 3 s: time enough to cut in between on a busy machine.
const PER_S: u64 = 4_000_000;
/// Bytes of a piece.
const PIECE: u64 = 2 * PIECE_VALUES as u64;
/// Pieces that come twice at most: four are under way when the link is cut, and four may be asked for at its return before the
/// sender's clock says that it is another one, and are then asked for anew.
const TWICE: u64 = 8;
/// What else comes in 60 s, [`crate::rig::PATIENCE`]: ten answers a second about the clock, of some 150 bytes with all that is round
/// them, and the words by which sessions are opened.
const OTHERS: u64 = 60 * 10 * 150 + 20_000;

/// How many pieces have come, by the receiver's words.
fn here(second: &Second) -> Option<u64> {
    let note = second.note()?;
    let (_, behind) = note.split_once("examination: ")?;
    behind.split(' ').next()?.parse().ok()
}

/// A receiver over a slow wire that has a third of the pieces.
struct Begun {
    room: Room,
    second: Second,
    receiver: Program,
    sender: Program,
    wire: Wire,
    endpoint: String,
    all: u64,
    /// Bytes that had come.
    came: u64,
}

impl Begun {
    fn at(world: &Path) -> Self {
        let endpoint = free_endpoint();
        let wire = Wire::before(&endpoint, PER_S);
        let room = Room::open(world, Duration::from_secs(1), DIMS, |_| {});
        let second = Second::open(world, "second", &wire.endpoint());
        let sender = room.send(world, &endpoint);
        let receiver = second.receive(world, &wire.endpoint(), &room.id());
        let all = u64::from(pieces(room.header.layout().unwrap().stored()));
        until("a third of the pieces", || {
            room.serve_late_joiners();
            here(&second).filter(|here| *here >= all / 3)
        });
        Self {
            room,
            second,
            receiver,
            sender,
            wire,
            endpoint,
            all,
            came: 0,
        }
    }

    /// The receiver has told that it is cut off, and what had come by then is counted.
    fn is_cut_off(&mut self) {
        until("the note of the cut", || {
            self.second.note().filter(|note| note.contains("NO ANSWER"))
        });
        self.came = self.wire.came();
        let least = self.all / 3 * PIECE;
        assert!(
            (least..self.all * PIECE * 3 / 4).contains(&self.came),
            "{} bytes before the cut: too late to show anything",
            self.came
        );
        assert!(self.second.volumes.poll().unwrap().is_none());
    }

    /// All of it comes, and of the pieces no more than had not come before.
    fn goes_on(&self) {
        let volume = until("the examination", || {
            self.room.serve_late_joiners();
            self.second.volumes.poll().unwrap()
        });
        assert_eq!(volume.hash(), self.room.hash);
        assert!(
            volume.view().voxels == Voxels::made(DIMS).stored,
            "voxels lie elsewhere"
        );
        let after = self.wire.came();
        let said = self.receiver.said();
        let most = (self.all + TWICE) * PIECE + OTHERS;
        assert!(
            self.came + after <= most,
            "{} and {after} bytes came, of {} pieces of {PIECE}; {most} are expected at most\n{said}",
            self.came,
            self.all
        );
        assert_eq!(said.matches("is here after").count(), 1, "{said}");
        println!(
            "{} pieces: {:.1} pieces' bytes before the cut, {:.1} after it",
            self.all,
            self.came as f64 / PIECE as f64,
            after as f64 / PIECE as f64
        );
    }
}

#[test]
fn a_sender_that_follows_is_asked_for_what_is_missing_alone() {
    let _alone = alone();
    let world = world();
    let mut begun = Begun::at(world.path());
    begun.sender.signal(Signal::KILL);
    begun.sender.ended();
    begun.is_cut_off();
    let _follows = begun.room.send(world.path(), &begun.endpoint);
    begun.goes_on();
}

#[test]
fn a_link_that_comes_back_brings_what_is_missing_alone() {
    let _alone = alone();
    let world = world();
    let mut begun = Begun::at(world.path());
    begun.wire.cut();
    begun.is_cut_off();
    begun.wire.mend();
    begun.goes_on();
}

/// One bit of one piece of a true examination: its neighbours are none the wiser, its hash is.
#[test]
fn a_piece_that_is_altered_on_the_way_is_refused_by_the_hash() {
    let _alone = alone();
    let world = world();
    let endpoint = free_endpoint();
    let mut voxels = Voxels::made([128, 64, 48]);
    let hash = voxels.header.volume_hash();
    // In the third of six pieces.
    voxels.stored[2 * PIECE_VALUES + 999] ^= 1 << 4;
    let _liar = Liar::of(&endpoint, None, voxels);
    let second = Second::open(world.path(), "second", &endpoint);
    let mut receiver = second.receive(world.path(), &endpoint, &format!("{RUN:x}"));
    assert_eq!(receiver.ended().code(), Some(1), "{}", receiver.said());
    let said = receiver.said();
    assert!(
        said.contains(&format!("the examination of {endpoint}: what came has the hash "))
            && said.contains(&format!("and the sender's has {hash}: it was altered on the way")),
        "{said}"
    );
    assert!(second.volumes.poll().unwrap().is_none(), "{said}");
    assert!(second.poses.next().unwrap().is_none(), "{said}");
}
