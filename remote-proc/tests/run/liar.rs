//! A sender of the test's own on a real link, with the sender's certificate: it says what it likes.

use std::path::Path;
use std::sync::mpsc::channel;

use bus::clock::monotonic_ns;
use bus::message::{Wire, voxel_bytes};
use remote_proc::protocol::{
    CLOCK, Channel, ClockAnswer, Envelope, FACTS, Facts, PIECE, VERSION, hex, payloads, piece,
};
use remote_proc::session::{Opened, listen};
use zenoh::Wait;
use zenoh::query::Query;

use crate::rig::Voxels;

/// Of its run.
pub(crate) const RUN: u64 = 0xff;
/// Of itself.
const SENDER: u64 = 5;

/// Answers for facts, clock and pieces; publishes what it is told to.
pub(crate) struct Liar {
    session: Opened,
}

impl Liar {
    /// Shows an examination: what it says of it, and the values that it gives out.
    pub(crate) fn of(endpoint: &str, keys: Option<&Path>, voxels: Voxels) -> Self {
        let liar = Self::saying(
            endpoint,
            keys,
            &Facts {
                version: VERSION,
                payloads: payloads(),
                run: "room".to_owned(),
                run_id: format!("{RUN:016x}"),
                scene: String::new(),
                volume: Some(hex(voxels.header.wire_bytes())),
            },
        );
        let epoch_ns = monotonic_ns();
        liar.answer(CLOCK, move |_| {
            let now_ns = monotonic_ns() - epoch_ns;
            let told = ClockAnswer {
                heard_ns: now_ns,
                answered_ns: now_ns,
                run: RUN,
                sender: SENDER,
            };
            told.bytes()
        });
        liar.answer(PIECE, move |query| {
            let asked = query.payload().unwrap().to_bytes();
            let index = u32::from_le_bytes(asked[32..].try_into().unwrap());
            voxel_bytes(&voxels.stored[piece(index, voxels.stored.len()).unwrap()]).to_vec()
        });
        liar
    }

    /// Says these facts, and nothing else.
    pub(crate) fn saying(endpoint: &str, keys: Option<&Path>, facts: &Facts) -> Self {
        let session = listen(endpoint, keys).unwrap();
        let liar = Self { session };
        let answer = serde_json::to_vec(facts).unwrap();
        liar.answer(FACTS, move |_| answer.clone());
        liar
    }

    fn answer(&self, key: &'static str, with: impl Fn(&Query) -> Vec<u8> + Send + Sync + 'static) {
        // Whoever waits for room in the link's queues must not do so in its thread, which makes that room.
        let (asked, questions) = channel::<Query>();
        std::thread::spawn(move || {
            for query in questions {
                let _ = query.reply(query.key_expr().clone(), with(&query)).wait();
            }
        });
        let put = move |query| {
            let _ = asked.send(query);
        };
        let queryable = self.session.declare_queryable(key).callback(put);
        queryable.background().wait().unwrap();
    }

    /// Publishes `body` as message `count` of its channel.
    pub(crate) fn put(&self, channel: Channel, count: u64, body: &[u8]) {
        let envelope = Envelope {
            run: RUN,
            sender: SENDER,
            count,
        };
        self.session.put(channel.key(), envelope.around(body)).wait().unwrap();
    }
}
