//! The scene that is shipped.

use super::*;
use crate::chain::Stamps;

#[test]
fn the_shipped_room_is_played_and_tracked() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../config/operating-room.toml");
    let scene = Scene::load(&path).unwrap_or_else(|error| panic!("{error}"));
    let room = approached(&scene, scene.seed);
    let chain = room.chain(middle()).unwrap();
    let (mut stamps, mut arrivals) = (Stamps::default(), Vec::new());
    room.arrivals(-1, 60_000_000_000, &mut arrivals);
    let (mut tracked, mut stale, mut within, mut reasons) = (0, 0, 0, std::collections::BTreeMap::new());
    for arrival in &arrivals {
        let frame = room.frame(arrival.seq);
        assert!(!frame.dropped && frame.t_arrival_ns == arrival.t_arrival_ns);
        if stamps
            .admit(frame.t_device_ns, frame.t_capture_ns, arrival.t_arrival_ns)
            .is_err()
        {
            stale += 1;
            continue;
        }
        match chain.solve(&frame.tool, &frame.reference) {
            Ok(found) => {
                tracked += 1;
                within += usize::from(error_mm(&frame, &found, tip()) <= found.tip_95_mm);
            }
            Err(reason) => *reasons.entry(format!("{reason:.40}")).or_insert(0) += 1,
        }
    }
    println!(
        "{} frames in 60 s, {stale} out of order, {tracked} tracked, {within} within tip_95; lost: {reasons:?}",
        arrivals.len()
    );
    assert!(tracked > arrivals.len() / 2, "{tracked}");
    assert!(tracked + stale < arrivals.len(), "the hand never hid the marker");
}
