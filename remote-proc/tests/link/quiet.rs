//! What the configurations of both sides say of looking for others and being found, read back from zenoh.

use remote_proc::link::config;
use remote_proc::link::endpoint::{Endpoint, Transport};
use remote_proc::link::keys::{Keys, Side};
use serde_json::{Value, json};
use zenoh::Config;

use crate::support::room::Room;

fn read(config: &Config, key: &str) -> Value {
    serde_json::from_str(&config.get_json(key).unwrap()).unwrap()
}

#[test]
fn nobody_is_looked_for_and_nobody_else_is_dialled_or_listened_for() {
    for (transport, protocol) in [(Transport::Tls, "tls"), (Transport::Tcp, "tcp")] {
        let room = Room::open(transport);
        let load = |side| Keys::load(room.keys.path(), side).unwrap();
        let sender = config::sender(&Endpoint::listen(&room.endpoint).unwrap(), Some(&load(Side::Sender))).unwrap();
        let to = Endpoint::connect(&room.endpoint).unwrap();
        let receiver = config::receiver(&to, Some(&load(Side::Receiver))).unwrap();
        for config in [&sender, &receiver] {
            for key in [
                "scouting/multicast/enabled",
                "scouting/gossip/enabled",
                "adminspace/enabled",
                "plugins_loading/enabled",
                "transport/shared_memory/enabled",
            ] {
                assert_eq!(read(config, key), json!(false), "{key}");
            }
            assert_eq!(read(config, "transport/link/protocols"), json!([protocol]));
            assert_eq!(read(config, "access_control/enabled"), json!(true));
            assert_eq!(read(config, "access_control/default_permission"), json!("deny"));
        }
        assert_eq!(read(&sender, "mode"), json!("peer"));
        assert_eq!(read(&sender, "connect/endpoints"), json!([]));
        let listens = read(&sender, "listen/endpoints");
        let [one] = listens.as_array().unwrap().as_slice() else {
            panic!("{listens}")
        };
        assert!(one.as_str().unwrap().starts_with(&to.to_string()), "{one}");
        assert_eq!(read(&receiver, "mode"), json!("client"));
        assert_eq!(read(&receiver, "listen/endpoints"), json!([]));
        assert_eq!(read(&receiver, "connect/endpoints"), json!([to.to_string()]));
    }
}
