//! Emitters that are broken.

use super::*;

const EVERYWHERE: &str = "[tracker.room.marker]\ncone_deg = 180\n[tracker.room.handle]\nradius_mm = 0\n";

#[test]
fn dead_emitters_are_dark_from_their_time_on() {
    let tables = format!("{EVERYWHERE}[tracker.room.faults]\ndead = [3, 7]\nfrom_s = 1\n");
    let room = approached(&scene(QUIET, &tables), 1);
    let names = |seq| room.frame(seq).tool.iter().map(|s| s.emitter).collect::<Vec<_>>();
    assert_eq!(names(59), (0..24).collect::<Vec<_>>());
    assert_eq!(names(60), (0..24).filter(|i| ![3, 7].contains(i)).collect::<Vec<_>>());
}

#[test]
fn exchanged_names_are_found_out() {
    let tables = format!("{EVERYWHERE}[tracker.room.faults]\nswapped = [2, 20]\nfrom_s = 1\n");
    let room = approached(&scene(QUIET, &tables), 1);
    let chain = room.chain(middle()).unwrap();
    let [before, after] = [59, 60].map(|seq| room.frame(seq));
    let place = |frame: &Frame, name| frame.tool.iter().find(|s| s.emitter == name).unwrap().place;
    let truly = |frame: &Frame, index: usize| frame.tracker_from_marker * chain.marker.emitters()[index].place;
    assert!(place(&before, 2).distance(truly(&before, 2)) < 1e-12);
    assert!(place(&after, 2).distance(truly(&after, 20)) < 1e-12);
    assert!(place(&after, 20).distance(truly(&after, 2)) < 1e-12);
    let found = chain.solve(&after.tool, &[]).unwrap();
    assert_eq!((found.used, found.outliers), (22, 2));
    assert!(error_mm(&after, &found, tip()) < 2e-11);
}
