//! What the link is for.

use remote_proc::link::endpoint::{Endpoint, Transport};
use remote_proc::link::keys::{Keys, Side};
use remote_proc::link::probe::probe;

use crate::support::room::{KEYS, Room};

#[test]
fn puts_arrive_on_every_key_and_queries_are_answered_by_both_transports() {
    for transport in [Transport::Tcp, Transport::Tls] {
        let room = Room::open(transport);
        let keys = Keys::load(room.keys.path(), Side::Receiver).unwrap();
        probe(&Endpoint::connect(&room.endpoint).unwrap(), Some(&keys)).unwrap();
        let screens = [room.receiver(), room.receiver()];
        room.put_all("true");
        for screen in &screens {
            let wanted: Vec<_> = KEYS.iter().map(|key| format!("{key} true")).collect();
            assert_eq!(screen.heard_until(wanted.last().unwrap()), wanted, "{transport:?}");
            assert_eq!(screen.ask("trocar/1/volume"), ["the sender's"]);
        }
    }
}
