//! A client's side for tests.

use ndi::session::{Device, DeviceRules};
use ndi::{Command, Rom};

/// A definition of four markers, told apart by its part.
pub(super) fn rom(part: &str) -> Rom {
    let places = [
        [0.0, 0.0, 0.0],
        [0.0, 28.5, 41.0],
        [0.0, 0.0, 88.0],
        [0.0, -44.25, 40.5],
    ];
    Rom::simulated("test", part, &places).unwrap()
}

/// Sends a command that must not be refused.
pub(super) fn send(device: &mut Device, command: &str) -> String {
    // With a space in the place of the colon, no CRC follows.
    let line = format!("{}\r", command.replace(':', " "));
    let reply = String::from_utf8(device.bytes(line.as_bytes())).unwrap();
    assert!(!reply.starts_with("ERROR"), "{command}: {reply}");
    reply
}

/// A device with these tools loaded and tracked.
pub(super) fn client(roms: &[Rom]) -> Device {
    let mut device = Device::new(DeviceRules::default());
    send(&mut device, "INIT:");
    for rom in roms {
        let reply = send(&mut device, "PHRQ:*********1****");
        let handle = ndi::parse_phrq(reply.get(..2).unwrap()).unwrap();
        for (address, piece) in rom.pieces() {
            let reply = device.bytes(&Command::Pvwr(handle, address, Box::new(piece)).to_bytes(true));
            assert!(reply.starts_with(b"OKAY"));
        }
        send(&mut device, &format!("PINIT:{handle}"));
        send(&mut device, &format!("PENA:{handle}D"));
    }
    send(&mut device, "TSTART:");
    device
}
