//! What the link is for.

use remote_proc::link::endpoint::{Endpoint, Transport};
use remote_proc::link::keys::{Keys, Side};
use remote_proc::link::probe::probe;
use remote_proc::protocol::{ASKED, Channel};
use zenoh::Wait;

use crate::support::room::Room;

#[test]
fn puts_arrive_on_every_channel_and_queries_on_every_asked_key_are_answered_by_both_transports() {
    for transport in [Transport::Tcp, Transport::Tls] {
        let room = Room::open(transport);
        let keys = Keys::load(room.keys.path(), Side::Receiver).unwrap();
        probe(&Endpoint::connect(&room.endpoint).unwrap(), Some(&keys)).unwrap();
        let screens = [room.receiver(), room.receiver()];
        room.put_all("true");
        for screen in &screens {
            let wanted: Vec<_> = Channel::ALL.iter().map(|of| format!("{} true", of.key())).collect();
            assert_eq!(screen.heard_until(wanted.last().unwrap()), wanted, "{transport:?}");
            for key in ASKED {
                assert_eq!(screen.ask(key), ["the sender's"], "{key}");
            }
        }
    }
}

/// Subscriptions, questions and puts are allowed key by key: what is no key of the link goes nowhere, whoever follows it.
#[test]
fn what_is_no_key_of_the_link_is_not_sent_and_not_answered() {
    for (room, is_open) in [
        (Room::open(Transport::Tls), false),
        (Room::without_control(Transport::Tls), true),
    ] {
        let screen = room.receiver();
        let elsewhere = room.session.declare_queryable("trocar/1/no/such/key");
        let reply = elsewhere.callback(|query| {
            let key = query.key_expr().clone();
            let _: Result<(), _> = query.reply(key, "elsewhere").wait();
        });
        reply.background().wait().unwrap();
        room.session.put("trocar/1/no/such/key", "elsewhere").wait().unwrap();
        room.session.put("trocar/1/event", "last").wait().unwrap();
        let heard = screen.heard_until("trocar/1/event last");
        assert_eq!(heard.len(), if is_open { 2 } else { 1 }, "{heard:?}");
        // Where it is allowed it comes once the receiver was told who can answer.
        let mut answers = (0..if is_open { 200 } else { 5 }).map(|_| {
            std::thread::sleep(std::time::Duration::from_millis(10));
            screen.ask("trocar/1/no/such/key")
        });
        assert_eq!(answers.any(|answers| !answers.is_empty()), is_open);
    }
}
