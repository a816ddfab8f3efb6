//! Whether ways and points of a scene can be used at all, wherever the examination lies.

use geometry::{Ct, Point};
use guidance::plan::SHORTEST_MM;
use scene::Scene;
use scene::steps::{APART_MM, KnownPoint, Registering};

/// Ways that have no direction, and points to register by that lie on a line.
pub(super) fn faults(scene: &Scene) -> Vec<String> {
    let targets = scene.targets.iter();
    let ways = targets.filter_map(|target| {
        let way_mm = target.entry?.distance(target.centre);
        let least_mm = target.stop_mm + SHORTEST_MM;
        (way_mm <= least_mm).then(|| {
            format!(
                "target {:?}: from entry_ct_mm to ct_mm it is {way_mm:.1} mm, and the tip is to stop {:.1} mm before that (stop_mm): expected a \
                 way of more than {least_mm:.1} mm",
                target.name, target.stop_mm
            )
        })
    });
    let points = match scene.steps.as_ref().and_then(|steps| steps.register.as_ref()) {
        Some(Registering::Points(points)) => &points[..],
        Some(Registering::Beads(_)) | None => &[],
    };
    ways.chain(on_a_line(points)).collect()
}

/// Points of which none lies farther from the line through the two farthest than a pointer tells two places apart: they do not hold the patient's
/// turn about that line.
fn on_a_line(points: &[KnownPoint]) -> Option<String> {
    let places: Vec<Point<Ct>> = points.iter().map(|point| point.place).collect();
    let pairs = places.iter().flat_map(|a| places.iter().map(move |b| (*a, *b)));
    let (a, b) = pairs.max_by(|(a, b), (c, d)| a.distance(*b).total_cmp(&c.distance(*d)))?;
    let along = (b - a).direction()? * 1.0;
    let off = |p: Point<Ct>| p.distance(a + along * (p - a).dot(along));
    let off_mm = places.into_iter().map(off).fold(0.0, f64::max);
    (off_mm < APART_MM).then(|| {
        format!(
            "steps.points lie on a line: the farthest is {off_mm:.1} mm off it, expected one of at least {APART_MM} mm; else the patient's turn about \
             the line is not found"
        )
    })
}
