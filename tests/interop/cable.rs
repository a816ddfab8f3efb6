//! A cable that is pulled: the peer lives in a network of its own, whose link is set down.

use crate::followed::{Server, check, program, scene};
use crate::support::cable::Cable;
use crate::support::frames::{Watch, is_disconnected, is_seen, status_says};
use crate::support::{World, wait_for};

/// What the system says of it: that nothing was acknowledged, or, where it has looked for the peer's hardware once more before that, that nobody
/// has answered.
const REASONS: [&str; 2] = ["timed out", "no route to host"];

/// Not the silence of the peer, which is waited for for a minute here, but that it acknowledges nothing.
#[test]
fn a_cable_that_is_pulled_is_found_out_and_plugged_in_again_it_is_followed() {
    let Some(program) = program() else { return };
    let Some(cable) = Cable::new() else { return };
    let mut command = cable.command(program);
    command.arg("push");
    let server = Server::of(command);
    let world = World::new();
    let address = format!("{}:{}", cable.address, server.port);
    let text = scene(&address, "peer = \"v1\"\nsilent_s = 60\n");
    let pilot = world.start(&world.file("s.toml", &text), &world.path("out"), "default");
    let watch = Watch::open(&world);
    watch.wait("poses", 1, is_seen);
    for _ in 0..2 {
        cable.set("down");
        watch.wait("the end of the connection", 1, is_disconnected);
        wait_for("the reason", || {
            watch
                .told()
                .iter()
                .any(|words| REASONS.iter().any(|reason| words.contains(reason)))
                .then_some(())
        });
        status_says(&pilot, "waiting for");
        cable.set("up");
        watch.wait("poses again", 3, is_seen).iter().for_each(check);
    }
    let _ = pilot.stop();
}
