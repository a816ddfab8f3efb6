//! Neither program looks for others, nor can it be found: which sockets they have.

use std::collections::HashMap;
use std::time::Duration;

use super::program;
use crate::rig::{Program, Room, Second, alone, free_endpoint, keys, until, world};

/// A socket of the network, as `/proc/PID/net` has it.
#[derive(Debug, PartialEq)]
struct Socket {
    kind: &'static str,
    port: u16,
    is_listening: bool,
}

/// Those of a process, without those of the machine alone (`AF_UNIX`).
fn sockets(of: &Program) -> Vec<Socket> {
    let proc = format!("/proc/{}", of.child.id());
    let mut all = HashMap::new();
    for kind in ["tcp", "tcp6", "udp", "udp6", "udplite", "raw", "raw6", "icmp"] {
        let table = std::fs::read_to_string(format!("{proc}/net/{kind}")).unwrap_or_default();
        for line in table.lines().skip(1) {
            let fields: Vec<&str> = line.split_whitespace().collect();
            let port = u16::from_str_radix(fields[1].rsplit_once(':').unwrap().1, 16).unwrap();
            let socket = Socket {
                kind,
                port,
                is_listening: kind.starts_with("tcp") && fields[3] == "0A",
            };
            all.insert(format!("socket:[{}]", fields[9]), socket);
        }
    }
    let open = std::fs::read_dir(format!("{proc}/fd")).unwrap().flatten();
    let links = open.filter_map(|entry| std::fs::read_link(entry.path()).ok());
    links.filter_map(|to| all.remove(to.to_str()?)).collect()
}

#[test]
fn the_sender_listens_at_its_port_alone_and_a_receiver_at_none_and_both_speak_nothing_but_tcp() {
    let _alone = alone();
    let world = world();
    let keys = keys(world.path(), "localhost");
    let endpoint = free_endpoint().replace("tcp/127.0.0.1", "tls/localhost");
    let port: u16 = endpoint.rsplit_once(':').unwrap().1.parse().unwrap();
    let mut room = Room::open(world.path(), Duration::from_secs(1), [16, 16, 16], |_| {});
    let sender = room.send_by(program("send", Some(&keys)), world.path(), &endpoint);
    let second = Second::open(world.path(), "second", &endpoint);
    let receiver = second.receive_by(program("receive", Some(&keys)), world.path(), &endpoint, &room.id());
    until("the first pose", || {
        room.serve_late_joiners();
        room.pose();
        second.poses.next().unwrap()
    });
    let (of_sender, of_receiver) = (sockets(&sender), sockets(&receiver));
    for sockets in [&of_sender, &of_receiver] {
        assert!(
            sockets.iter().all(|socket| socket.kind.starts_with("tcp")),
            "{sockets:?}"
        );
        // The link between them.
        assert!(sockets.iter().any(|socket| !socket.is_listening), "{sockets:?}");
    }
    assert!(of_sender.iter().all(|socket| socket.port == port), "{of_sender:?}");
    assert!(of_receiver.iter().all(|socket| !socket.is_listening), "{of_receiver:?}");
}
